"""The first modes of the solid foundation beside CalculiX on the same mesh: CPU time and memory. Writes solid.md.

`make bench` runs it with the others; it needs `ccx` on the PATH. `python benchmarks/solid.py largest` solves a body of
a million coordinates and writes its own part of solid.md, which the other runs leave as it is.
"""

import json
import os
import platform
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import files, version
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import Any

os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", MKL_NUM_THREADS="1")

import numpy as np
from calculix import read_frequencies, write_deck
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

import rbfound as rb
from rbfound.solid import (
    COARSE,
    WORKING,
    FoundationGeometry,
    Solid,
    elastic_solid,
    foundation_blocks,
    mirror_halves,
    modes as solids,
    natural_modes,
)

Array = NDArray[np.float64]

COUNT = 12
# Clamped pads, as CalculiX's springs would cost it more than our bed costs us.
GEOMETRY = FoundationGeometry(bed=None)
GRIDS = {
    "coarse": COARSE,
    "between": COARSE.halved("neck", "neck_height", "foot", "stator", "web"),
    "working": WORKING,
}
WAYS = ("rbfound, SuperLU", "rbfound, PARDISO", "CalculiX, SPOOLES")
REPEATS = 3
# 514 989 coordinates in each mirror half
FINEST, REFINEMENT = WORKING.halved("stator"), 3
LARGEST = "## A body of a million coordinates"
PAGE = Path(__file__).parent / "solid.md"


def pardiso(A: sparse.csc_array) -> Callable[[Array], Array]:
    """PARDISO's Cholesky factor of a definite matrix, for `natural_modes(..., factor=pardiso)`."""
    # pypardiso would look through the whole environment for MKL, and once more for each further solver
    for file in files("mkl") or []:
        if "mkl_rt" in file.name:
            os.environ.setdefault("PYPARDISO_MKL_RT", str(file.locate()))
    from pypardiso import ps as solver

    upper = sparse.triu(A, format="csr")
    # nobody else needs it, and it would stand beside the factor
    del A
    solver.set_matrix_type(2)
    # iparm 1 and 2: as told here, with METIS's order. Left to itself it refines each answer twice, which costs three
    # times as much as the answer, and with a definite matrix leaves no smaller residual
    solver.iparm[:2] = 1, 2
    solver.factorize(upper)
    solver.remove_stored_factorization()
    solver.set_phase(33)
    return lambda b: np.asarray(solver._call_pardiso(upper, np.asfortranarray(b)))


def body(grid: str) -> Solid:
    return elastic_solid(foundation_blocks(GEOMETRY, grid=GRIDS[grid]), GEOMETRY.on_pads)


def ours(make: Callable[[], Solid], factor: solids.Factor | None, count: int = COUNT) -> dict[str, Any]:
    """From blocks to modes: frequencies [Hz], CPU time [s], memory beyond that of the imports [MB]."""
    before, start = peak(), os.times()
    solid = make()
    omega, _ = natural_modes(solid, count, factor=factor)
    end, memory = os.times(), peak() - before
    return {
        "frequency": rb.hertz(omega).tolist(),
        "coordinates": len(solid.free),
        "cpu": end.user + end.system - start.user - start.system,
        "memory": memory,
    }


def sizes(grid: str) -> dict[str, float]:
    """A number and an index each entry [MB]: SuperLU's factor, both triangles, and the matrices that are there with it.

    These are K, M, and the copy of K that is factored.
    """
    solid = body(grid)
    A = solid.K[solid.free][:, solid.free].tocsc()
    options = {"SymmetricMode": True}
    factor = splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    entries = {"factor": factor.nnz, "matrices": solid.K.nnz + solid.M.nnz + A.nnz}
    return {name: nnz * 12 / 2**20 for name, nnz in entries.items()}


def theirs(grid: str) -> dict[str, Any]:
    """CalculiX from its deck, which is written before: K by 2 x 2 x 2 points, as ours is, M too."""
    with tempfile.TemporaryDirectory() as name:
        deck = Path(name) / "body.inp"
        blocks = foundation_blocks(GEOMETRY, grid=GRIDS[grid])
        write_deck(deck, blocks, GEOMETRY.on_pads, count=COUNT, element="C3D20R")
        start = os.times()
        subprocess.run(["ccx", "-i", "body"], cwd=name, check=True, capture_output=True)
        end = os.times()
        frequency = read_frequencies(deck.with_suffix(".dat"))[:COUNT]
    return {
        "frequency": frequency.tolist(),
        "cpu": end[2] + end[3] - start[2] - start[3],
        "memory": resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024,
    }


def peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def asked(*words: str) -> Any:
    """What this script answers in an interpreter of its own: its memory is then its own too."""
    done = subprocess.run([sys.executable, __file__, *words], check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def answer(way: str, what: str) -> Any:
    if way == "half":
        return ours(lambda: mirror_halves(refinement=REFINEMENT, grid=FINEST)[int(what)], pardiso, 8)
    if way == "size":
        return sizes(what)
    if way == WAYS[2]:
        return theirs(what)
    return ours(lambda: body(what), pardiso if way == WAYS[1] else None)


def largest() -> str:
    """Both halves of the finest mesh, each in an interpreter of its own: PARDISO keeps a factor until its end."""
    halves = [asked("half", str(k)) for k in range(2)]
    found = np.sort(np.concatenate([half["frequency"] for half in halves]))[:8]
    rows = "\n".join(
        f"| {moves} the plane of symmetry | {half['coordinates']} | {half['cpu']:.0f} | {half['memory']:.0f} |"
        for moves, half in zip(("within", "across"), halves, strict=True)
    )
    together = sum(half["coordinates"] for half in halves)
    return f"""{LARGEST}

Written by `python benchmarks/solid.py largest`. The foundation on its bed, the working mesh with every edge divided by
{REFINEMENT} and those of the stator by {2 * REFINEMENT}: {together} coordinates, solved as two mirror halves one after
the other, eight modes of each, with PARDISO's factor (pypardiso {version("pypardiso")}), one thread.

| motion | coordinates | CPU [s] | memory [MB] |
| --- | ---: | ---: | ---: |
{rows}

The lowest frequencies of both together: {", ".join(f"{value:.2f}" for value in found)} Hz.

SuperLU keeps both triangles of its factor, and would need more than twice this memory. A body without symmetry, or one
larger still, wants a factor that is spread over machines: PETSc with MUMPS behind `natural_modes(..., factor=)`,
or SLEPc in place of it. `benchmarks/petsc.py` tries both at small size.
"""


def page() -> str:
    ways = [way for way in WAYS if way != WAYS[1] or find_spec("pypardiso")]
    rows = []
    for grid in GRIDS:
        # by turns, so that whatever else the machine does falls on all of them
        runs = [{way: asked(way, grid) for way in ways} for _ in range(REPEATS)]
        found = {
            way: runs[0][way] | {key: median(run[way][key] for run in runs) for key in ("cpu", "memory")}
            for way in ways
        }
        cpu = found[WAYS[2]]["cpu"]
        size = asked("size", grid)
        known = np.array(found[WAYS[0]]["frequency"])
        for way, run in found.items():
            apart = float(np.abs(np.array(run["frequency"]) / known - 1).max())
            held = f"{size['matrices']:.0f} | {size['factor']:.0f} | {run['memory'] / size['factor']:.2f}"
            rows.append(
                f"| {found[WAYS[0]]['coordinates']} | {way} | {run['cpu']:.2f} | {run['cpu'] / cpu:.2f} | "
                f"{run['memory']:.0f} | {held if way == WAYS[0] else ' |  | '} | {apart:.0e} |"
            )
            print(rows[-1], flush=True)
    told = re.findall(r"Version ([\d.]+)", subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout)
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "scikit-fem"))
    return f"""# The solid beside CalculiX

Written by `make bench` (`benchmarks/solid.py`): do not edit by hand.

The foundation with clamped pads, 20-node bricks, the first {COUNT} modes on the same mesh, from the blocks (rbfound)
or the deck (CalculiX) to the modes. CPU time, one thread, the median of {REPEATS} runs by turns.
Memory: the peak beyond what the imports take, for CalculiX the whole; and its ratio to SuperLU's factor, both triangles
with an index each entry. Beside the factor there are the matrices K and M, and K once more as it is factored. They
grow with the coordinates, the factor grows faster: on a small mesh they weigh most. The last column is relative to
rbfound with SuperLU: K alike, M by 3 x 3 x 3 points here and 2 x 2 x 2 there. Python {platform.python_version()},
{packages}, CalculiX {told[0] if told else "?"}.

| coordinates | way | CPU [s] | ratio to CalculiX | memory [MB] | matrices [MB] | factor [MB] | memory to the factor | \
frequencies differ by |
| ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
{chr(10).join(rows)}
"""


def write(text: str, at: int) -> None:
    """Put one of the page's two parts in its place and keep the other."""
    kept = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    first, mark, second = kept.partition(LARGEST)
    parts = [first.strip(), (mark + second).strip()]
    parts[at] = text.strip()
    PAGE.write_text("\n\n".join(part for part in parts if part) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:] == ["largest"]:
        write(largest(), 1)
    elif len(sys.argv) > 1:
        print(json.dumps(answer(*sys.argv[1:])))
    elif shutil.which("ccx"):
        write(page(), 0)
    else:
        sys.exit("CalculiX's solver `ccx` is not on the PATH: solid.md stays as it is.")
