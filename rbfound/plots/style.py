"""The one style of every figure: colours, lines, and a decorator that draws in it.

Curves differ in line style as well as in colour (the palette of Okabe and Ito), so that they can be told apart in
greyscale.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

P = ParamSpec("P")
V = TypeVar("V")

BLUE, ORANGE, GREEN, RED, PURPLE, SKY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9"
BLACK, GREY = "#222222", "#b5b5b5"
LINES = ((BLUE, "-"), (RED, "--"), (GREEN, "-."), (BLACK, ":"), (ORANGE, "-"), (SKY, "--"), (PURPLE, "-."))
MARKERS = ("o", "s", "^", "D", "v", "x", "P")
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
    """Draw in the book's style without touching the reader's own settings, and show the figure."""

    @wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> None:
        with plt.rc_context(STYLE):
            draw(*args, **kwargs)
            plt.show()

    return in_style


def each(curves: Mapping[str, V]) -> Iterator[tuple[str, V, str, str]]:
    """Each named thing with the colour and the line that it gets."""
    return ((name, values, *look) for (name, values), look in zip(curves.items(), LINES, strict=False))


def legend_above(ax: Axes, columns: int, **look: Any) -> None:
    """The legend of some axes above the whole figure."""
    ax.figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=columns, **look)


def legend_on(ax: Axes, columns: int, **look: Any) -> None:
    """The legend of some axes on top of them."""
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns, **look)


def marked(axes: Sequence[Axes], places: Mapping[str, float]) -> None:
    """A thin line at each named place, with the name above the first axes."""
    for name, place in places.items():
        for ax in axes:
            ax.axvline(place, color=BLACK, lw=0.7, ls=":")
        axes[0].annotate(name, (place, 1), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=8)
