"""Where the modes of a fit come from: known poles, pseudo-modes of the remainder, and the mode that is missing."""

import numpy as np
from scipy import linalg

from rbfound.leastsquares import (
    ALIKE,
    Array,
    Complex,
    Problem,
    State,
    chain,
    compliance,
    curvature,
    gradient,
    groups_of,
    residuals,
    scale_of,
    tangents,
)

# Where pseudo-modes are tried: parts of the band's lower edge, multiples of its upper edge.
BELOW = (0.3, 0.7)
ABOVE = (1.01, 1.03, 1.06, 1.1, 1.15, 1.2, 1.3, 1.45, 1.6, 2.0, 3.0, 5.0, 10.0)

# Of nearly alike poles each stands for a mode if the residue that they share has that many eigenvalues above this part
# of the largest. Where the second is a larger part, a pole that was found once is a repeated one: neither noise nor a
# remainder that is not yet known leaves as much.
RANK, PLAINLY = 1e-6, 0.5

# How often a candidate's shape is improved.
ALTERNATIONS = 6


def first_modes(problem: Problem, poles: Complex) -> State:
    """Modes at known poles with the shapes that linear least squares gives them, and one pseudo-mode a seat above.

    Each entry is a real combination of the modes' compliances, of a remainder U + V w^2 of what lies above the band and
    of one -L / w^2 of what lies below. The largest eigenvector of a mode's symmetric residue is its shape. Poles that
    cannot be told from a repeated one have a residue together, and `repeated_modes` tells them apart.
    """
    groups = groups_of(poles)
    mean = np.array([poles[group].mean() for group in groups], dtype=complex)
    own, zeta = np.abs(mean), np.clip(-mean.real / np.abs(mean), 1e-4, 0.3)
    seats, m = int(problem.rows.max()) + 1, len(mean)
    low, high = problem.edges
    w = problem.omega
    several = np.flatnonzero([len(group) > 1 for group in groups])
    g = compliance(w, own, zeta)
    columns = np.vstack([g, np.ones_like(w), (w / high) ** 2, -((low / w) ** 2), g[several] ** 2])
    residue = np.zeros((len(columns), seats, seats))
    for e, (i, j) in enumerate(zip(problem.rows, problem.columns, strict=True)):
        A = (columns * problem.weight[e]).view(float).T
        size = np.linalg.norm(A, axis=0)
        solved = linalg.lstsq(A / size, (problem.H[e] * problem.weight[e]).view(float))[0] / size
        residue[:, i, j] = residue[:, j, i] = solved
    level = level_of(problem)
    residue[:m] *= level[:, None] * level
    slope = np.zeros((m, seats, seats))
    slope[several] = residue[m + 3 :] * level[:, None] * level
    inside = State(np.zeros((seats, 0)), np.zeros(0), np.zeros(0))
    for k, group in enumerate(groups):
        values = np.linalg.eigvalsh(residue[k])
        rank, plain = (int((values > part * values[-1]).sum()) for part in (RANK, PLAINLY))
        Phi, shift = repeated_modes(residue[k], slope[k], max(1, plain, min(len(group), rank)))
        # a step to first order, no longer than the poles that were found are apart
        most = 2 * own[k] ** 2 * ALIKE * zeta[k]
        omega = np.sqrt(own[k] ** 2 + np.clip(shift, -most, most))
        inside = inside.joined(State(Phi / level[:, None], omega, np.full(len(omega), zeta[k])))
    return inside.joined(_above(residue[m], residue[m + 1] / high**2, high, float(np.median(zeta)) if m else 0.02))


def repeated_modes(R: Array, slope: Array, few: int) -> tuple[Array, Array]:
    """The modes of a repeated pole, or of nearly repeated ones: shapes (seats, few) and shifts of omega^2 (few,).

    To first order, modes near one pole are R g + slope g^2 with R = Phi Phi' and slope = -Phi diag(shift) Phi'. Both
    are diagonal in the right combination of the largest eigenvectors of R; where the pole is a repeated one, any is.
    """
    values, vectors = np.linalg.eigh(R)
    half = vectors[:, -few:] * np.sqrt(np.maximum(values[-few:], 1e-9 * np.abs(values).max()))
    inverse = half / (half**2).sum(axis=0)
    shift, turn = np.linalg.eigh(-inverse.T @ slope @ inverse)
    return half @ turn, shift


def level_of(problem: Problem) -> Array:
    """What brings all seats to one size, (seats,) [sqrt(N/m)]: else an eigenvector sees the one that moves most."""
    return np.asarray(np.sqrt(np.median(problem.weight[problem.rows == problem.columns], axis=1)))


def _above(U: Array, V: Array, high: float, zeta: float) -> State:
    """One pseudo-mode a seat for the remainder U + V w^2: U = sum phi phi' / omega^2, V = sum phi phi' / omega^4.

    Both are diagonal in the eigenvectors of V - lambda U, with lambda = 1 / omega^2; what noise made negative is cut.
    """
    values, vectors = np.linalg.eigh(U)
    values = np.maximum(values, 1e-3 * np.abs(values).max() + np.finfo(float).tiny)
    half = vectors * np.sqrt(values)
    inverse = (vectors / np.sqrt(values)).T
    squared, turn = np.linalg.eigh(inverse @ V @ inverse.T)
    omega = 1 / np.sqrt(np.clip(squared, (20 * high) ** -2, (1.05 * high) ** -2))
    return State(half @ turn * omega, omega, np.full(len(omega), zeta))


def candidates(low: float, high: float, zeta: float) -> Array:
    """Frequencies at which a missing mode is looked for [rad/s]: below, in and above a band, as dense as zeta asks."""
    count = int(np.clip(np.log(high / low) / (2 * zeta), 20, 300))
    return np.concatenate([low * np.array(BELOW), np.geomspace(low, high, count), high * np.array(ABOVE)])


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
    m, entries = len(state.omega), len(problem.rows)
    thin = problem.thinned()
    error = problem.weight * residuals(problem, state)
    match = compliance(problem.omega, own, zeta).view(float) @ error.view(float).T
    new, basis = compliance(thin.omega, own, zeta), tangents(thin.omega, state).reshape(3 * m, -1)
    size = (new.real**2 + new.imag**2) @ (thin.weight**2).T
    product = np.empty((entries, len(own), m, 3))
    for e, weight in enumerate(thin.weight):
        product[e] = (new.view(float) @ (basis * weight**2).view(float).T).reshape(-1, m, 3)
    # (e, m, c, 3) by (e, m, 3, parameters)
    cross = np.matmul(product.transpose(0, 2, 1, 3), chain(state, problem.rows, problem.columns).transpose(0, 1, 3, 2))
    return size, match, cross.transpose(2, 0, 3, 1).reshape(len(own), entries, -1)


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
