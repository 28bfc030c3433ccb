"""A round shaft as a chain of nodes, tied at a few of them.

Between its bearings a round shaft knows no direction. In f = u + i v and b = u - i v, of the displacements and slopes
u = (x, psi) and v = (y, -theta), it falls into two systems of two coordinates a node,

    lambda^2 M f - i lambda Omega G f + K f    and the same with + i for b,

that only bearings and foundation tie together, by forces at their own coordinates. `rbfound.elimination` solves it.
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
# Nodes that are multiplied together, for all lanes: few enough to stay in a processor's cache.
NODES = 16


@dataclass(frozen=True, eq=False)
class Chain:
    """A shaft and its ties, made by `rbfound.roundshaft.chain_of`.

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
        return self._with_ties(own, self.tied(poles, speeds), turning, behind)

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
        own[:, self.node, self.slope] += both(force[:q], force[q : 2 * q])
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

    def tied(self, poles: Complex, speeds: Array) -> Complex:
        """Dynamic stiffness of the ties, (lanes, i, i)."""
        M, C, K, G = self.ties
        s, omega = poles[:, None, None], speeds[:, None, None]
        return np.asarray(s**2 * M + s * C + s * omega * G + K)

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


def _largest(turning: Complex, behind: Complex) -> Array:
    lanes = turning.shape[-1]
    sizes = [np.abs(part).reshape(-1, lanes).max(axis=0, initial=0.0) for part in (turning, behind)]
    return np.maximum(*sizes)


def both(x: Complex, y: Complex) -> Complex:
    """Forces along x and y on f and b."""
    return np.stack([x + 1j * y, x - 1j * y])
