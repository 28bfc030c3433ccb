"""Numbers that are hard on the arithmetic: a right answer or a ValueError that says why, never a silent wrong one."""

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

import rbfound as rb

ROTOR, PLACES = rb.thesis.rotor(), rb.thesis.bearings()
BODY = rb.thesis.unrounded_foundation()
LINES = np.arange(20.0, 400.0, 1.0)
TWO = ("x1", "y1")
PHI = np.array([[0.1, 0.05, 0.02], [0.02, 0.1, -0.05]])
SMALL = rb.modal_foundation(PHI, rb.from_hertz(np.array([80.0, 140.0, 220.0])), [0.02] * 3, TWO)
EYE, NONE = np.eye(2), np.zeros((2, 2))


def answer(work, *arguments):
    """What a piece of work returns, or what its ValueError says."""
    try:
        return work(*arguments)
    except ValueError as error:
        return str(error)


def lowest(k, c=1e3, count=5):
    """Natural frequencies [Hz] of the rotor in bearings of a stiffness and damping, on its foundation."""
    bearing = rb.Bearing(k, k, cxx=c, cyy=c)
    return rb.mount(ROTOR, dict.fromkeys(PLACES, bearing), on=BODY).at(100.0).modes().above(1.0).frequency[:count]


# --- stiffness of any size ---


def test_a_bearing_of_no_stiffness_leaves_the_foundation_as_it_is_and_the_rotor_free():
    free = ROTOR.at(100.0).modes().above(1.0).frequency
    both = np.sort(np.concatenate([free, BODY.modes().frequency]))
    for k in (0.0, 1e-10):
        np.testing.assert_allclose(lowest(k, c=0.0), both[:5], rtol=1e-6)


@settings(max_examples=15)
@given(st.floats(11, 300))
@example(17.3)  # here every spring but the bearings was less than their rounding, and all that it held passed for free
def test_a_stiffer_and_stiffer_bearing_ends_at_the_rigid_one_or_is_refused(exponent):
    # 6e-5 is what 1e11 N/m lacks of rigid. Where it is not refused, below 3e14 N/m, rounding adds 4e-5 at most with
    # any processor's kernels: eigenvalues are found after entries of many sizes have been balanced, and the slow ones
    # suffer less than the 3 % that `System.rounding` fears there
    rigid = lowest(1e12)
    found = answer(lowest, 10.0**exponent)
    if isinstance(found, str):
        assert exponent > 13
        assert "too many orders of magnitude: modes below" in found
    else:
        np.testing.assert_allclose(found, rigid, rtol=1e-3)


@pytest.mark.parametrize("c", [1e12, 1e15, 1e100])
def test_damping_that_drowns_every_mode_is_refused(c):
    with pytest.raises(ValueError, match="too many orders of magnitude"):
        lowest(1e8, c)


@settings(max_examples=10)
@given(st.floats(-14, -2))
def test_a_short_segment_changes_nothing_or_is_refused(exponent):
    def frequencies(lengths):
        rotor = rb.Rotor(rb.Shaft(lengths, [0.05] * len(lengths)), element=0.2)
        bearings = {0.0: rb.Bearing(1e8, 1e8), 2.0: rb.Bearing(1e8, 1e8)}
        return rb.mount(rotor, bearings).at(0.0).modes().frequency[:4]

    found = answer(frequencies, [1.0, 10.0**exponent, 1.0 - 10.0**exponent])
    if isinstance(found, str):
        assert exponent < -4
        assert "too many orders of magnitude" in found
    else:
        np.testing.assert_allclose(found, frequencies([1.0, 1.0]), rtol=1e-3)


def test_more_elements_than_memory_holds_are_refused():
    with pytest.raises(ValueError, match=r"would have 1e\+09 elements, more than 2000"):
        rb.Rotor(rb.Shaft([1.0], [0.05]), element=1e-9)


# --- masses, and matrices that are no machine's ---


@pytest.mark.parametrize("M", [NONE, -EYE, np.diag([1.0, 0.0]), [[1.0, 2.0], [2.0, 1.0]]])
def test_a_mass_matrix_without_mass_everywhere_is_refused(M):
    body = rb.Foundation(M, EYE, EYE, EYE, TWO)
    with pytest.raises(ValueError, match="M is not positive definite: its smallest eigenvalue is"):
        body.modes()
    with pytest.raises(ValueError, match="M is not positive definite"):
        rb.mount(ROTOR, {min(PLACES): rb.Bearing(1e8, 1e8)}, on=body).at(0.0).modes()


def test_stiffness_and_damping_that_drive_show_as_what_they_are():
    # q'' - q = 0 grows as exp(t): a real pole at +1; q'' - q' + 1e4 q = 0 has the damping ratio -0.005
    poles = rb.Foundation(EYE, NONE, -EYE, EYE, TWO).modes().poles
    np.testing.assert_allclose(np.sort(poles.real), [-1, -1, 1, 1], atol=1e-12)
    np.testing.assert_allclose(rb.Foundation(EYE, -EYE, 1e4 * EYE, EYE, TWO).modes().damping, -0.005, rtol=1e-9)
    body = rb.Foundation(EYE, -EYE, -1e4 * EYE, EYE, TWO)
    assert body.definiteness()["C"] < 0
    assert body.definiteness()["K"] < 0


