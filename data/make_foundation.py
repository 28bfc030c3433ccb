"""Compute the foundation's FRFs and its reduced model from the solid model, and write them beside this file.

    python data/make_foundation.py            write data/foundation/
    python data/make_foundation.py --check    compare what is there with what is computed, to 1e-6

Needs rbfound[solid]; takes a few seconds.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rbfound import Foundation, hertz, load_foundation, load_frf, save_foundation, save_frf, table
from rbfound.solid import Solid, foundation_solid, momentum, reduce, ritz_modes
from rbfound.thesis import FOUNDATION as ANSYS

Array = NDArray[np.float64]

FOLDER = Path(__file__).parent / "foundation"
TRUTH = FOLDER / "truth.npz"
MOMENTUM = FOLDER / "momentum.txt"

# [Hz]. A harmonic analysis of n steps up to some frequency solves the end of each step, not the start of the first.
GRIDS = {
    "coarse": 25.0 * np.arange(1, 21),
    "medium": 10.0 * np.arange(1, 101),
    "fine": 0.5 * np.arange(1, 2001),
}
TOLERANCE = 1e-6


def compute(solid: Solid) -> Foundation:
    """The reduced solid, with a sentence on where it comes from and its frequencies beside ANSYS's."""
    bare = reduce(solid)
    beside = ", ".join(f"{f:.1f} ({a:.0f})" for f, a in zip(natural_frequencies(bare), ANSYS, strict=False))
    notes = (
        f"Reduced from the solid model of rbfound.solid with {len(solid.free)} free coordinates, 2 % modal damping.",
        f"Undamped natural frequencies [Hz], the thesis's ANSYS model in brackets: {beside}.",
    )
    return Foundation(bare.M, bare.C, bare.K, bare.B, bare.labels, notes)


def natural_frequencies(foundation: Foundation) -> Array:
    """Undamped natural frequencies [Hz] of a foundation in its own modal coordinates."""
    return np.asarray(hertz(np.sqrt(np.diag(foundation.K))))


def comparison(foundation: Foundation) -> str:
    """The nine frequencies beside ANSYS's, and how much each mode moves the four seats."""
    nine = len(ANSYS)
    frequency = natural_frequencies(foundation)[:nine]
    shapes = {f"{label} [1/√kg]": foundation.B[k, :nine] for k, label in enumerate(foundation.labels)}
    columns = {
        "mode": range(1, nine + 1),
        "here [Hz]": frequency,
        "ANSYS [Hz]": ANSYS,
        "apart [%]": [f"{100 * (f / a - 1):+.2f}" for f, a in zip(frequency, ANSYS, strict=True)],
    }
    return table({**columns, **shapes})


def momentum_of(solid: Solid) -> Array:
    """Momentum along X and Y of the coordinates that `compute` reduces the solid to, (2, n)."""
    return momentum(solid, ritz_modes(solid)[1])


def write(foundation: Foundation, carried: Array) -> None:
    for name, frequency in GRIDS.items():
        save_frf(foundation.frf(frequency), FOLDER / name)
    save_foundation(foundation, TRUTH)
    title = "Momentum along X and along Y of each coordinate of truth.npz at unit velocity [sqrt(kg)]"
    np.savetxt(MOMENTUM, carried.T, fmt="%.12e", delimiter="\t", header=title)


def differences(foundation: Foundation) -> dict[str, float]:
    """How far what is stored is from what is computed: the worst relative difference of any entry on any line.

    A set on another grid, or a model of another size, counts as infinitely far.
    """
    worst = {}
    for name, frequency in GRIDS.items():
        stored = load_frf(FOLDER / name)
        same = stored.frequency.shape == frequency.shape and np.allclose(stored.frequency, frequency, rtol=1e-9)
        H = foundation.frf(frequency).H
        worst[name] = float((np.abs(stored.H - H) / np.abs(H)).max()) if same else np.inf
    truth = load_foundation(TRUTH)
    pairs = [(getattr(truth, key), getattr(foundation, key)) for key in "MCKB"]
    same = all(a.shape == b.shape for a, b in pairs)
    worst[TRUTH.name] = max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs) if same else np.inf
    return worst


def momentum_difference(carried: Array) -> float:
    """The worst difference of the stored momenta from these, as a part of the largest."""
    return float(np.abs(np.loadtxt(MOMENTUM).T - carried).max() / np.abs(carried).max())


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare instead of writing; exit code 1 if they differ")
    check = parser.parse_args(arguments).check
    solid = foundation_solid()
    foundation, carried = compute(solid), momentum_of(solid)
    print(comparison(foundation))
    if not check:
        write(foundation, carried)
        print(f"\nWritten: {', '.join(GRIDS)}, {TRUTH.name} and {MOMENTUM.name}")
        return 0
    apart = {**differences(foundation), MOMENTUM.name: momentum_difference(carried)}
    print("\n" + table({"stored": list(apart), "worst relative difference": list(apart.values())}))
    return 0 if max(apart.values()) <= TOLERANCE else 1


if __name__ == "__main__":
    sys.exit(main())
