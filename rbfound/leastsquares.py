"""Real modes fitted to receptances by least squares: residuals, their derivatives, Levenberg-Marquardt.

H = sum over r of phi_r phi_r' / (omega_r^2 - w^2 + 2 i zeta_r omega_r w),   phi_r real

Parameters stand in the order phi (seats, m) row by row, log omega (m,), log zeta (m,).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Bounds of the damping ratio of any mode.
LIGHT, HEAVY = 1e-5, 0.5

# A receptance counts as zero below this part of sqrt(|H_ii H_jj|): there its own size is no measure of its error.
NOTHING = 1e-4

# Lines in one piece of the normal equations: keeps what is in memory at a time to a few megabytes.
BATCH = 2048


@dataclass(frozen=True, eq=False)
class Problem:
    """What is fitted: the entries i <= j of the symmetric part of H.

    Attributes
    ----------
    omega : (n,) [rad/s]
    H : (entries, n) complex [m/N]
    weight : (entries, n) [N/m]
        One over the standard deviation of each entry, but for one common factor, the noise.
    rows, columns : (entries,)
        i and j of each entry.
    averaging : float
        By how much the mean of H_ij and H_ji is surer than either: sqrt(2), or 1 if they are one measurement.
    """

    omega: Array
    H: Complex
    weight: Array
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    averaging: float = 1.0

    def at(self, lines: NDArray[np.intp], share: Array) -> "Problem":
        """Some of the lines, each standing for as many as `share` says."""
        weight = self.weight[:, lines] * np.sqrt(share)
        return replace(self, omega=self.omega[lines], H=self.H[:, lines], weight=weight)


@dataclass(frozen=True, eq=False)
class State:
    """Modes: Phi (seats, m) [1/sqrt(kg)], omega (m,) [rad/s], zeta (m,) [-]."""

    Phi: Array
    omega: Array
    zeta: Array

    def only(self, keep: NDArray[np.intp] | NDArray[np.bool_]) -> "State":
        """Some of the modes, or all in another order."""
        return State(self.Phi[:, keep], self.omega[keep], self.zeta[keep])

    def joined(self, other: "State") -> "State":
        """These modes and then the others."""
        return State(
            np.hstack([self.Phi, other.Phi]),
            np.concatenate([self.omega, other.omega]),
            np.concatenate([self.zeta, other.zeta]),
        )


def problem_of(omega: Array, H: Complex, relative: bool = True) -> Problem:
    """The problem of fitting H (n, seats, seats), with weights for an error of |H|, or for one error everywhere.

    The mean of H_ij and H_ji has half the variance of either, unless they are one measurement written twice.
    """
    rows, columns = np.triu_indices(H.shape[1])
    mean = ((H + H.transpose(0, 2, 1)) / 2)[:, rows, columns].T.copy()
    averaging = 1.0 if np.array_equal(H, H.transpose(0, 2, 1)) else float(np.sqrt(2))
    size = size_of(mean, rows, columns) if relative else np.full(mean.shape, np.sqrt(np.mean(np.abs(mean) ** 2)))
    weight = np.where(rows != columns, averaging, 1.0)[:, None] / size
    return Problem(omega, mean, weight, rows, columns, averaging)


def size_of(H: Complex, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
    """|H| of each entry and line, (entries, n), not below what counts as zero there."""
    size = np.abs(H)
    point = size[rows == columns]
    driving = np.sqrt(point[rows] * point[columns])
    return np.asarray(np.maximum(np.maximum(size, NOTHING * driving), 1e-12 * size.max() + np.finfo(float).tiny))


def compliance(omega: Array, own: Array, zeta: Array) -> Complex:
    """1 / (own^2 - omega^2 + 2 i zeta own omega) of each mode, (m, n)."""
    own, zeta = own[:, None], zeta[:, None]
    return np.asarray(1 / (own**2 - omega**2 + 2j * zeta * own * omega))


def tangents(omega: Array, state: State) -> Complex:
    """Compliance of each mode and its derivatives by log omega and log zeta, (3, m, n)."""
    own, zeta = state.omega[:, None], state.zeta[:, None]
    g = compliance(omega, state.omega, state.zeta)
    damper = 2j * zeta * own * omega
    return np.stack([g, -(g**2) * (2 * own**2 + damper), -(g**2) * damper])


def receptances(problem: Problem, state: State) -> Complex:
    """The model's entries on the problem's lines, (entries, n)."""
    g = compliance(problem.omega, state.omega, state.zeta)
    return np.asarray((state.Phi[problem.rows] * state.Phi[problem.columns]) @ g)


def residuals(problem: Problem, state: State) -> Complex:
    """Weighted difference of data and model, (entries, n)."""
    return np.asarray(problem.weight * (problem.H - receptances(problem, state)))


def cost(problem: Problem, state: State) -> float:
    """Sum of the squared residuals."""
    r = residuals(problem, state)
    return float(np.vdot(r, r).real)


def normal_equations(problem: Problem, state: State) -> tuple[Array, Array, float]:
    """J'J, J'r and r'r of the residuals r = data - model, with J the derivative of the weighted model.

    Entry (i, j) depends on phi_i, phi_j, omega and zeta only, through the three tangents of each mode; so that the sums
    over the lines are those of 3 m columns, whatever the number of seats.
    """
    seats, m = state.Phi.shape
    N, gradient, total = np.zeros((seats + 2, m, seats + 2, m)), np.zeros((seats + 2, m)), 0.0
    for start in range(0, len(problem.omega), BATCH):
        part = slice(start, start + BATCH)
        basis = tangents(problem.omega[part], state)
        model = (state.Phi[problem.rows] * state.Phi[problem.columns]) @ basis[0]
        error = problem.weight[:, part] * (problem.H[:, part] - model)
        total += float(np.vdot(error, error).real)
        for e, (i, j) in enumerate(zip(problem.rows, problem.columns, strict=True)):
            weighted = (basis * problem.weight[e, part]).reshape(3 * m, -1).view(float)
            gram = (weighted @ weighted.T).reshape(3, m, 3, m)
            along = (weighted @ error[e].view(float)).reshape(3, m)
            terms = chain(state, int(i), int(j))
            for a, p, ca in terms:
                gradient[a] += ca * along[p]
                for b, q, cb in terms:
                    N[a, :, b, :] += ca[:, None] * gram[p, :, q, :] * cb
    size = (seats + 2) * m
    return N.reshape(size, size), gradient.ravel(), total


def chain(state: State, i: int, j: int) -> list[tuple[int, int, Array]]:
    """How entry (i, j) depends on the parameters: (row of parameters, which tangent, factor of each mode)."""
    seats = len(state.Phi)
    both = state.Phi[i] * state.Phi[j]
    return [(i, 0, state.Phi[j]), (j, 0, state.Phi[i]), (seats, 1, both), (seats + 1, 2, both)]


def refine(problem: Problem, state: State, *, small: float, iterations: int = 60) -> tuple[State, float]:
    """Levenberg-Marquardt, scaled by the diagonal of J'J: the modes and what is left of the cost.

    Plain Gauss-Newton overshoots: what lies above the band is ill-determined mode by mode, though its sum is not.

    Parameters
    ----------
    small : float
        A step that lowers the cost by less ends the search.
    """
    damping, factor = 1e-3, 2.0
    N, b, now = normal_equations(problem, state)
    for _ in range(iterations):
        scale = scale_of(N)
        values, vectors = linalg.eigh(N / scale[:, None] / scale)
        along = vectors.T @ (b / scale)
        while True:
            step = vectors @ (along / (np.maximum(values, 0) + damping))
            trial = moved(state, step / scale)
            then = cost(problem, trial)
            if then <= now:
                break
            damping, factor = damping * factor, 2 * factor
            if damping > 1e8:
                return state, now
        expected = step @ (b / scale) + damping * step @ step
        agreement = (now - then) / expected if expected > 0 else 1.0
        damping = max(damping * max(0.2, 1 - (2 * agreement - 1) ** 3), 1e-14)
        factor, state, decrease = 2.0, trial, now - then
        if decrease <= small:
            return state, then
        N, b, now = normal_equations(problem, state)
    return state, now


def scale_of(N: Array) -> Array:
    """Roots of the diagonal: the size of each column of J, (parameters,)."""
    diagonal = np.diag(N)
    return np.sqrt(np.maximum(diagonal, 1e-30 * diagonal.max() + np.finfo(float).tiny))


def moved(state: State, step: Array) -> State:
    """The modes after a step of the parameters; a long one is cut, damping stays in its bounds."""
    seats, m = state.Phi.shape
    shapes, frequency, damping = step[: seats * m], step[seats * m : -m], step[-m:]
    return State(
        state.Phi + shapes.reshape(seats, m),
        state.omega * np.exp(np.clip(frequency, -0.2, 0.2)),
        np.clip(state.zeta * np.exp(np.clip(damping, -1, 1)), LIGHT, HEAVY),
    )


def noise_of(problem: Problem, state: State) -> float:
    """Standard deviation of the weighted error, from how much it changes from line to line.

    A mode that the model lacks makes the error large but smooth, and leaves this number as it is. The median stands for
    the mean square, ln 2 of it for complex normal errors: a resonance narrower than the lines spoils few of them.
    """
    r = residuals(problem, state)
    if r.shape[1] < 3:
        return float(np.sqrt(np.mean(np.abs(r) ** 2)))
    bend = r[:, 1:-1] - (r[:, 2:] + r[:, :-2]) / 2
    return float(np.sqrt(np.median(np.abs(bend) ** 2) / (1.5 * np.log(2))))
