"""Figures of the chapter on measured data: a blow in time, and FRFs with their coherence."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from rbfound.averaging import Blocks
from rbfound.plots_style import BLACK, BLUE, LINES, styled


@styled
def blow(blocks: Blocks, seat: str) -> None:
    """The first blow at a seat: its force near the blow, the acceleration there over the whole block."""
    j = blocks.labels.index(seat)
    force, response, t = blocks.force[j, 0], blocks.response[j, j, 0], blocks.time
    _, (left, right) = plt.subplots(1, 2, figsize=(8.4, 2.9), width_ratios=(1, 1.8))
    top = int(np.abs(force).argmax())
    near = slice(max(top - 8, 0), top + 13)
    left.plot(1e3 * t[near], force[near], "o-", color=BLUE, ms=3, lw=1.2)
    left.set(xlabel="time [ms]", ylabel="force [N]", title=f"the hammer at {seat}")
    right.plot(t, response, "-", color=BLACK, lw=0.8, label=f"acceleration at {seat}")
    right.set(xlabel="time [s]", ylabel="acceleration [m/s²]", title="the answer in one block")
    right.legend()
    plt.show()


@styled
def coherences(curves: Mapping[str, tuple[ArrayLike, ArrayLike, ArrayLike]], low: float = 0.0) -> None:
    """Named receptances with their coherences, each (frequency [Hz], H [m/N], coherence), above a frequency [Hz]."""
    _, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7.6, 4.8), height_ratios=(2, 1.1))
    for (name, values), (color, line) in zip(curves.items(), LINES, strict=False):
        f, H, coherence = (np.asarray(value) for value in values)
        seen = f >= low
        top.semilogy(f[seen], np.abs(H[seen]), line, color=color, lw=1.2, label=name)
        bottom.plot(f[seen], coherence[seen], line, color=color, lw=1.0)
    top.set_ylabel("receptance |H|  [m/N]")
    top.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    bottom.set(xlabel="frequency [Hz]", ylabel="coherence [-]", ylim=(-0.03, 1.05))
    plt.show()
