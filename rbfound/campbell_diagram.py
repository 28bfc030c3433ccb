"""What a machine does over speed: Campbell diagram, whirl, critical speeds, unbalance response.

Anything that has `.at(speed) -> System` can be swept.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.banded import lowest_modes
from rbfound.machine import Machine
from rbfound.system import Modes, System, mac
from rbfound.units import hertz

Array = NDArray[np.float64]

Complex = NDArray[np.complex128]

Planes = tuple[NDArray[np.intp], NDArray[np.intp]] | None


# Modes beyond those that are followed, at each speed.
SPARE = 8


# A shaft of fewer nodes is done sooner as a dense matrix.
LONG = 16


class Spinning(Protocol):
    """Whatever has a System at each speed [rad/s]."""

    def at(self, speed: float) -> System:
        """The system at one speed [rad/s]."""
        ...


@dataclass(frozen=True, eq=False)
class CriticalSpeeds:
    """Speeds at which a natural frequency equals the speed of rotation, ascending.

    Attributes
    ----------
    speed : (c,) [rad/s]
    damping : (c,) [-]
    whirl : (c,) [-]   from 1, forward circles, to -1, backward circles
    """

    speed: Array
    damping: Array
    whirl: Array

    @property
    def frequency(self) -> Array:
        """The same as frequencies [Hz], (c,)."""
        return np.asarray(hertz(self.speed))


@dataclass(frozen=True, eq=False)
class Campbell:
    """Damped natural frequencies over speed, each mode followed from speed to speed.

    Attributes
    ----------
    speeds : (s,) [rad/s]
    poles : (s, m) complex [rad/s]
        Branch by branch; nan where a branch became overdamped or left the band.
    whirl : (s, m) [-]
        1 for forward circles, -1 for backward circles, 0 for motion in a plane; weighted by the squared amplitude
        along the shaft. nan without a shaft.
    """

    speeds: Array
    poles: Complex
    whirl: Array
    machine: Any = field(default=None, repr=False, compare=False)

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

        A mode that no damping reaches has a damping of zero, which comes out on either side of it: only what grows
        faster than rounding can feign, see `System.rounding`, is unstable.
        """
        growing = np.nan_to_num(self.poles.real) > 0
        if not growing.any():
            return np.zeros(self.poles.shape[1], dtype=bool)
        error = self.machine.at(float(self.speeds[-1])).rounding(self.poles)
        return np.asarray((growing & (self.poles.real > error)).any(axis=0))

    def critical_speeds(self) -> CriticalSpeeds:
        """Where branches cross the line frequency = speed, refined on the machine itself to 1e-9."""
        found = []
        margin = self.poles.imag - self.speeds[:, None]
        # a speed of the sweep that is itself a critical one belongs to the step that ends there
        margin[np.abs(margin) <= 1e-9 * self.speeds[:, None]] = 0
        crossing = (margin[:-1] * margin[1:] < 0) | (margin[1:] == 0)
        crossing[:1] |= margin[:1] == 0
        step, branch = np.nonzero(crossing)
        poles = _refine(
            self.machine, self.speeds[[step, step + 1]], self.poles[[step, step + 1], branch], self.poles.shape[1]
        )
        for pole, whirl in zip(poles, self.whirl[step, branch], strict=True):
            found.append((pole.imag, -pole.real / abs(pole), whirl))
        found.sort()
        speed, damping, whirl = np.array(found).reshape(-1, 3).T
        return CriticalSpeeds(speed, damping, whirl)


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
    # a few more than are followed, so that branches which cross the last one are not lost
    kept, planes = _lowest(machine, speeds, count + SPARE, above)
    count = min(count, len(kept[0].poles))
    order = np.arange(count)
    branches = [order]
    for before, after in pairwise(kept):
        order = _follow(before, after, order)
        branches.append(order)
    poles = np.array([_pick(m.poles, b) for m, b in zip(kept, branches, strict=True)])
    turns = np.array([_pick(_whirl(m, where), b) for m, where, b in zip(kept, planes, branches, strict=True)])
    return Campbell(speeds, poles, turns.real, machine)


