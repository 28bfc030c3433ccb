"""Figures as plain values: what a front end draws, told without a plotting library."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rbfound.tables import number


def axis(label: str, low: float | None = None, high: float | None = None, log: bool = False) -> dict[str, Any]:
    """An axis, with its unit in the label; an end that is not given follows the curves."""
    return {"label": label, "low": low, "high": high, "log": log}


def line(label: str, x: ArrayLike, y: ArrayLike, style: int = 0, thin: bool = False) -> dict[str, Any]:
    """A curve; nan interrupts it. Equal styles have one colour and one dash, the first line of a label names it."""
    x, y = (np.ascontiguousarray(values, dtype=float) for values in (x, y))
    if x.shape != y.shape or x.ndim != 1:
        raise ValueError(f"{label}: x has shape {x.shape}, y {y.shape}: both must be rows of one length.")
    return {"label": label, "x": x, "y": y, "style": style, "thin": thin}


def mark(label: str, x: float, y: float, style: int = 0) -> dict[str, Any]:
    """A point with a name, which may be empty."""
    return {"label": label, "x": float(x), "y": float(y), "style": style}


def figure(
    title: str,
    x: Mapping[str, Any],
    y: Mapping[str, Any],
    lines: Sequence[Mapping[str, Any]],
    marks: Sequence[Mapping[str, Any]] = (),
    equal: bool = False,
    wide: bool = False,
) -> dict[str, Any]:
    """Curves and points between two axes; `equal` gives both axes one scale, `wide` a row of its own."""
    return {
        "title": title,
        "x": dict(x),
        "y": dict(y),
        "lines": list(lines),
        "marks": [point for point in marks if np.isfinite([point["x"], point["y"]]).all()],
        "equal": equal,
        "wide": wide,
    }


def listing(caption: str, columns: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    """A table with four significant digits, as in `rbfound.table`."""
    return {"caption": caption, "columns": {name: [number(v) for v in column] for name, column in columns.items()}}


def slider(
    name: str,
    label: str,
    unit: str,
    low: float,
    high: float,
    value: float,
    log: bool = False,
    step: float | None = None,
) -> dict[str, Any]:
    """A number between two ends; `log` makes equal steps of equal parts. Without a step there are two hundred."""
    if not low <= value <= high:
        raise ValueError(f"{label}: {value:g} does not lie between {low:g} and {high:g}.")
    kind = {"kind": "slider", "name": name, "label": label, "unit": unit}
    return kind | {"low": low, "high": high, "value": value, "log": log, "step": step}


def switch(name: str, label: str, value: bool) -> dict[str, Any]:
    """On or off."""
    return {"kind": "switch", "name": name, "label": label, "value": value}


def choice(name: str, label: str, options: Mapping[str, str], value: str) -> dict[str, Any]:
    """One of several, a mapping from the value to what a reader sees."""
    return {
        "kind": "choice",
        "name": name,
        "label": label,
        "options": [list(o) for o in options.items()],
        "value": value,
    }
