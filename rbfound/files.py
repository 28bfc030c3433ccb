"""Load and save FRFs and foundations. No arithmetic beyond what a file's columns ask for.

A set of FRFs is a folder of text files, one for each pair of seats, named and numbered after table 2:
frf01_x1_from_y1.txt is FRF 1, the response at x1 to a force at y1. Each has five columns, as a harmonic analysis
exports them: frequency [Hz], amplitude [m], phase [deg], real part [m], imaginary part [m], for a force of 1 N.
"""

import os
import re
import tempfile
import zipfile
import zlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rbfound.foundation import Foundation
from rbfound.frf import FRF, check_ascending

Array = NDArray[np.float64]

NAME = re.compile(r"(?P<response>[xy]\d+)_from_(?P<force>[xy]\d+)\.txt$", re.IGNORECASE)
SEAT = re.compile(r"[xy](0|[1-9]\d*)")
COLUMNS = ("Frequency [Hz]", "Amplitude [m]", "Phase [deg]", "Real [m]", "Imaginary [m]")
# Amplitude and phase must say the same as real and imaginary part, up to the rounding of an export with four digits.
AGREEMENT = 2e-3


def load_frf(folder: str | os.PathLike[str]) -> FRF:
    """FRFs from a folder with one text file for each pair of seats: sixteen for two bearings.

    Nothing is guessed: units are those of the columns [m] for a force of 1 N, missing files are not filled in.

    Raises
    ------
    ValueError
        For a missing or doubled file, a text without numbers, a number of columns other than five, a line that is
        not a number or not finite, frequencies that do not ascend or differ from file to file, amplitude and phase
        that contradict real and imaginary part. It names the file and the line.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise ValueError(f"{folder} is not a folder: give the folder that holds the text files of the FRFs.")
    paths = _paths(folder)
    labels = _labels(folder, paths)
    first = paths[labels[0], labels[0]]
    frequency, lines, _ = _read(first)
    H = np.empty((len(frequency), len(labels), len(labels)), dtype=complex)
    for i, response in enumerate(labels):
        for j, force in enumerate(labels):
            path = paths[response, force]
            grid, numbers, H_ij = _read(path)
            _same_grid(first, frequency, lines, path, grid, numbers)
            H[:, i, j] = H_ij
    return FRF(frequency, H, labels)


def save_frf(frf: FRF, folder: str | os.PathLike[str]) -> None:
    """Write the FRFs as a folder of text files that `load_frf` reads, numbered after table 2.

    The sets follow the forces y1, x1, y2, x2, the responses in each set x1, y1, x2, y2. Every file is written under
    another name first and renamed when all are complete.
    """
    folder = Path(folder)
    if frf.labels != _seats(frf.labels):
        raise ValueError(
            f"The seats are {', '.join(frf.labels)}: file names can tell them only as x and y of each bearing, "
            "x1, y1, x2, y2, ..."
        )
    folder.mkdir(parents=True, exist_ok=True)
    forces = [label for pair in zip(frf.labels[1::2], frf.labels[0::2], strict=True) for label in pair]
    texts: dict[str, str] = {}
    for force in forces:
        for response in frf.labels:
            H = frf.H[:, frf.seat(response), frf.seat(force)]
            name = f"frf{len(texts) + 1:02d}_{response}_from_{force}.txt"
            columns = (np.abs(H), np.degrees(np.angle(H)), H.real, H.imag)
            rows = [
                f"{f:.10g}\t" + "\t".join(f"{value:.8e}" for value in values)
                for f, *values in zip(frf.frequency, *columns, strict=True)
            ]
            texts[name] = "\n".join(["\t".join(COLUMNS), *rows, ""])
    with tempfile.TemporaryDirectory(dir=folder) as aside:
        for name, text in texts.items():
            (Path(aside) / name).write_text(text, encoding="utf-8", newline="\n")
        for name in texts:
            os.replace(Path(aside) / name, folder / name)


def load_foundation(path: str | os.PathLike[str]) -> Foundation:
    """A foundation from the .npz file that `save_foundation` wrote; nothing in it is unpickled."""
    if not Path(path).is_file():
        raise ValueError(f"{path} is not a file: give the .npz file that holds the foundation.")
    try:
        with open(path, "rb") as file:
            stored = np.load(file, allow_pickle=False)
            if not isinstance(stored, np.lib.npyio.NpzFile):
                raise ValueError("it holds a single array")
            M, C, K, B, labels, notes = (stored[key] for key in ("M", "C", "K", "B", "labels", "notes"))
        if labels.ndim != 1 or notes.ndim != 1:
            raise ValueError(f"labels has shape {labels.shape}, notes {notes.shape}: both must be rows of texts")
        return Foundation(M, C, K, B, tuple(map(str, labels)), tuple(map(str, notes)))
    except KeyError as error:
        raise ValueError(f"{path} holds no foundation: {error.args[0]}") from None
    except (ValueError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"{path} is not a readable .npz file of a foundation: {error}") from None


def save_foundation(foundation: Foundation, path: str | os.PathLike[str]) -> None:
    """Write a foundation as .npz; an older file of that name stays whole until the new one is complete."""
    path = Path(path)
    if path.suffix != ".npz":
        raise ValueError(f"{path} does not end in .npz.")
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as aside:
        whole = Path(aside) / path.name
        np.savez(
            whole,
            M=foundation.M,
            C=foundation.C,
            K=foundation.K,
            B=foundation.B,
            labels=np.array(foundation.labels, dtype=str),
            notes=np.array(foundation.notes, dtype=str),
        )
        os.replace(whole, path)


def foundation_bytes(foundation: Foundation) -> bytes:
    """The .npz file that `save_foundation` writes."""
    with tempfile.TemporaryDirectory() as aside:
        path = Path(aside) / "foundation.npz"
        save_foundation(foundation, path)
        return path.read_bytes()


def foundation_text(foundation: Foundation) -> str:
    """M, C, K and B in full as plain text, behind what `print(foundation)` shows; # begins a remark."""
    lines = [f"# {line}".rstrip() for line in str(foundation).splitlines()]
    units = {"M": "kg", "C": "N s/m", "K": "N/m", "B": f"rows {', '.join(foundation.labels)}"}
    for name, unit in units.items():
        matrix = getattr(foundation, name)
        lines += ["", f"# {name} [{unit}], {len(matrix)} rows" if name != "B" else f"# B, {unit}"]
        lines += [" ".join(f"{value:.17g}" for value in row) for row in matrix]
    return "\n".join([*lines, ""])


