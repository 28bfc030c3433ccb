"""The still picture of something that moves, drawn from the values that it begins with."""

from io import BytesIO
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from rbfound.live import Live
from rbfound.plots import STYLE
from rbfound.sketch import axis, figure, line

COLORS = ("#0067a5", "#b84300", "#00795a", "#9a3f78", "#6b5d00", "#6a6f76")
DASHES = ("-", (0, (5, 2.5)), (0, (1.2, 1.6)), (0, (6, 2, 1.2, 1.6)), (0, (3, 1.5)), (0, (9, 2.5)))


def still(name: str, thing: Live) -> tuple[bytes, str]:
    """A WebP picture and the words that stand for it."""
    values = thing.values
    told = values["result"]["figures"] if "controls" in values else picked(values)
    with matplotlib.rc_context(STYLE):
        columns = min(len(told), 2)
        rows = -(-len(told) // columns)
        figure = Figure(figsize=(7.6, (3.9 if columns == 1 else 2.9) * rows), layout="constrained")
        for k, one in enumerate(told):
            draw(figure.add_subplot(rows, columns, k + 1), one)
        out = BytesIO()
        figure.savefig(out, format="webp", dpi=130, pil_kwargs={"quality": 80, "method": 6})
    titles = "; ".join(f"{one['title']}, {one['y']['label']} over {one['x']['label']}" for one in told)
    if "controls" not in values:
        return out.getvalue(), f"{titles}. Lines stand where the peaks were picked."
    settings = ", ".join(
        f"{c['label']} {c['value']:.4g} {c['unit']}" if c["kind"] == "slider" else f"{c['label']}: {c['value']}"
        for c in values["controls"]
    )
    return out.getvalue(), f"{titles}. Drawn for {settings}."


def picked(values: dict[str, Any]) -> list[dict[str, Any]]:
    """Figures of a peak picker: the driving points, and where the peaks stand."""
    labels, count = values["scene"]["labels"], values["scene"]["lines"]
    numbers = np.frombuffer(values["data"], "<f4")
    frequency, parts = numbers[:count], numbers[count:].view("<c8").reshape(len(labels), len(labels), count)
    out = []
    for k, label in enumerate(labels):
        size = np.abs(parts[k, k])
        ends = size[size > 0].min(), size.max()
        lines = [line("", frequency, size)]
        lines += [
            line("peak", [peak["frequency"]] * 2, ends, 1, thin=True)
            for peak in values["peaks"]
            if peak["seat"] == label
        ]
        x = axis("frequency [Hz]", float(frequency[0]), float(frequency[-1]))
        out.append(figure(f"Driving point {label}", x, axis("|H| [m/N]", log=True), lines))
    return out


def draw(ax: Any, told: dict[str, Any]) -> None:
    """One figure into given axes."""
    known: set[str] = set()
    for curve in told["lines"]:
        style = curve["style"] % len(COLORS)
        label = curve["label"] if curve["label"] not in known else ""
        known.add(curve["label"])
        ax.plot(
            curve["x"], curve["y"], color=COLORS[style], ls=DASHES[style], lw=0.9 if curve["thin"] else 1.6, label=label
        )
    for mark in told["marks"]:
        ax.plot(mark["x"], mark["y"], "o", mfc="white", mec=COLORS[mark["style"]], ms=5)
        if mark["label"]:
            ax.annotate(mark["label"], (mark["x"], mark["y"]), (6, 4), textcoords="offset points", fontsize=8)
    for name in "xy":
        axis = told[name]
        getattr(ax, f"set_{name}scale")("log" if axis["log"] else "linear")
        getattr(ax, f"set_{name}label")(axis["label"])
        ends = [value for value in (axis["low"], axis["high"]) if value is not None]
        if len(ends) == 2:
            getattr(ax, f"set_{name}lim")(*ends)
    ax.set_title(told["title"])
    if told["equal"]:
        ax.set_aspect("equal", adjustable="datalim")
    if known - {""}:
        ax.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=3, frameon=False)
