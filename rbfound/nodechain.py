"""A round shaft as a chain of nodes, tied at a few of them: solved for many frequencies at once, node after node.

Between its bearings a round shaft knows no direction. In f = u + i v and b = u - i v, of the displacements and slopes
u = (x, psi) and v = (y, -theta), it falls into two systems of two coordinates a node,

    lambda^2 M f - i lambda Omega G f + K f    and the same with + i for b,

that only bearings and foundation tie together, by forces at their own coordinates. So the chains are eliminated two by
two, all frequencies side by side, and a small system for what ties them is left: the cost is proportional to the nodes,
and nothing is approximated. No pivots are sought within a chain; who needs certainty looks at `residual`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]

# Coordinates of a node that belong to u and to v, with the signs of v.
U, V, SIGN = np.array([0, 3]), np.array([1, 2]), np.array([1.0, -1.0])
# More ties than this part of all coordinates, and a dense matrix is the better road.
MOST_TIES = 0.25
# What rounding may leave of D x - force, as a part of |D| |x| + |force|: what a dense solver leaves too.
ROUNDING = 1e-12
# Lanes that go side by side: enough to hide what a call costs, few enough to stay in a processor's cache.
LANES = 512
# And nodes, where all lanes go together.
NODES = 16


@dataclass(frozen=True, eq=False)
class Chain:
    """A shaft and its ties, made by `chain_of`.

    The coordinates of a motion are f and b of each node, (2, nodes, 2, lanes), the pair in front, and the coordinates
    behind the shaft's (the foundation's), (rest, lanes).

    Attributes
    ----------
    inner : (3, nodes, 3)
        Entries 11, 12, 22 of each node's blocks of M, G and K.
    outer : (3, nodes - 1, 4)
        Entries 11, 12, 21, 22 of the blocks to the next node.
    node, slope : (points,)
        Where the ties hold the shaft: a node, and 0 for its displacement or 1 for its slope.
    ties : (4, 2 points + rest, 2 points + rest)
        M, C, K and G of the ties: u of all points, v of all points, the rest.
    """

    inner: Array
    outer: Array
    node: Index
    slope: Index
    ties: Array

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.inner.shape[1]

    @property
    def rest(self) -> int:
        """Number of coordinates behind the shaft's."""
        return len(self.ties[0]) - 2 * len(self.node)

    def solve(self, poles: Complex, speeds: Array, turning: Complex, behind: Complex) -> tuple[Complex, Complex]:
        """The motion that forces cause, lane by lane: D(lambda, Omega) x = forces.

        Parameters
        ----------
        poles, speeds : (lanes,)
            lambda and Omega [rad/s]
        turning, behind : the forces, in the coordinates of a motion
        """
        x = np.empty((2, self.nodes, 2, len(poles)), dtype=complex)
        y = np.empty((self.rest, len(poles)), dtype=complex)
        work = _Work(self, 1, min(LANES, len(poles)))
        for k in _chunks(len(poles)):
            # a chain that is singular gives nan, which whoever looks at `misfit` finds
            with np.errstate(all="ignore"):
                x[..., k], y[:, k] = self._solve(work, poles[k], speeds[k], turning[..., k], behind[..., k])
        return x, y

    def response(self, omega: Array, speeds: Array, force: Complex) -> tuple[Complex, Index]:
        """Steady motion under harmonic forces, lane by lane, (n, lanes), and the lanes where it is not certain.

        Parameters
        ----------
        omega, speeds : (lanes,) circular frequency and speed of rotation [rad/s]
        force : (n, lanes) in the machine's coordinates
        """
        known = self.motion(force)
        poles = np.asarray(1j * omega, dtype=complex)
        turning, behind = self.solve(poles, speeds, *known)
        with np.errstate(all="ignore"):
            for solve in (self.solve_twice, None):
                bad = np.flatnonzero(~(self.misfit(poles, speeds, (turning, behind), known) <= ROUNDING))
                if solve is None or not len(bad):
                    break
                some = (part[..., bad] for part in known)
                turning[..., bad], behind[..., bad] = solve(poles[bad], speeds[bad], *some)
        return self.vector(turning, behind), bad

    def solve_twice(self, poles: Complex, speeds: Array, turning: Complex, behind: Complex) -> tuple[Complex, Complex]:
        """As `solve`, and what is left of the forces is solved for again.

        A frequency near one of a part of the shaft, held at the next node, costs digits: this gives them back.
        """
        x, y = self.solve(poles, speeds, turning, behind)
        own, rest = self.stiffness(poles, speeds, x, y)
        dx, dy = self.solve(poles, speeds, turning - own, behind - rest)
        return x + dx, y + dy

    def turns(self, poles: Complex, speeds: Array) -> Complex:
        """det D / |det D|, lane by lane: (lanes,)."""
        out = np.empty(len(poles), dtype=complex)
        work = _Work(self, 0, min(LANES, len(poles)))
        for k in _chunks(len(poles)):
            spring = self._springs(poles[k], speeds[k])
            phase = np.ones(2 * len(poles[k]), dtype=complex)
            work.use(len(poles[k]))
            self._eliminate(work, poles[k], speeds[k], spring, phase)
            moved = self._forward(work, None)
            small = np.linalg.slogdet(self._small(self._loaded(poles[k], speeds[k], spring), moved))[0]
            out[k] = phase.reshape(2, -1).prod(axis=0) * small
        return out

    def motion(self, x: Complex) -> tuple[Complex, Complex]:
        """A vector in the machine's coordinates (n, lanes) as a motion (or forces as such)."""
        shaft = x[: 4 * self.nodes].reshape(self.nodes, 4, -1)
        u, v = shaft[:, U], SIGN[:, None] * shaft[:, V]
        return np.stack([u + 1j * v, u - 1j * v], axis=0), x[4 * self.nodes :]

    def vector(self, turning: Complex, behind: Complex) -> Complex:
        """A motion in the machine's coordinates, (n, lanes)."""
        f, b = turning
        shaft = np.empty((self.nodes, 4, f.shape[-1]), dtype=complex)
        shaft[:, U] = (f + b) / 2
        shaft[:, V] = SIGN[:, None] * (f - b) / 2j
        return np.concatenate([shaft.reshape(4 * self.nodes, -1), behind])

    def stiffness(self, poles: Complex, speeds: Array, turning: Complex, behind: Complex) -> tuple[Complex, Complex]:
        """D(lambda, Omega) times a motion: what the motion needs for forces."""
        own = poles**2 * self.times(0, turning) + poles * speeds * self._gyroscopic(turning) + self.times(2, turning)
        return self._with_ties(own, self._tied(poles, speeds), turning, behind)

    def slope_of_stiffness(
        self, poles: Complex, speeds: Array, turning: Complex, behind: Complex
    ) -> tuple[Complex, Complex]:
        """dD/dlambda times a motion."""
        own = 2 * poles * self.times(0, turning) + speeds * self._gyroscopic(turning)
        M, C, _, G = self.ties
        tied = 2 * poles[:, None, None] * M + C + speeds[:, None, None] * G
        return self._with_ties(own, tied, turning, behind)

    def misfit(
        self,
        poles: Complex,
        speeds: Array,
        motion: tuple[Complex, Complex],
        force: tuple[Complex, Complex] | None = None,
    ) -> Array:
        """|D x - force| over |D| |x| + |force|, lane by lane, (lanes,): what a stable solver leaves is a few roundings.

        Infinity norms; nan where the motion is not finite.
        """
        left = self.stiffness(poles, speeds, *motion)
        known = (np.zeros(1), np.zeros(1)) if force is None else force
        size = np.abs(poles)
        norms = (size**2, size * np.abs(speeds), 1.0)
        own = sum(w * norm for w, norm in zip(norms, self.norms[:3], strict=True))
        tied = sum(
            w * norm for w, norm in zip((size**2, size, 1.0, size * np.abs(speeds)), self.norms[3:], strict=True)
        )
        return np.asarray(
            _largest(*(a - b for a, b in zip(left, known, strict=True)))
            / ((own + tied) * _largest(*motion) + _largest(*known))
        )

    @cached_property
    def norms(self) -> Array:
        """Largest row sums of |M|, |G|, |K| of the shaft, and of |M|, |C|, |K|, |G| of the ties, (7,)."""
        a, b = np.abs(self.inner), np.abs(self.outer)
        rows = np.stack([a[..., 0] + a[..., 1], a[..., 1] + a[..., 2]], axis=2)
        rows[:, :-1] += np.stack([b[..., 0] + b[..., 1], b[..., 2] + b[..., 3]], axis=2)
        rows[:, 1:] += np.stack([b[..., 0] + b[..., 2], b[..., 1] + b[..., 3]], axis=2)
        return np.concatenate([rows.max(axis=(1, 2)), np.abs(self.ties).sum(axis=2).max(axis=1, initial=0.0)])

    def _gyroscopic(self, turning: Complex) -> Complex:
        return np.array([-1j, 1j])[:, None, None, None] * self.times(1, turning)

    def _with_ties(self, own: Complex, tied: Complex, turning: Complex, behind: Complex) -> tuple[Complex, Complex]:
        q = len(self.node)
        force = (tied @ self._held(turning, behind).T[:, :, None])[:, :, 0].T
        own[:, self.node, self.slope] += _both(force[:q], force[q : 2 * q])
        return own, force[2 * q :]

    def _held(self, turning: Complex, behind: Complex) -> Complex:
        """Displacements at the ties, in their order: (2 points + rest, lanes)."""
        f, b = turning[:, self.node, self.slope]
        return np.concatenate([(f + b) / 2, (f - b) / 2j, behind])

    def times(self, which: int, x: NDArray[Any]) -> NDArray[Any]:
        """M, G or K of the shaft (which: 0, 1, 2) times both chains, or one: (.., nodes, 2, lanes)."""
        own, last = self.inner[which].T[:, :, None], self.nodes - 1
        beyond = self.outer[which].T[:, :, None]
        out = np.empty(x.shape, dtype=x.dtype)
        # real and imaginary parts are lanes of their own here: the coefficients are real
        given, found = np.ascontiguousarray(x).view(float), out.view(float)
        room = np.empty((len(x), NODES, given.shape[-1]))
        for i in range(0, self.nodes, NODES):
            j = min(i + NODES, self.nodes)
            right, left = slice(i, min(j, last)), slice(max(i, 1) - 1, j - 1)
            after, before = slice(i + 1, right.stop + 1), slice(max(i, 1), j)
            for row in range(2):
                y = found[:, i:j, row]
                np.multiply(own[row, i:j], given[:, i:j, 0], out=y)
                for coefficient, x_, to in (
                    (own[row + 1, i:j], given[:, i:j, 1], y),
                    (beyond[2 * row, right], given[:, after, 0], found[:, right, row]),
                    (beyond[2 * row + 1, right], given[:, after, 1], found[:, right, row]),
                    (beyond[row, left], given[:, left, 0], found[:, before, row]),
                    (beyond[row + 2, left], given[:, left, 1], found[:, before, row]),
                ):
                    # in place: asking for memory costs more than the arithmetic
                    to += np.multiply(coefficient, x_, out=room[:, : x_.shape[1]])
        return out

    def _tied(self, poles: Complex, speeds: Array) -> Complex:
        """Dynamic stiffness of the ties, (lanes, i, i)."""
        M, C, K, G = self.ties
        s, omega = poles[:, None, None], speeds[:, None, None]
        return np.asarray(s**2 * M + s * C + s * omega * G + K)

    def _springs(self, poles: Complex, speeds: Array) -> Complex:
        """A round spring for each point, (points, lanes), as strong as its ties and out of phase.

        The chain gets it, the ties lose it: a chain that is free would be singular at rest, and one out of phase is
        not singular where the machine is.
        """
        q = np.arange(len(self.node))
        M, C, K, G = (np.abs(np.array([A[q, q], A[q + len(q), q + len(q)]])).mean(axis=0)[:, None] for A in self.ties)
        size = np.abs(poles)
        return np.asarray((size**2 * M + size * (C + np.abs(speeds) * G) + K) * np.exp(0.25j * np.pi))

    def _eliminate(
        self, work: "_Work", poles: Complex, speeds: Array, spring: Complex, phase: Complex | None = None
    ) -> None:
        """Fill work.steps: of each node the inverse of what is left of its block, and that times the next block."""
        squared, turn = np.tile(poles**2, 2), np.concatenate([-1j * poles * speeds, 1j * poles * speeds])
        springs = np.tile(spring, 2)
        entries, other, loss, pair = work.entries, work.other, work.loss, work.pair
        det, unit = work.det, work.unit
        loss[...] = 0
        for k, step in enumerate(work.steps):
            m, g, stiff = self.coefficients[k][:, :, None]
            np.multiply(squared, m, out=entries)
            np.multiply(turn, g, out=other)
            entries += other
            entries += stiff
            for p in self.fresh[k]:
                entries[2 * self.slope[p]] += springs[p]
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

    def _forward(self, work: "_Work", turning: Complex | None) -> Complex:
        """Fill work.ways: of each node its motion under all columns of forces if the next one were held.

        The columns are the given forces, (nodes, 2, 2 lanes), if any, and a unit force at each point, left out up to
        there. Returned is what all columns move at the points, (points, columns, 2 lanes): half of the way is enough,
        as the chains are symmetric.
        """
        given = 0 if turning is None else 1
        moved = np.zeros((len(self.node), given + len(self.node), work.wide), dtype=complex)
        (now, then), count = work.columns, given
        now[...] = 0
        for k, (step, way) in enumerate(zip(work.steps, work.ways, strict=True)):
            if turning is not None:
                now[:, 0] += turning[k]
            for p in self.fresh[k]:
                now[self.slope[p], count] += 1.0
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

    def _small(self, loaded: Complex, yields: Complex) -> Complex:
        """What is left for the displacements at the points and the rest, (lanes, i, i)."""
        q = len(self.node)
        g = yields.reshape(q, q, 2, len(loaded)).transpose(2, 3, 0, 1)
        mean, turn = (g[0] + g[1]) / 2, 0.5j * (g[0] - g[1])
        H = np.concatenate([np.concatenate([mean, turn], axis=2), np.concatenate([-turn, mean], axis=2)], axis=1)
        out = np.concatenate([H @ loaded[:, : 2 * q], loaded[:, 2 * q :] / _size(loaded, q)[:, :, None]], axis=1)
        out[:, np.arange(2 * q), np.arange(2 * q)] += 1.0
        return out

    def _loaded(self, poles: Complex, speeds: Array, spring: Complex) -> Complex:
        q = len(self.node)
        tied = self._tied(poles, speeds)
        tied[:, np.arange(2 * q), np.arange(2 * q)] -= np.tile(spring, (2, 1)).T
        return tied

    def _solve(
        self, work: "_Work", poles: Complex, speeds: Array, turning: Complex, behind: Complex
    ) -> tuple[Complex, Complex]:
        q, lanes = len(self.node), len(poles)
        spring = self._springs(poles, speeds)
        work.use(lanes)
        self._eliminate(work, poles, speeds, spring)
        moved = self._forward(work, turning.transpose(1, 2, 0, 3).reshape(self.nodes, 2, -1))
        loaded = self._loaded(poles, speeds, spring)
        f, b = moved[:, 0].reshape(q, 2, lanes).transpose(1, 0, 2)
        known = np.concatenate([(f + b) / 2, (f - b) / 2j, behind / _size(loaded, q).T])
        held = np.linalg.solve(self._small(loaded, moved[:, 1:]), known.T[:, :, None])
        force = (loaded[:, : 2 * q] @ held)[:, :, 0].T
        weights = -_both(force[:q], force[q:]).transpose(1, 0, 2).reshape(q, 2 * lanes)
        out, pair = work.motion, work.pair
        for k in range(self.nodes - 1, -1, -1):
            step, way = work.steps[k], work.ways[k]
            out[k] = way[:, 0]
            for p in range(int(self.node.searchsorted(k, "right"))):
                np.multiply(way[:, 1 + p], weights[p], out=pair)
                out[k] += pair
            if k < self.nodes - 1:
                for row in range(2):
                    np.multiply(step[3 + 2 * row : 5 + 2 * row], out[k + 1], out=pair)
                    out[k, row] -= pair[0]
                    out[k, row] -= pair[1]
        behind = np.asarray(held[:, 2 * q :, 0].T, dtype=complex)
        return out.reshape(self.nodes, 2, 2, lanes).transpose(2, 0, 1, 3), behind

    @cached_property
    def coefficients(self) -> Complex:
        """Of each node M, G and K: entries 11, 12, 22 of its block and 11, 12, 21, 22 of the one to the next node."""
        last = np.zeros((3, 1, 4))
        parts = np.concatenate([self.inner, np.concatenate([self.outer, last], axis=1)], axis=2)
        return parts.transpose(1, 0, 2).astype(complex)

    @cached_property
    def fresh(self) -> list[list[int]]:
        """The points at each node."""
        return [[int(p) for p in np.flatnonzero(self.node == k)] for k in range(self.nodes)]


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


