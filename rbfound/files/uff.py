"""FRFs from Universal Files, dataset 58 in text or binary, through pyuff (extra `rbfound[uff]`).

Signs follow the directions: a response at 3-X is minus that at 3+X. Ordinate and denominator say the quantity, their
axis labels the unit; where a file leaves them empty the caller says it.
"""

import contextlib
import io
import re
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from rbfound.files.content import content_of
from rbfound.files.text import Curve
from rbfound.frf import check_ascending
from rbfound.units import FREQUENCIES

FRF_KIND, COHERENCE = 4, 6
# Specific data types of dataset 58.
MOTIONS, FORCE, RPM = {8: 0, 11: 1, 12: 2}, 13, 19
NAMES = (("receptance", "mobility", "accelerance"), ("stiffness", "impedance", "apparent mass"))
REAL, AXES = (2, 4), {1: "x", 2: "y", 3: "z"}
HEADER = 11


def curves_in(path: Path, renumbered: bool) -> tuple[dict[tuple[str, str], Curve], tuple[str, ...]]:
    """The FRFs of a Universal File by their points, and a note on which node became which bearing.

    X, Y and Z are the directions 1, 2 and 3 of the file; where `renumbered`, nodes are bearings in ascending order.

    Raises
    ------
    ValueError
        When it is no such file, is damaged, holds no FRF, two for one pair, one without a phase, or a rotation.
    """
    sets = [(place, data) for place, data in _sets(path) if data.get("func_type") in (FRF_KIND, COHERENCE)]
    kinds = [data["func_type"] for _, data in sets]
    if FRF_KIND not in kinds:
        raise ValueError(f"{path} holds no FRF (dataset 58, function type {FRF_KIND}).")
    nodes = sorted({int(data.get(end, 0)) for _, data in sets for end in ("rsp_node", "ref_node")})
    number = {node: k if renumbered else node for k, node in enumerate(nodes, start=1)}
    found: tuple[dict[tuple[str, str], Curve], dict[tuple[str, str], Curve]] = ({}, {})
    for (place, data), kind in zip(sets, kinds, strict=True):
        try:
            pair, curve = _curve(place, data, number, renumbered, kind == COHERENCE)
        except (KeyError, TypeError, OverflowError) as error:
            raise ValueError(f"{place} is incomplete or damaged ({error}).") from None
        there = found[kind == COHERENCE]
        if pair in there:
            raise ValueError(f"{place} is a second one of {pair[0]} from {pair[1]}.")
        there[pair] = curve
    frfs, coherent = found
    for pair, curve in frfs.items():
        other = coherent.get(pair)
        if other is not None and len(other.values) == len(curve.values):
            frfs[pair] = replace(curve, coherence=other.values.real)
    told = ", ".join(f"node {node} is {k}" for node, k in number.items())
    return frfs, (f"Bearings in the order of the file's nodes: {told}.",) if renumbered else ()


def _sets(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each dataset 58, and where it stands."""
    content = content_of(path)
    marks = [match.start() for match in re.finditer(rb"^    -1 *\r?$", content, re.MULTILINE)]
    if not marks or marks[0] > 4096:
        raise ValueError(f"{path} is not a Universal File: no line -1 opens a dataset.")
    # pyuff opens by name, prints what it skips, and lets through whatever a damaged file makes its parser do
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        copy = Path(folder) / "copy.uff"
        copy.write_bytes(content)
        place = str(path)
        try:
            with np.errstate(all="ignore"):
                file = pyuff.UFF(str(copy))
                kinds = file.get_set_types() if marks[1:] else []
                for k, kind in enumerate(kinds):
                    place = f"{path}, dataset {k + 1}"
                    if kind == 58:
                        yield place, file.read_sets(k)
        except Exception as error:
            line = _bad_line(content, marks, int(place.rpartition(" ")[2]) - 1) if place != str(path) else ""
            raise ValueError(f"{place}{line} is not readable: {error or type(error).__name__}") from None


def _bad_line(content: bytes, marks: list[int], k: int) -> str:
    """Where the first line of a dataset in text stands that holds no numbers."""
    if 2 * k + 1 >= len(marks):
        return ""
    lines = content[marks[2 * k] : marks[2 * k + 1]].splitlines()
    for number, line in enumerate(lines[2 + HEADER :], start=3 + HEADER + content.count(b"\n", 0, marks[2 * k])):
        try:
            [float(cell) for cell in line.split()]
        except ValueError:
            return f", line {number}"
    return ""


def _curve(
    place: str, data: dict[str, Any], number: dict[int, int], renumbered: bool, coherence: bool
) -> tuple[tuple[str, str], Curve]:
    ends = []
    for end in ("rsp", "ref"):
        node, direction = int(data[f"{end}_node"]), int(data[f"{end}_dir"])
        axis = AXES.get(abs(direction))
        if axis is None:
            raise ValueError(f"{place} is at node {node} in direction {direction}: only X, Y and Z (1, 2, 3) are read.")
        if axis == "z" and renumbered:
            raise ValueError(
                f"{place} is at node {node} in direction {direction}: seats move along X (1) and Y (2). Say which "
                f"directions of the file they are: seats='{node}Z = y1, ...'."
            )
        ends.append(f"{axis}{number[node]}" if direction > 0 else f"{number[node]}-{axis}")
    if not coherence and data["ord_data_type"] in REAL:
        raise ValueError(f"{place} holds real ordinates: an FRF without its phase says too little.")
    count = int(data["num_pts"])
    x, y = np.asarray(data["x"], dtype=float), np.asarray(data["data"], dtype=complex)
    if x.ndim != 1 or y.ndim != 1 or not 0 < count <= min(len(x), len(y)):
        raise ValueError(f"{place} has {x.size} frequencies and {y.size} values, and says {count}.")
    # what follows fills the last line up
    x, y = x[:count], y[:count]
    if not np.isfinite(y[x != 0]).all():
        k = int(np.flatnonzero(~np.isfinite(y))[0])
        raise ValueError(f"{place}: the value at {x[k]:g} is {y[k]}: it must be finite.")
    label = _label(data, "abscissa") or ("rpm" if data["abscissa_spec_data_type"] == RPM else "")
    if label.lower() not in FREQUENCIES:
        raise ValueError(f"{place}: the frequency is in {label!r}: it must be Hz, kHz, rad/s or rpm.")
    try:
        check_ascending(x)
    except ValueError as error:
        raise ValueError(f"{place}, {ends[0]} from {ends[1]}: {error}") from None
    top, under = int(data["ordinate_spec_data_type"]), int(data["orddenom_spec_data_type"])
    over = top == FORCE and under in MOTIONS
    quantity = NAMES[over][MOTIONS[under if over else top]] if over or top in MOTIONS else None
    return (ends[0], ends[1]), Curve(place, x * FREQUENCIES[label.lower()], y, _unit(data), quantity)


def _label(data: dict[str, Any], of: str) -> str:
    label = str(data.get(f"{of}_axis_units_lab", "")).strip()
    return "" if label.upper() == "NONE" else label


def _unit(data: dict[str, Any]) -> str | None:
    """The unit that the axis labels say: of the response alone where the force has none, None where both are empty."""
    response, force = _label(data, "ordinate"), _label(data, "orddenom")
    return f"{response}/({force})" if response and force and "/" not in response.replace("/s", "") else response or None
