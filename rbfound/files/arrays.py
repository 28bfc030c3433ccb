"""Arrays by name out of .npz and MATLAB .mat files, with their sizes checked before anything is unpacked."""

import io
import struct
import warnings
import zipfile
import zlib
from collections.abc import Collection, Iterator
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray
from scipy import io as scipy_io

from rbfound.files.content import content_of, listed
from rbfound.files.text import Curve
from rbfound.frf import check_ascending

# 64 FRFs on 500 000 lines [bytes]
LARGEST_UNPACKED = 600_000_000
# Version 5 of MATLAB's format: kinds of elements, and of arrays; the stored kinds of numbers and letters.
MATRIX, COMPRESSED = 14, 15
LETTERS, NUMBERS = 4, range(6, 16)
KINDS = {1: "cell", 2: "struct", 3: "object", 5: "sparse matrix", 16: "function", 17: "object"}
STORED = (1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18)


def read_arrays(path: Path, names: Collection[str]) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Those of the named arrays that a .npz or a .mat file holds, and the names of all that are there.

    A .mat file has MATLAB's version 5 to 7; rows of letters become a row of words. Nothing is unpickled.

    Raises
    ------
    ValueError
        When it is no such file, is damaged, holds something else than numbers or words under these names, or would
        unpack to more than 600 MB.
    """
    kind = path.suffix.lower()
    content = content_of(path)
    try:
        return _npz(content, names) if kind == ".npz" else _mat(content, names)
    except (ValueError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, OSError) as error:
        raise ValueError(f"{path} is not a readable {kind} file: {error}") from None


def _npz(content: bytes, names: Collection[str]) -> tuple[dict[str, NDArray[Any]], list[str]]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        there = [name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")]
        wanted = [name for name in names if name in there]
        total = sum(archive.getinfo(f"{name}.npy").file_size for name in wanted)
        if total > LARGEST_UNPACKED:
            raise ValueError(f"it unpacks to {total / 1e6:.0f} MB: at most {LARGEST_UNPACKED / 1e6:.0f} are read")
        return {name: _array(name, archive.read(f"{name}.npy")) for name in wanted}, there


def _array(name: str, content: bytes) -> NDArray[Any]:
    """One array; the size that its heading claims must be that of what follows, or numpy would make room for it."""
    stream = io.BytesIO(content)
    try:
        version = npy.read_magic(stream)
        # numpy only warns of headings that Python 2 may have written, and Python of slips in them
        with warnings.catch_warnings(action="error"):
            read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}[version]
            shape, _, dtype = read(stream)
    except Exception as error:  # a damaged heading is a piece of Python that may raise anything
        raise ValueError(f"the heading of {name} is damaged ({error})") from None
    if dtype.hasobject:
        raise ValueError(f"{name} holds pickled objects, which are not read")
    rest = len(content) - stream.tell()
    if prod(shape) * dtype.itemsize != rest:
        raise ValueError(f"{name} holds {rest} bytes, which is not a {shape} of {dtype}")
    return np.asarray(np.load(io.BytesIO(content), allow_pickle=False))


def _mat(content: bytes, names: Collection[str]) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """What SciPy reads of the elements that hold these arrays, after their tags were looked at: it trusts these."""
    if content[:8] == b"\x89HDF\r\n\x1a\n" or content[:20].startswith(b"MATLAB 7.3"):
        raise ValueError("it is of MATLAB's version 7.3: save it with -v7")
    if content[124:128] not in (b"\x00\x01IM", b"\x01\x00MI"):
        raise ValueError("it is not of version 5 to 7: save it with -v7")
    order = "<" if content[126:128] == b"IM" else ">"
    kept, there, left = content[:128], [], LARGEST_UNPACKED
    for kind, data in _elements(content, 128, order):
        whole = data
        if kind == COMPRESSED:
            unpacker = zlib.decompressobj()
            whole = unpacker.decompress(data, left + 1)
            left -= len(whole)
            if left < 0:
                raise ValueError(f"it unpacks to more than {LARGEST_UNPACKED / 1e6:.0f} MB")
            if not unpacker.eof:
                raise ValueError("a compressed part is cut off")
            # its own size is no check, as Octave counts four bytes too many for some texts
            kind, whole = struct.unpack_from(order + "I", whole.ljust(8))[0], whole[8:]
        if kind != MATRIX:
            continue
        (_, flags), _, (_, name), *values = [*_elements(whole, 0, order), *[(0, b"")] * 3][: 5 if len(whole) else 3]
        there.append(name.decode("latin-1"))
        if there[-1] in names:
            form = flags[0 if order == "<" else 3] if len(flags) == 8 else 0
            if form != LETTERS and form not in NUMBERS:
                raise ValueError(
                    f"{there[-1]} is a {KINDS.get(form, 'thing unknown')}: only arrays of numbers or letters are read "
                    "(labels: ['x1'; 'y1'])"
                )
            if not values or any(tag not in STORED for tag, part in values if part) or len(name) > 60:
                raise ValueError(f"{there[-1]} holds values of a kind that is not known")
            kept += struct.pack(order + "II", MATRIX, len(whole)) + whole
    try:
        arrays = scipy_io.loadmat(io.BytesIO(kept), variable_names=list(names))
    except Exception as error:  # of a damaged array, whatever its shape and letters lead to
        raise ValueError(f"an array is damaged ({error})") from None
    return {name: np.asarray(arrays[name]) for name in names if name in arrays}, there


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


def texts(array: NDArray[Any]) -> tuple[str, ...]:
    """A row of words, as numpy and MATLAB (letters in rows, padded with blanks) keep them."""
    if array.dtype.kind not in "US" or array.ndim > 2:
        raise ValueError(f"labels are {array.dtype} of shape {array.shape}: they must be a row of words")
    return tuple(str(word).strip() for word in array.ravel())


def curves_of_arrays(path: Path) -> tuple[dict[tuple[str, str], Curve], tuple[str, ...], tuple[str, ...]]:
    """The FRFs of a .npz or .mat file by their labels, the labels, and the notes."""
    parts = ("frequency", "H", "labels", "unit", "notes", "coherence")
    arrays, there = read_arrays(path, parts)
    missing = [name for name in ("frequency", "H") if name not in arrays]
    if missing:
        raise ValueError(
            f"{path} holds no {' and no '.join(missing)}: FRFs are the arrays frequency, H, labels, unit. "
            f"It holds {listed(there) or 'nothing'}."
        )
    frequency, H = arrays["frequency"], arrays["H"]
    for name, array, kinds in (("frequency", frequency, "fiu"), ("H", H, "fiuc")):
        if array.dtype.kind not in kinds:
            raise ValueError(f"{path}: {name} is an array of {array.dtype}: it must hold numbers.")
    if frequency.ndim == 2 and 1 in frequency.shape:
        frequency = frequency.ravel()
    if H.ndim < 3 and H.size == frequency.size:
        H = H.reshape(-1, 1, 1)
    if H.ndim != 3 or H.shape[1] != H.shape[2] or frequency.shape != H.shape[:1] or not H.size:
        raise ValueError(
            f"{path}: H has shape {H.shape}, frequency {frequency.shape}: they must be (lines, seats, seats), (lines,)."
        )
    try:
        labels = texts(arrays["labels"]) if "labels" in arrays else ()
        unit = texts(arrays["unit"])[:1] if "unit" in arrays else ()
        notes = tuple(note for note in texts(arrays["notes"]) if note) if "notes" in arrays else ()
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not labels and H.shape[1] % 2 == 0:
        labels = tuple(f"{axis}{k + 1}" for k in range(H.shape[1] // 2) for axis in "xy")
    if len(labels) != H.shape[1] or len(set(labels)) != len(labels):
        raise ValueError(f"{path}: H has {H.shape[1]} seats, and the labels {listed(labels) or 'are missing'}.")
    try:
        check_ascending(frequency.astype(float))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    bad = np.argwhere(~np.isfinite(H) & (frequency > 0)[:, None, None])
    if len(bad):
        k, i, j = bad[0]
        raise ValueError(
            f"{path}: H at {frequency[k]:g} Hz, response {labels[i]} to a force at {labels[j]}, is {H[k, i, j]}: every "
            "number must be finite."
        )
    ignored = tuple(name for name in there if name not in parts)
    coherence = arrays.get("coherence")
    if coherence is not None and (coherence.shape != H.shape or coherence.dtype.kind != "f"):
        raise ValueError(f"{path}: coherence has shape {coherence.shape}, H {H.shape}: they must be alike.")
    curves = {
        (row, column): Curve(
            str(path), frequency.astype(float), H[:, i, j].astype(complex), unit[0] if unit else None,
            coherence=None if coherence is None else coherence[:, i, j], ignored=ignored,
        )
        for i, row in enumerate(labels)
        for j, column in enumerate(labels)
    }  # fmt: skip
    return curves, labels, notes
