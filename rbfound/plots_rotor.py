"""Figures of the chapters on the rigid rotor, transmitted forces, unbalance and the rotor's inverse problem."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from rbfound.orbits import path
from rbfound.plots_style import BLACK, BLUE, LINES, RED, styled
from rbfound.rigid import RigidRotor
from rbfound.rotor import Bearing, Rotor
from rbfound.units import rpm

Orbit = tuple[complex, complex]


@styled
def rigid_on_supports(rotor: RigidRotor) -> None:
    """A rigid rotor seen from the side in its x plane: centre of mass, coordinates, springs, the distances a and b."""
    a, b = rotor.a, rotor.b
    span = a + b
    _, ax = plt.subplots(figsize=(7.2, 2.9))
    tilt = 0.12
    ax.plot([-1.25 * a, 1.25 * b], [0, 0], ls="-.", color="#888888", lw=0.8)
    turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    half, thick, up = 0.3 * span, 0.07 * span, np.array([0.0, 0.06 * span])
    for length, height, color in ((0.62 * span, 0.015 * span, "#dfe6ec"), (half, thick, "#c9d6e2")):
        box = np.array([[-length, -height], [length, -height], [length, height], [-length, height]])
        ax.add_patch(plt.Polygon(box @ turn.T + up, fc=color, ec=BLACK, lw=1))
    ax.plot(*up, "o", color=RED, markersize=7)
    for z, name, spring in ((-a, "a", "$k_{x1}$"), (b, "b", "$k_{x2}$")):
        top = up[1] + z * np.tan(tilt) - 0.015 * span
        zigzag = np.array([0, 0, 1, -1, 1, -1, 1, 0, 0]) * 0.02 * span
        ax.plot(z + zigzag, np.linspace(top, -0.3 * span, 9), color=BLACK, lw=1.2)
        ax.plot([z - 0.05 * span, z + 0.05 * span], [-0.3 * span] * 2, color=BLACK, lw=2.5)
        ax.annotate(spring, (z, -0.16 * span), (12, 0), textcoords="offset points")
        ax.annotate("", (0, -0.24 * span), (z, -0.24 * span), arrowprops={"arrowstyle": "<->", "lw": 0.9})
        ax.annotate(name, (z / 2, -0.24 * span), (0, 3), textcoords="offset points", ha="center")
    ax.annotate("", up, (0, 0), arrowprops={"arrowstyle": "->", "color": RED, "lw": 1.6})
    ax.annotate("x", (0, 0.02 * span), (5, -2), textcoords="offset points", color=RED)
    ax.annotate("ψ", (0.36 * span, 0.02 * span), color=BLUE)
    arc = np.linspace(0, tilt, 20)
    ax.plot(0.34 * span * np.cos(arc), up[1] * 0 + 0.34 * span * np.sin(arc) + up[1] * 0.2, color=BLUE, lw=1.4)
    ax.set_aspect("equal")
    ax.set_axis_off()
    plt.show()


@styled
def orbits(panels: Mapping[str, Mapping[str, Orbit]], *, unit: str = "relative", scale: float = 1.0) -> None:
    """Orbits (x, y complex) side by side: dot at the start of a turn, arrow in the sense of motion. Rotation is anti-
    clockwise, X to Y."""
    _, axes = plt.subplots(1, len(panels), figsize=(min(9.6, 2.5 * len(panels) + 0.6), 3.0), squeeze=False)
    for ax, (title, curves) in zip(axes[0], panels.items(), strict=True):
        for (name, (x, y)), (color, line) in zip(curves.items(), LINES, strict=False):
            _orbit_on(ax, scale * x, scale * y, name, color, line)
        ax.set(title=title, aspect="equal", xlabel=f"x  [{unit}]")
        ax.margins(0.15)
        ax.set_adjustable("datalim")
    axes[0, 0].set_ylabel(f"y  [{unit}]")
    axes[0, 0].figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    plt.show()


def _orbit_on(ax: Axes, x: complex, y: complex, name: str, color: str, line: str) -> None:
    px, py = path(x, y)
    ax.plot(px, py, line, color=color, label=name)
    ax.plot(px[0], py[0], "o", color=color, markersize=5)
    along = {"arrowstyle": "-|>", "color": color, "lw": 1.4}
    ax.annotate("", (px[26], py[26]), (px[22], py[22]), arrowprops=along)


@styled
def amplitude_and_phase(
    curves: Mapping[str, tuple[ArrayLike, ArrayLike]],
    *,
    xlabel: str = "frequency [Hz]",
    ylabel: str = "",
    marks: Mapping[str, float] | None = None,
) -> None:
    """Size (logarithmic) and phase of named complex curves, each (x, values); thin lines at marked places."""
    _, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7.2, 4.6), height_ratios=(2, 1))
    for (name, (x, values)), (color, line) in zip(curves.items(), LINES, strict=False):
        values = np.asarray(values)
        phase = np.unwrap(np.angle(values))
        top.semilogy(x, np.abs(values), line, color=color, label=name)
        bottom.plot(x, np.degrees(phase), line, color=color)
    for name, place in (marks or {}).items():
        for ax in (top, bottom):
            ax.axvline(place, color=BLACK, lw=0.7, ls=":")
        top.annotate(name, (place, 1), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=8)
    top.set_ylabel(ylabel)
    top.legend()
    bottom.set(xlabel=xlabel, ylabel="phase [°]")
    bottom.yaxis.set_major_locator(plt.MultipleLocator(90))
    plt.show()


@styled
def over_speed(
    curves: Mapping[str, tuple[ArrayLike, ArrayLike]], *, ylabel: str, marks: Mapping[str, float] | None = None
) -> None:
    """Sizes of named curves over speed, each (speeds [rad/s], values), with thin lines at marked speeds [rad/s]."""
    figure, ax = plt.subplots(figsize=(7.2, 3.5))
    for (name, (speeds, values)), (color, line) in zip(curves.items(), LINES, strict=False):
        ax.semilogy(rpm(speeds), np.abs(values), line, color=color, label=name)
    for name, speed in (marks or {}).items():
        ax.axvline(rpm(speed), color=BLACK, lw=0.7, ls=":")
        ax.annotate(name, (rpm(speed), 1), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=8)
    ax.set(xlabel="speed [rev/min]", ylabel=ylabel)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    plt.show()


@styled
def rotors(panels: Mapping[str, tuple[Rotor, Mapping[float, Bearing]]]) -> None:
    """Rotors under each other, to one scale: triangles where the bearings stand, a dot for each disk."""
    _, axes = plt.subplots(len(panels), 1, sharex=True, figsize=(7.2, 1.0 + 1.15 * len(panels)), squeeze=False)
    for ax, (title, (rotor, bearings)) in zip(axes[:, 0], panels.items(), strict=True):
        ends = 1e3 * rotor.shaft.ends
        for left, right, diameter in zip(ends[:-1], ends[1:], rotor.shaft.diameter, strict=True):
            ax.add_patch(
                plt.Rectangle((left, -500 * diameter), right - left, 1000 * diameter, fc="#c9d6e2", ec=BLACK, lw=0.9)
            )
        for z in rotor.disks:
            ax.plot(1e3 * z, 0, "o", color=RED, markersize=9)
        for z in bearings:
            ax.plot(1e3 * z, -75, "^", color=BLACK, markersize=8)
        ax.set(xlim=(-20, 1060), ylim=(-95, 70), yticks=(), aspect="equal")
        ax.set_title(title, loc="left", fontsize=9)
        ax.grid(False)
    axes[-1, 0].set_xlabel("z [mm]")
    plt.show()


@styled
def directions(names: Sequence[str], sizes: ArrayLike, rows: NDArray[np.float64]) -> None:
    """Singular values [-] on the left; on the right what each direction does to the parameters, a row a direction."""
    sizes = np.asarray(sizes, dtype=float)
    _, (left, right) = plt.subplots(1, 2, figsize=(8.6, 0.34 * len(sizes) + 1.4), width_ratios=(1, 2))
    left.barh(range(len(sizes)), sizes, color=BLUE)
    left.set(xscale="log", xlim=(1e-4, 10), xlabel="singular value [-]", ylabel="direction")
    left.set_yticks(range(len(sizes)), [str(k + 1) for k in range(len(sizes))])
    left.invert_yaxis()
    # a direction has no sign: its largest part is drawn positive
    signs = np.sign(rows[np.arange(len(rows)), np.abs(rows).argmax(axis=1)])
    drawn = rows * signs[:, None]
    right.imshow(drawn, cmap="RdBu_r", vmin=-1.4, vmax=1.4, aspect="auto")
    for (i, j), value in np.ndenumerate(drawn):
        if abs(value) >= 0.15:
            right.text(j, i, f"{value:+.1f}", ha="center", va="center", fontsize=7.5)
    right.set_xticks(range(len(names)), names, rotation=35, ha="right")
    right.set_yticks(range(len(sizes)), [str(k + 1) for k in range(len(sizes))])
    right.grid(False)
    left.set_title("no bar: zero", fontsize=9)
    right.set_title("parts of the direction", fontsize=9)
    plt.show()
