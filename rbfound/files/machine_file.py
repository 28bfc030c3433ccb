"""A machine from a small TOML file: shaft, disks, bearings, foundation, speeds. An error names the entry.

speeds = [0, 12000]            # rev/min, lowest and highest
foundation = "foundation.json" # beside this file; leave it out for rigid ground

[shaft]
length = [0.8, 0.16]           # segments from the left [m]
diameter = [0.1, 0.04]         # [m]; also: inner, E, rho, nu, and element, the longest element [m]

[[disk]]
position = 0.96                # [m]
mass = 10.0                    # [kg]; also: Id, Ip [kg m^2]

[[bearing]]
position = 0.0                 # [m]
kxx = 1e8                      # [N/m]; also kyy (kxx unless given), kxy, kyx
kyy = 1e8
cxx = 1e4                      # [N s/m]; also cyy, cxy, cyx
"""

import contextlib
import os
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from rbfound.files.content import decoded, reckoning
from rbfound.files.load_save import load_foundation
from rbfound.machine import Machine, mount
from rbfound.rotor import Bearing, Disk, Rotor, Shaft
from rbfound.units import from_rpm

SHAFT = {
    "length": list,
    "diameter": list,
    "inner": (float, list),
    "E": float,
    "rho": float,
    "nu": float,
    "element": float,
}
DISK = {"position": float, **{field.name: float for field in fields(Disk)}}
BEARING = {"position": float, **{field.name: float for field in fields(Bearing)}}
TOP = {"speeds": list, "foundation": str, "shaft": dict, "disk": list, "bearing": list}


@dataclass(frozen=True, eq=False)
class MachineFile:
    """What a machine file says: the mounted machine and the range of speeds (lowest, highest) [rad/s]."""

    machine: Machine
    speeds: tuple[float, float]


def load_machine(path: str | os.PathLike[str]) -> MachineFile:
    """The machine of a TOML file: see the top of this module for what stands in it.

    Raises
    ------
    ValueError
        For an entry that is unknown, missing, or of the wrong kind, or a machine that cannot be built. It names the
        file and the entry.
    """
    path = Path(path)
    with reckoning(path):
        text = decoded(path)
        try:
            stored = tomllib.loads(text)
        except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
            raise ValueError(f"{path} is no TOML: {error}") from None
        _check(path, stored, TOP, "", ("speeds", "shaft", "bearing"))
        shaft = stored["shaft"]
        _check(path, shaft, SHAFT, "shaft.", ("length", "diameter"))
        speeds = stored["speeds"]
        if len(speeds) != 2 or not 0 <= speeds[0] < speeds[1]:
            raise ValueError(
                f"{path}: speeds is {speeds!r:.60}: give the lowest and the highest [rev/min], such as [0, 12000]."
            )
        disks = _placed(path, stored, "disk", DISK, ("position", "mass"), Disk)
        bearings = _placed(path, stored, "bearing", BEARING, ("position",), Bearing)
        with _at(path, "shaft"):
            element = shaft.pop("element", 0.05)
            rotor = Rotor(Shaft(**shaft), disks, element)
        on = None
        if "foundation" in stored:
            with _at(path, "foundation"):
                on = load_foundation(path.parent / stored["foundation"])
        with _at(path, "bearing"):
            machine = mount(rotor, bearings, on)
        return MachineFile(machine, (float(from_rpm(speeds[0])), float(from_rpm(speeds[1]))))


@contextlib.contextmanager
def _at(path: Path, entry: str) -> Iterator[None]:
    """Gives a ValueError inside the entry that it comes from."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{path}: {entry}: {error}") from None


def _check(path: Path, table: Mapping[str, Any], known: Mapping[str, Any], where: str, needed: tuple[str, ...]) -> None:
    """A ValueError unless every entry is known, of its kind, and all needed ones are there."""
    for key, value in table.items():
        if key not in known:
            raise ValueError(f"{path}: {where}{key} is not known: the entries here are {', '.join(known)}.")
        kinds = known[key] if isinstance(known[key], tuple) else (known[key],)
        words = {float: "a number", list: "a list", str: "a text", dict: "a table"}
        if not any(_is(value, each) for each in kinds):
            right = " or ".join(words[each] for each in kinds)
            raise ValueError(f"{path}: {where}{key} is {value!r:.60}: it must be {right}.")
        if isinstance(value, list) and key not in ("disk", "bearing") and not all(_is(v, float) for v in value):
            raise ValueError(f"{path}: {where}{key} is {value!r:.60}: it must be a list of finite numbers.")
    for key in needed:
        if key not in table:
            raise ValueError(f"{path}: {where}{key} is missing.")


def _placed(
    path: Path, stored: Mapping[str, Any], name: str, known: Mapping[str, Any], needed: tuple[str, ...], make: Any
) -> dict[float, Any]:
    """What stands where, by position [m], of an array of tables."""
    out: dict[float, Any] = {}
    for k, table in enumerate(stored.get(name, []), start=1):
        if not isinstance(table, dict):
            raise ValueError(f"{path}: {name} must be written as [[{name}]].")
        _check(path, table, known, f"{name}[{k}].", needed)
        with _at(path, f"{name}[{k}]"):
            values = dict(table)
            position = float(values.pop("position"))
            if position in out:
                raise ValueError(f"another {name} stands at {position:g} m already.")
            out[position] = make(**values)
    return out


def _is(value: Any, kind: type) -> bool:
    if kind is float:
        # whole numbers of TOML have no bound, those of the machine have
        return isinstance(value, int | float) and not isinstance(value, bool) and -1e300 < value < 1e300
    return isinstance(value, kind)
