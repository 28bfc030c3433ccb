"""A machine from a small TOML file: shaft, disks, bearings, foundation, speeds. An error names the line.

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
kxx = 1e8                      # [N/m]; also kyy, kxy, kyx
kyy = 1e8
cxx = 1e4                      # [N s/m]; also cyy, cxy, cyx
"""

import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from rbfound.files.load_save import load_foundation
from rbfound.files.text import decoded, reckoning
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
        file, the line and the entry.
    """
    path = Path(path)
    with reckoning(path):
        text = decoded(path)
        try:
            stored = tomllib.loads(text)
        except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
            raise ValueError(f"{path} is no TOML: {error}") from None
        file = _File(path, text)
        file.check(stored, TOP, (), ("speeds", "shaft", "bearing"))
        shaft = stored["shaft"]
        file.check(shaft, SHAFT, ("shaft",), ("length", "diameter"))
        disks = file.items(stored, "disk", DISK, ("position", "mass"))
        bearings = file.items(stored, "bearing", BEARING, ("position",))
        speeds = stored["speeds"]
        if len(speeds) != 2 or not 0 <= speeds[0] < speeds[1]:
            raise file.error(
                ("speeds",), f"is {speeds!r:.60}: give the lowest and the highest [rev/min], such as [0, 12000]"
            )
        with file.at("shaft"):
            element = shaft.pop("element", 0.05)
            made = Shaft(**shaft)
        rotor = Rotor(made, file.built(disks, "disk", Disk), element)
        on = None
        if "foundation" in stored:
            with file.at("foundation"):
                on = load_foundation(path.parent / stored["foundation"])
        with file.at("bearing"):
            machine = mount(rotor, file.built(bearings, "bearing", Bearing), on)
        return MachineFile(machine, (float(from_rpm(speeds[0])), float(from_rpm(speeds[1]))))


class _Place:
    """Gives a ValueError inside the place in the file that it comes from."""

    def __init__(self, file: "_File", where: tuple[str | int, ...]) -> None:
        self.file, self.where = file, where

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, ValueError) and not str(error).startswith(f"{self.file.path}, line"):
            raise self.file.error(self.where, f"- {error}") from None


class _File:
    """The text of a machine file, to say on which line an entry stands."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.lines = path, text.splitlines()

    def at(self, *where: str | int) -> _Place:
        return _Place(self, where)

    def error(self, where: tuple[str | int, ...], told: str) -> ValueError:
        name = ".".join(f"[{part + 1}]" if isinstance(part, int) else part for part in where).replace(".[", "[")
        return ValueError(f"{self.path}, line {self.line(where)}: {name} {told}.")

    def line(self, where: tuple[str | int, ...]) -> int:
        """The line that an entry stands on; that of its table when it is missing."""
        begin, end = 0, len(self.lines)
        if where and (where[0] in ("shaft", "disk", "bearing")):
            number = where[1] if len(where) > 1 and isinstance(where[1], int) else 0
            heads = [k for k, line in enumerate(self.lines) if re.match(rf"\s*\[+\s*{where[0]}\s*\]+", line)]
            if heads:
                begin = heads[min(number, len(heads) - 1)]
                later = [k for k, line in enumerate(self.lines) if k > begin and re.match(r"\s*\[", line)]
                end = later[0] if later else end
        key = where[-1] if where else ""
        for k in range(begin, end):
            entry = rf"\s*(?:[\"']?{re.escape(str(key))}[\"']?\s*=|\[+\s*{re.escape(str(key))}\s*\])"
            if key and re.match(entry, self.lines[k]):
                return k + 1
        return begin + 1

    def check(
        self, table: Mapping[str, Any], known: Mapping[str, Any], where: tuple[str | int, ...], needed: tuple[str, ...]
    ) -> None:
        """A ValueError unless every entry is known, of its kind, and all needed ones are there."""
        for key, value in table.items():
            if key not in known:
                raise self.error((*where, key), f"is not known: the entries here are {', '.join(known)}")
            kind = known[key]
            kinds = kind if isinstance(kind, tuple) else (kind,)
            if not any(_is(value, each) for each in kinds):
                words = {float: "a number", list: "a list", str: "a text", dict: "a table"}
                raise self.error(
                    (*where, key), f"is {value!r:.60}: it must be {' or '.join(words[each] for each in kinds)}"
                )
            if isinstance(value, list) and key not in ("disk", "bearing") and not all(_is(v, float) for v in value):
                raise self.error((*where, key), f"is {value!r:.60}: it must be a list of finite numbers")
        for key in needed:
            if key not in table:
                raise self.error((*where, key), "is missing")

    def items(
        self, stored: Mapping[str, Any], name: str, known: Mapping[str, Any], needed: tuple[str, ...]
    ) -> list[dict[str, Any]]:
        """The tables of an array of tables, each checked."""
        tables = stored.get(name, [])
        for k, table in enumerate(tables):
            if not isinstance(table, dict):
                raise self.error((name,), f"must be written as [[{name}]]")
            self.check(table, known, (name, k), needed)
        return list(tables)

    def built(self, tables: list[dict[str, Any]], name: str, make: Any) -> dict[float, Any]:
        """What stands where, by position [m]."""
        out: dict[float, Any] = {}
        for k, table in enumerate(tables):
            with self.at(name, k):
                values = dict(table)
                position = float(values.pop("position"))
                if position in out:
                    raise ValueError(f"another {name} stands at {position:g} m already")
                out[position] = make(**values)
        return out


def _is(value: Any, kind: type) -> bool:
    if kind is float:
        # whole numbers of TOML have no bound, those of the machine have
        return isinstance(value, int | float) and not isinstance(value, bool) and -1e300 < value < 1e300
    return isinstance(value, kind)
