"""Figures of coupled machines by several roads: each beside the truth, and what noise does to a foundation's FRFs."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from rbfound.plots_style import BLACK, BLUE, LINES, RED, SKY, styled


@styled
def beside_truth(
    x: ArrayLike,
    truth: ArrayLike,
    curves: Mapping[str, ArrayLike],
    *,
    xlabel: str = "frequency [Hz]",
    ylabel: str = "receptance |H|  [m/N]",
) -> None:
    """Magnitudes of complex curves over one axis with the truth under them, and below how far each is from it [%]."""
    x, truth = np.asarray(x), np.asarray(truth)
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7.2, 4.8), height_ratios=(3, 2))
    top.semilogy(x, np.abs(truth), color="#bbbbbb", lw=5, label="truth")
    for (name, curve), (color, line) in zip(curves.items(), LINES, strict=False):
        top.semilogy(x, np.abs(curve), line, color=color, lw=1.2, label=name)
        bottom.semilogy(x, 100 * np.abs(np.asarray(curve) / truth - 1), line, color=color, lw=1.0)
    top.set_ylabel(ylabel)
    bottom.set(xlabel=xlabel, ylabel="error [%]")
    figure.legend(*top.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    plt.show()


@styled
def passivity(frequency: ArrayLike, levels: Mapping[str, ArrayLike]) -> None:
    """The least energy that a foundation takes in, over frequency [Hz]: `rbfound.passivity`. Grey is below zero."""
    figure, ax = plt.subplots(figsize=(7.2, 3.4))
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
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    plt.show()


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
    plt.show()
