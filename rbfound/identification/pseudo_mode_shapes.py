"""From measured FRFs to a foundation: the pseudo mode shape method and its equivalent matrices."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.foundation import Foundation, checked_modes
from rbfound.frf import FRF, SEATS
from rbfound.identification.circle import circle_fit, modal_constants
from rbfound.measurement import Peaks, nearest_peak
from rbfound.parallel import one_thread
from rbfound.system import mac
from rbfound.theory import real_matrices
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Two columns with a higher MAC than this are nearly the same shape, and Phi can hardly be inverted.
PARALLEL = 0.9


@dataclass(frozen=True, eq=False)
class PseudoModes:
    """One pseudo mode a seat, and what it was read from.

    Attributes
    ----------
    Phi : (seats, seats) [1/sqrt(kg)]
        Column j comes from the FRFs driven at seat j, at the peak of seat j. Complex with parts="complex".
    omega : (seats,) [rad/s]
    zeta : (seats,) [-]
    """

    Phi: Array | Complex
    omega: Array
    zeta: Array

    @property
    def condition(self) -> float:
        """Condition number of Phi: an error of the data reaches the matrices up to its square as large."""
        return float(np.linalg.cond(self.Phi))


@one_thread
def pseudo_modes(
    frf: FRF,
    peaks: Sequence[float] | Peaks,
    *,
    interpolate: bool = True,
    method: str = "peak",
    parts: str = "real",
) -> PseudoModes:
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
        Between the lines; see `rbfound.theory.sdof.half_power`.
    method : "peak" or "circle"
        "circle" reads frequency, damping and products off circles instead, which need not be told from the other
        modes' constant share: `rbfound.identification.circle.circle_fit` of the driving point, `modal_constants` of its
        column. It takes frequencies, not `Peaks`.
    parts : "real" or "complex"
        What is kept of each product. "complex" keeps the phase too: that of a complex mode (damping that couples
        modes), and with method="peak" that of the other modes' share.

    Raises
    ------
    ValueError
        When there is not one peak a seat, a peak lies beside the data or has no damping, a driving point gains
        energy, or method or parts is another word.
    """
    for name, value, known in (("method", method, ("peak", "circle")), ("parts", parts, ("real", "complex"))):
        if value not in known:
            raise ValueError(f'{name} is {value!r}: it must be "{known[0]}" or "{known[1]}".')
    if len(peaks) != len(frf.labels):
        raise ValueError(f"{len(peaks)} peaks are given: there must be one a seat, {', '.join(frf.labels)}.")
    chosen, product = (_from_circles if method == "circle" else _from_peaks)(frf, peaks, interpolate)
    Phi = np.empty_like(product) if parts == "complex" else np.empty(product.shape)
    for j, label in enumerate(frf.labels):
        if not product[j, j].real > 0:
            raise ValueError(
                f"The driving point {label} has a positive imaginary part at {chosen.frequency[j]:g} Hz: a driving "
                "point loses energy (Im H < 0). Its sensor or its force may be the wrong way round."
            )
        column = product[:, j] if parts == "complex" else np.real(product[:, j])
        Phi[:, j] = column / np.sqrt(column[j])
    return PseudoModes(Phi, np.asarray(from_hertz(chosen.frequency)), chosen.damping)


def equivalent_matrices(
    Phi: ArrayLike,
    omega: ArrayLike,
    zeta: ArrayLike,
    labels: tuple[str, ...] = SEATS,
    notes: tuple[str, ...] = (),
) -> Foundation:
    """Equivalent matrices of a square Phi (equations 62-64), with the seats themselves as coordinates.

    M = Phi^-T Phi^-1,  C = Phi^-T diag(2 zeta omega) Phi^-1,  K = Phi^-T diag(omega^2) Phi^-1

    A complex Phi would make these complex: no masses and springs. It is taken for what complex shapes are, modes of
    a real system whose damping couples them, with their conjugates beside them. Such modes psi = phi /
    sqrt(2 i omega_d) obey sum psi psi' = 0 (conjugates included), and shapes from data do so only nearly. The nearest
    ones that do are taken, with the poles as they are, and M, C and K follow from these, real and symmetric (Balmes
    1997, Mechanical Systems and Signal Processing 11, 229-243). For a real Phi they are equations 62-64.

    Parameters
    ----------
    Phi : (seats, seats) [1/sqrt(kg)]
        Mass-normalised shapes, one column a mode; real or complex.
    omega : (seats,) [rad/s]
    zeta : (seats,) [-]

    Raises
    ------
    ValueError
        When Phi is not square (use `modal_foundation` for more, or fewer, modes than seats) or singular, or so
        complex that no real system is near.
    """
    if np.iscomplexobj(Phi):
        Phi = np.asarray(Phi)
        _, omega, zeta = checked_modes(np.abs(Phi), omega, zeta, labels)
    else:
        Phi, omega, zeta = checked_modes(Phi, omega, zeta, labels)
    if Phi.shape[0] != Phi.shape[1]:
        raise ValueError(
            f"Phi is {Phi.shape[0]} x {Phi.shape[1]}: equivalent matrices need as many modes as seats. "
            "modal_foundation(Phi, omega, zeta) takes any number."
        )
    condition = np.linalg.cond(Phi)
    if condition > 1 / np.finfo(float).eps:
        raise ValueError(
            f"Phi is singular (condition number {condition:.1e}): two columns are the same mode, or two "
            "seats move alike."
        )
    if np.iscomplexobj(Phi):
        M, C, K = real_matrices(Phi.astype(complex), omega, zeta)
        foundation = Foundation(M, C, K, np.eye(len(labels)), labels, (*notes, *_warnings(Phi, labels)))
        return replace(foundation, notes=(*foundation.notes, *_active(foundation)))
    inverse = np.linalg.inv(Phi)
    M, C, K = (
        # the factor in the middle is halved so that the product is symmetric to the last bit
        (half := inverse * np.sqrt(d)[:, None]).T @ half
        for d in (np.ones_like(omega), 2 * zeta * omega, omega**2)
    )
    return Foundation(M, C, K, np.eye(len(labels)), labels, (*notes, *_warnings(Phi, labels)))


