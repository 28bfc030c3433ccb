"""The lowest modes of a chain at many speeds: guessed in a small model, then made exact, and counted.

A real basis, the same for all speeds, gives a small problem at each speed. Each of its modes starts Newton's method on
the whole machine, all modes of all speeds side by side. What it finds is kept if its last step and its residual say
that it is a mode, if no two are one, and if the machine has as many poles as the small problem within a contour:
the turns of det D along it count them. Otherwise the answer is None, and somebody has to take the long road.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.elimination import ROUNDING, solve, solve_twice, turns
from rbfound.nodechain import Chain
from rbfound.system import Modes, in_order, mac
from rbfound.units import radians

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Motion = tuple[Complex, Complex]

# Vectors of a plane's basis, tried in turn.
SIZES = (36, 72)
# Newton's steps, and the size of the last one, relative, that is the end: the error left is of its square.
STEPS, SETTLED = 5, 1e-6
# A step away from a pole, relative: far beyond rounding, and still a good start.
BESIDE = 1e-7
# Neighbours as close as this, relative, are parted in their common plane: Newton's method might find one of them twice.
CLOSE = 1e-2
# Two modes of one speed are the same one if they are as close in both pole and shape.
SAME = 1e-6
# A phase that turns by more between two neighbours on a contour might have turned the other way round.
MOST_TURN = 2.5


@dataclass(frozen=True, eq=False)
class SmallModel:
    """The machine in a real basis: M is I, the rest (r, r); `basis` (2 nodes, p) in one plane, `mix` (2p + rest, r)."""

    C: Array
    K: Array
    G: Array
    basis: Array
    mix: Array

    def modes(self, speeds: Array) -> tuple[Complex, Complex]:
        """All poles and shapes at each speed: (speeds, 2r) and (speeds, r, 2r)."""
        r = len(self.K)
        rate = np.sqrt(linalg.norm(self.K, np.inf)) or 1.0
        A = np.zeros((len(speeds), 2 * r, 2 * r))
        A[:, :r, r:] = np.eye(r)
        A[:, r:, :r] = -self.K / rate**2
        A[:, r:, r:] = -(self.C + speeds[:, None, None] * self.G) / rate
        poles, vectors = np.linalg.eig(A)
        return np.asarray(rate * poles), np.asarray(vectors[:, :r])


def lowest_modes(chain: Chain, speeds: Array, count: int, above: float) -> list[Modes] | None:
    """The lowest modes above a frequency [Hz] at each speed [rad/s], or None where they are not certain.

    Parameters
    ----------
    count : int
        So many are wanted at each speed; up to there, none with a damping ratio below 0.98 is left out.
    """
    for size in SIZES:
        small = small_model(chain, size, size * count // 24)
        guessed, shapes = small.modes(speeds)
        slow = float(radians(above))
        order = np.argsort(np.where(guessed.imag > slow, guessed.imag, np.inf), axis=1)[:, :count]
        start = np.take_along_axis(guessed, order, axis=1)
        if not (start.imag > slow).all():
            continue
        if not complete(chain, speeds, guessed, start):
            continue
        modes = _polished(chain, small, speeds, start, np.take_along_axis(shapes, order[:, None, :], axis=2))
        if modes is not None:
            return modes
    return None


def small_model(chain: Chain, size: int, kept: int) -> SmallModel:
    """The machine in a few real coordinates, good for its lowest modes."""
    basis = _plane_basis(chain, min(size, 2 * chain.nodes))
    p, rest = basis.shape[1], chain.rest
    M, G, K = (basis.T @ _times(chain, k, basis) for k in range(3))
    at = basis.reshape(-1, 2, p)[chain.node, chain.slope]
    picked = linalg.block_diag(at, at, np.eye(rest))
    zero, far = np.zeros((p, p)), np.zeros((rest, rest))
    own = [linalg.block_diag(A, A, far) for A in (M, zero, K)]
    own.append(linalg.block_diag(np.block([[zero, G], [-G, zero]]), far))
    M, C, K, G = (A + picked.T @ tie @ picked for A, tie in zip(own, chain.ties, strict=True))
    _, mix = linalg.eigh((K + K.T) / 2, (M + M.T) / 2)
    mix = mix[:, :kept]
    C, K, G = (mix.T @ A @ mix for A in (C, K, G))
    return SmallModel(C, K, G, basis, mix)


def _plane_basis(chain: Chain, size: int) -> Array:
    """A basis of one plane of the free shaft, (2 nodes, size), M-orthonormal.

    A block Krylov space: what forces at the ties, and one anywhere, do to the shaft again and again.
    """
    nodes = chain.nodes
    M, K = (_banded(chain, k) for k in (0, 2))
    # the smallest shift that leaves rounding no say: the free shaft alone is singular
    shift = 1e-10 * (K[0] / M[0]).max()
    factor = linalg.cholesky_banded(K + shift * M, lower=True)
    force = np.zeros((2 * nodes, len(chain.node) + 1))
    force[2 * chain.node + chain.slope, np.arange(len(chain.node))] = 1.0
    force[:, -1] = np.random.default_rng(0).standard_normal(2 * nodes)
    basis = np.zeros((2 * nodes, 0))
    while basis.shape[1] < size:
        new = linalg.cho_solve_banded((factor, True), force)
        for _ in range(2):
            new -= basis @ (basis.T @ _times(chain, 0, new))
            new /= np.sqrt(np.einsum("ij,ij->j", new, _times(chain, 0, new)))
        squared, turn = linalg.eigh(new.T @ _times(chain, 0, new))
        new = new @ turn[:, squared > 1e-12] / np.sqrt(squared[squared > 1e-12])
        if not new.shape[1]:
            break
        basis = np.hstack([basis, new])
        force = _times(chain, 0, new)
    return basis[:, :size]


def _banded(chain: Chain, which: int) -> Array:
    """Lower bands of one plane's M, G or K, (4, 2 nodes)."""
    bands = np.zeros((4, 2 * chain.nodes))
    a11, a12, a22 = chain.inner[which].T
    b11, b12, b21, b22 = chain.outer[which].T
    bands[0, ::2], bands[0, 1::2], bands[1, ::2] = a11, a22, a12
    bands[1, 1:-2:2], bands[2, :-2:2], bands[2, 1:-2:2], bands[3, :-2:2] = b21, b11, b22, b12
    return bands


