"""Forces that reach the foundation, and the ground under it (equations 25-31).

A bearing gives its seat the force f = K r + C r', where r is the journal's displacement minus the seat's. Of these
forces the foundation's own inertia takes a part; the rest is what it hands down to the ground:

    force on the ground = sum of the bearing forces - rate of change of the foundation's momentum.

For one bearing of mass m on a spring and a damper that is K x + C x' (equations 25-30). In general it needs the
momentum of the foundation's coordinates, which FRFs at the seats do not tell: `rbfound.solid.modes.momentum` has it.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.foundation import Foundation
from rbfound.machine import Machine

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def sine_cosine_matrix(
    omega: float, k: tuple[float, float], c: tuple[float, float] = (0.0, 0.0), m: float = 0.0
) -> Array:
    """Forces of one bearing seat from its displacements, in sines and cosines, (4, 4) (equations 25-30).

    With x = A1 sin + A2 cos and y = B1 cos + B2 sin of omega t: the parts Fx1, Fx2 (sine, cosine) and Fy1, Fy2
    (cosine, sine) from A1, A2, B1, B2. With the mass it is the force that the bearing needs (equation 29), without it
    the one that reaches the ground (equation 30).

    Parameters
    ----------
    omega : [rad/s]
    k, c : stiffness [N/m] and damping [N s/m] in x and in y
    m : mass of the bearing [kg]
    """
    out = np.zeros((4, 4))
    for axis, sign in ((0, -1.0), (1, 1.0)):
        spring, damper = k[axis] - m * omega**2, sign * omega * c[axis]
        out[2 * axis : 2 * axis + 2, 2 * axis : 2 * axis + 2] = [[spring, damper], [-damper, spring]]
    return out


def sine_cosine_amplitude(parts: ArrayLike) -> Array:
    """Amplitudes of the two directions from the four parts (..., 4): (..., 2) (equation 31)."""
    parts = np.asarray(parts, dtype=float)
    return np.hypot(parts[..., 0::2], parts[..., 1::2])


def seat_forces(machine: Machine, speeds: ArrayLike, response: ArrayLike) -> Complex:
    """Forces of the bearings on their seats, x1, y1, x2, y2, ...: (speeds, seats) complex [N] (equations 25, 26).

    Parameters
    ----------
    speeds : (s,) circular frequencies of the response [rad/s]
    response : (s, n) complex displacements of the machine, as `rbfound.unbalance_response` gives them
    """
    omega, x = _checked(machine, speeds, response)
    n = len(machine.mesh.M)
    forces = np.empty((len(omega), 2 * len(machine.bearings)), dtype=complex)
    seats = 0 if machine.foundation is None else x[:, n:] @ machine.foundation.B.T
    journals = x[:, [machine.coordinate(z, direction) for z in machine.bearings for direction in "xy"]]
    relative = journals - seats
    for k, bearing in enumerate(machine.bearings.values()):
        stiffness = bearing.K + 1j * omega[:, None, None] * bearing.C
        forces[:, 2 * k : 2 * k + 2] = np.einsum("sij,sj->si", stiffness, relative[:, 2 * k : 2 * k + 2])
    return forces


def ground_forces(
    machine: Machine, speeds: ArrayLike, response: ArrayLike, momentum: ArrayLike | None = None
) -> Complex:
    """Resultant force on the ground along X and Y: (speeds, 2) complex [N] (equations 25-31).

    Parameters
    ----------
    speeds, response : as in `seat_forces`
    momentum : (2, q), optional
        The foundation's momentum along X and Y for a unit velocity of each of its coordinates. Unless given it is that
        of `seat_momentum`; rigid ground has none.
    """
    omega, x = _checked(machine, speeds, response)
    through = seat_forces(machine, omega, x)
    resultant = np.stack([through[:, 0::2].sum(axis=1), through[:, 1::2].sum(axis=1)], axis=1)
    if machine.foundation is None:
        return resultant
    q = x[:, len(machine.mesh.M) :]
    rows = seat_momentum(machine.foundation) if momentum is None else np.asarray(momentum, dtype=float)
    if rows.shape != (2, q.shape[1]):
        raise ValueError(f"momentum has shape {rows.shape}: for {q.shape[1]} coordinates it is (2, {q.shape[1]}).")
    return np.asarray(resultant + omega[:, None] ** 2 * (q @ rows.T))


def seat_momentum(foundation: Foundation) -> Array:
    """Momentum along X and Y of a foundation that has as many coordinates as seats: (2, q) [kg, modal].

    Its rigid translation is taken for the motion in which all seats move alike, and M for all of its moving mass. The
    force on the ground is then the sum of K x + C x' over the seats, as in equation 30.
    """
    seats, coordinates = foundation.B.shape
    if seats != coordinates or np.linalg.matrix_rank(foundation.B) < seats:
        raise ValueError(
            f"The foundation has {coordinates} coordinates and {seats} seats: which momentum its coordinates carry "
            "cannot be told from its seats. Give `momentum`."
        )
    alike = np.array([[label.startswith(axis) for label in foundation.labels] for axis in "xy"], dtype=float)
    return np.asarray(np.linalg.solve(foundation.B, alike.T).T @ foundation.M)


def _checked(machine: Machine, speeds: ArrayLike, response: ArrayLike) -> tuple[Array, Complex]:
    omega = np.atleast_1d(np.asarray(speeds, dtype=float))
    x = np.atleast_2d(np.asarray(response, dtype=complex))
    if x.shape != (len(omega), len(machine.M)):
        raise ValueError(
            f"response has shape {x.shape}: with {len(omega)} speeds and {len(machine.M)} coordinates it must be "
            f"({len(omega)}, {len(machine.M)})."
        )
    return omega, x
