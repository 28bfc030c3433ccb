"""Figures of rotors and machines: mode shapes, Campbell diagrams, orbits, unbalance response."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from rbfound.campbell_diagram import Campbell
from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.machine import Machine
from rbfound.plots.frf import matrix_on
from rbfound.plots.style import BLACK, BLUE, LINES, RED, SKY, each, legend_above, legend_on, marked, styled
from rbfound.rotor import Bearing, Rotor
from rbfound.system import Modes
from rbfound.theory import RigidRotor
from rbfound.unbalance import path
from rbfound.units import hertz, rpm


@styled
def ladder(columns: Mapping[str, tuple[ArrayLike, ArrayLike]], limit: float = 1250.0) -> None:
    """Natural frequencies [Hz] as rungs, a column a model: (frequency, the foundation's share of the energy)."""
    _, ax = plt.subplots(figsize=(7.2, 4.4))
    kinds = {False: (BLUE, "-", "mostly shaft"), True: (RED, "--", "mostly foundation")}
    for k, (frequencies, shares) in enumerate(columns.values()):
        for f, share in zip(np.asarray(frequencies), np.asarray(shares), strict=True):
            if f <= limit:
                color, line, _ = kinds[bool(share > 0.5)]
                ax.plot([k - 0.38, k + 0.38], [f, f], color=color, ls=line, lw=1.8)
    for color, line, name in kinds.values():
        ax.plot([], [], color=color, ls=line, label=name)
    legend_on(ax, 2)
    ax.set(ylabel="natural frequency [Hz]", ylim=(0, limit), xticks=range(len(columns)), xticklabels=list(columns))
    ax.grid(axis="x", visible=False)


@styled
def rotor(rotor: Rotor, bearings: Mapping[float, Bearing]) -> None:
    """The shaft to scale, its disks, and where the bearings hold it."""
    _, ax = plt.subplots(figsize=(7.6, 2.5))
    rotor_on(ax, rotor, bearings)


def rotor_on(ax: Axes, rotor: Rotor, bearings: Mapping[float, Bearing]) -> None:
    """A rotor to scale into given axes."""
    _shaft_on(ax, rotor)
    top = 500 * max(rotor.shaft.diameter)
    for z, disk in rotor.disks.items():
        ax.plot(1e3 * z, 0, "o", color=RED, markersize=13)
        ax.annotate(f"{disk.mass:g} kg", (1e3 * z, 0), (0, 11), textcoords="offset points", ha="center")
    for z in bearings:
        ax.plot(1e3 * z, -top - 16, "^", color=BLACK, markersize=13)
        ax.annotate(f"{1e3 * z:g}", (1e3 * z, -top - 30), (0, -10), textcoords="offset points", ha="center", va="top")
    ax.axhline(0, color=BLACK, lw=0.7, ls="-.")
    ax.set(xlabel="z [mm]", ylabel="[mm]", xlim=(-30, 1e3 * rotor.shaft.ends[-1] + 40))
    ax.set(ylim=(-top - 115, top + 25), aspect="equal")
    ax.grid(False)


def _shaft_on(ax: Axes, rotor: Rotor) -> None:
    """The segments of a shaft, in millimetres."""
    ends = 1e3 * rotor.shaft.ends
    for left, right, diameter in zip(ends[:-1], ends[1:], rotor.shaft.diameter, strict=True):
        box = plt.Rectangle((left, -500 * diameter), right - left, 1000 * diameter, fc="#c9d6e2", ec=BLACK, lw=1)
        ax.add_patch(box)


@styled
def mode_shapes(machine: Machine, modes: Modes, which: Sequence[int]) -> None:
    """Shapes of chosen modes along the shaft, at the instant of the largest displacement; squares are the seats."""
    figure, axes = plt.subplots(
        len(which), 1, sharex=True, figsize=(7.2, 0.5 + 1.25 * len(which)), squeeze=False, sharey=True
    )
    planes = machine.mesh.planes
    n = len(machine.mesh.M)
    places = list(machine.bearings)
    for ax, k in zip(axes[:, 0], which, strict=True):
        shape = modes.shapes[:, k]
        largest = np.concatenate([shape[plane] for plane in planes])
        turn = largest[np.abs(largest).argmax()]
        for plane, name, (color, line) in zip(planes, "xy", LINES, strict=False):
            ax.plot(machine.mesh.z, (shape[plane] / turn).real, line, color=color, label=f"shaft, {name}")
        if machine.foundation is not None and places:
            seats = (machine.foundation.B @ shape[n:] / turn).real
            ax.plot(places, seats[0::2], "s", color=BLUE, label="seats, x")
            ax.plot(places, seats[1::2], "s", mfc="white", color=RED, label="seats, y")
        ax.set_title(f"{modes.frequency[k]:.1f} Hz, damping {100 * modes.damping[k]:.2f} %", loc="left", fontsize=9)
        ax.set_ylim(-1.25, 1.25)
    axes[-1, 0].set_xlabel("z [m]")
    figure.supylabel("displacement, relative", fontsize=9.5)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=4)


