"""What can be played with in a page: each thing by its name, as values to begin with and an answer to changed ones.

A host (a page with Python in a worker, or a kernel) hands the values to a front end and passes on what that changes.
"""

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from rbfound.files import foundation_bytes, foundation_text, load_foundation, load_frf
from rbfound.foundation import Foundation
from rbfound.live import machine_things, reduction_things, sdof_things
from rbfound.live.bench import Bench, bench_of
from rbfound.live.frontend import answer, scene
from rbfound.thesis import bearings, rotor

Values = dict[str, Any]

# What an argument of `rbfound.load_frf`, as messages name it, is called in the page.
FIELDS = {
    "fill=True takes": 'The box "A missing FRF from its mirror" takes',
    "unit=": 'the field "Unit" ',
    "columns=": 'the field "Columns" ',
    "pattern=": 'the field "Names of the files" ',
}


@dataclass(frozen=True)
class Live:
    """Something that has been started.

    Attributes
    ----------
    values : what a front end begins with
    update : from the values that a front end has changed to those that follow
    saves : from the name of a file that can be had of it to that file
    """

    values: Values
    update: Callable[[Values], Values]
    saves: Mapping[str, Callable[[], bytes]] = field(default_factory=dict)


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


def opened(name: str, folder: Path, **fields: Any) -> Live:
    """Start a thing with a reader's own files: one file, or a folder of them, as `rbfound.load_frf` takes them.

    Parameters
    ----------
    fields : `unit`, `columns`, `pattern`, `fill` of `rbfound.load_frf`, where files do not say it; an empty one is none

    Raises
    ------
    ValueError
        As `rbfound.load_frf`, with the fields of the page in place of Python's arguments.
    """
    if name not in OPENS:
        raise ValueError(f"{name} takes no files: {', '.join(OPENS)} does.")
    inside = sorted(folder.iterdir())
    given = {key: value for key, value in fields.items() if value}
    try:
        return OPENS[name](inside[0] if len(inside) == 1 else folder, given)
    except ValueError as error:
        raise ValueError(_in_fields(str(error))) from error


def front(name: str) -> str:
    """Name of the front end that draws a thing: see `script` and `sheet`."""
    return THINGS[name][0]


def script(name: str) -> str:
    """A front end as one module: what all of them share, and its own."""
    return "\n".join(_text(f"{part}.js") for part in ("core", name))


def sheet(name: str) -> str:
    """The style sheet of a front end."""
    return _text(f"{name}.css")


def _text(name: str) -> str:
    return files("rbfound.live").joinpath(name).read_text(encoding="utf-8")


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


def _in_fields(message: str) -> str:
    """A message of the package in the words of the page, which has fields for some arguments."""
    for argument, words in FIELDS.items():
        message = re.sub(rf"\b{argument}", words, message)
    return message


def _sliders(controls: list[Values], answer: Callable[[Mapping[str, Any]], Values]) -> Live:
    """A thing with sliders: the front end sends all `settings`, and a `stamp` that the `result` bears."""

    def update(values: Values) -> Values:
        result = answer(values["settings"])
        return {"result": {"stamp": values["stamp"], **result}}

    settings = {control["name"]: control["value"] for control in controls}
    first = {"controls": controls, "settings": settings, "stamp": 0}
    return Live(first | update(first), update)


def _oscillator(folder: Path) -> Live:
    return _sliders(sdof_things.CONTROLS, sdof_things.oscillator)


def _campbell(folder: Path) -> Live:
    return _sliders(*machine_things.campbell_thing(load_foundation(folder / "truth.npz")))


def _unbalance(folder: Path) -> Live:
    return _sliders(*machine_things.unbalance_thing(load_foundation(folder / "truth.npz")))


def _reduction(folder: Path) -> Live:
    return _sliders(*reduction_things.reduction_thing())


def _peak_picker(folder: Path) -> Live:
    truth = load_foundation(folder / "truth.npz")
    return _picker(bench_of(load_frf(folder / "fine"), rotor(), bearings(), truth), "pmsm")


def _own_peak_picker(path: Path, fields: Mapping[str, Any]) -> Live:
    return _picker(bench_of(load_frf(path, **fields)), "identify")


def _picker(bench: Bench, method: str) -> Live:
    """The peak picker: the front end sends `peaks`, `method` and `stamp`; see `rbfound.live.frontend`."""
    names, data = scene(bench)
    held: dict[str, Foundation] = {}

    def update(values: Values) -> Values:
        found, told, curves = answer(bench, values["peaks"], values["method"])
        held.clear()
        if found is not None:
            held["foundation"] = found.foundation
        # the curves first: the result tells the front end to draw them
        return {"curves": curves, "result": {**told, "stamp": values["stamp"]}}

    def kept() -> Foundation:
        if not held:
            raise ValueError("The peaks as they stand give no foundation.")
        return held["foundation"]

    first = {"peaks": names["first"][method], "method": method, "stamp": 0}
    saves = {
        "foundation.npz": lambda: foundation_bytes(kept()),
        "foundation.txt": lambda: foundation_text(kept()).encode(),
    }
    return Live({"scene": names, "data": data} | first | update(first), update, saves)


# Front end and beginning of each thing; what takes a reader's own files.
THINGS: Mapping[str, tuple[str, Callable[[Path], Live]]] = {
    "peak_picker": ("picker", _peak_picker),
    "oscillator": ("sliders", _oscillator),
    "campbell": ("sliders", _campbell),
    "unbalance": ("sliders", _unbalance),
    "reduction": ("sliders", _reduction),
}
OPENS: Mapping[str, Callable[[Path, Mapping[str, Any]], Live]] = {"peak_picker": _own_peak_picker}
