"""Real modes fitted to receptances by least squares: residuals, their derivatives, Levenberg-Marquardt.

H = sum over r of phi_r phi_r' / (omega_r^2 - w^2 + 2 i zeta_r omega_r w),   phi_r real

Parameters stand in the order phi (seats, m) row by row, log omega (m,), log zeta (m,); a shape is taken relative to its
frequency, so that a step of log omega alone leaves phi / omega as it is. What a mode far above the band does there is
phi phi' / omega^2: along such a step it hardly changes, and the valley in which the search creeps is nearly straight.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Piece = tuple[int, slice, NDArray[np.intp], Array, NDArray[np.intp] | slice, Complex]

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

# What is added to a damping matrix that is to have a Cholesky factor, as a part of it.
SINGULAR = 1e-9

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
    """Modes: Phi (seats, m) [1/sqrt(kg)], omega (m,) [rad/s], zeta (m,) [-], and how their damping is coupled.

    C = S R S, S = diag(sqrt(2 zeta omega)): of a passive foundation R is positive semidefinite with ones on its
    diagonal. R = U U' with rows of length one, each of which points along [V_a1, V_a2, ..., 1, 0, ...]. An entry of V
    (m, m) that is zero stays zero. Without V, R = I: modal damping.
    """

    Phi: Array
    omega: Array
    zeta: Array
    V: Array | None = None

    @property
    def U(self) -> Array:
        """Lower triangular, its rows of length one, (m, m)."""
        U = np.eye(len(self.omega)) + (0 if self.V is None else self.V)
        return np.asarray(U / np.linalg.norm(U, axis=1, keepdims=True))

    @property
    def C(self) -> Array:
        """Damping matrix, (m, m) [1/s]."""
        half = np.sqrt(2 * self.zeta * self.omega)[:, None] * self.U
        return np.asarray(half @ half.T)

    def only(self, keep: NDArray[np.intp] | NDArray[np.bool_]) -> "State":
        """Some of the modes, or all in another order."""
        V = None
        if self.V is not None:
            R = (self.U @ self.U.T)[keep][:, keep]
            L = np.linalg.cholesky((1 - SINGULAR) * R + SINGULAR * np.eye(len(R)))
            V = np.tril(L / np.diag(L)[:, None], -1)
        return State(self.Phi[:, keep], self.omega[keep], self.zeta[keep], V)

    def joined(self, other: "State") -> "State":
        """These modes and then the others."""
        V = None
        if self.V is not None:
            m = len(self.omega)
            V = np.zeros((m + len(other.omega),) * 2)
            V[:m, :m] = self.V
        return State(
            np.hstack([self.Phi, other.Phi]),
            np.concatenate([self.omega, other.omega]),
            np.concatenate([self.zeta, other.zeta]),
            V,
        )


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


def responses(omega: Array, state: State) -> Complex:
    """Modal coordinates under a unit force at each seat, (seats, m, n)."""
    if state.V is None:
        return np.asarray(state.Phi[:, :, None] * compliance(omega, state.omega, state.zeta))
    D = 1j * omega[:, None, None] * state.C
    D[:, range(len(state.omega)), range(len(state.omega))] += state.omega**2 - omega[:, None] ** 2
    return np.ascontiguousarray(np.linalg.solve(D, np.broadcast_to(state.Phi.T + 0j, (len(D), *state.Phi.T.shape))).T)


def receptances(problem: Problem, state: State) -> Complex:
    """The model's entries on the problem's lines, (entries, n)."""
    if state.V is None:
        g = compliance(problem.omega, state.omega, state.zeta)
        # real times complex as real times real: a quarter of the work
        return ((state.Phi[problem.rows] * state.Phi[problem.columns]) @ g.view(float)).view(complex)
    X = responses(problem.omega, state)
    H = (state.Phi @ X.view(float)).view(complex)
    return np.asarray(H[problem.columns, problem.rows])


def residuals(problem: Problem, state: State) -> Complex:
    """Weighted difference of data and model, (entries, n)."""
    return np.asarray(problem.weight * (problem.H - receptances(problem, state)))


def cost(problem: Problem, state: State) -> float:
    """Sum of the squared residuals."""
    r = residuals(problem, state)
    return float(np.vdot(r, r).real)


def jacobian(problem: Problem, state: State) -> Iterator[Piece]:
    """Derivatives size * basis[source] of the model without weights, entry by entry, in pieces of lines.

    Yields entry, lines, index (k,) of the parameters it depends on, size (k, 1), source (k,) or all, basis (., lines).
    With X the modal coordinates, H_ij = phi_i' x_j, and a change of D = K - w^2 + i w C makes -x_i' dD x_j of it.
    """
    seats, m = state.Phi.shape
    U, modes, forced = state.U, np.arange(m), -2 * (state.omega**2)[:, None]
    a, b = np.nonzero(state.V) if state.V is not None else (np.zeros(0, dtype=int),) * 2
    length = np.diag(U)[a][:, None]
    inner = seats * m + np.arange(2 * m + len(a))
    root = np.sqrt(2 * state.zeta * state.omega)[:, None]
    for start in range(0, len(problem.omega), BATCH):
        part = slice(start, start + BATCH)
        w = problem.omega[part]
        force = -1j * w * root
        if state.V is None:
            # three tangents of each mode are all that there is, at any two seats
            g = compliance(w, state.omega, state.zeta)
            damped = force * root * g * g
            tangents = np.concatenate([g, 2 * g + damped + forced * (g * g), damped])
        else:
            X = responses(w, state)
            Y = (U.T @ (root * X).view(float)).view(complex)
            T = (U @ Y.view(float)).view(complex)
            # what belongs to one seat is made once, not once an entry
            half = force / 2 * T
            other = half + state.Phi[:, :, None]
            own = forced * X + other
            turning, turned = X[:, a] * (force[a] * length), Y[:, b] - U[a, b][:, None] * T[:, a]
        for e, (i, j) in enumerate(zip(problem.rows, problem.columns, strict=True)):
            shapes = [(i, j), (j, i)] if i != j else [(i, i)]
            index = np.concatenate([*(one * m + modes for one, _ in shapes), inner])
            k = len(index) - len(inner)
            if state.V is None:
                product = state.Phi[i] * state.Phi[j]
                size = np.concatenate([*((1 + (i == j)) * state.Phi[two] for _, two in shapes), product, product])
                source = np.concatenate([*[modes] * len(shapes), m + np.arange(2 * m)])
                yield e, part, index, size[:, None], source, tangents
                continue
            J = np.empty((len(index), len(w)), dtype=complex)
            J[:k] = np.concatenate([X[j], X[i]]) if i != j else 2 * X[i]
            J[k : k + m] = own[i] * X[j] + X[i] * other[j]
            J[k + m : k + 2 * m] = X[i] * half[j] + half[i] * X[j]
            np.multiply(turning[i], turned[j], out=J[k + 2 * m :])
            J[k + 2 * m :] += turning[j] * turned[i]
            yield e, part, index, np.ones((len(index), 1)), slice(None), J


def curvature(problem: Problem, state: State, pieces: Iterable[Piece] | None = None) -> Array:
    """J'J, with J the derivative of the weighted model, over the nodes if the problem has them."""
    thin = problem.thinned()
    N = np.zeros((parameters(state),) * 2)
    for e, part, index, size, source, basis in pieces or jacobian(thin, state):
        weighted = (basis * thin.weight[e, part]).view(float)
        square = size * (weighted @ weighted.T)[source][:, source] * size[:, 0]
        # slices are added in a fraction of the time that lists of places take
        ends = [0, *(np.flatnonzero(np.diff(index) != 1) + 1), len(index)]
        runs = [(slice(p, q), slice(index[p], index[q - 1] + 1)) for p, q in pairwise(ends)]
        for here, row in runs:
            for there, column in runs:
                N[row, column] += square[here, there]
    return N


