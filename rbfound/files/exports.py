"""A foundation for other programs, and files that are written whole.

JSON, MATLAB, ANSYS (MATRIX27) and NASTRAN (DMIG) as texts and arrays. A killed or failing write leaves the old file.
"""

import contextlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbfound.foundation import Foundation

Array = NDArray[np.float64]

PARTS = ("M", "C", "K", "B", "labels", "notes")


FORMAT = "rbfound foundation 1"


# MATRIX27 has KEYOPT(3) = 2, 4, 5 for a mass, a stiffness and a damping matrix.
MATRICES = {"M": 2, "K": 4, "C": 5}


DEGREES = ("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ")


# What rounding leaves of a symmetric matrix; beyond it a program that keeps one half would lose something.
SYMMETRIC = 1e-12


def to_json(foundation: Foundation) -> str:
    """A foundation as JSON text; every number in the digits that give it back to the last bit."""
    parts = {name: getattr(foundation, name).tolist() for name in "MCKB"}
    words = {"labels": list(foundation.labels), "notes": list(foundation.notes)}
    units = {"M": "kg", "C": "N s/m", "K": "N/m", "about": "M q'' + C q' + K q = B^T f, x = B q at the seats"}
    return json.dumps({"format": FORMAT, "units": units, **words, **parts}, indent=1, ensure_ascii=False) + "\n"


def from_json(text: str) -> Foundation:
    """The foundation of a JSON text that `to_json` wrote.

    Raises
    ------
    ValueError
        When it is no JSON, lacks a part, or holds what is no foundation.
    """
    try:
        stored = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"it is no JSON: {error}") from None
    if not isinstance(stored, dict) or stored.get("format") != FORMAT:
        raise ValueError(f'it is no foundation: "format" must be "{FORMAT}"')
    missing = [name for name in PARTS if name not in stored]
    if missing:
        raise ValueError(f"it lacks {', '.join(missing)}")
    for name in ("labels", "notes"):
        if not isinstance(stored[name], list) or not all(isinstance(word, str) for word in stored[name]):
            raise ValueError(f"{name} must be a list of texts")
    matrices = {}
    for name in "MCKB":
        try:
            matrices[name] = np.array(stored[name], dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"{name} must be rows of numbers, all of one length") from None
    return Foundation(**matrices, labels=tuple(stored["labels"]), notes=tuple(stored["notes"]))


def to_mat(foundation: Foundation) -> dict[str, Any]:
    """What a .mat file of a foundation holds: M, C, K, B, and labels and notes as rows of letters."""
    words = {"labels": np.array(foundation.labels), "notes": np.array(foundation.notes or ("",))}
    return {"M": foundation.M, "C": foundation.C, "K": foundation.K, "B": foundation.B, **words}


def from_arrays(arrays: Mapping[str, NDArray[Any]]) -> Foundation:
    """The foundation of arrays M, C, K, B, labels and notes; a ValueError when one is missing or of the wrong kind."""
    for name in "MCKB":
        if arrays[name].dtype.kind not in "fiu":
            raise ValueError(f"{name} is an array of {arrays[name].dtype}: it must hold real numbers")
    labels, notes = arrays["labels"], arrays["notes"]
    if labels.ndim != 1 or notes.ndim != 1:
        raise ValueError(f"labels has shape {labels.shape}, notes {notes.shape}: both must be rows of texts")
    M, C, K, B = (arrays[name] for name in "MCKB")
    return Foundation(M, C, K, B, tuple(map(str, labels)), tuple(map(str, notes)))


