"""Still pictures of something that moves, drawn from the values that it begins with."""

from collections.abc import Mapping, Sequence
from io import BytesIO
from textwrap import fill
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from rbfound.live import Live, axis, figure, line
from rbfound.plots import STYLE

# Of each theme: ink, paper, grid and the colours of the styles, as rbfound/live/sliders.css has them.
THEMES: Mapping[str, tuple[str, ...]] = {
    "light": ("#1d2126", "#ffffff", "#e6e8eb", "#0067a5", "#b84300", "#00795a", "#9a3f78", "#6b5d00", "#6a6f76"),
    "dark": ("#e7e9ec", "#14181e", "#2a3038", "#6cb6ee", "#ff9b54", "#45c79f", "#e59bcb", "#d8c65a", "#a2a8af"),
}
DASHES = ("-", (0, (5, 2.5)), (0, (1.2, 1.6)), (0, (6, 2, 1.2, 1.6)), (0, (3, 1.5)), (0, (9, 2.5)))
# The most columns, width of the picture and height of a row, alone and among others [inch], dots per inch, letters in a
# title, names in a row of the legend: the letters have one size beside the text of a screen and of a phone.
WIDTHS = {"wide": (3, 7.6, 3.9, 2.8, 150, 44, 5), "narrow": (1, 3.7, 3.1, 2.8, 200, 36, 2)}


def still(thing: Live, width: str, theme: str) -> bytes:
    """A WebP picture for one of the WIDTHS and THEMES."""
    told = figures(thing.values)
    ink, paper, grid, *colors = THEMES[theme]
    most, across, alone, row, dpi, letters, names = WIDTHS[width]
    columns = min(len(told), most)
    rows = -(-len(told) // columns)
    own = {"text.color": ink, "axes.labelcolor": ink, "axes.edgecolor": ink, "xtick.color": ink, "ytick.color": ink}
    own |= {"figure.facecolor": paper, "savefig.facecolor": paper, "axes.facecolor": paper, "grid.color": grid}
    with matplotlib.rc_context({**STYLE, **own}):
        picture = Figure(figsize=(across, alone if len(told) == 1 else row * rows), layout="constrained")
        for k, one in enumerate(told):
            draw(picture.add_subplot(rows, columns, k + 1), one, colors, letters, names if columns == 1 else 3)
        out = BytesIO()
        picture.savefig(out, format="webp", dpi=dpi, pil_kwargs={"quality": 80, "method": 6})
    return out.getvalue()


def words(thing: Live) -> str:
    """What stands for the picture where it cannot be seen."""
    values = thing.values
    titles = "; ".join(f"{one['title']}, {one['y']['label']} over {one['x']['label']}" for one in figures(values))
    if "controls" not in values:
        return f"{titles}. Lines stand where the peaks were picked."
    settings = ", ".join(
        f"{c['label']} {c['value']:.4g} {c['unit']}" if c["kind"] == "slider" else f"{c['label']}: {c['value']}"
        for c in values["controls"]
    )
    return f"{titles}. Drawn for {settings}."


def figures(values: dict[str, Any]) -> list[dict[str, Any]]:
    """What a thing begins with, as figures; of a peak picker the driving points, and where the peaks stand."""
    if "controls" in values:
        return list(values["result"]["figures"])
    labels, count = values["scene"]["labels"], values["scene"]["lines"]
    numbers = np.frombuffer(values["data"], "<f4")
    frequency, parts = numbers[:count], numbers[count:].view("<c8").reshape(len(labels), len(labels), count)
    sizes = [np.abs(parts[k, k]) for k in range(len(labels))]
    ends = min(size[size > 0].min() for size in sizes), max(size.max() for size in sizes)
    lines = [line(label, frequency, size, k) for k, (label, size) in enumerate(zip(labels, sizes, strict=True))]
    lines += [
        line("", [peak["frequency"]] * 2, ends, labels.index(peak["seat"]), thin=True) for peak in values["peaks"]
    ]
    x = axis("frequency [Hz]", float(frequency[0]), float(frequency[-1]))
    return [figure("Driving points of the four seats", x, axis("|H| [m/N]", log=True), lines)]


def draw(ax: Any, told: dict[str, Any], colors: Sequence[str], letters: int, names: int) -> None:
    """One figure into given axes, with so many letters in a line of its title and names in a row of its legend."""
    known: set[str] = set()
    for curve in told["lines"]:
        style = curve["style"] % len(colors)
        label = curve["label"] if curve["label"] not in known else ""
        known.add(curve["label"])
        ax.plot(
            curve["x"], curve["y"], color=colors[style], ls=DASHES[style], lw=0.9 if curve["thin"] else 1.6, label=label
        )
    for mark in told["marks"]:
        ax.plot(mark["x"], mark["y"], "o", mfc=ax.get_facecolor(), mec=colors[mark["style"]], ms=5)
        if mark["label"]:
            ax.annotate(mark["label"], (mark["x"], mark["y"]), (6, 4), textcoords="offset points", fontsize=8)
    for name in "xy":
        axis = told[name]
        getattr(ax, f"set_{name}scale")("log" if axis["log"] else "linear")
        getattr(ax, f"set_{name}label")(axis["label"])
        ends = [value for value in (axis["low"], axis["high"]) if value is not None]
        if len(ends) == 2:
            getattr(ax, f"set_{name}lim")(*ends)
    ax.set_title(fill(told["title"], letters))
    if told["equal"]:
        ax.set_aspect("equal", adjustable="datalim")
    if known - {""}:
        below = ax.transAxes + ScaledTranslation(0, -0.4, ax.figure.dpi_scale_trans)
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0), bbox_transform=below, ncols=names)
