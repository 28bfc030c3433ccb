"""A machine as a band with a border: its responses and its lowest poles, at a cost proportional to the nodes.

A node of a shaft is joined to its neighbours only, so that the shaft's rows of the dynamic stiffness

    D(lambda, Omega) = lambda^2 M + lambda (C + Omega G) + K

are a band, which LAPACK factors. The foundation's rows are a border: what is left for them is a Schur complement as
small as they are. Poles are guessed in a small model, refined on D by Newton's method with right and left vectors, and
counted by the argument principle. No answer is trusted: what is not certain is said to be so, and the caller takes
dense matrices.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.linalg import lapack

from rbfound.system import Modes, System, mac

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]

# Four coordinates a node, each joined to those of the next node: sub- and superdiagonals.
HALF = 7
# More of the border than this part of all coordinates, and a dense matrix is cheaper.
MOST_TIES = 0.25
# What rounding may leave of D x - force, as a part of |D| |x| + |force|: what a dense solver leaves too.
ROUNDING = 1e-12
# Entries of the matrices that are made at a time: some lanes go side by side, few enough to stay in the cache.
AT_A_TIME = 2**16
# Vectors of the small model's basis, tried in turn.
SIZES = (72, 144)
# Newton's steps, and the size of the last one, relative, that is the end: the error left is of its cube.
STEPS, SETTLED = 8, 1e-5
# A crossing is one where frequency and speed differ by no more than this, relative.
CROSSED = 1e-9
# Two modes of one speed are the same one if they are as close in both pole and shape.
SAME = 1e-6
# The contour of a count: half its width over its height, and how often a step is halved. A phase that turns by more
# in one step might have turned the other way round. Its height is in the widest of so many gaps.
WIDE, HALVINGS, MOST_TURN, GAPS = 5.0, 12, 1.5, 6


@dataclass(frozen=True, eq=False)
class Banded:
    """M, C, K and G (for a spin of 1 rad/s) of a machine, the shaft's coordinates first; made by `band_of`.

    Attributes
    ----------
    parts : M, C, K, G (n, n)
    band : (4, shaft * (3 HALF + 1))
        The shaft's rows and columns of each as LAPACK stores a band, column by column.
    held : (h,)
        The shaft's coordinates that the border is joined to.
    right, below, rest : (4, h, b), (4, b, h), (4, b, b)
        The border: forces on the held coordinates, forces of these, and its own.
    """

    parts: tuple[sparse.csr_array, ...]
    band: Array
    held: Index
    right: Array
    below: Array
    rest: Array

    @property
    def shaft(self) -> int:
        """How many of the coordinates are the shaft's."""
        return self.band.shape[1] // (3 * HALF + 1)

    @cached_property
    def norms(self) -> Array:
        """Largest row sums of |M|, |C|, |K|, |G|, (4,)."""
        return np.array([float(np.max(abs(part).sum(axis=1), initial=0.0)) for part in self.parts])

    def factors(self, poles: Complex, speeds: Array) -> list["_Factor"]:
        """The factored D of each lane; few lanes at a time are enough for memory, see `_lanes`."""
        weights = _weights(poles, speeds)
        ab = np.empty((len(poles), self.band.shape[1]), dtype=complex)
        # real products: the band is real, and a complex copy of it would cost more than they do
        ab.real, ab.imag = weights.real @ self.band, weights.imag @ self.band
        border = [np.tensordot(weights, part, 1) for part in (self.right, self.below, self.rest)]
        bands = ab.reshape(len(poles), self.shaft, -1).transpose(0, 2, 1)
        return [_Factor(a, self.held, *parts) for a, *parts in zip(bands, *border, strict=True)]

    def _lanes(self, count: int) -> list[slice]:
        step = max(1, AT_A_TIME // self.band.shape[1])
        return [slice(k, k + step) for k in range(0, count, step)]

    def times(self, weights: Complex, x: Complex, transposed: bool = False) -> Complex:
        """The sum of weights (lanes, 4) times M, C, K and G, or their transposes, times x: (n, lanes)."""
        out = np.zeros(x.shape, dtype=complex)
        for part, weight in zip(self.parts, weights.T, strict=True):
            if part.nnz and weight.any():
                out += weight * ((part.T if transposed else part) @ x)
        return out

    def solve(self, poles: Complex, speeds: Array, force: Complex) -> Complex:
        """D x = force, lane by lane: (n, lanes)."""
        x = np.empty(force.shape, dtype=complex)
        for some in self._lanes(len(poles)):
            found = [f.solve(b) for f, b in zip(self.factors(poles[some], speeds[some]), force.T[some], strict=True)]
            x[:, some] = np.transpose(found)
        return x

    def response(self, omega: Array, speeds: Array, force: Complex) -> tuple[Complex, Index]:
        """Steady motion under harmonic forces (n, lanes), and the lanes where it is not certain.

        Parameters
        ----------
        omega, speeds : (lanes,) circular frequency and speed of rotation [rad/s]
        """
        poles = np.asarray(1j * omega, dtype=complex)
        x, weights = self.solve(poles, speeds, force), _weights(poles, speeds)
        bad = np.flatnonzero(~(self.misfit(poles, speeds, x, force) <= ROUNDING))
        if len(bad):
            # where the shaft alone is nearly singular, digits are lost: what is left of the forces gives them back
            left = force[:, bad] - self.times(weights[bad], x[:, bad])
            x[:, bad] += self.solve(poles[bad], speeds[bad], left)
            bad = bad[~(self.misfit(poles[bad], speeds[bad], x[:, bad], force[:, bad]) <= ROUNDING)]
        return x, bad

    def misfit(self, poles: Complex, speeds: Array, x: Complex, force: Complex) -> Array:
        """|D x - force| over |D| |x| + |force|, (lanes,): a few roundings after a stable solver, or nan."""
        weights = _weights(poles, speeds)
        left = np.abs(self.times(weights, x) - force).max(axis=0)
        size = np.abs(weights) @ self.norms * np.abs(x).max(axis=0) + np.abs(force).max(axis=0)
        return np.asarray(left / np.maximum(size, np.finfo(float).tiny))

    def turns(self, poles: Complex, speeds: Array) -> Complex:
        """det D / |det D|, (lanes,)."""
        some = self._lanes(len(poles))
        return np.array([f.turn() for k in some for f in self.factors(poles[k], speeds[k])], dtype=complex)

    def newton(self, poles: Complex, speeds: Array, x: Complex, y: Complex) -> tuple[Complex, Complex, Complex]:
        """A step towards poles, right and left vectors, lane by lane.

        With D w = D' x and D^H v = D'^H y (primes: d/dlambda), lambda moves by the small root d of
        v^H (D + d D' + d^2 M) w = 0, whose error is of third order.
        """
        slope = np.stack([2 * poles, np.ones_like(poles), np.zeros_like(poles), speeds], axis=1)
        w, v = np.empty_like(x), np.empty_like(y)
        given = self.times(slope, x), self.times(slope.conj(), y, transposed=True)
        for some in self._lanes(len(poles)):
            lanes = range(*some.indices(len(poles)))
            for k, factor in zip(lanes, self.factors(poles[some], speeds[some]), strict=True):
                w[:, k], v[:, k] = factor.solve(given[0][:, k]), factor.solve(given[1][:, k], adjoint=True)
        size = np.abs(w).max(axis=0)
        w, v = w / size, v / np.abs(v).max(axis=0)
        c = (v.conj() * given[0]).sum(axis=0) / size
        b = (v.conj() * self.times(slope, w)).sum(axis=0)
        a = (v.conj() * (self.parts[0] @ w)).sum(axis=0)
        return poles - 2 * c / (b * (1 + np.sqrt(1 - 4 * a * c / b**2))), w, v

    def slope(self, poles: Complex, speeds: Array, x: Complex, y: Complex) -> Complex:
        """d lambda / d Omega of modes with right and left vectors, (lanes,)."""
        zero = np.zeros_like(poles)
        turned = self.times(np.stack([zero, zero, zero, poles], axis=1), x)
        moved = self.times(np.stack([2 * poles, zero + 1, zero, speeds], axis=1), x)
        return np.asarray(-(y.conj() * turned).sum(axis=0) / (y.conj() * moved).sum(axis=0))


class _Factor:
    """D at one pole and speed, factored."""

    def __init__(self, ab: Complex, held: Index, right: Complex, below: Complex, rest: Complex) -> None:
        self.lu, self.pivots, _ = lapack.zgbtrf(ab, HALF, HALF, overwrite_ab=1)
        self.held, self.border = held, (right, below, rest)
        diagonal = self.lu[2 * HALF]
        if not diagonal.all():
            # a pole met to the last bit: a matrix one rounding beside it is taken, as in any inverse iteration
            diagonal[diagonal == 0] = np.finfo(float).eps * np.abs(diagonal).max()

    def solve(self, force: Complex, adjoint: bool = False) -> Complex:
        """D x = force or D^H x = force: (n,)."""
        n, h = self.lu.shape[1], len(self.held)
        columns = np.zeros((n, 1 + h), dtype=complex, order="F")
        columns[:, 0] = force[:n]
        columns[self.held, np.arange(1, h + 1)] = 1.0
        columns, _ = lapack.zgbtrs(self.lu, HALF, HALF, columns, self.pivots, trans=2 * adjoint, overwrite_b=1)
        x, moved = columns[:, 0], columns[:, 1:]
        right, below, rest = self.border
        if adjoint:
            right, below, rest = below.conj().T, right.conj().T, rest.conj().T
        if not len(rest):
            return np.asarray(x)
        behind = _solved(rest - below @ moved[self.held] @ right, force[n:] - below @ x[self.held])
        return np.concatenate([x - moved @ (right @ behind), behind])

    def turn(self) -> complex:
        """det D / |det D|."""
        n, diagonal = self.lu.shape[1], self.lu[2 * HALF]
        swaps = np.count_nonzero(self.pivots != np.arange(n))
        phase = complex(np.prod(diagonal / np.abs(diagonal)) * (-1) ** swaps)
        right, below, rest = self.border
        if not len(rest):
            return phase
        columns = np.zeros((n, len(self.held)), dtype=complex, order="F")
        columns[self.held, np.arange(len(self.held))] = 1.0
        columns, _ = lapack.zgbtrs(self.lu, HALF, HALF, columns, self.pivots, overwrite_b=1)
        return phase * complex(np.linalg.slogdet(rest - below @ columns[self.held] @ right)[0])


def _solved(A: Complex, b: Complex) -> Complex:
    """A x = b; where A is singular to the last bit, that of a matrix one rounding beside it."""
    try:
        return np.asarray(np.linalg.solve(A, b))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.solve(A + np.finfo(float).eps * np.abs(A).max() * np.eye(len(A)), b))


