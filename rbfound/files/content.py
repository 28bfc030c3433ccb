"""What a file holds, as bytes or as text, and numbers of it that overflow; and lists of words for messages."""

import contextlib
import re
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

# A set of 64 FRFs with 50 000 lines in one file of text is smaller than this [bytes].
LARGEST = 300_000_000


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
    if content[:4] in (b"PK\x03\x04", b"\xd0\xcf\x11\xe0"):
        raise ValueError(f"{path} is a workbook of Excel, or an archive: save the sheet as text (.csv).")
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
