"""Missing modes: seen before any fit is good, and candidates of no interest are left alone."""

import numpy as np
import pytest
from samples import BAND, LINES, known, noisy

import rbfound as rb
from rbfound.identification.added_modes import candidates, missing_mode, within
from rbfound.identification.decimation import compressed
from rbfound.identification.least_squares import State, cost, problem_of, refine
from rbfound.identification.lsfd import first_modes
from rbfound.identification.model_order import started
from rbfound.identification.plscf import lines_in


def problem(truth, level=0.01, seed=0):
    data, _ = lines_in(noisy(truth.frf(LINES), level, seed), BAND)
    return compressed(problem_of(rb.from_hertz(data.frequency), data.H), truth.modes().poles[:0], True, 1e-5)


def of_the_band(state):
    f = rb.hertz(state.omega)
    return np.sort(f[(f > BAND[0]) & (f < BAND[1])])


@pytest.mark.parametrize("missing", [[0], [2], [0, 5]])
def test_modes_that_the_poles_lack_are_there_from_the_start(missing):
    truth = known()
    poles = truth.modes().above(BAND[0]).below(BAND[1]).poles
    state = started(problem(truth), np.delete(poles, missing), 0.015, 16)
    assert len(of_the_band(state)) == len(poles)
    # candidates stand half a damping ratio of 1.5 % apart on either side, and a mode that comes alone stands for others
    np.testing.assert_allclose(of_the_band(state), np.sort(rb.hertz(np.abs(poles))), rtol=0.03)


def test_where_all_poles_are_known_none_is_added():
    truth = known()
    poles = truth.modes().above(BAND[0]).below(BAND[1]).poles
    whole = problem(truth)
    state = started(whole, poles, 0.015, 16)
    np.testing.assert_array_equal(state.omega, first_modes(whole.thinned(), poles).omega)


def test_a_bound_on_what_is_of_interest_changes_nothing_of_what_is():
    truth = known()
    whole = problem(truth)
    state = first_modes(whole.thinned(), truth.modes().above(BAND[0]).below(BAND[1]).poles[1:])
    tried = candidates(*whole.edges, 0.015)
    new, gain = missing_mode(whole, state, tried, 0.015)
    least = np.median(gain)
    fewer, then = missing_mode(whole, state, tried, 0.015, least)
    np.testing.assert_array_equal(then[gain > least], gain[gain > least])
    np.testing.assert_array_equal(fewer.Phi[:, gain > least], new.Phi[:, gain > least])
    assert (then[gain <= least] <= least).all()
    assert (then == 0).any()


def test_the_band_keeps_its_edges():
    np.testing.assert_array_equal(within(np.array([1.0, 2.0, 3.0, 4.0]), (2.0, 3.0)), [2.0, 3.0])


def test_of_a_held_mode_the_shape_alone_moves():
    truth = known()
    data, _ = lines_in(truth.frf(LINES), BAND)
    lines = problem_of(rb.from_hertz(data.frequency), data.H)
    omega = np.sqrt(np.diag(truth.K))
    true = State(truth.B, omega, np.diag(truth.C) / (2 * omega))
    start = State(true.Phi * 1.05, true.omega * 1.001, true.zeta * 1.05)
    held = rb.hertz(true.omega) > BAND[1]
    state, left = refine(lines, start, small=1e-12, held=held)
    np.testing.assert_array_equal(state.zeta[held], start.zeta[held])
    np.testing.assert_allclose(state.omega[held], start.omega[held], rtol=1e-14)
    assert left < 1e-4 * cost(lines, start)
    assert np.abs(state.Phi[:, held] / start.Phi[:, held] - 1).max() > 1e-3
    # the others find their places, as shapes make up for what the held ones are wrong by
    np.testing.assert_allclose(state.omega[~held], true.omega[~held], rtol=1e-5)


def test_a_pole_is_not_given_twice_and_no_start_is_worse_than_the_one_before():
    # a block on soil: six heavily damped modes below 28 Hz, of which most have no stable pole
    rng = np.random.default_rng(8)
    f = np.r_[rng.uniform(12, 28, 6), np.linspace(150, 950, 8) + rng.uniform(-40, 40, 8), rng.uniform(1050, 2000, 6)]
    zeta = np.r_[rng.uniform(0.15, 0.3, 6), rng.uniform(0.01, 0.03, 14)]
    Phi = np.hstack([0.03 * rng.standard_normal((4, 6)), 0.06 * rng.standard_normal((4, 14))])
    truth = rb.modal_foundation(Phi, rb.from_hertz(f), zeta)
    data, _ = lines_in(noisy(truth.frf(np.arange(2.0, 1001.0, 2.0)), 0.05, 8), (6.0, 1000.0))
    whole = problem_of(rb.from_hertz(data.frequency), data.H)
    poles = truth.modes().above(150).below(1000).poles
    first, state = first_modes(whole, poles), started(whole, poles, 0.02, 16)
    assert cost(whole, state) <= cost(whole, first)
    assert (np.diff(np.sort(within(state.omega, whole.edges))) > 0).all()
