"""Fewer lines that tell as much: a smooth stretch of noisy lines becomes a few nodes, and little but noise is lost.

Where receptances are polynomials of low degree over a stretch of n lines, their least-squares polynomials hold all that
the lines say. A polynomial is known by its values at the Gauss nodes of the lines, and there its errors are independent
of one another: a value of share s has the error of the mean of s lines (Gautschi 2004, Orthogonal Polynomials, section
1.4, doi:10.1093/oso/9780198506720.001.0001). A sum of squares over the nodes is that over the lines, but for a part
that no smooth model can reach.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from rbfound.identification.least_squares import Array, Complex, Problem, State, receptances, residuals, size_of
from rbfound.measurement import beside_neighbours

# Nodes of a stretch, and its greatest length: a part of its distance from the next pole, and of its own frequency.
NODES, REACH, LONGEST = 4, 0.8, 0.25

# What a stretch may leave beside its polynomials, in standard deviations of what noise leaves.
BESIDE = 4.0


def compressed(problem: Problem, poles: Complex, relative: bool, finest: float) -> Problem:
    """The problem with nodes, dense where a pole is near; without, where the lines are too few to be made fewer.

    Parameters
    ----------
    poles : (m,) [rad/s]
        Those that are known. Where one is missing, a stretch does not fit its polynomials and is halved.
    relative : whether errors are taken relative to |H|
    finest : float
        Weighted errors that don't matter.
    """
    omega, H, weight = problem.omega, problem.H, problem.weight
    # a pseudo-mode may come as near to the band as it likes
    near = np.concatenate([poles, 1j * np.array(problem.edges)])
    parts = _stretches(omega, near)[::-1]
    level = max(_noise(problem), finest, problem.least) ** 2
    even = np.ptp(np.diff(omega)) < 1e-6 * np.diff(omega).min()
    nodes, values, weights, shares = [], [], [], []
    while parts:
        part = parts.pop()
        lines = part.stop - part.start
        if lines <= NODES + 1:
            nodes.append(omega[part])
            values.append(H[:, part])
            weights.append(weight[:, part])
            shares.append(np.ones(lines))
            continue
        at, share, rows = gauss_even(lines) if even else gauss(omega[part])
        if even:
            at = omega[part][0] + at * (omega[1] - omega[0])
        along = H[:, part] @ rows.T
        beside = np.abs(weight[:, part] * (H[:, part] - along @ rows)) ** 2
        freedom = (lines - NODES) * len(H)
        if beside.sum() > level * freedom * (1 + BESIDE / np.sqrt(freedom)):
            middle = (part.start + part.stop) // 2
            parts += [slice(middle, part.stop), slice(part.start, middle)]
            continue
        nodes.append(at)
        values.append(along / np.sqrt(share))
        variance = np.mean(weight[:, part] ** -2.0, axis=1, keepdims=True)
        weights.append(np.repeat(1 / np.sqrt(variance), NODES, axis=1))
        shares.append(share)
    at, few, share = np.concatenate(nodes), np.hstack(values), np.concatenate(shares)
    if len(at) == len(omega):
        return problem
    heavy = np.hstack(weights)
    if relative:
        # |H| of a node is known better than that of a line
        heavy = np.where(problem.rows != problem.columns, problem.averaging, 1.0)[:, None]
        heavy = heavy / size_of(few, problem.rows, problem.columns)
    return replace(problem, nodes=replace(problem, omega=at, H=few, weight=heavy * np.sqrt(share)))


@lru_cache(maxsize=1024)
def gauss_even(lines: int) -> tuple[Array, Array, Array]:
    """The quadrature over 0, 1, ..., lines - 1: that of any evenly spaced lines, but for place and spacing."""
    return gauss(np.arange(lines, dtype=float))


def gauss(x: Array) -> tuple[Array, Array, Array]:
    """Gauss quadrature of sums over x (n,): NODES nodes, weights, and orthonormal rows (NODES, n).

    A polynomial with the values p at the nodes is rows' (sqrt(weights) p) at x.
    """
    centre, half = (x[0] + x[-1]) / 2, (x[-1] - x[0]) / 2
    u = (x - centre) / half
    Q = np.linalg.qr(np.vander(u, NODES, increasing=True))[0]
    # multiplying by u is a tridiagonal matrix in orthonormal polynomials; its eigenvalues are the nodes
    at, V = np.linalg.eigh(Q.T @ (u[:, None] * Q))
    rows = V.T @ Q.T
    first = rows.sum(axis=1)
    return centre + half * at, first**2, rows * np.sign(first)[:, None]


def _stretches(omega: Array, poles: Complex) -> list[slice]:
    """Runs of lines that are short where a pole is near."""
    out, start = [], 0
    while start < len(omega):
        here = omega[start]
        # on the way to a pole ahead the distance shrinks
        way = np.where(poles.imag > here, (poles.imag - here) / (1 + REACH), poles.imag - here)
        distance = np.hypot(poles.real, way).min(initial=np.inf)
        end = int(np.searchsorted(omega, here + min(REACH * distance, LONGEST * here), side="right"))
        out.append(slice(start, max(end, start + 1)))
        start = out[-1].stop
    return out


def _noise(problem: Problem) -> float:
    """Standard deviation of the weighted error, as neighbouring lines tell it."""
    if len(problem.omega) < 5:
        return 0.0
    square = problem.weight[:, 2:-2] ** 2 * beside_neighbours(problem.omega, problem.H.T).T
    # the median of the square of a complex normal error is ln 2 of its mean
    return float(np.sqrt(np.median(square) / np.log(2)))


def reweighted(problem: Problem, state: State) -> Problem:
    """|H| of the model in place of the data's: an entry that came out small by chance weighs no more for it."""
    data = size_of(problem.H, problem.rows, problem.columns)
    weight = problem.weight * data / size_of(receptances(problem, state), problem.rows, problem.columns)
    nodes = reweighted(problem.nodes, state) if problem.nodes else None
    return replace(problem, weight=weight, nodes=nodes)


def scale_of_data(problem: Problem) -> float:
    """The size of the weighted data, without those lines where it is great or small."""
    return float(np.median(problem.weight * size_of(problem.H, problem.rows, problem.columns)))


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