def _weights(poles: Complex, speeds: Array) -> Complex:
    return np.stack([poles**2, poles, np.ones_like(poles), poles * speeds], axis=1)


def band_of(matrices: tuple[Array, Array, Array, Array], shaft: int) -> Banded | None:
    """M, C, K and G (n, n) as a band with a border; None where they are none.

    Parameters
    ----------
    shaft : how many coordinates are the shaft's, which come first
    """
    n, b = len(matrices[0]), len(matrices[0]) - shaft
    entries = [sparse.coo_array(A) for A in matrices]
    inside = [(A.row < shaft) & (A.col < shaft) for A in entries]
    joined = [np.concatenate([A.row[A.col >= shaft], A.col[A.row >= shaft]]) for A in entries]
    held = np.unique(np.concatenate(joined))
    held = held[held < shaft]
    far = any((np.abs(A.row - A.col)[own] > HALF).any() for A, own in zip(entries, inside, strict=True))
    if far or len(held) + b > MOST_TIES * n:
        return None
    band = np.zeros((4, shaft, 3 * HALF + 1))
    for to, A, own in zip(band, entries, inside, strict=True):
        to[A.col[own], 2 * HALF + A.row[own] - A.col[own]] = A.data[own]
    right, below, rest = (
        np.array([part(A) for A in matrices])
        for part in (lambda A: A[held, shaft:], lambda A: A[shaft:, held], lambda A: A[shaft:, shaft:])
    )
    return Banded(tuple(sparse.csr_array(A) for A in entries), band.reshape(4, -1), held, right, below, rest)


