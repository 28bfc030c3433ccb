"""The orbit of a point of a shaft: an ellipse, from the two complex amplitudes of x and y.

A displacement x = Re(X e^(i omega t)), y = Re(Y e^(i omega t)) is a forward circle, (X + iY) / 2, and a backward one,
(X - iY) / 2: the sum of their radii is the ellipse's major half axis, their difference the minor one. It runs forward,
from X to Y, if the forward circle is the larger.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


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
