"""Figures of what a computation costs, and of how modes are counted."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from rbfound.plots_style import BLUE, LINES, RED, styled
from rbfound.units import hertz


@styled
def growth(curves: Mapping[str, Mapping[int, float]], size: str) -> None:
    """CPU seconds over size for each name, with the slope of a straight line through the logarithms."""
    _, ax = plt.subplots(figsize=(7.2, 3.4))
    for (name, spent), (color, line), marker in zip(curves.items(), LINES, "osd^v", strict=False):
        n, seconds = np.array(list(spent)), np.array(list(spent.values()))
        slope, at_one = np.polyfit(np.log(n), np.log(seconds), 1)
        ax.loglog(n, seconds, marker, color=color, ms=6)
        ax.loglog(n, np.exp(at_one) * n**slope, line, color=color, lw=1.2, label=f"{name}: slope {slope:.1f}")
    ax.set(xlabel=size, ylabel="CPU time [s]")
    ax.legend()
    plt.show()


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
    plt.show()


@styled
def guesses(errors: Mapping[str, ArrayLike]) -> None:
    """Relative errors of poles by number, a line for each name."""
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    for (name, values), (color, line), marker in zip(errors.items(), LINES, "osd^v", strict=False):
        y = np.maximum(np.asarray(values, dtype=float), 1e-16)
        ax.semilogy(np.arange(1, len(y) + 1), y, marker + line, color=color, ms=5, lw=1.2, label=name)
    ax.set(xlabel="number of the mode", ylabel="relative error of its pole [-]")
    ax.legend()
    plt.show()


@styled
def lines_where_needed(lines: ArrayLike, response: ArrayLike) -> None:
    """A response [m] over speed [rev/min] with the lines on which it was computed, marked on it and below."""
    x, y = np.asarray(lines), np.abs(np.asarray(response))
    _, ax = plt.subplots(figsize=(7.2, 3.2))
    ax.semilogy(x, y, ".-", color=BLUE, ms=4, lw=0.8, label=f"{len(x)} lines")
    ax.plot(x, np.full(len(x), y.min() / 3), "|", color=RED, ms=7, label="where they lie")
    ax.set(xlabel="speed [rev/min]", ylabel="amplitude at the disk [m]")
    ax.legend()
    plt.show()
