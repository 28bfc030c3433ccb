"""The bodies of the thesis's full models g to l, which are ours: a solid rotor, and what it does along its axis.

Needs the extra rbfound[solid].
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rbfound.foundation import Foundation
from rbfound.machine import couple
from rbfound.rotor import Bearing, Rotor
from rbfound.solid import Solid, gyroscopic, reduce, ritz_modes, solid_rotor
from rbfound.system import System
from rbfound.theory import ReducedRotor, round_rotor
from rbfound.thesis import beam_models

Array = NDArray[np.float64]

# The rotor's modes are sought around this square of a frequency below zero: it floats free. [Hz]
SHIFT = -100.0


def reduced_solid(rotor: Rotor, seats: list[float], size: float = 0.01, modes: int = 12) -> ReducedRotor:
    """The solid rotor in a few coordinates for each plane.

    Parameters
    ----------
    seats : positions of the bearings [m]
    size : longest edge of an element [m]
    modes : as in `rbfound.solid.modes.ritz_modes`
    """
    solid = solid_rotor(rotor, seats, size)
    omega, Phi = ritz_modes(solid, modes, shift=SHIFT)
    return round_rotor(omega, solid.B @ Phi, Phi.T @ (gyroscopic(solid, rotor.shaft) @ Phi), seats)


def centre_line(letter: str, count: int, size: float = 0.01) -> tuple[Array, Array, Array]:
    """How the axis of model g, h or i bends in one plane: z (n,) [m], frequency (count,) [Hz], displacement (n, count).

    Each displacement has the largest size 1, at the instant when it is largest; rigid-body modes are left out.
    """
    if letter not in tuple("ghi"):
        raise ValueError(f"Model {letter!r} has more than a rotor: the letters are g, h, i.")
    bearings = beam_models.bearings()
    solid = solid_rotor(beam_models.rotor(0.0 if letter == "g" else beam_models.POINT_MASS), list(bearings), size)
    omega, Phi = ritz_modes(solid, 12, 3, SHIFT)
    C, K = np.zeros((len(omega),) * 2), np.diag(omega**2)
    if letter == "i":
        for seat, bearing in zip(solid.B @ Phi, bearings.values(), strict=True):
            C += bearing.cxx * np.outer(seat, seat)
            K += bearing.kxx * np.outer(seat, seat)
    modes = System(np.eye(len(omega)), C, K).modes().above(1.0)
    z, r = solid.mesh.doflocs
    axis = np.flatnonzero(r < 1e-12)
    axis = axis[np.argsort(z[axis])]
    shapes = (Phi[axis] @ modes.shapes)[:, :count]
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(count)]
    return z[axis], modes.frequency[:count], np.real(shapes / largest)


def axially_tied(solid: Solid, mass: float, stiffness: float) -> System:
    """The solid foundation and a rotor that it holds along Z only: a mass [kg] between two springs [N/m], undamped.

    What model l becomes if the springs between the bodies act along the shaft. The mass is the first coordinate.
    """
    nodes = solid.K.shape[0] // 3
    # the x seats are means of the first displacement over a bore; the same weights on the third are means along Z
    along = np.zeros((2, 3 * nodes))
    along[:, 2 * nodes :] = solid.B[0::2, :nodes]
    body = reduce(replace(solid, B=along, labels=("z1", "z2")), zeta=0.0)
    none = np.zeros((1, 1))
    above = Foundation(np.array([[mass]]), none, none, np.ones((2, 1)), body.labels)
    # the two springs stand where a bearing has its x and its y
    return couple(above, [Bearing(kxx=stiffness, kyy=stiffness)], body)
