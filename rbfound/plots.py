"""Figures of FRFs, matrices, rotors and Campbell diagrams. Each function draws a new figure, or into `ax`.

Frequencies are in hertz and speeds in revolutions per minute on the axes.
"""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from numpy.typing import ArrayLike, NDArray

from rbfound.coupling import Machine
from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.peaks import Peaks, mode_indicator
from rbfound.plots_style import BLACK, BLUE, LINES, RED, SKY, styled
from rbfound.rotor import Bearing, Rotor
from rbfound.sdof import Peak
from rbfound.system import Modes
from rbfound.units import hertz, rpm
from rbfound.whirl import Campbell


@styled
def receptances(curves: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> None:
    """Magnitude and phase over frequency of named curves, each (frequency [Hz], H [m/N])."""
    _, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7.2, 4.6), height_ratios=(2, 1))
    for (name, (frequency, H)), (color, line) in zip(curves.items(), LINES, strict=False):
        marker = "o" if len(np.atleast_1d(frequency)) <= 60 else ""
        top.semilogy(frequency, np.abs(H), line, color=color, label=name, marker=marker, markersize=4)
        bottom.plot(frequency, np.degrees(np.angle(np.asarray(H))), line, color=color, marker=marker, markersize=3)
    top.set_ylabel("receptance |H|  [m/N]")
    top.legend(ncols=2)
    highest = max(np.degrees(np.angle(np.asarray(H))).max() for _, H in curves.values())
    ticks = (-180, -90, 0, 90, 180) if highest > 1 else (-180, -135, -90, -45, 0)
    bottom.set(xlabel="frequency [Hz]", ylabel="phase [°]", ylim=(-190, ticks[-1] + 10), yticks=ticks)
    plt.show()


@styled
def driving_point_set(frf: FRF, force: str) -> None:
    """The four responses to one force, as the thesis plots a set (figures 14-17)."""
    j = frf.seat(force)
    receptances({f"{label} from {force}": (frf.frequency, frf.H[:, i, j]) for i, label in enumerate(frf.labels)})


@styled
def frf_matrix(sets: Mapping[str, FRF]) -> None:
    """All receptances as a matrix of small plots: a row a response, a column a force."""
    labels = next(iter(sets.values())).labels
    n = len(labels)
    figure, axes = plt.subplots(n, n, sharex=True, sharey=True, figsize=(7.6, 6.4), squeeze=False)
    for (name, frf), (color, line) in zip(sets.items(), LINES, strict=False):
        for i, j in np.ndindex(n, n):
            marker = "o" if len(frf.frequency) <= 60 else ""
            axes[i, j].semilogy(
                frf.frequency,
                np.abs(frf.H[:, i, j]),
                line,
                color=color,
                lw=1.1,
                marker=marker,
                markersize=2.5,
                label=name,
            )
    for i, j in np.ndindex(n, n):
        axes[i, j].set_title(f"{labels[i]} from {labels[j]}", fontsize=8.5, pad=2)
    figure.supxlabel("frequency [Hz]", fontsize=9.5)
    figure.supylabel("receptance |H|  [m/N]", fontsize=9.5)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=len(sets))
    plt.show()


@styled
def half_power(frequency: ArrayLike, magnitude: ArrayLike, peaks: Mapping[str, Peak], width: float = 2.5) -> None:
    """A peak with its half-power points, `width` bandwidths of the first one to either side."""
    frequency, magnitude = np.asarray(frequency), np.asarray(magnitude)
    _, ax = plt.subplots()
    first = next(iter(peaks.values()))
    reach = width * (first.high - first.low)
    near = np.abs(frequency - first.frequency) <= reach
    ax.plot(frequency[near], magnitude[near], "o-", color=BLACK, markersize=4, lw=0.7, label="lines")
    for (name, peak), (color, line) in zip(peaks.items(), LINES, strict=False):
        level = peak.height / np.sqrt(2)
        ax.plot([peak.low, peak.high], [level, level], line, color=color, marker="|", markersize=12, label=name)
        ax.plot(peak.frequency, peak.height, "^", color=color, markersize=7)
    ax.set(xlabel="frequency [Hz]", ylabel="receptance |H|  [m/N]")
    ax.set_ylim(0, 1.1 * max(peak.height for peak in peaks.values()))
    ax.legend()
    plt.show()


@styled
def circle(curves: Mapping[str, ArrayLike]) -> None:
    """Receptances in the complex plane, where one mode draws a circle."""
    _, ax = plt.subplots(figsize=(5.2, 4.2))
    for (name, H), (color, line) in zip(curves.items(), LINES, strict=False):
        ax.plot(np.real(H), np.imag(H), line, color=color, label=name)
    ax.set(xlabel="Re H  [m/N]", ylabel="Im H  [m/N]", aspect="equal")
    ax.ticklabel_format(scilimits=(-2, 2))
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    plt.show()


