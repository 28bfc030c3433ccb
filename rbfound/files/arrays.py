"""Arrays by name out of .npz and MATLAB .mat files, with their sizes checked before anything is unpacked."""

import io
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from rbfound.files.text import content_of

Array = NDArray[np.float64]

Complex = NDArray[np.complex128]

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


# 64 FRFs on 500 000 lines [bytes]
LARGEST_UNPACKED = 600_000_000


# What numpy's own reader lets through when the heading of an array is damaged; it warns where the heading is one that
# Python 2 may have written, and Python itself where it looks like a slip.
HEADING: tuple[type[Exception], ...] = (SyntaxError, TypeError, KeyError, IndexError, OverflowError, struct.error)


HEADING += (MemoryError, RecursionError, tokenize.TokenError, Warning)


def read_npz(path: Path, names: Iterable[str]) -> dict[str, NDArray[Any]]:
    """Those of the named arrays that a .npz file holds.

    Raises
    ------
    ValueError
        When it is no such file, is damaged, holds a pickled object, or would unpack to more than 600 MB.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content_of(path))) as archive:
            members = {name: f"{name}.npy" for name in names if f"{name}.npy" in archive.namelist()}
            total = sum(archive.getinfo(member).file_size for member in members.values())
            if total > LARGEST_UNPACKED:
                raise ValueError(f"it unpacks to {total / 1e6:.0f} MB: at most {LARGEST_UNPACKED / 1e6:.0f} are read")
            return {name: _array(archive, member) for name, member in members.items()}
    except (ValueError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, OSError) as error:
        raise ValueError(f"{path} is not a readable .npz file: {error}") from None
    except HEADING as error:
        raise ValueError(f"{path} is not a readable .npz file: an array's heading is damaged ({error})") from None


def _array(archive: zipfile.ZipFile, member: str) -> NDArray[Any]:
    """One array; the size that its heading claims must be the size that the archive holds."""
    with archive.open(member) as stream:
        content = stream.read()
    start = io.BytesIO(content)
    version = npy.read_magic(start)
    read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}.get(version)
    if read is None:
        raise ValueError(f"{member} is written in version {version}, which is not known")
    with warnings.catch_warnings(action="error"):
        shape, _, dtype = read(start)
    if dtype.hasobject:
        raise ValueError(f"{member} holds pickled objects, which are not read")
    if prod(shape) * dtype.itemsize != len(content) - start.tell():
        raise ValueError(f"{member} holds {len(content) - start.tell()} bytes, which is not a {shape} of {dtype}")
    return np.asarray(npy.read_array(io.BytesIO(content), allow_pickle=False))


def read_mat(path: Path, names: Iterable[str]) -> dict[str, NDArray[Any]]:
    """Those of the named arrays of numbers or letters that a MATLAB file (version 5 to 7) holds.

    Raises
    ------
    ValueError
        When it is no such file, is damaged, holds cells, structures or objects under these names, or would unpack to
        more than 600 MB. Files of MATLAB's -v7.3 are HDF5: save them with -v7.
    """
    content = content_of(path)
    if content[:8] == b"\x89HDF\r\n\x1a\n" or content[:20].startswith(b"MATLAB 7.3"):
        raise ValueError(f"{path} is of MATLAB's version 7.3: save it with -v7.")
    try:
        return arrays_in(content, set(names), LARGEST_UNPACKED)
    except ValueError as error:
        raise ValueError(f"{path} is not a readable .mat file: {error}") from None


def texts(array: NDArray[Any]) -> tuple[str, ...]:
    """A row of words, as numpy and MATLAB (letters in rows, padded with blanks) keep them."""
    if array.dtype.kind not in "US" or array.ndim > 2:
        raise ValueError(f"labels are {array.dtype} of shape {array.shape}: they must be a row of words")
    return tuple(str(word).strip() for word in array.ravel())


def frf_parts(
    path: Path, arrays: dict[str, NDArray[Any]]
) -> tuple[Array, Complex, tuple[str, ...], str | None, tuple[str, ...]]:
    """Frequency (n,), H (n, seats, seats), labels, unit (None: not said) and notes out of the arrays of these names."""
    missing = [name for name in ("frequency", "H") if name not in arrays]
    if missing:
        raise ValueError(f"{path} holds no {' and no '.join(missing)}: FRFs are the arrays frequency, H, labels, unit.")
    frequency, H = arrays["frequency"], arrays["H"]
    for name, array, kinds in (("frequency", frequency, "fiu"), ("H", H, "fiuc")):
        if array.dtype.kind not in kinds:
            raise ValueError(f"{path}: {name} is an array of {array.dtype}: it must hold numbers.")
    if frequency.ndim == 2 and 1 in frequency.shape:
        frequency = frequency.ravel()
    if H.ndim < 3 and H.size == frequency.size:
        H = H.reshape(-1, 1, 1)
    if H.ndim != 3 or H.shape[1] != H.shape[2]:
        raise ValueError(f"{path}: H has shape {H.shape}: it must be (lines, seats, seats).")
    if "labels" in arrays:
        labels = texts(arrays["labels"])
    elif H.shape[1] % 2 == 0:
        labels = tuple(f"{axis}{k + 1}" for k in range(H.shape[1] // 2) for axis in "xy")
    else:
        raise ValueError(f"{path}: H has {H.shape[1]} seats and no labels say which.")
    unit = texts(arrays["unit"])[:1] if "unit" in arrays else ()
    notes = tuple(note for note in texts(arrays["notes"]) if note) if "notes" in arrays else ()
    return frequency.astype(float), H.astype(complex), labels, unit[0] if unit else None, notes