def pmsm(
    frf: FRF,
    peaks: Sequence[float] | Peaks,
    *,
    interpolate: bool = True,
    method: str = "peak",
    parts: str = "real",
) -> Foundation:
    """Pseudo mode shape method: sixteen FRFs and one peak a seat to equivalent matrices (equations 57-64).

    The thesis takes pmsm(frf, [150, 350, 150, 350]): the X mode from both x seats, the Y mode from both y seats.
    Four distinct modes are better, each at the seat that sees it best; `print(foundation)` says what was used,
    the condition number of Phi, and which columns are nearly parallel.

    Parameters and errors are those of `pseudo_modes` and `equivalent_matrices`.
    """
    modes = pseudo_modes(frf, peaks, interpolate=interpolate, method=method, parts=parts)
    used = ", ".join(
        f"{label} {f:.4g} Hz {100 * zeta:.3g} %"
        for label, f, zeta in zip(frf.labels, hertz(modes.omega), modes.zeta, strict=True)
    )
    what = "Circles" if method == "circle" else "Peaks"
    return equivalent_matrices(modes.Phi, modes.omega, modes.zeta, frf.labels, (f"{what} used: {used}.",))


def _warnings(Phi: Array | Complex, labels: tuple[str, ...]) -> tuple[str, ...]:
    notes = [f"cond(Phi) = {np.linalg.cond(Phi):.3g}."]
    likeness = mac(Phi, Phi)
    for i, j in combinations(range(len(labels)), 2):
        if likeness[i, j] > PARALLEL:
            notes.append(
                f"Warning: columns {i + 1} ({labels[i]}) and {j + 1} ({labels[j]}) of Phi are nearly parallel "
                f"(MAC {likeness[i, j]:.4f}): one mode twice. Small errors of the data become large ones of M, C, K."
            )
    return tuple(notes)


def _from_peaks(frf: FRF, peaks: Sequence[float] | Peaks, interpolate: bool) -> tuple[Peaks, Complex]:
    """Peaks of the driving points and the products phi_ij phi_jj there, (seats, seats) [1/kg]."""
    chosen = peaks if isinstance(peaks, Peaks) else _driving_point_peaks(frf, peaks, interpolate)
    _check_peaks(frf, chosen)
    omega, zeta = np.asarray(from_hertz(chosen.frequency)), chosen.damping
    columns = [
        2j * zeta[j] * omega[j] ** 2 * _column_at(frf, j, chosen.frequency[j], interpolate)
        for j in range(len(frf.labels))
    ]
    return chosen, np.column_stack(columns)


def _from_circles(frf: FRF, near: Sequence[float] | Peaks, interpolate: bool) -> tuple[Peaks, Complex]:
    """The same by circles: what is read lies between the lines anyhow."""
    if isinstance(near, Peaks):
        raise ValueError('method="circle" reads the damping itself: give one frequency [Hz] a seat, not Peaks.')
    if not interpolate:
        raise ValueError('method="circle" uses all lines about a peak: interpolate=False has no meaning there.')
    fits = [
        circle_fit(frf.frequency, frf.H[:, j, j], float(f), name=f"the driving point {frf.labels[j]}")
        for j, f in enumerate(near)
    ]
    columns = [modal_constants(frf.frequency, frf.H[:, :, j], fit) for j, fit in enumerate(fits)]
    chosen = Peaks(np.array([fit.natural_frequency for fit in fits]), np.array([fit.damping for fit in fits]))
    return chosen, np.column_stack(columns)


def _active(foundation: Foundation) -> tuple[str, ...]:
    """A warning for each matrix that can give energy away; those of a real Phi cannot."""
    return tuple(
        f"Warning: {name} is not positive definite (smallest eigenvalue {least:.2g} of the largest): this foundation "
        "can give energy away. Phases of Phi that are not those of its modes do so."
        for name, least in foundation.definiteness().items()
        if least <= 0
    )


def _driving_point_peaks(frf: FRF, near: Sequence[float], interpolate: bool) -> Peaks:
    found = [
        nearest_peak(frf.frequency, np.abs(frf.H[:, j, j]), float(f), interpolate, f"the driving point {label}")
        for j, (f, label) in enumerate(zip(near, frf.labels, strict=True))
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
