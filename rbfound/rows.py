"""Rows of numbers out of a text file, whatever separates them: the one place that decodes bytes and splits lines.

Nothing is taken for something else in silence: an unknown encoding, a comma that may be either a decimal sign or a
separator, and a row that is not one of numbers are refused.
"""

import contextlib
import re
import stat
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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
