"""What lies above the band, found at once: the best of a convex problem, passive, and few modes in the end."""

from pathlib import Path

import numpy as np
import pytest
from samples import BAND, LINES, noisy
from scipy import optimize

import rbfound as rb
from rbfound.identification.added_modes import (
    MOST,
    SCARCE,
    SPARE,
    _best,
    _few,
    arranged,
    bordered,
    symmetric,
)
from rbfound.identification.least_squares import State, cost, problem_of, refine
from rbfound.identification.lsfd import first_modes
from rbfound.identification.plscf import lines_in
from rbfound.measurement.noise import CLEAN

TRUTH = rb.load_foundation(Path(__file__).parents[2] / "data" / "foundation" / "truth.npz")


def modes_of(foundation):
    omega, V = rb.theory.normal_modes(foundation.M, foundation.K)
    return State(foundation.B @ V, omega, np.diag(V.T @ foundation.C @ V) / (2 * omega))


def solid(level=0.01, seed=17):
    """The problem, the true modes, and those of the band alone."""
    data, _ = lines_in(noisy(TRUTH.frf(LINES), level, seed), BAND)
    true = modes_of(TRUTH)
    return problem_of(rb.from_hertz(data.frequency), data.H), true, true.only(rb.hertz(true.omega) < BAND[1])


def test_no_residues_are_better_says_the_gap_to_the_dual():
    # at the best x the slope of each residue is a positive semidefinite matrix that is orthogonal to it; the traces of
    # their products bound what any other x could gain (Boyd and Vandenberghe, section 5.9)
    problem, _, own = solid()
    places = rb.from_hertz(np.array([6.0, 1050.0, 1200.0, 1500.0, 3000.0, 20000.0]))
    A, b = bordered(problem, own, places, np.full(6, 0.02))
    gap = 1e-3
    x = _best(problem, A, b, 6, gap)
    R = symmetric(problem, x[-60:].reshape(6, -1))
    slope = 2 * (A @ x - b)
    half = np.where(problem.rows == problem.columns, 1.0, 0.5)
    S = symmetric(problem, slope[-60:].reshape(6, -1) * half)
    assert (np.linalg.eigvalsh(R) > 0).all()
    assert (np.linalg.eigvalsh(S) > 0).all()
    assert np.einsum("kij,kij->", S, R) < 3 * gap
    size = np.sqrt(np.diag(A))[:-60]
    assert np.abs(slope[:-60] / size).max() < 1e-2


def test_at_one_seat_it_is_least_squares_with_positive_numbers():
    truth = rb.modal_foundation([[0.1, 0.2, 0.3]], rb.from_hertz(np.array([100.0, 700.0, 900.0])), [0.02] * 3, ("x1",))
    data = noisy(truth.frf(np.arange(20.0, 500.0)), 0.01)
    problem = problem_of(rb.from_hertz(data.frequency), data.H)
    own = modes_of(truth).only(np.array([0]))
    places = rb.from_hertz(np.array([510.0, 600.0, 800.0, 1000.0, 4000.0]))
    A, b = bordered(problem, own, places, np.full(5, 0.02))
    x = _best(problem, A, b, 5, 1e-4)
    # the steps of the mode may have either sign
    least = np.where(np.arange(len(A)) < len(A) - 5, -np.inf, 0.0)
    unit = 1 / np.sqrt(np.diag(A))
    L = np.linalg.cholesky(A * unit[:, None] * unit + 1e-13 * np.eye(len(A)))
    lsq = optimize.lsq_linear(L.T, np.linalg.solve(L, b * unit), (least, np.full(len(A), np.inf)), tol=1e-14)
    value = lsq.x @ (A * unit[:, None] * unit) @ lsq.x - 2 * b @ (unit * lsq.x)
    assert x @ A @ x - 2 * b @ x == pytest.approx(value, abs=2e-4)


def undamped(state, omega):
    return (state.Phi / (state.omega**2 - omega**2)) @ state.Phi.T


def test_few_modes_answer_as_many_at_the_frequencies_they_were_made_for():
    rng = np.random.default_rng(0)
    omega = np.repeat(rb.from_hertz(np.linspace(1010, 5000, 10)), 4)
    many = State(rng.standard_normal((4, 40)), omega, np.full(40, 0.02))
    high = rb.from_hertz(1000.0)
    few = _few(many, high * np.array(SPARE), np.ones(4), 0.0)
    assert few.omega.shape == (4 * len(SPARE),)
    assert (few.omega > high).all()
    assert ((few.zeta > 0.5 * 0.02) & (few.zeta < 2 * 0.02)).all()

    for part in SPARE:
        # the value and, as it is a congruence, the slope too
        near = [undamped(s, part * high) for s in (few, many)]
        np.testing.assert_allclose(near[0], near[1], rtol=1e-8, atol=1e-8 * np.abs(near[1]).max())
        h = 1e-4 * high
        slopes = [undamped(s, part * high + h) - undamped(s, part * high - h) for s in (few, many)]
        np.testing.assert_allclose(slopes[0], slopes[1], atol=1e-5 * np.abs(slopes[1]).max())


