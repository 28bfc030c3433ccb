"""The foundation as the rotor sees it: a second-order system with an interface.

M q'' + C q' + K q = Bᵀ f,    x = B q        f, x: forces and displacements at the bearing seats
"""

from dataclasses import dataclass
from textwrap import fill

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.frf import FRF, SEATS
from rbfound.system import Modes, System
from rbfound.tables import table

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Foundation:
    """A foundation model, whatever road it came by.

    Attributes
    ----------
    M, C, K : (n, n) [kg, N s/m, N/m] in the coordinates q
        For a modal foundation these are I, diag(2 zeta omega), diag(omega^2).
    B : (seats, n)
        x = B q gives the displacements of the seats.
    labels : names of the seats, in the order x1, y1, x2, y2, ...
    notes : sentences that belong to this model
        How it was made and what to beware of. `print(foundation)` shows them.
    """

    M: Array
    C: Array
    K: Array
    B: Array
    labels: tuple[str, ...] = SEATS
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        system = System(self.M, self.C, self.K)
        B = np.asarray(self.B, dtype=float)
        if B.shape != (len(self.labels), len(system.M)):
            raise ValueError(
                f"B has shape {B.shape}: with {len(self.labels)} seats and {len(system.M)} coordinates "
                f"it must be ({len(self.labels)}, {len(system.M)})."
            )
        if not np.isfinite(B).all():
            row, column = np.argwhere(~np.isfinite(B))[0]
            raise ValueError(f"B[{row}, {column}] is {B[row, column]}: every entry must be finite.")
        for name, matrix in (("M", system.M), ("C", system.C), ("K", system.K), ("B", B)):
            object.__setattr__(self, name, matrix)
        object.__setattr__(self, "labels", tuple(self.labels))
        object.__setattr__(self, "notes", tuple(self.notes))

    def system(self) -> System:
        """The foundation alone, in its own coordinates."""
        return System(self.M, self.C, self.K)

    def modes(self) -> Modes:
        """Damped modes of the foundation alone; `B @ modes.shapes` are their shapes at the seats."""
        return self.system().modes()

    def frf(self, frequency: ArrayLike) -> FRF:
        """Receptances at the seats on the given lines [Hz]: H = B (K + i omega C - omega^2 M)^-1 Bᵀ."""
        frequency = np.atleast_1d(np.asarray(frequency, dtype=float))
        return FRF(frequency, self.system().receptance(frequency, self.B, self.B.T), self.labels)

    def asymmetry(self) -> float:
        """Worst |A - Aᵀ| of M, C and K, each relative to its largest entry."""
        worst = [np.abs(A - A.T).max() / (np.abs(A).max() or 1.0) for A in (self.M, self.C, self.K)]
        return float(max(worst))

    def definiteness(self) -> dict[str, float]:
        """Smallest eigenvalue of the symmetric part of M, C and K, relative to the largest.

        A passive foundation has M > 0, C >= 0 and K >= 0; a negative number says which matrix can give energy away.
        """
        out = {}
        for name, A in (("M", self.M), ("C", self.C), ("K", self.K)):
            values = np.linalg.eigvalsh((A + A.T) / 2)
            out[name] = float(values[0] / (np.abs(values).max() or 1.0))
        return out

    def __str__(self) -> str:
        modes = self.modes()
        lines = [
            f"Foundation with {len(self.M)} coordinates at the seats {', '.join(self.labels)}",
            table({"frequency [Hz]": modes.frequency, "damping [%]": 100 * modes.damping}),
        ]
        return "\n".join([*lines, *(fill(note, width=92) for note in self.notes)])


def modal_foundation(
    Phi: ArrayLike,
    omega: ArrayLike,
    zeta: ArrayLike,
    labels: tuple[str, ...] = SEATS,
    notes: tuple[str, ...] = (),
) -> Foundation:
    """A foundation in modal coordinates, with any number of modes: M = I, B = Phi.

    Each row is q'' + 2 zeta omega q' + omega^2 q = phi' f: equation 76, with the factor 2 that is not printed there.

    Parameters
    ----------
    Phi : (seats, modes) [1/sqrt(kg)]
        Mass-normalised shapes at the seats.
    omega : (modes,) [rad/s]
        Undamped natural frequencies.
    zeta : (modes,) [-]
        Damping ratios.
    """
    Phi, omega, zeta = checked_modes(Phi, omega, zeta, labels)
    return Foundation(np.eye(len(omega)), np.diag(2 * zeta * omega), np.diag(omega**2), Phi, labels, notes)


def checked_modes(
    Phi: ArrayLike, omega: ArrayLike, zeta: ArrayLike, labels: tuple[str, ...]
) -> tuple[Array, Array, Array]:
    """Phi (seats, modes), omega (modes,) and zeta (modes,) as arrays, or a ValueError that says what is wrong."""
    Phi = np.asarray(Phi, dtype=float)
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    zeta = np.atleast_1d(np.asarray(zeta, dtype=float))
    if Phi.ndim != 2 or len(Phi) != len(labels):
        raise ValueError(f"Phi has shape {Phi.shape}: with the seats {', '.join(labels)} it needs {len(labels)} rows.")
    modes = Phi.shape[1]
    for name, value in (("omega", omega), ("zeta", zeta)):
        if value.shape != (modes,):
            raise ValueError(f"{name} has shape {value.shape}: Phi has {modes} columns, so it must be ({modes},).")
    for name, value in (("Phi", Phi), ("omega", omega), ("zeta", zeta)):
        if not np.isfinite(value).all():
            raise ValueError(f"{name} holds a number that is not finite: {value[~np.isfinite(value)][0]}.")
    if (omega <= 0).any():
        raise ValueError(f"omega holds {omega.min():g} rad/s: natural frequencies must be positive.")
    if (zeta < 0).any():
        raise ValueError(f"zeta holds {zeta.min():g}: a foundation has no source of energy, damping ratios are >= 0.")
    return Phi, omega, zeta
