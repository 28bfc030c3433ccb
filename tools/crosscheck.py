"""The solid model against CalculiX: the same bricks, solved by both, frequency by frequency and second by second.

python tools/crosscheck.py, which `make crosscheck` does. The body is the foundation: what holds it, fixed nodes or a
bed, goes to CalculiX too, the bed as springs between the nodes of its pads.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from calculix import read_frequencies, write_deck
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis

import rbfound as rb
from rbfound.solid import (
    Block,
    FoundationGeometry,
    Places,
    Solid,
    elastic_solid,
    foundation_blocks,
    foundation_solid,
    join,
    natural_modes,
)

Array = NDArray[np.float64]

MISSING = "CalculiX's solver `ccx` is not on the PATH. On Debian or Ubuntu: apt-get install calculix-ccx"

# CalculiX prints seven digits of omega^2, so the root of it is known to 2.5e-7 at the worst.
AGREE = 1e-6

# Polynomials up to this order are integrated exactly: by 2 x 2 x 2 and by 3 x 3 x 3 points.
TWO, THREE = 3, 5


def assemble(blocks: Sequence[Block], stiffness: int, mass: int) -> tuple[sparse.csc_array, sparse.csc_array]:
    """M and K of a body of bricks, each integrated to an order of its own; numbered as in `elastic_solid`.

    A second road beside `elastic_solid`, which leaves the sums to scikit-fem's forms: here they are written out, and
    only the shape functions are scikit-fem's.
    """
    mesh, owner = join(blocks)
    first, second, rho = np.array([(*block.material.lame, block.material.rho) for block in blocks])[owner].T
    basis = Basis(mesh, mesh.elem(), intorder=stiffness)
    slopes = np.array([basis.basis[a][0].grad for a in range(20)])
    # G[e, a, i, b, j]: the integral over element e of d N_a / d x_i times d N_b / d x_j
    G = np.einsum("aieq,bjeq,eq->eaibj", slopes, slopes, basis.dx, optimize=True)
    across = np.einsum("eaibi,jk->eajbk", G, np.eye(3)) + G.swapaxes(2, 4)
    K = first[:, None, None, None, None] * G + second[:, None, None, None, None] * across
    basis = Basis(mesh, mesh.elem(), intorder=mass)
    heights = np.array([np.broadcast_to(basis.basis[a][0], basis.dx.shape) for a in range(20)])
    M = np.einsum("e,aeq,beq,eq,ij->eaibj", rho, heights, heights, basis.dx, np.eye(3), optimize=True)
    count = mesh.doflocs.shape[1]
    place = (basis.element_dofs.T[:, :, None] + count * np.arange(3)).reshape(-1, 60)
    rows, columns = np.repeat(place, 60, axis=1).ravel(), np.tile(place, 60).ravel()
    M, K = (sparse.coo_array((A.ravel(), (rows, columns)), shape=(3 * count,) * 2).tocsc() for A in (M, K))
    return M, K


def ask_calculix(
    blocks: Sequence[Block],
    fixed: Places | None,
    count: int,
    element: str = "C3D20",
    springs: sparse.sparray | None = None,
) -> Array:
    """The lowest natural frequencies [Hz] that CalculiX finds."""
    program = shutil.which("ccx")
    if program is None:
        raise FileNotFoundError(MISSING)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_deck(folder / "body.inp", blocks, fixed, count=count, element=element, springs=springs)
        run = subprocess.run([program, "-i", "body"], cwd=folder, capture_output=True, text=True, check=False)
        if run.returncode or "*ERROR" in run.stdout or not (folder / "body.dat").exists():
            raise RuntimeError(f"ccx ended with {run.returncode}:\n{run.stdout[-2000:]}{run.stderr[-2000:]}")
        return read_frequencies(folder / "body.dat")


def ask_rbfound(solid: Solid, count: int, M: sparse.csc_array, K: sparse.csc_array) -> Array:
    """The lowest natural frequencies [Hz] of a body with other matrices."""
    # below 0 Hz the shifted stiffness is definite even if nothing but springs holds the body
    return rb.hertz(natural_modes(replace(solid, M=M, K=K), count, shift=-1.0)[0])


def timed(work: Callable[[], Array]) -> tuple[Array, float]:
    """What a piece of work returns, and how many seconds it took."""
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def compare(blocks: Sequence[Block], solid: Solid, count: int) -> dict[str, tuple[Array, float]]:
    """Frequencies [Hz] and seconds of each way to them; `solid` is the body of these blocks, with all that holds it."""
    held = ~np.isin(np.arange(solid.mesh.doflocs.shape[1]), solid.free)
    # what is in K beside the bricks: both have these from the same sums, so that elsewhere nothing at all is left
    bed = sparse.csr_array(solid.K - elastic_solid(blocks).K)
    bed.eliminate_zeros()
    what = f"{held.sum()} nodes are held fast, {len(np.unique(bed.nonzero()[0])) // 3} stand on a bed of springs"
    print(f"{solid}; {what}.")

    def ours(stiffness: int, mass: int) -> tuple[Array, float]:
        def work() -> Array:
            M, K = assemble(blocks, stiffness, mass)
            return ask_rbfound(solid, count, M, sparse.csc_array(K + bed))

        return timed(work)

    def theirs(element: str) -> tuple[Array, float]:
        return timed(lambda: ask_calculix(blocks, lambda _: held, count, element, bed if bed.nnz else None))

    return {
        "K and M full": ours(THREE, THREE),
        "K and M reduced": ours(TWO, TWO),
        "K alone reduced": ours(TWO, THREE),
        "C3D20": theirs("C3D20"),
        "C3D20R": theirs("C3D20R"),
    }


def main() -> None:
    """Print both columns, how far they are apart, and both times; end with an error where they do not agree."""
    if shutil.which("ccx") is None:
        sys.exit(MISSING)
    ways = compare(foundation_blocks(FoundationGeometry()), foundation_solid(), 20)
    apart = {}
    for title, ours, theirs in (
        ("Full integration, 3 x 3 x 3 points for K and M", "K and M full", "C3D20"),
        ("Reduced integration, 2 x 2 x 2 points for K and M", "K and M reduced", "C3D20R"),
        ("What rbfound uses, 2 x 2 x 2 points for K and 3 x 3 x 3 for M", "K alone reduced", "C3D20R"),
    ):
        (a, seconds), (b, other) = ways[ours], ways[theirs]
        apart[ours] = float(np.abs(a / b - 1).max())
        columns = {
            "mode": range(1, len(a) + 1),
            "rbfound [Hz]": a,
            f"{theirs} [Hz]": b,
            "difference": [f"{x:9.1e}" for x in a / b - 1],
        }
        print(f"\n{title}", rb.table(columns, digits=7), sep="\n")
        print(f"Largest difference {apart[ours]:.1e}; {seconds:.1f} s by rbfound, {other:.1f} s by CalculiX.")
    worst = max(apart["K and M full"], apart["K and M reduced"])
    if worst > AGREE:
        sys.exit(f"\nWhere both integrate alike they shall agree to {AGREE:g}, and they differ by {worst:.1e}.")
    print(f"\nWhere both integrate alike, the first {len(a)} frequencies agree to {worst:.1e}.")


if __name__ == "__main__":
    main()
