"""Cones behind the steps of a shaft."""

import numpy as np
import pytest

import rbfound as rb
from rbfound.rotor import with_cones

STEPPED = rb.Shaft([0.3, 0.5], [0.04, 0.1])


def test_length_and_mass_stay():
    for shaft in (STEPPED, rb.thesis.rotor().shaft):
        coned = with_cones(shaft)
        assert coned.ends[-1] == pytest.approx(shaft.ends[-1], rel=1e-12)
        assert rb.Rotor(coned).mass == pytest.approx(rb.Rotor(shaft).mass, rel=1e-12)


def test_what_works_widens_by_the_cone_and_ends_at_the_full_diameter():
    # 45 degrees: from 40 mm at the step to 100 mm 30 mm behind it
    coned = with_cones(STEPPED, slices=3)
    middle = (coned.ends[:-1] + coned.ends[1:]) / 2
    stiff = np.array(coned.stiff)
    expected = np.where(middle < 0.3, 0.04, np.minimum(0.1, 0.04 + 2 * (middle - 0.3)))
    np.testing.assert_allclose(stiff, expected, rtol=1e-9)


def test_a_shaft_without_steps_is_left_as_it_is():
    coned = with_cones(rb.Shaft([0.3, 0.5], [0.05, 0.05]))
    assert set(coned.stiff) == {0.05}


def test_cones_only_soften_and_90_degrees_are_plain_beam_theory():
    plain = rb.Rotor(STEPPED).at(0).modes().above(1).frequency[:4]
    coned = [rb.Rotor(with_cones(STEPPED, angle)).at(0).modes().above(1).frequency[:4] for angle in (30, 45, 89.99)]
    assert (np.diff([*coned, plain], axis=0)[:2] > 0).all()
    # one more mesh of the same elements: its own error, some 1e-5, is all that is left
    np.testing.assert_allclose(coned[2], plain, rtol=1e-4)


@pytest.mark.parametrize("angle", [0.0, 90.0, -5.0, float("nan")])
def test_an_angle_that_is_no_cone_is_refused(angle):
    with pytest.raises(ValueError, match="degrees"):
        with_cones(STEPPED, angle)


def test_stiff_diameters_of_another_number_are_refused():
    with pytest.raises(ValueError, match="2 stiff diameters and 1 lengths"):
        rb.Shaft([1.0], [0.1], stiff=[0.1, 0.1])
