"""The rotor's inverse problem: known shafts come back, the eight numbers are met, and what they leave open is known."""

import numpy as np
import pytest

import rbfound as rb
from rbfound.thesis import fit_shaft, shaft_fit
from rbfound.thesis.shaft_fit import PARAMETERS, TARGETS, four_segments, frequencies, three_segments, two_segments

# the package's own equivalent rotor in the terms of `four_segments`
OWN = [60.0, 100.0, 60.0, 40.0, 90.0, 745.0, 15.0, 150.0, 45.0, 850.0, 200.0]


@pytest.fixture(scope="module")
def fit() -> shaft_fit.ShaftFit:
    return fit_shaft(three_segments, [50, 90, 700, 200, 20])


def test_one_plane_has_the_frequencies_of_the_whole_machines() -> None:
    found = frequencies(four_segments, OWN)
    whole = []
    for letter, count in (("a", 2), ("b", 2), ("c", 4)):
        whole += [*rb.thesis.model(letter).at(0.0).modes().above(1.0).frequency[: 2 * count : 2]]
    # two meshes: elements of 50 and 60 mm are some hundredths of a per cent too stiff in the highest of these modes
    np.testing.assert_allclose(found, whole, rtol=4e-4)
    same = [*shaft_fit.machine(four_segments, OWN, "c").at(0.0).modes().above(1.0).frequency[:8:2]]
    np.testing.assert_allclose(found[4:], same, rtol=1e-7)


def test_the_targets_are_the_printed_numbers_of_tables_3_to_5() -> None:
    np.testing.assert_array_equal(TARGETS, [601.7, 1171.0, 281.9, 760.8, 185.7, 225.6, 544.6, 981.9])


def test_a_known_shaft_comes_back_from_its_own_frequencies(monkeypatch: pytest.MonkeyPatch) -> None:
    known = np.array([98.0, 790.0, 41.0, 150.0, 15.0])
    monkeypatch.setattr(shaft_fit, "TARGETS", frequencies(two_segments, known))
    found = fit_shaft(two_segments, [90, 700, 50, 200, 20])
    # the least singular value, 0.02, multiplies what the stop of the iteration leaves
    np.testing.assert_allclose(found.values, known, rtol=1e-4)


def test_five_lengths_meet_all_eight_numbers_within_an_eighth_of_a_per_cent(fit: shaft_fit.ShaftFit) -> None:
    # five unknowns, eight equations: that they can be met at all is information
    assert np.abs(fit.error).max() < 0.125


def test_the_fit_finds_the_same_shaft_from_another_start(fit: shaft_fit.ShaftFit) -> None:
    other = fit_shaft(three_segments, [30, 110, 850, 120, 5])
    np.testing.assert_allclose(other.values, fit.values, rtol=1e-4)


def test_fitted_to_a_b_and_c_it_predicts_f_within_a_fifth_of_a_per_cent(fit: shaft_fit.ShaftFit) -> None:
    found = shaft_fit.predicted(fit.design, fit.values)
    np.testing.assert_allclose(found, rb.thesis.printed("f"), rtol=2e-3)


def test_what_a_b_and_c_do_not_feel_f_does_not_feel_either() -> None:
    J, F = (shaft_fit.sensitivity(four_segments, OWN, of) for of in (frequencies, shaft_fit.predicted))
    rows = np.linalg.svd(J)[2]
    # three directions that no number of a, b, c feels: in f they are a hundred times weaker than the strongest one
    assert np.linalg.norm(F @ rows[8:].T, 2) < 0.01 * np.linalg.norm(F, 2)


def test_the_directions_are_those_in_which_the_frequencies_move_as_said(fit: shaft_fit.ShaftFit) -> None:
    sizes, rows = fit.directions()
    assert len(sizes) == len(rows) == len(PARAMETERS[three_segments])
    for size, row in zip(sizes, rows, strict=True):
        moved = np.log(frequencies(three_segments, fit.moved(row, 0.1)) / fit.frequency)
        # a step of 0.1 %: the second order is a thousandth of the lengths' own nonlinearity
        assert np.linalg.norm(moved) == pytest.approx(1e-3 * size, rel=0.02, abs=2e-6)


def test_more_unknowns_than_numbers_leave_directions_that_no_number_feels() -> None:
    f = shaft_fit.ShaftFit(
        four_segments, np.array(OWN), frequencies(four_segments, OWN), shaft_fit.sensitivity(four_segments, OWN)
    )
    sizes, rows = f.directions()
    assert len(sizes) == len(PARAMETERS[four_segments]) == 11
    assert (sizes[8:] == 0).all()
    moved = np.log(frequencies(four_segments, f.moved(rows[-1], 1.0)) / f.frequency)
    assert np.abs(moved).max() < 2e-4  # of a step of 1 %: second order only


def test_youngs_modulus_moves_a_free_shaft_as_its_square_root() -> None:
    J = shaft_fit.sensitivity(four_segments, OWN)
    np.testing.assert_allclose(J[:4, -1], 0.5, rtol=1e-5)
    assert (J[4:, -1] < 0.5).all()  # the bearings do not become stiffer with it


def test_a_start_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match=r"start has shape \(2,\): this design has the parameters D body"):
        fit_shaft(two_segments, [1.0, 2.0])
    with pytest.raises(ValueError, match="start holds -5: their logarithms are fitted"):
        fit_shaft(two_segments, [90, 700, 50, 200, -5])
