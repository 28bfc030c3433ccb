"""The README's picture, drawn by the same lines as the book's first page, and the card that links are shown with.

python tools/overview.py book/static/overview.png book/static/social.png
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import rbfound as rb
from rbfound import plots


def overview(target: str) -> None:
    """The whole path in one picture."""
    frf = rb.load_frf(Path(__file__).parent.parent / "data" / "foundation" / "fine")
    foundation = rb.pmsm(frf, [160, 480, 626, 344])
    rotor, bearings = rb.thesis.rotor(), rb.thesis.bearings()
    machine = rb.mount(rotor, bearings, on=foundation)
    diagram = rb.campbell(machine, rb.from_rpm(np.linspace(0, 30000, 31)))
    plots.overview(frf, foundation, rotor, bearings, diagram)
    plt.savefig(target, dpi=130, bbox_inches="tight", facecolor="white", metadata={"Software": None})


def card(picture: str, target: str) -> None:
    """The book's title over that picture, 1200 by 630."""
    figure = plt.figure(figsize=(12, 6.3), dpi=100, facecolor="white")
    figure.text(0.05, 0.86, "A rotor on its foundation", size=40, weight="bold", color="#14324f")
    figure.text(
        0.05, 0.775, "From frequency response functions to matrices to critical speeds", size=21, color="#444444"
    )
    axes = figure.add_axes((0.04, 0.03, 0.92, 0.70), anchor="S")
    axes.imshow(plt.imread(picture), interpolation="lanczos")
    axes.axis("off")
    figure.savefig(target, metadata={"Software": None})


if __name__ == "__main__":
    overview(sys.argv[1])
    card(*sys.argv[1:])
