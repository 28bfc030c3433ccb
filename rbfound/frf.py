"""Frequency response functions at the bearing seats: receptance H = x / f."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.units import QUANTITIES, Unit, agreed_unit, from_hertz

STATIC = "The line at 0 Hz was left out: a mobility or an accelerance says nothing of the displacement there."
EMPTY = "The line at 0 Hz was left out: it holds no numbers."
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
    notes : sentences that belong to these data
        What was left out or filled in when they were read.
    """

    frequency: NDArray[np.float64]
    H: NDArray[np.complex128]
    labels: tuple[str, ...] = SEATS
    notes: tuple[str, ...] = ()

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
        object.__setattr__(self, "notes", tuple(self.notes))

    @classmethod
    def from_arrays(
        cls,
        frequency: ArrayLike,
        H: ArrayLike,
        labels: Sequence[str] = SEATS,
        *,
        unit: str,
        quantity: str | None = None,
        force: float = 1.0,
        conjugate: bool = False,
        delay: float = 0.0,
        notes: Sequence[str] = (),
    ) -> "FRF":
        """Receptances out of arrays of any quantity, as other programs hold them.

        `frequency` is (n,) [Hz], `H` (n, outputs, inputs). Of pyFBS this is `from_arrays(freq, Y, ...)`; where the
        lines come last (ROSS: `freq_resp`, SDynPy: `ordinate`), give `np.moveaxis(H, -1, 0)`, in ROSS only the rows
        and columns of X and Y at the bearings.

        Parameters
        ----------
        unit, quantity, force, conjugate, delay : as of `rbfound.load_frf`

        Raises
        ------
        ValueError
            For a unit that is not known, a quantity that contradicts it, and what `FRF` itself refuses.
        """
        f, values = np.asarray(frequency, dtype=float), np.asarray(H, dtype=complex)
        said = agreed_unit("The array", unit, None, quantity)
        if said.decibels:
            raise ValueError("Decibels have lost their phase: give complex numbers.")
        start, lost = left_out(f, values, said)
        f, values = f[start:], converted(f[start:], values[start:], said, force, conjugate, delay)
        if QUANTITIES[said.quantity][1]:
            checked = cls(f, values, tuple(labels))
            try:
                values = np.asarray(np.linalg.inv(checked.H))
            except np.linalg.LinAlgError:
                raise ValueError(f"On one line the {said.quantity} is singular: it has no inverse.") from None
        return cls(f, values, tuple(labels), (*notes, *lost))

    def between(self, low: float, high: float) -> "FRF":
        """The lines from `low` to `high` [Hz], both included."""
        inside = (self.frequency >= low) & (self.frequency <= high)
        if not inside.any():
            raise ValueError(
                f"No line lies between {low:g} and {high:g} Hz: "
                f"the FRFs reach from {self.frequency[0]:g} to {self.frequency[-1]:g} Hz."
            )
        return FRF(self.frequency[inside], self.H[inside], self.labels, self.notes)

    def with_noise(self, level: float, seed: int | np.random.Generator = 0) -> "FRF":
        """The same as if measured with noise: each receptance times 1 + level e, with E |e|^2 = 1 and e complex normal.

        Parameters
        ----------
        level : float
            Standard deviation relative to each |H|: 0.01 is 1 % of noise.
        seed : int or Generator
            The same number draws the same noise, and the same at any level.
        """
        rng = np.random.default_rng(seed)
        e = rng.standard_normal(self.H.shape) + 1j * rng.standard_normal(self.H.shape)
        return FRF(self.frequency, self.H * (1 + level * e / np.sqrt(2)), self.labels, self.notes)

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

    def kinds(self) -> NDArray[np.str_]:
        """What ties each response (row) to each force (column): an array of words, as large as H on one line.

        "direct" is one seat, "cross-coupling" X to Y at one bearing, "cross-talk" from one bearing to the other. Labels
        are a direction and the number of a bearing.
        """
        bearings = [re.sub(r"\D", "", label) or label[1:] for label in self.labels]
        same = np.equal.outer(bearings, bearings)
        words = np.where(same, "cross-coupling", "cross-talk")
        words[np.diag_indices(len(self.labels))] = "direct"
        return words

    def without(self, kind: str) -> "FRF":
        """The same with zeros in place of one kind of FRF: a foundation that lacks it."""
        kinds = self.kinds()
        if kind not in kinds:
            raise ValueError(f"There is no {kind!r} here: the kinds are {', '.join(sorted(set(kinds.ravel())))}.")
        return FRF(self.frequency, np.where(kinds == kind, 0, self.H), self.labels, self.notes)

    def _omega(self) -> NDArray[np.float64]:
        return np.asarray(from_hertz(self.frequency))[:, None, None]


def relative_error(H: ArrayLike, reference: ArrayLike) -> NDArray[np.float64]:
    """|H - reference| / |reference| line by line, (n,): receptances (n,), or matrices in Frobenius' norm."""
    H, reference = np.asarray(H), np.asarray(reference)
    if H.shape != reference.shape:
        raise ValueError(f"H has shape {H.shape} and reference {reference.shape}: they must be alike.")
    lines = len(reference)
    size = np.linalg.norm(reference.reshape(lines, -1), axis=1)
    return np.asarray(np.linalg.norm((H - reference).reshape(lines, -1), axis=1) / size)


def left_out(frequency: NDArray[np.float64], values: NDArray[np.complex128], unit: Unit) -> tuple[int, tuple[str, ...]]:
    """Whether the first line is at 0 Hz and says nothing (0 or 1), and a note of that."""
    if not len(frequency) or frequency[0] != 0:
        return 0, ()
    if QUANTITIES[unit.quantity][0]:
        return 1, (STATIC,)
    return (0, ()) if np.isfinite(values[:1]).all() else (1, (EMPTY,))


def converted(
    frequency: NDArray[np.float64],
    values: NDArray[np.complex128],
    unit: Unit,
    force: float = 1.0,
    conjugate: bool = False,
    delay: float = 0.0,
) -> NDArray[np.complex128]:
    """Values (n, ...) in a unit as receptances [m/N], or as stiffnesses [N/m] where they are forces over motions.

    `conjugate` is for time factors exp(-i omega t); `delay` [s] is how much later than the force the motion was
    recorded.
    """
    order, over = QUANTITIES[unit.quantity]
    if not np.isfinite(force) or force == 0:
        raise ValueError(f"force is {force} N: it must be finite and not zero.")
    if (unit.whole or over) and force != 1:
        raise ValueError(f"The unit is for a unit force already, and force= says {force:g} N: leave one out.")
    if not np.isfinite(delay):
        raise ValueError(f"delay is {delay} s: it must be finite.")
    values = (values.conj() if conjugate else values) * (unit.size / force)
    s = 1j * np.asarray(from_hertz(frequency)).reshape(-1, *[1] * (values.ndim - 1))
    sign = -1 if over else 1
    if order:
        values = values / s ** (sign * order)
    return np.asarray(values * np.exp(sign * delay * s) if delay else values)


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