def _largest(turning: Complex, behind: Complex) -> Array:
    lanes = turning.shape[-1]
    sizes = [np.abs(part).reshape(-1, lanes).max(axis=0, initial=0.0) for part in (turning, behind)]
    return np.maximum(*sizes)


def _both(x: Complex, y: Complex) -> Complex:
    """Forces along x and y on f and b."""
    return np.stack([x + 1j * y, x - 1j * y])


def _size(loaded: Complex, q: int) -> Array:
    """Of the equations of the rest, (lanes, rest): forces there, displacements above, brought to one for the pivots."""
    return np.abs(loaded[:, 2 * q :]).max(axis=2, initial=1e-300)


def chain_of(M: Array, C: Array, K: Array, G: Array, shaft: tuple[Array, Array, Array]) -> Chain | None:
    """The chain of a machine, or None if it is none: a shaft that is not round, or ties nearly everywhere.

    Parameters
    ----------
    M, C, K, G : (n, n)
        The machine; four coordinates a node first, in the order x, y, theta, psi, G for a spin of 1 rad/s.
    shaft : M, K and G of the shaft alone and free, (4 nodes, 4 nodes)
    """
    size = len(shaft[0])
    parts = [_round_parts(A, turning) for A, turning in zip(shaft, (False, False, True), strict=True)]
    whole, alone = (M, C, K, G), (shaft[0], None, shaft[1], shaft[2])
    # copies of whole matrices would cost more than all that follows
    held = np.flatnonzero(np.any([_touched(A, own, size) for A, own in zip(whole, alone, strict=True)], axis=0))
    slope = np.isin(held % 4, (2, 3)).astype(int)
    points = np.unique(np.stack([held // 4, slope], axis=1), axis=0)
    rest = np.arange(size, len(M))
    if any(part is None for part in parts) or 2 * len(points) + len(rest) > MOST_TIES * len(M):
        return None
    node, slope = points.T
    order = np.concatenate([4 * node + U[slope], 4 * node + V[slope], rest])
    sign = np.concatenate([np.ones(len(node)), SIGN[slope], np.ones(len(rest))])
    ties, own = (np.array([A[np.ix_(some, some)] for A in part]) for some, part in ((order, whole), (order[: 2 * len(node)], shaft)))
    ties[[0, 2, 3], : 2 * len(node), : 2 * len(node)] -= own
    ties *= np.outer(sign, sign)
    inner, outer = (np.array([part[k] for part in parts if part is not None])[[0, 2, 1]] for k in range(2))
    return Chain(inner, outer, node, slope, ties)


def _touched(A: Array, own: Array | None, size: int) -> NDArray[np.bool_]:
    """Which of the shaft's coordinates are in more than the shaft's own matrix: (size,)."""
    more = A[:size, :size] != (0.0 if own is None else own)
    behind = (A[:size, size:] != 0).any(axis=1) | (A[size:, :size] != 0).any(axis=0)
    return np.asarray(more.any(axis=0) | more.any(axis=1) | behind)


def _round_parts(A: Array, turning: bool) -> tuple[Array, Array] | None:
    """Entries of one plane's blocks, (nodes, 3) and (nodes - 1, 4); None unless A is a chain without directions."""
    nodes = len(A) // 4
    blocks, k = A.reshape(nodes, 4, nodes, 4), np.arange(nodes)
    order, sign = np.concatenate([U, V]), np.concatenate([[1.0, 1.0], SIGN])
    own, next_ = (blocks[a, :, b][:, order][:, :, order] * np.outer(sign, sign) for a, b in ((k, k), (k[:-1], k[1:])))
    back = (blocks[k[1:], :, k[:-1]][:, order][:, :, order] * np.outer(sign, sign)).transpose(0, 2, 1)
    same, across = (slice(0, 2), slice(0, 2)), (slice(0, 2), slice(2, 4))
    taken, other = (across, same) if turning else (same, across)
    least = 1e-12 * np.abs(A).max(initial=0.0)

    def near(a: Array, b: Array | float) -> bool:
        return bool(np.abs(a - b).max(initial=0.0) <= least)

    flipped = (slice(2, 4), slice(0, 2)) if turning else (slice(2, 4), slice(2, 4))
    fine = all(
        near(B[:, *flipped], (-1 if turning else 1) * B[:, *taken]) and near(B[:, *other], 0.0) for B in (own, next_)
    )
    fine &= near(own[:, *taken], own[:, *taken].transpose(0, 2, 1)) and near(back, -next_ if turning else next_)
    inside = sum(np.count_nonzero(B) for B in (own, next_, back))
    if not fine or inside != np.count_nonzero(A):
        return None
    a, b = own[:, *taken], next_[:, *taken]
    return np.stack([a[:, 0, 0], a[:, 0, 1], a[:, 1, 1]], axis=1), b.reshape(-1, 4)
