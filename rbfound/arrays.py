"""Arrays by name out of .npz and MATLAB .mat files, with their sizes checked before anything is unpacked.

Nothing in such a file is run: pickled arrays and MATLAB's objects are refused.
"""

import io
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterable
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from rbfound.matfile import arrays_in
from rbfound.rows import content_of

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

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
