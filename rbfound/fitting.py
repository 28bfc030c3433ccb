"""From measured FRFs to a foundation: the pseudo mode shape method and its equivalent matrices."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.foundation import Foundation, checked_modes
from rbfound.frf import FRF, SEATS
from rbfound.peaks import Peaks, nearest_peak
from rbfound.system import mac
from rbfound.units import hertz, radians

Array = NDArray[np.float64]

# Two columns with a higher MAC than this are nearly the same shape, and Phi can hardly be inverted.
PARALLEL = 0.9


@dataclass(frozen=True, eq=False)
class PseudoModes:
    """One pseudo mode a seat, and what it was read from.

    Attributes
    ----------
    Phi : (seats, seats) [1/sqrt(kg)]
        Column j comes from the FRFs driven at seat j, at the peak of seat j.
    omega : (seats,) [rad/s]
    zeta : (seats,) [-]
    """

    Phi: Array
    omega: Array
    zeta: Array

    @property
    def condition(self) -> float:
        """Condition number of Phi: an error of the data reaches the matrices up to its square as large."""
        return float(np.linalg.cond(self.Phi))


def pseudo_modes(frf: FRF, peaks: Sequence[float] | Peaks, *, interpolate: bool = True) -> PseudoModes:
    """Mode shapes column by column from the driving points (equations 57-61).

    At the peak of the driving point H_jj a single mode is taken to dominate, so that for a unit modal mass
    phi_jj = sqrt(2 i zeta omega^2 H_jj) and phi_ij = 2 i zeta omega^2 H_ij / phi_jj. Of each product the real
    part is kept: it is the quadrature of the FRF, which the undamped remainder of the other modes leaves alone.
    The frequency of the peak is taken for the undamped one (equation 33 does so too): zeta^2 too low, 0.04 % at 2 %.

    Parameters
    ----------
    peaks : one frequency [Hz] a seat, or `Peaks`
        From a frequency, the nearest peak of that seat's driving point and its half-power damping are used;
        `Peaks` are used as they are, on a peak or not.
    interpolate : bool
        Between the lines; see `rbfound.sdof.half_power`.
    """
    seats = len(frf.labels)
    chosen = peaks if isinstance(peaks, Peaks) else _driving_point_peaks(frf, peaks, interpolate)
    if len(chosen) != seats:
        raise ValueError(f"{len(chosen)} peaks are given: there must be one a seat, {', '.join(frf.labels)}.")
    _check_peaks(frf, chosen)
    omega, zeta = np.asarray(radians(chosen.frequency)), chosen.damping
    Phi = np.empty((seats, seats))
    for j, label in enumerate(frf.labels):
        product = np.real(2j * zeta[j] * omega[j] ** 2 * _column_at(frf, j, chosen.frequency[j], interpolate))
        if not product[j] > 0:
            raise ValueError(
                f"The driving point {label} has a positive imaginary part at {chosen.frequency[j]:g} Hz: a driving "
                "point loses energy (Im H < 0). Its sensor or its force may be the wrong way round."
            )
        Phi[:, j] = product / np.sqrt(product[j])
    return PseudoModes(Phi, omega, zeta)


def equivalent_matrices(
    Phi: ArrayLike,
    omega: ArrayLike,
    zeta: ArrayLike,
    labels: tuple[str, ...] = SEATS,
    notes: tuple[str, ...] = (),
) -> Foundation:
    """Equivalent matrices of a square Phi (equations 62-64), with the seats themselves as coordinates.

    M = Phi^-T Phi^-1,  C = Phi^-T diag(2 zeta omega) Phi^-1,  K = Phi^-T diag(omega^2) Phi^-1

    Parameters
    ----------
    Phi : (seats, seats) [1/sqrt(kg)]
        Mass-normalised shapes, one column a mode.
    omega : (seats,) [rad/s]
    zeta : (seats,) [-]

    Raises
    ------
    ValueError
        When Phi is not square (use `modal_foundation` for more, or fewer, modes than seats) or singular.
    """
    Phi, omega, zeta = checked_modes(Phi, omega, zeta, labels)
    if Phi.shape[0] != Phi.shape[1]:
        raise ValueError(
            f"Phi is {Phi.shape[0]} x {Phi.shape[1]}: equivalent matrices need as many modes as seats. "
            "modal_foundation(Phi, omega, zeta) takes any number."
        )
    condition = np.linalg.cond(Phi)
    if condition > 1 / np.finfo(float).eps:
        raise ValueError(f"Phi is singular (condition number {condition:.1e}): two columns are the same mode.")
    inverse = np.linalg.inv(Phi)
    M, C, K = (
        # the factor in the middle is halved so that the product is symmetric to the last bit
        (half := inverse * np.sqrt(d)[:, None]).T @ half
        for d in (np.ones_like(omega), 2 * zeta * omega, omega**2)
    )
    return Foundation(M, C, K, np.eye(len(labels)), labels, (*notes, *_warnings(Phi, labels)))


def pmsm(frf: FRF, peaks: Sequence[float] | Peaks, *, interpolate: bool = True) -> Foundation:
    """Pseudo mode shape method: sixteen FRFs and one peak a seat to equivalent matrices (equations 57-64).

    The thesis takes pmsm(frf, [150, 350, 150, 350]): the X mode from both x seats, the Y mode from both y seats.
    Four distinct modes are better, each at the seat that sees it best; `print(foundation)` says what was used,
    the condition number of Phi, and which columns are nearly parallel.

    Parameters and errors are those of `pseudo_modes` and `equivalent_matrices`.
    """
    modes = pseudo_modes(frf, peaks, interpolate=interpolate)
    used = ", ".join(
        f"{label} {f:.4g} Hz {100 * zeta:.3g} %"
        for label, f, zeta in zip(frf.labels, hertz(modes.omega), modes.zeta, strict=True)
    )
    return equivalent_matrices(modes.Phi, modes.omega, modes.zeta, frf.labels, (f"Peaks used: {used}.",))


def _warnings(Phi: Array, labels: tuple[str, ...]) -> tuple[str, ...]:
    notes = [f"cond(Phi) = {np.linalg.cond(Phi):.3g}."]
    likeness = mac(Phi, Phi)
    for i, j in combinations(range(len(labels)), 2):
        if likeness[i, j] > PARALLEL:
            notes.append(
                f"Warning: columns {i + 1} ({labels[i]}) and {j + 1} ({labels[j]}) of Phi are nearly parallel "
                f"(MAC {likeness[i, j]:.4f}): one mode twice. Small errors of the data become large ones of M, C, K."
            )
    return tuple(notes)


def _driving_point_peaks(frf: FRF, near: Sequence[float], interpolate: bool) -> Peaks:
    near = [float(f) for f in near]
    if len(near) != len(frf.labels):
        raise ValueError(f"{len(near)} peaks are given: there must be one a seat, {', '.join(frf.labels)}.")
    found = [
        nearest_peak(frf.frequency, np.abs(frf.H[:, j, j]), f, interpolate, f"the driving point {frf.labels[j]}")
        for j, f in enumerate(near)
    ]
    return Peaks(np.array([p.frequency for p in found]), np.array([p.damping for p in found]))


def _check_peaks(frf: FRF, peaks: Peaks) -> None:
    low, high = frf.frequency[[0, -1]]
    for label, f, zeta in zip(frf.labels, peaks.frequency, peaks.damping, strict=True):
        if not low <= f <= high:
            raise ValueError(f"The peak for {label} is at {f:g} Hz: the FRFs reach from {low:g} to {high:g} Hz.")
        if not 0 < zeta < 1:
            raise ValueError(
                f"The peak for {label} at {f:g} Hz has the damping ratio {zeta:g}: it must lie between 0 and 1. "
                "(nan: the peak does not fall to half power before its neighbour rises; give Peaks with a damping.)"
            )


def _column_at(frf: FRF, j: int, frequency: float, interpolate: bool) -> NDArray[np.complex128]:
    """H[:, j] at a frequency between lines: 1/H_jj and the ratios H_ij / H_jj are smooth there, H is not."""
    nearest = int(np.abs(frf.frequency - frequency).argmin())
    if not interpolate or len(frf.frequency) < 3:
        return frf.H[nearest, :, j]
    first = min(max(nearest - 1, 0), len(frf.frequency) - 3)
    q = frf.frequency[first : first + 3] ** 2
    H = frf.H[first : first + 3, :, j]
    weight = [np.prod([(frequency**2 - q[m]) / (q[k] - q[m]) for m in range(3) if m != k]) for k in range(3)]
    ratio = np.tensordot(weight, H / H[:, [j]], axes=1)
    return np.asarray(ratio / np.tensordot(weight, 1 / H[:, j], axes=1))
