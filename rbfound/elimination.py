"""The motion of a chain of nodes under forces, for many frequencies at once: node after node, then what ties them.

Both chains of a shaft are eliminated from one end to the other, and a small system for what ties them is left: the cost
is proportional to the nodes, and nothing is approximated. No pivots are sought within a chain; who needs certainty asks
`Chain.misfit`. All frequencies (lanes) go side by side, so that they share what a call costs.
"""

import numpy as np
from numpy.typing import NDArray

from rbfound.nodechain import Chain, both

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]

# What rounding may leave of D x - force, as a part of |D| |x| + |force|: what a dense solver leaves too.
ROUNDING = 1e-12
# Lanes that go side by side: enough to hide what a call costs, few enough to stay in a processor's cache.
LANES = 512


def solve(chain: Chain, poles: Complex, speeds: Array, turning: Complex, behind: Complex) -> tuple[Complex, Complex]:
    """The motion that forces cause, lane by lane: D(lambda, Omega) x = forces.

    Parameters
    ----------
    poles, speeds : (lanes,)
        lambda and Omega [rad/s]
    turning, behind : the forces, in the coordinates of a motion
    """
    x = np.empty((2, chain.nodes, 2, len(poles)), dtype=complex)
    y = np.empty((chain.rest, len(poles)), dtype=complex)
    work = _Work(chain, 1, min(LANES, len(poles)))
    for k in _chunks(len(poles)):
        # a chain that is singular gives nan, which whoever looks at `misfit` finds
        with np.errstate(all="ignore"):
            x[..., k], y[:, k] = _solve(chain, work, poles[k], speeds[k], turning[..., k], behind[..., k])
    return x, y


def response(chain: Chain, omega: Array, speeds: Array, force: Complex) -> tuple[Complex, Index]:
    """Steady motion under harmonic forces, lane by lane, (n, lanes), and the lanes where it is not certain.

    Parameters
    ----------
    omega, speeds : (lanes,) circular frequency and speed of rotation [rad/s]
    force : (n, lanes) in the machine's coordinates
    """
    known = chain.motion(force)
    poles = np.asarray(1j * omega, dtype=complex)
    turning, behind = solve(chain, poles, speeds, *known)
    with np.errstate(all="ignore"):
        for again in (True, False):
            bad = np.flatnonzero(~(chain.misfit(poles, speeds, (turning, behind), known) <= ROUNDING))
            if not again or not len(bad):
                break
            some = (part[..., bad] for part in known)
            turning[..., bad], behind[..., bad] = solve_twice(chain, poles[bad], speeds[bad], *some)
    return chain.vector(turning, behind), bad


def solve_twice(
    chain: Chain, poles: Complex, speeds: Array, turning: Complex, behind: Complex
) -> tuple[Complex, Complex]:
    """As `solve`, and what is left of the forces is solved for again.

    A frequency near one of a part of the shaft, held at the next node, costs digits: this gives them back.
    """
    x, y = solve(chain, poles, speeds, turning, behind)
    own, rest = chain.stiffness(poles, speeds, x, y)
    dx, dy = solve(chain, poles, speeds, turning - own, behind - rest)
    return x + dx, y + dy


def turns(chain: Chain, poles: Complex, speeds: Array) -> Complex:
    """det D / |det D|, lane by lane: (lanes,)."""
    out = np.empty(len(poles), dtype=complex)
    work = _Work(chain, 0, min(LANES, len(poles)))
    for k in _chunks(len(poles)):
        spring = _springs(chain, poles[k], speeds[k])
        phase = np.ones(2 * len(poles[k]), dtype=complex)
        work.use(len(poles[k]))
        _eliminate(chain, work, poles[k], speeds[k], spring, phase)
        moved = _forward(chain, work, None)
        small = np.linalg.slogdet(_small(chain, _loaded(chain, poles[k], speeds[k], spring), moved))[0]
        out[k] = phase.reshape(2, -1).prod(axis=0) * small
    return out


def _springs(chain: Chain, poles: Complex, speeds: Array) -> Complex:
    """A round spring for each point, (points, lanes), as strong as its ties and out of phase.

    The chain gets it, the ties lose it: a chain that is free would be singular at rest, and one out of phase is
    not singular where the machine is.
    """
    q = np.arange(len(chain.node))
    M, C, K, G = (np.abs(np.array([A[q, q], A[q + len(q), q + len(q)]])).mean(axis=0)[:, None] for A in chain.ties)
    size = np.abs(poles)
    return np.asarray((size**2 * M + size * (C + np.abs(speeds) * G) + K) * np.exp(0.25j * np.pi))


