"""Studies of very many machines: one rotor over all pairings of bearing stiffness and damping, foundation and speed.

The rotor without its bearings is reduced once, to its modes and to what answers to forces at its journals, so that any
bearings and foundations can be put under it; a machine is then some twenty coordinates, and a thousand machines are one
stack of eigenvalue problems. Results go to a folder of Parquet files, one for each such
stack, so that memory stays as it is and what is finished survives a kill. Needs the extra rbfound[sweep] (pyarrow);
`import rbfound` does not load this module.
"""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
from numpy.typing import NDArray
from pyarrow import parquet
from scipy import linalg

from rbfound.files import replaced, text_replaced
from rbfound.foundation import Foundation
from rbfound.machine import check_seats, mount
from rbfound.parallel import run
from rbfound.rotor import Bearing, Rotor, assemble
from rbfound.system import System
from rbfound.theory import orthonormal
from rbfound.units import hertz, radians

Array = NDArray[np.float64]

# The basis of the reduced rotor: its modes up to so many times the limit, so many terms of the series of static
# answers, and the frequency of these answers, below zero, as a part of the limit.
REACH, BLOCKS, NEARLY_STATIC = 1.5, 2, 0.1

# What the folder holds beside its parts.
TOLD = "study.json"


@dataclass(frozen=True)
class Study:
    """Machines that differ by bearing stiffness, bearing damping, foundation and speed: all pairings of these.

    Attributes
    ----------
    rotor : Rotor
    bearings : mapping from a position along the shaft [m] to a Bearing
    speeds : [rad/s]
    foundations : what the machines stand on, one after the other; None is rigid ground
    stiffness, damping : factors by which the K and the C of all bearings are multiplied
    limit : [Hz]
        Poles up to this size |lambda| are given, within 2e-4 of those of the whole rotor at speeds up to the same
        number of turns a second. What is damped so strongly that its |lambda| lies above is left out.
    count : how many of them at the most, those of the lowest damped frequencies
    above : [Hz]
        Modes of lower frequency are left out: rigid-body and overdamped ones.
    """

    rotor: Rotor
    bearings: Mapping[float, Bearing]
    speeds: Sequence[float]
    foundations: Sequence[Foundation | None] = (None,)
    stiffness: Sequence[float] = (1.0,)
    damping: Sequence[float] = (1.0,)
    limit: float = 1000.0
    count: int = 12
    above: float = 1.0

    def __post_init__(self) -> None:
        if not self.bearings:
            raise ValueError("A study needs bearings: the rotor has none here.")
        for name in ("speeds", "foundations", "stiffness", "damping"):
            if not len(getattr(self, name)):
                raise ValueError(f"{name} is empty: a study needs at least one of them.")
        for name in ("speeds", "stiffness", "damping"):
            values = np.asarray(getattr(self, name), dtype=float)
            if values.ndim != 1 or not np.isfinite(values).all():
                raise ValueError(f"{name} must be a list of finite numbers: it is {values.tolist()}.")
            object.__setattr__(self, name, tuple(values.tolist()))
        if not 0 <= self.above < self.limit < np.inf:
            raise ValueError(f"above = {self.above:g} Hz and limit = {self.limit:g} Hz: it must be 0 <= above < limit.")
        if self.count < 1:
            raise ValueError(f"count = {self.count}: ask for one frequency at least.")

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """How many foundations, factors of stiffness and of damping, and speeds."""
        return len(self.foundations), len(self.stiffness), len(self.damping), len(self.speeds)

    def __len__(self) -> int:
        return int(np.prod(self.shape))

    def system(self, number: int) -> System:
        """One machine, unreduced and at its speed: the way to look closer at a row of the results."""
        ground, k, c, speed = (int(place) for place in np.unravel_index(number, self.shape))
        given = {}
        for z, bearing in self.bearings.items():
            values = asdict(bearing)
            factor = {"k": self.stiffness[k], "c": self.damping[c]}
            given[z] = Bearing(**{name: value * factor[name[0]] for name, value in values.items()})
        return mount(self.rotor, given, on=self.foundations[ground]).at(self.speeds[speed])


