"""Balance quality grades: the definition, a worked value, and what they refuse."""

import numpy as np
import pytest

import rbfound as rb
from rbfound.unbalance import grade_of, in_two_planes, permissible_eccentricity, permissible_unbalance


def test_the_centre_of_mass_travels_at_the_grade() -> None:
    for revolutions in (1000, 3000, 30000):
        speed = rb.from_rpm(revolutions)
        assert permissible_eccentricity(speed, 6.3) * speed == pytest.approx(6.3e-3)


def test_a_rotor_of_60_kg_at_3000_rev_per_minute_and_g_2_5_may_have_477_gram_millimetres() -> None:
    # 2.5 mm/s / (100 pi rad/s) = 7.9577 micrometres; times 60 kg
    assert 1e6 * permissible_eccentricity(rb.from_rpm(3000)) == pytest.approx(7.9577, abs=1e-4)
    assert 1e6 * permissible_unbalance(60.0, rb.from_rpm(3000)) == pytest.approx(477.46, abs=0.01)


def test_the_grade_of_the_permissible_unbalance_is_the_grade() -> None:
    speed = 1234.5
    assert grade_of(permissible_unbalance(7.0, speed, 16.0), 7.0, speed) == pytest.approx(16.0)


def test_two_planes_share_an_unbalance_with_its_moment() -> None:
    shares = in_two_planes(3.0, centre=0.4, left=0.1, right=1.0)
    assert sum(shares.values()) == pytest.approx(3.0)
    assert sum(z * u for z, u in shares.items()) == pytest.approx(3.0 * 0.4)


@pytest.mark.parametrize("speed", [0.0, -1.0, np.inf, np.nan])
def test_a_speed_that_is_none_is_refused(speed: float) -> None:
    with pytest.raises(ValueError, match=r"speed = .*must be positive and finite"):
        permissible_unbalance(1.0, speed)


def test_wrong_grades_masses_and_planes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"grade = -2\.5 mm/s: it must be positive"):
        permissible_unbalance(1.0, 100.0, -2.5)
    with pytest.raises(ValueError, match="mass = 0 kg: it must be positive"):
        permissible_unbalance(0.0, 100.0)
    with pytest.raises(ValueError, match="mass = 0 kg: it must be positive"):
        grade_of(1.0, 0.0, 100.0)
    with pytest.raises(ValueError, match=r"at 0\.5 m does not lie between planes at 0\.6 and 1 m"):
        in_two_planes(1.0, 0.5, 0.6, 1.0)
