"""A rotor and a foundation in few coordinates, so that a machine can be swept over speed many times a second.

Modes up to a limit are kept; of the others what they yield under static forces at the seats, see
`rbfound.theory.reduction.ritz`: below half the limit the error is out of sight.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.foundation import Foundation
from rbfound.machine import couple
from rbfound.rotor import X_PLANE, Y_PLANE, Y_SIGN, Bearing, Rotor, assemble
from rbfound.system import Modes, System
from rbfound.theory.reduction import ritz
from rbfound.units import from_hertz

Array = NDArray[np.float64]

# A free rotor gives no static answer: at minus the square of this part of the limit it does, and hardly another one.
NEARLY_STATIC = 0.1


@dataclass(frozen=True, eq=False)
class ReducedRotor:
    """A free round rotor in few coordinates of its two planes, those of x first.

    Attributes
    ----------
    body : Foundation
        The rotor at rest. Its seats are the displacements x1, y1, x2, y2, ... at the places.
    G : (n, n)
        Gyroscopic matrix for a spin of 1 rad/s.
    places : positions [m]
    """

    body: Foundation
    G: Array
    places: tuple[float, ...]

    def rows(self, place: float) -> Array:
        """The displacements x and y at one of the places, (2, n)."""
        first = 2 * self.places.index(place)
        return self.body.B[first : first + 2]


@dataclass(frozen=True, eq=False)
class ReducedMachine:
    """A reduced rotor in its bearings: whatever has .at(speed) can be swept.

    Attributes
    ----------
    system : the machine at rest, the rotor's coordinates first, the foundation's behind
    rotor : ReducedRotor
    foundation : Foundation or None
    """

    system: System
    rotor: ReducedRotor
    foundation: Foundation | None

    def at(self, speed: float) -> System:
        """The machine at a spin speed [rad/s]."""
        half = len(self.rotor.G) // 2
        planes = np.arange(half), half + np.arange(half)
        return System(self.system.M, self.system.C, self.system.K, speed * self._G(), planes)

    def foundation_share(self, modes: Modes) -> Array:
        """Part of each mode's kinetic energy that is the foundation's, (m,)."""
        n = len(self.rotor.G)
        energy = np.real(modes.shapes.conj() * (self.system.M @ modes.shapes))
        return np.asarray(energy[n:].sum(axis=0) / energy.sum(axis=0))

    def unbalance(self, speeds: Array, place: float, value: float) -> NDArray[np.complex128]:
        """Response of all coordinates (s, n) [m] to an unbalance [kg m] at a place [m], over speeds [rad/s]."""
        x, y = self.rotor.rows(place)
        force = np.zeros(len(self.system.M), complex)
        force[: len(x)] = value * (x - 1j * y)
        w = np.asarray(speeds, dtype=float)[:, None, None]
        stiffness = self.system.K + 1j * w * (self.system.C + w * self._G()) - w**2 * self.system.M
        return np.asarray(np.linalg.solve(stiffness, w**2 * force[:, None])[:, :, 0])

    def _G(self) -> Array:
        below = len(self.system.M) - len(self.rotor.G)
        return np.pad(self.rotor.G, (0, below))


def reduced_rotor(rotor: Rotor, places: Sequence[float], limit: float, blocks: int = 1) -> ReducedRotor:
    """A free rotor that is known at some positions [m], with its modes up to a limit [Hz].

    Parameters
    ----------
    blocks : terms of the series of static answers, to forces at the places and to moments where disks turn
    """
    for z in places:
        rotor.check_position(z, "bearing")
    mesh = assemble(rotor, places)
    nodes = 4 * np.arange(len(mesh.z))[:, None]
    x, y = (np.ravel(nodes + plane[:2]) for plane in (X_PLANE, Y_PLANE))
    signs = np.tile(Y_SIGN[:2], len(nodes))
    M, K = (A[np.ix_(x, x)] for A in (mesh.M, mesh.K))
    at = [2 * mesh.node(z) for z in places]
    turning = [2 * mesh.node(z) + 1 for z, disk in rotor.disks.items() if disk.Ip]
    below = linalg.eigh(K, M, eigvals_only=True) < float(from_hertz(limit)) ** 2
    omega, Phi = ritz(M, K, np.eye(len(M))[:, at + turning], int(below.sum()), blocks, -NEARLY_STATIC * limit)
    gyroscopic = Phi.T @ mesh.G[np.ix_(x, y)] @ (signs[:, None] * Phi)
    return round_rotor(omega, Phi[at], gyroscopic, places)


def round_rotor(omega: Array, rows: Array, gyroscopic: Array, places: Sequence[float]) -> ReducedRotor:
    """A rotor from the modes of one of its two planes, which are alike.

    Parameters
    ----------
    omega : (m,) [rad/s], of mass-normalised shapes
    rows : (places, m), displacements at the places
    gyroscopic : (m, m), force in x from the rates of y at a spin of 1 rad/s
    places : [m]
    """
    m = len(omega)
    B = np.zeros((2 * len(rows), 2 * m))
    B[0::2, :m] = B[1::2, m:] = rows
    labels = tuple(f"{axis}{k + 1}" for k in range(len(rows)) for axis in "xy")
    body = Foundation(np.eye(2 * m), np.zeros((2 * m, 2 * m)), np.diag(np.tile(omega**2, 2)), B, labels)
    zero = np.zeros((m, m))
    return ReducedRotor(body, np.block([[zero, gyroscopic], [-gyroscopic.T, zero]]), tuple(places))


def reduced_foundation(foundation: Foundation, limit: float) -> Foundation:
    """A foundation with its undamped modes up to a limit [Hz], and little of the rest: M = I, K = diag(omega^2)."""
    squares = linalg.eigh(foundation.K, foundation.M, eigvals_only=True)
    below = int((squares < float(from_hertz(limit)) ** 2).sum())
    omega, Phi = ritz(foundation.M, foundation.K, foundation.B.T, below)
    C = Phi.T @ foundation.C @ Phi
    return Foundation(np.eye(len(omega)), C, np.diag(omega**2), foundation.B @ Phi, foundation.labels)


def mount_reduced(rotor: ReducedRotor, bearings: Mapping[float, Bearing], on: Foundation | None) -> ReducedMachine:
    """A reduced rotor through its bearings, which stand at some of its places, on a foundation or on rigid ground."""
    at = sorted(bearings)
    B = np.array([rotor.rows(z) for z in at]).reshape(2 * len(at), len(rotor.G))
    labels = rotor.body.labels[: len(B)]
    body = Foundation(rotor.body.M, rotor.body.C, rotor.body.K, B, labels)
    return ReducedMachine(couple(body, [bearings[z] for z in at], on), rotor, on)
