"""Figures of what there is, before it moves: the foundation cut and shaken, the machine, a gyroscope."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from numpy.typing import ArrayLike, NDArray

from rbfound.plots import BLACK, BLUE, GREEN, ORANGE, RED, VIEW, Body, body_on, styled
from rbfound.solid import Solid, surface

# corners of a brick that an edge joins, in the order of skfem's MeshHex
EDGES = np.array(
    [(0, 1), (0, 2), (0, 3), (1, 4), (1, 5), (2, 4), (2, 6), (3, 5), (3, 6), (4, 7), (5, 7), (6, 7)], dtype=np.intp
)
SHADES = ("#c9d6e2", "#e8b65c")


@styled
def machine(
    bodies: Sequence[Body],
    arrows: Mapping[str, tuple[ArrayLike, ArrayLike]],
    held: ArrayLike = (),
    springs: Sequence[str] = (),
) -> None:
    """Bodies with the forces on them and the places where they are held, seen as by `rbfound.plots.solids.body`.

    Parameters
    ----------
    bodies : sheer ones are drawn so that what stands inside is seen
    arrows : name to (point (3,) [m], direction (3,)), drawn a tenth of the picture long
    held : (k, 3) [m] points with a triangle below them
    springs : marks of the bodies that get the sign of a spring, as "seat 1"
    """
    # sheer faces over each other have so many shades that a finer picture would be a third of its page's weight
    _, ax = plt.subplots(figsize=(7.2, 5.0), dpi=105)
    for body, color in zip(sorted(bodies, key=lambda body: body.sheer), SHADES[::-1][-len(bodies) :], strict=True):
        body_on(ax, body.points, np.repeat(body.faces, 2, axis=1), color)
        if body.sheer:
            ax.collections[-1].set_alpha(0.3)
    everything = np.vstack([body.points for body in bodies])
    reach = 0.1 * np.linalg.norm(np.ptp(everything, axis=0))
    for name, (point, direction) in arrows.items():
        along = np.asarray(direction, dtype=float)
        foot, head, text = (np.asarray(point) + f * reach * along for f in (0.0, 1.0, 1.25))
        foot, head, text = (VIEW[:2] @ p for p in (foot, head, text))
        ax.annotate("", head, foot, arrowprops={"arrowstyle": "-|>", "color": RED, "lw": 2})
        ax.text(*text, name, ha="center", va="center", color=BLACK, bbox={"fc": "white", "ec": "none", "pad": 1})
    for point in np.reshape(held, (-1, 3)):
        ax.plot(*(VIEW[:2] @ point), "^", color=BLACK, markersize=9, zorder=5)
    marked = {label: body.points[place] for body in bodies for label, place in body.marks.items()}
    for label in springs:
        _spring(ax, VIEW[:2] @ marked[label], float(0.35 * reach))
    plt.show()


def _spring(ax: Axes, at: NDArray[np.float64], size: float) -> None:
    """A small zigzag with its middle at a point."""
    zigzag = np.array([0, 0, 1, -1, 1, -1, 0, 0]) / 3
    ax.plot(at[0] + size * zigzag, at[1] + size * np.linspace(-1, 1, 8), color=BLACK, lw=1.8, zorder=6)


@styled
def cut(solid: Solid) -> None:
    """The elements that the plane x = 0 cuts, and how: z to the right, y up, each cut element a polygon."""
    # a plane through the very nodes would cut elements on both its sides, or none
    corners = solid.mesh.p[:, solid.mesh.t[:8]] - np.array([1e-6, 0, 0])[:, None, None]
    x = corners[0]
    polygons = []
    for element in np.flatnonzero((x.min(axis=0) < 0) & (x.max(axis=0) > 0)):
        a, b = (corners[:, EDGES[:, end], element] for end in (0, 1))
        crossed = a[0] * b[0] < 0
        a, b = a[:, crossed], b[:, crossed]
        _, y, z = a + (b - a) * a[0] / (a[0] - b[0])
        turn = np.argsort(np.arctan2(y - y.mean(), z - z.mean()))
        polygons.append(1e3 * np.column_stack([z, y])[turn])
    _, ax = plt.subplots(figsize=(7.2, 3.9))
    ax.add_collection(PolyCollection(polygons, facecolors="#c9d6e2", edgecolors="#7a8896", linewidths=0.4))
    for k, place in enumerate(_seats(solid)):
        ax.plot(*(1e3 * place[[2, 1]]), "P", color=RED, markersize=8)
        ax.annotate(f"seat {k + 1}", 1e3 * place[[2, 1]], (0, 20), textcoords="offset points", ha="center")
    ax.axhline(1e3 * _seats(solid)[0][1], color=BLACK, lw=0.9, ls="-.", zorder=3)
    ax.axhline(0, color=BLACK, lw=2)
    ax.autoscale_view()
    ax.set(xlabel="z [mm]", ylabel="y [mm]", aspect="equal")
    ax.grid(False)
    plt.show()


def _seats(solid: Solid) -> NDArray[np.float64]:
    """Middles of the seats [m], (seats / 2, 3)."""
    nodes = solid.mesh.doflocs.shape[1]
    return np.asarray(solid.B[0::2, :nodes] @ solid.mesh.doflocs.T)


@styled
def meshes(solids: Mapping[str, Solid]) -> None:
    """The same body in several meshes, side by side."""
    _, axes = plt.subplots(1, len(solids), figsize=(4.1 * len(solids), 3.3), squeeze=False)
    for ax, (name, solid) in zip(axes[0], solids.items(), strict=True):
        body_on(ax, *surface(solid))
        ax.collections[0].set(linewidth=0.5, edgecolor=BLACK)
        ax.set_title(f"{name}: {solid.mesh.nelements} elements")
    plt.show()


@styled
def gyroscope(tilt: float = 0.45) -> None:
    """Coordinates of a spinning disk with its angular momenta, and why a tilting disk answers across (equation 19)."""
    _, (left, right) = plt.subplots(1, 2, figsize=(8.2, 3.6), width_ratios=(1.15, 1))
    x, y, z = np.array([-0.62, -0.5]), np.array([0.0, 1.0]), np.array([1.0, -0.12])
    turn = np.pi * np.linspace(0, 2, 90)
    left.fill(*np.outer(x, 0.55 * np.cos(turn)) + np.outer(y, 0.55 * np.sin(turn)), fc="#c9d6e2", ec=BLACK, lw=1)
    for axis, name, moment in ((x, "X", "$I_d\\dot\\theta$"), (y, "Y", "$I_d\\dot\\psi$"), (z, "Z", "$I_p\\Omega$")):
        _arrow(left, 0 * axis, 1.25 * axis, BLACK, name)
        for end in (0.78, 0.9):  # two heads: a moment, to tell it from a displacement
            _arrow(left, 0.55 * axis, end * axis, BLUE if name != "Z" else RED)
        left.annotate(
            moment,
            0.85 * axis,
            (-34, 9) if name == "X" else (9, 9),
            textcoords="offset points",
            color=BLUE if name != "Z" else RED,
        )
    left.set_title("a disk and its angular momenta", fontsize=10)
    tip = np.array([np.cos(tilt), np.sin(tilt)])
    _arrow(right, np.zeros(2), np.array([1.0, 0.0]), RED, "$I_p\\Omega$, along Z")
    _arrow(right, np.zeros(2), tip, RED, "$I_p\\Omega$, tilted")
    _arrow(right, np.array([1.0, 0.0]), tip, GREEN)
    right.annotate("what the tip has gone:\n$I_p\\Omega\\;\\psi$, along X", (1.02, 0.23), color=GREEN, va="center")
    arc = np.linspace(0, tilt, 30)
    right.plot(0.45 * np.cos(arc), 0.45 * np.sin(arc), color=ORANGE, lw=1.6)
    right.annotate("ψ", (0.49, 0.08), fontsize=11)
    right.set_title("seen along Y: the axis tilts by ψ", fontsize=10)
    left.set(xlim=(-1.1, 1.6), ylim=(-1.0, 1.5))
    right.set(xlim=(-0.1, 1.75), ylim=(-0.35, 0.85))
    for ax in (left, right):
        ax.set_aspect("equal")
        ax.set_axis_off()
    plt.show()


def _arrow(ax: Axes, start: NDArray[np.float64], end: NDArray[np.float64], color: str, name: str = "") -> None:
    """An arrow, named beyond its head."""
    foot, head = ((float(x), float(y)) for x, y in (start, end))
    ax.annotate("", head, foot, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.6, "shrinkA": 0, "shrinkB": 0})
    if name:
        ax.annotate(name, head, (6, 4), textcoords="offset points", color=color)