def gradient(problem: Problem, state: State, error: Complex, pieces: Iterable[Piece] | None = None) -> Array:
    """J'error for a weighted error (entries, n) on all lines: (parameters,)."""
    b = np.zeros(parameters(state))
    weighted = problem.weight * error
    for e, part, index, size, source, basis in pieces or jacobian(problem, state):
        b[index] += size[:, 0] * (basis.view(float) @ np.ascontiguousarray(weighted[e, part]).view(float))[source]
    return b


def parameters(state: State) -> int:
    """How many there are."""
    return state.Phi.size + 2 * len(state.omega) + (0 if state.V is None else int(np.count_nonzero(state.V)))


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
    moving = np.ones(parameters(state), dtype=bool)
    if held is not None:
        moving[state.Phi.size : state.Phi.size + 2 * len(held)] = np.tile(~held, 2)
    free = np.flatnonzero(moving)
    # zero where nothing moves
    whole = np.zeros(len(moving))
    # without a mode there is nothing to move
    for _ in range(iterations if len(state.omega) else 0):
        pieces = list(jacobian(thin, state))
        N = curvature(thin, state, pieces)[np.ix_(free, free)]
        b = gradient(problem, state, error, pieces if thin is problem else None)[free]
        scale = scale_of(N)
        N /= scale[:, None] * scale
        here = problem.H - error / problem.weight if thin is problem else receptances(thin, state)
        while True:
            lower = _factor(N + damping * np.eye(len(N)))
            step = linalg.lapack.dpotrs(lower, b / scale, lower=1)[0]
            whole[free] = step / scale
            bend = gradient(thin, state, _bend(thin, state, here, whole), pieces)[free]
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
    shapes, frequency, damping, coupling = np.split(step, [seats * m, (seats + 1) * m, (seats + 2) * m])
    V = None
    if state.V is not None:
        V = state.V.copy()
        # zero would stay zero
        V[V != 0] += np.where(coupling == -V[V != 0], SINGULAR, np.clip(coupling, -1, 1))
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
        V,
    )
