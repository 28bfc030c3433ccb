"""Figures of poles: the stabilisation chart, polynomials and their condition, what noise does to poles, residuals."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from rbfound.frf import FRF
from rbfound.peaks import mode_indicator
from rbfound.plots_style import BLACK, BLUE, LINES, RED, styled
from rbfound.polyreference import Stabilisation
from rbfound.residues import Residues
from rbfound.units import hertz, radians

GREY = "#b5b5b5"
MARKERS = ("o", "s", "^", "x")


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
        ax.plot(chart.frequency[which], chart.order[which], ls="", label=name, **look)
    for f in hertz(np.abs(np.asarray(picked))):
        ax.axvline(f, color=BLACK, lw=0.8, ls=":", zorder=0.5)
    low, high = frf.frequency[[0, -1]]
    ax.set(xlabel="frequency [Hz]", ylabel="order of the polynomial", xlim=(low, high), yticks=chart.orders[::2])
    ax.grid(axis="y", visible=False)
    ax.legend(title="stable in", loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, fontsize=8.5)
    plt.show()


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
    plt.show()


@styled
def conditions(modes: Sequence[int], numbers: Mapping[str, ArrayLike]) -> None:
    """Condition numbers over the number of modes, with the two that double precision allows."""
    _, ax = plt.subplots()
    for (name, values), (color, line), marker in zip(numbers.items(), LINES, MARKERS, strict=False):
        ax.semilogy(modes, values, line, color=color, marker=marker, markersize=5, label=name)
    eps = np.finfo(float).eps
    for level, text in ((eps**-0.5, "normal equations keep no digit"), (1 / eps, "least squares keep none")):
        ax.axhline(level, color=BLACK, lw=0.9, ls=":")
        ax.annotate(text, (modes[0], level), (2, 3), textcoords="offset points", fontsize=8.5)
    ax.set(xlabel="modes", ylabel="condition number [-]", xticks=modes)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=len(numbers))
    plt.show()


@styled
def pole_map(
    truth: ArrayLike, found: Mapping[str, ArrayLike], band: tuple[float, float], heaviest: float = 5.0
) -> None:
    """Poles [rad/s] as frequency [Hz] against damping [%]: true ones as crosses, found ones as other marks.

    Parameters
    ----------
    truth, found : complex, one of each pair
    band : (lowest, highest) [Hz]
    heaviest : damping [%] at which the picture ends; what is damped more, or less than not at all, stands at its edge
    """
    _, ax = plt.subplots(figsize=(7.2, 3.8))

    def place(poles: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        poles = np.asarray(poles)
        f, zeta = np.asarray(hertz(np.abs(poles))), -100 * poles.real / np.abs(poles)
        inside = (f >= band[0]) & (f <= band[1])
        return f[inside], np.clip(zeta[inside], -0.3, heaviest)

    ax.plot(*place(truth), "+", color=GREY, markersize=17, mew=3, label="truth")
    for (name, poles), (color, _), marker in zip(found.items(), LINES, MARKERS, strict=False):
        ax.plot(*place(poles), marker, mec=color, mfc="none", color=color, markersize=6.5, mew=1.3, label=name)
    ax.axhline(0, color=BLACK, lw=0.8)
    ax.set(xlabel="frequency [Hz]", ylabel="damping [%]", xlim=band, ylim=(-0.4, heaviest * 1.02))
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    plt.show()


@styled
def parts(fit: Residues, data: FRF, response: str, force: str) -> None:
    """One FRF, and what its fit is made of: the modes of the band, what lies above it, and what lies below."""
    i, j = data.seat(response), data.seat(force)
    f = data.frequency[data.frequency > 0]
    whole = fit.frf(f).H[:, i, j]
    w = np.asarray(radians(f))
    above = sum((U[i, j] * w ** (2 * k) for k, U in enumerate(fit.upper)), np.zeros(len(f)))
    below = -fit.lower[i, j] / w**2
    _, ax = plt.subplots()
    shown = {"data": data.H[data.frequency > 0, i, j], "modes in the band": whole - above - below}
    shown |= {"what lies above": above} | ({"what lies below": below} if fit.lower.any() else {})
    ax.semilogy(f, np.abs(shown.pop("data")), color=GREY, lw=4, label="data")
    for (name, H), (color, line) in zip(shown.items(), LINES, strict=False):
        ax.semilogy(f, np.abs(H), line, color=color, lw=1.3, label=name)
    ax.set(xlabel="frequency [Hz]", ylabel=f"|H|, {response} from {force}  [m/N]", xlim=fit.band)
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    plt.show()
