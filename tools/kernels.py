"""Run the tests once for each kind of processor that this one can play.

    python tools/kernels.py [--only KIND] [-- COMMAND ...]

OpenBLAS and numpy choose their inner loops by the processor, and each loop rounds in its own way. What passes with all
of them passes on a reader's machine as well. Without a command, `make unit` and `make nbval` are run. The output of
what failed is kept in _build/portable. Exit code 1 if anything failed.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KEPT = ROOT / "_build" / "portable"

# OpenBLAS's name of each kind, and what a processor must have to play it, as numpy names it. These are all that the
# wheels of numpy and scipy have: there a Zen plays Haswell.
CORES = {
    "Prescott": {"SSE3"},
    "Nehalem": {"SSE42"},
    "Sandybridge": {"AVX"},
    "Haswell": {"AVX2", "FMA3"},
    "SkylakeX": {"AVX512F", "AVX512DQ", "AVX512BW", "AVX512VL"},
}
# What OpenBLAS says where one stands for several: the first name that it knows for it.
SAID = {"Prescott": "Katmai"}
# numpy's own loops without wide registers: a fused multiply and add rounds once instead of twice.
NARROW = "numpy-narrow"
OWN = "own"
KINDS = (*CORES, NARROW, OWN)
# What would choose another kind, or another size of blocks, than the one that is meant.
CLEARED = ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE", "NPY_DISABLE_CPU_FEATURES", "NPY_ENABLE_CPU_FEATURES")
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}

FEATURES = """import json
from numpy._core._multiarray_umath import __cpu_dispatch__ as dispatch, __cpu_features__ as features
has = [name for name in features if features[name]]
print(json.dumps([has, [name for name in dispatch if name in has]]))
"""
# The wheels of numpy and scipy each have an OpenBLAS of their own, and each says which kind it plays.
IN_USE = """import json
import numpy, scipy.linalg
from threadpoolctl import threadpool_info
blas = [one for one in threadpool_info() if one["internal_api"] == "openblas"]
print(json.dumps({one["filepath"]: one["architecture"] for one in blas}))
"""


@dataclass(frozen=True)
class Kind:
    """A kind of processor: its name, and what the environment says for it."""

    name: str
    environment: dict[str, str]


def kinds(features: Iterable[str], dispatched: Iterable[str]) -> list[Kind]:
    """The kinds that a processor with these features can play; `dispatched` are those that numpy has loops for."""
    has, wide = set(features), " ".join(dispatched)
    found = [Kind(name, {"OPENBLAS_CORETYPE": name}) for name, needs in CORES.items() if needs <= has]
    if not found:
        return [Kind(OWN, {})]
    if wide and any(kind.name == "Nehalem" for kind in found):
        found.append(Kind(NARROW, {"OPENBLAS_CORETYPE": "Nehalem", "NPY_DISABLE_CPU_FEATURES": wide}))
    return found


def environment(kind: Kind, around: dict[str, str]) -> dict[str, str]:
    """What a command runs in: all that is around it, except what would choose another kind."""
    return {**{name: value for name, value in around.items() if name not in CLEARED}, **ONE_THREAD, **kind.environment}


def disagreement(kind: Kind, in_use: dict[str, str]) -> str:
    """Which library plays another kind than it was asked to, or an empty text."""
    asked = kind.environment.get("OPENBLAS_CORETYPE", "")
    meant = {asked.lower(), SAID.get(asked, asked).lower()}
    others = [f"{name} plays {core}" for name, core in in_use.items() if asked and core.lower() not in meant]
    return f"asked for {asked}, and {', '.join(others)}" if others else ""


def table(results: dict[str, dict[str, str]]) -> str:
    """Kinds down, parts across."""
    parts = list(dict.fromkeys(part for row in results.values() for part in row))
    rows = [["", *parts], *([name, *(row.get(part, "") for part in parts)] for name, row in results.items())]
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.ljust, row, wide)).rstrip() for row in rows)


def asked_python(script: str, kind: Kind) -> str:
    """What a script prints in a Python of its own, which plays a kind."""
    command = [sys.executable, "-c", script]
    return subprocess.run(
        command, env=environment(kind, dict(os.environ)), check=True, capture_output=True, text=True
    ).stdout


def playable() -> list[Kind]:
    """The kinds that this processor can play."""
    return kinds(*json.loads(asked_python(FEATURES, Kind(OWN, {}))))


def run(kind: Kind, part: str, command: list[str]) -> str:
    """Run one command as one kind; its output stays in a file if it failed."""
    log, start = KEPT / f"{kind.name}-{part}.txt", time.monotonic()
    with log.open("w", encoding="utf-8") as out:
        done = subprocess.run(
            command,
            cwd=ROOT,
            env=environment(kind, dict(os.environ)),
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            check=False,
        )
    verdict = "FAILED" if done.returncode else "passed"
    print(f"{kind.name}, {part}: {verdict}, {time.monotonic() - start:.0f} s", flush=True)
    if done.returncode:
        end = log.read_text(encoding="utf-8", errors="replace").splitlines()[-30:]
        print("\n".join(f"    {line}" for line in end), f"    All of it: {log.relative_to(ROOT)}", sep="\n", flush=True)
    else:
        log.unlink()
    return verdict


def main() -> int:
    """Run each part as each kind."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="KIND", choices=KINDS, help=f"of {', '.join(KINDS)}")
    parser.add_argument("command", nargs=argparse.REMAINDER, help="what is run; `make unit` and `make nbval` without")
    args = parser.parse_args()
    command = args.command[1:] if args.command[:1] == ["--"] else args.command
    parts = {"command": command} if command else {name: ["make", name] for name in ("unit", "nbval")}
    KEPT.mkdir(parents=True, exist_ok=True)

    able_to_play = playable()
    if [kind.name for kind in able_to_play] == [OWN]:
        print("This processor is not of the x86-64 family: only its own kernels are run.")
    chosen = [kind for kind in able_to_play if args.only in (None, kind.name)]
    if not chosen:
        able = ", ".join(kind.name for kind in able_to_play)
        print(f"This processor cannot play {args.only}: nothing is run. It can play {able}.")
        return 0
    results: dict[str, dict[str, str]] = {}
    for kind in chosen:
        in_use = json.loads(asked_python(IN_USE, kind))
        if not in_use:
            print(f"{kind.name}: not checked, as numpy and scipy did not bring an OpenBLAS that tells what it plays.")
        if wrong := disagreement(kind, in_use):
            print(f"{kind.name}: FAILED, {wrong}")
            results[kind.name] = dict.fromkeys(parts, "FAILED")
            continue
        results[kind.name] = {part: run(kind, part, wanted) for part, wanted in parts.items()}
    print("", table(results), sep="\n")
    return int(any("FAILED" in row.values() for row in results.values()))


if __name__ == "__main__":
    sys.exit(main())