@styled
def campbell(diagram: Campbell, highest: float | None = None) -> None:
    """Campbell diagram: natural frequencies over speed, the line of rotation, and the critical speeds."""
    _, ax = plt.subplots(figsize=(7.2, 4.4))
    campbell_on(ax, diagram, highest)


def campbell_on(ax: Axes, diagram: Campbell, highest: float | None = None, legend: bool = True) -> None:
    """A Campbell diagram into given axes."""
    speeds = rpm(diagram.speeds)
    kinds = {1: (RED, "--", "forward whirl"), -1: (BLUE, "-.", "backward whirl"), 0: (BLACK, "-", "in a plane")}
    named: set[int] = set()
    for b in range(diagram.frequency.shape[1]):
        # a branch is named by what it does on most of its way
        turn = np.nanmedian(diagram.whirl[:, b]) if np.isfinite(diagram.whirl[:, b]).any() else 0.0
        kind = int(np.sign(turn)) if abs(turn) > 0.1 else 0
        color, line, name = kinds[kind]
        ax.plot(speeds, diagram.frequency[:, b], line, color=color, label=None if kind in named else name)
        named.add(kind)
    ax.plot(speeds, hertz(diagram.speeds), color="#888888", lw=1, label="speed of rotation")
    critical = diagram.critical_speeds()
    if len(critical.speed):
        ax.plot(
            rpm(critical.speed), critical.frequency, "o", mfc="white", color=BLACK, label="critical speed", zorder=5
        )
    ax.set(xlabel="speed [rev/min]", ylabel="natural frequency [Hz]", xlim=(speeds[0], speeds[-1]), ylim=(0, highest))
    if legend:
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.13), ncols=5, fontsize=8, columnspacing=1.2)


@styled
def spread(samples: ArrayLike, marks: Mapping[str, ArrayLike], limit: float = 600.0) -> None:
    """Histogram of the natural frequencies of many samples (samples, modes), with marked frequencies [Hz]."""
    _, ax = plt.subplots(figsize=(7.2, 3.0))
    values = np.asarray(samples, dtype=float)
    bins = np.linspace(0, limit, 151)
    ax.hist(values[values > 0], bins=bins, color=SKY, label=f"{len(values)} roundings")
    for (name, frequencies), (color, line) in zip(marks.items(), (LINES[1], LINES[3]), strict=False):
        for k, f in enumerate(np.atleast_1d(np.asarray(frequencies, dtype=float))):
            ax.axvline(float(f), color=color, ls=line, lw=1.3, label=name if k == 0 else None)
    ax.set(xlabel="natural frequency [Hz]", ylabel="count", yscale="log", xlim=(0, limit))
    ax.legend(loc="upper right", fontsize=8)


