"""A set of FRFs: which file holds which pair of seats, its quantity and unit, and the pairs as one FRF."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rbfound.files.content import decoded, listed
from rbfound.files.text import POINT, Curve, curves_of
from rbfound.frf import FRF, converted, left_out
from rbfound.units import QUANTITIES, agreed_unit

Array = NDArray[np.float64]
Pair = tuple[str, str]

# More bearings than any machine of this book has; a file that names seat x900 is not one of them.
MOST = 64
# Sixty-four bearings would have four times as many.
MOST_FILES = 4096
# Stands in a folder while `rbfound.files.load_save.save_frf` puts the files of a new set in the place of an old one.
MIXED = "half-written"
# Frequencies with six printed digits are one grid, as long as they stay within this part of its finest step.
GRID, STEP = 1e-6, 1e-2

NAME = re.compile(rf"(?<![A-Za-z0-9])(?P<response>{POINT})_from_(?P<force>{POINT})\.(?:txt|csv|dat)$", re.IGNORECASE)

MAPPED = re.compile(rf"\s*({POINT})\s*=\s*([xy])0*([1-9]\d{{0,2}})\s*", re.IGNORECASE)
# What `rbfound.files.load_save.save_frf` calls its files.
OWN = re.compile(r"frf\d{2,}_[xy]\d+_from_[xy]\d+\.txt")


class Said(NamedTuple):
    """What a caller says of a set: see `rbfound.load_frf`."""

    unit: str | None = None
    quantity: str | None = None
    force: float = 1.0
    columns: str | None = None
    pattern: str | None = None
    fill: bool = False
    seats: str | None = None
    conjugate: bool = False
    delay: float = 0.0


def point_of(word: str) -> tuple[int, str, int]:
    """Number, direction and sign of a point: of x1, x01, 1X, 12:-Z."""
    match = re.fullmatch(r"([xyz])(\d+)|(\d+):?([+-]?)([xyz])", word.strip().lower())
    if match is None:
        raise ValueError(f"{word[:60]!r} is no seat: seats are x1, y1, x2, y2, ...")
    number, axis = int(match[2] or match[3]), match[1] or match[5]
    return number, axis, -1 if match[4] == "-" else 1


def plain(word: str) -> str:
    """The label of a point without its sign: x1 of x01, 1X, and 1:-X."""
    number, axis, _ = point_of(word)
    return f"{axis}{number}"


def seats_of(labels: tuple[str, ...]) -> tuple[str, ...]:
    """x and y of every bearing that one of the labels names, in ascending order."""
    numbers = {int(label[1:]) for label in labels if re.fullmatch(r"[xy](0|[1-9]\d{0,2})", label)}
    return tuple(f"{axis}{number}" for number in sorted(numbers) for axis in "xy")


def seated(curves: Mapping[Pair, Curve], where: str, seats: str | None) -> tuple[dict[Pair, Curve], tuple[str, ...]]:
    """The curves by seats, with the signs of their directions, and a note of those that `seats` does not name."""
    places: dict[tuple[int, str], tuple[str, int]] = {}
    for part in seats.split(",") if seats is not None else ():
        match = MAPPED.fullmatch(part)
        if match is None:
            raise ValueError(f"seats= says {part.strip()!r}: say it as '12+Z = y1, 7-X = x2'.")
        number, axis, sign = point_of(match[1])
        if (number, axis) in places or any(label == f"{match[2].lower()}{match[3]}" for label, _ in places.values()):
            raise ValueError(f"seats= says {part.strip()!r}, and said something else of one of them before.")
        places[number, axis] = f"{match[2].lower()}{match[3]}", sign
    out: dict[Pair, Curve] = {}
    left = 0
    for pair, curve in curves.items():
        ends = []
        for word in pair:
            number, axis, sign = point_of(word)
            if seats is None and axis == "z":
                raise ValueError(
                    f"{where}: {word} is along Z: seats move along X and Y. Say which they are: seats='{number}Z = y1'."
                )
            label, other = places.get((number, axis), ("", 1)) if seats is not None else (f"{axis}{number}", 1)
            ends.append((label, sign * other))
        (i, a), (j, b) = ends
        if not i or not j:
            left += 1
        elif (i, j) in out:
            raise ValueError(f"{where} holds two FRFs of {i} from {j}.")
        else:
            out[i, j] = replace(curve, values=curve.values if a * b > 0 else -curve.values)
    return out, (f"{left} FRFs at points that seats= does not name were left out.",) if left else ()


def gathered(
    curves: Mapping[Pair, Curve], where: str, said: Said, labels: tuple[str, ...] = (), hint: str = ""
) -> tuple[FRF, Array | None]:
    """One FRF of all pairs (response, force), and their coherence (n, outputs, inputs) where all have one.

    `labels` are those of the format, else the seats that the pairs name; `hint` goes into the message when some miss.
    """
    labels = labels or seats_of(tuple(label for pair in curves for label in pair))
    if not labels:
        raise ValueError(f"{where} holds no FRF between seats x1, y1, x2, y2, ...{hint}")
    if len(labels) > 2 * MOST:
        raise ValueError(f"{where} names {len(labels) // 2} bearings: at most {MOST} are read.")
    missing = [(i, j) for j in labels for i in labels if (i, j) not in curves]
    filled = [(i, j) for i, j in missing if (j, i) in curves] if said.fill else []
    lost = [pair for pair in missing if pair not in filled]
    if lost:
        other = [pair for pair in lost if (pair[1], pair[0]) in curves]
        ask = " fill=True takes H_ij for a missing H_ji." if len(other) == len(lost) else ""
        raise ValueError(
            f"{where} holds {len(curves)} of the {len(labels) ** 2} FRFs between {listed(labels)}. "
            f"Missing: {listed(f'{i} from {j}' for i, j in lost)}.{ask}{hint}"
        )
    units = {
        pair: agreed_unit(curve.source, curve.unit, said.unit, said.quantity, curve.quantity)
        for pair, curve in curves.items()
    }
    first = curves[labels[0], labels[0]] if (labels[0], labels[0]) in curves else next(iter(curves.values()))
    over = {QUANTITIES[unit.quantity][1] for unit in units.values()}
    if len(over) > 1:
        raise ValueError(f"{where} holds motions over forces and forces over motions: only one kind can be read.")
    starts = [left_out(curve.frequency, curve.values, units[pair]) for pair, curve in curves.items()]
    start, notes = max(starts)
    frequency = first.frequency[start:]
    H = np.empty((len(frequency), len(labels), len(labels)), dtype=complex)
    coherence = np.empty(H.shape)
    for i, response in enumerate(labels):
        for j, driven in enumerate(labels):
            pair = (response, driven) if (response, driven) in curves else (driven, response)
            curve = curves[pair]
            _same_grid(first, curve)
            H[:, i, j] = converted(frequency, curve.values[start:], units[pair], said.force, said.conjugate, said.delay)
            coherence[:, i, j] = np.nan if curve.coherence is None else curve.coherence[start:]
    if filled:
        notes = (*notes, f"Filled by reciprocity, not measured: {', '.join(f'{i} from {j}' for i, j in filled)}.")
    unit, quantity = ("N/m", "stiffness") if over == {True} else ("m/N", None)
    frf = FRF.from_arrays(frequency, H, labels, unit=unit, quantity=quantity, notes=notes)
    return frf, None if np.isnan(coherence).any() else coherence


def _same_grid(first: Curve, curve: Curve) -> None:
    grid, frequency = curve.frequency, first.frequency
    shared = min(len(frequency), len(grid))
    step = np.diff(frequency).min() if len(frequency) > 1 else np.inf
    apart = np.abs(grid[:shared] - frequency[:shared])
    bad: NDArray[np.intp] = np.flatnonzero((apart > GRID * frequency[:shared]) | (apart > STEP * step))
    if len(bad):
        k = int(bad[0])
        here = f"{curve.source}, line {curve.lines[k]}" if curve.lines else f"{curve.source}, entry {k + 1}"
        name = Path(first.source).name
        there = f"{name}, line {first.lines[k]}," if first.lines else name
        raise ValueError(
            f"{here}: {grid[k]:.10g} Hz where {there} has {frequency[k]:.10g} Hz. "
            "All FRFs must share one grid of frequencies."
        )
    if len(grid) != len(frequency):
        raise ValueError(
            f"{curve.source} has {len(grid)} frequencies, {Path(first.source).name} has {len(frequency)}. "
            "All FRFs must share one grid of frequencies."
        )


def curves_of_folder(folder: Path, said: Said) -> tuple[dict[Pair, Curve], str]:
    """The FRF of each text file of a folder, and a hint at files whose names say no seats."""
    if (folder / MIXED).exists():
        raise ValueError(
            f"{folder} was being written when that was interrupted, and may hold files of two sets: save it again. "
            f"(If you know that its files belong together, remove the file {MIXED}.)"
        )
    name = NAME if said.pattern is None else _pattern(said.pattern)
    numbered = "number" in name.groupindex
    matches = [
        (path, match) for path in sorted(folder.iterdir()) if path.is_file() and (match := name.search(path.name))
    ]
    if not matches:
        raise ValueError(
            f"{folder} holds no FRFs: expected text files with names like {said.pattern or 'frf01_x1_from_y1.txt'}."
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
            pair = _canonical(match["response"]), _canonical(match["force"])
        if pair in paths:
            raise ValueError(f"{paths[pair].name} and {path.name} in {folder} both hold {pair[0]} from {pair[1]}.")
        paths[pair] = path
    texts = [p.name for p in sorted(folder.iterdir()) if p.suffix.lower() == ".txt" and not name.search(p.name)]
    hint = f" Files whose names say no pair of seats: {listed(texts)}." if texts else ""
    return {pair: _single(path, said) for pair, path in paths.items()}, hint


def _canonical(word: str) -> str:
    """One spelling of a point: 12-z of 12:-Z, x1 of X01 and 1X."""
    number, axis, sign = point_of(word)
    return f"{axis}{number}" if sign > 0 else f"{number}-{axis}"


def _pattern(pattern: str) -> re.Pattern[str]:
    """A regular expression for names such as "H_{response}_{force}.csv"."""
    parts = re.split(r"(\{\w*\})", pattern)
    fields = [part for part in parts if part.startswith("{")]
    if sorted(fields) not in (["{force}", "{response}"], ["{number}"]):
        raise ValueError(f"pattern is {pattern!r}: it must hold {{response}} and {{force}}, or {{number}}.")
    groups = {
        "{response}": rf"(?P<response>{POINT})",
        "{force}": rf"(?P<force>{POINT})",
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


def _single(path: Path, said: Said) -> Curve:
    """The one FRF of a file, whatever its heading says of seats: its name says them."""
    curves = curves_of(path, said.columns, said.unit)
    if len(curves) > 1:
        raise ValueError(f"{path} holds {len(curves)} FRFs where its name says one.")
    return next(iter(curves.values()))


def curves_of_file(path: Path, said: Said) -> dict[Pair, Curve]:
    """The FRFs of a table whose heading names the seats, or of the files that an index names."""
    text = decoded(path)
    heading = re.split(r"\s*[;,\t]\s*", text.lstrip()[:1000].split("\n")[0].strip().lower())
    if {"file", "response", "force"} <= set(heading):
        lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
        return _indexed(path, heading, lines[1:], said)
    curves = curves_of(path, said.columns, said.unit)
    if None in curves:
        raise ValueError(
            f"{path}: its heading does not say of which seats its columns are: name them 'x1 from y1 real [m/N]' and "
            "so on, or give the folder of all files, or an index with the heading 'file, response, force'."
        )
    return {pair: curve for pair, curve in curves.items() if pair is not None}


def _indexed(path: Path, heading: list[str], lines: list[tuple[int, str]], said: Said) -> dict[Pair, Curve]:
    """The FRFs of the files that an index names, relative to its own folder."""
    if len(lines) > MOST_FILES:
        raise ValueError(f"{path} names {len(lines)} files: at most {MOST_FILES} are read.")
    out: dict[Pair, Curve] = {}
    for number, line in lines:
        cells = re.split(r"\s*[;,\t]\s*", line.strip())
        if len(cells) != len(heading):
            raise ValueError(f"{path}, line {number}: {len(cells)} cells where there should be {len(heading)}.")
        row = dict(zip(heading, cells, strict=True))
        try:
            pair = _canonical(row["response"]), _canonical(row["force"])
        except ValueError as error:
            raise ValueError(f"{path}, line {number}: {error}") from None
        if pair in out:
            raise ValueError(f"{path}, line {number}: {pair[0]} from {pair[1]} was named before.")
        if not row["file"] or "\0" in row["file"]:
            raise ValueError(f"{path}, line {number}: no file is named.")
        out[pair] = _single(path.parent / row["file"], said)
    if not out:
        raise ValueError(f"{path} is an index without files.")
    return out
