"""Unbalance: the response to it, the orbits of the shaft, how much is permitted, and at which speeds to compute.

A grade G is the product of the permissible eccentricity of the centre of mass and the speed of rotation, in mm/s: a
rotor of grade G2.5 may have its centre of mass travel round at 2.5 mm/s. Turbines and the rotors of small electric
machines are usually given G2.5, pumps and fans G6.3.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.campbell_diagram import Spinning
from rbfound.machine import Machine
from rbfound.parallel import one_thread

Array = NDArray[np.float64]

Complex = NDArray[np.complex128]

# Intervals are halved at most so many times: a response with a jump would never end.
HALVINGS = 30


def adaptive_lines(
    response: Callable[[Array], Complex], lines: ArrayLike, tolerance: float = 1e-3
) -> tuple[Array, Complex]:
    """Lines between which a cubic through four neighbours holds a tolerance, and the response on them.

    Each interval is tried at its middle, which becomes a line: everything returned has been asked for, nothing is
    interpolated. An interval is halved until the cubic through the lines around it has met its middle.

    Parameters
    ----------
    response : function of lines (k,), in any unit, that gives (k, ...) complex
        `rbfound.unbalance_response` over speeds, or `machine.frf(lines, ...).H`.
    lines : (n,) to begin with, ascending, four at least
        A resonance so narrow that it shows at no line and no middle is not seen: put the natural frequencies in.
    tolerance : float
        Of the largest difference at the middle, relative to the largest entry there.

    Returns
    -------
    (m,) lines and (m, ...) responses

    Raises
    ------
    ValueError
        When there are fewer than four lines, they do not ascend, or the tolerance is not positive.
    """
    x = np.asarray(lines, dtype=float)
    if x.ndim != 1 or len(x) < 4 or not np.isfinite(x).all() or (np.diff(x) <= 0).any():
        raise ValueError(f"{x.size} lines: at least four are needed, finite and ascending.")
    if not 0 < tolerance < np.inf:
        raise ValueError(f"tolerance = {tolerance:g}: it must be positive and finite.")
    y = np.asarray(response(x), dtype=complex)
    open_ = np.ones(len(x) - 1, dtype=bool)
    for _ in range(HALVINGS):
        left = np.flatnonzero(open_)
        if not len(left):
            break
        middle = (x[left] + x[left + 1]) / 2
        found = np.asarray(response(middle), dtype=complex)
        flat = found.reshape(len(middle), -1)
        off = np.abs(flat - _cubic(x, y.reshape(len(x), -1), left, middle)).max(axis=1)
        rough = off > tolerance * np.abs(flat).max(axis=1)
        x, y = np.insert(x, left + 1, middle), np.insert(y, left + 1, found, axis=0)
        open_ = np.insert(open_, left, rough)
        open_[left + np.arange(1, len(left) + 1)] = rough
    return x, y


def _cubic(x: Array, y: Complex, left: NDArray[np.intp], at: Array) -> Complex:
    """The cubic through the four lines around each interval, at a place in it: (k, entries)."""
    four = np.clip(left - 1, 0, len(x) - 4)[:, None] + np.arange(4)
    known = x[four]
    weight = np.ones_like(known)
    for i in range(4):
        for j in range(4):
            if i != j:
                weight[:, i] *= (at - known[:, j]) / (known[:, i] - known[:, j])
    return np.asarray(np.einsum("ki,kie->ke", weight, y[four]))


def permissible_unbalance(mass: float, speed: float, grade: float = 2.5) -> float:
    """Permissible residual unbalance of a rotor [kg m], mass times eccentricity, at its highest service speed.

    Parameters
    ----------
    mass : [kg]
    speed : highest service speed [rad/s]
    grade : e_per times speed [mm/s]: 2.5 for G2.5
    """
    _check("mass", mass, "kg")
    return mass * permissible_eccentricity(speed, grade)


def permissible_eccentricity(speed: float, grade: float = 2.5) -> float:
    """How far the centre of mass may lie beside the axis [m], e_per = grade / speed [mm/s, rad/s]."""
    _check("speed", speed, "rad/s")
    _check("grade", grade, "mm/s")
    return 1e-3 * grade / speed


def grade_of(unbalance: float, mass: float, speed: float) -> float:
    """The balance quality grade [mm/s] that a rotor with an unbalance [kg m] has at a speed [rad/s]."""
    _check("mass", mass, "kg")
    return 1e3 * unbalance / mass * speed


def in_two_planes(unbalance: float, centre: float, left: float, right: float) -> dict[float, float]:
    """Share an unbalance [kg m] of the centre of mass between two planes, as a weight would rest on them.

    Parameters
    ----------
    centre, left, right : positions [m]; the centre of mass must lie between the planes

    Returns
    -------
    mapping from the position of a plane to its share [kg m], as `rbfound.unbalance_response` takes it
    """
    if not left <= centre <= right or left == right:
        raise ValueError(f"The centre of mass at {centre:g} m does not lie between planes at {left:g} and {right:g} m.")
    share = (centre - left) / (right - left)
    return {left: (1 - share) * unbalance, right: share * unbalance}


def _check(name: str, value: float, unit: str) -> None:
    if not 0 < value < np.inf:
        raise ValueError(f"{name} = {value:g} {unit}: it must be positive and finite.")


@dataclass(frozen=True, eq=False)
class Orbits:
    """Ellipses, of any shape (...).

    Attributes
    ----------
    major : half axes [m]
    minor : half axes [m], negative for an orbit that runs backward, 0 for a line
    angle : from the X axis to the major axis, from X to Y [rad], -pi/2 to pi/2
    """

    major: Array
    minor: Array
    angle: Array


def ellipses(x: ArrayLike, y: ArrayLike) -> Orbits:
    """The orbits of complex amplitudes x and y of one shape [m]."""
    x, y = np.asarray(x, dtype=complex), np.asarray(y, dtype=complex)
    forward, backward = (x + 1j * y) / 2, (x - 1j * y) / 2
    major, minor = np.abs(forward) + np.abs(backward), np.abs(forward) - np.abs(backward)
    # the two circles point the same way at half the difference of their phases
    turn = np.angle(forward * backward.conj()) / 2
    return Orbits(np.asarray(major), np.asarray(minor), np.asarray(turn))


def path(x: complex, y: complex, points: int = 181) -> tuple[Array, Array]:
    """One turn of the orbit: x and y [m], (points,) each; the first and the last point are the same."""
    turn = np.exp(1j * np.pi * np.linspace(0, 2, points))
    return np.real(x * turn), np.real(y * turn)


class Placed(Protocol):
    """A machine whose shaft can be asked for the coordinate of a place."""

    def coordinate(self, z: float, direction: str) -> int:
        """Index of the displacement "x" or "y" at a position [m]."""
        ...


class Shafted(Spinning, Placed, Protocol):
    """Both: it can be swept, and be asked for a place."""


@one_thread
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
    if isinstance(machine, Machine):
        force = unbalance_force(machine, unbalance, len(machine.M))
        return machine.responses(speeds, speeds, np.outer(speeds**2, force))
    # a film bearing has no coefficients at rest: no speed is asked for but those given
    systems = [machine.at(float(speed)) for speed in speeds]
    force = unbalance_force(machine, unbalance, len(systems[0].M) if systems else 0)
    return np.array([system.solve(float(w), w**2 * force) for system, w in zip(systems, speeds, strict=True)])


def unbalance_force(machine: Placed, unbalance: Mapping[float, complex], count: int) -> Complex:
    """Forces of unbalances on all `count` coordinates at 1 rad/s, (count,) complex [kg m]: circles, forward."""
    force = np.zeros(count, dtype=complex)
    for z, value in unbalance.items():
        force[machine.coordinate(z, "x")] += value
        force[machine.coordinate(z, "y")] += -1j * value
    return force
