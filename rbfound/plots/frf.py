"""Figures of FRFs and what is read off them: curves, peaks, circles, the mode indicator, matrices; in hertz."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from numpy.typing import ArrayLike, NDArray

from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.measurement import Peaks, mode_indicator
from rbfound.plots.style import BLACK, LINES, each, legend_above, marked, styled
from rbfound.theory import Peak


@styled
def receptances(curves: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> None:
    """Magnitude and phase over frequency of named curves, each (frequency [Hz], H [m/N])."""
    _, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7.2, 4.6), height_ratios=(2, 1))
    for name, (frequency, H), color, line in each(curves):
        marker = "o" if len(np.atleast_1d(frequency)) <= 60 else ""
        top.semilogy(frequency, np.abs(H), line, color=color, label=name, marker=marker, markersize=4)
        bottom.plot(frequency, np.degrees(np.angle(np.asarray(H))), line, color=color, marker=marker, markersize=3)
    top.set_ylabel("receptance |H|  [m/N]")
    top.legend(ncols=2)
    highest = max(np.degrees(np.angle(np.asarray(H))).max() for _, H in curves.values())
    ticks = (-180, -90, 0, 90, 180) if highest > 1 else (-180, -135, -90, -45, 0)
    bottom.set(xlabel="frequency [Hz]", ylabel="phase [°]", ylim=(-190, ticks[-1] + 10), yticks=ticks)


@styled
def driving_point_set(frf: FRF, force: str) -> None:
    """The four responses to one force, as the thesis plots a set (figures 14-17)."""
    j = frf.seat(force)
    receptances({f"{label} from {force}": (frf.frequency, frf.H[:, i, j]) for i, label in enumerate(frf.labels)})


@styled
def frf_matrix(sets: Mapping[str, FRF]) -> None:
    """All receptances as a matrix of small plots: a row a response, a column a force."""
    labels = next(iter(sets.values())).labels
    axes = matrix_of_axes(labels)
    for name, frf, color, line in each(sets):
        look = {"color": color, "lw": 1.1, "marker": "o" if len(frf.frequency) <= 60 else "", "markersize": 2.5}
        for (i, j), ax in np.ndenumerate(axes):
            ax.semilogy(frf.frequency, np.abs(frf.H[:, i, j]), line, label=name, **look)
    legend_above(axes[0, 0], len(sets))


def matrix_of_axes(labels: Sequence[str]) -> NDArray[np.object_]:
    """Axes for an FRF matrix: a row a response, a column a force."""
    n = len(labels)
    figure, axes = plt.subplots(n, n, sharex=True, sharey=True, figsize=(7.6, 6.4), squeeze=False)
    for (i, j), ax in np.ndenumerate(axes):
        ax.set_title(f"{labels[i]} from {labels[j]}", fontsize=8.5, pad=2)
    figure.supxlabel("frequency [Hz]", fontsize=9.5)
    figure.supylabel("receptance |H|  [m/N]", fontsize=9.5)
    return np.asarray(axes)


@styled
def half_power(frequency: ArrayLike, magnitude: ArrayLike, peaks: Mapping[str, Peak], width: float = 2.5) -> None:
    """A peak with its half-power points, `width` bandwidths of the first one to either side."""
    frequency, magnitude = np.asarray(frequency), np.asarray(magnitude)
    _, ax = plt.subplots()
    first = next(iter(peaks.values()))
    reach = width * (first.high - first.low)
    near = np.abs(frequency - first.frequency) <= reach
    ax.plot(frequency[near], magnitude[near], "o-", color=BLACK, markersize=4, lw=0.7, label="lines")
    for name, peak, color, line in each(peaks):
        level = peak.height / np.sqrt(2)
        ax.plot([peak.low, peak.high], [level, level], line, color=color, marker="|", markersize=12, label=name)
        ax.plot(peak.frequency, peak.height, "^", color=color, markersize=7)
    ax.set(xlabel="frequency [Hz]", ylabel="receptance |H|  [m/N]")
    ax.set_ylim(0, 1.1 * max(peak.height for peak in peaks.values()))
    ax.legend()


@styled
def circle(curves: Mapping[str, ArrayLike]) -> None:
    """Receptances in the complex plane, where one mode draws a circle."""
    _, ax = plt.subplots(figsize=(5.2, 4.2))
    for name, H, color, line in each(curves):
        ax.plot(np.real(H), np.imag(H), line, color=color, label=name)
    ax.set(xlabel="Re H  [m/N]", ylabel="Im H  [m/N]", aspect="equal")
    ax.ticklabel_format(scilimits=(-2, 2))
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


@styled
def over_time(time: ArrayLike, curves: Mapping[str, ArrayLike]) -> None:
    """Displacements over time."""
    _, ax = plt.subplots(figsize=(7.2, 2.9))
    for name, x, color, line in each(curves):
        ax.plot(time, x, line, color=color, label=name)
    ax.set(xlabel="time [s]", ylabel="displacement [m]")
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(curves))


@styled
def indicator(frf: FRF, peaks: Peaks) -> None:
    """The mode indicator's singular values, with the peaks that were picked."""
    _, ax = plt.subplots()
    values = mode_indicator(frf)
    for k, (color, line) in zip(range(values.shape[1]), LINES, strict=False):
        ax.semilogy(frf.frequency, values[:, k], line, color=color, label=f"singular value {k + 1}")
    for frequency in peaks.frequency:
        marked([ax], {f"{frequency:.0f}": float(frequency)})
    ax.set(xlabel="frequency [Hz]", ylabel="singular value of H  [m/N]")
    ax.legend(ncols=2, fontsize=8)


@styled
def matrices(foundation: Foundation) -> None:
    """M, C and K as coloured tables: red is positive, blue negative, the number tells both."""
    _, axes = plt.subplots(1, 3, figsize=(8.6, 3.1))
    for ax, name, unit in zip(axes, "MCK", ("kg", "N s/m", "N/m"), strict=True):
        matrix_on(ax, getattr(foundation, name), foundation.labels, f"{name}  [{unit}]")


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
