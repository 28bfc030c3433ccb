"""Real modes fitted to receptances by least squares: residuals, their derivatives, Levenberg-Marquardt.

H = sum over r of phi_r phi_r' / (omega_r^2 - w^2 + 2 i zeta_r omega_r w),   phi_r real

Parameters stand in the order phi (seats, m) row by row, log omega (m,), log zeta (m,); a shape is taken relative to its
frequency, so that a step of log omega alone leaves phi / omega as it is. What a mode far above the band does there is
phi phi' / omega^2: along such a step it hardly changes, and the valley in which the search creeps is nearly straight.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Bounds of the damping ratio of any mode, and of its frequency in parts of the band's lower and upper edge: what lies
# beyond cannot be told from a mass or from a spring.
LIGHT, HEAVY = 1e-5, 0.5
NEAR_ZERO, FAR = 0.02, 30.0

# A receptance counts as zero below this part of sqrt(|H_ii H_jj|): there its own size is no measure of its error.
NOTHING = 1e-4

# A second-order part of a step that is longer than this part of it is left out; how far its probe looks ahead.
STRAIGHT, PROBE = 0.375, 0.1

# The least damping of a step: at that the scaled J'J still has a Cholesky factor, rounding or not.
LEAST = 1e-12

# The damping of a first step: far from the end, and near it, where the way along the valley is known.
CAREFUL, SURE = 1e-3, 1e-6

# No mode comes nearer to an edge of the band than this part of it.
APART = 1e-6

# Poles that are nearer to each other than this part of their damping -Re lambda are one repeated pole to the
# data: noise or rounding decides which combination of the shapes belongs to which of them.
ALIKE = 0.3

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
    edges : (lowest, highest) [rad/s]
        Of the band: its first line and its last, of the nodes too.
    averaging : float
        By how much the mean of H_ij and H_ji is surer than either: sqrt(2), or 1 if they are one measurement.
    nodes : Problem
        The same on fewer lines, each of which weighs as much as those it stands for. Modes are looked for there, and
        sums that hold no data, J'J above all, are taken there. Residuals, J'r and where the fit ends are those of all.
    least : float
        The noise is no less than this, however alike neighbouring lines are: 1 where the errors are known.
    """

    omega: Array
    H: Complex
    weight: Array
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    edges: tuple[float, float]
    averaging: float = 1.0
    nodes: "Problem | None" = None
    least: float = 0.0

    def thinned(self) -> "Problem":
        """The nodes; all lines if there are none."""
        return self.nodes or self


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


def groups_of(poles: Complex, alike: float = ALIKE) -> list[NDArray[np.intp]]:
    """Indices of the poles that cannot be told from a repeated pole, group by group, ascending in frequency.

    Neighbours belong together when they are nearer than `alike` times the damping -Re lambda of the lighter one.
    """
    order = np.argsort(np.abs(poles))
    if not len(order):
        return []
    damping, apart = -poles.real[order], np.abs(np.diff(poles[order]))
    ends = np.flatnonzero(apart >= alike * np.minimum(damping[1:], damping[:-1])) + 1
    return np.split(order, ends)


def problem_of(omega: Array, H: Complex, relative: bool = True, errors: Array | None = None) -> Problem:
    """The problem of fitting H (n, seats, seats), with weights for an error of |H|, or for one error everywhere.

    The mean of H_ij and H_ji has half the variance of either, unless they are one measurement written twice. With
    `errors` (n, seats, seats), one for each, the weights are theirs.
    """
    rows, columns = np.triu_indices(H.shape[1])
    mean = ((H + H.transpose(0, 2, 1)) / 2)[:, rows, columns].T.copy()
    averaging = 1.0 if np.array_equal(H, H.transpose(0, 2, 1)) else float(np.sqrt(2))
    if errors is not None:
        size = np.hypot(errors, errors.transpose(0, 2, 1))[:, rows, columns].T / np.sqrt(2)
    elif relative:
        size = size_of(mean, rows, columns)
    else:
        size = np.full(mean.shape, np.sqrt(np.mean(np.abs(mean) ** 2)))
    weight = np.where(rows != columns, averaging, 1.0)[:, None] / size
    edges = float(omega[0]), float(omega[-1])
    return Problem(omega, mean, weight, rows, columns, edges, averaging, least=float(errors is not None))


