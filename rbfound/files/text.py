"""FRFs in text files: decoding, columns, headings and units of one table of numbers."""

import contextlib
import re
import stat
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rbfound.frf import check_ascending
from rbfound.units import hertz

Array = NDArray[np.float64]

# A set of 64 FRFs with 50 000 lines in one file of text is smaller than this [bytes].
LARGEST = 300_000_000


NUMBER = re.compile(r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eEdD][+-]?\d+)?|[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class Rows:
    """The numbers of a text file.

    Attributes
    ----------
    heading : the last line of text above the numbers that holds more than one cell, split like them; may be empty
    text : that line as it stands
    values : (rows, columns)
    numbers : the line that each row stands on, counted from 1
    """

    heading: tuple[str, ...]
    text: str
    values: NDArray[np.float64]
    numbers: list[int]


def listed(words: Iterable[str], most: int = 20) -> str:
    """Words with commas between them, for a message: the first ones and how many there are, if there are many."""
    words = [word[:60] for word in words]
    more = f", ... ({len(words)} in all)" if len(words) > most else ""
    return ", ".join(words[:most]) + more


@contextlib.contextmanager
def reckoning(path: Path) -> Iterator[None]:
    """Around all that is done with a file's numbers: where they overflow it is a ValueError, not numpy's warning."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except (FloatingPointError, OverflowError) as error:
        raise ValueError(f"{path} holds numbers too large or too small to reckon with ({error}).") from None


def content_of(path: Path) -> bytes:
    """The bytes of a file; a ValueError when it is none, cannot be read, or is too large to be a set of FRFs."""
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            # a device or a pipe may never end
            raise ValueError(f"{path} is not a file.")
        if found.st_size > LARGEST:
            raise ValueError(f"{path} has {found.st_size / 1e6:.0f} MB: at most {LARGEST / 1e6:.0f} MB are read.")
        return path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}.") from None


def decoded(path: Path) -> str:
    """The text of a file: UTF-8, UTF-16 with its mark, or Latin-1 where only printable letters of it occur.

    Degree and micro signs of older exports are one byte of Latin-1. In UTF-8 such a byte never stands alone, so a file
    that is not UTF-8 and holds none of the control codes 0x80-0x9f is read as Latin-1; anything else is refused.
    """
    content = content_of(path)
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        letters = encoding == "utf-8-sig" and not re.search(rb"[\x00-\x08\x0e-\x1f\x7f-\x9f]", content)
        if not letters:
            name = "UTF-16" if encoding == "utf-16" else "UTF-8"
            raise ValueError(f"{path}: byte {error.start} is not {name} text.") from None
        text = content.decode("latin-1")
    if "\0" in text:
        raise ValueError(f"{path}: character {text.index(chr(0))} is a zero: this is no text.")
    return text


def rows_of(path: Path, width: int | None = None) -> Rows:
    """Heading and numbers of a text file.

    Cells are separated by tabs, else by semicolons, else by blanks or commas; a comma inside a number is then the
    decimal sign. `width` is how many columns there should be; unless given, as many as the first row has.
    """
    lines = [(k, line.strip()) for k, line in enumerate(re.split(r"\r\n|\r|\n", decoded(path)), 1) if line.strip()]
    separator = _separator([line for _, line in lines])
    first = next((k for k, (_, line) in enumerate(lines) if _is_number(_split(line, separator)[0])), len(lines))
    headings = [line for _, line in lines[:first] if len(_split(line, separator)) > 1]
    text = headings[-1].lstrip("#%! ") if headings else ""
    if first == len(lines):
        raise ValueError(f"{path}: no row of numbers, only text.")
    rows: list[list[float]] = []
    marks: set[str] = set()
    signs = "." if separator == "," else ",."
    for number, line in lines[first:]:
        cells = _split(line, separator)
        if not all(NUMBER.fullmatch(cell) for cell in cells):
            raise ValueError(f"{path}, line {number}: {line[:60]!r} is not a row of numbers.")
        marks.update(mark for mark in signs if mark in line)
        if len(marks) > 1:
            raise ValueError(
                f"{path}, line {number}: a decimal comma and a decimal point stand in one file ({line[:60]!r}): "
                "write all numbers in one way."
            )
        rows.append([float(cell.replace(",", ".").replace("d", "e").replace("D", "e")) for cell in cells])
        width = width or len(cells)
        if len(cells) != width:
            raise ValueError(f"{path}, line {number}: {len(cells)} columns where there should be {width}.")
    heading = tuple(cell.strip().strip('"') for cell in _split(text, separator)) if text else ()
    return Rows(heading, text, np.array(rows), [number for number, _ in lines[first:]])


def _split(line: str, separator: str | None) -> list[str]:
    cells = line.split() if separator is None else line.split(separator)
    cells = [cell.strip() for cell in cells]
    # a separator at the end of a line makes no column
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _separator(lines: list[str]) -> str | None:
    """What separates the cells: a tab, a semicolon, a comma, or blanks (None)."""
    numeric = [line for line in lines if re.match(r"[+-]?[.,]?\d", line)] or lines
    for separator in "\t;":
        if any(separator in line for line in numeric):
            return separator
    # "0,5 1,2": decimal commas between blanks; "0.5, 1.2" or "0.5,1.2": commas between the cells
    blanks = all(
        NUMBER.fullmatch(cell) for line in numeric[:1] for cell in line.split() if len(line.split()) > 1
    ) and all(len(line.split()) > 1 for line in numeric[:1])
    return None if blanks or not any("," in line for line in numeric) else ","


def _is_number(cell: str) -> bool:
    return NUMBER.fullmatch(cell) is not None


COLUMNS = ("Frequency [Hz]", "Amplitude [m]", "Phase [deg]", "Real [m]", "Imaginary [m]")


# Amplitude and phase must say the same as real and imaginary part, up to the rounding of an export with four digits.
AGREEMENT = 2e-3


ROLES = {
    "frequency": r"freq\w*|f",
    "amplitude": r"ampl\w*|magn\w*|abs\w*",
    "phase": r"phase(?:[ _]angle)?",
    "real": r"re(?:al)?(?:[ _]part)?",
    "imaginary": r"im(?:ag\w*)?(?:[ _]part)?",
}


ROLE = re.compile(
    r"(?<![A-Za-z0-9])(?:" + "|".join(f"(?P<{role}>{words})" for role, words in ROLES.items()) + r")(?![A-Za-z0-9])",
    re.IGNORECASE,
)


UNIT = re.compile(r"\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\))?[^()]*)\)")


PAIR = re.compile(r"(?P<response>[xy]\d{1,3})\s*(?:_from_|\bfrom\b|[:/]|<-)\s*(?P<force>[xy]\d{1,3})", re.IGNORECASE)


HELP = "columns='frequency [Hz], amplitude [mm], phase [deg]'"


@dataclass(frozen=True, eq=False)
class Curve:
    """One FRF as a file holds it: frequency (n,) [Hz], complex values (n,) in `unit` (None: not said).

    `source` names the file, `lines` the line of each row in it (empty where there are no lines of text), `quantity`
    what is measured where a file says that apart from the unit.
    """

    source: Path
    frequency: Array
    values: NDArray[np.complex128]
    unit: str | None
    lines: list[int]
    quantity: str | None = None


@dataclass(frozen=True)
class Column:
    """What a heading says of a column: its role, its unit, and the seats (response, force) where it names them."""

    role: str | None
    unit: str | None
    pair: tuple[str, str] | None


def curves_of(path: Path, columns: str | None = None) -> dict[tuple[str, str] | None, Curve]:
    """All FRFs of a text file by their seats; the key of a single one that its heading does not name is None.

    Parameters
    ----------
    columns : str
        What the columns are, with commas between them, in place of a heading: "frequency [Hz], real [mm],
        imaginary [mm]"; names that are no roles stand for columns to skip.
    """
    given = None if columns is None else columns.split(",")
    rows = rows_of(path, None if given is None else len(given))
    described = described_by(path, given if given is not None else _heading(path, rows), rows)
    if len({column.role for column in described} - {None}) == 0:
        raise ValueError(f"{path}: no column is named. Say what they are: {HELP}.")
    frequency = _frequency(path, rows, described)
    out: dict[tuple[str, str] | None, Curve] = {}
    for pair in dict.fromkeys(column.pair for column in described if column.role not in (None, "frequency")):
        values, unit = _values(path, rows, described, pair)
        out[pair] = Curve(path, frequency, values, unit, rows.numbers)
    if not out:
        raise ValueError(f"{path}: its columns {listed(rows.heading)} hold no response. Say what they are: {HELP}.")
    return out


def _heading(path: Path, rows: Rows) -> list[str]:
    """The cells of the heading: as the rows are split, or word by word where blanks separate them."""
    width = rows.values.shape[1]
    if len(rows.heading) == width and any(ROLE.search(cell) for cell in rows.heading):
        return list(rows.heading)
    words = [*ROLE.finditer(rows.text)]
    if not words:
        raise ValueError(f"{path}: no heading says what its {width} columns are and in which unit. Say it with {HELP}.")
    ends = [*(word.start() for word in words[1:]), len(rows.text)]
    return [rows.text[word.start() : end] for word, end in zip(words, ends, strict=True)]


def described_by(path: Path, cells: list[str], rows: Rows) -> list[Column]:
    """What each column is; a ValueError when there are more or fewer names than columns."""
    described = []
    for cell in cells:
        pair, unit, role = PAIR.search(cell), UNIT.search(cell), ROLE.search(PAIR.sub(" ", UNIT.sub(" ", cell)))
        described.append(
            Column(
                role.lastgroup if role else None,
                (unit[1] or unit[2] or "").strip() or None if unit else None,
                (pair["response"].lower(), pair["force"].lower()) if pair else None,
            )
        )
    if len(described) != rows.values.shape[1]:
        raise ValueError(
            f"{path}, line {rows.numbers[0]}: {rows.values.shape[1]} columns where there should be {len(described)}: "
            f"{listed(cell.strip() for cell in cells)}."
        )
    return described


def _column(path: Path, rows: Rows, described: list[Column], role: str, pair: tuple[str, str] | None) -> int | None:
    """Index of the column with a role, None if there is none; its numbers must be finite."""
    places = [k for k, column in enumerate(described) if column.role == role and column.pair == pair]
    if len(places) > 1:
        raise ValueError(f"{path}: columns {places[0] + 1} and {places[1] + 1} both hold the {role}.")
    if not places:
        return None
    bad = np.flatnonzero(~np.isfinite(rows.values[:, places[0]]))
    if len(bad):
        column = described[places[0]]
        name = role.capitalize() + (f" [{column.unit}]" if column.unit else "")
        raise ValueError(
            f"{path}, line {rows.numbers[bad[0]]}: {name} is {rows.values[bad[0], places[0]]}: "
            "every number must be finite."
        )
    return places[0]


def _frequency(path: Path, rows: Rows, described: list[Column]) -> Array:
    place = _column(path, rows, described, "frequency", None)
    if place is None:
        raise ValueError(f"{path}: no column is the frequency. Say what the columns are: {HELP}.")
    unit, f = described[place].unit, rows.values[:, place]
    scale = {None: 1.0, "hz": 1.0, "1/s": 1.0, "khz": 1e3, "rad/s": float(hertz(1.0))}.get(unit and unit.lower())
    if scale is None:
        raise ValueError(f"{path}: the frequency is in {unit!r}: it must be Hz, kHz or rad/s.")
    falls = np.flatnonzero((np.diff(f, prepend=-1.0) <= 0) | (f < 0))
    try:
        check_ascending(f)
    except ValueError as error:
        raise ValueError(f"{path}, line {rows.numbers[falls[0]]}: {error}") from None
    return f * scale


def _values(
    path: Path, rows: Rows, described: list[Column], pair: tuple[str, str] | None
) -> tuple[NDArray[np.complex128], str | None]:
    """Complex values of one FRF and their unit, from its real and imaginary part, or its amplitude and phase."""
    real, imaginary, amplitude, phase = (
        _column(path, rows, described, role, pair) for role in ("real", "imaginary", "amplitude", "phase")
    )
    name = f" of {pair[0]} from {pair[1]}" if pair else ""
    if None in (real, imaginary) and None in (amplitude, phase):
        raise ValueError(
            f"{path}: the columns{name} are neither real and imaginary part nor amplitude and phase. Say them: {HELP}."
        )
    used = [k for k in (real, imaginary, amplitude) if k is not None]
    units = list(dict.fromkeys(described[k].unit for k in used))
    if len(units) > 1:
        raise ValueError(f"{path}: the columns{name} are in different units: {units[0]} and {units[1]}.")
    polar = None
    if amplitude is not None and phase is not None:
        turn = _turned(path, rows, described[phase].unit, phase)
        low = np.flatnonzero(rows.values[:, amplitude] < 0)
        if len(low):
            raise ValueError(
                f"{path}, line {rows.numbers[low[0]]}: the amplitude is {rows.values[low[0], amplitude]:g}: "
                "it must not be negative (decibels are not read)."
            )
        polar = rows.values[:, amplitude] * np.exp(1j * turn)
    if real is None or imaginary is None:
        assert polar is not None
        return polar, units[0]
    values = rows.values[:, real] + 1j * rows.values[:, imaginary]
    if polar is not None:
        _agree(path, rows, polar, values, described, name)
    return values, units[0]


def _turned(path: Path, rows: Rows, unit: str | None, phase: int) -> Array:
    """A phase in radians; it must say that it is in degrees or in radians."""
    said = (unit or "").lower().strip(". ")
    if said in ("deg", "degree", "degrees", "°", "º", "grad °"):
        return np.asarray(np.radians(rows.values[:, phase]))
    if said in ("rad", "radians"):
        return rows.values[:, phase]
    raise ValueError(
        f"{path}: the phase is in {unit!r}: its heading must say deg or rad. Say what the columns are: {HELP}."
    )


def _agree(
    path: Path,
    rows: Rows,
    polar: NDArray[np.complex128],
    parts: NDArray[np.complex128],
    described: list[Column],
    name: str,
) -> None:
    apart = np.abs(polar - parts) > AGREEMENT * np.maximum(np.abs(polar), np.abs(parts))
    if apart.any():
        k = int(np.flatnonzero(apart)[0])
        amplitude, phase = abs(polar[k]), np.degrees(np.angle(polar[k]))
        raise ValueError(
            f"{path}, line {rows.numbers[k]}: amplitude {amplitude:.4g} at phase {phase:.4g} deg{name} is "
            f"{polar[k]:.4g}, but real and imaginary part say {parts[k]:.4g}. "
            f"The columns must be {', '.join(COLUMNS)}."
        )
