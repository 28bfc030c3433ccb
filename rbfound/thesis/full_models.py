"""The thesis's full models g to l with bodies of ours: a solid rotor, and the reduced solid foundation.

g: the rotor; h: with the point mass; i: h on springs and dampers to the ground; j: g beside the foundation; k: h
beside it; l: h through springs and dampers on it. Needs the extra rbfound[solid].
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbfound.foundation import Foundation
from rbfound.machine import couple
from rbfound.rotor import Rotor
from rbfound.solid import Solid, both_planes, gyroscopic, reduce, ritz_modes, solid_rotor
from rbfound.system import Modes, System
from rbfound.thesis import beam_models

Array = NDArray[np.float64]

# The rotor's modes are sought around this square of a frequency below zero: it floats free. [Hz]
SHIFT = -100.0


@dataclass(frozen=True, eq=False)
class SolidRotor:
    """A reduced solid rotor: `body` at rest with the seats x1, y1, x2, y2, and G for a spin of 1 rad/s."""

    body: Foundation
    G: Array


@dataclass(frozen=True, eq=False)
class FullMachine:
    """A solid rotor over a foundation: whatever has .at(speed) can be swept.

    Attributes
    ----------
    system : the machine at rest, the rotor's coordinates first
    rotor : SolidRotor
    foundation : Foundation or None
    """

    system: System
    rotor: SolidRotor
    foundation: Foundation | None

    def at(self, speed: float) -> System:
        """The machine at a spin speed [rad/s]."""
        n = len(self.rotor.G)
        G = np.zeros_like(self.system.M)
        G[:n, :n] = speed * self.rotor.G
        return System(self.system.M, self.system.C, self.system.K, G)

    def foundation_share(self, modes: Modes) -> Array:
        """Part of each mode's kinetic energy that is the foundation's, (m,); M is the identity here."""
        energy = np.abs(modes.shapes) ** 2
        return np.asarray(energy[len(self.rotor.G) :].sum(axis=0) / energy.sum(axis=0))


def reduced_rotor(rotor: Rotor, seats: list[float], size: float = 0.01, modes: int = 12, blocks: int = 3) -> SolidRotor:
    """The solid rotor in a few coordinates for each plane.

    Parameters
    ----------
    seats : positions of the bearings [m]
    size : longest edge of an element [m]
    modes, blocks : as in `rbfound.solid.modes.ritz_modes`
    """
    solid = solid_rotor(rotor, seats, size)
    omega, Phi = ritz_modes(solid, modes, blocks, SHIFT)
    g = Phi.T @ (gyroscopic(solid, rotor.shaft) @ Phi)
    none = np.zeros_like(g)
    return SolidRotor(both_planes(omega, Phi, solid.B), np.block([[none, g], [-g, none]]))


def model(letter: str, foundation: Foundation | None = None, size: float = 0.01, modes: int = 12) -> FullMachine:
    """One of the full models g to l; j, k and l need the foundation, for instance the reduced solid.

    Parameters
    ----------
    size, modes : of the rotor, see `reduced_rotor`
    """
    if letter not in tuple("ghijkl"):
        raise ValueError(f"There is no full model {letter!r}: the letters are g, h, i, j, k, l.")
    if (foundation is not None) != (letter in "jkl"):
        raise ValueError(f"Model {letter} stands {'on a foundation: give one' if letter in 'jkl' else 'on none'}.")
    bearings = beam_models.bearings()
    rotor = reduced_rotor(
        beam_models.rotor(0.0 if letter in "gj" else beam_models.POINT_MASS), list(bearings), size, modes
    )
    tied = list(bearings.values()) if letter in "il" else []
    return FullMachine(couple(rotor.body, tied, foundation), rotor, foundation)


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


def beside(letter: str, foundation: Foundation | None = None, limit: float = 1200.0) -> dict[str, list[Any]]:
    """The natural frequencies of a full model beside the printed ones; see `rbfound.thesis.beam_models.compare`."""
    machine = model(letter, foundation)
    modes = machine.at(0.0).modes().above(1.0).below(limit)
    return beam_models.compare(beam_models.printed(letter), modes.frequency, machine.foundation_share(modes))


def axially_tied(solid: Solid, mass: float, stiffness: float) -> System:
    """The solid foundation and a rotor that it holds along Z only: a mass [kg] between two springs [N/m], undamped.

    What model l becomes if the springs between the bodies act along the shaft. The mass is the last coordinate.
    """
    nodes = solid.K.shape[0] // 3
    # the x seats are means of the first displacement over a bore; the same weights on the third are means along Z
    along = np.zeros((2, 3 * nodes))
    along[:, 2 * nodes :] = solid.B[0::2, :nodes]
    body = reduce(replace(solid, B=along, labels=("z1", "z2")), zeta=0.0)
    n = len(body.M)
    M, K = np.eye(n + 1), np.zeros((n + 1, n + 1))
    M[n, n], K[:n, :n] = mass, body.K
    relative = np.hstack([-body.B, np.ones((2, 1))])
    return System(M, 0 * K, K + stiffness * relative.T @ relative)
