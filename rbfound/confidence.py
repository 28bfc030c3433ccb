"""How sure fitted modes are: the noise through the linearised fit."""

import numpy as np
from scipy import linalg

from rbfound.leastsquares import Array, Problem, State, cost, curvature, scale_of


def covariance_of(problem: Problem, state: State) -> tuple[Array, float]:
    """Covariance of phi, log omega, log zeta, and the standard deviation of a complex weighted residual."""
    N = curvature(problem, state)
    variance = _variance(problem, state)
    turn = _to_shapes(state)
    return turn @ _inverse(N) @ turn.T * variance, float(np.sqrt(2 * variance))


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
