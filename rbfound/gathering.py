"""FRFs that were read one by one, put together to one set: seats, one grid, one unit, and what is missing."""

import re
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from rbfound.frf import FRF
from rbfound.quantities import parsed_unit, receptance, said_unit
from rbfound.rows import listed
from rbfound.textfiles import Curve

Pair = tuple[str, str]
SEAT = re.compile(r"[xy](0|[1-9]\d{0,2})")
# More bearings than any machine of this book has; a file that names seat x900 is not one of them.
MOST = 64
STATIC = "The line at 0 Hz was left out: a mobility or an accelerance says nothing of the displacement there."


def seats_of(labels: Iterable[str]) -> tuple[str, ...]:
    """x and y of every bearing that one of the labels names, in ascending order."""
    numbers = {int(label[1:]) for label in labels if SEAT.fullmatch(label)}
    return tuple(f"{axis}{number}" for number in sorted(numbers) for axis in "xy")


def gathered(
    curves: Mapping[Pair, Curve],
    where: str,
    *,
    unit: str | None,
    quantity: str | None,
    force: float,
    fill: bool,
    hint: str = "",
    notes: tuple[str, ...] = (),
) -> FRF:
    """One FRF of all pairs (response, force); `where` and `hint` go into the message when some are missing."""
    labels = seats_of(label for pair in curves for label in pair)
    if len(labels) > 2 * MOST:
        raise ValueError(f"{where} names {len(labels) // 2} bearings: at most {MOST} are read.")
    missing = [(i, j) for j in labels for i in labels if (i, j) not in curves]
    filled = [(i, j) for i, j in missing if (j, i) in curves] if fill else []
    lost = [pair for pair in missing if pair not in filled]
    if lost:
        other = [pair for pair in lost if (pair[1], pair[0]) in curves]
        ask = " fill=True takes H_ij for a missing H_ji." if len(other) == len(lost) else ""
        raise ValueError(
            f"{where} holds {len(curves)} of the {len(labels) ** 2} FRFs between {listed(labels)}. "
            f"Missing: {listed(f'{i} from {j}' for i, j in lost)}.{ask}{hint}"
        )
    first = curves.get((labels[0], labels[0])) or next(iter(curves.values()))
    for curve in curves.values():
        if curve.quantity is not None and quantity not in (None, curve.quantity):
            raise ValueError(f"{curve.source} holds {curve.quantity}, quantity= says {quantity}.")
    units = {
        pair: said_unit(str(curve.source), curve.unit, unit, curve.quantity or quantity)
        for pair, curve in curves.items()
    }
    said = list(notes)
    frequency = first.frequency
    # nothing can be said of the displacement from an acceleration at 0 Hz
    start = int(frequency[0] == 0 and any(parsed_unit(u)[0] for u in units.values()))
    if start:
        said.append(STATIC)
    H = np.empty((len(frequency) - start, len(labels), len(labels)), dtype=complex)
    for i, response in enumerate(labels):
        for j, driven in enumerate(labels):
            pair = (response, driven) if (response, driven) in curves else (driven, response)
            curve = curves[pair]
            _same_grid(first, curve)
            H[:, i, j] = receptance(frequency[start:], curve.values[start:], units[pair], force)
    if filled:
        told = ", ".join(f"{i} from {j}" for i, j in filled)
        said.append(f"Filled by reciprocity, not measured: {told}.")
    return FRF(frequency[start:], H, labels, tuple(said))


def _same_grid(first: Curve, curve: Curve) -> None:
    grid, frequency = curve.frequency, first.frequency
    shared = min(len(frequency), len(grid))
    apart: NDArray[np.intp] = np.flatnonzero(~np.isclose(grid[:shared], frequency[:shared], rtol=1e-9, atol=0))
    if len(apart):
        k = int(apart[0])
        here = f"{curve.source}, line {curve.lines[k]}" if curve.lines else f"{curve.source}, entry {k + 1}"
        there = f"{first.source.name}, line {first.lines[k]}," if first.lines else f"{first.source.name}"
        raise ValueError(
            f"{here}: {grid[k]:g} Hz where {there} has {frequency[k]:g} Hz. "
            "All FRFs must share one grid of frequencies."
        )
    if len(grid) != len(frequency):
        raise ValueError(
            f"{curve.source} has {len(grid)} frequencies, {first.source.name} has {len(frequency)}. "
            "All FRFs must share one grid of frequencies."
        )