@settings(max_examples=50)
@given(st.floats(-9, 9), st.floats(-9, 9))
def test_other_units_of_mass_and_length_change_no_frequency(mass, length):
    """Tons and millimetres, or whatever: M, C and K all scale with the mass, B with the length."""
    scaled = [10.0**mass * getattr(SMALL, name) for name in "MCK"]
    other = rb.Foundation(*scaled, 10.0**length * SMALL.B, TWO)
    np.testing.assert_allclose(other.modes().poles, SMALL.modes().poles, rtol=1e-9)
    H = 10.0 ** (2 * length - mass) * SMALL.frf(LINES).H
    np.testing.assert_allclose(other.frf(LINES).H, H, rtol=1e-9, atol=1e-12 * np.abs(H).max())


# --- identification ---


@pytest.mark.parametrize("scale", [1e-12, 1e-3, 1e12])
def test_receptances_in_any_unit_give_the_same_modes(scale):
    # without noise: what is left is where the fit stops
    found = rb.identify(rb.FRF(LINES, scale * SMALL.frf(LINES).H, TWO)).modes()
    np.testing.assert_allclose(found.poles, SMALL.modes().poles, rtol=1e-8)


def test_receptances_that_no_unit_explains_are_refused():
    for scale in (1e-160, 1e160):
        with pytest.raises(ValueError, match=r"The largest receptance is .* m/N: is its unit right"):
            rb.identify(rb.FRF(LINES, scale * SMALL.frf(LINES).H, TWO))
    with pytest.raises(ValueError, match="are zero: nothing moves"):
        rb.identify(rb.FRF(LINES, np.zeros((len(LINES), 2, 2)), TWO))


@pytest.mark.parametrize("seed", range(4))
def test_noise_alone_is_refused_or_called_unsure(seed):
    rng = np.random.default_rng(seed)
    H = rng.standard_normal((len(LINES), 2, 2)) + (seed % 2) * 1j * rng.standard_normal((len(LINES), 2, 2))
    found = answer(rb.identify, rb.FRF(LINES, H, TWO))
    if isinstance(found, str):
        # real noise has no phase
        assert ("No mode was found" if seed % 2 else "have no phase") in found
    else:
        assert any(note.startswith("Warning") for note in found.notes)


@pytest.mark.parametrize("wrong", [np.negative, np.conj])
def test_a_set_of_the_other_sign_is_refused_by_peaks_and_warned_of_by_fits(wrong):
    frf = rb.FRF(LINES, wrong(SMALL.frf(LINES).H), TWO)
    with pytest.raises(ValueError, match="has a positive imaginary part"):
        rb.pmsm(frf, [80, 140])
    assert rb.identify(frf).notes[0].startswith("Warning: this is no model of the data")
    assert any("gives energy away" in warning for warning in rb.check(frf).warnings)


def test_repeated_poles_are_found_as_often_as_the_seats_can_tell():
    twice = rb.modal_foundation([[0.1, 0.0], [0.0, 0.1]], rb.from_hertz(np.array([100.0, 100.0])), [0.02] * 2, TWO)
    found = rb.identify(twice.frf(LINES))
    np.testing.assert_allclose(found.modes().poles, twice.modes().poles, rtol=1e-8)
    np.testing.assert_allclose(found.frf(LINES).H, twice.frf(LINES).H, rtol=1e-7)


def test_a_singular_phi_is_refused_whichever_way_it_is_singular():
    lone = rb.modal_foundation([[0.1], [0.1]], rb.from_hertz(np.array([100.0])), [0.02], TWO)
    with pytest.raises(ValueError, match="Phi is singular"):
        rb.pmsm(lone.frf(LINES), [100, 100])
    for phi in (np.ones((2, 2)), [[1.0, 2.0], [1.0, 2.0 + 1e-15]], np.zeros((2, 2))):
        with pytest.raises(ValueError, match="Phi is singular"):
            rb.equivalent_matrices(phi, [100.0, 200.0], [0.01, 0.01], TWO)


@settings(max_examples=60)
@given(st.floats(-14, 0))
def test_a_phi_near_to_singular_says_its_condition_or_is_refused(exponent):
    phi = [[1.0, 1.0], [0.0, 10.0**exponent]]
    body = rb.equivalent_matrices(phi, [100.0, 200.0], [0.01, 0.01], TWO)
    assert any(note.startswith("cond(Phi) = ") for note in body.notes)
    # the poles survive M = Phi^-T Phi^-1 as far as twice the condition number leaves digits
    found = answer(body.modes)
    if isinstance(found, str):
        assert exponent < -6
        assert "M is not positive definite" in found
    else:
        np.testing.assert_allclose(np.abs(found.poles), [100.0, 200.0], rtol=1e-12 * 10.0 ** (-2 * exponent) + 1e-9)
