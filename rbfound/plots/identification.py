"""Figures of identification: peaks, circles, stabilisation, poles, matrices, errors and their bars."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from rbfound.campbell_diagram import Campbell
from rbfound.frf import FRF
from rbfound.identification import CircleFit, ErrorBars, Residues, Stabilisation
from rbfound.measurement import mode_indicator
from rbfound.plots.machines import campbell_on
from rbfound.plots.style import (
    BLACK,
    BLUE,
    GREY,
    LINES,
    MARKERS,
    ORANGE,
    RED,
    SKY,
    each,
    legend_above,
    legend_on,
    styled,
)
from rbfound.units import from_hertz, hertz, rpm


@styled
def campbell_bands(diagram: Campbell, bars: ErrorBars, magnified: float = 1.0, highest: float | None = None) -> None:
    """A Campbell diagram with a band of two deviations either way about each branch, so many times magnified."""
    _, ax = plt.subplots(figsize=(7.2, 4.6))
    campbell_on(ax, diagram, highest, legend=False)
    for branch, deviation in zip(bars.frequency.T, bars.frequency_deviation.T, strict=True):
        half = 2 * magnified * deviation
        ax.fill_between(rpm(diagram.speeds), branch - half, branch + half, color=BLUE, alpha=0.22, lw=0)
    times = f", {magnified:g} times" if magnified != 1 else ""
    ax.fill_between([], [], [], color=BLUE, alpha=0.22, lw=0, label=f"two deviations{times}")
    legend_above(ax, 3, fontsize=8.5)


@styled
def errors_in_bars(frequency: ArrayLike, errors: Sequence[ArrayLike], level: float = 1.96) -> None:
    """Errors over their stated deviations: a column a coupled frequency [Hz], a dot a measurement."""
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    names = [f"{f:.0f}" for f in np.atleast_1d(np.asarray(frequency))]
    ax.axhspan(-level, level, color="#e6eef5", label="95 % of the errors should lie here")
    ax.axhline(0, color=BLACK, lw=0.8)
    for row in errors:
        row = np.asarray(row)
        within = np.abs(row) <= level
        ax.plot(np.flatnonzero(within), row[within], "o", color=BLUE, ms=3.5, alpha=0.7)
        ax.plot(np.flatnonzero(~within), row[~within], "x", color=RED, ms=6)
    ax.set_xticks(range(len(names)), names)
    ax.set(xlabel="natural frequency of the machine [Hz]", ylabel="error / deviation [-]", ylim=(-4.5, 4.5))
    ax.legend(loc="upper right")


@styled
def beside_reference(
    x: ArrayLike,
    reference: ArrayLike,
    curves: Mapping[str, ArrayLike],
    *,
    xlabel: str = "frequency [Hz]",
    ylabel: str = "receptance |H|  [m/N]",
) -> None:
    """Magnitudes of complex curves over one axis with the reference under them; below, the error of each [%]."""
    x, reference = np.asarray(x), np.asarray(reference)
    _, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7.2, 4.8), height_ratios=(3, 2))
    top.semilogy(x, np.abs(reference), color="#bbbbbb", lw=5, label="reference")
    for name, curve, color, line in each(curves):
        top.semilogy(x, np.abs(curve), line, color=color, lw=1.2, label=name)
        bottom.semilogy(x, 100 * np.abs(np.asarray(curve) / reference - 1), line, color=color, lw=1.0)
    top.set_ylabel(ylabel)
    bottom.set(xlabel=xlabel, ylabel="error [%]")
    legend_above(top, 4)


@styled
def passivity(frequency: ArrayLike, levels: Mapping[str, ArrayLike]) -> None:
    """The least energy that a foundation takes in, over frequency [Hz]: `rbfound.identification.passivity`. Grey is
    below zero."""
    _, ax = plt.subplots(figsize=(7.2, 3.4))
    markers = ("", "o", "x")
    lowest = min(float(np.min(values)) for values in levels.values())
    ax.axhspan(110 * lowest, 0, color="#eeeeee")
    ax.axhline(0, color=BLACK, lw=0.8)
    # the noisiest first, so that it hides nothing, and the lightest, so that it is another one without colour too
    shades = ((BLACK, "-"), (RED, ""), (SKY, ""))
    pairs = list(zip(levels.items(), shades, markers, strict=False))
    for (name, values), (color, line), marker in reversed(pairs):
        style = "None" if marker else line
        ax.plot(frequency, 100 * np.asarray(values), ls=style, marker=marker, markersize=3, color=color, label=name)
    ax.set(xlabel="frequency [Hz]", ylabel="least loss, part of |H| [%]")
    ax.margins(y=0.02)
    legend_above(ax, 3)


@styled
def price(names: Sequence[str], seconds: ArrayLike, errors: ArrayLike) -> None:
    """What each way costs [s] over how far off it ends [%]; one without any cost stands at a hundredth of a second."""
    _, ax = plt.subplots(figsize=(7.2, 3.4))
    cost = np.maximum(np.asarray(seconds, dtype=float), 0.01)
    ax.loglog(np.asarray(errors), cost, "o", color=BLUE, ms=7)
    for k, (name, x, y) in enumerate(zip(names, np.asarray(errors), cost, strict=True)):
        # neighbours one above, one below
        ax.annotate(name, (x, y), xytext=(7, 6 if k % 2 else -13), textcoords="offset points", fontsize=9)
    ax.set(xlabel="largest error of a natural frequency [%]", ylabel="CPU time to the foundation [s]")
    ax.margins(x=0.18, y=0.25)


@styled
def parts(frequency: ArrayLike, H: ArrayLike, fit: CircleFit, width: float = 3.0) -> None:
    """Real and imaginary part of a receptance [m/N], `width` half-power widths to either side of a fitted mode."""
    f, H = np.asarray(frequency, dtype=float), np.asarray(H)
    low, high = fit.half_power
    near = np.abs(f - fit.natural_frequency) <= width * (high - low)
    fine = np.linspace(f[near][0], f[near][-1], 400)
    curve = fit.mobility(fine) / (1j * from_hertz(fine))
    _, axes = plt.subplots(2, 1, sharex=True, figsize=(7.2, 4.6))
    for ax, part, name in zip(axes, (np.real, np.imag), ("Re H", "Im H"), strict=True):
        ax.plot(fine, part(curve), color=BLUE, label="fitted circle", zorder=3)
        ax.plot(f[near], part(H[near]), "o", color="#888888", markersize=3.5, label="lines")
        ax.axvline(fit.natural_frequency, color=RED, ls="--", lw=1.2, label="natural frequency")
        for k, edge in enumerate((low, high)):
            ax.axvline(edge, color=BLACK, ls=":", lw=1.0, label="half-power points" if k == 0 else None)
        ax.axhline(0, color=BLACK, lw=0.6)
        ax.set_ylabel(f"{name}  [m/N]")
    axes[0].legend(ncols=4, fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    axes[1].set_xlabel("frequency [Hz]")


@styled
def nyquist(frequency: ArrayLike, H: ArrayLike, fit: CircleFit) -> None:
    """The mobility [m/(N s)] of the fitted lines and some beside them, the circle, its diameter and quarter points."""
    f, H = np.asarray(frequency, dtype=float), np.asarray(H)
    first, last = fit.lines
    more = slice(max(first - 2 * (last - first), 0), last + 2 * (last - first))
    Y = 1j * np.asarray(from_hertz(f)) * H
    _, ax = plt.subplots(figsize=(7.6, 4.2))
    ax.plot(Y[more].real, Y[more].imag, "-", color="#999999", lw=0.9, marker=".", markersize=4, label="other lines")
    turn = fit.centre + fit.radius * np.exp(1j * np.linspace(0, 7, 400))
    ax.plot(turn.real, turn.imag, color=BLUE, label="fitted circle")
    used = Y[first:last]
    ax.plot(used.real, used.imag, "o", color=BLACK, markersize=4.5, label="lines of the fit")
    ends = np.array([fit.remainder, 2 * fit.centre - fit.remainder])
    ax.plot(ends.real, ends.imag, "--", color=RED, label="diameter at resonance")
    ax.plot(ends.real[1], ends.imag[1], "^", color=RED, markersize=8)
    points = fit.mobility(fit.half_power)
    ax.plot(points.real, points.imag, "s", color=ORANGE, mec=BLACK, markersize=7, label="half-power points")
    for at, edge in [*zip(points, fit.half_power, strict=True), (ends[1], float(hertz(fit.omega)))]:
        outwards = (at - fit.centre) / fit.radius
        ax.annotate(
            f"{edge:.1f} Hz",
            (at.real, at.imag),
            (9 * outwards.real, 14 * outwards.imag),
            textcoords="offset points",
            ha="center" if abs(outwards.real) < 0.5 else "left" if outwards.real > 0 else "right",
            va="center",
            fontsize=8.5,
        )
    ax.plot(0, 0, "+", color=BLACK, markersize=10)
    ax.set(xlabel="Re iωH  [m/(N s)]", ylabel="Im iωH  [m/(N s)]", aspect="equal")
    ax.margins(0.22, 0.14)
    ax.ticklabel_format(scilimits=(-2, 2))
    ax.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))


@styled
def stabilisation_chart(chart: Stabilisation, frf: FRF, picked: ArrayLike = ()) -> None:
    """Poles over the order that they come from, with the mode indicator behind; `picked` poles [rad/s] get a line.

    The more of a pole is stable, the darker and fuller its mark.
    """
    _, ax = plt.subplots(figsize=(7.6, 4.6))
    behind = ax.twinx()
    behind.semilogy(frf.frequency, mode_indicator(frf)[:, :2], color=GREY, lw=1.0)
    behind.set_ylabel("singular values of H  [m/N]", color="#777777")
    behind.grid(False)
    behind.set_zorder(0)
    ax.set_zorder(1)
    ax.patch.set_visible(False)
    frequency, damping, shape = chart.stable_frequency, chart.stable_damping, chart.stable_participation
    kinds = (
        ("new", ~frequency, {"marker": ".", "color": "#888888", "ms": 4}),
        ("frequency", frequency & ~damping & ~shape, {"marker": "o", "mec": BLUE, "mfc": "white", "ms": 5}),
        (
            "and damping or participation",
            frequency & (damping ^ shape),
            {"marker": "^", "mec": RED, "mfc": "white", "ms": 5.5},
        ),
        ("all three", chart.stable, {"marker": "o", "color": BLACK, "ms": 4.5}),
    )
    for name, which, look in kinds:
        ax.plot(chart.natural_frequency[which], chart.order[which], ls="", label=name, **look)
    for f in hertz(np.abs(np.asarray(picked))):
        ax.axvline(f, color=BLACK, lw=0.8, ls=":", zorder=0.5)
    low, high = frf.frequency[[0, -1]]
    ax.set(xlabel="frequency [Hz]", ylabel="order of the polynomial", xlim=(low, high), yticks=chart.orders[::2])
    ax.grid(axis="y", visible=False)
    ax.legend(title="stable in", loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, fontsize=8.5)


@styled
def polynomials(frequency: ArrayLike, bases: Mapping[str, ArrayLike]) -> None:
    """The first polynomials of some bases over frequency [Hz], each (degree + 1, lines), scaled to a largest 1."""
    _, axes = plt.subplots(1, len(bases), sharey=True, figsize=(8.2, 3.2), squeeze=False)
    for ax, (name, values) in zip(axes[0], bases.items(), strict=True):
        for k, ((color, line), row) in enumerate(zip(LINES, np.asarray(values), strict=False)):
            # i^k is taken out: what is left is real
            real = np.real(row * (-1j) ** k)
            ax.plot(frequency, real / np.abs(real).max(), line, color=color, label=f"{k}")
        ax.set(xlabel="frequency [Hz]", title=name)
    axes[0, 0].set_ylabel("polynomial, largest 1 [-]")
    axes[0, -1].legend(title="degree", loc="center left", bbox_to_anchor=(1.0, 0.5))


@styled
def conditions(modes: Sequence[int], numbers: Mapping[str, ArrayLike]) -> None:
    """Condition numbers over the number of modes, with the two that double precision allows."""
    _, ax = plt.subplots()
    for (name, values, color, line), marker in zip(each(numbers), MARKERS, strict=False):
        ax.semilogy(modes, values, line, color=color, marker=marker, markersize=5, label=name)
    eps = np.finfo(float).eps
    for level, text in ((eps**-0.5, "normal equations keep no digit"), (1 / eps, "least squares keep none")):
        ax.axhline(level, color=BLACK, lw=0.9, ls=":")
        ax.annotate(text, (modes[0], level), (2, 3), textcoords="offset points", fontsize=8.5)
    ax.set(xlabel="modes", ylabel="condition number [-]", xticks=modes)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=len(numbers))


@styled
def pole_map(
    reference: ArrayLike, found: Mapping[str, ArrayLike], band: tuple[float, float], heaviest: float = 5.0
) -> None:
    """Poles [rad/s] as frequency [Hz] against damping [%]: true ones as crosses, found ones as other marks.

    Parameters
    ----------
    reference, found : complex, one of each pair
    band : (lowest, highest) [Hz]
    heaviest : damping [%] at which the picture ends; what is damped more, or less than not at all, stands at its edge
    """
    _, ax = plt.subplots(figsize=(7.2, 3.8))

    def place(poles: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        poles = np.asarray(poles)
        f, zeta = np.asarray(hertz(np.abs(poles))), -100 * poles.real / np.abs(poles)
        inside = (f >= band[0]) & (f <= band[1])
        return f[inside], np.clip(zeta[inside], -0.3, heaviest)

    ax.plot(*place(reference), "+", color=GREY, markersize=17, mew=3, label="reference")
    for (name, poles, color, _), marker in zip(each(found), MARKERS, strict=False):
        ax.plot(*place(poles), marker, mec=color, mfc="none", color=color, markersize=6.5, mew=1.3, label=name)
    ax.axhline(0, color=BLACK, lw=0.8)
    ax.set(xlabel="frequency [Hz]", ylabel="damping [%]", xlim=band, ylim=(-0.4, heaviest * 1.02))
    legend_on(ax, 4)


@styled
def residual_parts(fit: Residues, data: FRF, response: str, force: str) -> None:
    """One FRF, and what its fit is made of: the modes of the band, what lies above it, and what lies below."""
    i, j = data.seat(response), data.seat(force)
    f = data.frequency[data.frequency > 0]
    whole = fit.frf(f).H[:, i, j]
    w = np.asarray(from_hertz(f))
    above = sum((U[i, j] * w ** (2 * k) for k, U in enumerate(fit.upper)), np.zeros(len(f)))
    below = -fit.lower[i, j] / w**2
    _, ax = plt.subplots()
    shown = {"data": data.H[data.frequency > 0, i, j], "modes in the band": whole - above - below}
    shown |= {"what lies above": above} | ({"what lies below": below} if fit.lower.any() else {})
    ax.semilogy(f, np.abs(shown.pop("data")), color=GREY, lw=4, label="data")
    for name, H, color, line in each(shown):
        ax.semilogy(f, np.abs(H), line, color=color, lw=1.3, label=name)
    ax.set(xlabel="frequency [Hz]", ylabel=f"|H|, {response} from {force}  [m/N]", xlim=fit.band)
    legend_on(ax, 4)
