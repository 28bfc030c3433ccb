"""Lines where a response needs them."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import rbfound as rb
from rbfound.unbalance import adaptive_lines


def two_modes(f):
    return 1 / (100.0**2 - f**2 + 1j * f) + 1 / (300.0**2 - f**2 + 3j * f)


def test_a_spline_through_the_lines_holds_the_tolerance_everywhere():
    for tolerance in (1e-2, 1e-3, 1e-4):
        lines, values = adaptive_lines(two_modes, np.linspace(0.0, 500.0, 21), tolerance)
        assert (np.diff(lines) > 0).all()
        np.testing.assert_array_equal(values, two_modes(lines))
        fine = np.linspace(0.0, 500.0, 20001)
        # another cubic than the one that was tested: it holds the same order
        off = np.abs(CubicSpline(lines, values)(fine) - two_modes(fine)) / np.abs(two_modes(fine))
        assert off.max() < 5 * tolerance


def test_lines_crowd_at_the_resonances():
    lines, _ = adaptive_lines(two_modes, np.linspace(0.0, 500.0, 21))
    near = np.abs(lines - 100.0) < 5
    # 2 % of the range
    assert near.sum() > 0.2 * len(lines)
    # as fine everywhere would be far more
    assert len(lines) < 0.2 * 500.0 / np.diff(lines).min()


def test_every_line_of_an_unbalance_response_is_solved():
    machine = rb.thesis.model("f")

    def response(speeds):
        return rb.unbalance_response(machine, speeds, {0.95: 5e-4})[:, [machine.coordinate(0.95, d) for d in "xy"]]

    speeds, found = adaptive_lines(response, rb.from_hertz(np.linspace(5.0, 200.0, 30)), 1e-2)
    np.testing.assert_allclose(found, response(speeds), rtol=1e-9)
    middle = (speeds[1:-2] + speeds[2:-1]) / 2
    assert np.abs(CubicSpline(speeds, found)(middle) / response(middle) - 1).max() < 0.05


def test_a_jump_ends_too():
    lines, _ = adaptive_lines(lambda f: (f > 0.3) + 1.0, np.linspace(0, 1, 5))
    assert len(lines) < 1000


@pytest.mark.parametrize("lines", [[0.0, 1, 2], [0.0, 1, 1, 2], [0.0, 1, 2, np.nan]])
def test_lines_that_are_too_few_or_do_not_ascend_are_an_error(lines):
    with pytest.raises(ValueError, match="at least four"):
        adaptive_lines(two_modes, lines)


def test_a_tolerance_of_nothing_is_an_error():
    with pytest.raises(ValueError, match="tolerance = 0"):
        adaptive_lines(two_modes, np.arange(5.0), 0.0)
