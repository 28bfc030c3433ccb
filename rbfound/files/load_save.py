"""The door for files: load and save FRFs and foundations, whatever their format.

A set of FRFs is a folder of text files, one for each pair of seats, named and numbered after table 2:
frf01_x1_from_y1.txt is FRF 1, the response at x1 to a force at y1. Each has five columns, as a harmonic analysis
exports them: frequency [Hz], amplitude [m], phase [deg], real part [m], imaginary part [m], for a force of 1 N.
What else is read: `load_frf`.
"""

import os
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import io as scipy_io
from scipy.ndimage import uniform_filter1d

from rbfound.files.arrays import curves_of_arrays, read_arrays, texts
from rbfound.files.content import content_of, decoded, listed, reckoning
from rbfound.files.exports import PARTS, aside, from_arrays, from_json, replaced, text_replaced, to_json, to_mat
from rbfound.files.frf_sets import (
    MIXED,
    OWN,
    Pair,
    Said,
    curves_of_file,
    curves_of_folder,
    gathered,
    plain,
    seated,
    seats_of,
)
from rbfound.files.text import COLUMNS, POINT, Curve
from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.tables import table
from rbfound.units import parsed_unit

UNIVERSAL = (".uff", ".unv", ".ufb", ".u58")
UNIVERSAL_START = re.compile(rb"\s*-1 *\r?\n\s*\d+")


def load_frf(
    path: str | os.PathLike[str],
    *,
    unit: str | None = None,
    quantity: str | None = None,
    force: float = 1.0,
    columns: str | None = None,
    pattern: str | None = None,
    fill: bool = False,
    seats: str | None = None,
    conjugate: bool = False,
    delay: float = 0.0,
) -> FRF:
    """FRFs from a folder with a text file for each pair of seats, an index of such files, or one file with all.

    A folder's files are named after their seats (`x1_from_y1.txt`); an index is a text with the heading
    `file, response, force`. One file is a table whose heading names the seats (`x1 from y1 real [m/N]`), a Universal
    File (dataset 58: .uff, .unv; needs `rbfound[uff]`), or .npz or .mat with the arrays frequency (n,),
    H (n, seats, seats), labels and unit. Text may have tabs, blanks, semicolons or commas between its cells, decimal
    commas, amplitude and phase, real and imaginary part, or both. Nothing is guessed: what no file says, say here.

    Parameters
    ----------
    unit : str
        Of the responses: "m", "mm", "m/s", "m/s2", "mm/s2", "g", ..., also for a unit force: "mm/N"; of amplitudes in
        decibels "dB re 1 m/N". It says the quantity too. A file's own unit and this one must agree.
    quantity : "receptance", "mobility" or "accelerance"
        Only a check of what the unit says. "stiffness", "impedance" or "apparent mass" (forces over motions, each seat
        driven with the others held): the matrix of each line is inverted.
    force : float [N]
        The force that the responses were computed or measured for, unless the unit is for a unit force.
    columns : str
        What the columns of the text files are, where no heading says it: "frequency [Hz], amplitude [mm], phase [deg]".
    pattern : str
        How the files of a folder are named: "H_{response}_{force}.csv", or "FRF{number}.txt", numbered after table 2.
    fill : bool
        Whether a missing H_ij may be taken from H_ji; `notes` of the result say which were.
    seats : str
        Which points and directions of the file are the seats: "12+Z = y1, 7-X = x1". FRFs at others are left out.
    conjugate : bool
        Whether the phases are those of a time factor exp(-i omega t), as some programs have them.
    delay : float [s]
        How much later than the force the motion was recorded; it is taken out.

    Raises
    ------
    ValueError
        For a missing or doubled file, a unit that is not said or contradicts, a number of columns that does not fit,
        a line that is not a number or not finite, frequencies that do not ascend or differ from file to file, amplitude
        and phase that contradict real and imaginary part, a damaged or too large file. It names the file and the line.
    """
    said = Said(unit, quantity, force, columns, pattern, fill, seats, conjugate, delay)
    return _loaded(Path(path), said)[0]


