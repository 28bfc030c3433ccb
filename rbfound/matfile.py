"""Arrays of numbers and letters out of MATLAB's files of version 5 to 7.

A reader of its own for what FRFs and foundations need: that of scipy ends the whole program on some damaged files (it
reads where no memory is). Nothing is unpacked beyond a limit, and nothing in the file is run.
"""

import struct
import zlib
from collections.abc import Collection, Iterator
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

MATRIX, COMPRESSED = 14, 15
STORED = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
    17: "u2",
    18: "u4",
}
UTF8 = 16
LETTERS, NUMBERS = 4, range(6, 16)
KINDS = {1: "cell", 2: "struct", 3: "object", 5: "sparse matrix", 16: "function", 17: "object"}
COMPLEX, DIMENSIONS = 0x0800, 8


def arrays_in(content: bytes, names: Collection[str], largest: int) -> dict[str, NDArray[Any]]:
    """The named arrays of a file's content, each in its own shape; letters as a row of texts.

    Raises
    ------
    ValueError
        When it is no such file, is damaged, unpacks to more than `largest` bytes, or holds something else than an array
        of numbers or letters under one of the names.
    """
    if content[124:128] not in (b"\x00\x01IM", b"\x01\x00MI"):
        raise ValueError("it is not of version 5 to 7: save it with -v7")
    order = "<" if content[126:128] == b"IM" else ">"
    out: dict[str, NDArray[Any]] = {}
    for kind, data in _elements(content, 128, order):
        if kind == COMPRESSED:
            whole = _unpacked(data, largest)
            largest -= len(whole)
            # one array; its own size is no check, as Octave counts four bytes too many for some texts
            if len(whole) >= 8 and struct.unpack_from(order + "I", whole)[0] == MATRIX:
                _matrix(whole[8:], order, names, out)
        elif kind == MATRIX:
            _matrix(data, order, names, out)
    return out


def _elements(content: bytes, place: int, order: str) -> Iterator[tuple[int, bytes]]:
    """(type, data) of each element that stands in a row."""
    while place < len(content):
        if place + 8 > len(content):
            raise ValueError(f"it is cut off at byte {place}")
        kind, size = struct.unpack_from(order + "II", content, place)
        start = place + 8
        if kind >> 16:  # four bytes or fewer stand in the tag itself
            kind, size, start = kind & 0xFFFF, kind >> 16, place + 4
            if size > 4:
                raise ValueError(f"the element at byte {place} is damaged")
            place += 8
        else:
            # all but the compressed ones are filled up to eight bytes
            place = start + (size if kind == COMPRESSED else -(-size // 8) * 8)
        if start + size > len(content):
            raise ValueError(f"it is cut off at byte {len(content)}")
        yield kind, content[start : start + size]


def _unpacked(data: bytes, largest: int) -> bytes:
    unpacker = zlib.decompressobj()
    try:
        whole = unpacker.decompress(data, largest + 1)
    except zlib.error as error:
        raise ValueError(f"a compressed part is damaged ({error})") from None
    if len(whole) > largest:
        raise ValueError(f"it unpacks to more than {largest / 1e6:.0f} MB")
    if not unpacker.eof:
        raise ValueError("a compressed part is cut off")
    return whole


def _matrix(data: bytes, order: str, names: Collection[str], out: dict[str, NDArray[Any]]) -> None:
    """Put one array into `out` if it is wanted: its flags, shape, name, and one or two parts of values."""
    elements = _elements(data, 0, order)
    (_, flags), (_, shape_data), (_, name_data) = (_next(elements) for _ in range(3))
    name = name_data.decode("latin-1")
    if name not in names:
        return
    if len(flags) != 8 or not shape_data or len(shape_data) % 4 or len(shape_data) > 4 * DIMENSIONS:
        raise ValueError(f"{name} has a damaged heading")
    (flag,) = struct.unpack(order + "I", flags[:4])
    kind = flag & 0xFF
    shape = struct.unpack(f"{order}{len(shape_data) // 4}i", shape_data)
    if kind in NUMBERS:
        values = _values(name, *_next(elements), order, shape)
        if flag & COMPLEX:
            values = values + 1j * _values(name, *_next(elements), order, shape)
        out[name] = values.reshape(shape, order="F")
    elif kind == LETTERS:
        codes = _values(name, *_next(elements), order, shape)
        rows = codes.reshape(shape[0], -1, order="F") if len(codes) else np.zeros((0, 0), dtype="u4")
        if codes.dtype.kind not in "iu" or (rows.astype("i8") > 0x10FFFF).any() or (rows.astype("i8") < 0).any():
            raise ValueError(f"{name} holds what is no letter")
        out[name] = np.array(["".join(map(chr, row)) for row in rows], dtype=str)
    else:
        raise ValueError(
            f"{name} is a {KINDS.get(kind, 'thing unknown')}: only arrays of numbers or letters are read "
            "(labels: ['x1'; 'y1'])"
        )


def _next(elements: Iterator[tuple[int, bytes]]) -> tuple[int, bytes]:
    found = next(elements, None)
    if found is None:
        raise ValueError("an array ends before its values")
    return found


def _values(name: str, kind: int, data: bytes, order: str, shape: tuple[int, ...]) -> NDArray[Any]:
    """The values of one part, as many as the shape says."""
    if kind == UTF8:
        values = np.array([ord(letter) for letter in data.decode("utf-8", errors="replace")], dtype="u4")
    elif kind in STORED and len(data) % np.dtype(STORED[kind]).itemsize == 0:
        values = np.frombuffer(data, dtype=order + STORED[kind])
    else:
        raise ValueError(f"{name} holds values of a kind that is not known ({kind})")
    if min(shape) < 0 or prod(shape) != len(values):
        raise ValueError(f"{name} has {len(values)} values, which is not {' x '.join(map(str, shape))}")
    return values.astype(values.dtype.newbyteorder("="))
