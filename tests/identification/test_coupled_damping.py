"""Foundations whose damping couples the modes: dashpots at two places, and soil under a stiff body."""

from dataclasses import replace

import numpy as np
import pytest
from samples import BAND, F_N, LINES, assert_passive, known, noisy, under_the_rotor

import rbfound as rb
from rbfound.identification.added_modes import deviation_of_poles
from rbfound.identification.error_propagation import _slopes
from rbfound.identification.least_squares import State, curvature, gradient, moved, problem_of, residuals

# What is promised [%] under the rotor: frequency and damping.
PROMISED = {0.01: (0.08, 3.0), 0.05: (0.2, 6.0)}


def with_dashpots(seed=0, most=0.03):
    """Seven modes of the band and four above it, with dashpots at two places that are no seats."""
    modal = known(seed=seed)
    omega = np.sqrt(np.diag(modal.K))
    places = np.random.default_rng(100 + seed).standard_normal((2, len(omega))) * np.sqrt(omega / omega[3])
    return replace(modal, C=modal.C + most * omega[:7].mean() * places.T @ places)


@pytest.fixture(scope="module")
def fits():
    return {level: rb.fit_modes(noisy(with_dashpots().frf(LINES), level, 1), band=BAND) for level in PROMISED}


@pytest.mark.parametrize("level", PROMISED)
def test_dashpots_invent_no_modes_and_the_coupled_modes_come_back(fits, level):
    fit, truth = fits[level], with_dashpots()
    assert fit.inside.sum() == len(F_N)
    reached = under_the_rotor(truth, fit)
    assert (np.array(reached) < PROMISED[level]).all(), reached
    made = fit.foundation()
    assert_passive(made)
    assert np.abs(made.C - np.diag(np.diag(made.C))).max() > 0.01 * np.abs(made.C).max()
    assert "C is full" in " ".join(made.notes)


def test_modal_damping_stays_modal():
    fit = rb.fit_modes(noisy(known().frf(LINES), 0.01), band=BAND)
    assert fit.coupling is None
    np.testing.assert_array_equal(fit.C, np.diag(2 * fit.zeta * fit.omega))


def test_the_derivatives_by_a_full_damping_matrix_are_those_of_finite_differences():
    truth = with_dashpots()
    frf = noisy(truth.frf(np.arange(20.0, 500.0, 7.0)), 0.05)
    problem = problem_of(2 * np.pi * frf.frequency, frf.H)
    omega = np.sqrt(np.diag(truth.K))
    V = np.tril(np.random.default_rng(0).standard_normal((11, 11)), -1)
    V[5, 4] = 0
    state = State(truth.B, omega, np.diag(truth.C) / (2 * omega), V)
    N, b = curvature(problem, state), gradient(problem, state, residuals(problem, state))

    def r(x):
        return residuals(problem, moved(problem, state, x)).view(float).ravel()

    # central differences of step h: an error of h^2
    J = np.array([(r(-e) - r(e)) / 2e-6 for e in 1e-6 * np.eye(len(b))])
    assert len(b) == 6 * 11 + 11 * 10 / 2 - 1
    np.testing.assert_allclose(N, J @ J.T, atol=1e-7 * np.abs(N).max())
    np.testing.assert_allclose(b, J @ r(np.zeros(len(b))), atol=1e-7 * np.abs(b).max())


def test_some_of_the_modes_keep_their_damping():
    state = State(np.ones((1, 3)), np.arange(1.0, 4.0), np.full(3, 0.1), np.tril(np.ones((3, 3)), -1))
    order = [2, 0]
    # what is added for the Cholesky factor is 1e-9
    np.testing.assert_allclose(state.only(np.array(order)).C, state.C[order][:, order], rtol=1e-8)


def test_derivatives_of_poles_by_the_coupling_are_those_of_finite_differences(fits):
    fit = fits[0.01]
    rotor, bearings = rb.thesis.rotor(), rb.thesis.bearings()
    machine = rb.mount(rotor, bearings, on=fit.foundation())
    pole = machine.at(0.0).modes().above(50).below(400).poles[3]
    slope, _ = _slopes(fit, machine, 0.0, pole)
    m = len(fit.omega)
    assert len(slope) == len(fit.covariance) == 6 * m + m * (m - 1) // 2
    rows, columns = np.tril_indices(m, -1)
    first = slope[6 * m :]
    for k in np.argsort(np.abs(first))[-3:]:
        ends = []
        for h in (1e-4, -1e-4):
            R = fit.coupling.copy()
            R[rows[k], columns[k]] += h
            R[columns[k], rows[k]] += h
            poles = rb.mount(rotor, bearings, on=replace(fit, coupling=R).foundation()).at(0.0).modes().poles
            ends.append(poles[np.abs(poles - pole).argmin()])
        assert (ends[0] - ends[1]) / 2e-4 == pytest.approx(first[k], rel=1e-3)


def test_the_window_of_a_hammer_test_cannot_be_taken_out_of_coupled_damping(fits):
    with pytest.raises(ValueError, match="damping of this fit couples the modes"):
        rb.identification.without_window(fits[0.01], 1.0)


def test_modes_that_dashpots_couple_are_sure_and_their_poles_within_the_error_bars(fits):
    for level, fit in fits.items():
        assert not fit.unsure.any(), level
        frequency, damping = deviation_of_poles(fit.omega, fit.C, fit.covariance)
        got, true = (f.modes().above(BAND[0]).below(BAND[1]).poles for f in (fit.foundation(), with_dashpots()))
        assert len(got) == len(true) == len(F_N)
        # of 14 normal numbers one is beyond 3.5 once in 150 times
        assert (np.abs(np.abs(got / true) - 1) < 3.5 * frequency[fit.inside]).all()
        assert (np.abs(got.real / true.real - np.abs(got / true)) < 3.5 * damping[fit.inside]).all()
        assert (frequency[fit.inside] < fit.deviation[0][fit.inside]).all()