def load_errors(path: str | os.PathLike[str], averages: int, **said: Any) -> NDArray[np.float64]:
    """Standard deviation of the complex error of each FRF [m/N], (n, outputs, inputs), for `rbfound.fit_modes`.

    From the coherence that a file holds (columns, Universal Files of function type 6, an array `coherence`) and the
    number of averages: variance |H|^2 (1 - c) / (c (averages - 1)), see `rbfound.measurement.Spectra.errors`, taken as
    even over nine lines. A coherence is taken as 1 - 1e-6 at most, since files print some digits of it. The other
    arguments are those of `load_frf`, whose lines these are.

    Raises
    ------
    ValueError
        When the file holds no coherence for some of the FRFs, or one outside 0 to 1, and for what `load_frf` refuses.
    """
    frf, c = _loaded(Path(path), Said(**said))
    if c is None:
        raise ValueError(f"{path} does not hold the coherence of all of its FRFs.")
    if averages < 2 or not ((c > 0) & (c <= 1)).all():
        raise ValueError(
            f"{path}: coherences from {c.min():g} to {c.max():g} of {averages} averages tell no errors: they must lie "
            "between 0 and 1, and the averages be two or more."
        )
    # as of accelerations, whose errors are even
    square = np.maximum(frf.frequency, frf.frequency[-1] / 1e3)[:, None, None] ** 2
    rest = (square * np.abs(frf.H)) ** 2 * np.maximum(1 - c, 1e-6) / c
    return np.asarray(np.sqrt(uniform_filter1d(rest, 9, axis=0, mode="nearest") / (averages - 1)) / square)


def explained(path: str | os.PathLike[str], **said: Any) -> str:
    """What is understood of each FRF of a set, before they are put together: a table."""
    path, options = Path(path), Said(**said)
    with reckoning(path):
        curves = _curves(path, options)[0]
    rows: dict[str, list[object]] = {}
    for (response, force), curve in curves.items():
        units = [word for word in (curve.unit, options.unit) if word is not None]
        quantity = parsed_unit(units[-1]).quantity if units and units[-1].lower() != "db" else curve.quantity
        row = {
            "file": Path(curve.source).name,
            "response": response,
            "force": force,
            "quantity": quantity or "not said",
            "unit": curve.unit or f"{options.unit or 'not said'} (by the caller)",
            "time factor": "exp(-i w t)" if options.conjugate else "exp(i w t)",
            "first [Hz]": float(curve.frequency[0]),
            "last [Hz]": float(curve.frequency[-1]),
            "lines": len(curve.frequency),
            "besides": ", ".join((*curve.ignored, *(["coherence"] if curve.coherence is not None else []))) or "-",
        }
        for name, value in row.items():
            rows.setdefault(name, []).append(value)
    return table(rows)


def _loaded(path: Path, said: Said) -> tuple[FRF, NDArray[np.float64] | None]:
    with reckoning(path):
        curves, labels, hint, notes = _curves(path, said)
        frf, coherence = gathered(curves, str(path), said, labels, hint)
        return FRF(frf.frequency, frf.H, frf.labels, (*notes, *frf.notes)), coherence


def _curves(path: Path, said: Said) -> tuple[dict[Pair, Curve], tuple[str, ...], str, tuple[str, ...]]:
    """The FRFs by their seats, the labels where the format has its own, a hint and notes."""
    kind = path.suffix.lower()
    text = path.is_dir() or kind not in (".npz", ".mat", *UNIVERSAL)
    if not path.is_dir() and not path.is_file():
        raise ValueError(f"{path} is not a folder nor a file: give the folder or the file that holds the FRFs.")
    if text and path.is_file() and UNIVERSAL_START.match(content_of(path)[:400]):
        text, kind = False, UNIVERSAL[0]
    for name, given, there in (
        ("columns", said.columns is not None, text),
        ("pattern", said.pattern is not None, path.is_dir()),
        ("fill", said.fill, kind not in (".npz", ".mat")),
    ):
        if given and not there:
            raise ValueError(f"{path}: {name}= means nothing for such a file: leave it out.")
    labels: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    hint = ""
    if path.is_dir():
        curves, hint = curves_of_folder(path, said)
    elif kind in (".npz", ".mat"):
        curves, labels, notes = curves_of_arrays(path)
        if said.seats is None and not all(re.fullmatch(POINT, label, re.IGNORECASE) for label in labels):
            # words of their own choice
            return curves, labels, hint, notes
        labels = () if said.seats is not None else tuple(plain(label) for label in labels)
    elif text:
        curves = curves_of_file(path, said)
    else:
        curves, notes = _universal(path, said.seats is None)
    if not text and any((said.unit or curve.unit or "").lower().startswith("db") for curve in curves.values()):
        raise ValueError(f"{path}: decibels have lost their phase: only amplitudes of a text may be such.")
    curves, more = seated(curves, str(path), said.seats)
    return curves, labels, hint, (*notes, *more)


