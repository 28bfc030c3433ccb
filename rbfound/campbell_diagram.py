"""Campbell diagram, whirl, critical speeds: of anything that has `.at(speed) -> System`."""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg
from scipy.linalg import lapack
from scipy.optimize import linear_sum_assignment

from rbfound.banded import SIZES, SmallModel, complete, refined, small_model
from rbfound.machine import Machine
from rbfound.parallel import one_thread
from rbfound.system import LOST, ZERO_POLE, Modes, System
from rbfound.units import from_hertz, hertz, rpm

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.intp]
# A shaft of fewer nodes is done sooner as a dense matrix.
LONG = 16
# A step between two speeds is halved at most so often, where it is not clear which mode continues which, and where the
# count of poles above the line of rotation does not agree with the crossings found.
FOLLOWING, COUNTING = 6, 14
# A mode continues another one beyond doubt if left and right vectors agree so well; in the smallest step it does so if
# they agree by half, or the pole has moved by no more than this part of itself.
ALIKE, HALF, STILL = 0.8, 0.5, 0.01
# Im lambda = order |Omega| holds to this, relative; ends of the range are widened by more, so that a critical speed at
# an end is inside.
EXACT, WIDER = 1e-9, 1e-7
# Steps of Newton's method for a crossing; modes beyond those that are followed.
NEWTON, SPARE = 25, 8
# Two modes at rest whose poles are as close, relative, have no direction of whirl.
DEGENERATE = 1e-6


class Spinning(Protocol):
    """Whatever has a System at each speed [rad/s]."""

    def at(self, speed: float) -> System:
        """The system at one speed [rad/s]."""
        ...


@dataclass(frozen=True, eq=False)
class CriticalSpeeds:
    """Speeds at which a natural frequency equals the speed of rotation, or a multiple of it, ascending.

    Attributes
    ----------
    speed : (c,) [rad/s]
    damping : (c,) [-]
    whirl : (c,) [-]   from 1, forward circles, to -1, backward circles
    order : what multiple of the speed of rotation the natural frequency is
    """

    speed: Array
    damping: Array
    whirl: Array
    order: float = 1.0

    @property
    def frequency(self) -> Array:
        """The natural frequencies [Hz], (c,)."""
        return np.asarray(hertz(self.order * np.abs(self.speed)))


@dataclass(frozen=True, eq=False)
class Campbell:
    """Damped natural frequencies over speed, each mode followed from speed to speed.

    Attributes
    ----------
    speeds : (s,) [rad/s]
    poles : (s, m) complex [rad/s]
        Branch by branch; nan where a branch has ended: it became overdamped or slower than `above`.
    whirl : (s, m) [-]
        1 for forward circles, -1 for backward circles, 0 for motion in a plane; weighted by the squared amplitude
        along the shaft. nan without a shaft, and at rest where X and Y are alike: any direction is a mode there.
    above : [Hz]
        Slower modes are left out.
    """

    speeds: Array
    poles: Complex
    whirl: Array
    machine: Any = field(default=None, repr=False, compare=False)
    above: float = 1.0
    model: Any = field(default=None, repr=False, compare=False)

    @property
    def frequency(self) -> Array:
        """(s, m) [Hz]"""
        return np.asarray(hertz(self.poles.imag))

    @property
    def damping(self) -> Array:
        """(s, m) [-], negative where the machine is unstable, or by rounding where nothing damps it: see `unstable`."""
        return np.asarray(-self.poles.real / np.abs(self.poles))

    def unstable(self) -> NDArray[np.bool_]:
        """Which branches are unstable at some speed, (m,).

        A mode that nothing damps has a damping of zero, which rounding puts on either side of it. So a branch that
        seems to grow is tried by the energy of its shape, which is free of that: see `System.growth`.
        """
        out, rate = np.zeros(self.poles.shape[1], dtype=bool), np.nan_to_num(-self.damping)
        for branch in np.flatnonzero((rate > 0).any(axis=0)):
            k = rate[:, branch].argmax()
            pole = self.poles[k, branch]
            out[branch] = self.machine.at(float(self.speeds[k])).growth(pole) > EXACT * abs(pole)
        return out

    @one_thread
    def critical_speeds(self, order: float = 1.0) -> CriticalSpeeds:
        """Every speed of the range at which a natural frequency is `order` times the speed of rotation.

        They are those of the machine, however many branches were followed. In each step the crossings have to agree
        with the count of poles above the line at both ends; a step where they do not is halved, and in the end
        there is a warning. Each is refined until Im lambda = order |Omega| to 1e-9. Below `above` none is sought.

        Raises
        ------
        ValueError
            When the order is not positive.
        """
        if not 0 < order < np.inf:
            raise ValueError(f"order = {order:g}: it must be positive and finite, such as 1, 2 or 0.5.")
        if self.machine is None:
            raise ValueError("This diagram was made without its machine: critical speeds need it.")
        known = [self.model] if self.model is not None and order <= 1 else []
        models = _models(self.machine, self.speeds, self.poles.shape[1], order, self.above)
        return next(found for found in (_critical_speeds(m, order) for m in chain(known, models)) if found is not None)