def matrix27(foundation: Foundation, seats: Sequence[int], first: int = 9001, kind: int = 901) -> str:
    """ANSYS commands that put a foundation under a model.

    The coordinates q sit six to a node on the nodes `first`, `first` + 1, ...; a MATRIX27 element for each pair of
    these holds its part of M, C or K. Constraint equations (CE) tie UX and UY of the seats' nodes to them.

    Parameters
    ----------
    seats : numbers of the model's nodes, one for each bearing, in the order of the labels
    first : the first free node number
    kind : the first of three free numbers of element types; real constants start there too

    Raises
    ------
    ValueError
        When the number of nodes does not fit, or a matrix is not symmetric.
    """
    _check(foundation, seats)
    n = len(foundation.M)
    nodes = max(-(-n // 6), 2)
    lines = [
        "! A foundation from rbfound: SI units (N, m, kg, s)",
        f"! seats {', '.join(foundation.labels)}; {n} coordinates on nodes {first} to {first + nodes - 1}",
        "/PREP7",
        *(f"N,{first + k},0,0,0" for k in range(nodes)),
    ]
    unused = range(n, 6 * nodes)
    lines += [f"D,{first + k // 6},{DEGREES[k % 6]},0" for k in unused]
    real = kind
    for number, (name, option) in enumerate(MATRICES.items()):
        whole = np.zeros((6 * nodes, 6 * nodes))
        whole[:n, :n] = _symmetric(getattr(foundation, name))
        lines += [f"ET,{kind + number},MATRIX27", f"KEYOPT,{kind + number},2,0", f"KEYOPT,{kind + number},3,{option}"]
        for i, j, block in _pairs(whole, nodes):
            values = block[np.triu_indices(12)]
            lines += [f"! {name}, nodes {first + i} and {first + j}"]
            for k in range(0, 78, 6):
                row = ",".join(f"{value:.16e}" for value in values[k : k + 6])
                lines.append(f"R,{real},{row}" if k == 0 else f"RMORE,{row}")
            lines += [f"TYPE,{kind + number}", f"REAL,{real}", f"E,{first + i},{first + j}"]
            real += 1
    for row, label in zip(foundation.B, foundation.labels, strict=True):
        lines += _constraint(row, seats[_bearing(foundation, label)], "U" + label[0].upper(), first)
    return "\n".join([*lines, "FINISH", ""])


def _constraint(row: Array, seat: int, degree: str, first: int) -> list[str]:
    """0 = -x + sum B_k q_k: three terms a command, the further ones by HIGH, the number just given."""
    terms = [(seat, degree, -1.0)]
    terms += [(first + k // 6, DEGREES[k % 6], float(b)) for k, b in enumerate(row) if b != 0]
    lines = []
    for k in range(0, len(terms), 3):
        told = ",".join(f"{node},{name},{value:.16e}" for node, name, value in terms[k : k + 3])
        lines.append(f"CE,{'NEXT' if k == 0 else 'HIGH'},0,{told}")
    return lines


def _pairs(whole: Array, nodes: int) -> Iterator[tuple[int, int, Array]]:
    """(i, j, 12 x 12): the coupling of each pair of nodes; a node's own part goes into the first pair that has it."""
    own: set[int] = set()
    for i in range(nodes):
        for j in range(i + 1, nodes):
            block = np.zeros((12, 12))
            a, b = slice(6 * i, 6 * i + 6), slice(6 * j, 6 * j + 6)
            block[:6, 6:], block[6:, :6] = whole[a, b], whole[b, a]
            for node, at, here in ((i, a, slice(0, 6)), (j, b, slice(6, 12))):
                if node not in own:
                    block[here, here] = whole[at, at]
                    own.add(node)
            if block.any():
                yield i, j, block


def dmig(foundation: Foundation, seats: Sequence[int], first: int = 9001, constraints: int = 9001) -> str:
    """A NASTRAN bulk data file: the coordinates q as scalar points, M2GG, K2GG and B2GG as DMIG, the seats by MPC.

    Fields are 16 columns wide, which leaves ten significant digits.

    Parameters
    ----------
    seats : grid points of the model, one for each bearing, in the order of the labels
    first : the first free number of a point
    constraints : number of the MPC set

    Raises
    ------
    ValueError
        When the number of grid points does not fit, or a matrix is not symmetric.
    """
    _check(foundation, seats)
    n = len(foundation.M)
    lines = [
        "$ A foundation from rbfound: SI units (N, m, kg, s). In the case control section:",
        f"$ M2GG = MFOUND, K2GG = KFOUND, B2GG = CFOUND, MPC = {constraints}",
        f"$ seats {', '.join(foundation.labels)}",
        f"SPOINT  {first:<8d}THRU    {first + n - 1:<8d}" if n > 1 else f"SPOINT  {first:<8d}",
    ]
    for name in "MKC":
        A, title = _symmetric(getattr(foundation, name)), f"{name}FOUND"
        lines.append(f"DMIG    {title:<8}{0:8d}{6:8d}{2:8d}{0:8d}")
        for j in range(n):
            column = [(i, A[i, j]) for i in range(j, n) if A[i, j] != 0]
            if column:
                lines.append(f"DMIG*   {title:<16}{first + j:16d}{0:16d}")
                lines += [f"*       {first + i:16d}{0:16d}{_field(value)}" for i, value in column]
    for row, label in zip(foundation.B, foundation.labels, strict=True):
        terms = [(seats[_bearing(foundation, label)], 1 + "xy".index(label[0]), -1.0)]
        terms += [(first + k, 0, float(b)) for k, b in enumerate(row) if b != 0]
        for k in range(0, len(terms), 2):
            start = f"MPC*    {constraints:16d}" if k == 0 else f"*       {'':16}"
            (p, c, a), *rest = terms[k : k + 2]
            lines.append(f"{start}{p:16d}{c:16d}{_field(a)}")
            lines.append("*       " + "".join(f"{p:16d}{c:16d}{_field(a)}" for p, c, a in rest))
    return "\n".join([*lines, ""])


def _field(value: float) -> str:
    return f"{value:16.9E}"


def _check(foundation: Foundation, seats: Sequence[int]) -> None:
    bearings = dict.fromkeys(label[1:] for label in foundation.labels)
    odd = [label for label in foundation.labels if label[:1] not in ("x", "y") or not label[1:].isdigit()]
    if odd:
        raise ValueError(f"The seat {odd[0]} has no direction: labels must be x1, y1, x2, y2, ...")
    if len(seats) != len(bearings) or len(set(seats)) != len(seats):
        raise ValueError(f"{len(seats)} nodes for {len(bearings)} bearings: give a different one for each.")


def _bearing(foundation: Foundation, label: str) -> int:
    return list(dict.fromkeys(other[1:] for other in foundation.labels)).index(label[1:])


def _symmetric(A: Array) -> Array:
    apart = float(np.abs(A - A.T).max())
    if apart > SYMMETRIC * np.abs(A).max():
        raise ValueError(
            f"A matrix differs from its transpose by {apart / np.abs(A).max():.2g} of its largest entry: the formats "
            "of other programs keep one half of it only."
        )
    return np.asarray((A + A.T) / 2)


# A write that is killed leaves its folder of this name behind; a later write removes it when it is an hour old, for
# nobody writes that long.
ASIDE, STALE = ".writing-", 3600.0


@contextlib.contextmanager
def aside(folder: Path) -> Iterator[Path]:
    """A folder inside `folder`, which is made if need be, for what is not complete yet; gone in the end."""
    folder.mkdir(parents=True, exist_ok=True)
    for left in folder.glob(f"{ASIDE}*"):
        # another program may remove it first
        with contextlib.suppress(OSError):
            if time.time() - left.stat().st_mtime > STALE:
                shutil.rmtree(left)
    with tempfile.TemporaryDirectory(prefix=ASIDE, dir=folder) as name:
        yield Path(name)


def replaced(path: str | os.PathLike[str], write: Callable[[Path], object]) -> None:
    """Let `write` make a file aside, in the same folder, and put it in the place of `path` once it is complete."""
    path = Path(path)
    with aside(path.parent) as folder:
        write(folder / path.name)
        os.replace(folder / path.name, path)


def text_replaced(path: str | os.PathLike[str], text: str) -> None:
    """The same for a text, in UTF-8 with the line ends as they are in it."""
    replaced(path, lambda whole: whole.write_text(text, encoding="utf-8", newline="\n"))