def _universal(path: Path, renumbered: bool) -> tuple[dict[Pair, Curve], tuple[str, ...]]:
    try:
        # the one import that waits: pyuff is an extra, and only such a file needs it
        from rbfound.files.uff import curves_in
    except ImportError as error:
        raise ValueError(f"{path}: Universal Files need pyuff: pip install 'rbfound[uff]' ({error}).") from None
    return curves_in(path, renumbered)


def save_frf(frf: FRF, folder: str | os.PathLike[str]) -> None:
    """Write the FRFs as a folder of text files that `load_frf` reads, numbered after table 2; or as .npz or .mat.

    The sets follow the forces y1, x1, y2, x2, the responses in each set x1, y1, x2, y2. Every file is written aside
    and renamed when all are complete; a folder in which that was interrupted is refused until it is saved again.
    """
    folder = Path(folder)
    if folder.suffix in (".npz", ".mat"):
        _save_arrays(frf, folder)
        return
    if frf.labels != seats_of(frf.labels):
        raise ValueError(
            f"The seats are {', '.join(frf.labels)}: file names can tell them only as x and y of each bearing, "
            "x1, y1, x2, y2, ..."
        )
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
    with aside(folder) as new:
        for name, text in texts.items():
            (new / name).write_text(text, encoding="utf-8", newline="\n")
        # between two of these the folder holds files of two sets: `load_frf` refuses it until the last one is there
        (folder / MIXED).touch()
        for name in texts:
            os.replace(new / name, folder / name)
        for path in folder.iterdir():
            # of a set that was saved here before
            if OWN.fullmatch(path.name) and path.name not in texts:
                path.unlink()
        (folder / MIXED).unlink()


def _save_arrays(frf: FRF, path: Path) -> None:
    words: dict[str, Any] = {
        "labels": np.array(frf.labels),
        "unit": np.array(["m/N"]),
        "notes": np.array(frf.notes, dtype=str),
    }
    if path.suffix == ".npz":
        replaced(path, lambda whole: np.savez(whole, frequency=frf.frequency, H=frf.H, **words))
    else:
        words["notes"] = np.array(frf.notes or ("",))
        replaced(path, lambda whole: scipy_io.savemat(whole, {"frequency": frf.frequency, "H": frf.H, **words}))


def load_foundation(path: str | os.PathLike[str]) -> Foundation:
    """A foundation from the .npz, .json or .mat file that `save_foundation` wrote; nothing in it is unpickled.

    Raises
    ------
    ValueError
        When it is no such file, is damaged, or holds what is no foundation. It names the file.
    """
    path = Path(path)
    with reckoning(path):
        if not path.is_file():
            raise ValueError(f"{path} is not a file: give the .npz, .json or .mat file that holds the foundation.")
        if path.suffix == ".json":
            text = decoded(path)
            try:
                return from_json(text)
            except ValueError as error:
                raise ValueError(f"{path} is not a readable .json file of a foundation: {error}") from None
        arrays, there = read_arrays(path, PARTS)
        missing = [name for name in PARTS if name not in arrays]
        if missing:
            raise ValueError(
                f"{path} holds no foundation: {', '.join(missing)} is missing. It holds {listed(there) or 'nothing'}."
            )
        try:
            if path.suffix == ".mat":
                words = {
                    name: np.array([t for t in texts(arrays[name]) if t], dtype=str) for name in ("labels", "notes")
                }
                arrays |= words
            return from_arrays(arrays)
        except ValueError as error:
            raise ValueError(f"{path} is not a readable {path.suffix} file of a foundation: {error}") from None


def save_foundation(foundation: Foundation, path: str | os.PathLike[str]) -> None:
    """Write a foundation as .npz, .json or .mat; an older file stays whole until the new one is complete.

    All three come back exactly, but for blanks at the ends of notes in .mat. For ANSYS, NASTRAN and ROSS see
    `rbfound.files.exports` and `rbfound.files.ross_bearing`.
    """
    path = Path(path)
    if path.suffix == ".npz":
        words: dict[str, Any] = {name: np.array(getattr(foundation, name), dtype=str) for name in ("labels", "notes")}
        matrices: dict[str, Any] = {name: getattr(foundation, name) for name in "MCKB"}
        replaced(path, lambda whole: np.savez(whole, **matrices, **words))
    elif path.suffix == ".json":
        text_replaced(path, to_json(foundation))
    elif path.suffix == ".mat":
        replaced(path, lambda whole: scipy_io.savemat(whole, to_mat(foundation)))
    else:
        raise ValueError(f"{path} does not end in .npz, .json or .mat.")


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
