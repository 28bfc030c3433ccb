"""What a machine does over speed: Campbell diagram, whirl, critical speeds, unbalance response.

Anything that has `.at(speed) -> System` can be swept.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.system import Modes, System, mac
from rbfound.units import hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Spinning(Protocol):
    """Whatever has a System at each speed [rad/s]."""

    def at(self, speed: float) -> System:
        """The system at one speed [rad/s]."""
        ...


class Placed(Protocol):
    """A machine whose shaft can be asked for the coordinate of a place."""

    def coordinate(self, z: float, direction: str) -> int:
        """Index of the displacement "x" or "y" at a position [m]."""
        ...


class Shafted(Spinning, Placed, Protocol):
    """Both: it can be swept, and be asked for a place."""


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
        """(s, m) [-], negative where the machine is unstable."""
        return np.asarray(-self.poles.real / np.abs(self.poles))

    def critical_speeds(self) -> CriticalSpeeds:
        """Where branches cross the line frequency = speed, refined on the machine itself to 1e-9."""
        found = []
        margin = self.poles.imag - self.speeds[:, None]
        # a speed of the sweep that is itself a critical one belongs to the step that ends there
        margin[np.abs(margin) <= 1e-9 * self.speeds[:, None]] = 0
        crossing = (margin[:-1] * margin[1:] < 0) | (margin[1:] == 0)
        crossing[:1] |= margin[:1] == 0
        for k, b in zip(*np.nonzero(crossing), strict=True):
            pole = _refine(self.machine, self.speeds[k : k + 2], self.poles[k : k + 2, b])
            found.append((pole.imag, -pole.real / abs(pole), self.whirl[k, b]))
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
    """
    speeds = np.atleast_1d(np.asarray(speeds, dtype=float))
    if speeds.ndim != 1 or not len(speeds) or not np.isfinite(speeds).all() or (np.diff(speeds) <= 0).any():
        raise ValueError("speeds must be finite and ascending, and at least one [rad/s].")
    systems = [machine.at(float(speed)) for speed in speeds]
    modes = [system.modes().above(above) for system in systems]
    count = min(count, len(modes[0].poles))
    # a few more than are followed, so that branches which cross the last one are not lost
    kept = [Modes(m.poles[: count + 8], m.shapes[:, : count + 8]) for m in modes]
    order = np.arange(count)
    branches = [order]
    for before, after in pairwise(kept):
        order = _follow(before, after, order)
        branches.append(order)
    rows = list(zip(kept, systems, branches, strict=True))
    poles = np.array([_pick(m.poles, b) for m, _, b in rows])
    turns = np.array([_pick(whirl_direction(m, system), b) for m, system, b in rows])
    return Campbell(speeds, poles, turns.real, machine)


def whirl_direction(modes: Modes, system: System) -> Array:
    """Direction of whirl of each mode, from 1 (forward circles) to -1 (backward circles), (m,).

    The turning sense of each node's orbit, -2 Im(conj(x) y), over the sum of |x|^2 + |y|^2.
    """
    if system.planes is None:
        return np.full(len(modes.poles), np.nan)
    x, y = (modes.shapes[plane] for plane in system.planes)
    size = (np.abs(x) ** 2 + np.abs(y) ** 2).sum(axis=0)
    return np.asarray(-2 * np.imag(x.conj() * y).sum(axis=0) / np.where(size > 0, size, 1.0))


def unbalance_response(machine: Shafted, speeds: ArrayLike, unbalance: Mapping[float, complex]) -> Complex:
    """Steady response to unbalances, every coordinate of the machine: (speeds, n) complex [m].

    Parameters
    ----------
    machine : Machine
    speeds : (s,) [rad/s]
    unbalance : mapping from a position [m] to mass times eccentricity [kg m]
        A complex value turns it by its angle. The force is Omega^2 u in x and -i Omega^2 u in y: forward circles.
    """
    speeds = np.atleast_1d(np.asarray(speeds, dtype=float))
    force = unbalance_force(machine, unbalance, len(machine.at(0.0).M))
    response = np.empty((len(speeds), len(force)), dtype=complex)
    for k, speed in enumerate(speeds):
        response[k] = machine.at(float(speed)).solve(float(speed), speed**2 * force)
    return response


def unbalance_force(machine: Placed, unbalance: Mapping[float, complex], count: int) -> Complex:
    """Forces of unbalances on all `count` coordinates at 1 rad/s, (count,) complex [kg m]: circles, forward."""
    force = np.zeros(count, dtype=complex)
    for z, value in unbalance.items():
        force[machine.coordinate(z, "x")] += value
        force[machine.coordinate(z, "y")] += -1j * value
    return force


def _follow(before: Modes, after: Modes, order: NDArray[np.intp]) -> NDArray[np.intp]:
    """Which mode of the next speed continues each branch; -1 for none. Closest pole and likest shape first."""
    alive = np.flatnonzero(order >= 0)
    old = order[alive]
    distance = np.abs(before.poles[old][:, None] - after.poles[None, :])
    cost = distance / np.abs(before.poles[old])[:, None] + 1 - mac(before.shapes[:, old], after.shapes)
    following = np.full(len(order), -1)
    for flat in np.argsort(cost, axis=None):
        row, column = np.unravel_index(flat, cost.shape)
        if following[alive[row]] < 0 and column not in following:
            following[alive[row]] = column
    return following


def _pick(values: NDArray[Any], branch: NDArray[np.intp]) -> Complex:
    picked = np.full(len(branch), complex(np.nan, np.nan))
    picked[branch >= 0] = values[branch[branch >= 0]]
    return picked


def _refine(machine: Spinning, speeds: Array, poles: Complex) -> complex:
    """The pole of one branch at the speed that equals its frequency, by false position between two speeds."""
    (a, b), (fa, fb) = speeds, poles.imag - speeds
    speed, pole = a, poles[0]
    for _ in range(30):
        speed = (a * fb - b * fa) / (fb - fa)
        expected = poles[0] + (poles[1] - poles[0]) * (speed - speeds[0]) / (speeds[1] - speeds[0])
        candidates = machine.at(float(speed)).modes().poles
        pole = candidates[np.abs(candidates - expected).argmin()]
        margin = pole.imag - speed
        if abs(margin) <= 1e-9 * speed:
            break
        if margin * fa < 0:
            b, fb, fa = speed, margin, fa / 2
        else:
            a, fa, fb = speed, margin, fb / 2
    return complex(pole)
