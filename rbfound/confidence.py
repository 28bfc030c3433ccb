"""How sure fitted modes are: the noise through the linearised fit, and what noise can hide outside the band."""

import numpy as np
from scipy import linalg

from rbfound.additions import bordered
from rbfound.leastsquares import Array, Problem, State, cost, curvature, scale_of

# Outside the band the data are matched by no more pseudo-modes than noise lets show. What it hides is small, but leans
# on the modes that are there. Residues that are free at these parts of the lower and multiples of the upper edge stand
# for it.
HIDDEN_BELOW, HIDDEN_ABOVE = (0.5,), (1.005, 1.02, 1.05, 1.1, 1.2, 1.4, 1.8, 2.5, 5.0, 10.0)


def covariance_of(problem: Problem, state: State) -> tuple[Array, float]:
    """Covariance of phi, log omega, log zeta, and the standard deviation of a complex weighted residual."""
    N = curvature(problem, state)
    variance = _variance(problem, state)
    turn = _to_shapes(state)
    return turn @ _inverse(N) @ turn.T * variance, float(np.sqrt(2 * variance))


def hidden_places(problem: Problem) -> Array:
    """Frequencies of the residues that stand for what noise can hide [rad/s]."""
    low, high = problem.edges
    return np.concatenate([low * np.array(HIDDEN_BELOW), high * np.array(HIDDEN_ABOVE)])


def wide_covariance(problem: Problem, state: State, places: Array, zeta: float) -> Array:
    """Covariance of phi, log omega, log zeta and then the entries i <= j of a free symmetric residue at each place.

    Of a fit to which these residues had been added. They are zero as far as the data tell, and the parameters are known
    no better than with them.
    """
    A = bordered(problem, state, places, np.full(len(places), zeta))[0]
    shapes = _to_shapes(state)
    turn = linalg.block_diag(shapes, np.eye(len(A) - len(shapes)))
    return np.asarray(turn @ _inverse(A) @ turn.T * _variance(problem, state))


def _variance(problem: Problem, state: State) -> float:
    """Of the real part of a weighted residual; the imaginary part has the same."""
    numbers = 2 * problem.H.size
    parameters = state.Phi.size + 2 * len(state.omega)
    return cost(problem, state) / max(numbers - parameters, 1)


def _inverse(N: Array) -> Array:
    scale = scale_of(N)
    return np.asarray(linalg.pinvh(N / scale[:, None] / scale, rtol=1e-13) / scale[:, None] / scale)


def _to_shapes(state: State) -> Array:
    """From shapes relative to their frequency, as the fit has them, to shapes."""
    seats, m = state.Phi.shape
    turn = np.eye((seats + 2) * m)
    for i, row in enumerate(state.Phi):
        turn[i * m : (i + 1) * m, seats * m : -m] = np.diag(row)
    return turn
