"""No identification at all: the measured FRFs of the foundation under the rotor, line by line (impedance coupling).

At one frequency a foundation is its receptance H at the seats, and a bearing the stiffness Z = K + i omega C between
journal and seat. In series they are what the journal feels,

    S = (Z^-1 + H)^-1 = (I + Z H)^-1 Z,

and the machine is the free rotor with S at its journals: equation 65 without the foundation's coordinates (Vazquez,
Barrett and Flack 2001; de Klerk, Rixen and Voormeeren 2008, DOI 10.2514/1.33274, call it frequency-based
substructuring). H is never inverted: one that is nearly or exactly singular does no harm. Nothing is known between the
lines, and nothing beyond them.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from rbfound.frf import FRF
from rbfound.identification.plscf import largest_order, lines_in, stabilisation, stable_poles
from rbfound.machine import Machine, check_seats, mount
from rbfound.parallel import one_thread
from rbfound.rotor import Bearing, Rotor
from rbfound.unbalance import unbalance_force
from rbfound.units import from_hertz, hertz, rpm

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# A static stiffness with a larger condition number holds the rotor by nothing but rounding.
FREE = 1e13


@dataclass(frozen=True, eq=False)
class MeasuredMachine:
    """A rotor through its bearings on a foundation of which only FRFs are known. It exists on their lines alone.

    Its coordinates are those of the rotor, (n,), and behind them the displacements of the seats.

    Attributes
    ----------
    rotor : free, with its disks
    grounded : the same in its bearings on rigid ground
    foundation : FRFs at the seats
    """

    rotor: Rotor
    grounded: Machine
    foundation: FRF

    @property
    def journals(self) -> list[int]:
        """Indices of the shaft's displacements in the bearings, in the order of the seats."""
        return [self.coordinate(z, direction) for z in self.grounded.bearings for direction in "xy"]

    def coordinate(self, z: float, direction: str) -> int:
        """Index of the shaft's displacement "x" or "y" at a position [m]."""
        return self.grounded.coordinate(z, direction)

    def seat(self, label: str) -> int:
        """Index of the displacement of a seat, by its name."""
        return len(self.grounded.mesh.M) + self.foundation.seat(label)

    def frf(self, coordinates: Mapping[str, int], speed: float = 0.0) -> FRF:
        """Receptances of the machine between some of its coordinates, on the foundation's lines.

        Parameters
        ----------
        coordinates : mapping from a name to an index, as `coordinate` and `seat` give it
        speed : of rotation [rad/s]

        Raises
        ------
        ValueError
            When the speed is not finite, or the machine is singular on a line: at 0 Hz, if nothing holds the rotor.
        """
        chosen = list(coordinates.values())
        frequency = self.foundation.frequency
        force = np.zeros((len(self.grounded.mesh.M) + len(self.foundation.labels), len(chosen)))
        force[chosen, np.arange(len(chosen))] = 1.0
        H = np.empty((len(frequency), len(chosen), len(chosen)), dtype=complex)
        for line, omega in enumerate(from_hertz(frequency)):
            H[line] = self.solve(float(omega), speed, self.foundation.H[line], force)[chosen]
        return FRF(frequency, H, tuple(coordinates))

    def solve(self, omega: float, speed: float, H: Complex, force: Array | Complex) -> Complex:
        """Displacements under harmonic forces on one line: all coordinates, as the forces, (n + seats, i).

        Parameters
        ----------
        omega, speed : circular frequency and speed of rotation [rad/s]
        H : (seats, seats) complex [m/N], the foundation's receptance at that frequency
        """
        if not np.isfinite(speed):
            raise ValueError(f"speed is {speed} rad/s: it must be finite.")
        mesh, journals = self.grounded.mesh, self.journals
        n = len(mesh.M)
        bearing = _dynamic_stiffness(self.grounded.bearings, omega)
        stiffness = mesh.K - omega**2 * mesh.M + 1j * omega * speed * mesh.G
        above, below = np.array(force[:n], dtype=complex), np.asarray(force[n:])
        try:
            series = np.linalg.solve(np.eye(len(H)) + bearing @ H, bearing)
            stiffness[np.ix_(journals, journals)] += series
            if omega == 0 and np.linalg.cond(stiffness) > FREE:
                raise np.linalg.LinAlgError
            above[journals] += series @ H @ below
            x = np.linalg.solve(stiffness, above)
        except np.linalg.LinAlgError:
            raise ValueError(
                f"The machine is singular at {hertz(omega):g} Hz: the bearings do not hold the rotor there. "
                "Leave the line out, or give both directions of each bearing a stiffness."
            ) from None
        return np.concatenate([x, H @ (series @ (x[journals] - H @ below) + below)])


def mount_measured(rotor: Rotor, bearings: Mapping[float, Bearing], on: FRF) -> MeasuredMachine:
    """Put a rotor through its bearings on measured FRFs, as `rbfound.mount` puts it on a foundation.

    Raises
    ------
    ValueError
        When a bearing stands beside the shaft, or the FRFs have not two seats for each bearing.
    """
    grounded = mount(rotor, bearings)
    check_seats(len(bearings), on.labels)
    return MeasuredMachine(rotor, grounded, on)