def size_of(H: Complex, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
    """|H| of each entry and line, (entries, n), not below what counts as zero there."""
    size = np.abs(H)
    point = size[rows == columns]
    driving = np.sqrt(point[rows] * point[columns])
    return np.asarray(np.maximum(np.maximum(size, NOTHING * driving), 1e-12 * size.max() + np.finfo(float).tiny))


def compliance(omega: Array, own: Array, zeta: Array) -> Complex:
    """1 / (own^2 - omega^2 + 2 i zeta own omega) of each mode, (m, n)."""
    # real and imaginary part by hand: a complex division takes five times as long
    real, damper = (own**2)[:, None] - omega**2, (2 * zeta * own)[:, None] * omega
    size = 1 / (real * real + damper * damper)
    g = np.empty(real.shape, dtype=complex)
    g.real, g.imag = real * size, -damper * size
    return g


def tangents(omega: Array, state: State) -> Complex:
    """Compliance of each mode and the derivatives of phi phi' g by log omega and log zeta, over phi phi', (m, 3, n)."""
    own, zeta = state.omega[:, None], state.zeta[:, None]
    g = compliance(omega, state.omega, state.zeta)
    damper = 2j * zeta * own * omega
    # 2 g: with log omega the shape grows too
    square = g * g
    return np.stack([g, 2 * g - square * (2 * own**2 + damper), -square * damper], axis=1)


def receptances(problem: Problem, state: State) -> Complex:
    """The model's entries on the problem's lines, (entries, n)."""
    g = compliance(problem.omega, state.omega, state.zeta)
    # real times complex as real times real: a quarter of the work
    return ((state.Phi[problem.rows] * state.Phi[problem.columns]) @ g.view(float)).view(complex)


def residuals(problem: Problem, state: State) -> Complex:
    """Weighted difference of data and model, (entries, n)."""
    return np.asarray(problem.weight * (problem.H - receptances(problem, state)))


def cost(problem: Problem, state: State) -> float:
    """Sum of the squared residuals."""
    r = residuals(problem, state)
    return float(np.vdot(r, r).real)


def curvature(problem: Problem, state: State) -> Array:
    """J'J, with J the derivative of the weighted model, over the nodes if the problem has them.

    Entry (i, j) depends on phi_i, phi_j, omega and zeta only, through the three tangents of each mode; so that the sums
    over the lines are those of 3 m columns, whatever the number of seats.
    """
    problem = problem.thinned()
    entries, m = len(problem.rows), len(state.omega)
    gram = np.zeros((entries, 3 * m, 3 * m))
    for part in _batches(problem):
        basis = tangents(problem.omega[part], state).reshape(3 * m, -1)
        for e, weight in enumerate(problem.weight[:, part]):
            weighted = (basis * weight).view(float)
            gram[e] += weighted @ weighted.T
    C = chain(state, problem.rows, problem.columns)
    parameters = C.shape[2]
    # the parameters take the place of the tangents, first on one side, then on the other
    half = np.matmul(C, gram.reshape(entries, m, 3, 3 * m)).reshape(entries, m * parameters, m, 3)
    half = half.transpose(2, 1, 0, 3).reshape(m, m * parameters, 3 * entries)
    other = C.transpose(1, 0, 3, 2).reshape(m, 3 * entries, parameters)
    N = np.matmul(half, other).reshape(m, m, parameters, parameters).transpose(2, 1, 3, 0)
    return N.reshape(parameters * m, parameters * m)


def gradient(problem: Problem, state: State, error: Complex) -> Array:
    """J'error for a weighted error (entries, n) on all lines: (parameters,)."""
    entries, m = len(problem.rows), len(state.omega)
    along = np.zeros((entries, 3 * m))
    for part in _batches(problem):
        basis = tangents(problem.omega[part], state).reshape(3 * m, -1)
        # real parts times real parts and imaginary parts times imaginary parts, summed over the lines
        along += (problem.weight[:, part] * error[:, part]).view(float) @ basis.view(float).T
    out = np.matmul(chain(state, problem.rows, problem.columns), along.reshape(entries, m, 3, 1))
    return out.sum(axis=0)[..., 0].T.ravel()


def _batches(problem: Problem) -> list[slice]:
    return [slice(start, start + BATCH) for start in range(0, len(problem.omega), BATCH)]


def chain(state: State, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
    """How each entry depends on the parameters of each mode through its tangents, (entries, m, seats + 2, 3)."""
    seats, m = state.Phi.shape
    C = np.zeros((len(rows), m, seats + 2, 3))
    every = np.arange(len(rows))
    C[every, :, rows, 0] = state.Phi[columns]
    # on the diagonal both are the same parameter
    C[every, :, columns, 0] += state.Phi[rows]
    C[:, :, seats, 1] = C[:, :, seats + 1, 2] = state.Phi[rows] * state.Phi[columns]
    return C


def refine(
    problem: Problem,
    state: State,
    *,
    small: float,
    rough: float = 0.0,
    damping: float = CAREFUL,
    iterations: int = 60,
    held: NDArray[np.bool_] | None = None,
) -> tuple[State, float]:
    """Levenberg-Marquardt, scaled by the diagonal of J'J: the modes and what is left of the cost.

    Plain Gauss-Newton overshoots: what lies above the band is ill-determined mode by mode, though its sum is not. Each
    step follows the bend of the valley to second order: geodesic acceleration, Transtrum and Sethna 2012,
    arXiv:1201.5885.

    Parameters
    ----------
    small, rough : float
        A step that lowers the cost by less, or by less than this part of it, ends the search.
    damping : float
        What is added to the scaled J'J in the first step.
    held : (m,) bool
        Modes of which the shape alone moves. Of many pseudo-modes that is enough to make up any sum, and without their
        frequencies there is hardly a valley.
    """
    factor = 2.0
    error, thin = residuals(problem, state), problem.thinned()
    now = float(np.vdot(error, error).real)
    own = np.ones(len(state.omega), dtype=bool) if held is None else ~held
    free = np.flatnonzero(np.concatenate([np.ones(state.Phi.size, dtype=bool), own, own]))
    # zero where nothing moves
    whole = np.zeros(state.Phi.size + 2 * len(own))
    # without a mode there is nothing to move
    for _ in range(iterations if len(state.omega) else 0):
        N, b = curvature(problem, state)[np.ix_(free, free)], gradient(problem, state, error)[free]
        scale = scale_of(N)
        N /= scale[:, None] * scale
        here = receptances(thin, state)
        while True:
            lower = _factor(N + damping * np.eye(len(N)))
            step = linalg.lapack.dpotrs(lower, b / scale, lower=1)[0]
            whole[free] = step / scale
            bend = gradient(thin, state, _bend(thin, state, here, whole))[free]
            turn = linalg.lapack.dpotrs(lower, bend / scale, lower=1)[0] / 2
            straight = np.linalg.norm(turn) > STRAIGHT * np.linalg.norm(step)
            whole[free] = (step if straight else step + turn) / scale
            trial = moved(problem, state, whole)
            left = residuals(problem, trial)
            then = float(np.vdot(left, left).real)
            if then <= now:
                break
            damping, factor = damping * factor, 2 * factor
            if damping > 1e8:
                return state, now
        expected = step @ (b / scale) + damping * step @ step
        agreement = (now - then) / expected if expected > 0 else 1.0
        damping = max(damping * max(0.2, 1 - (2 * agreement - 1) ** 3), LEAST)
        decrease = now - then
        factor, state, error, now = 2.0, trial, left, then
        if decrease <= max(small, rough * now):
            break
    return state, now


def _factor(A: Array) -> Array:
    """Lower Cholesky factor. LAPACK by hand: the matrices are small, and the wrapper takes as long as the work."""
    lower, failed = linalg.lapack.dpotrf(A, lower=1, overwrite_a=1)
    if failed:
        raise np.linalg.LinAlgError("J'J has no Cholesky factor: a parameter is not finite.")
    return np.asarray(lower)


def _bend(problem: Problem, state: State, here: Complex, step: Array) -> Complex:
    """Second derivative of the weighted residuals along a step, (entries, n), by central differences about `here`."""
    ahead, behind = (receptances(problem, moved(problem, state, part * step)) for part in (PROBE, -PROBE))
    return np.asarray(problem.weight * (2 * here - ahead - behind) / PROBE**2)


def scale_of(N: Array) -> Array:
    """Roots of the diagonal: the size of each column of J, (parameters,)."""
    diagonal = np.diag(N)
    return np.sqrt(np.maximum(diagonal, 1e-30 * diagonal.max() + np.finfo(float).tiny))


def moved(problem: Problem, state: State, step: Array) -> State:
    """The modes after a step of the parameters; a long one is cut, frequency and damping stay in their bounds.

    A step takes no mode across an edge of the band, at most half of the way there: inside and outside are different
    things, and a first step is easily too long.
    """
    seats, m = state.Phi.shape
    shapes, frequency, damping = step[: seats * m], step[seats * m : -m], step[-m:]
    low, high = problem.edges
    omega = state.omega * np.exp(np.clip(frequency, -0.5, 0.5))
    for edge in (low, high):
        # half of the way, over and over, would end on the edge
        half, side = np.sqrt(state.omega * edge), np.where(state.omega > edge, 1, -1)
        nearest = side * np.maximum(side * half, side * edge * (1 + side * APART))
        omega = side * np.maximum(side * omega, side * nearest)
    omega = np.clip(omega, NEAR_ZERO * low, FAR * high)
    return State(
        (state.Phi + shapes.reshape(seats, m)) * (omega / state.omega),
        omega,
        np.clip(state.zeta * np.exp(np.clip(damping, -1, 1)), LIGHT, HEAVY),
    )


def noise_of(problem: Problem, state: State) -> float:
    """Standard deviation of the weighted error, from how much it changes from line to line.

    A mode that the model lacks makes the error large but smooth, and leaves this number as it is. The median stands for
    the mean square, ln 2 of it for complex normal errors: a resonance narrower than the lines spoils few of them.
    """
    r = residuals(problem, state)
    if r.shape[1] < 3:
        return max(float(np.sqrt(np.mean(np.abs(r) ** 2))), problem.least)
    bend = r[:, 1:-1] - (r[:, 2:] + r[:, :-2]) / 2
    return max(float(np.sqrt(np.median(np.abs(bend) ** 2) / (1.5 * np.log(2)))), problem.least)