@styled
def unbalance(answers: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> None:
    """Amplitudes over speed of named unbalance responses, each (speeds [rad/s], displacement [m])."""
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    for name, (speed, x), color, line in each(answers):
        ax.semilogy(rpm(speed), 1e6 * np.abs(x), line, color=color, label=name)
    ax.set(xlabel="speed [rev/min]", ylabel="amplitude [µm]")
    ax.legend()


@styled
def overview(
    frf: FRF, foundation: Foundation, rotor: Rotor, bearings: Mapping[float, Bearing], diagram: Campbell
) -> None:
    """The whole path in one picture: FRFs, stiffness matrix, rotor, Campbell diagram."""
    _, axes = plt.subplots(2, 2, figsize=(9.6, 6.2), width_ratios=(1.25, 1))
    (first, second), (third, fourth) = axes
    for j, (label, (color, line)) in enumerate(zip(frf.labels, LINES, strict=False)):
        first.semilogy(frf.frequency, np.abs(frf.H[:, j, j]), line, color=color, lw=1.3, label=label)
    first.plot([], [], ":", color=BLACK, lw=0.9, label="modes taken")
    for f in foundation.modes().frequency:
        first.axvline(f, color=BLACK, ls=":", lw=0.9)
    first.set(xlabel="frequency [Hz]", ylabel="driving points |H|  [m/N]")
    first.set_title("1  FRFs at the bearing seats", loc="left", pad=20)
    first.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.985), ncols=5, fontsize=8, columnspacing=1)
    matrix_on(second, foundation.K, foundation.labels, "2  stiffness matrix K  [N/m]")
    rotor_on(third, rotor, bearings)
    third.set_title("3  the rotor in its bearings, on the foundation", loc="left")
    campbell_on(fourth, diagram, highest=700, legend=False)
    fourth.set_title("4  natural frequencies and critical speeds", loc="left")


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


@styled
def orbits(panels: Mapping[str, Mapping[str, Orbit]], *, unit: str = "relative", scale: float = 1.0) -> None:
    """Orbits (x, y complex) side by side: dot at the start of a turn, arrow in the sense of motion. Rotation is anti-
    clockwise, X to Y."""
    _, axes = plt.subplots(1, len(panels), figsize=(min(9.6, 2.5 * len(panels) + 0.6), 3.0), squeeze=False)
    for ax, (title, curves) in zip(axes[0], panels.items(), strict=True):
        for name, (x, y), color, line in each(curves):
            _orbit_on(ax, scale * x, scale * y, name, color, line)
        ax.set(title=title, aspect="equal", xlabel=f"x  [{unit}]")
        ax.margins(0.15)
        ax.set_adjustable("datalim")
    axes[0, 0].set_ylabel(f"y  [{unit}]")
    legend_above(axes[0, 0], 4)


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
    for name, (x, values), color, line in each(curves):
        values = np.asarray(values)
        phase = np.unwrap(np.angle(values))
        top.semilogy(x, np.abs(values), line, color=color, label=name)
        bottom.plot(x, np.degrees(phase), line, color=color)
    marked([top, bottom], marks or {})
    top.set_ylabel(ylabel)
    top.legend()
    bottom.set(xlabel=xlabel, ylabel="phase [°]")
    bottom.yaxis.set_major_locator(plt.MultipleLocator(90))


@styled
def over_speed(
    curves: Mapping[str, tuple[ArrayLike, ArrayLike]], *, ylabel: str, marks: Mapping[str, float] | None = None
) -> None:
    """Sizes of named curves over speed, each (speeds [rad/s], values), with thin lines at marked speeds [rad/s]."""
    _, ax = plt.subplots(figsize=(7.2, 3.5))
    for name, (speeds, values), color, line in each(curves):
        ax.semilogy(rpm(speeds), np.abs(values), line, color=color, label=name)
    marked([ax], {name: float(rpm(speed)) for name, speed in (marks or {}).items()})
    ax.set(xlabel="speed [rev/min]", ylabel=ylabel)
    legend_above(ax, 3)


@styled
def rotors(panels: Mapping[str, tuple[Rotor, Mapping[float, Bearing]]]) -> None:
    """Rotors under each other, to one scale: triangles where the bearings stand, a dot for each disk."""
    _, axes = plt.subplots(len(panels), 1, sharex=True, figsize=(7.2, 1.0 + 1.15 * len(panels)), squeeze=False)
    for ax, (title, (rotor, bearings)) in zip(axes[:, 0], panels.items(), strict=True):
        _shaft_on(ax, rotor)
        for z in rotor.disks:
            ax.plot(1e3 * z, 0, "o", color=RED, markersize=9)
        for z in bearings:
            ax.plot(1e3 * z, -75, "^", color=BLACK, markersize=8)
        ax.set(xlim=(-20, 1060), ylim=(-95, 70), yticks=(), aspect="equal")
        ax.set_title(title, loc="left", fontsize=9)
        ax.grid(False)
    axes[-1, 0].set_xlabel("z [mm]")


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
