"""PETSc's MUMPS behind `natural_modes(..., factor=)`, and SLEPc in place of it: equal modes, CPU time. Writes petsc.md.

Both are for bodies whose factor one machine cannot hold; here they are tried on small ones. PyPI has their sources
only. Debian's packages are compiled for its own numpy, older than the one rbfound asks for, which does here:

    apt-get install python3-slepc4py python3-venv
    /usr/bin/python3 -m venv --system-site-packages petsc
    petsc/bin/pip install --no-deps "scipy==1.14.1" "scikit-fem==12.0.2"
    PETSC_DIR=/usr/lib/petscdir/petsc3.18/x86_64-linux-gnu-real \\
    SLEPC_DIR=/usr/lib/slepcdir/slepc3.18/x86_64-linux-gnu-real \\
    PYTHONPATH=. petsc/bin/python benchmarks/petsc.py
"""

import os
import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any

os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")

import numpy as np
from petsc4py import PETSc
from scipy import sparse
from slepc4py import SLEPc
from solid import COUNT, REPEATS, body

from rbfound.solid import Solid, natural_modes

PAGE = Path(__file__).parent / "petsc.md"


def matrix(A: sparse.csc_array) -> Any:
    rows = A.tocsr()
    index = (rows.indptr.astype(PETSc.IntType), rows.indices.astype(PETSc.IntType))
    return PETSc.Mat().createAIJ(rows.shape, csr=(*index, rows.data))


def make_mumps(solver: Any) -> None:
    """Let a solver be nothing but MUMPS' factor."""
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")


def factor(A: sparse.csc_array) -> Callable[[np.ndarray], np.ndarray]:
    """For `natural_modes(..., factor=factor)`."""
    solver = PETSc.KSP().create()
    solver.setOperators(matrix(A))
    make_mumps(solver)
    solver.setUp()
    inverse = solver.getPC().getFactorMatrix()

    def solve(b: np.ndarray) -> np.ndarray:
        forces = PETSc.Mat().createDense(b.shape, array=b.ravel(order="F"))
        answer = PETSc.Mat().createDense(b.shape)
        answer.setUp()
        for one in (forces, answer):
            one.assemble()
        inverse.matSolve(forces, answer)
        return np.array(answer.getDenseArray())

    # PETSc takes a factor away with its solver
    solve.solver = solver
    return solve


def slepc(solid: Solid) -> np.ndarray:
    """Natural frequencies [rad/s] by SLEPc's own iteration, shifted to zero."""
    problem = SLEPc.EPS().create()
    problem.setOperators(*(matrix(A[solid.free][:, solid.free]) for A in (solid.K, solid.M)))
    problem.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    problem.setDimensions(COUNT)
    problem.setTarget(0.0)
    problem.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    problem.getST().setType("sinvert")
    make_mumps(problem.getST().getKSP())
    problem.setTolerances(1e-12)
    problem.solve()
    return np.sqrt(np.sort([problem.getEigenvalue(k).real for k in range(COUNT)]))


WAYS: dict[str, Callable[[Solid], np.ndarray]] = {
    "natural_modes, SuperLU": lambda solid: natural_modes(solid, COUNT)[0],
    "natural_modes, MUMPS of PETSc": lambda solid: natural_modes(solid, COUNT, factor=factor)[0],
    "SLEPc, MUMPS": slepc,
}


def seconds(way: Callable[[Solid], np.ndarray], solid: Solid) -> tuple[float, np.ndarray]:
    start = os.times()
    omega = way(solid)
    end = os.times()
    return end.user + end.system - start.user - start.system, omega


def rows() -> list[str]:
    out = []
    for grid in ("coarse", "working"):
        solid = body(grid)
        spent: dict[str, list[float]] = {name: [] for name in WAYS}
        found = {}
        for _ in range(REPEATS):
            for name, way in WAYS.items():
                time, found[name] = seconds(way, solid)
                spent[name].append(time)
        own = next(iter(found.values()))
        for name, omega in found.items():
            off = np.abs(omega / own - 1).max()
            out.append(f"| {len(solid.free)} | {name} | {median(spent[name]):.2f} | {off:.0e} |")
            print(out[-1], flush=True)
    return out


def page() -> str:
    table = "\n".join(rows())
    versions = ", ".join(".".join(map(str, package.Sys.getVersion())) for package in (PETSc, SLEPc))
    return f"""# Beyond one machine

Written by `benchmarks/petsc.py`, which says what it needs: do not edit by hand.

A factor that one machine cannot hold is for MUMPS, which spreads it over many: PETSc has it, and `natural_modes`
takes it as `factor=`; or SLEPc does the whole. Here both are tried on small bodies, in one process: the first {COUNT}
modes, from the matrices on. The last column is relative to the first row. CPU time, one thread, the median of
{REPEATS} runs by turns. Python {platform.python_version()}, numpy {np.__version__}, scipy {version("scipy")},
PETSc and SLEPc {versions} of Debian.

| coordinates | way | CPU [s] | frequencies differ by |
| ---: | --- | ---: | ---: |
{table}
"""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
