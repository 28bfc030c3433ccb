"""Plain-text tables."""

import re

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import rbfound as rb
from rbfound.tables import number


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (118.681894, "118.7"),
        (1171.87, "1172"),
        (0.0256512, "0.02565"),
        (1e-3, "0.001000"),
        (-4.56, "-4.560"),
        (1e8, "1.000e+08"),
        (5.1e-5, "5.100e-05"),
        (0.0, "0"),
        (-0.0, "0"),
        (9999.7, "10000"),  # rounding adds a digit before the point
        (999999.7, "1.000e+06"),  # and here leaves the range of fixed point
        (0.00099999, "0.001000"),
    ],
)
def test_a_number_has_four_significant_digits(value, text):
    assert number(value) == text


@settings(max_examples=200)
@given(st.floats(min_value=1e-12, max_value=1e12), st.integers(2, 8), st.booleans())
def test_a_printed_number_is_within_half_a_unit_of_its_last_digit(value, digits, negative):
    # n significant digits: the relative error is at most 0.5 * 10^(1 - n); a little above it for binary rounding
    value = -value if negative else value
    assert abs(float(number(value, digits)) - value) <= 0.500001 * 10.0 ** (1 - digits) * abs(value)


def test_what_is_not_a_measured_number_is_left_alone():
    assert number(None) == "-"
    assert number(float("nan")) == "-"
    assert number("foundation") == "foundation"
    assert number(12345) == "12345"
    assert number(np.int64(12345)) == "12345"
    assert number(True) == "True"


def test_a_table_aligns_numbers_right_and_words_left():
    text = rb.table({"f [Hz]": [118.68, 1171.9], "what": ["foundation", "shaft"], "n": [1, 2]})
    assert text.splitlines() == [
        "f [Hz]  what        n",
        " 118.7  foundation  1",
        "  1172  shaft       2",
    ]


def test_a_shorter_column_ends_in_blanks_and_a_missing_number_is_a_dash():
    text = rb.table({"a": [1.0], "b": [None, 2.0]})
    assert text.splitlines() == ["    a      b", "1.000      -", "       2.000"]


def test_no_line_of_a_table_ends_in_a_blank():
    text = rb.table({"a": [1.0, 2.0, 3.0], "b": ["long word", "x"]})
    assert all(line == line.rstrip() for line in text.splitlines())


def test_a_table_without_columns_or_rows_is_its_heading():
    assert rb.table({}) == ""
    assert rb.table({"a": [], "b": []}) == "a  b"


def test_more_digits_are_printed_when_asked_for():
    assert rb.table({"f": [np.pi]}, digits=7).splitlines()[1] == "3.141593"


@settings(max_examples=200)
@given(st.floats(min_value=1e-11, max_value=1e3))
def test_a_bound_is_a_power_of_ten_three_to_thirty_times_the_residual(value):
    text = rb.bound(value)
    assert re.fullmatch(r"< 1e[+-]\d\d", text)
    # one part in 1e15 for the rounding of 3 * value
    assert 3 * value <= float(text.removeprefix("< ")) * (1 + 1e-15) <= 30.0001 * value


@pytest.mark.parametrize(
    ("value", "text"), [(3e-9, "< 1e-08"), (5e-9, "< 1e-07"), (0.3, "< 1e+00"), (0.4, "< 1e+01"), (50.0, "< 1e+03")]
)
def test_a_bound_keeps_a_factor_of_three_from_the_residual(value, text):
    assert rb.bound(value) == text


@pytest.mark.parametrize("floor", [1e-11, 1e-9, 1e-7, 1e-4])
def test_residuals_that_are_all_rounding_print_alike(floor):
    # what rounding leaves must not show up in a committed output: thirty times below the floor, and ten times more
    for value in (0.0, 1e-16, floor / 1000, floor / 30, floor / 3.01):
        assert rb.bound(value, rounding=floor) == f"< {floor:.0e}"
    assert rb.bound(floor / 2.99, rounding=floor) == f"< {10 * floor:.0e}"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1e-12])
def test_a_residual_that_is_no_residual_is_an_error(value):
    with pytest.raises(ValueError, match=rf"finite and not negative.*{value}"):
        rb.bound(value)


@pytest.mark.parametrize("floor", [9e-5, 2e-4, 0.0, -1e-9, float("nan"), float("inf")])
def test_a_floor_that_is_no_power_of_ten_is_an_error(floor):
    with pytest.raises(ValueError, match=rf"power of ten.*not {floor}"):
        rb.bound(1e-6, rounding=floor)