@styled
def over_time(time: ArrayLike, curves: Mapping[str, ArrayLike]) -> None:
    """Displacements over time."""
    _, ax = plt.subplots(figsize=(7.2, 2.9))
    for (name, x), (color, line) in zip(curves.items(), LINES, strict=False):
        ax.plot(time, x, line, color=color, label=name)
    ax.set(xlabel="time [s]", ylabel="displacement [m]")
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(curves))
    plt.show()


@styled
def indicator(frf: FRF, peaks: Peaks) -> None:
    """The mode indicator's singular values, with the peaks that were picked."""
    _, ax = plt.subplots()
    values = mode_indicator(frf)
    for k, (color, line) in zip(range(values.shape[1]), LINES, strict=False):
        ax.semilogy(frf.frequency, values[:, k], line, color=color, label=f"singular value {k + 1}")
    for frequency in peaks.frequency:
        ax.axvline(frequency, color=BLACK, lw=0.8, ls=":")
        ax.annotate(
            f"{frequency:.0f}", (frequency, 1), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=8
        )
    ax.set(xlabel="frequency [Hz]", ylabel="singular value of H  [m/N]")
    ax.legend(ncols=2, fontsize=8)
    plt.show()


@styled
def matrices(foundation: Foundation) -> None:
    """M, C and K as coloured tables: red is positive, blue negative, the number tells both."""
    _, axes = plt.subplots(1, 3, figsize=(8.6, 3.1))
    for ax, name, unit in zip(axes, "MCK", ("kg", "N s/m", "N/m"), strict=True):
        matrix_on(ax, getattr(foundation, name), foundation.labels, f"{name}  [{unit}]")
    plt.show()


def matrix_on(ax: Axes, matrix: NDArray[np.float64], labels: Sequence[str], title: str) -> None:
    """One matrix as a coloured table."""
    size = np.abs(matrix).max() or 1.0
    exponent = 3 * int(np.floor(np.log10(size) / 3))
    ax.imshow(matrix, cmap="RdBu_r", norm=TwoSlopeNorm(0, -1.6 * size, 1.6 * size))
    for (i, j), value in np.ndenumerate(matrix):
        ax.text(j, i, f"{value / 10**exponent:.3g}", ha="center", va="center", fontsize=8)
    ax.set(xticks=range(len(labels)), yticks=range(len(labels)), xticklabels=labels, yticklabels=labels)
    ax.set_title(title if exponent == 0 else f"{title}  × $10^{{{exponent}}}$")
    ax.grid(False)
    ax.tick_params(length=0)


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
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    ax.set(ylabel="natural frequency [Hz]", ylim=(0, limit), xticks=range(len(columns)), xticklabels=list(columns))
    ax.grid(axis="x", visible=False)
    plt.show()


@styled
def rotor(rotor: Rotor, bearings: Mapping[float, Bearing]) -> None:
    """The shaft to scale, its disks, and where the bearings hold it."""
    _, ax = plt.subplots(figsize=(7.6, 2.5))
    rotor_on(ax, rotor, bearings)
    plt.show()


def rotor_on(ax: Axes, rotor: Rotor, bearings: Mapping[float, Bearing]) -> None:
    """A rotor to scale into given axes."""
    ends = 1e3 * rotor.shaft.ends
    for left, right, diameter in zip(ends[:-1], ends[1:], rotor.shaft.diameter, strict=True):
        ax.add_patch(
            plt.Rectangle((left, -500 * diameter), right - left, 1000 * diameter, fc="#c9d6e2", ec=BLACK, lw=1)
        )
    top = 500 * max(rotor.shaft.diameter)
    for z, disk in rotor.disks.items():
        ax.plot(1e3 * z, 0, "o", color=RED, markersize=13)
        ax.annotate(f"{disk.mass:g} kg", (1e3 * z, 0), (0, 11), textcoords="offset points", ha="center")
    for z in bearings:
        ax.plot(1e3 * z, -top - 16, "^", color=BLACK, markersize=13)
        ax.annotate(f"{1e3 * z:g}", (1e3 * z, -top - 30), (0, -10), textcoords="offset points", ha="center", va="top")
    ax.axhline(0, color=BLACK, lw=0.7, ls="-.")
    ax.set(xlabel="z [mm]", ylabel="[mm]", xlim=(-30, ends[-1] + 40), ylim=(-top - 115, top + 25), aspect="equal")
    ax.grid(False)


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
    plt.show()


@styled
def campbell(diagram: Campbell, highest: float | None = None) -> None:
    """Campbell diagram: natural frequencies over speed, the line of rotation, and the critical speeds."""
    _, ax = plt.subplots(figsize=(7.2, 4.4))
    campbell_on(ax, diagram, highest)
    plt.show()


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
    plt.show()


@styled
def unbalance(answers: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> None:
    """Amplitudes over speed of named unbalance responses, each (speeds [rad/s], displacement [m])."""
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    for (name, (speed, x)), (color, line) in zip(answers.items(), LINES, strict=False):
        ax.semilogy(rpm(speed), 1e6 * np.abs(x), line, color=color, label=name)
    ax.set(xlabel="speed [rev/min]", ylabel="amplitude [µm]")
    ax.legend()
    plt.show()


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
    plt.show()
