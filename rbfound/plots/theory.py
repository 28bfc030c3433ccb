"""Figures of the theory chapters: chains of masses, kinds of FRF, reduction, sums of modes, and cost."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from rbfound.frf import FRF
from rbfound.plots.frf import matrix_of_axes
from rbfound.plots.style import BLACK, BLUE, GREEN, GREY, LINES, MARKERS, RED, each, legend_above, styled
from rbfound.units import hertz


@styled
def growth(curves: Mapping[str, Mapping[int, float]], size: str) -> None:
    """CPU seconds over size for each name, with the slope of a straight line through the logarithms."""
    _, ax = plt.subplots(figsize=(7.2, 3.4))
    for (name, spent, color, line), marker in zip(each(curves), MARKERS, strict=False):
        n, seconds = np.array(list(spent)), np.array(list(spent.values()))
        slope, at_one = np.polyfit(np.log(n), np.log(seconds), 1)
        ax.loglog(n, seconds, marker, color=color, ms=6)
        ax.loglog(n, np.exp(at_one) * n**slope, line, color=color, lw=1.2, label=f"{name}: slope {slope:.1f}")
    ax.set(xlabel=size, ylabel="CPU time [s]")
    ax.legend()


@styled
def winding(points: ArrayLike, turns: ArrayLike, poles: ArrayLike) -> None:
    """Half of a contour about poles [rad/s], and the phase of det D along it: half a turn for each pole within.

    Parameters
    ----------
    points : (p,) complex [rad/s] along the upper half, from right to left
    turns : (p,) det D / |det D| there
    poles : (m,) complex [rad/s]
    """
    z, s = (np.asarray(values) for values in (points, poles))
    _, (left, right) = plt.subplots(1, 2, figsize=(7.6, 3.2))
    seen = (s.imag > 0) & (s.imag < 1.25 * z.imag.max()) & (np.abs(s.real) < np.abs(z.real).max())
    left.plot(hertz(z.real), hertz(z.imag), ".-", color=BLUE, ms=3, lw=1, label="contour")
    left.plot(hertz(s[seen].real), hertz(s[seen].imag), "x", color=RED, ms=6, label="poles")
    left.set(xlabel="real part / 2π [Hz]", ylabel="imaginary part / 2π [Hz]")
    left.legend(loc="upper right")
    phase = np.unwrap(np.angle(np.asarray(turns)))
    right.plot((phase - phase[0]) / np.pi, ".-", color=BLUE, ms=3, lw=1)
    right.set(xlabel="point on the contour", ylabel="phase of det D [half turns]")


@styled
def guesses(errors: Mapping[str, ArrayLike]) -> None:
    """Relative errors of poles by number, a line for each name."""
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    for (name, values, color, line), marker in zip(each(errors), MARKERS, strict=False):
        y = np.maximum(np.asarray(values, dtype=float), 1e-16)
        ax.semilogy(np.arange(1, len(y) + 1), y, marker + line, color=color, ms=5, lw=1.2, label=name)
    ax.set(xlabel="number of the mode", ylabel="relative error of its pole [-]")
    ax.legend()


@styled
def lines_where_needed(lines: ArrayLike, response: ArrayLike) -> None:
    """A response [m] over speed [rev/min] with the lines on which it was computed, marked on it and below."""
    x, y = np.asarray(lines), np.abs(np.asarray(response))
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    ax.semilogy(x, y, ".-", color=BLUE, ms=4, lw=0.8, label=f"{len(x)} lines")
    ax.plot(x, np.full(len(x), y.min() / 3), "|", color=RED, ms=7, label="where they lie")
    ax.set(xlabel="speed [rev/min]", ylabel="amplitude at the disk [m]")
    ax.legend()


# Colour, line and shade of the three kinds of FRF: `rbfound.FRF.kind`.
KINDS = {
    "direct": (BLUE, "-", "#dce9f3"),
    "cross-coupling": (RED, "--", "#f9e3d6"),
    "cross-talk": (GREEN, "-.", "#dff0e9"),
}


@styled
def chain_drawing(masses: Sequence[str], links: Sequence[str]) -> None:
    """Named masses in a row between walls; each link is a spring over a damper, an empty name none (and no wall)."""
    n = len(masses)
    _, ax = plt.subplots(figsize=(7.2, 1.9))
    for k, name in enumerate(masses):
        left = 2 * k + 1.0
        ax.add_patch(plt.Rectangle((left, 0.1), 1, 0.8, fc="#c9d6e2", ec=BLACK))
        ax.text(left + 0.5, 0.5, name, ha="center", va="center")
        ax.annotate("", (left + 1.0, 1.25), (left + 0.5, 1.25), arrowprops={"arrowstyle": "->", "color": BLACK})
        ax.plot([left + 0.5] * 2, [0.95, 1.3], color=BLACK, lw=0.8)
        ax.text(left + 0.75, 1.32, f"$x_{k + 1}$", ha="center", va="bottom")
    for k, name in enumerate(links):
        if name:
            _link(ax, 2.0 * k, name)
    for x, tied in ((0.0, links[0]), (2.0 * n + 1, links[-1])):
        if tied:
            ax.plot([x, x], [-0.05, 1.1], color=BLACK, lw=3)
    ax.set(xlim=(-0.2, 2 * n + 1.2), ylim=(-0.25, 1.65))
    ax.axis("off")


def _link(ax: Axes, x: float, name: str) -> None:
    spring = np.array([0, 0, 1, -1, 1, -1, 1, -1, 0, 0])
    ax.plot(x + np.array([0, 0.2, *np.linspace(0.26, 0.74, 6), 0.8, 1]), 0.72 + 0.09 * spring, color=BLACK, lw=1.1)
    ax.plot([x, x + 0.55], [0.25, 0.25], color=BLACK, lw=1.1)
    ax.plot([x + 0.55] * 2, [0.17, 0.33], color=BLACK, lw=1.6)
    ax.plot([x + 0.7, x + 0.4, x + 0.4, x + 0.7], [0.37, 0.37, 0.13, 0.13], color=BLACK, lw=1.1)
    ax.plot([x + 0.7, x + 0.7], [0.13, 0.37], color=BLACK, lw=1.1)
    ax.plot([x + 0.7, x + 1], [0.25, 0.25], color=BLACK, lw=1.1)
    ax.text(x + 0.5, 0.9, f"$k_{name}$", ha="center", va="bottom", fontsize=9)
    ax.text(x + 0.5, 0.06, f"$c_{name}$", ha="center", va="top", fontsize=9)


@styled
def chain_shapes(shapes: ArrayLike, curves: ArrayLike, omega: ArrayLike, count: int = 4) -> None:
    """The first shapes of a chain, (n, modes), as dots at the masses, and closed forms (points, modes) as lines."""
    shapes, curves = np.asarray(shapes), np.asarray(curves)
    _, axes = plt.subplots(1, count, sharey=True, figsize=(8.2, 2.4))
    place, fine = np.arange(len(shapes) + 2), np.linspace(0, len(shapes) + 1, len(curves))
    for k, ax in enumerate(axes):
        ax.plot(fine, curves[:, k], color=RED, ls="--", lw=1.2, label="closed form")
        ax.plot(place, [0, *shapes[:, k], 0], "o", color=BLUE, markersize=5, label="computed")
        ax.axhline(0, color=BLACK, lw=0.6)
        ax.set_title(f"mode {k + 1}, {hertz(np.asarray(omega)[k]):.1f} Hz", fontsize=9)
        ax.set(xlabel="mass", xticks=place[:: max(len(place) // 5, 1)])
    axes[0].set_ylabel("shape  [1/√kg]")
    axes[0].legend(fontsize=8, loc="lower center")


@styled
def frf_kinds(frf: FRF) -> None:
    """The FRF matrix with its direct, cross-coupling and cross-talk parts in lines and shades of their own."""
    axes, kinds = matrix_of_axes(frf.labels), frf.kinds()
    for (i, j), ax in np.ndenumerate(axes):
        color, line, shade = KINDS[str(kinds[i, j])]
        ax.set_facecolor(shade)
        ax.semilogy(frf.frequency, np.abs(frf.H[:, i, j]), line, color=color, lw=1.3, label=str(kinds[i, j]))
    handles = {ax.get_lines()[0].get_label(): ax.get_lines()[0] for ax in axes.ravel()}
    axes[0, 0].figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=3)


@styled
def errors(
    x: ArrayLike, curves: Mapping[str, ArrayLike], *, xlabel: str, marks: ArrayLike = (), floor: float = 0.0
) -> None:
    """Relative errors, drawn in per cent, over frequency or over a number; few points get markers.

    Parameters
    ----------
    marks : where dotted lines stand
    floor : [%] errors below it are drawn there
    """
    x = np.asarray(x, dtype=float)
    _, ax = plt.subplots(figsize=(7.2, 3.9))
    for (name, curve, color, line), marker in zip(each(curves), MARKERS, strict=False):
        curve = np.maximum(100 * np.asarray(curve, dtype=float), floor)
        few = {"marker": marker, "markersize": 5} if len(x) <= 20 else {}
        ax.semilogy(x, curve, line, color=color, label=name, **few)
    for mark in np.asarray(marks):
        ax.axvline(mark, color=BLACK, lw=0.8, ls=":", zorder=0)
    ax.set(xlabel=xlabel, ylabel="error [%]")
    if len(x) <= 20:
        ax.set_xticks(x)
    legend_above(ax, 4)


@styled
def errors_for_seconds(panels: Mapping[str, Mapping[str, tuple[Sequence[int], ArrayLike, ArrayLike]]]) -> None:
    """Relative errors, drawn in per cent, over CPU time: a panel a body, a curve a way, (coordinates, [s], errors)."""
    _, axes = plt.subplots(1, len(panels), figsize=(8.4, 3.6), squeeze=False)
    for ax, (body, curves) in zip(axes[0], panels.items(), strict=True):
        for (name, (counts, seconds, error), color, line), marker in zip(each(curves), MARKERS, strict=False):
            percent = 100 * np.asarray(error)
            ax.loglog(seconds, percent, line, color=color, label=name, marker=marker, markersize=5)
            for count, x, y in zip(counts, np.asarray(seconds), percent, strict=True):
                ax.annotate(str(count), (x, y), (5, 3), textcoords="offset points", fontsize=7.5)
        ax.set(title=body, xlabel="CPU time to the basis [s]")
        ax.margins(x=0.15, y=0.1)
    axes[0, 0].set_ylabel("largest error [%]")
    legend_above(axes[0, 0], 3)


@styled
def contributions(frequency: ArrayLike, terms: ArrayLike, omega: ArrayLike) -> None:
    """One FRF, the share of each mode (lines, modes) in it, and what the modes beyond the drawn ones add."""
    terms, shown = np.asarray(terms), 4
    _, ax = plt.subplots(figsize=(7.2, 4.2))
    ax.semilogy(frequency, np.abs(terms.sum(axis=1)), color=GREY, lw=5, label="all modes")
    for k, (color, line) in zip(range(shown), LINES, strict=False):
        name = f"mode {k + 1}, {hertz(np.asarray(omega)[k]):.0f} Hz"
        ax.semilogy(frequency, np.abs(terms[:, k]), line, color=color, lw=1.3, label=name)
    rest = np.abs(terms[:, shown:].sum(axis=1))
    ax.semilogy(frequency, rest, color=BLACK, lw=0.9, marker=".", markevery=25, label="the others together")
    ax.set(xlabel="frequency [Hz]", ylabel="receptance |H|  [m/N]")
    legend_above(ax, 3)


@styled
def zeros_and_poles(
    frequency: ArrayLike, panels: Mapping[str, tuple[ArrayLike, ArrayLike]], resonances: ArrayLike
) -> None:
    """FRFs one under the other, each (H, its anti-resonances [Hz]): triangles below mark these, dotted lines poles."""
    frequency = np.asarray(frequency, dtype=float)
    figure, axes = plt.subplots(len(panels), 1, sharex=True, figsize=(7.2, 0.6 + 1.75 * len(panels)), squeeze=False)
    for ax, (name, (H, zeros), color, line) in zip(axes[:, 0], each(panels), strict=False):
        size = np.abs(np.asarray(H))
        ax.semilogy(frequency, size, line, color=color, lw=1.5, label="|H|")
        inside = [z for z in np.asarray(zeros) if frequency[0] <= z <= frequency[-1]]
        ax.plot(inside, [size.min() / 2] * len(inside), "^", color=BLACK, markersize=7, label="anti-resonance")
        for k, f in enumerate(np.asarray(resonances)):
            if frequency[0] <= f <= frequency[-1]:
                ax.axvline(f, color=BLACK, lw=0.8, ls=":", zorder=0, label="resonance" if k == 0 else None)
        ax.set_title(name, loc="left", fontsize=9)
        ax.set_ylim(size.min() / 4, size.max() * 2)
    axes[-1, 0].set(xlabel="frequency [Hz]", xlim=(frequency[0], frequency[-1]))
    figure.supylabel("receptance |H|  [m/N]", fontsize=9.5)
    legend_above(axes[0, 0], 3)


@styled
def phasors(shapes: Mapping[str, NDArray[np.complex128]]) -> None:
    """Shapes in the complex plane, one arrow a mass, each turned so that its largest entry is 1."""
    _, axes = plt.subplots(1, len(shapes), figsize=(2.5 * len(shapes), 3.4), squeeze=False, sharey=True)
    for ax, (name, shape) in zip(axes[0], shapes.items(), strict=True):
        shape = shape / shape[np.abs(shape).argmax()]
        for k, (z, (color, line)) in enumerate(zip(shape, LINES, strict=False)):
            ax.plot(
                [0, z.real], [0, z.imag], line, color=color, marker=MARKERS[k], markevery=[1], label=f"mass {k + 1}"
            )
        ax.set_title(name, fontsize=9)
        ax.set(xlim=(-1.2, 1.2), ylim=(-1.2, 1.2), aspect="equal", xlabel="real part [-]")
    axes[0, 0].set_ylabel("imaginary part [-]")
    legend_above(axes[0, 0], 4)
