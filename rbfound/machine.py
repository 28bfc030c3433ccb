"""The rotor through its bearings on its foundation: one machine (equation 65)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from rbfound.banded import Banded, band_of
from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.parallel import one_thread
from rbfound.rotor import Bearing, Mesh, Rotor, assemble
from rbfound.system import Modes, System
from rbfound.units import from_hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Machine:
    """A mounted rotor: M, C, K and G (n, n) with the rotor's coordinates first and the foundation's behind.

    Attributes
    ----------
    M, C, K : mass, damping, stiffness; the bearings are in C and K
    G : gyroscopic matrix for a spin of 1 rad/s
    mesh : the rotor's nodes
    bearings : mapping from a position [m] to a Bearing, in the order of the seats
    foundation : what it stands on; None is rigid ground
    """

    M: Array
    C: Array
    K: Array
    G: Array
    mesh: Mesh
    bearings: Mapping[float, Bearing]
    foundation: Foundation | None = None

    def at(self, speed: float) -> System:
        """The machine at a spin speed [rad/s]."""
        return System(self.M, self.C, self.K, speed * self.G, self.mesh.planes)

    @cached_property
    def banded(self) -> Banded | None:
        """The machine as a band with a border, solved in a time proportional to its nodes; None if it is none."""
        return band_of((self.M, self.C, self.K, self.G), len(self.mesh.M))

    @one_thread
    def responses(self, omega: Array, speeds: Array, force: Complex) -> Complex:
        """Steady motion under harmonic forces, line by line: (lines, n) complex [m].

        Parameters
        ----------
        omega, speeds : (lines,) circular frequency and speed of rotation [rad/s]
        force : (lines, n)

        Raises
        ------
        ValueError
            When an undamped mode lies on a line.
        """
        out, uncertain = np.empty(force.shape, dtype=complex), np.arange(len(omega))
        if self.banded is not None:
            found, uncertain = self.banded.response(omega, speeds, force.T)
            out[:] = found.T
            # at rest the dense matrix knows whether the machine is free
            uncertain = np.union1d(uncertain, np.flatnonzero(omega == 0))
        for k in uncertain:
            out[k] = self.at(float(speeds[k])).solve(float(omega[k]), force[k])
        return out

    @one_thread
    def frf(self, frequency: ArrayLike, coordinates: Mapping[str, int], speed: float = 0.0) -> FRF:
        """Receptances between some coordinates: each line [Hz] solved exactly.

        Parameters
        ----------
        coordinates : mapping from a name to an index, as `coordinate` gives it
        speed : of rotation [rad/s]

        Raises
        ------
        ValueError
            When the speed is not finite, or an undamped mode lies on a line.
        """
        if not np.isfinite(speed):
            raise ValueError(f"speed is {speed} rad/s: it must be finite.")
        frequency = np.atleast_1d(np.asarray(frequency, dtype=float))
        chosen = list(coordinates.values())
        omega, at = np.asarray(from_hertz(frequency)), np.full(len(frequency), float(speed))
        H = np.empty((len(frequency), len(chosen), len(chosen)), dtype=complex)
        for column, driven in enumerate(chosen):
            force = np.zeros((len(frequency), len(self.M)), dtype=complex)
            force[:, driven] = 1.0
            H[:, :, column] = self.responses(omega, at, force)[:, chosen]
        return FRF(frequency, H, tuple(coordinates))

    def foundation_share(self, modes: Modes) -> Array:
        """Part of each mode's kinetic energy that is the foundation's, (m,): 0 all shaft, 1 all foundation."""
        n = len(self.mesh.M)
        moving = self.M @ modes.shapes
        whole = np.real(np.sum(modes.shapes.conj() * moving, axis=0))
        below = np.real(np.sum(modes.shapes[n:].conj() * moving[n:], axis=0))
        return np.asarray(below / whole)

    def coordinate(self, z: float, direction: str) -> int:
        """Index of the shaft's displacement "x" or "y" at a position [m]."""
        if direction not in ("x", "y"):
            raise ValueError(f'direction is {direction!r}: it must be "x" or "y".')
        return 4 * self.mesh.node(z) + "xy".index(direction)


def couple(above: Foundation, bearings: Sequence[Bearing], below: Foundation | None = None) -> System:
    """Two bodies known by their seats, tied by bearings; the coordinates of `above` first, of `below` behind.

    Parameters
    ----------
    above, below : Foundation
        Any reduced bodies, a rotor that stands still among them; None below is rigid ground.
    bearings : one for each pair of seats x, y, in their order; none leaves the bodies uncoupled
    """
    bodies = [above] if below is None else [above, below]
    for body in bodies if bearings else []:
        if len(body.labels) != 2 * len(bearings):
            raise ValueError(
                f"{len(bearings)} bearings need {2 * len(bearings)} seats on either side, x and y for each: "
                f"one side has {len(body.labels)} ({', '.join(body.labels)})."
            )
    M, C, K = (linalg.block_diag(*(getattr(body, name) for body in bodies)) for name in "MCK")
    for k, bearing in enumerate(bearings):
        rows = slice(2 * k, 2 * k + 2)
        _tie(C, K, above.B[rows], bearing, None if below is None else below.B[rows])
    return System(M, C, K)


def _tie(C: Array, K: Array, journal: Array, bearing: Bearing, seat: Array | None) -> None:
    """Add a bearing to C and K: it feels the journal's displacement, (2, n) rows, minus its seat's, (2, q)."""
    relative = journal if seat is None else np.hstack([journal, -seat])
    K += relative.T @ bearing.K @ relative
    C += relative.T @ bearing.C @ relative


def mount(rotor: Rotor, bearings: Mapping[float, Bearing], on: Foundation | None = None) -> Machine:
    """Put a rotor through its bearings on a foundation.

    Parameters
    ----------
    rotor : Rotor
    bearings : mapping from a position along the shaft [m] to a Bearing
        The bearing at the smallest z stands on the seats x1, y1, the next one on x2, y2, and so on. Without
        bearings rotor and foundation stand side by side, uncoupled.
    on : Foundation, or None for rigid ground

    Raises
    ------
    ValueError
        When a bearing stands beside the shaft, or the foundation has not two seats for each bearing.
    """
    places = sorted(bearings)
    for z in places:
        rotor.check_position(z, "bearing")
    if on is not None and places:
        check_seats(len(places), on.labels)
    mesh = assemble(rotor, places)
    n = len(mesh.M)
    matrices = [on.M, on.C, on.K] if on is not None else [np.zeros((0, 0))] * 3
    q = len(matrices[0])
    M, C, K = (linalg.block_diag(a, b) for a, b in zip((mesh.M, np.zeros((n, n)), mesh.K), matrices, strict=True))
    G = linalg.block_diag(mesh.G, np.zeros((q, q)))
    for k, z in enumerate(places):
        journal = np.zeros((2, n))
        first = 4 * mesh.node(z)
        journal[[0, 1], [first, first + 1]] = 1.0
        _tie(C, K, journal, bearings[z], None if on is None else on.B[2 * k : 2 * k + 2])
    return Machine(M, C, K, G, mesh, {z: bearings[z] for z in places}, on)


def check_seats(bearings: int, labels: Sequence[str]) -> None:
    """Raise a ValueError unless a foundation has two seats for each bearing."""
    if len(labels) != 2 * bearings:
        raise ValueError(
            f"{bearings} bearings need {2 * bearings} seats, x and y for each: "
            f"the foundation has {len(labels)} ({', '.join(labels)})."
        )
