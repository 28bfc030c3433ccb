"""Where the modes of a fit come from: known poles, pseudo-modes of the remainder, and the mode that is missing."""

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

from rbfound.identification.least_squares import (
    Array,
    Problem,
    State,
    compliance,
    cost,
    curvature,
    gradient,
    jacobian,
    moved,
    parameters,
    residuals,
    scale_of,
)
from rbfound.identification.lsfd import level_of, repeated_modes

# Where pseudo-modes are tried: parts of the band's lower edge, multiples of its upper edge.
BELOW = (0.3, 0.7)


ABOVE = (1.01, 1.03, 1.06, 1.1, 1.15, 1.2, 1.3, 1.45, 1.6, 2.0, 3.0, 5.0, 10.0)


# A mode that is damped more is no mode of the band, but a part of the remainder.
REMAINDER = 0.3


# How often a candidate's shape is improved.
ALTERNATIONS = 6


def candidates(low: float, high: float, zeta: float) -> Array:
    """Frequencies at which a missing mode is looked for [rad/s]: below, in and above a band, as dense as zeta asks."""
    count = int(np.clip(np.log(high / low) / (2 * zeta), 20, 300))
    return np.concatenate([low * np.array(BELOW), np.geomspace(low, high, count), high * np.array(ABOVE)])


def in_band(omega: Array, edges: tuple[float, float]) -> NDArray[np.bool_]:
    """Which frequencies lie in the band."""
    return (omega >= edges[0]) & (omega <= edges[1])


def within(omega: Array, edges: tuple[float, float]) -> Array:
    """Those frequencies that lie in the band."""
    return omega[in_band(omega, edges)]


def inside(state: State, edges: tuple[float, float]) -> NDArray[np.bool_]:
    """Which modes are those of the band, (m,)."""
    return in_band(state.omega, edges) & (state.zeta < REMAINDER)


def without_weakest(problem: Problem, state: State, group: NDArray[np.intp]) -> State:
    """The modes with one less in a group: its shapes are the strongest combinations of those that there are."""
    level = level_of(problem)
    Phi = state.Phi[:, group] * level[:, None]
    square = float(np.mean(state.omega[group] ** 2))
    slope = -(Phi * (state.omega[group] ** 2 - square)) @ Phi.T
    shapes, shift = repeated_modes(Phi @ Phi.T, slope, len(group) - 1)
    low, high = state.omega[group].min(), state.omega[group].max()
    omega = np.clip(np.sqrt(np.maximum(square + shift, low**2)), low, high)
    fewer = State(shapes / level[:, None], omega, np.full(len(omega), np.mean(state.zeta[group])))
    return state.only(np.setdiff1d(np.arange(len(state.omega)), group)).joined(fewer)


def weight_of(problem: Problem, state: State) -> Array:
    """Sum of the squares of what each mode alone does to the weighted receptances, (m,)."""
    thin = problem.thinned()
    g = np.abs(compliance(thin.omega, state.omega, state.zeta)) ** 2
    product = (state.Phi[thin.rows] * state.Phi[thin.columns]) ** 2
    return np.asarray((product * (thin.weight**2 @ g.T)).sum(axis=0))


def prominence_of(problem: Problem, state: State) -> Array:
    """The largest weighted receptance that each mode alone has on any line, (m,)."""
    g = np.abs(compliance(problem.omega, state.omega, state.zeta))
    product = np.abs(state.Phi[problem.rows] * state.Phi[problem.columns])
    return np.asarray([(problem.weight * product[:, [k]] * g[k]).max() for k in range(len(g))])


def deviation_of(state: State, covariance: Array) -> tuple[Array, Array]:
    """Standard deviations of frequency and damping of each mode, or of its pole where damping couples them."""
    if state.V is not None:
        return deviation_of_poles(state.omega, state.C, covariance)
    n, m = state.Phi.size, len(state.omega)
    spread = np.sqrt(np.maximum(np.diag(covariance), 0))
    return spread[n : n + m], spread[n + m : n + 2 * m]