@one_thread
def campbell(machine: Spinning, speeds: ArrayLike, count: int = 12, above: float = 1.0) -> Campbell:
    """Campbell diagram of a machine.

    Parameters
    ----------
    machine : whatever has .at(speed) -> System
    speeds : (s,) [rad/s], ascending
    count : int
        Modes to follow: the lowest ones at the first speed.
    above : float [Hz]
        Slower modes are left out: rigid-body and overdamped ones.

    Raises
    ------
    ValueError
        When the speeds are not finite and ascending.
    """
    speeds = np.atleast_1d(np.asarray(speeds, dtype=float))
    if speeds.ndim != 1 or not len(speeds) or not np.isfinite(speeds).all() or (np.diff(speeds) <= 0).any():
        raise ValueError("speeds must be finite and ascending, and at least one [rad/s].")
    models = _models(machine, speeds, count, 1.0, above)
    return next(found for found in (_diagram(model, count) for model in models) if found is not None)


def _diagram(model: "_Model", count: int) -> Campbell | None:
    """The branches of a model; None where it has poles that the machine has not."""
    speeds, kept, slow = model.speeds, [model.spectrum(float(speed)) for speed in model.speeds], from_hertz(model.above)
    order = np.flatnonzero(kept[0].poles.imag > slow)[:count]
    branches = [order]
    for before, after in pairwise(kept):
        order = _follow(model, before, after, order, FOLLOWING)
        branches.append(order)
    row, column = np.nonzero(np.array(branches) >= 0)
    exact = model.exact([kept[k].mode(branches[k][b]) for k, b in zip(row, column, strict=True)])
    if exact is None:
        return None
    found = exact[1]
    whirl = np.full((len(speeds), len(order)), np.nan)
    poles = whirl + 1j * whirl
    poles[row, column] = found.poles
    if model.planes is not None:
        whirl[row, column] = _turning(speeds[row]) * found.whirl(model.planes)
        for k in np.flatnonzero(speeds == 0):
            alike = np.abs(poles[k][:, None] - kept[k].poles) <= DEGENERATE * np.abs(poles[k])[:, None]
            whirl[k, alike.sum(axis=1) > 1] = np.nan
    return Campbell(speeds, poles, whirl, model.machine, model.above, model)


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """The poles of one speed, Im lambda > 0 ascending, and vectors of the state, (2r, p): left^H right = 1."""

    speed: float
    poles: Complex
    right: Complex
    left: Complex

    def mode(self, k: int) -> "_Spectrum":
        """One of them."""
        return _Spectrum(self.speed, self.poles[[k]], self.right[:, [k]], self.left[:, [k]])

    def likeness(self, other: "_Spectrum") -> Array:
        """1 where a mode of this speed continues as one of another, (p, q)."""
        return np.abs((self.left.conj().T @ other.right) * (other.left.conj().T @ self.right).T)


