"""Orbits: ellipses from two complex amplitudes, against the points of the path itself."""

import numpy as np
import pytest

from rbfound.unbalance import ellipses, path


@pytest.mark.parametrize("seed", range(5))
def test_the_half_axes_are_the_extreme_distances_of_the_path(seed: int) -> None:
    x, y = np.random.default_rng(seed).normal(size=(2, 2)) @ [1, 1j]
    px, py = path(x, y, 200001)
    away, orbit = np.hypot(px, py), ellipses(x, y)
    # an extreme found on n points of a turn is off by (pi / n)^2 / 2 of its size
    assert orbit.major == pytest.approx(away.max(), rel=1e-9)
    assert abs(orbit.minor) == pytest.approx(away.min(), rel=1e-6)
    k = away.argmax()
    assert np.tan(orbit.angle) == pytest.approx(py[k] / px[k], rel=1e-3)


def test_a_forward_circle_runs_from_x_to_y_and_a_backward_one_the_other_way() -> None:
    orbit = ellipses([1, 1, 1], [-1j, 1j, 0])
    np.testing.assert_allclose(orbit.major, [1, 1, 1])
    np.testing.assert_allclose(orbit.minor, [1, -1, 0], atol=1e-15)
    px, py = path(1, -1j, 5)
    np.testing.assert_allclose(py[1], 1)  # a quarter of a turn later it is on the positive Y axis
    np.testing.assert_allclose(px[1], 0, atol=1e-15)


def test_the_area_of_the_path_is_pi_times_the_half_axes_with_the_sign_of_the_sense() -> None:
    x, y = 1.3 - 0.4j, 0.2 + 0.9j
    px, py = path(x, y, 4001)
    area = np.sum(px[:-1] * py[1:] - px[1:] * py[:-1]) / 2
    orbit = ellipses(x, y)
    # a polygon of n corners inside an ellipse lacks 2 pi^2 / 3 n^2 of its area
    assert area == pytest.approx(np.pi * orbit.major * orbit.minor, rel=1e-6)


def test_angles_lie_within_a_quarter_turn_and_a_line_keeps_its_own() -> None:
    orbit = ellipses([1.0, 1.0, 0.0], [1.0, -1.0, 2.0])
    np.testing.assert_allclose(orbit.angle[:2], [np.pi / 4, -np.pi / 4])
    assert abs(orbit.angle[2]) == pytest.approx(np.pi / 2)
