"""What lies above the band, found at once: residues at fixed places are a convex problem, and it has one optimum.

A search that moves single modes ends in one of many valleys. Positive semidefinite residues of any rank at a few fixed
frequencies, beside steps of the modes of the band to first order, have no valleys: an interior-point method (Boyd and
Vandenberghe 2004, Convex Optimization, section 11.6, doi:10.1017/CBO9780511804441) finds what is best. It is more modes
than the data need; projected on what it answers at a few frequencies of the band (Krylov vectors: a congruence, so that
it stays passive) it is left with three a seat at the most, and with fewer where noise hides what some of them do.
"""

import numpy as np
from scipy import linalg

from rbfound.additions import bordered, level_of, symmetric
from rbfound.leastsquares import Array, Problem, State, cost, moved, scale_of

# Where residues stand, in multiples of the band's upper edge. At each place there are two, damped by these multiples:
# of both together, any damping between can be made.
ABOVE, DAMPED = (1.015, 1.05, 1.12, 1.22, 1.4, 1.8, 3.0, 20.0), (0.5, 2.0)

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
    places = np.repeat(high * np.array(ABOVE), len(DAMPED))
    damping = np.tile(zeta * np.array(DAMPED), len(ABOVE))
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