class _Model:
    """A machine, or the small model of a long one, over a range of speeds."""

    def __init__(self, machine: Spinning, speeds: Array, above: float, small: SmallModel | None = None) -> None:
        self.machine, self.speeds, self.above, self.small = machine, speeds, above, small
        self.planes = machine.at(float(speeds[-1])).planes
        self.rate = 1.0
        A = self.state(float(speeds[-1]))
        self.rate = float(np.sqrt(linalg.norm(A[len(A) // 2 :, : len(A) // 2], np.inf))) or 1.0
        self.known: dict[float, _Spectrum] = {}

    def system(self, speed: float) -> System:
        """The system at a speed; at the ends of the range for what lies a rounding beside them."""
        return (self.small or self.machine).at(float(np.clip(speed, self.speeds[0], self.speeds[-1])))

    def state(self, speed: float) -> Array:
        """The state matrix in units of time of the fastest mode, so that both halves of the state have one size."""
        A, L = self.system(speed).state_matrix()
        n = len(L)
        A[n:, :n] /= self.rate**2
        A[n:, n:] /= self.rate
        return A

    def spectrum(self, speed: float) -> _Spectrum:
        """All poles with Im lambda > 0, and their vectors."""
        if speed not in self.known:
            every, left, right = linalg.eig(self.state(speed), left=True, right=True)
            every = every * self.rate
            zero = ZERO_POLE * np.abs(every).max(initial=0.0)
            if hertz(zero) > LOST:
                # an error where it tells nothing
                self.system(speed).modes()
            some = np.flatnonzero((every.imag > 0) & (np.abs(every) > zero))
            damping = -every[some].real / np.abs(every[some])
            some = some[np.lexsort((damping, every[some].imag))]
            left, right = left[:, some], right[:, some]
            scale = (left.conj() * right).sum(axis=0)
            left = left / np.where(scale == 0, np.finfo(float).tiny, scale).conj()
            self.known[speed] = _Spectrum(speed, every[some], right, left)
        return self.known[speed]

    def slopes(self, some: _Spectrum) -> Complex:
        """d lambda / d Omega of some modes, (p,)."""
        step = 1e-4 * max(abs(some.speed), 1e-2 * float(np.abs(self.speeds).max()), 1e-3)
        ends = np.clip([some.speed - step, some.speed + step], self.speeds[0], self.speeds[-1])
        if ends[0] == ends[1]:
            return np.zeros(len(some.poles), dtype=complex)
        change = (self.state(ends[1]) - self.state(ends[0])) * (self.rate / (ends[1] - ends[0]))
        return np.asarray((some.left.conj() * (change @ some.right)).sum(axis=0))

    def newton(self, mode: _Spectrum) -> _Spectrum:
        """A mode at its speed, by a step of inverse iteration with both vectors."""
        A = self.state(mode.speed)
        at = mode.poles[0] / self.rate
        lu, pivots, _ = lapack.zgetrf(A - at * np.eye(len(A)))
        # a pole met to the last bit: a matrix one rounding beside it is taken
        lu[np.diag_indices_from(lu)] += np.finfo(float).eps * (lu.diagonal() == 0)
        right, left = (lapack.zgetrs(lu, pivots, x, trans=t)[0] for x, t in ((mode.right, 0), (mode.left, 2)))
        grown = (left.conj() * right).sum()
        pole = mode.poles + self.rate * (left.conj() * mode.right).sum() / grown
        size = linalg.norm(right)
        return _Spectrum(mode.speed, pole, right / size, left * (size / grown.conj()))

    def exact(self, modes: list[_Spectrum], order: float | None = None) -> tuple[Array, Modes] | None:
        """Modes of the machine itself, each at its own speed, or with an order where it crosses that line.

        None where one of the small model's is none of the machine.
        """
        speeds = np.array([mode.speed for mode in modes])
        if not modes:
            return speeds, Modes(np.zeros(0, dtype=complex), np.zeros((0, 0), dtype=complex))
        poles, r = np.array([mode.poles[0] for mode in modes]), len(modes[0].right) // 2
        right = np.array([mode.right[:r, 0] for mode in modes]).T
        if self.small is None or not isinstance(self.machine, Machine) or self.machine.banded is None:
            L = linalg.cholesky(self.system(float(speeds[0])).M, lower=True)
            return speeds, Modes(poles, linalg.solve_triangular(L.T, right))
        left = np.array([mode.left[r:, 0] for mode in modes]).T
        basis = self.small.basis
        return refined(self.machine.banded, poles, speeds, basis @ right, basis @ left, order)


def _models(machine: Spinning, speeds: Array, count: int, order: float, above: float) -> Iterator[_Model]:
    """Small models that have all poles of a long machine that are asked for, one after the other; then the machine."""
    if isinstance(machine, Machine) and machine.banded is not None and len(machine.mesh.z) >= LONG:
        line = order * np.abs(speeds)
        for size in SIZES:
            small = small_model(machine.banded, size, count + SPARE, float(line.max()))
            if complete(machine.banded, speeds, small.poles(speeds), count, line):
                yield _Model(machine, speeds, above, small)
    yield _Model(machine, speeds, above)


def whirl_direction(modes: Modes, system: System) -> Array:
    """Direction of whirl of each mode, from 1 (forward circles) to -1 (backward circles), (m,)."""
    return modes.whirl(system.planes)


def _turning(speeds: Array) -> Array:
    """1, or -1 where the machine turns from Y to X: whirl is forward in the direction of rotation."""
    return np.where(speeds < 0, -1.0, 1.0)


def _follow(model: _Model, before: _Spectrum, after: _Spectrum, order: Index, halvings: int) -> Index:
    """Which mode of the next speed continues each branch; -1 for none. The step is halved where two are candidates."""
    alive = np.flatnonzero(order >= 0)
    following = np.full(len(order), -1)
    if not len(alive):
        return following
    old = order[alive]
    like = before.likeness(after)[old]
    moved = np.abs(before.poles[old][:, None] - after.poles) / np.abs(before.poles[old])[:, None]
    row, column = linear_sum_assignment(np.minimum(moved, 10.0) + 1 - np.minimum(like, 1))
    sure = like[row, column] >= ALIKE
    if halvings and not (sure.all() and len(row) == len(alive)):
        middle = model.spectrum((before.speed + after.speed) / 2)
        halfway = _follow(model, before, middle, order, halvings - 1)
        return _follow(model, middle, after, halfway, halvings - 1)
    kept = (like[row, column] >= HALF) | (moved[row, column] <= STILL)
    kept &= after.poles[column].imag > from_hertz(model.above)
    following[alive[row[kept]]] = column[kept]
    return following


def _critical_speeds(model: _Model, order: float) -> CriticalSpeeds | None:
    """All critical speeds; None where a crossing of the small model is none of the machine."""
    low, high = model.speeds[[0, -1]] + WIDER * np.abs(model.speeds).max() * np.array([-1, 1])
    least = from_hertz(model.above) / order
    points = np.unique([low, *model.speeds[1:-1], high, *(end for end in (-least, least) if low < end < high)])
    modes: list[_Spectrum] = []
    for side in (points[points <= -least], points[points >= least]):
        steps = pairwise([_off_the_line(model, float(p), order) for p in side])
        modes += [mode for a, b in steps for mode in _crossings(model, a, b, order, COUNTING)]
    found = model.exact(modes, order)
    if found is None:
        return None
    speeds, exact = found
    whirl = _turning(speeds) * exact.whirl(model.planes) if len(speeds) else np.zeros(0)
    some = np.argsort(speeds)
    return CriticalSpeeds(speeds[some], exact.damping[some], whirl[some], order)


def _off_the_line(model: _Model, speed: float, order: float) -> _Spectrum:
    """The poles of a speed, or of one close by if a critical speed lies on it: there the count is open."""
    while True:
        found, line = model.spectrum(speed), order * abs(speed)
        if not (np.abs(found.poles.imag - line) <= EXACT * 10 * line).any():
            return found
        speed *= 1 + 3 * WIDER


def _crossings(model: _Model, a: _Spectrum, b: _Spectrum, order: float, halvings: int) -> list[_Spectrum]:
    """The modes that cross the line between two speeds, each at its crossing."""
    turning, step = float(np.sign(a.speed + b.speed)), b.speed - a.speed
    found, net = list[_Spectrum](), 0
    for end, ahead in ((a, 1.0), (b, -1.0)):
        margin = end.poles.imag - order * abs(end.speed)
        slope = model.slopes(end).imag - order * turning
        with np.errstate(divide="ignore", invalid="ignore"):
            way = -margin / slope * ahead
        # a branch that bends towards the line meets it before its tangent does, seen from one of both ends
        for k in np.flatnonzero((way >= 0) & (way <= 1.2 * step)):
            mode, up = _crossing(model, end.mode(int(k)), order, (a.speed - step, b.speed + step))
            known = (abs(mode.speed - o.speed) <= WIDER * abs(o.speed) and mode.likeness(o)[0, 0] > HALF for o in found)
            if up and a.speed < mode.speed <= b.speed and not any(known):
                found.append(mode)
                net += up
    gained = int((b.poles.imag > order * abs(b.speed)).sum()) - int((a.poles.imag > order * abs(a.speed)).sum())
    if net == gained:
        return found
    if not halvings:
        warnings.warn(
            f"Near {rpm(a.speed):.6g} rev/min the number of poles above the line changes by {gained}, and by {net} at "
            "the crossings found: a critical speed there may be missing.",
            stacklevel=2,
        )
        return found
    middle = _off_the_line(model, (a.speed + b.speed) / 2, order)
    return [mode for s, e in ((a, middle), (middle, b)) for mode in _crossings(model, s, e, order, halvings - 1)]


def _crossing(model: _Model, mode: _Spectrum, order: float, within: tuple[float, float]) -> tuple[_Spectrum, int]:
    """Where a mode crosses the line, by Newton's method for pole and speed, and 1 up, -1 down, 0 for nowhere."""
    turning = float(np.sign(mode.speed))
    for _ in range(NEWTON):
        guess, mode = mode, model.newton(mode)
        slope, line = model.slopes(mode), order * abs(mode.speed)
        margin, rise = mode.poles[0].imag - line, slope[0].imag - order * turning
        if max(abs(margin), abs(mode.poles[0] - guess.poles[0])) <= EXACT * line:
            return mode, int(np.sign(rise))
        step = -margin / rise if rise else np.inf
        if not within[0] <= mode.speed + step <= within[1] or not np.isfinite(mode.poles).all():
            break
        mode = _Spectrum(mode.speed + step, mode.poles + slope * step, mode.right, mode.left)
    return mode, 0