def _lowest(machine: Spinning, speeds: Array, count: int, above: float) -> tuple[list[Modes], list[Planes]]:
    """The lowest modes above a frequency [Hz] at each speed, and which coordinates are the shaft's."""
    if isinstance(machine, Machine) and machine.banded is not None and len(machine.mesh.z) >= LONG:
        found = lowest_modes(machine.banded, speeds, count, above)
        if found is not None:
            return found, [machine.mesh.planes] * len(speeds)
    modes, planes = [], []
    for speed in speeds:
        system = machine.at(float(speed))
        every = system.modes().above(above)
        modes.append(Modes(every.poles[:count], every.shapes[:, :count]))
        planes.append(system.planes)
    return modes, planes


def whirl_direction(modes: Modes, system: System) -> Array:
    """Direction of whirl of each mode, from 1 (forward circles) to -1 (backward circles), (m,).

    The turning sense of each node's orbit, -2 Im(conj(x) y), over the sum of |x|^2 + |y|^2.
    """
    return _whirl(modes, system.planes)


def _whirl(modes: Modes, planes: Planes) -> Array:
    if planes is None:
        return np.full(len(modes.poles), np.nan)
    x, y = (modes.shapes[plane] for plane in planes)
    size = (np.abs(x) ** 2 + np.abs(y) ** 2).sum(axis=0)
    return np.asarray(-2 * np.imag(x.conj() * y).sum(axis=0) / np.where(size > 0, size, 1.0))


def _follow(before: Modes, after: Modes, order: NDArray[np.intp]) -> NDArray[np.intp]:
    """Which mode of the next speed continues each branch; -1 for none. Closest pole and likest shape first."""
    alive = np.flatnonzero(order >= 0)
    old = order[alive]
    distance = np.abs(before.poles[old][:, None] - after.poles[None, :])
    cost = distance / np.abs(before.poles[old])[:, None] + 1 - mac(before.shapes[:, old], after.shapes)
    following = np.full(len(order), -1)
    taken = np.zeros(cost.shape[1], dtype=bool)
    for row, column in zip(*np.unravel_index(np.argsort(cost, axis=None), cost.shape), strict=True):
        if following[alive[row]] < 0 and not taken[column]:
            following[alive[row]], taken[column] = column, True
            if (following[alive] >= 0).all():
                break
    return following


def _pick(values: NDArray[Any], branch: NDArray[np.intp]) -> Complex:
    picked = np.full(len(branch), complex(np.nan, np.nan))
    picked[branch >= 0] = values[branch[branch >= 0]]
    return picked


def _refine(machine: Spinning, speeds: Array, poles: Complex, count: int) -> Complex:
    """The poles of some branches at the speeds that equal their frequencies, by false position between two speeds each.

    Speeds and poles are (2, c): all branches are refined side by side.
    """
    (a, b), (fa, fb) = speeds.copy(), poles.imag - speeds
    pole, speed = poles[0].copy(), (a * fb - b * fa) / (fb - fa)
    open_ = np.arange(poles.shape[1])
    for _ in range(30):
        if not len(open_):
            break
        k, now = open_, speed[open_]
        expected = poles[0, k] + (poles[1, k] - poles[0, k]) * (now - speeds[0, k]) / (speeds[1, k] - speeds[0, k])
        found, _ = _lowest(machine, now, count + 2 * SPARE, float(hertz(expected.imag.min())) / 2)
        pole[k] = [modes.poles[np.abs(modes.poles - at).argmin()] for modes, at in zip(found, expected, strict=True)]
        margin = pole[k].imag - now
        # the slope between here and the nearer end; false position where that leads out of the bracket
        end, f_end = np.where(now - a[k] < b[k] - now, (a[k], fa[k]), (b[k], fb[k]))
        right = margin * fa[k] < 0
        b[k], fb[k] = np.where(right, now, b[k]), np.where(right, margin, fb[k])
        a[k], fa[k] = np.where(right, a[k], now), np.where(right, fa[k], margin)
        with np.errstate(all="ignore"):
            speed[k] = now - margin * (now - end) / (margin - f_end)
            inside = (a[k] < speed[k]) & (speed[k] < b[k])
            speed[k] = np.where(inside, speed[k], (a[k] * fb[k] - b[k] * fa[k]) / (fb[k] - fa[k]))
        open_ = k[np.abs(margin) > 1e-9 * now]
    return pole