@dataclass(frozen=True, eq=False)
class SmallModel:
    """The machine in a few real coordinates, the same for all speeds: M is I, `basis` (n, r)."""

    C: Array
    K: Array
    G: Array
    basis: Array

    def at(self, speed: float) -> System:
        """The small machine at a spin speed [rad/s]."""
        return System(np.eye(len(self.K)), self.C, self.K, speed * self.G)

    def poles(self, speeds: Array) -> Complex:
        """All poles at each speed: (speeds, 2r)."""
        r = len(self.K)
        rate = np.sqrt(linalg.norm(self.K, np.inf)) or 1.0
        A = np.zeros((len(speeds), 2 * r, 2 * r))
        A[:, :r, r:] = np.eye(r)
        A[:, r:, :r] = -self.K / rate**2
        A[:, r:, r:] = -(self.C + speeds[:, None, None] * self.G) / rate
        return np.asarray(rate * np.linalg.eigvals(A), dtype=complex)


def small_model(machine: Banded, size: int, count: int, reach: float = 0.0) -> SmallModel:
    """The machine in its lowest undamped modes, within the space that dampers and border reach.

    A block Krylov space: what forces at dampers and border, and two anywhere, do to the shaft again and again.

    Parameters
    ----------
    size : vectors of that space
    count, reach : so many modes, and all up to so fast [rad/s], shall be good guesses
    """
    n, (M, C, K, G) = machine.shaft, machine.parts
    size = min(size, n)
    bands = machine.band.reshape(4, n, -1).transpose(0, 2, 1)
    # the smallest shift that leaves rounding no say: a free shaft is singular
    shift = 1e-10 * (bands[2, 2 * HALF] / bands[0, 2 * HALF]).max()
    lu, pivots, _ = lapack.dgbtrf(np.asfortranarray(bands[2] + shift * bands[0]), HALF, HALF)
    damped = np.unique(np.concatenate(C.nonzero()))
    ties = np.union1d(machine.held, damped[damped < n])
    force = np.zeros((n, len(ties) + 2))
    force[ties, np.arange(len(ties))] = 1.0
    force[:, len(ties) :] = np.random.default_rng(0).standard_normal((n, 2))
    own, basis = M[:n, :n], np.zeros((n, 0))
    while basis.shape[1] < size:
        new, _ = lapack.dgbtrs(lu, HALF, HALF, np.asfortranarray(force), pivots)
        for _ in range(2):
            new -= basis @ (basis.T @ (own @ new))
            new /= np.sqrt(np.einsum("ij,ij->j", new, own @ new))
        squared, turn = linalg.eigh(new.T @ (own @ new))
        new = new @ turn[:, squared > 1e-12] / np.sqrt(squared[squared > 1e-12])
        if not new.shape[1]:
            break
        basis = np.hstack([basis, new])
        force = own @ new
    whole = linalg.block_diag(basis[:, :size], np.eye(M.shape[0] - n))
    Mr, Kr = (whole.T @ (A @ whole) for A in (M, K))
    squared, mix = linalg.eigh((Kr + Kr.T) / 2, (Mr + Mr.T) / 2)
    count = max(count, int((squared < reach**2).sum()) + 2)
    whole = whole @ mix[:, : max(size * count // 48, 3 * count // 2)]
    C, K, G = (whole.T @ (A @ whole) for A in (C, K, G))
    return SmallModel(C, K, G, whole)


def contour(height: float) -> Complex:
    """Points along the upper half of a contour: up on the right, to the left, closer above the origin, and down."""
    side, above = WIDE + 1j * np.linspace(0, 1, 3), np.linspace(1, -1, 11)[1:-1]
    return np.asarray(height * np.concatenate([side, WIDE * above * np.abs(above) + 1j, -side[::-1].conj()]))


def complete(machine: Banded, speeds: Array, poles: Complex, count: int, line: Array) -> bool:
    """Whether the machine has as many poles as the small model, `poles` (speeds, p), within a contour at every speed.

    The contour lies above the lowest `count` poles and a line (speeds,) [rad/s], where the gap to the next is wide.
    The phase of det D over the product of all lambda - p turns by half a turn along its upper half for each pole that
    is missing. It is a slow function, as the poles near by cancel; where it is not, steps are halved.
    """
    heights = []
    for row, least in zip(poles, line, strict=True):
        above = np.sort(row.imag[row.imag > 1e-9 * np.abs(row).max()])
        at = np.append(least, above)[max(count, int((above <= least).sum())) :][: GAPS + 1]
        if len(at) < 2:
            return False
        at[0] = max(at[0], least)
        gap = np.diff(np.log(at)).argmax()
        heights.append(float(np.sqrt(at[gap] * at[gap + 1])))

    def phase(row: Index, at: Complex) -> Complex:
        apart = at[:, None] - poles[row]
        return np.asarray(machine.turns(at, speeds[row]) / np.prod(apart / np.abs(apart), axis=1))

    points = np.array([contour(h) for h in heights])
    row = np.repeat(np.arange(len(speeds)), points.shape[1])
    turned = phase(row, points.ravel()).reshape(points.shape)
    ends = np.stack([points[:, :-1].ravel(), points[:, 1:].ravel()])
    phases = np.stack([turned[:, :-1].ravel(), turned[:, 1:].ravel()])
    row, turns = np.repeat(np.arange(len(speeds)), points.shape[1] - 1), np.zeros(len(speeds))
    for _ in range(HALVINGS):
        step = np.angle(phases[1] / phases[0])
        clear = np.abs(step) < MOST_TURN
        np.add.at(turns, row[clear], step[clear])
        row, (a, b), (from_, to) = row[~clear], ends[:, ~clear], phases[:, ~clear]
        if not len(row):
            return bool((np.abs(turns) < 1).all())
        middle = (a + b) / 2
        halfway = phase(row, middle)
        row, ends = np.tile(row, 2), np.stack([np.concatenate([a, middle]), np.concatenate([middle, b])])
        phases = np.stack([np.concatenate([from_, halfway]), np.concatenate([halfway, to])])
    return False


def refined(
    machine: Banded, poles: Complex, speeds: Array, x: Complex, y: Complex, order: float | None = None
) -> tuple[Array, Modes] | None:
    """The machine's modes near guesses, lane by lane, at their speeds; None where two are one or one is none.

    Parameters
    ----------
    x, y : (n, lanes) right and left vectors
    order : optional
        Each speed is moved to where Im lambda = order |Omega|.
    """
    speeds, open_ = speeds.copy(), np.arange(len(poles))
    for _ in range(STEPS):
        at, given = speeds[open_], poles[open_]
        found, w, v = machine.newton(given, at, x[:, open_], y[:, open_])
        off = np.abs(found - given) / np.abs(found)
        misfit = machine.misfit(found, at, w, np.zeros((1, 1), dtype=complex))
        poles[open_], x[:, open_], y[:, open_] = found, w, v
        done = (off <= SETTLED) & (misfit <= ROUNDING)
        if order is not None:
            slope = machine.slope(found, at, w, v)
            margin = found.imag - order * np.abs(at)
            done &= np.abs(margin) <= CROSSED * np.abs(at)
            step = np.where(done, 0.0, -margin / (slope.imag - order * np.sign(at)))
            speeds[open_], poles[open_] = at + step, found + slope * step
        open_ = open_[~done]
        if not len(open_):
            return None if _repeated(speeds, poles, x) else (speeds, Modes(poles, x))
    return None


def _repeated(speeds: Array, poles: Complex, x: Complex) -> bool:
    """Whether two neighbours are one and the same mode."""
    order = np.lexsort((poles.imag, speeds))
    a, b = order[:-1], order[1:]
    near = (np.abs(speeds[b] - speeds[a]) <= SAME * np.abs(speeds[a])) & (
        np.abs(poles[b] - poles[a]) <= SAME * np.abs(poles[a])
    )
    return any(mac(x[:, [i]], x[:, [j]])[0, 0] > 1 - SAME for i, j in zip(a[near], b[near], strict=True))
