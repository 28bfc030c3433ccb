"""The README's picture: the whole path, drawn by the same lines as the book's first page.

python tools/overview.py book/static/overview.png
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import rbfound as rb
from rbfound import plots


def main(target: str) -> None:
    """Draw the picture into a file."""
    frf = rb.load_frf(Path(__file__).parent.parent / "data" / "foundation" / "fine")
    foundation = rb.pmsm(frf, [160, 480, 626, 344])
    rotor, bearings = rb.thesis.rotor(), rb.thesis.bearings()
    machine = rb.mount(rotor, bearings, on=foundation)
    diagram = rb.campbell(machine, rb.from_rpm(np.linspace(0, 30000, 31)))
    plots.overview(frf, foundation, rotor, bearings, diagram)
    plt.savefig(target, dpi=130, bbox_inches="tight", facecolor="white", metadata={"Software": None})


if __name__ == "__main__":
    main(sys.argv[1])
