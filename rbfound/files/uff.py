"""FRFs from Universal Files, dataset 58 in text or binary, through pyuff (extra `rbfound[uff]`).

Signs follow the directions: a response at 3-X is minus that at 3+X. Ordinate and denominator say the quantity, their
axis labels the unit; where a file leaves them empty the caller says it.
"""

import contextlib
import io
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from rbfound.files.text import Curve, content_of
from rbfound.frf import check_ascending

FRF_KIND = 4
# Specific data types of dataset 58: what the numerator measures.
QUANTITY = {8: "receptance", 11: "mobility", 12: "accelerance"}
AXES = {1: "x", 2: "y", 3: "z"}


def curves_in(path: Path) -> tuple[dict[tuple[str, str], Curve], tuple[str, ...]]:
    """The FRFs of a Universal File by their seats, and a note on which node became which bearing.

    X and Y are the directions 1 and 2 of the file; bearings are numbered in the order of the nodes' numbers.

    Raises
    ------
    ValueError
        When it is no such file, is damaged, holds no FRF, two for one pair, or one in another direction than X and Y.
    """
    sets = [data for data in _sets(path) if data.get("type") == 58 and data.get("func_type") == FRF_KIND]
    if not sets:
        raise ValueError(f"{path} holds no FRF (dataset 58, function type {FRF_KIND}).")
    try:
        return _curves(path, sets)
    except (KeyError, TypeError, OverflowError) as error:
        raise ValueError(f"{path}: a dataset 58 is incomplete or damaged ({error}).") from None


def _sets(path: Path) -> list[dict[str, Any]]:
    content = content_of(path)
    if b"    -1" not in content[:4096]:
        raise ValueError(f"{path} is not a Universal File: no line -1 opens a dataset.")
    # pyuff opens by name, prints what it skips, and lets through whatever a damaged file makes its parser do
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        copy = Path(folder) / "copy.uff"
        copy.write_bytes(content)
        try:
            with np.errstate(all="ignore"):
                sets = pyuff.UFF(str(copy)).read_sets()
        except Exception as error:
            raise ValueError(f"{path} is not a readable Universal File: {error or type(error).__name__}") from None
    return sets if isinstance(sets, list) else [sets]


def _curves(path: Path, sets: list[dict[str, Any]]) -> tuple[dict[tuple[str, str], Curve], tuple[str, ...]]:
    nodes = sorted({int(data[end]) for data in sets for end in ("rsp_node", "ref_node")})
    number = {node: k for k, node in enumerate(nodes, start=1)}
    out: dict[tuple[str, str], Curve] = {}
    for data in sets:
        response, sign = _seat(path, number, int(data["rsp_node"]), int(data["rsp_dir"]))
        force, other = _seat(path, number, int(data["ref_node"]), int(data["ref_dir"]))
        if (response, force) in out:
            raise ValueError(f"{path} holds two FRFs of {response} from {force}.")
        frequency = np.asarray(data["x"], dtype=float)
        values = np.asarray(data["data"], dtype=complex)
        if frequency.shape != values.shape or frequency.ndim != 1 or not len(frequency):
            raise ValueError(f"{path}: {response} from {force} has {frequency.size} frequencies, {values.size} values.")
        if not np.isfinite(values).all():
            raise ValueError(f"{path}: {response} from {force} holds a number that is not finite.")
        try:
            check_ascending(frequency)
        except ValueError as error:
            raise ValueError(f"{path}: {response} from {force}: {error}") from None
        out[response, force] = Curve(
            path, frequency, sign * other * values, _unit(data), [], QUANTITY.get(data["ordinate_spec_data_type"])
        )
    told = ", ".join(f"node {node} is {k}" for node, k in number.items())
    return out, (f"Bearings in the order of the file's nodes: {told}.",)


def _seat(path: Path, number: dict[int, int], node: int, direction: int) -> tuple[str, int]:
    axis = AXES.get(abs(direction))
    if axis not in ("x", "y"):
        raise ValueError(
            f"{path}: an FRF at node {node} is in direction {direction}: seats move along X (1) and Y (2)."
        )
    return f"{axis}{number[node]}", 1 if direction > 0 else -1


def _unit(data: dict[str, Any]) -> str | None:
    """The unit that the axis labels say; None where they say none."""
    response = str(data.get("ordinate_axis_units_lab", "")).strip()
    force = str(data.get("orddenom_axis_units_lab", "")).strip()
    if response in ("", "NONE") or force in ("", "NONE"):
        return None
    return response if "/N" in response else f"{response}/{force}"
