"""Frequency response functions at the bearing seats: receptance H = x / f."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rbfound.units import radians

SEATS = ("x1", "y1", "x2", "y2")


@dataclass(frozen=True, eq=False)
class FRF:
    """Receptances over frequency.

    Attributes
    ----------
    frequency : (n,) [Hz]
        Ascending.
    H : (n, outputs, inputs) complex [m/N]
        H[:, i, j] is the displacement at seat i for a unit force at seat j.
    labels : names of the seats
        In the order x1, y1, x2, y2, ...; inputs and outputs share them.
    """

    frequency: NDArray[np.float64]
    H: NDArray[np.complex128]
    labels: tuple[str, ...] = SEATS

    def __post_init__(self) -> None:
        frequency = np.asarray(self.frequency, dtype=float)
        H = np.asarray(self.H, dtype=complex)
        labels = tuple(self.labels)
        if frequency.ndim != 1 or len(frequency) == 0:
            raise ValueError(f"frequency has shape {frequency.shape}: it must be a row of at least one line.")
        check_ascending(frequency)
        seats = len(labels)
        if H.shape != (len(frequency), seats, seats):
            raise ValueError(
                f"H has shape {H.shape}: with {len(frequency)} lines and the seats {', '.join(labels)} "
                f"it must be ({len(frequency)}, {seats}, {seats})."
            )
        if len(set(labels)) != seats:
            raise ValueError(f"The labels {', '.join(labels)} are not all different.")
        if not np.isfinite(H).all():
            line, i, j = np.argwhere(~np.isfinite(H))[0]
            raise ValueError(
                f"H at {frequency[line]:g} Hz, response {labels[i]} to a force at {labels[j]}, is {H[line, i, j]}: "
                "every receptance must be finite."
            )
        object.__setattr__(self, "frequency", frequency)
        object.__setattr__(self, "H", H)
        object.__setattr__(self, "labels", labels)

    def between(self, low: float, high: float) -> "FRF":
        """The lines from `low` to `high` [Hz], both included."""
        inside = (self.frequency >= low) & (self.frequency <= high)
        if not inside.any():
            raise ValueError(
                f"No line lies between {low:g} and {high:g} Hz: "
                f"the FRFs reach from {self.frequency[0]:g} to {self.frequency[-1]:g} Hz."
            )
        return FRF(self.frequency[inside], self.H[inside], self.labels)

    def reciprocity(self) -> float:
        """Worst |H - Hᵀ| over all lines, relative to the largest receptance of that line; 0 for a perfect set."""
        difference = np.abs(self.H - self.H.transpose(0, 2, 1)).max(axis=(1, 2))
        largest = np.abs(self.H).max(axis=(1, 2))
        return float((difference / np.where(largest > 0, largest, 1.0)).max())

    def mobility(self) -> NDArray[np.complex128]:
        """Velocity for a unit force, i omega H [m/(N s)], (n, outputs, inputs)."""
        return np.asarray(1j * self._omega() * self.H)

    def accelerance(self) -> NDArray[np.complex128]:
        """Acceleration for a unit force, -omega^2 H [m/(N s^2)], (n, outputs, inputs)."""
        return np.asarray(-(self._omega() ** 2) * self.H)

    def seat(self, label: str) -> int:
        """Index of a seat by its name."""
        if label not in self.labels:
            raise ValueError(f"There is no seat {label!r}: the seats are {', '.join(self.labels)}.")
        return self.labels.index(label)

    def kind(self, response: str, force: str) -> str:
        """What ties two seats: "direct", "cross-coupling" (X to Y at one bearing) or "cross-talk" (to the other one).

        Parameters
        ----------
        response, force : labels such as x1: a direction and the number of a bearing
        """
        i, j = self.labels[self.seat(response)], self.labels[self.seat(force)]
        if i == j:
            return "direct"
        return "cross-coupling" if i[1:] == j[1:] else "cross-talk"

    def _omega(self) -> NDArray[np.float64]:
        return np.asarray(radians(self.frequency))[:, None, None]


def check_ascending(frequency: NDArray[np.float64]) -> None:
    """Raise a ValueError unless the frequencies are finite, not negative and strictly ascending."""
    if not np.isfinite(frequency).all() or (frequency < 0).any():
        bad = int(np.flatnonzero(~np.isfinite(frequency) | (frequency < 0))[0])
        raise ValueError(f"frequency[{bad}] is {frequency[bad]}: frequencies must be finite and not negative.")
    falls = np.flatnonzero(np.diff(frequency) <= 0)
    if len(falls):
        k = int(falls[0])
        raise ValueError(
            f"frequency[{k + 1}] = {frequency[k + 1]:g} Hz follows {frequency[k]:g} Hz: frequencies must ascend."
        )