def deviation_of_poles(omega: Array, C: Array, covariance: Array) -> tuple[Array, Array]:
    """Standard deviations of frequency and damping of the pole of each coupled mode, as parts of them, (m,) and (m,).

    One pole comes from many undamped frequencies and couplings: these alone are far less sure than it. As (lambda^2 +
    lambda C + K) v = 0, dlambda = -v' (lambda dC + dK) v / v' (2 lambda + C) v. Infinite for a mode without a pole.
    """
    m = len(omega)
    rows, columns = np.tril_indices(m, -1)
    poles, vectors = np.linalg.eig(np.block([[np.zeros((m, m)), np.eye(m)], [-np.diag(omega**2), -C]]))
    poles, v = poles[poles.imag > 0], vectors[:m, poles.imag > 0]
    root, damped = np.sqrt(np.diag(C))[:, None] * v, poles * v * (C @ v)
    turn = np.concatenate([damped + 2 * (omega[:, None] * v) ** 2, damped, 2 * poles * root[rows] * root[columns]])
    turn = -turn / (2 * poles**2 * v**2 + damped).sum(axis=0)
    part = covariance[-len(turn) :, -len(turn) :]
    share = np.abs(v) ** 2 / (np.abs(v) ** 2).sum(axis=0)
    mode, pole = optimize.linear_sum_assignment(share, maximize=True)
    frequency, damping = np.full((2, m), np.inf)
    for out, slope in ((frequency, turn.real), (damping, (turn * poles).real / poles.real - turn.real)):
        out[mode] = np.sqrt(np.maximum((slope * (part @ slope)).sum(axis=0), 0))[pole]
    return frequency, damping


def missing_mode(
    problem: Problem, state: State, own: Array, zeta: float, least: float | Array = 0.0
) -> tuple[State, Array]:
    """The mode that would lower the cost most at each of several frequencies, all other modes being free to follow.

    Parameters
    ----------
    own : (c,) [rad/s]
        Where it is tried.
    zeta : damping ratio that it is tried with
    least : number or (c,)
        What is of interest: a mode that would lower the cost by less may come out as one that does nothing.

    Returns
    -------
    State with c modes, one a candidate, and (c,) by how much each would lower the cost (to first order)
    """
    N, b = curvature(problem, state), gradient(problem, state, residuals(problem, state))
    scale = scale_of(N)
    factor = linalg.cholesky(N / scale[:, None] / scale + 1e-9 * np.eye(len(N)), lower=True)
    size, match, cross = against(problem, state, own, np.full(len(own), zeta))
    # what the present modes can do by themselves is taken out, of the candidates and of the residuals
    count, entries = size.shape
    Y = linalg.solve_triangular(factor, (cross / scale).reshape(count * entries, -1).T, lower=True)
    Y = Y.T.reshape(count, entries, -1)
    match = match - Y @ linalg.solve_triangular(factor, b / scale, lower=True)
    Q = size[:, :, None] * np.eye(entries) - Y @ Y.transpose(0, 2, 1)
    phi, gain = _rank_one(problem, Q, match, size, least)
    return State(phi.T.copy(), own, np.full(count, zeta)), gain


def against(problem: Problem, state: State, own: Array, zeta: Array) -> tuple[Array, Array, Array]:
    """Of each candidate and entry: its squared norm, its product with the residuals, and with J, (c, entries, ...)."""
    thin = problem.thinned()
    error = problem.weight * residuals(problem, state)
    match = compliance(problem.omega, own, zeta).view(float) @ error.view(float).T
    new = compliance(thin.omega, own, zeta)
    size = (new.real**2 + new.imag**2) @ (thin.weight**2).T
    cross = np.zeros((len(own), len(thin.rows), parameters(state)))
    for e, part, index, size_of_each, source, basis in jacobian(thin, state):
        product = (new[:, part] * thin.weight[e, part] ** 2).view(float) @ basis.view(float).T
        cross[:, e, index] += product[:, source] * size_of_each[:, 0]
    return size, match, cross


def bordered(problem: Problem, state: State, places: Array, zeta: Array) -> tuple[Array, Array]:
    """J'J and J'r of the modes' parameters and, behind them, of the entries of a free residue at each place."""
    thin = problem.thinned()
    N, b = curvature(thin, state), gradient(thin, state, residuals(thin, state))
    p, entries = len(N), len(problem.rows)
    _, match, cross = against(thin, state, places, zeta)
    g = compliance(thin.omega, places, zeta)
    A = np.zeros((p + len(places) * entries,) * 2)
    A[:p, :p] = N
    A[p:, :p] = cross.reshape(-1, p)
    A[:p, p:] = A[p:, :p].T
    for e, weight in enumerate(thin.weight):
        column = (g * weight).view(float)
        A[p + e :: entries, p + e :: entries] = column @ column.T
    return A, np.concatenate([b, match.ravel()])


def symmetric(problem: Problem, entries: Array) -> Array:
    """Matrices (k, seats, seats) from their entries i <= j, (k, entries)."""
    seats = int(problem.rows.max()) + 1
    R = np.zeros((len(entries), seats, seats))
    R[:, problem.rows, problem.columns] = R[:, problem.columns, problem.rows] = entries
    return R


