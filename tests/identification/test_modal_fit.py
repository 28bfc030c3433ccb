"""All modes of a band from sixteen FRFs: accuracy on known foundations, alone and under the rotor."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from samples import BAND, F_N, LINES, PROMISED, alone, assert_passive, errors, known, machine_poles, noisy

import rbfound as rb
from rbfound.identification.least_squares import State, curvature, gradient, moved, problem_of, residuals

# --- what it reaches: see test_identification.py too ---


def test_the_shapes_come_back_with_their_mass():
    truth = known()
    fit = rb.fit_modes(noisy(truth.frf(LINES), 0.01), band=BAND)
    Phi = fit.Phi[:, fit.inside]
    assert Phi.shape == (4, 7)
    Phi = Phi * np.sign((Phi * truth.B[:, :7]).sum(axis=0))
    np.testing.assert_allclose(Phi, truth.B[:, :7], atol=0.005 * np.abs(truth.B[:, :7]).max())


def test_the_modes_of_the_band_alone_are_not_enough_under_the_rotor():
    # why pseudo-modes: the exact modes of the band without any remainder
    truth = known()
    cut = rb.modal_foundation(truth.B[:, :7], 2 * np.pi * F_N, np.full(7, 0.015))
    error = errors(machine_poles(truth).below(800).poles, machine_poles(cut).poles)
    assert error[0] > 5 * PROMISED[0.05][2]


# --- what may stand in the band ---


def test_two_modes_apart_by_their_half_power_width_are_told_apart():
    truth = known([100.0, 300.0, 312.0, 600.0], 0.02)
    for level in (0.0, 0.01, 0.05):
        reached = alone(truth, rb.fit_modes(noisy(truth.frf(LINES), level), band=BAND))
        assert (np.array(reached) < PROMISED[level][:2]).all(), (level, reached)


def test_a_mode_that_one_seat_alone_sees_is_found():
    Phi = known([100.0, 250.0, 400.0, 600.0, 800.0]).B.copy()
    Phi[:, 2] = [0, 0, 0.1, 0]
    truth = known([100.0, 250.0, 400.0, 600.0, 800.0], Phi=Phi)
    for level in (0.01, 0.05):
        reached = alone(truth, rb.fit_modes(noisy(truth.frf(LINES), level), band=BAND))
        assert (np.array(reached) < PROMISED[level][:2]).all(), (level, reached)


@pytest.mark.parametrize("zeta", [0.002, 0.1, [0.002, 0.1, 0.02, 0.002, 0.05]])
def test_light_and_heavy_damping_are_found(zeta):
    truth = known([100.0, 250.0, 400.0, 600.0, 800.0], zeta)
    fit = rb.fit_modes(noisy(truth.frf(LINES), 0.01), band=BAND)
    assert (np.array(alone(truth, fit)) < PROMISED[0.01][:2]).all()


@pytest.mark.parametrize("count", [4, 8, 12])
def test_four_to_twelve_modes_are_found(count):
    truth = known(np.geomspace(60, 900, count), seed=count)
    fit = rb.fit_modes(noisy(truth.frf(LINES), 0.01, 3), band=BAND)
    assert (np.array(alone(truth, fit)) < PROMISED[0.01][:2]).all()
    assert (fit.inside & ~fit.unsure).sum() == count


def test_twenty_coarse_lines_still_tell_the_modes_between_them():
    truth = known()
    fit = rb.fit_modes(truth.frf(np.arange(25.0, 501.0, 25.0)))
    reached = errors(truth.modes().below(490).poles, fit.omega * (-fit.zeta + 1j * np.sqrt(1 - fit.zeta**2)))
    assert reached[0] < 0.1
    assert_passive(fit.foundation())


def test_noise_of_a_sensor_is_weighted_as_such():
    truth = known()
    clean = truth.frf(LINES)
    floor = 1e-3 * np.sqrt(np.mean(np.abs(clean.H) ** 2))
    e = np.random.default_rng(0).standard_normal((*clean.H.shape, 2)) @ [1, 1j] / np.sqrt(2)
    fit = rb.fit_modes(rb.FRF(LINES, clean.H + floor * e), band=BAND, relative=False)
    assert (np.array(alone(truth, fit)) < PROMISED[0.01][:2]).all()
    assert fit.noise == pytest.approx(floor, rel=0.05)
    assert "m/N" in str(fit.foundation())


# --- properties ---

SHORT = np.arange(20.0, 601.0, 2.0)
FEW = known([62.0, 150.0, 240.0, 400.0])


@settings(max_examples=5)
@given(seed=st.integers(0, 10**6), level=st.sampled_from([0.01, 0.1, 0.3]))
def test_whatever_the_noise_the_foundation_is_reciprocal_and_passive(seed, level):
    assert_passive(rb.identify(noisy(FEW.frf(SHORT), level, seed)))


@settings(max_examples=4)
@given(seed=st.integers(0, 10**6), order=st.permutations(range(4)), unit=st.sampled_from([1e-3, 1e3]))
def test_units_scale_the_shapes_and_seats_may_change_places(seed, order, unit):
    frf = noisy(FEW.frf(SHORT), 0.01, seed)
    labels = tuple(frf.labels[k] for k in order)
    a = rb.fit_modes(frf)
    b = rb.fit_modes(rb.FRF(SHORT, unit * frf.H[:, order][:, :, order], labels))
    # the way down may differ in rounding, and with it where the search ends: far less than a standard deviation
    own, other = a.inside & ~a.unsure, b.inside & ~b.unsure
    np.testing.assert_allclose(b.omega[other], a.omega[own], rtol=1e-4)
    np.testing.assert_allclose(b.zeta[other], a.zeta[own], rtol=1e-2)
    np.testing.assert_allclose(
        np.abs(b.Phi[:, other]), np.sqrt(unit) * np.abs(a.Phi[order][:, own]), rtol=0.02, atol=1e-3 * np.sqrt(unit)
    )


def test_the_derivatives_of_the_residuals_are_those_of_finite_differences():
    truth = known(F_N[:3])
    frf = noisy(truth.frf(np.arange(20.0, 500.0, 7.0)), 0.05)
    problem = problem_of(2 * np.pi * frf.frequency, frf.H)
    omega = np.sqrt(np.diag(truth.K))
    state = State(truth.B, omega, np.diag(truth.C) / (2 * omega))
    N, b = curvature(problem, state), gradient(problem, state, residuals(problem, state))

    def r(x):
        return residuals(problem, moved(problem, state, x)).view(float).ravel()

    # central differences of step h: an error of h^2
    J = np.array([(r(-e) - r(e)) / 2e-6 for e in 1e-6 * np.eye(len(b))])
    np.testing.assert_allclose(N, J @ J.T, atol=1e-7 * np.abs(N).max())
    np.testing.assert_allclose(b, J @ r(np.zeros(len(b))), atol=1e-7 * np.abs(b).max())


def test_the_stated_deviations_are_those_of_repeated_noise():
    # thirty seeds of one foundation: the scatter of each frequency beside the stated one; 30 give it to 13 % (1 sigma)
    clean = FEW.frf(SHORT)
    fits = [rb.fit_modes(noisy(clean, 0.02, seed)) for seed in range(30)]
    found = np.array([[f.omega[np.abs(f.omega - w).argmin()] for w in np.sqrt(np.diag(FEW.K))[:4]] for f in fits])
    stated = np.median([f.deviation[0][f.inside & ~f.unsure][:4] for f in fits], axis=0)
    np.testing.assert_allclose(found.std(axis=0, ddof=1) / found.mean(axis=0), stated, rtol=0.5)


# --- what it says ---


def test_the_notes_tell_the_modes_the_misfit_and_the_noise():
    text = " ".join(rb.identify(noisy(known().frf(LINES), 0.01), band=BAND).notes)
    assert "Identified from 20 to 1000 Hz: 7 modes in the band, 62 Hz 1.5 %, 150 Hz" in text
    assert "pseudo-modes stand for what lies outside it" in text
    assert "the noise is estimated to be 0.99" in text
    assert "Warning" not in text


def test_a_mode_that_is_asked_for_and_is_not_there_is_called_unsure():
    fit = rb.fit_modes(noisy(known().frf(LINES), 0.01), band=BAND, modes=8)
    assert fit.inside.sum() == 8
    assert fit.unsure.sum() == 1
    assert "is unsure: its frequency is known to" in " ".join(fit.foundation().notes)


def test_fewer_modes_than_the_data_show_are_an_error_that_lists_them():
    with pytest.raises(
        ValueError, match=r"modes is 5, but the data show 7 in the band, at 62, 150, 187, 330, 480, 640"
    ):
        rb.identify(noisy(known().frf(LINES), 0.01), band=BAND, modes=5)


def test_too_few_lines_no_motion_and_no_modes_are_errors_with_their_numbers():
    frf = known().frf(LINES)
    with pytest.raises(ValueError, match=r"Only 2 lines lie between 100 and 100\.5 Hz: 4 seats and some modes need at"):
        rb.identify(frf, band=(100, 100.5))
    with pytest.raises(ValueError, match="modes is 0: a foundation has at least one mode"):
        rb.identify(frf, modes=0)
    with pytest.raises(ValueError, match=r"lies outside the FRFs, which reach from 0\.5 to 1000 Hz"):
        rb.identify(frf, band=(1200, 1300))
    with pytest.raises(ValueError, match=r"All receptances between 0\.5 and 1000 Hz are zero: nothing moves"):
        rb.identify(rb.FRF(LINES, np.zeros((len(LINES), 4, 4))))


def test_one_seat_is_enough():
    truth = rb.modal_foundation([[0.1, 0.2, 0.1]], 2 * np.pi * np.array([100.0, 300.0, 700.0]), [0.02] * 3, ("x1",))
    f = rb.identify(noisy(truth.frf(SHORT), 0.01))
    assert f.labels == ("x1",)
    np.testing.assert_allclose(f.modes().frequency[:2], truth.modes().frequency[:2], rtol=1e-3)


def test_a_search_that_went_astray_is_an_error_and_no_foundation(monkeypatch):
    # all shapes a thousand times too large, and nothing that mends them
    def astray(problem, state, *rest):
        return State(1e3 * state.Phi, state.omega, state.zeta)

    monkeypatch.setattr("rbfound.identification.modal_fit.completed", astray)
    monkeypatch.setattr("rbfound.identification.modal_fit.refine", lambda problem, state, **rest: (state, 0.0))
    monkeypatch.setattr("rbfound.identification.modal_fit.pruned", lambda problem, state, suspects: state)
    monkeypatch.setattr("rbfound.identification.modal_fit.uncrowded", lambda problem, state: state)
    with pytest.raises(
        ValueError, match=r"did not converge: from 20 to 1000 Hz it misses the FRFs by .* times their size"
    ):
        rb.fit_modes(known().frf(LINES), band=BAND)