def _paths(folder: Path) -> dict[tuple[str, str], Path]:
    """The file of each (response, force)."""
    found: dict[tuple[str, str], Path] = {}
    for path in sorted(folder.iterdir()):
        match = NAME.search(path.name)
        if match is None:
            continue
        pair = match["response"].lower(), match["force"].lower()
        if pair in found:
            raise ValueError(f"{found[pair].name} and {path.name} in {folder} both hold {pair[0]} from {pair[1]}.")
        found[pair] = path
    if not found:
        raise ValueError(f"{folder} holds no FRFs: expected text files with names like frf01_x1_from_y1.txt.")
    return found


def _labels(folder: Path, paths: dict[tuple[str, str], Path]) -> tuple[str, ...]:
    """The seats x1, y1, x2, y2, ...; a ValueError if a file of a pair of them is missing."""
    labels = _seats(label for pair in paths for label in pair)
    missing = [f"{i} from {j}" for j in labels for i in labels if (i, j) not in paths]
    if missing:
        others = [p.name for p in sorted(folder.iterdir()) if p.suffix.lower() == ".txt" and not NAME.search(p.name)]
        hint = f" Files whose names say no pair of seats: {', '.join(others)}." if others else ""
        raise ValueError(
            f"{folder} holds {len(paths)} of the {len(labels) ** 2} FRFs between {', '.join(labels)}. "
            f"Missing: {', '.join(missing)}.{hint}"
        )
    return labels


def _seats(labels: Iterable[str]) -> tuple[str, ...]:
    """x and y of every bearing that one of the labels names, in ascending order."""
    numbers = {int(label[1:]) for label in labels if SEAT.fullmatch(label)}
    return tuple(f"{axis}{number}" for number in sorted(numbers) for axis in "xy")


def _read(path: Path) -> tuple[Array, list[int], NDArray[np.complex128]]:
    """Frequency (n,), the number of the line that each row stands on, and H (n,) of one file."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: byte {error.start} is not UTF-8 text.") from None
    rows: list[list[float]] = []
    numbers: list[int] = []
    for number, line in enumerate(text.splitlines(), start=1):
        cells = line.split()
        if not cells:
            continue
        if not rows and not _is_number(cells[0]):
            continue  # the heading
        try:
            row = [float(cell) for cell in cells]
        except ValueError:
            raise ValueError(f"{path}, line {number}: {line.strip()[:60]!r} is not a row of numbers.") from None
        if len(row) != len(COLUMNS):
            raise ValueError(
                f"{path}, line {number}: {len(row)} columns where there should be {len(COLUMNS)}: {', '.join(COLUMNS)}."
            )
        rows.append(row)
        numbers.append(number)
    if not rows:
        raise ValueError(f"{path}: no row of numbers, only text. Expected {', '.join(COLUMNS)}.")
    values = np.array(rows)
    _check_rows(path, values, numbers)
    return values[:, 0], numbers, values[:, 3] + 1j * values[:, 4]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _check_rows(path: Path, values: Array, numbers: list[int]) -> None:
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        row, column = bad[0]
        raise ValueError(
            f"{path}, line {numbers[row]}: {COLUMNS[column]} is {values[row, column]}: every number must be finite."
        )
    try:
        check_ascending(values[:, 0])
    except ValueError as error:
        falls = np.flatnonzero((np.diff(values[:, 0], prepend=-1.0) <= 0) | (values[:, 0] < 0))
        raise ValueError(f"{path}, line {numbers[falls[0]]}: {error}") from None
    amplitude, phase, real, imaginary = values[:, 1:].T
    polar = amplitude * np.exp(1j * np.radians(phase))
    apart = np.abs(polar - (real + 1j * imaginary)) > AGREEMENT * np.maximum(
        np.abs(amplitude), np.hypot(real, imaginary)
    )
    if apart.any():
        k = int(np.flatnonzero(apart)[0])
        raise ValueError(
            f"{path}, line {numbers[k]}: amplitude {amplitude[k]:.4g} at phase {phase[k]:.4g} deg is "
            f"{polar[k]:.4g}, but real and imaginary part say {real[k] + 1j * imaginary[k]:.4g}. "
            f"The columns must be {', '.join(COLUMNS)}."
        )


def _same_grid(first: Path, frequency: Array, lines: list[int], path: Path, grid: Array, numbers: list[int]) -> None:
    shared = min(len(frequency), len(grid))
    apart = np.flatnonzero(~np.isclose(grid[:shared], frequency[:shared], rtol=1e-9, atol=0))
    if len(apart):
        k = int(apart[0])
        raise ValueError(
            f"{path}, line {numbers[k]}: {grid[k]:g} Hz where {first.name}, line {lines[k]}, has {frequency[k]:g} Hz. "
            "All FRFs must share one grid of frequencies."
        )
    if len(grid) != len(frequency):
        raise ValueError(
            f"{path} has {len(grid)} frequencies, {first.name} has {len(frequency)}. "
            "All FRFs must share one grid of frequencies."
        )
