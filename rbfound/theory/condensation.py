"""A rotor and a foundation in few coordinates, so that a machine can be swept over speed many times a second.

Modes up to a limit are kept; of the others what they yield under static forces at the seats (Rubin 1975,
DOI 10.2514/3.60497): below half the limit the error is out of sight.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.foundation import Foundation
from rbfound.rotor import X_PLANE, Y_PLANE, Y_SIGN, Bearing, Rotor, assemble
from rbfound.system import System
from rbfound.units import radians

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LightRotor:
    """A free rotor in modal coordinates of its two planes, those of x first.

    Attributes
    ----------
    K : (n, n) [1/s^2], diagonal; the mass matrix is the identity
    G : (n, n) [-]
        Gyroscopic matrix for a spin of 1 rad/s.
    rows : from a position [m] to (2, n), the displacements x and y there
    """

    K: Array
    G: Array
    rows: Mapping[float, Array]


@dataclass(frozen=True, eq=False)
class LightMachine:
    """A light rotor in its bearings; the rotor's coordinates first, the foundation's behind."""

    M: Array
    C: Array
    K: Array
    G: Array
    rows: Mapping[float, Array]

    def at(self, speed: float) -> System:
        """The machine at a spin speed [rad/s]."""
        half = next(iter(self.rows.values())).shape[1] // 2
        return System(self.M, self.C, self.K, speed * self.G, (np.arange(half), half + np.arange(half)))

    def unbalance(self, speeds: Array, place: float, value: float) -> NDArray[np.complex128]:
        """Response of all coordinates (s, n) [m] to an unbalance [kg m] at a position [m], over speeds [rad/s]."""
        x, y = self.rows[place]
        force = np.zeros(len(self.M), complex)
        force[: len(x)] = value * (x - 1j * y)
        w = np.asarray(speeds, dtype=float)[:, None, None]
        stiffness = self.K + 1j * w * (self.C + w * self.G) - w**2 * self.M
        return np.asarray(np.linalg.solve(stiffness, w**2 * force[:, None])[:, :, 0])


def light_rotor(rotor: Rotor, places: Sequence[float], limit: float) -> LightRotor:
    """A free rotor that is known at some positions [m], with its modes up to a limit [Hz]."""
    mesh = assemble(rotor, places)
    nodes = 4 * np.arange(len(mesh.z))[:, None]
    x, y = (np.ravel(nodes + plane[:2]) for plane in (X_PLANE, Y_PLANE))
    signs = np.tile(Y_SIGN[:2], len(nodes))
    squared, modes = linalg.eigh(mesh.K[np.ix_(x, x)], mesh.M[np.ix_(x, x)])
    held = modes[[2 * mesh.node(z) for z in places]]
    few, squared = condensed(squared, held, limit)
    shapes = modes @ few
    half = shapes.T @ mesh.G[np.ix_(x, y)] @ (signs[:, None] * shapes)
    zero = np.zeros_like(half)
    rows = {z: linalg.block_diag(row, row) for z, row in zip(places, held @ few, strict=True)}
    return LightRotor(np.diag(np.tile(squared, 2)), np.block([[zero, half], [-half.T, zero]]), rows)


def light_foundation(foundation: Foundation, limit: float) -> Foundation:
    """A modal foundation with its modes up to a limit [Hz] as they are, and little of the rest.

    Raises
    ------
    ValueError
        Unless M is the identity and K diagonal.
    """
    squared = np.diag(foundation.K)
    if np.any(np.eye(len(squared)) != foundation.M) or np.any(np.diag(squared) != foundation.K):
        raise ValueError("A foundation is made light in modal coordinates: M must be the identity and K diagonal.")
    few, kept = condensed(squared, foundation.B, limit)
    one = np.eye(len(kept))
    return Foundation(one, few.T @ foundation.C @ few, np.diag(kept), foundation.B @ few, foundation.labels)


def condensed(squared: Array, held: Array, limit: float) -> tuple[Array, Array]:
    """Columns (modes, kept), orthonormal, and omega squared of each: modes up to a limit [Hz] first, then the rest.

    Parameters
    ----------
    squared : (modes,) omega^2 [1/s^2]
    held : (rows, modes), displacements that must stay right

    Raises
    ------
    ValueError
        When no mode lies above the limit.
    """
    few = squared < float(radians(limit)) ** 2
    if few.all():
        raise ValueError(f"There is nothing to make light: no mode lies above {limit:g} Hz.")
    yielding = (held[:, ~few] / squared[~few]).T
    basis = linalg.orth(yielding / np.linalg.norm(yielding, axis=0))
    above, own = linalg.eigh(basis.T @ (squared[~few][:, None] * basis))
    columns = np.zeros((len(squared), few.sum() + len(above)))
    columns[np.flatnonzero(few), np.arange(few.sum())] = 1.0
    columns[~few, few.sum() :] = basis @ own
    return columns, np.concatenate([np.maximum(squared[few], 0.0), above])


def light_mount(
    rotor: LightRotor, bearings: Mapping[float, Bearing], on: Foundation | None, kept: Sequence[int] | None = None
) -> LightMachine:
    """A light rotor through its bearings on a foundation, of which some coordinates may be held still.

    Parameters
    ----------
    on : Foundation, or None for rigid ground
    kept : coordinates of the foundation that move; all unless given
    """
    n = len(rotor.K)
    which = range(len(on.M) if on else 0) if kept is None else kept
    below = [A[np.ix_(which, which)] for A in (on.M, on.C, on.K)] if on else [np.zeros((0, 0))] * 3
    M, C, K = (linalg.block_diag(a, b) for a, b in zip((np.eye(n), np.zeros((n, n)), rotor.K), below, strict=True))
    for k, z in enumerate(sorted(bearings)):
        seat = on.B[2 * k : 2 * k + 2][:, list(which)] if on else np.zeros((2, 0))
        relative = np.hstack([rotor.rows[z], -seat])
        K += relative.T @ bearings[z].K @ relative
        C += relative.T @ bearings[z].C @ relative
    return LightMachine(M, C, K, linalg.block_diag(rotor.G, np.zeros_like(below[0])), rotor.rows)