def _times(chain: Chain, which: int, x: Array) -> Array:
    """One plane's M, G or K times vectors (2 nodes, p)."""
    return np.asarray(chain.times(which, x.reshape(1, chain.nodes, 2, -1)).reshape(x.shape))


def complete(chain: Chain, speeds: Array, guessed: Complex, start: Complex) -> bool:
    """Whether the machine has as many poles as the small model within a contour, at every speed.

    Half of it runs above the real axis: up on the right, to the left through the widest gap above the wanted modes, and
    down beyond a damping ratio of 0.98. The other half is its mirror image, where det D is the conjugate.
    """
    points, height, width = contours(guessed, start)
    inside = (np.abs(guessed.imag) < height[:, None]) & (np.abs(guessed.real) < width[:, None])
    fresh = np.hstack([np.ones((len(speeds), 1), dtype=bool), np.diff(points, axis=1) != 0])
    turned = np.empty(points.shape, dtype=complex)
    turned[fresh] = turns(chain, points[fresh], np.broadcast_to(speeds[:, None], points.shape)[fresh])
    steps = np.zeros(points.shape)
    for k, (turn, new) in enumerate(zip(turned, fresh, strict=True)):
        steps[k, : new.sum() - 1] = np.angle(turn[new][1:] / turn[new][:-1])
    return bool(np.abs(steps).max() < MOST_TURN and (np.rint(steps.sum(axis=1) / np.pi) == inside.sum(axis=1)).all())


def contours(poles: Complex, wanted: Complex) -> tuple[Complex, Array, Array]:
    """Points along the upper half of each contour, (speeds, points), its height and its half width.

    A step turns the phase that the small model has by one radian at most. Points at the end repeat.
    """
    heights = np.sort(wanted.imag, axis=1)
    least = 2 * heights.shape[1] // 3 - 1
    gap = least + np.diff(np.log(heights[:, least:]), axis=1).argmax(axis=1)
    rows = np.arange(len(heights))
    height = np.sqrt(heights[rows, gap] * heights[rows, gap + 1])
    width = 5 * height
    gone = np.zeros(len(height))
    points = []
    while True:
        up, left = np.minimum(gone, height), np.clip(gone - height, 0, 2 * width)
        down = np.clip(gone - height - 2 * width, 0, height)
        points.append(width - left + 1j * (up - down))
        if (gone >= 2 * (height + width)).all():
            return np.array(points).T, height, width
        apart = points[-1][:, None] - poles
        apart[apart == 0] = height.min() * np.finfo(float).eps
        # at a pole the way would end: what is too quick to be followed there is seen by `complete`
        turning = np.maximum(np.abs((1 / apart).sum(axis=1)), 1.2 / np.abs(apart).min(axis=1))
        gone = gone + np.maximum(1.5 / turning, 1e-3 * (height + width))
        gone = np.minimum(gone, 2 * (height + width))