def _rank_one(problem: Problem, Q: Array, match: Array, size: Array, least: float | Array) -> tuple[Array, Array]:
    """Of each candidate the shape phi whose phi phi' lowers the cost most, (c, seats), and by how much, 0 if none does.

    Q (c, entries, entries), match and size (c, entries). The cost is no convex function of phi: from two starts, the
    residue that would be best if any were allowed and the one that points along the gradient, phi is replaced by the
    best psi in the symmetric part of phi psi', over and over. No phi phi' does better than that first residue: where it
    does less than what is of interest, the rest is spared.
    """
    unit = 1 / np.sqrt(np.maximum(size, np.finfo(float).tiny))
    scaled = Q * unit[:, :, None] * unit[:, None, :] + 1e-6 * np.eye(Q.shape[1])
    free = unit * np.linalg.solve(scaled, (unit * match)[:, :, None])[:, :, 0]
    phi, gain = np.zeros((len(Q), int(problem.rows.max()) + 1)), np.zeros(len(Q))
    of_interest = (match * free).sum(axis=1) > least
    Q, match, size, free, unit = (x[of_interest] for x in (Q, match, size, free, unit))
    # seats are brought to one size, else the one that moves most is all that the eigenvector sees
    level = size[:, problem.rows == problem.columns] ** 0.25
    shape, best = np.zeros((len(Q), phi.shape[1])), np.zeros(len(Q))
    for start in (free, unit**2 * match):
        residue = symmetric(problem, start)
        trial = np.linalg.eigh(residue * level[:, :, None] * level[:, None, :])[1][:, :, -1]
        for _ in range(ALTERNATIONS):
            better, worth = _scaled(problem, Q, match, trial / level)
            improved = worth > best
            shape[improved], best[improved] = better[improved], worth[improved]
            trial = _other(problem, Q, match, trial, level)
    phi[of_interest], gain[of_interest] = shape, best
    return phi, gain


def _scaled(problem: Problem, Q: Array, match: Array, phi: Array) -> tuple[Array, Array]:
    """Shapes at the size that lowers the cost most, and by how much."""
    product = phi[:, problem.rows] * phi[:, problem.columns]
    along = np.maximum(np.einsum("ce,ce->c", product, match), 0)
    norm = np.maximum(np.einsum("ce,cef,cf->c", product, Q, product), np.finfo(float).tiny)
    return phi * np.sqrt(along / norm)[:, None], along**2 / norm


def _other(problem: Problem, Q: Array, match: Array, trial: Array, level: Array) -> Array:
    """Half way from phi to the psi that is best beside it, both of length 1 in levelled seats."""
    seats = np.arange(trial.shape[1])
    left = (problem.columns[:, None] == seats) * (trial / level)[:, problem.rows, None]
    right = (problem.rows[:, None] == seats) * (trial / level)[:, problem.columns, None]
    A = (left + right) / 2 / level[:, None, :]
    square = A.transpose(0, 2, 1) @ Q @ A
    trace = np.trace(square, axis1=1, axis2=2)[:, None, None]
    square = square + (1e-9 * trace + np.finfo(float).tiny) * np.eye(len(seats))
    psi = np.linalg.solve(square, A.transpose(0, 2, 1) @ match[:, :, None])[:, :, 0]
    psi /= np.maximum(np.linalg.norm(psi, axis=1, keepdims=True), np.finfo(float).tiny)
    turned = trial + psi * np.sign(np.einsum("cs,cs->c", trial, psi))[:, None]
    return np.asarray(turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), np.finfo(float).tiny))


# Where residues stand, in multiples of the band's upper edge. At each place there are two, damped by these multiples:
# of both together, any damping between can be made.
BEYOND, DAMPED = (1.015, 1.05, 1.12, 1.22, 1.4, 1.8, 3.0, 20.0), (0.5, 2.0)


# More unknowns than these cost more than they save.
MOST = 600


# Parts of the upper edge at which the few modes answer as the many do: a good sum with modes to spare, and one mode a
# seat, which may be the very modes that are there.
SPARE, SCARCE = (0.3, 0.8, 1.0), (0.9,)


# The barrier: its first size, as a part of the largest slope; how it falls; steps at each size at the most.
FIRST, FALL, STEPS = 0.3, 8.0, 4


# A step that has to be shorter than this part of Newton's leads nowhere.
SHORT = 1e-6