def _eliminate(
    chain: Chain, work: "_Work", poles: Complex, speeds: Array, spring: Complex, phase: Complex | None = None
) -> None:
    """Fill work.steps: of each node the inverse of what is left of its block, and that times the next block."""
    squared, turn = np.tile(poles**2, 2), np.concatenate([-1j * poles * speeds, 1j * poles * speeds])
    springs = np.tile(spring, 2)
    entries, other, loss, pair = work.entries, work.other, work.loss, work.pair
    det, unit = work.det, work.unit
    loss[...] = 0
    for k, step in enumerate(work.steps):
        m, g, stiff = chain.coefficients[k][:, :, None]
        np.multiply(squared, m, out=entries)
        np.multiply(turn, g, out=other)
        entries += other
        entries += stiff
        for p in chain.fresh[k]:
            entries[2 * chain.slope[p]] += springs[p]
        entries[:3] -= loss
        d11, d12, d22, u = entries[0], entries[1], entries[2], entries[3:].reshape(2, 2, -1)
        np.multiply(d11, d22, out=det)
        np.multiply(d12, d12, out=unit)
        det -= unit
        np.divide(1.0, det, out=unit)
        if phase is not None:
            phase *= det
            phase /= np.abs(phase)
        np.multiply(d22, unit, out=step[0])
        np.multiply(d12, unit, out=step[1])
        np.negative(step[1], out=step[1])
        np.multiply(d11, unit, out=step[2])
        w = step[3:].reshape(2, 2, -1)
        for row, (a, b) in enumerate(((0, 1), (1, 2))):
            np.multiply(step[a], u[0], out=w[row])
            np.multiply(step[b], u[1], out=pair)
            w[row] += pair
        np.multiply(u[0, 0], w[0], out=loss[:2])
        np.multiply(u[1, 0], w[1], out=pair)
        loss[:2] += pair
        np.multiply(u[:, 1], w[:, 1], out=pair)
        np.add(pair[0], pair[1], out=loss[2])


def _forward(chain: Chain, work: "_Work", turning: Complex | None) -> Complex:
    """Fill work.ways: of each node its motion under all columns of forces if the next one were held.

    The columns are the given forces, (nodes, 2, 2 lanes), if any, and a unit force at each point, left out up to
    there. Returned is what all columns move at the points, (points, columns, 2 lanes): half of the way is enough,
    as the chains are symmetric.
    """
    given = 0 if turning is None else 1
    moved = np.zeros((len(chain.node), given + len(chain.node), work.wide), dtype=complex)
    (now, then), count = work.columns, given
    now[...] = 0
    for k, (step, way) in enumerate(zip(work.steps, work.ways, strict=True)):
        if turning is not None:
            now[:, 0] += turning[k]
        for p in chain.fresh[k]:
            now[chain.slope[p], count] += 1.0
            count += 1
        x, other = now[:, :count], work.product[:count]
        for row, (a, b) in enumerate(((0, 1), (1, 2))):
            np.multiply(step[a], x[0], out=way[row, :count])
            np.multiply(step[b], x[1], out=other)
            way[row, :count] += other
        for p in range(count - given):
            for row in range(2):
                np.multiply(x[row, given + p], way[row, :count], out=other)
                moved[p, :count] += other
        then[:, count:] = 0
        for column, (a, b) in enumerate(((3, 5), (4, 6))):
            np.multiply(step[a], x[0], out=then[column, :count])
            np.multiply(step[b], x[1], out=other)
            then[column, :count] += other
        np.negative(then[:, :count], out=then[:, :count])
        now, then = then, now
    return moved


def _small(chain: Chain, loaded: Complex, yields: Complex) -> Complex:
    """What is left for the displacements at the points and the rest, (lanes, i, i)."""
    q = len(chain.node)
    g = yields.reshape(q, q, 2, len(loaded)).transpose(2, 3, 0, 1)
    mean, turn = (g[0] + g[1]) / 2, 0.5j * (g[0] - g[1])
    H = np.concatenate([np.concatenate([mean, turn], axis=2), np.concatenate([-turn, mean], axis=2)], axis=1)
    out = np.concatenate([H @ loaded[:, : 2 * q], loaded[:, 2 * q :] / _size(loaded, q)[:, :, None]], axis=1)
    out[:, np.arange(2 * q), np.arange(2 * q)] += 1.0
    return out


