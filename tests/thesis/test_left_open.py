"""What chapter 25 says of the questions that the thesis left open: soft directions, distinct shapes, and few lines."""

from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound import thesis
from rbfound.thesis import methods

DATA = Path(__file__).resolve().parents[2] / "data" / "foundation"
TWICE = [150, 350, 150, 350]


@pytest.fixture(scope="module")
def truth() -> rb.Foundation:
    return rb.load_foundation(DATA / "truth.npz")


def under_the_rotor(foundation: rb.Foundation) -> np.ndarray:
    machine = rb.mount(thesis.rotor(), thesis.bearings(), on=foundation)
    return np.asarray(machine.at(0).modes().above(100).below(600).frequency)


@pytest.mark.parametrize("factor", [10, 0, -1])
def test_model_f_does_not_feel_the_two_soft_directions_of_the_stiffness_matrix(factor: float) -> None:
    # to first order a frequency moves by half its mode's share of strain energy, < 0.05 %, times the change, at most 9
    k, v = np.linalg.eigh(thesis.KE)
    K = (v * k * [factor, factor, 1, 1]) @ v.T
    changed = under_the_rotor(rb.Foundation(thesis.ME, thesis.CE, K, np.eye(4)))
    np.testing.assert_allclose(changed, under_the_rotor(thesis.foundation()), rtol=0.5 * 9 * 5e-4)


def test_the_two_stiff_directions_are_the_ones_that_model_f_feels() -> None:
    k, v = np.linalg.eigh(thesis.KE)
    K = (v * k * [1, 1, 1.1, 1.1]) @ v.T
    changed = under_the_rotor(rb.Foundation(thesis.ME, thesis.CE, K, np.eye(4)))
    assert np.max(changed / under_the_rotor(thesis.foundation()) - 1) > 0.01


def test_rounding_is_as_large_as_the_smallest_eigenvalue_of_the_printed_stiffness() -> None:
    # half a digit in each of sixteen entries: their norm can reach 4 times it
    assert 0 < np.linalg.eigvalsh(thesis.KE)[0] < 4 * 5e3


def test_below_500_hz_there_are_no_four_different_shapes(truth: rb.Foundation) -> None:
    # columns of length one: sqrt(n) / sqrt(1 - s) for two with a cosine s; ten is 0.98, and orthogonal ones have 1
    shapes = truth.B / np.linalg.norm(truth.B, axis=0)
    assert np.linalg.cond(shapes[:, [0, 1, 2, 3]]) > 10
    assert np.linalg.cond(shapes[:, [0, 2, 3, 4]]) < 1.5


def test_imaginary_parts_of_one_mode_read_twice_make_negative_masses() -> None:
    foundation = rb.pmsm(rb.load_frf(DATA / "coarse"), TWICE, parts="complex")
    assert np.linalg.eigvalsh(foundation.M)[0] < 0


def test_twenty_noisy_lines_hold_all_ten_frequencies_that_one_mode_read_twice_loses(truth: rb.Foundation) -> None:
    coarse = rb.load_frf(DATA / "coarse")
    rng = np.random.default_rng(25)
    noise = rng.standard_normal(coarse.H.shape) + 1j * rng.standard_normal(coarse.H.shape)
    noisy = rb.FRF(coarse.frequency, coarse.H * (1 + 0.01 * noise / np.sqrt(2)), coarse.labels)
    expected = under_the_rotor(truth)
    lost = methods.frequency_errors(expected, under_the_rotor(rb.pmsm(coarse, TWICE)))
    kept = methods.frequency_errors(expected, under_the_rotor(rb.identify(noisy, band=(20, 500))))
    assert np.isnan(lost).sum() >= 5
    # the noise of one line, 1 %, over the square root of 20 lines and 16 FRFs: 0.06 %, and an open band's end beside it
    np.testing.assert_array_less(np.abs(kept), 0.2)