def arranged(
    problem: Problem, own: State, zeta: float, variance: float, exact: tuple[float, ...] = SPARE
) -> State | None:
    """The modes of the band, and a few pseudo-modes above it.

    Parameters
    ----------
    own : State
        The modes of the band; they follow to first order.
    zeta : their damping ratio, more or less
    variance : float
        Of a weighted error: the cost comes within ten times this of the best.
    exact : SPARE or SCARCE
        How many pseudo-modes.

    Returns
    -------
    None when there are too many seats for it, or no mode in the band: then there is nothing that it stands beside.
    """
    high = problem.edges[1]
    places = np.repeat(high * np.array(BEYOND), len(DAMPED))
    damping = np.tile(zeta * np.array(DAMPED), len(BEYOND))
    entries, seats = len(problem.rows), own.Phi.shape[0]
    if len(places) * entries > MOST or not len(own.omega):
        return None
    A, b = bordered(problem, own, places, damping)
    x = _best(problem, A, b, len(places), 10 * variance)
    step, R = x[: -len(places) * entries], symmetric(problem, x[-len(places) * entries :].reshape(-1, entries))
    values, vectors = np.linalg.eigh(R)
    Phi = (vectors * np.sqrt(np.maximum(values, 0))[:, None, :]).transpose(1, 0, 2).reshape(seats, -1)
    many = State(Phi, np.repeat(places, seats), np.repeat(damping, seats))
    # a direction that adds d^2 to the weighted receptances of driving points adds no more than d^4 to the cost, a line
    few = _few(many, high * np.array(exact), level_of(problem), (variance / problem.H.size) ** 0.25)
    return min((moved(problem, own, step).joined(few), own.joined(few)), key=lambda state: cost(problem, state))


def _best(problem: Problem, A: Array, b: Array, count: int, gap: float) -> Array:
    """The x that makes x'Ax - 2b'x least, its last entries being `count` positive semidefinite matrices.

    To `gap`, or to where rounding ends the way; x is feasible all along it.
    """
    entries = len(problem.rows)
    p = len(A) - count * entries
    point = problem.rows == problem.columns
    twice = np.where(point, 1.0, 2.0)
    # parameters at the size of their columns, matrices at that of their diagonals: they stay what they are
    unit = 1 / scale_of(A)
    root = np.sqrt(unit[p:].reshape(count, entries)[:, point])
    unit[p:] = (root[:, problem.rows] * root[:, problem.columns]).ravel()
    A, b = A * unit[:, None] * unit, b * unit
    x = np.zeros(len(A))
    x[p:].reshape(count, entries)[:, point] = FIRST
    barrier = FIRST * float(np.abs(b).max())

    def worth(x: Array) -> float:
        values = np.linalg.eigvalsh(symmetric(problem, x[p:].reshape(count, entries)))
        return float(x @ A @ x - 2 * b @ x - barrier * np.log(values).sum()) if values.min() > 0 else np.inf

    while True:
        for _ in range(STEPS):
            S = np.asarray(np.linalg.inv(symmetric(problem, x[p:].reshape(count, entries))), dtype=float)
            slope, bend = 2 * (A @ x - b), 2 * A
            slope[p:] -= barrier * (twice * S[:, problem.rows, problem.columns]).ravel()
            for k, both in enumerate(_barrier_bend(problem, S, twice)):
                part = slice(p + k * entries, p + (k + 1) * entries)
                bend[part, part] += barrier * both
            # neighbouring places are nearly alike: rounding makes it indefinite
            bend.flat[:: len(bend) + 1] += 1e-12 * np.trace(bend) / len(bend)
            lower, failed = linalg.lapack.dpotrf(bend, lower=1)
            if failed:
                return x * unit
            step = -linalg.lapack.dpotrs(lower, slope, lower=1)[0]
            now, expected, length = worth(x), -float(slope @ step), 1.0
            while worth(x + length * step) > now - 1e-4 * length * expected:
                length *= 0.6
                if length < SHORT:
                    return x * unit
            x = x + length * step
            if expected < barrier / 2:
                break
        if barrier * count * int(point.sum()) < gap:
            return x * unit
        barrier /= FALL


def _barrier_bend(problem: Problem, S: Array, twice: Array) -> Array:
    """Second derivatives of -log det R by the entries i <= j of each R, from its inverse, (count, entries, entries)."""
    i, j = problem.rows, problem.columns
    straight = S[:, i[:, None], i] * S[:, j[:, None], j] + S[:, i[:, None], j] * S[:, j[:, None], i]
    return np.asarray(straight * twice[:, None] * twice / 2)


def _few(many: State, at: Array, unit: Array, least: float) -> State:
    """At most as many modes a seat as frequencies, where they answer as the many do: undamped, value and slope.

    Without directions in which the seats, each multiplied by its `unit`, answer by less than the root of what is least.
    """
    # in coordinates of which the stiffness is one
    B = many.Phi / many.omega
    answers = np.hstack([(B * unit[:, None] / (1 - (omega / many.omega) ** 2)).T for omega in at])
    V, size, _ = linalg.svd(answers, full_matrices=False)
    V = V[:, size > least]
    softness, turn = np.linalg.eigh(V.T @ (V / many.omega[:, None] ** 2))
    T, omega = V @ turn, 1 / np.sqrt(softness)
    return State(B @ T * omega, omega, (T**2 * (many.zeta / many.omega)[:, None]).sum(axis=0) * omega)
