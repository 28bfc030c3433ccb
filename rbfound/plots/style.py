"""The one style of every figure: colours, lines, and a decorator that draws in it.

Curves differ in line style as well as in colour (the palette of Okabe and Ito), so that they can be told apart in
greyscale.
"""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import matplotlib.pyplot as plt

P = ParamSpec("P")

BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BLACK = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#CC79A7",
    "#56B4E9",
    "#222222",
)
LINES = ((BLUE, "-"), (RED, "--"), (GREEN, "-."), (BLACK, ":"), (ORANGE, "-"), (SKY, "--"), (PURPLE, "-."))
STYLE = {
    "figure.dpi": 140,
    "figure.figsize": (7.2, 3.6),
    "figure.constrained_layout.use": True,
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "savefig.facecolor": "white",
}


def styled(draw: Callable[P, None]) -> Callable[P, None]:
    """Draw in the book's style without touching the reader's own settings."""

    @wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> None:
        with plt.rc_context(STYLE):
            draw(*args, **kwargs)

    return in_style
