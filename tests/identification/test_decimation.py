"""Gauss nodes in place of lines: exact for what is smooth, and no information lost where it counts."""

from dataclasses import replace

import numpy as np
import pytest
from samples import BAND, LINES, known, noisy

import rbfound as rb
from rbfound.identification import stabilisation, stable_poles
from rbfound.identification.decimation import NODES, compressed, gauss
from rbfound.identification.least_squares import State, cost, curvature, gradient, problem_of, residuals
from rbfound.identification.plscf import lines_in


def problem(level, truth=None, seed=0):
    truth = truth or known()
    data, _ = lines_in(noisy(truth.frf(LINES), level, seed), BAND)
    poles = stable_poles(stabilisation(data))[0] if level else truth.modes().poles
    return compressed(problem_of(rb.from_hertz(data.frequency), data.H), poles, True, 1e-5), truth


@pytest.mark.parametrize("x", [np.arange(9.0), np.geomspace(3, 5, 23)])
def test_nodes_sum_polynomials_of_twice_their_degree_exactly(x):
    # the definition of a Gauss rule, for the sum over x
    at, weight, rows = gauss(x)
    assert ((at > x[0]) & (at < x[-1])).all()
    assert weight.sum() == pytest.approx(len(x))
    for degree in range(2 * NODES):
        assert weight @ (at / x[-1]) ** degree == pytest.approx(((x / x[-1]) ** degree).sum(), rel=1e-12)
    np.testing.assert_allclose(rows @ rows.T, np.eye(NODES), atol=1e-12)
    # the least-squares polynomial, by another road
    y = np.sin(x)
    line = np.polynomial.Polynomial.fit(x, y, NODES - 1)
    np.testing.assert_allclose(rows @ y / np.sqrt(weight), line(at), atol=1e-12)


def test_a_node_holds_the_receptance_there_and_the_noise_of_its_share_of_lines():
    whole, truth = problem(0.01)
    few = whole.nodes
    assert len(few.omega) < 0.25 * len(whole.omega)
    true = truth.frf(rb.hertz(few.omega)).H[:, few.rows, few.columns].T
    # weights are those of one line times the root of the share: what is left is one per cent everywhere, to the
    # statistics of 2800 numbers
    error = few.weight * (few.H - true)
    assert np.sqrt(np.mean(np.abs(error) ** 2)) == pytest.approx(0.01, rel=0.05)
    # independent of one another: neighbours are not alike
    together = np.mean(error[:, 1:] * error[:, :-1].conj()) / np.mean(np.abs(error) ** 2)
    assert abs(together) < 4 / np.sqrt(error.size)


def test_curvature_and_gradient_over_the_nodes_are_those_over_the_lines():
    whole, truth = problem(0.0)
    omega = np.sqrt(np.diag(truth.K))
    state = State(truth.B * 1.01, omega, np.diag(truth.C) / (2 * omega))
    lines = replace(whole, nodes=None)
    N, fewer = curvature(lines, state), curvature(whole, state)
    size = np.sqrt(np.diag(N))
    # the weight is one over a receptance, no polynomial where that has a zero
    np.testing.assert_allclose(fewer / size / size[:, None], N / size / size[:, None], atol=2e-3)
    b = gradient(whole.nodes, state, residuals(whole.nodes, state))
    np.testing.assert_allclose(b / size, gradient(lines, state, residuals(lines, state)) / size, atol=2e-3 * 20)
    assert cost(whole.nodes, state) == pytest.approx(cost(lines, state), rel=2e-3)


def test_a_mode_that_no_pole_announces_is_not_smoothed_away():
    # 0.2 % at 300 Hz is narrower than three lines, and 480 and 640 Hz are unknown too
    truth = known([62.0, 300.0, 480.0, 640.0], [0.015, 0.002, 0.015, 0.015])
    data, _ = lines_in(noisy(truth.frf(LINES), 0.01), BAND)
    lines = problem_of(rb.from_hertz(data.frequency), data.H)
    few = compressed(lines, truth.modes().poles[:1], True, 1e-5).nodes
    true = truth.frf(rb.hertz(few.omega)).H[:, few.rows, few.columns].T
    error = np.abs(few.weight * (few.H - true)) ** 2
    assert np.sqrt(error.mean()) == pytest.approx(0.01, rel=0.1)
    near = np.abs(rb.hertz(few.omega) - 300) < 3
    assert near.sum() >= 8


@pytest.mark.parametrize("place", [20 / 1.001, 20 / 1.05, 1000 * 1.0002, 1000 * 1.002, 1000 * 1.02])
def test_a_pseudo_mode_beside_the_band_cannot_hide_between_the_nodes(place):
    # the search may bring one as near as it likes, where the data's own poles ask for no dense lines
    whole, truth = problem(0.01)
    omega = np.sqrt(np.diag(truth.K))
    state = State(truth.B, omega, np.diag(truth.C) / (2 * omega))
    shape = np.full((4, 1), 0.01)
    more = state.joined(State(shape, np.array([rb.from_hertz(place)]), np.array([0.01])))
    over_lines, over_nodes = (cost(p, more) - cost(p, state) for p in (whole, whole.nodes))
    assert over_lines > 1
    assert over_nodes == pytest.approx(over_lines, rel=0.02)


def test_few_lines_stay_as_they_are():
    truth = known([100.0, 250.0])
    frf = truth.frf(np.arange(25.0, 501.0, 25.0))
    lines = problem_of(rb.from_hertz(frf.frequency), frf.H)
    assert compressed(lines, truth.modes().poles, True, 1e-5).nodes is None


def test_known_errors_are_carried_to_the_nodes():
    truth = known([100.0, 250.0, 400.0])
    rng = np.random.default_rng(1)
    clean = truth.frf(LINES).H
    errors = np.full(clean.shape, 2e-3 * np.sqrt(np.mean(np.abs(clean) ** 2)))
    e = rng.standard_normal((*clean.shape, 2)) @ [1, 1j] / np.sqrt(2)
    data, _ = lines_in(rb.FRF(LINES, clean + errors * e), BAND)
    errors = errors[: len(data.frequency)]
    lines = problem_of(rb.from_hertz(data.frequency), data.H, False, errors)
    few = compressed(lines, truth.modes().poles, False, 1e-5).nodes
    true = truth.frf(rb.hertz(few.omega)).H[:, few.rows, few.columns].T
    # in standard deviations
    assert np.sqrt(np.mean(np.abs(few.weight * (few.H - true)) ** 2)) == pytest.approx(1.0, rel=0.05)
