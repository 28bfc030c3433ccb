"""The picture that a link to the book is shown with: its title over the README's picture, 1200 by 630.

python tools/social.py book/static/overview.png book/static/social.png
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def main(picture: str, target: str) -> None:
    """Draw the card into a file."""
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
    main(*sys.argv[1:])
