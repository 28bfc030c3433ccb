"""A set of FRFs: which file holds which pair of seats, its quantity and unit, and the pairs as one FRF."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rbfound.files.text import Curve, curves_of, decoded, listed
from rbfound.frf import FRF
from rbfound.units import radians

Complex = NDArray[np.complex128]

# How often a quantity is differentiated in time.
QUANTITIES = {"receptance": 0, "mobility": 1, "accelerance": 2}


# Derivative and size in SI of a response's unit, and newtons of a force's. g is the standard acceleration of gravity.
RESPONSES = {
    "m": (0, 1.0),
    "cm": (0, 1e-2),
    "mm": (0, 1e-3),
    "um": (0, 1e-6),
    "in": (0, 0.0254),
    "m/s": (1, 1.0),
    "mm/s": (1, 1e-3),
    "in/s": (1, 0.0254),
    "m/s2": (2, 1.0),
    "mm/s2": (2, 1e-3),
    "in/s2": (2, 0.0254),
    "g": (2, 9.80665),
}


FORCES = {"N": 1.0, "kN": 1e3, "lbf": 4.4482216152605}


ASK = "Say it with unit=: 'm', 'mm', 'm/s', 'm/s2', 'mm/s2', 'g', ... (or 'mm/N': per unit of force)."


def parsed_unit(unit: str) -> tuple[int, float, bool]:
    """(times differentiated, size in SI, whether it is for a unit force) of a text such as "mm", "g/N" or "m/s²"."""
    text = unit.strip().strip("[]").replace(" ", "").replace("²", "2").replace("^", "").replace("**", "")
    text = (
        text.replace("µ", "u").replace("μ", "u").replace("s/s", "s2").replace("(m/s2)", "m/s2").replace("(m/s)", "m/s")
    )
    response, force = text, None
    match = re.fullmatch(r"(.+)/(N|kN|lbf)", text)
    if match:
        response, force = match[1], match[2]
    if response not in RESPONSES:
        raise ValueError(
            f"The unit {unit!r} is not known: responses are in {', '.join(RESPONSES)}, forces in {', '.join(FORCES)}."
        )
    derivative, size = RESPONSES[response]
    return derivative, size / (FORCES[force] if force else 1.0), force is not None


def said_unit(source: str, found: str | None, unit: str | None, quantity: str | None) -> str:
    """The unit that holds for a source: what it says itself, what the caller says, and a ValueError if they differ."""
    if quantity is not None and quantity not in QUANTITIES:
        raise ValueError(f"quantity is {quantity!r}: it must be {', '.join(QUANTITIES)}.")
    said = found if unit is None else unit
    if said is None:
        raise ValueError(f"{source} does not say in which unit its responses are. {ASK}")
    try:
        derivative, size, _ = parsed_unit(said)
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from None
    if found is not None and unit is not None and parsed_unit_or_none(found) not in (None, (derivative, size)):
        raise ValueError(f"{source} says that its unit is {found!r}, unit= says {unit!r}: only one can be right.")
    if quantity is not None and QUANTITIES[quantity] != derivative:
        (name,) = (name for name, order in QUANTITIES.items() if order == derivative)
        raise ValueError(f"{source}: the unit {said!r} is that of {name}, not of {quantity}.")
    return said


def parsed_unit_or_none(unit: str) -> tuple[int, float] | None:
    """Derivative and size of a unit, or None where it is not known."""
    try:
        return parsed_unit(unit)[:2]
    except ValueError:
        return None


def receptance(frequency: NDArray[np.float64], values: Complex, unit: str, force: float = 1.0) -> Complex:
    """Values (n, ...) in a unit, for a force [N], as receptances [m/N]; no line may then be at 0 Hz unless they are.

    A unit for a unit force ("m/N") and a force other than 1 N contradict each other.
    """
    derivative, size, whole = parsed_unit(unit)
    if not np.isfinite(force) or force == 0:
        raise ValueError(f"force is {force} N: it must be finite and not zero.")
    if whole and force != 1:
        raise ValueError(f"The unit {unit!r} is for a unit force already, and force= says {force:g} N: leave one out.")
    omega = np.asarray(radians(frequency)).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values * (size / force) / (1j * omega) ** derivative if derivative else values * (size / force))


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


NAME = re.compile(r"(?P<response>[xy]\d+)_from_(?P<force>[xy]\d+)\.(?:txt|csv|dat)$", re.IGNORECASE)


# Sixty-four bearings would have four times as many.
MOST_FILES = 4096


# Stands in a folder while `rbfound.files.load_save.save_frf` puts the files of a new set in the place of an old one.
MIXED = "half-written"


def curves_of_folder(folder: Path, columns: str | None, pattern: str | None) -> tuple[dict[Pair, Curve], str]:
    """The FRF of each text file of a folder, and a hint at files whose names say no seats."""
    if (folder / MIXED).exists():
        raise ValueError(
            f"{folder} was being written when that was interrupted, and may hold files of two sets: save it again. "
            f"(If you know that its files belong together, remove the file {MIXED}.)"
        )
    name = NAME if pattern is None else _pattern(pattern)
    numbered = "number" in name.groupindex
    matches = [
        (path, match) for path in sorted(folder.iterdir()) if path.is_file() and (match := name.search(path.name))
    ]
    if not matches:
        raise ValueError(
            f"{folder} holds no FRFs: expected text files with names like {pattern or 'frf01_x1_from_y1.txt'}."
        )
    if len(matches) > MOST_FILES:
        raise ValueError(f"{folder} holds {len(matches)} files: at most {MOST_FILES} are read.")
    order = _table_2(folder, len(matches)) if numbered else []
    paths: dict[Pair, Path] = {}
    for path, match in matches:
        if numbered:
            if not 1 <= int(match["number"]) <= len(order):
                raise ValueError(f"{path}: the numbers of {len(order)} FRFs go from 1 to {len(order)}.")
            pair = order[int(match["number"]) - 1]
        else:
            pair = match["response"].lower(), match["force"].lower()
        if pair in paths:
            raise ValueError(f"{paths[pair].name} and {path.name} in {folder} both hold {pair[0]} from {pair[1]}.")
        paths[pair] = path
    texts = [p.name for p in sorted(folder.iterdir()) if p.suffix.lower() == ".txt" and not name.search(p.name)]
    hint = f" Files whose names say no pair of seats: {listed(texts)}." if texts else ""
    return {pair: _single(path, columns) for pair, path in paths.items()}, hint


def _pattern(pattern: str) -> re.Pattern[str]:
    """A regular expression for names such as "H_{response}_{force}.csv"."""
    parts = re.split(r"(\{\w*\})", pattern)
    fields = [part for part in parts if part.startswith("{")]
    if sorted(fields) not in (["{force}", "{response}"], ["{number}"]):
        raise ValueError(f"pattern is {pattern!r}: it must hold {{response}} and {{force}}, or {{number}}.")
    groups = {
        "{response}": r"(?P<response>[xy]\d{1,3})",
        "{force}": r"(?P<force>[xy]\d{1,3})",
        "{number}": r"(?P<number>\d{1,4})",
    }
    return re.compile("^" + "".join(groups.get(part, re.escape(part)) for part in parts) + "$", re.IGNORECASE)


def _table_2(folder: Path, count: int) -> list[Pair]:
    """The pairs in the order of table 2: forces y1, x1, y2, x2, responses x1, y1, x2, y2."""
    bearings = round(count**0.5 / 2)
    if 4 * bearings**2 != count:
        raise ValueError(f"{folder} holds {count} numbered files: it must be 4, 16, 36, ..., all pairs of seats.")
    labels = [f"{axis}{k + 1}" for k in range(bearings) for axis in "xy"]
    forces = [f"{axis}{k + 1}" for k in range(bearings) for axis in "yx"]
    return [(response, driven) for driven in forces for response in labels]


def _single(path: Path, columns: str | None) -> Curve:
    """The one FRF of a file, whatever its heading says of seats: its name says them."""
    curves = curves_of(path, columns)
    if len(curves) > 1:
        raise ValueError(f"{path} holds {len(curves)} FRFs where its name says one.")
    return next(iter(curves.values()))


def curves_of_file(path: Path, columns: str | None) -> dict[Pair, Curve]:
    """The FRFs of a table whose heading names the seats, or of the files that an index names."""
    text = decoded(path)
    heading = re.split(r"\s*[;,\t]\s*", text.lstrip()[:1000].split("\n")[0].strip().lower())
    if {"file", "response", "force"} <= set(heading):
        lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
        return _indexed(path, heading, lines[1:], columns)
    curves = curves_of(path, columns)
    if None in curves:
        raise ValueError(
            f"{path}: its heading does not say of which seats its columns are: name them 'x1 from y1 real [m/N]' and "
            "so on, or give the folder of all files, or an index with the heading 'file, response, force'."
        )
    return {pair: curve for pair, curve in curves.items() if pair is not None}


def _indexed(path: Path, heading: list[str], lines: list[tuple[int, str]], columns: str | None) -> dict[Pair, Curve]:
    """The FRFs of the files that an index names, relative to its own folder."""
    if len(lines) > MOST_FILES:
        raise ValueError(f"{path} names {len(lines)} files: at most {MOST_FILES} are read.")
    out: dict[Pair, Curve] = {}
    for number, line in lines:
        cells = re.split(r"\s*[;,\t]\s*", line.strip())
        if len(cells) != len(heading):
            raise ValueError(f"{path}, line {number}: {len(cells)} cells where there should be {len(heading)}.")
        row = dict(zip(heading, cells, strict=True))
        pair = row["response"].lower(), row["force"].lower()
        if not all(re.fullmatch(r"[xy]\d{1,3}", seat) for seat in pair):
            raise ValueError(f"{path}, line {number}: {pair[0]!r} from {pair[1]!r}: seats are x1, y1, x2, y2, ...")
        if pair in out:
            raise ValueError(f"{path}, line {number}: {pair[0]} from {pair[1]} was named before.")
        if not row["file"] or "\0" in row["file"]:
            raise ValueError(f"{path}, line {number}: no file is named.")
        out[pair] = _single(path.parent / row["file"], columns)
    if not out:
        raise ValueError(f"{path} is an index without files.")
    return out
