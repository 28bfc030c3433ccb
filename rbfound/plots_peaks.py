"""Figures of the chapter on reading one peak: its parts over frequency, and its circle."""

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from rbfound.circle import CircleFit
from rbfound.plots_style import BLACK, BLUE, ORANGE, RED, styled
from rbfound.units import hertz, radians


@styled
def parts(frequency: ArrayLike, H: ArrayLike, fit: CircleFit, width: float = 3.0) -> None:
    """Real and imaginary part of a receptance [m/N], `width` half-power widths to either side of a fitted mode."""
    f, H = np.asarray(frequency, dtype=float), np.asarray(H)
    low, high = fit.half_power
    near = np.abs(f - fit.frequency) <= width * (high - low)
    fine = np.linspace(f[near][0], f[near][-1], 400)
    curve = fit.mobility(fine) / (1j * radians(fine))
    _, axes = plt.subplots(2, 1, sharex=True, figsize=(7.2, 4.6))
    for ax, part, name in zip(axes, (np.real, np.imag), ("Re H", "Im H"), strict=True):
        ax.plot(fine, part(curve), color=BLUE, label="fitted circle", zorder=3)
        ax.plot(f[near], part(H[near]), "o", color="#888888", markersize=3.5, label="lines")
        ax.axvline(fit.frequency, color=RED, ls="--", lw=1.2, label="natural frequency")
        for k, edge in enumerate((low, high)):
            ax.axvline(edge, color=BLACK, ls=":", lw=1.0, label="half-power points" if k == 0 else None)
        ax.axhline(0, color=BLACK, lw=0.6)
        ax.set_ylabel(f"{name}  [m/N]")
    axes[0].legend(ncols=4, fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    axes[1].set_xlabel("frequency [Hz]")
    plt.show()


@styled
def nyquist(frequency: ArrayLike, H: ArrayLike, fit: CircleFit) -> None:
    """The mobility [m/(N s)] of the fitted lines and some beside them, the circle, its diameter and quarter points."""
    f, H = np.asarray(frequency, dtype=float), np.asarray(H)
    first, last = fit.lines
    more = slice(max(first - 2 * (last - first), 0), last + 2 * (last - first))
    Y = 1j * np.asarray(radians(f)) * H
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
    plt.show()