def test_modes_are_left_out_that_do_less_than_what_counts():
    rng = np.random.default_rng(1)
    omega = np.repeat(rb.from_hertz(np.linspace(1010, 5000, 10)), 4)
    many = State(rng.standard_normal((4, 40)), omega, np.full(40, 0.02))
    high, unit = rb.from_hertz(1000.0), np.array([1.0, 3.0, 0.1, 10.0])
    whole = _few(many, high * np.array(SPARE), unit, 0.0)
    answers = np.hstack([(many.Phi / many.omega * unit[:, None] / (1 - (w * high / omega) ** 2)).T for w in SPARE])
    size = np.linalg.svd(answers, compute_uv=False)
    few = _few(many, high * np.array(SPARE), unit, 1.001 * size[7])
    assert len(few.omega) == 7 < len(whole.omega)
    for part in SPARE:
        lost = (undamped(many, part * high) - undamped(few, part * high)) * unit[:, None] * unit
        # it is a congruence: what is lost is positive semidefinite, and smaller than the next direction squared
        values = np.linalg.eigvalsh(lost)
        assert values[0] > -1e-9 * size[0] ** 2
        assert values[-1] < size[7] ** 2


@pytest.mark.parametrize("seed", range(4))
def test_one_mode_a_seat_is_a_short_way_from_the_truth_where_there_are_no_more(seed):
    shapes = 0.1 * np.random.default_rng(seed).standard_normal((4, 6))
    omega = rb.from_hertz(np.array([100.0, 600.0, 1150.0, 1500.0, 2100.0, 3000.0]))
    truth = rb.modal_foundation(shapes, omega, [0.02] * 6)
    data = truth.frf(np.arange(20.0, 1000.5))
    problem, true = problem_of(rb.from_hertz(data.frequency), data.H), modes_of(truth)
    found = arranged(problem, true.only(np.arange(2)), 0.02, 1e-8, SCARCE)
    assert found.omega.shape == true.omega.shape
    _, left = refine(problem, found, small=1e-9, iterations=10)
    # noise below a thousandth of |H| is called clean; one pseudo-mode a seat at a static remainder is not there by then
    assert np.sqrt(left / problem.H.size) < CLEAN
    static = first_modes(problem, truth.modes().poles[:2])
    _, left = refine(problem, static, small=1e-9, iterations=10)
    assert np.sqrt(left / problem.H.size) > CLEAN


def test_it_fits_the_noise_of_the_solid_model_as_well_as_the_truth_does():
    # twenty modes above the band, five of them within 30 % of its edge: pseudo-modes that are added one by one end at
    # 250 in this measure; noise alone lowers it by one a parameter, some eighty to a hundred and thirty of them at work
    problem, true, own = solid()
    state, left = refine(problem, arranged(problem, own, 0.02, 1e-4), small=1e-6, iterations=60)
    assert len(state.omega) < len(true.omega)
    assert (left - cost(problem, true)) / (0.01**2 / 2) < -60


def test_its_damping_need_not_be_known():
    problem, true, own = solid()
    for zeta in (0.012, 0.03):
        _, left = refine(problem, arranged(problem, own, zeta, 1e-4), small=1e-6, iterations=60)
        assert (left - cost(problem, true)) / (0.01**2 / 2) < -60


def test_beside_no_mode_there_is_none():
    problem, _, own = solid()
    assert arranged(problem, own.only(np.arange(0)), 0.02, 1e-6) is None


def test_for_too_many_seats_there_is_none():
    seats = 12
    omega = rb.from_hertz(np.linspace(100, 300, seats))
    many = rb.modal_foundation(np.eye(seats), omega, [0.02] * seats, tuple("abcdefghijkl"))
    frf = many.frf(np.arange(20.0, 400.0, 5.0))
    problem = problem_of(rb.from_hertz(frf.frequency), frf.H)
    assert len(problem.rows) * 16 > MOST
    assert arranged(problem, modes_of(many), 0.02, 1e-6) is None
