"""Studies of very many machines: one rotor over all pairings of bearing stiffness and damping, foundation and speed.

The rotor without its bearings is reduced once, so that any bearings and foundations can be put under it; a machine is
then some twenty coordinates, and a thousand machines are one stack of eigenvalue problems. Results go to a folder, a
file for each such stack, so that memory stays as it is and what is finished survives a kill.
"""

import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from functools import partial
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.files import replaced, text_replaced
from rbfound.foundation import Foundation
from rbfound.machine import mount
from rbfound.parallel import run
from rbfound.rotor import Bearing, Rotor
from rbfound.system import System
from rbfound.theory import ReducedRotor, mount_reduced, reduced_rotor
from rbfound.units import hertz

Array = NDArray[np.float64]

# The reduced rotor has its modes up to so many times the limit, and so many terms of the series of static answers.
REACH, BLOCKS = 1.5, 2

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
    """A stack of machines of one family, numbers start to stop of the study, and the file of their poles."""

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
    """Work a study off into a folder, or the rest of it if the folder holds a part of it: see `results`.

    The folder then has files part-00000.npy, part-00001.npy, ... Each is written aside and then renamed: it is there as
    a whole or not at all, also after a kill.

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
    _claim(folder, {**_told(study), "chunk": str(chunk)})
    rotor = reduced_rotor(study.rotor, sorted(study.bearings), REACH * study.limit, BLOCKS)
    each = len(study) // len(study.foundations)
    parts: list[_Part] = []
    for number, foundation in enumerate(study.foundations):
        family = _family(rotor, study.bearings, foundation)
        for start in range(number * each, (number + 1) * each, chunk):
            path = folder / f"part-{len(parts):05d}.npy"
            parts.append(_Part(path, family, start, min(start + chunk, (number + 1) * each)))
    missing = [part for part in parts if not part.path.exists()]
    axes = (study.stiffness, study.damping, study.speeds)
    task = partial(_work_off, study.shape, axes, (study.above, study.limit), study.count)
    run(task, missing, executor=executor, progress=progress, title="parts")


def results(folder: str | os.PathLike[str]) -> NDArray[np.complex128]:
    """The poles that a folder of `sweep` holds, (machines, count) [rad/s], damped natural frequencies ascending.

    Machines run over foundations, stiffness, damping and speeds, the last fastest: of a finished study
    `results(folder).reshape(*study.shape, study.count)` has these as axes. The frequency [Hz] is
    `rbfound.hertz(poles.imag)`, the damping ratio -Re / |pole|; nan where there are no more below the limit.
    """
    paths = sorted(Path(folder).glob("part-*.npy"))
    if not paths:
        raise ValueError(f"{folder} has no part-*.npy: it is no folder of `sweep`, or nothing is finished yet.")
    return np.concatenate([np.load(path, allow_pickle=False) for path in paths])


def _told(study: Study) -> dict[str, str]:
    """What a study is, for its folder: numbers as they are, foundations by a digest of their matrices."""
    told = {name: repr(value) for name, value in vars(study).items()}
    told["bearings"] = repr(sorted(study.bearings.items()))
    told["foundations"] = " ".join(
        "rigid" if f is None else sha256(b"".join(A.tobytes() for A in (f.M, f.C, f.K, f.B))).hexdigest()
        for f in study.foundations
    )
    return told


def _claim(folder: Path, told: dict[str, str]) -> None:
    """Write what the study is into its folder, or raise a ValueError where another one is there."""
    path = folder / TOLD
    if not path.exists():
        if any(folder.glob("part-*.npy")):
            raise ValueError(f"{folder} holds parts but no {TOLD}: nobody knows of which study. Take an empty folder.")
        text_replaced(path, json.dumps(told, indent=1) + "\n")
        return
    there = json.loads(path.read_text(encoding="utf-8"))
    changed = sorted(name for name in told.keys() | there.keys() if told.get(name) != there.get(name))
    if changed:
        raise ValueError(
            f"{folder} holds a study with other {', '.join(changed)}: take another folder, or the same values."
        )


def _family(rotor: ReducedRotor, bearings: Mapping[float, Bearing], foundation: Foundation | None) -> _Family:
    loose, tied = (mount_reduced(rotor, these, foundation).at(1.0) for these in ({}, bearings))
    inverse = linalg.inv(linalg.cholesky(loose.M, lower=True))
    K0, C0, G, K1, C1 = (
        inverse @ A @ inverse.T for A in (loose.K, loose.C, loose.G, tied.K - loose.K, tied.C - loose.C)
    )
    return _Family(K0, K1, C0, C1, G)


def _work_off(
    shape: tuple[int, int, int, int],
    axes: tuple[Sequence[float], Sequence[float], Sequence[float]],
    band: tuple[float, float],
    count: int,
    part: _Part,
) -> None:
    """Solve a part and write its file."""
    _, *places = np.unravel_index(np.arange(part.start, part.stop), shape)
    poles = part.family.poles(*(np.asarray(axis)[place] for axis, place in zip(axes, places, strict=True)))
    frequency = hertz(poles.imag)
    inside = (frequency > band[0]) & (hertz(np.abs(poles)) <= band[1])
    order = np.argsort(np.where(inside, frequency, np.inf), axis=1)[:, :count]
    nothing = complex(np.nan, np.nan)
    chosen = np.full((len(poles), count), nothing)
    chosen[:, : order.shape[1]] = np.take_along_axis(np.where(inside, poles, nothing), order, axis=1)
    replaced(part.path, partial(np.save, arr=chosen))
