"""Figures of the chapters in three dimensions: bodies, sections and meshes, and what their models say."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike, NDArray

from rbfound.campbell_diagram import Campbell
from rbfound.plots.machines import campbell_on
from rbfound.plots.style import BLACK, BLUE, LINES, RED, styled

# The viewer of solids stands at the far end of the shaft, to the left and above: rows right, up, towards the viewer.
TURN, TILT = np.radians(52), np.radians(22)
ACROSS = np.array([np.cos(TURN), 0.0, np.sin(TURN)])
LEVEL = np.array([-np.sin(TURN), 0.0, np.cos(TURN)])
UPRIGHT = np.array([0.0, 1.0, 0.0])
VIEW = np.array([ACROSS, np.cos(TILT) * UPRIGHT - np.sin(TILT) * LEVEL, np.cos(TILT) * LEVEL + np.sin(TILT) * UPRIGHT])


def body_on(ax: Axes, points: NDArray[np.float64], faces: NDArray[np.intp], color: str = "#c9d6e2") -> None:
    """A solid's surface into given axes: points (p, 3) [m], faces (f, 8) as `solid.surface` gives them."""
    rings = (points @ VIEW.T)[faces]
    rings = rings[np.argsort(rings[:, :, 2].mean(axis=1))]  # far faces first, near ones over them
    normals = np.cross(rings[:, 4] - rings[:, 0], rings[:, 6] - rings[:, 2])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    light = 0.55 + 0.45 * np.abs(normals @ np.array([-0.45, 0.75, 0.48]))
    shades = np.clip(np.outer(light, to_rgb(color)), 0, 1)
    ax.add_collection(PolyCollection(list(rings[:, :, :2]), facecolors=shades, edgecolors="#55555566", linewidths=0.2))
    ax.autoscale_view()
    ax.set_aspect("equal")
    ax.set_axis_off()


@styled
def body(points: NDArray[np.float64], faces: NDArray[np.intp]) -> None:
    """A solid's surface, seen from the far end of the shaft, from the left and above."""
    _, ax = plt.subplots(figsize=(7.2, 5.0))
    body_on(ax, points, faces)
    corner = np.array([points[:, 0].min() - 0.1, 0.0, points[:, 2].mean() - 0.2])
    for name, along in zip("XYZ", 0.15 * np.eye(3), strict=True):
        line, text = (np.array([corner, corner + f * along]) @ VIEW[:2].T for f in (1.0, 1.3))
        ax.plot(*line.T, color=BLACK, lw=1.2)
        ax.text(*text[1], name, ha="center", va="center")


@styled
def section(points: NDArray[np.float64], quads: NDArray[np.intp]) -> None:
    """The mesh of half a section: points (2, p), z and r [m], quads (4, q)."""
    _, ax = plt.subplots(figsize=(7.6, 1.6))
    rings = np.moveaxis(1e3 * points[:, quads], 0, 2).swapaxes(0, 1)
    ax.add_collection(PolyCollection(list(rings), facecolors="#dfe8f0", edgecolors=BLACK, linewidths=0.4))
    ax.axhline(0, color=BLACK, lw=1, ls="-.")
    ax.set(xlabel="z [mm]", ylabel="r [mm]", aspect="equal")
    ax.autoscale_view()
    ax.grid(False)


@styled
def centre_lines(lines: Mapping[str, tuple[ArrayLike, ArrayLike, ArrayLike]]) -> None:
    """How axes bend: a panel for each name, (z [m], frequency [Hz], shapes (n, modes))."""
    _, axes = plt.subplots(1, len(lines), sharey=True, figsize=(8.4, 2.9), squeeze=False)
    for ax, (name, (z, frequency, shapes)) in zip(axes[0], lines.items(), strict=True):
        for f, shape, (color, line) in zip(np.asarray(frequency), np.asarray(shapes).T, LINES, strict=False):
            ax.plot(z, shape, line, color=color, label=f"{f:.0f} Hz")
        ax.set(xlabel="z [m]", title=name)
        ax.legend(fontsize=8, loc="upper center", ncols=2)
    axes[0, 0].set(ylabel="displacement, relative", ylim=(-1.1, 1.7))


@styled
def moved(
    before: Sequence[float], after: Sequence[float], pairs: Sequence[tuple[float, float]], names: Sequence[str]
) -> None:
    """Frequencies [Hz] of two models beside each other, thick and joined where one became another."""
    _, ax = plt.subplots(figsize=(7.2, 4.2))
    for column, frequencies in enumerate((before, after)):
        changed = {pair[column] for pair in pairs}
        for f in {*frequencies, *changed}:
            thick = f in changed
            color, line = (RED, "-") if thick else (BLUE, "-")
            ax.plot([column - 0.3, column + 0.3], [f, f], line, color=color, lw=2.8 if thick else 1.0)
    for start, end in pairs:
        ax.annotate(
            "", (0.69, end), (0.31, start), arrowprops={"arrowstyle": "->", "color": RED, "lw": 1.2, "ls": "--"}
        )
        ax.text(0.5, (start + end) / 2, f"{start:g} → {end:g}", ha="center", fontsize=8.5, backgroundcolor="white")
    ax.set(ylabel="natural frequency [Hz]", xticks=(0, 1), xticklabels=names, ylim=(-20, None))
    ax.grid(axis="x", visible=False)


@styled
def campbells(diagrams: Mapping[str, Campbell], highest: float | None = None) -> None:
    """Campbell diagrams side by side."""
    figure, axes = plt.subplots(1, len(diagrams), sharey=True, figsize=(9.2, 4.4), squeeze=False)
    for ax, (name, diagram) in zip(axes[0], diagrams.items(), strict=True):
        campbell_on(ax, diagram, highest, legend=False)
        ax.set_title(name)
        ax.label_outer()
    handles = {label: handle for ax in axes[0] for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles, loc="outside upper center", ncols=5, fontsize=8.5)


@styled
def cost(coordinates: ArrayLike, seconds: ArrayLike, apart: ArrayLike, labels: Sequence[str]) -> None:
    """Seconds over coordinates of some meshes; the labels say which, and how far [%] their frequencies are apart."""
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    ax.loglog(coordinates, seconds, "o", color=BLUE, markersize=8)
    for n, s, away, label in zip(np.asarray(coordinates), np.asarray(seconds), np.asarray(apart), labels, strict=True):
        ax.annotate(
            f"{label}: {away:.1f} %",
            (n, s),
            (9, 6 if "2 x 2" in label else -11),
            textcoords="offset points",
            fontsize=8.5,
        )
    ax.set(xlabel="coordinates", ylabel="time [s]")
    ax.margins(x=0.6, y=0.3)