@dataclass(frozen=True, eq=False)
class _Family:
    """Machines on one foundation, mass-normalised: K = K0 + k K1 and C = C0 + c C1 + speed G, all (m, m)."""

    K0: Array
    K1: Array
    C0: Array
    C1: Array
    G: Array

    def poles(self, k: Array, c: Array, speed: Array) -> NDArray[np.complex128]:
        """All poles of n machines by their factors and speeds (n,): (n, 2 m) [rad/s]."""
        m = len(self.K0)
        k, c, speed = (values[:, None, None] for values in (k, c, speed))
        stiffness = self.K0 + k * self.K1
        # time in units of the fastest mode, so that both halves of the state have one size
        rate = np.sqrt(np.abs(stiffness).sum(axis=2).max(axis=1))[:, None, None]
        A = np.zeros((len(k), 2 * m, 2 * m))
        A[:, range(m), range(m, 2 * m)] = 1.0
        A[:, m:, :m] = -stiffness / rate**2
        A[:, m:, m:] = -(self.C0 + c * self.C1 + speed * self.G) / rate
        return np.asarray(np.linalg.eigvals(A) * rate[:, :, 0], dtype=complex)


@dataclass(frozen=True, eq=False)
class _Part:
    """A stack of machines of one family, numbers start to stop of the study, and the file of their results."""

    path: Path
    family: _Family
    start: int
    stop: int


def sweep(
    study: Study,
    folder: str | os.PathLike[str],
    *,
    chunk: int = 1000,
    executor: Executor | None = None,
    progress: bool | None = None,
) -> None:
    """Work a study off into a folder, or the rest of it if the folder holds a part of it.

    The folder then has files part-00000.parquet, part-00001.parquet, ..., which every reader of Parquet takes as one
    table; `results` is the shortest. A row is a machine; rows run over foundations, stiffness, damping and speeds, the
    last fastest, and the columns are

    - foundation [number from 0], stiffness, damping [factors], speed [rad/s]
    - f1, f2, ... [Hz] and zeta1, zeta2, ... [-]: damped natural frequencies, ascending, and damping ratios, negative
      where the machine is unstable; nan where there are no more below the limit

    A part is written aside and then renamed: it is there as a whole or not at all, also after a kill.

    Parameters
    ----------
    study : Study
    folder : made if it is not there
    chunk : how many machines a part has
        A worker holds one part at a time: some 20 MB for a thousand machines of 25 coordinates.
    executor, progress : see `rbfound.parallel.run`
        The workers write the parts themselves, so they must all see the folder.

    Raises
    ------
    ValueError
        When the folder holds another study, or parts of another size.
    """
    if chunk < 1:
        raise ValueError(f"chunk = {chunk}: a part needs at least one machine.")
    folder = Path(folder)
    _claim(folder, {**_told(study), "chunk": chunk})
    reduced, G = _reduced_rotor(study)
    each = len(study) // len(study.foundations)
    parts: list[_Part] = []
    for number, foundation in enumerate(study.foundations):
        family = _family(study, reduced, G, foundation)
        for start in range(number * each, (number + 1) * each, chunk):
            path = folder / f"part-{len(parts):05d}.parquet"
            parts.append(_Part(path, family, start, min(start + chunk, (number + 1) * each)))
    missing = [part for part in parts if not part.path.exists()]
    axes = (study.stiffness, study.damping, study.speeds)
    task = partial(_work_off, study.shape, axes, (study.above, study.limit), study.count)
    run(task, missing, executor=executor, progress=progress, title="parts")


def results(folder: str | os.PathLike[str], columns: Sequence[str] | None = None) -> dict[str, NDArray[Any]]:
    """The columns of a study's folder as arrays, (machines,) each; all unless some are named. See `sweep`."""
    paths = sorted(Path(folder).glob("part-*.parquet"))
    if not paths:
        raise ValueError(f"{folder} has no part-*.parquet: it is no folder of `sweep`, or nothing is finished yet.")
    names = list(columns) if columns is not None else None
    table = pyarrow.concat_tables([parquet.read_table(path, columns=names) for path in paths])
    return {name: table[name].to_numpy() for name in table.column_names}


def _told(study: Study) -> dict[str, Any]:
    """What a study is, for its folder: numbers as they are, foundations by a digest of their matrices."""
    told = {name: value for name, value in vars(study).items() if name not in ("rotor", "bearings", "foundations")}
    told["rotor"] = asdict(study.rotor)
    told["bearings"] = {z: asdict(study.bearings[z]) for z in sorted(study.bearings)}
    told["foundations"] = [
        "rigid ground" if f is None else hashlib.sha256(b"".join(A.tobytes() for A in (f.M, f.C, f.K, f.B))).hexdigest()
        for f in study.foundations
    ]
    # as it will be read again
    return dict(json.loads(json.dumps(told, default=lambda value: np.asarray(value).tolist())))


