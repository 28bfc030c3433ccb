"""Figures of error bars: bands about a Campbell diagram, and errors in units of their bars."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from rbfound.plots import campbell_on
from rbfound.plots_style import BLACK, BLUE, RED, styled
from rbfound.uncertainty import ErrorBars
from rbfound.units import rpm
from rbfound.whirl import Campbell


@styled
def campbell_bands(diagram: Campbell, bars: ErrorBars, magnified: float = 1.0, highest: float | None = None) -> None:
    """A Campbell diagram with a band of two deviations either way about each branch, so many times magnified."""
    figure, ax = plt.subplots(figsize=(7.2, 4.6))
    campbell_on(ax, diagram, highest, legend=False)
    for branch, deviation in zip(bars.frequency.T, bars.frequency_deviation.T, strict=True):
        half = 2 * magnified * deviation
        ax.fill_between(rpm(diagram.speeds), branch - half, branch + half, color=BLUE, alpha=0.22, lw=0)
    times = f", {magnified:g} times" if magnified != 1 else ""
    ax.fill_between([], [], [], color=BLUE, alpha=0.22, lw=0, label=f"two deviations{times}")
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=8.5)
    plt.show()


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
    plt.show()
