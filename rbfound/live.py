"""What can be played with in a page: each thing by its name, as values to begin with and an answer to changed ones.

A host (a page with Python in a worker, or a kernel) hands the values to a front end and passes on what that changes.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbfound import live_sdof

Values = dict[str, Any]


@dataclass(frozen=True)
class Live:
    """Something that has been started.

    Attributes
    ----------
    values : what a front end begins with
    update : from the values that a front end has changed to those that follow
    """

    values: Values
    update: Callable[[Values], Values]


def start(name: str, folder: Path) -> Live:
    """Start a thing.

    Parameters
    ----------
    name : one of THINGS
    folder : with the data that it needs, laid out as in data/foundation
    """
    if name not in THINGS:
        raise ValueError(f"There is nothing named {name!r} to play with: there are {', '.join(THINGS)}.")
    return THINGS[name][1](folder)


def front(name: str) -> str:
    """Name of the module, and of the style sheet, in the package that draws a thing."""
    return THINGS[name][0]


def packed(values: Values) -> tuple[str, list[Any]]:
    """Values as JSON, in which {"buffer": k} stands for the k-th of the arrays and bytes that come with it."""
    buffers: list[Any] = []

    def aside(value: Any) -> dict[str, int]:
        if isinstance(value, bytes):
            buffers.append(value)
        elif isinstance(value, np.ndarray):
            buffers.append(np.ascontiguousarray(value, dtype=float).ravel())
        else:
            raise TypeError(f"A {type(value).__name__} cannot be sent to a page.")
        return {"buffer": len(buffers) - 1}

    return json.dumps(values, default=aside, allow_nan=False), buffers


def _sliders(controls: list[Values], answer: Callable[[Mapping[str, Any]], Values]) -> Live:
    """A thing with sliders: the front end sends all `settings`, and a `stamp` that the `result` bears."""

    def update(values: Values) -> Values:
        result = answer(values["settings"])
        return {"result": {"stamp": values["stamp"], **result}}

    settings = {control["name"]: control["value"] for control in controls}
    first = {"controls": controls, "settings": settings, "stamp": 0}
    return Live(first | update(first), update)


def _oscillator(folder: Path) -> Live:
    return _sliders(live_sdof.CONTROLS, live_sdof.oscillator)


# Front end and beginning of each thing.
THINGS: Mapping[str, tuple[str, Callable[[Path], Live]]] = {
    "oscillator": ("sliders", _oscillator),
}