def _claim(folder: Path, told: dict[str, Any]) -> None:
    """Write what the study is into its folder, or raise a ValueError where another one is there."""
    path = folder / TOLD
    if not path.exists():
        if any(folder.glob("part-*.parquet")):
            raise ValueError(f"{folder} holds parts but no {TOLD}: nobody knows of which study. Take an empty folder.")
        text_replaced(path, json.dumps(told, indent=1) + "\n")
        return
    there = json.loads(path.read_text(encoding="utf-8"))
    changed = sorted(name for name in told.keys() | there.keys() if told.get(name) != there.get(name))
    if changed:
        raise ValueError(
            f"{folder} holds a study with other {', '.join(changed)}: take another folder, or the same values."
        )


def _reduced_rotor(study: Study) -> tuple[Foundation, Array]:
    """The free rotor in few coordinates, with x and y of its journals as seats, and G in the same coordinates.

    The basis has the modes of the rotor at rest, its static answers to forces at the journals and to moments where
    disks turn, and the answers to the inertia of these: the first terms of what the omitted modes add.
    """
    places = sorted(study.bearings)
    for z in places:
        study.rotor.check_position(z, "bearing")
    mesh = assemble(study.rotor, places)
    journals = [4 * mesh.node(z) + axis for z in places for axis in (0, 1)]
    disks = [4 * mesh.node(z) + axis for z, disk in study.rotor.disks.items() if disk.Ip for axis in (2, 3)]
    limit = float(radians(study.limit))
    T = linalg.eigh(mesh.K, mesh.M, subset_by_value=(-np.inf, (REACH * limit) ** 2))[1]
    # a free rotor gives no static answer: at this square of a frequency below zero it does, and hardly another one
    factor = linalg.cho_factor(mesh.K + (NEARLY_STATIC * limit) ** 2 * mesh.M)
    forces = np.eye(len(mesh.M))[:, journals + disks]
    for _ in range(BLOCKS):
        answer = orthonormal(linalg.cho_solve(factor, forces), mesh.M, T)
        T, forces = np.hstack([T, answer]), mesh.M @ answer
    M, K, G = (T.T @ A @ T for A in (mesh.M, mesh.K, mesh.G))
    return Foundation(
        M, np.zeros_like(M), (K + K.T) / 2, T[journals], tuple(f"{a}{z:g}" for z in places for a in "xy")
    ), G


def _family(study: Study, rotor: Foundation, G: Array, foundation: Foundation | None) -> _Family:
    bearings = [study.bearings[z] for z in sorted(study.bearings)]
    bodies, relative = [rotor], rotor.B
    if foundation is not None:
        check_seats(len(bearings), foundation.labels)
        bodies.append(foundation)
        relative = np.hstack([rotor.B, -foundation.B])
    M, C, K = (linalg.block_diag(*(getattr(body, name) for body in bodies)) for name in "MCK")
    spin = np.zeros_like(M)
    spin[: len(G), : len(G)] = G
    tied = (
        relative.T @ linalg.block_diag(*(getattr(bearing, name) for bearing in bearings)) @ relative for name in "KC"
    )
    inverse = linalg.inv(linalg.cholesky(M, lower=True))
    K0, C0, spin, K1, C1 = (inverse @ A @ inverse.T for A in (K, C, spin, *tied))
    return _Family(K0, K1, C0, C1, spin)


def _work_off(
    shape: tuple[int, int, int, int],
    axes: tuple[Sequence[float], Sequence[float], Sequence[float]],
    band: tuple[float, float],
    count: int,
    part: _Part,
) -> None:
    """Solve a part and write its file."""
    ground, *places = np.unravel_index(np.arange(part.start, part.stop), shape)
    k, c, speed = (np.asarray(axis)[place] for axis, place in zip(axes, places, strict=True))
    poles = part.family.poles(k, c, speed)
    frequency = hertz(poles.imag)
    inside = (frequency > band[0]) & (hertz(np.abs(poles)) <= band[1])
    order = np.argsort(np.where(inside, frequency, np.inf), axis=1)[:, :count]
    nothing = complex(np.nan, np.nan)
    chosen = np.full((len(poles), count), nothing)
    chosen[:, : order.shape[1]] = np.take_along_axis(np.where(inside, poles, nothing), order, axis=1)
    columns: dict[str, Any] = {"foundation": ground, "stiffness": k, "damping": c, "speed": speed}
    for j, pole in enumerate(chosen.T, start=1):
        columns[f"f{j}"], columns[f"zeta{j}"] = hertz(pole.imag), -pole.real / np.abs(pole)
    replaced(part.path, partial(parquet.write_table, pyarrow.table(columns)))
