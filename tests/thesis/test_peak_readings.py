"""One peak read in several ways: what each promises for one mode, and how their errors are counted."""

import numpy as np
import pytest

import rbfound as rb
from rbfound.theory import sdof
from rbfound.thesis import reading_errors, readings
from rbfound.thesis.peak_readings import METHODS, Reading, by_circle, by_half_power, by_parts

M, F_N, ZETA = 2.0, 100.0, 0.02
K = M * rb.from_hertz(F_N) ** 2
C = 2 * ZETA * np.sqrt(K * M)
LINES = np.arange(50.0, 150.0, 0.02)
H = sdof.receptance(LINES, M, C, K)


def test_each_method_reads_one_mode_within_what_it_promises():
    # on lines 0.02 Hz apart, a half-power width is 4 Hz: a line or two; and zeta^2 = 0.04 % for equation 33
    promise = dict.fromkeys(METHODS, (5e-4, 6e-3, 6e-3))
    promise["half-power, between"] = (5e-4, 1e-3, 1e-3)
    promise["circle"] = promise["circle with slope"] = (1e-10, 1e-10, 1e-10)
    found = readings(LINES, H, 100)
    assert list(found) == list(METHODS)
    for name, reading in found.items():
        got = np.array([reading.frequency / F_N, reading.damping / ZETA, reading.constant * M])
        assert (np.abs(got - 1) < promise[name]).all(), name


def test_the_real_part_is_largest_and_smallest_where_the_docstring_says():
    # d Re H / d w = 0 of one mode, found by a dense search: w^2 = omega^2 (1 -+ 2 zeta)
    dense = np.linspace(95, 105, 200001)
    real = sdof.receptance(dense, M, C, K).real
    for found, side in ((dense[real.argmax()], -1), (dense[real.argmin()], 1)):
        assert found == pytest.approx(F_N * np.sqrt(1 + 2 * side * ZETA), rel=1e-6)


def test_the_sign_of_a_mode_between_two_seats_is_read_from_the_parts_and_the_circle():
    for method in (by_parts, by_circle):
        assert method(LINES, -H, 100).constant == pytest.approx(-1 / M, rel=1e-2)


def test_on_lines_that_lie_too_far_apart_for_the_parts_they_are_not_read():
    coarse = np.arange(5.0, 200.0, 5.0)
    assert np.isnan(by_parts(coarse, sdof.receptance(coarse, M, C, K), 100).damping)
    assert by_circle(coarse, sdof.receptance(coarse, M, C, K), 100).damping == pytest.approx(ZETA, rel=1e-9)


def test_a_method_that_finds_nothing_is_nan_beside_the_others_and_says_why_when_called_alone():
    nothing = readings(LINES, np.ones(len(LINES)) + 0j, 100)
    assert all(np.isnan(reading.damping) for reading in nothing.values())
    with pytest.raises(ValueError, match="has no peak"):
        by_half_power(LINES, np.ones(len(LINES)) + 0j, 100)


def test_errors_are_root_mean_squares_in_per_cent_over_the_samples_that_were_read():
    nan = float("nan")
    samples = [
        {"one": Reading(101.0, 0.03, 0.5), "other": Reading(nan, nan, nan)},
        {"one": Reading(99.0, 0.02, 0.5), "other": Reading(100.0, 0.02, 0.55)},
    ]
    columns = reading_errors(samples, 100.0, 0.02, 0.5)
    assert columns["method"] == ["one", "other"]
    assert columns["frequency [%]"] == [1.0, 0.0]
    # one of two is 50 % too high: 50 / sqrt(2)
    assert columns["damping [%]"] == [35.36, 0.0]
    assert columns["constant [%]"] == [0.0, 10.0]
    assert columns["read"] == [2, 1]
    never = reading_errors([{"one": Reading(nan, nan, nan)}], 100.0, 0.02, 0.5)
    assert np.isnan(never["damping [%]"]).all()
    assert never["read"] == [0]