def _loaded(chain: Chain, poles: Complex, speeds: Array, spring: Complex) -> Complex:
    q = len(chain.node)
    tied = chain.tied(poles, speeds)
    tied[:, np.arange(2 * q), np.arange(2 * q)] -= np.tile(spring, (2, 1)).T
    return tied


def _solve(
    chain: Chain, work: "_Work", poles: Complex, speeds: Array, turning: Complex, behind: Complex
) -> tuple[Complex, Complex]:
    q, lanes = len(chain.node), len(poles)
    spring = _springs(chain, poles, speeds)
    work.use(lanes)
    _eliminate(chain, work, poles, speeds, spring)
    moved = _forward(chain, work, turning.transpose(1, 2, 0, 3).reshape(chain.nodes, 2, -1))
    loaded = _loaded(chain, poles, speeds, spring)
    f, b = moved[:, 0].reshape(q, 2, lanes).transpose(1, 0, 2)
    known = np.concatenate([(f + b) / 2, (f - b) / 2j, behind / _size(loaded, q).T])
    held = _held(_small(chain, loaded, moved[:, 1:]), known.T[:, :, None])
    force = (loaded[:, : 2 * q] @ held)[:, :, 0].T
    weights = -both(force[:q], force[q:]).transpose(1, 0, 2).reshape(q, 2 * lanes)
    out, pair = work.motion, work.pair
    for k in range(chain.nodes - 1, -1, -1):
        step, way = work.steps[k], work.ways[k]
        out[k] = way[:, 0]
        for p in range(int(chain.node.searchsorted(k, "right"))):
            np.multiply(way[:, 1 + p], weights[p], out=pair)
            out[k] += pair
        if k < chain.nodes - 1:
            for row in range(2):
                np.multiply(step[3 + 2 * row : 5 + 2 * row], out[k + 1], out=pair)
                out[k, row] -= pair[0]
                out[k, row] -= pair[1]
    behind = np.asarray(held[:, 2 * q :, 0].T, dtype=complex)
    return out.reshape(chain.nodes, 2, 2, lanes).transpose(2, 0, 1, 3), behind


def _held(A: Complex, b: Complex) -> Complex:
    """A x = b, lane by lane.

    Where a pole is met to the last bit A is singular, and a matrix one rounding beside it is taken, as in any inverse
    iteration.
    """
    try:
        return np.asarray(np.linalg.solve(A, b))
    except np.linalg.LinAlgError:
        met = np.linalg.slogdet(A)[0] == 0
        beside = np.finfo(float).eps * np.abs(A).max(axis=(1, 2)) * met
        return np.asarray(np.linalg.solve(A + beside[:, None, None] * np.eye(A.shape[1]), b))


class _Work:
    """Room for one elimination, taken once: asking for memory costs more than the arithmetic in it."""

    steps: Complex
    ways: Complex
    motion: Complex
    columns: Complex
    product: Complex
    entries: Complex
    other: Complex
    loss: Complex
    pair: Complex
    det: Complex
    unit: Complex

    def __init__(self, chain: Chain, given: int, lanes: int) -> None:
        columns, wide = given + len(chain.node), 2 * lanes
        shapes = {
            "steps": (chain.nodes, 7),
            "ways": (chain.nodes, 2, columns),
            "motion": (chain.nodes, 2),
            "columns": (2, 2, columns),
            "product": (columns,),
            "entries": (7,),
            "other": (7,),
            "loss": (3,),
            "pair": (2,),
            "det": (),
            "unit": (),
        }
        self._room = {name: np.empty((*shape, wide), dtype=complex) for name, shape in shapes.items()}
        self.use(lanes)

    def use(self, lanes: int) -> None:
        """Give room for so many lanes."""
        self.wide = 2 * lanes
        for name, room in self._room.items():
            setattr(self, name, room[..., : self.wide])


def _chunks(lanes: int) -> list[slice]:
    return [slice(a, a + LANES) for a in range(0, lanes, LANES)]


def _size(loaded: Complex, q: int) -> Array:
    """Of the equations of the rest, (lanes, rest): forces there, displacements above, brought to one for the pivots."""
    return np.abs(loaded[:, 2 * q :]).max(axis=2, initial=1e-300)
