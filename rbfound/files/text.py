"""FRFs in text files: the columns of one table of numbers, as its heading or the caller describes them."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rbfound.files.content import decoded, listed
from rbfound.frf import check_ascending
from rbfound.units import FREQUENCIES

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# A heading lies among the first lines.
PREAMBLE = 200
# Amplitude and phase must say the same as real and imaginary part, up to the rounding of an export with four digits.
AGREEMENT = 2e-3

COLUMNS = ("Frequency [Hz]", "Amplitude [m]", "Phase [deg]", "Real [m]", "Imaginary [m]")
HELP = "columns='frequency [Hz], amplitude [mm], phase [deg]'"

REAL = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eEdD][+-]?\d+)?"
NUMBER = re.compile(rf"{REAL}|[+-]?(?:nan|inf(?:inity)?)|\(?(?:{REAL})?{REAL}j\)?", re.IGNORECASE)
ROLES = {
    "frequency": r"freq\w*|f",
    "amplitude": r"ampl\w*|mag|magn\w*|abs\w*",
    "phase": r"(?:phase|angle|arg)(?:[ _]angle)?",
    "real": r"re(?:al)?(?:[ _]part)?",
    "imaginary": r"im(?:ag\w*)?(?:[ _]part)?",
    "coherence": r"coh\w*|gamma2?",
}
ROLE = re.compile(
    r"(?<![A-Za-z0-9])(?:" + "|".join(f"(?P<{role}>{words})" for role, words in ROLES.items()) + r")(?![A-Za-z0-9])",
    re.IGNORECASE,
)
UNIT = re.compile(r"\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\)")
# Re(H): what a part is taken of, no unit
OF = re.compile(r"\b(re|im|real|imag|abs|mag|phase|arg|angle)\w*\s*\(\s*(?:[HYZ]\d*|FRF|TF)\s*\)", re.IGNORECASE)
POINT = r"(?:[xyz]\d{1,6}|\d{1,6}:?[+-]?[xyz])"
PAIR = re.compile(
    rf"(?<![A-Za-z0-9])(?P<response>{POINT})\s*(?:_from_|\bfrom\b|[:/]|<-)\s*(?P<force>{POINT})(?![A-Za-z0-9])",
    re.IGNORECASE,
)


@dataclass(frozen=True, eq=False)
class Curve:
    """One FRF as a file holds it, whatever the format.

    Attributes
    ----------
    source : the file, and which part of it
    frequency, values : (n,) [Hz], (n,) complex in `unit`
    unit : None where the file does not say it
    quantity : what is measured, where a file says that apart from the unit
    lines : the line of each row in a text
    coherence : (n,), where the file holds it
    ignored : what the file holds besides
    """

    source: str
    frequency: Array
    values: Complex
    unit: str | None = None
    quantity: str | None = None
    lines: list[int] = field(default_factory=list)
    coherence: Array | None = None
    ignored: tuple[str, ...] = ()


@dataclass(frozen=True)
class Column:
    """What is said of a column: its role, its unit, and the points (response, force) where it names them."""

    text: str
    role: str | None
    unit: str | None
    pair: tuple[str, str] | None


@dataclass(frozen=True, eq=False)
class Table:
    """The numbers of a text file (rows, columns), the line that each row stands on, and the heading, split."""

    path: Path
    heading: list[str]
    values: NDArray[np.generic]
    lines: list[int]


def table_of(path: Path) -> Table:
    """Heading and numbers of a text file.

    Cells are separated by tabs, else by semicolons, else by blanks or commas; a comma inside a number is then the
    decimal sign. Lines above the heading, a row of units below it, and its repetitions (pages) hold no numbers.
    """
    lines = [(k, line.strip()) for k, line in enumerate(re.split(r"\r\n|\r|\n", decoded(path)), 1) if line.strip()]
    separator = _separator([line for _, line in lines])
    named = [k for k, (_, line) in enumerate(lines[:PREAMBLE]) if _words(line) > 1]
    first, head = len(lines), None
    # the first line of words with numbers on one of the next ones, or else the first row of numbers
    for head in [*named, None]:
        start = -1 if head is None else head
        end = len(lines) if head is None else min(head + 4, len(lines))
        first = next((k for k in range(start + 1, end) if _is_row(lines[k][1], separator)), len(lines))
        if first < len(lines):
            break
    if first == len(lines):
        raise ValueError(f"{path}: no row of numbers, only text.")
    width = len(_split(lines[first][1], separator))
    above = lines[:first] if head is None else lines[head + 1 : first]
    for number, line in above:
        cells = _split(line, separator)
        if NUMBER.fullmatch(cells[0]) and (head is not None or len(cells) == width):
            raise ValueError(f"{path}, line {number}: {line[:60]!r} is not a row of numbers.")
    heading = [] if head is None else _cells(lines[head][1].lstrip("#%! "), separator, width)
    units = _cells(above[-1][1].lstrip("#%! "), separator, 0) if head is not None and above else []
    if len(units) == len(heading) and not any(UNIT.search(cell) for cell in heading):
        heading = [f"{cell} [{unit.strip('[]() ')}]" for cell, unit in zip(heading, units, strict=True)]
    repeated = {line for _, line in lines[head:first]} if head is not None else set()
    body = [(number, line) for number, line in lines[first:] if line not in repeated]
    return Table(path, heading, _numbers(path, body, separator, width), [number for number, _ in body])


def _words(line: str) -> int:
    """How many columns a line names, two at the most."""
    found = sum(1 for _, _ in zip(range(2), ROLE.finditer(line), strict=False))
    return found if found > 1 else found + sum(1 for _, _ in zip(range(2), PAIR.finditer(line), strict=False))


def _is_row(line: str, separator: str | None) -> bool:
    cells = _split(line, separator)
    return len(cells) > 1 and all(NUMBER.fullmatch(cell) for cell in cells)


def _numbers(path: Path, body: list[tuple[int, str]], separator: str | None, width: int) -> NDArray[np.generic]:
    """(rows, columns) of numbers; what numpy cannot read is looked for, and named with its line."""
    text = "\n".join(line.rstrip(separator) if separator else line for _, line in body)
    if separator != "," and "," in text:
        if "." in text:
            comma = "," in text[: text.index(".")]
            number, line = next((n, line) for n, line in body if ("." if comma else ",") in line)
            raise ValueError(
                f"{path}, line {number}: a decimal comma and a decimal point stand in one file ({line[:60]!r}): "
                "write all numbers in one way."
            )
        text = text.replace(",", ".")
    kind = complex if "j" in text else float
    text = re.sub("[dD]", "e", text)
    try:
        return np.loadtxt(text.split("\n"), dtype=kind, comments=None, delimiter=separator, ndmin=2)
    except ValueError as error:
        for number, line in body:
            cells = _split(line, separator)
            if not all(NUMBER.fullmatch(cell) for cell in cells):
                raise ValueError(f"{path}, line {number}: {line[:60]!r} is not a row of numbers.") from None
            if len(cells) != width:
                raise ValueError(
                    f"{path}, line {number}: {len(cells)} columns where there should be {width}."
                ) from None
        raise ValueError(f"{path}: {error}") from None


def _split(line: str, separator: str | None) -> list[str]:
    cells = [cell.strip() for cell in line.split(separator)]
    # a separator at the end of a line makes no column
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def _cells(line: str, separator: str | None, width: int) -> list[str]:
    """The cells of a heading: as the rows are split, or word by word where blanks separate them."""
    cells = [cell.strip('"') for cell in _split(line, separator)]
    words = [*ROLE.finditer(line)]
    if len(cells) == width or not words or not width:
        return cells
    ends = [*(word.start() for word in words[1:]), len(line)]
    return [line[word.start() : end].strip() for word, end in zip(words, ends, strict=True)]


def _separator(lines: list[str]) -> str | None:
    """What separates the cells: a tab, a semicolon, a comma, or blanks (None)."""
    numeric = [line for line in lines if re.match(r"[+-]?[.,]?\d", line)] or lines
    for separator in "\t;":
        if any(separator in line for line in numeric):
            return separator
    # "0,5 1,2": decimal commas between blanks; "0.5, 1.2" or "0.5,1.2": commas between the cells
    cells = numeric[-1].split() if numeric else []
    blanks = len(cells) > 1 and all(NUMBER.fullmatch(cell) for cell in cells)
    return None if blanks or not any("," in line for line in numeric) else ","


def described(cell: str) -> Column:
    """What the text above a column says of it."""
    plain = OF.sub(r"\1", cell)
    pair = PAIR.search(plain)
    plain = PAIR.sub(" ", plain)
    unit, role = UNIT.search(plain), ROLE.search(UNIT.sub(" ", plain))
    return Column(
        cell.strip(),
        role.lastgroup if role else None,
        (unit[1] or unit[2] or "").strip() or None if unit else None,
        (pair["response"].lower(), pair["force"].lower()) if pair else None,
    )


def _columns(table: Table, columns: str | None) -> list[Column]:
    """What each column is, by the heading and by the caller, who must agree."""
    width = table.values.shape[1]
    found = [described(cell) for cell in table.heading]
    said = [described(cell) for cell in columns.split(",")] if columns is not None else found
    if not said:
        raise ValueError(
            f"{table.path}: no heading says what its {width} columns are and in which unit. Say it with {HELP}."
        )
    if len(said) != width:
        raise ValueError(
            f"{table.path}, line {table.lines[0]}: {width} columns where there should be {len(said)}: "
            f"{listed(column.text for column in said)}."
        )
    if columns is None or len(found) != width:
        return said
    both = []
    for heading, told in zip(found, said, strict=True):
        for here, there in ((heading.role, told.role), (heading.unit, told.unit), (heading.pair, told.pair)):
            if here and there and told.role and here != there:
                raise ValueError(
                    f"{table.path}: its heading says {heading.text!r}, columns= says {told.text!r}: only one can be "
                    "right. Where the heading is wrong, mend it."
                )
        both.append(Column(told.text, told.role, told.unit or heading.unit, told.pair or heading.pair))
    return both


def curves_of(path: Path, columns: str | None = None, unit: str | None = None) -> dict[tuple[str, str] | None, Curve]:
    """All FRFs of a text file by their points; the key of a single one that its heading does not name is None.

    Parameters
    ----------
    columns : str
        What the columns are, with commas between them, where no heading says it: "frequency [Hz], real [mm],
        imaginary [mm]"; names that are no roles stand for columns to skip.
    unit : str
        What the caller says of the responses: it counts here where it says that amplitudes are in decibels.
    """
    table = table_of(path)
    said = _columns(table, columns)
    if not any(column.role for column in said):
        raise ValueError(f"{path}: no column is named. Say what they are: {HELP}.")
    frequency = _frequency(table, said)
    ignored = tuple(column.text for column in said if column.role is None and column.pair is None)
    out: dict[tuple[str, str] | None, Curve] = {}
    for pair in dict.fromkeys(column.pair for column in said if column.role != "frequency"):
        if pair is None and all(column.role is None for column in said if column.pair is None):
            continue
        of_pair = [(k, column) for k, column in enumerate(said) if column.pair == pair]
        values, found = _values(table, of_pair, unit, frequency[0] == 0)
        coherence = _column(table, of_pair, "coherence")
        out[pair] = Curve(
            str(path), frequency, values, found, None, table.lines,
            None if coherence is None else coherence[0].real.astype(float), ignored,
        )  # fmt: skip
    if not out:
        raise ValueError(
            f"{path}: its columns {listed(c.text for c in said)} hold no response. Say what they are: {HELP}."
        )
    return out


def _column(
    table: Table, columns: list[tuple[int, Column]], role: str | None, static: bool = False
) -> tuple[NDArray[np.generic], Column] | None:
    """The numbers of the column with a role, which must be finite, but for the first line when it is at 0 Hz."""
    places = [(k, column) for k, column in columns if column.role == role]
    if len(places) > 1:
        raise ValueError(f"{table.path}: columns {places[0][0] + 1} and {places[1][0] + 1} both hold the {role}.")
    if not places:
        return None
    k, column = places[0]
    values = table.values[:, k]
    bad = np.flatnonzero(~np.isfinite(values))
    bad = bad[bad > 0] if static else bad
    if len(bad):
        name = (role or "value").capitalize() + (f" [{column.unit}]" if column.unit else "")
        raise ValueError(
            f"{table.path}, line {table.lines[bad[0]]}: {name} is {values[bad[0]]}: every number must be finite."
        )
    return values, column


def _frequency(table: Table, said: list[Column]) -> Array:
    found = _column(table, [*enumerate(said)], "frequency")
    if found is None:
        raise ValueError(f"{table.path}: no column is the frequency. Say what the columns are: {HELP}.")
    f, unit = found[0].real.astype(float), found[1].unit or ""
    if unit.lower() not in FREQUENCIES:
        raise ValueError(f"{table.path}: the frequency is in {unit!r}: it must be Hz, kHz, rad/s or rpm.")
    try:
        check_ascending(f)
    except ValueError as error:
        falls = np.flatnonzero((np.diff(f, prepend=-1.0) <= 0) | (f < 0))
        raise ValueError(f"{table.path}, line {table.lines[falls[0]]}: {error}") from None
    return f * FREQUENCIES[unit.lower()]


def _values(
    table: Table, columns: list[tuple[int, Column]], unit: str | None, static: bool
) -> tuple[Complex, str | None]:
    """Complex values of one FRF and their unit: complex numbers, real and imaginary part, or amplitude and phase."""
    path = table.path
    whole = _column(table, columns, None, static) if np.iscomplexobj(table.values) else None
    real, imaginary, amplitude, phase = (
        _column(table, columns, role, static) for role in ("real", "imaginary", "amplitude", "phase")
    )
    pair = columns[0][1].pair
    name = f" of {pair[0]} from {pair[1]}" if pair else ""
    if whole is None and None in (real, imaginary) and None in (amplitude, phase):
        raise ValueError(
            f"{path}: the columns{name} are neither real and imaginary part nor amplitude and phase. Say them: {HELP}."
        )
    if whole is not None:
        return whole[0].astype(complex), whole[1].unit
    units = list(dict.fromkeys(column[1].unit for column in (real, imaginary, amplitude) if column is not None))
    parts = None if real is None or imaginary is None else real[0].real + 1j * imaginary[0].real
    if parts is not None and len(units) > 1 and units[-1] is not None and units[-1].lower().startswith("db"):
        # decibels beside the parts say nothing more
        return parts, units[0]
    if len(units) > 1:
        raise ValueError(f"{path}: the columns{name} are in different units: {units[0]} and {units[1]}.")
    decibels = ((units[0] if units[0] is not None else unit) or "").lower().startswith("db")
    if parts is not None and decibels:
        raise ValueError(f"{path}: real and imaginary part{name} cannot be in decibels.")
    if amplitude is None or phase is None:
        assert parts is not None
        return parts, units[0]
    size = amplitude[0].real.astype(float)
    low = np.flatnonzero(size < 0)
    if decibels:
        size = 10 ** (size / 20)
    elif len(low):
        raise ValueError(
            f"{path}, line {table.lines[low[0]]}: the amplitude is {size[low[0]]:g}: it must not be negative. Are "
            "these decibels? Say of what: unit='dB re 1 m/N'."
        )
    polar = size * np.exp(1j * _turned(table, phase[1].unit, phase[0].real.astype(float)))
    if parts is None:
        return polar, units[0]
    apart = np.abs(polar - parts) > AGREEMENT * np.maximum(np.abs(polar), np.abs(parts))
    if apart.any():
        k = int(np.flatnonzero(apart)[0])
        raise ValueError(
            f"{path}, line {table.lines[k]}: amplitude {abs(polar[k]):.4g} at phase "
            f"{np.degrees(np.angle(polar[k])):.4g} deg{name} is {polar[k]:.4g}, but "
            f"real and imaginary part say {parts[k]:.4g}. The columns must be {', '.join(COLUMNS)}."
        )
    return parts, units[0]


def _turned(table: Table, unit: str | None, phase: Array) -> Array:
    """A phase in radians; it must say that it is in degrees or in radians."""
    said = (unit or "").lower().strip(". ")
    if said in ("deg", "degree", "degrees", "°", "º", "grad °"):
        return np.asarray(np.radians(phase))
    if said in ("rad", "radians"):
        return phase
    raise ValueError(
        f"{table.path}: the phase is in {unit!r}: its heading must say deg or rad. Say what the columns are: {HELP}."
    )