def _polished(chain: Chain, small: SmallModel, speeds: Array, start: Complex, shapes: Complex) -> list[Modes] | None:
    """Newton's method for (lambda, x) from each guess: D w = D' x, lambda -= (c x) / (c w), x = w."""
    s, m = start.shape
    p = small.basis.shape[1]
    full = np.einsum("ij,sjm->ism", small.mix, shapes).reshape(len(small.mix), s * m)
    u, v = ((small.basis @ part).reshape(chain.nodes, 2, -1) for part in (full[:p], full[p : 2 * p]))
    x = np.stack([u + 1j * v, u - 1j * v]), full[2 * p :]
    poles, at = start.ravel(), np.repeat(speeds, m)
    for turn in range(STEPS):
        poles, x, off = _newton(solve, chain, poles, at, x)
        if turn == 0:
            _part_neighbours(chain, poles, at, x, m)
        if not np.isfinite(off).all():
            return None
        if off.max() <= SETTLED:
            break
    bad = np.flatnonzero(chain.misfit(poles, at, x) > ROUNDING)
    if len(bad):
        # at the pole itself a chain may be singular before its ends are tied: from beside it
        beside, some = poles[bad] * (1 + BESIDE), (x[0][..., bad], x[1][..., bad])
        poles[bad], better, _ = _newton(solve_twice, chain, beside, at[bad], some)
        for part, new in zip(x, better, strict=True):
            part[..., bad] = new
        bad = bad[~(chain.misfit(poles[bad], at[bad], better) <= ROUNDING)]
    if not off.max() <= SETTLED or len(bad):
        return None
    vectors = chain.vector(*x).reshape(-1, s, m).transpose(1, 0, 2)
    found = [in_order(p, q) for p, q in zip(poles.reshape(s, m), vectors, strict=True)]
    return None if any(map(_repeated, found)) else found


def _newton(
    answer: Callable[[Chain, Complex, Array, Complex, Complex], Motion],
    chain: Chain,
    poles: Complex,
    at: Array,
    x: Motion,
) -> tuple[Complex, Motion, Array]:
    """One step of every pole and its motion, and how far the poles moved, relative."""
    x = _unit(x)
    w = answer(chain, poles, at, *chain.slope_of_stiffness(poles, at, *x))
    step = 1 / _dot(x, w)
    return poles - step, w, np.abs(step / poles)


def _part_neighbours(chain: Chain, poles: Complex, at: Array, x: Motion, m: int) -> None:
    """Replace each two close modes of a speed by what D makes of the plane that they span; m modes a speed, in place.

    Within the plane (D + (lambda' - lambda) D') w = 0, with D at one of the two poles.
    """
    close = np.abs(np.diff(poles)) <= CLOSE * np.abs(poles[1:])
    close[m - 1 :: m] = False
    # of three in a row the first two
    close[1:] &= ~close[:-1]
    first = np.flatnonzero(close)
    if not len(first):
        return
    pole, speed = poles[first], at[first]
    pair = [_unit((x[0][..., k], x[1][..., k])) for k in (first, first + 1)]
    forces = [[D(pole, speed, *w) for w in pair] for D in (chain.stiffness, chain.slope_of_stiffness)]
    A, B = (np.array([[_dot(v, f) for f in force] for v in pair]).transpose(2, 0, 1) for force in forces)
    shift, mix = np.linalg.eig(-np.linalg.solve(B, A))
    for k in range(2):
        poles[first + k] = pole + shift[:, k]
        for part, (a, b) in zip(x, zip(*pair, strict=True), strict=True):
            part[..., first + k] = a * mix[:, 0, k] + b * mix[:, 1, k]


def _dot(a: Motion, b: Motion) -> Complex:
    lanes = a[0].shape[-1]
    return np.asarray(sum((p.conj() * q).reshape(-1, lanes).sum(axis=0) for p, q in zip(a, b, strict=True)))


def _unit(x: Motion) -> Motion:
    size = np.sqrt(_dot(x, x).real)
    return x[0] / size, x[1] / size


def _repeated(modes: Modes) -> bool:
    """Whether two neighbours are one and the same mode."""
    near = np.abs(np.diff(modes.poles)) <= SAME * np.abs(modes.poles[1:])
    return any(mac(modes.shapes[:, [k]], modes.shapes[:, [k + 1]])[0, 0] > 1 - SAME for k in np.flatnonzero(near))