@one_thread
def unbalance_on_lines(
    machine: MeasuredMachine,
    speeds: ArrayLike | None,
    unbalance: Mapping[float, complex],
    *,
    interpolate: bool = False,
) -> Complex:
    """Steady response to unbalances: (speeds, n + seats) complex [m], the rotor's coordinates, then the seats'.

    The rotor's are those of `rbfound.unbalance_response`, in the same order and with the same force.

    Parameters
    ----------
    speeds : (s,) [rad/s]
        Each must be a line of the FRFs; None for all lines.
    unbalance : mapping from a position [m] to mass times eccentricity [kg m]
    interpolate : bool
        Between two lines take a straight one, entry by entry of H. Near a peak of half-power width b that errs by
        (spacing of the lines / b)^2 as a part of H.

    Raises
    ------
    ValueError
        When a speed is no line of the FRFs, or with `interpolate` lies outside them: they are not extrapolated.
    """
    frf = machine.foundation
    wanted = from_hertz(frf.frequency) if speeds is None else np.atleast_1d(np.asarray(speeds, dtype=float))
    size = len(machine.grounded.mesh.M) + len(frf.labels)
    force = unbalance_force(machine, unbalance, size)
    response = np.empty((len(wanted), size), dtype=complex)
    for k, speed in enumerate(wanted):
        H = _receptance_at(frf, float(speed), interpolate)
        response[k] = machine.solve(float(speed), float(speed), H, speed**2 * force)
    return response


@one_thread
def coupled_poles(machine: MeasuredMachine, speed: float = 0.0, band: tuple[float, float] | None = None) -> Complex:
    """Poles of the machine within the data's band, (m,) complex [rad/s], ascending.

    The stable poles of the machine's own FRFs at its journals and disks (`rbfound.identification.plscf.stabilisation`).
    A mode that moves the shaft too little for its noise is not among them.

    Parameters
    ----------
    speed : of rotation [rad/s]
    band : (lowest, highest) [Hz]
        Unless given, all lines but those at 0 Hz.

    Raises
    ------
    ValueError
        When the band lies outside the data or has too few lines, or no pole is stable.
    """
    measured, band = lines_in(machine.foundation, band)
    disks = [machine.coordinate(z, direction) for z in machine.rotor.disks for direction in "xy"]
    places = {str(k): k for k in (*machine.journals, *disks)}
    frf = MeasuredMachine(machine.rotor, machine.grounded, measured).frf(places, speed)
    most = largest_order(len(frf.frequency), len(places))
    orders = range(4, min(24, most) + 1) if most > 4 else None
    return stable_poles(stabilisation(frf, orders, band))[0]


@one_thread
def passivity(frf: FRF) -> Array:
    """The least energy that the foundation takes from any forces at its seats, line by line, (n,) [-].

    Forces f of one frequency do the work pi f^H L f in a turn, with L = (H^H - H) / 2i, for a symmetric H its negative
    imaginary part. Given is the smallest eigenvalue of L as a part of the largest singular value of H. A foundation
    without a source of energy has none below zero.
    """
    loss = (frf.H.conj().transpose(0, 2, 1) - frf.H) / 2j
    size = np.linalg.norm(frf.H, ord=2, axis=(1, 2))
    return np.asarray(np.linalg.eigvalsh(loss)[:, 0] / np.where(size > 0, size, 1.0))


def _dynamic_stiffness(bearings: Mapping[float, Bearing], omega: float) -> Complex:
    """Of all bearings, (seats, seats) complex [N/m]: K + i omega C."""
    return np.asarray(linalg.block_diag(*(bearing.K + 1j * omega * bearing.C for bearing in bearings.values())))


def _receptance_at(frf: FRF, speed: float, interpolate: bool) -> Complex:
    """H on the line of a speed [rad/s], (seats, seats), or between two lines if that was asked for."""
    lines, f = frf.frequency, float(hertz(speed))
    nearest = int(np.abs(lines - f).argmin()) if np.isfinite(f) else 0
    # a speed that came from rev/min is a line up to its rounding
    if abs(lines[nearest] - f) <= 1e-9 * f:
        return frf.H[nearest]
    told = f"A speed of {rpm(speed):g} rev/min is {f:g} Hz"
    if not lines[0] <= f <= lines[-1]:
        raise ValueError(
            f"{told}: the FRFs reach from {lines[0]:g} to {lines[-1]:g} Hz, and nothing is known of the foundation "
            "outside."
        )
    upper = int(np.searchsorted(lines, f))
    lower = upper - 1
    if not interpolate:
        raise ValueError(
            f"{told}: the lines around it are at {lines[lower]:g} and {lines[upper]:g} Hz. Take speeds on lines, or "
            "interpolate=True."
        )
    part = (f - lines[lower]) / (lines[upper] - lines[lower])
    return np.asarray((1 - part) * frf.H[lower] + part * frf.H[upper])
