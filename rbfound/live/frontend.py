"""What a front end shows of moved peaks: plain numbers and bytes, so that it need not know how they come about."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.identification import ModalFit
from rbfound.live.bench import Bench, thinned
from rbfound.live.picking import METHODS, Pick, Picked, first_picks, picked
from rbfound.units import hertz

Array = NDArray[np.float64]

# Lines of the data that are sent; about each mode of a picked foundation some more, so many half-widths from its peak.
MOST_LINES = 4000
ABOUT = np.linspace(-1, 1, 25) ** 3 * 8
# Two frequencies that lie further apart than this part are not one mode seen twice.
SAME = 0.05


def scene(bench: Bench) -> tuple[dict[str, Any], bytes]:
    """What a front end draws before any peak is picked: names and numbers, and the curves.

    The bytes are 32-bit floats: the lines [Hz], then real and imaginary part of each FRF by turns, response by
    response and force by force.
    """
    shown = thinned(bench.frf, MOST_LINES)
    alone, under = bench.true_frequencies
    names = {
        "labels": list(bench.frf.labels),
        "methods": [list(item) for item in METHODS.items()],
        "lines": len(shown.frequency),
        "step": float(np.median(np.diff(bench.frf.frequency))),
        "readings": [
            [{"frequency": p.frequency, "height": p.height, "low": p.low, "high": p.high} for p in own]
            for own in bench.readings
        ],
        "first": {method: _first(bench, method) for method in METHODS},
        "findings": list(bench.findings),
        "size": bench.size,
        "rotor": bench.journals is not None,
        "truth": {"alone": alone.tolist(), "under": under.tolist()} if bench.truth is not None else None,
    }
    return names, _bytes(shown.frequency, np.moveaxis(shown.H, 0, -1))


def answer(bench: Bench, peaks: Sequence[Any], method: str = "pmsm") -> tuple[Picked | None, dict[str, Any], bytes]:
    """What a front end draws once peaks are picked, or the sentence that says why it cannot.

    The bytes are 32-bit floats: the lines [Hz], then real and imaginary part of the FRFs by turns, of the seats
    (0, 0), (0, 1), ..., (1, 1), ...: a foundation is reciprocal.
    """
    try:
        found = picked(bench, peaks, method)
    except ValueError as error:
        return None, {"message": str(error), "method": method}, b""
    return found, _told(bench, found), _curves(bench, found)


def paired(truth: ArrayLike, found: ArrayLike) -> list[tuple[float | None, float | None]]:
    """Frequencies side by side, nearest first served; one without a partner within 5 % stands alone. Ascending."""
    left, right = (list(map(float, np.ravel(values))) for values in (truth, found))
    near = sorted((abs(np.log(a / b)), i, j) for i, a in enumerate(left) for j, b in enumerate(right))
    rows: list[tuple[float | None, float | None]] = []
    lefts, rights = set(range(len(left))), set(range(len(right)))
    for distance, i, j in near:
        if distance < SAME and i in lefts and j in rights:
            lefts.remove(i)
            rights.remove(j)
            rows.append((left[i], right[j]))
    rows += [(left[i], None) for i in lefts] + [(None, right[j]) for j in rights]
    return sorted(rows, key=lambda row: row[0] or row[1] or 0.0)


def _first(bench: Bench, method: str) -> list[Pick]:
    """Peaks to begin with; none where the FRFs do not show them, and the answer to none says so."""
    try:
        return first_picks(bench, method)
    except ValueError:
        return []


def _told(bench: Bench, found: Picked) -> dict[str, Any]:
    """Numbers that JSON can hold."""
    square = found.method != "identify"
    alone, under = bench.true_frequencies
    columns = [
        f"{seat} {f:.1f} Hz" if seat else f"{f:.1f} Hz"
        for seat, f in zip(found.seats, found.peaks.frequency, strict=True)
    ]
    return {
        "message": "",
        "method": found.method,
        "peaks": [
            {"seat": seat, "frequency": float(f), "damping": float(zeta)}
            for seat, f, zeta in zip(found.seats, found.peaks.frequency, found.peaks.damping, strict=True)
        ],
        "columns": columns,
        "Phi": found.Phi.tolist(),
        "order": list(found.order),
        "condition": found.condition,
        "matrices": {name: getattr(found.foundation, name).tolist() for name in "MCK"} if square else None,
        "coordinates": len(found.foundation.M),
        "alone": paired(alone, found.alone),
        "under": paired(under, found.under),
        "fit": None if square else _fit(bench.fit),
    }


def _fit(fit: ModalFit) -> dict[str, Any]:
    """How well all modes fit the FRFs, and what each of them is."""
    unit = "% of |H|" if fit.relative else "m/N" if fit.errors is None else "times its error"
    scale = 100.0 if fit.relative else 1.0
    own = np.flatnonzero(fit.inside)
    return {
        "unit": unit,
        "misfit": (scale * fit.misfit).tolist(),
        "noise": scale * fit.noise,
        # beyond this it is an error of the model, see the notes of a fit
        "much": scale * 1.5 * max(fit.noise, 1e-3 * fit.relative),
        "modes": [[float(fit.natural_frequency[k]), 100 * float(fit.zeta[k]), bool(fit.unsure[k])] for k in own],
        "residual": fit.natural_frequency[~fit.inside].tolist(),
        "band": list(fit.band),
    }


def _curves(bench: Bench, found: Picked) -> bytes:
    about = hertz(np.outer(found.omega, np.ones_like(ABOUT)) * (1 + np.outer(found.zeta, ABOUT)))
    low, high = bench.lines[[0, -1]]
    lines = np.unique(np.concatenate([bench.lines, about[(about > low) & (about < high)]]))
    rows, columns = np.triu_indices(len(bench.frf.labels))
    return _bytes(lines, found.receptance(lines)[:, rows, columns].T)


def _bytes(lines: Array, curves: NDArray[np.complex128]) -> bytes:
    return lines.astype("<f4").tobytes() + np.ascontiguousarray(curves).astype("<c8").tobytes()
