"""Figures of measured data: the report on a set of FRFs, a hammer blow, coherence; and the page with the report.

`rbfound identify --report` writes that page: one HTML file with text and figures, nothing to load.
"""

import base64
import html
import io
from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.measurement import FEW_LINES, STATIC_PART, Blocks, Report, gains, mode_indicator
from rbfound.plots.style import BLACK, BLUE, ORANGE, RED, STYLE, each, legend_on, styled
from rbfound.tables import number

PAGE_STYLE = """body { font: 16px/1.5 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; }
pre { background: #f4f4f4; padding: 1em; overflow-x: auto; } img { max-width: 100%; }"""

# A matrix of noise is lettered up to so many seats.
LETTERED = 8


@styled
def checked(frf: FRF, report: Report) -> None:
    """A report on a set of FRFs as one figure, see `check_on`."""
    check_on(plt.figure(figsize=(9.2, 8.2)), frf, report)


def check_figure(frf: FRF, report: Report) -> Figure:
    """The same figure for a page, in the book's style."""
    with plt.rc_context(STYLE):
        figure = Figure(figsize=(9.2, 8.2))
        check_on(figure, frf, report)
    return figure


def check_on(figure: Figure, frf: FRF, report: Report) -> None:
    """The report into a given figure.

    Peaks with their double modes, gaps and the static limit; the lines in each half-power width; the noise of each FRF;
    the pair that is least reciprocal; the lines on which a driving point gives energy away.
    """
    axes = figure.subplot_mosaic("AAA;BBC;DDE", height_ratios=(1.25, 1, 1))
    _peaks_on(axes["A"], frf, report)
    _reciprocity_on(axes["B"], frf, report)
    _noise_on(axes["C"], report)
    _signs_on(axes["D"], frf, report)
    _resolution_on(axes["E"], report)


def _peaks_on(ax: Axes, frf: FRF, report: Report) -> None:
    values = mode_indicator(frf)
    ax.semilogy(frf.frequency, values[:, 0], "-", color=BLACK, lw=1.2, label="first singular value of H")
    if values.shape[1] > 1:
        ax.semilogy(frf.frequency, values[:, 1], "--", color="#888888", lw=1.0, label="second")
    height = np.interp(report.peaks, frf.frequency, values[:, 0])
    coarse = report.resolution < FEW_LINES
    kinds = (
        (~report.double & ~coarse, "o", BLUE, "one mode"),
        (report.double & ~coarse, "s", ORANGE, "two or more modes"),
        (coarse, "X", RED, "too few lines for its damping"),
    )
    for which, marker, color, name in kinds:
        if which.any():
            ax.plot(report.peaks[which], height[which], marker, color=color, mec=BLACK, ms=7, label=name, zorder=4)
    for k, (low, high) in enumerate(report.gaps):
        ax.axvspan(low, high, color="#bbbbbb", hatch="//", lw=0, label="no lines" if k == 0 else None)
    if len(report.peaks):
        ax.axvspan(0, STATIC_PART * report.peaks[0], color="#e6eef5", lw=0, label="static limit", zorder=0)
    ax.set(xlabel="frequency [Hz]", ylabel="[m/N]", xlim=(0, report.high))
    told = "the static limit is in the data" if report.reaches_static else "the static limit is not in the data"
    ax.set_title(f"mode indicator: {len(report.peaks)} peaks, {told}", loc="left", pad=22)
    ax.legend(loc="lower left", bbox_to_anchor=(-0.01, 0.985), ncols=6, fontsize=8, columnspacing=1.1)


def _reciprocity_on(ax: Axes, frf: FRF, report: Report) -> None:
    response, force, at = report.nonreciprocal_at
    i, j = frf.seat(response), frf.seat(force)
    ax.semilogy(frf.frequency, np.abs(frf.H[:, i, j]), "-", color=BLUE, lw=1.8, label=f"{response} from {force}")
    ax.semilogy(frf.frequency, np.abs(frf.H[:, j, i]), "--", color=RED, lw=1.1, label=f"{force} from {response}")
    told = "reciprocity: within the noise"
    if report.nonreciprocity > 0:
        ax.semilogy(
            frf.frequency, np.abs(frf.H[:, i, j] - frf.H[:, j, i]), ":", color=BLACK, lw=1.1, label="difference"
        )
        ax.axvline(at, color=BLACK, ls="-.", lw=0.8)
        told = f"least reciprocal: {number(100 * report.nonreciprocity, 2)} % of the largest at {at:.4g} Hz"
    ax.set(xlabel="frequency [Hz]", ylabel="|H|  [m/N]", xlim=(0, report.high))
    ax.set_title(told, loc="left")
    ax.legend(fontsize=8, ncols=3)


def _noise_on(ax: Axes, report: Report) -> None:
    percent, seats = 100 * report.noise, range(len(report.labels))
    ax.imshow(np.log10(np.maximum(percent, 1e-3)), cmap="Greys", vmin=-2, vmax=3.2, aspect="auto")
    if len(report.labels) <= LETTERED:
        for (i, j), value in np.ndenumerate(percent):
            told = f"{value:.1f}" if 0.05 <= value < 100 else f"{value:.0f}"
            ax.text(j, i, told, ha="center", va="center", fontsize=8, color="white" if value > 20 else BLACK)
    ax.set(xticks=seats, yticks=seats, xticklabels=report.labels, yticklabels=report.labels)
    ax.set(xlabel="force", ylabel="response")
    ax.set_title("noise [% of |H|]", loc="left")
    ax.grid(False)


def _signs_on(ax: Axes, frf: FRF, report: Report) -> None:
    seats, gives = len(report.labels), gains(frf)
    for k, label in enumerate(report.labels):
        ax.fill_between(frf.frequency, k - 0.3, k + 0.3, color="#e3e3e3", lw=0)
        ax.vlines(frf.frequency[gives[:, k]], k - 0.3, k + 0.3, color=RED, lw=1.2)
        ax.text(1.01, k, f"{report.gaining[k]:.0%}", transform=ax.get_yaxis_transform(), va="center", fontsize=8)
        ax.annotate(label, (0, k), (-4, 0), textcoords="offset points", ha="right", va="center")
    ax.set(xlabel="frequency [Hz]", ylim=(seats - 0.4, -0.6), xlim=(0, report.high), yticks=[])
    ax.set_title("driving points: lines that give energy away (Im H > 0)", loc="left")
    ax.grid(False)


def _resolution_on(ax: Axes, report: Report) -> None:
    few = report.resolution < FEW_LINES
    places = np.arange(len(report.peaks))
    ax.bar(places, report.resolution, color=np.where(few, RED, "#9fb8cd"), ec=BLACK, lw=0.6)
    ax.axhline(FEW_LINES, color=BLACK, ls="--", lw=1.0, label=f"{FEW_LINES:.0f}, for a damping")
    ax.set_xticks(places, [f"{f:.0f}" for f in report.peaks], rotation=60, fontsize=8)
    ax.set(xlabel="peak [Hz]", ylabel="lines")
    ax.set_title("lines in the half-power width", loc="left")
    ax.legend(fontsize=8)
    ax.grid(axis="x", visible=False)


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


@styled
def coherences(curves: Mapping[str, tuple[ArrayLike, ArrayLike, ArrayLike]], low: float = 0.0) -> None:
    """Named receptances with their coherences, each (frequency [Hz], H [m/N], coherence), above a frequency [Hz]."""
    _, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7.6, 4.8), height_ratios=(2, 1.1))
    for name, values, color, line in each(curves):
        f, H, coherence = (np.asarray(value) for value in values)
        seen = f >= low
        top.semilogy(f[seen], np.abs(H[seen]), line, color=color, lw=1.2, label=name)
        bottom.plot(f[seen], coherence[seen], line, color=color, lw=1.0)
    top.set_ylabel("receptance |H|  [m/N]")
    legend_on(top, 3)
    bottom.set(xlabel="frequency [Hz]", ylabel="coherence [-]", ylim=(-0.03, 1.05))


def page(frf: FRF, report: Report, foundation: Foundation) -> str:
    """An HTML page with the report on the FRFs, the foundation made of them, and both in figures."""
    model = foundation.frf(frf.frequency)
    parts = [
        "<h1>A foundation from its FRFs</h1>",
        "<h2>The measured FRFs</h2>",
        f"<pre>{html.escape(str(report))}</pre>",
        _image(check_figure(frf, report), "Peaks, noise, reciprocity, driving points and resolution of the FRFs"),
        _image(_driving_points(frf, model), "Driving points, measured and of the model"),
        _image(_indicator(frf, model), "Mode indicator, measured and of the model"),
        "<h2>The foundation</h2>",
        f"<pre>{html.escape(str(foundation))}</pre>",
    ]
    head = f'<meta charset="utf-8"><title>A foundation from its FRFs</title><style>{PAGE_STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n' + "\n".join(parts) + "\n</body></html>\n"


def _driving_points(frf: FRF, model: FRF) -> Figure:
    seats = len(frf.labels)
    figure = Figure(figsize=(9, 2.2 * ((seats + 1) // 2)), layout="constrained")
    for k, label in enumerate(frf.labels):
        axes = figure.add_subplot((seats + 1) // 2, 2, k + 1)
        axes.semilogy(frf.frequency, np.abs(frf.H[:, k, k]), "-", color="0.6", lw=2.5, label="measured")
        axes.semilogy(frf.frequency, np.abs(model.H[:, k, k]), "k--", lw=1.0, label="model")
        axes.set(title=f"{label} from {label}", xlabel="frequency [Hz]", ylabel="|H| [m/N]")
        axes.grid(color="0.9")
        if k == 0:
            axes.legend()
    return figure


def _indicator(frf: FRF, model: FRF) -> Figure:
    figure = Figure(figsize=(9, 3.4), layout="constrained")
    axes = figure.add_subplot()
    for values, style, name in ((mode_indicator(frf), "-", "measured"), (mode_indicator(model), "--", "model")):
        for k in range(min(2, values.shape[1])):
            axes.semilogy(
                frf.frequency,
                values[:, k],
                style,
                color="k" if style == "--" else "0.6",
                label=name if k == 0 else None,
            )
    axes.set(xlabel="frequency [Hz]", ylabel="singular values [m/N]", title="mode indicator, first and second")
    axes.grid(color="0.9")
    axes.legend()
    return figure


def _image(figure: Figure, told: str) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=110)
    content = base64.b64encode(stream.getvalue()).decode()
    return f'<p><img alt="{told}" src="data:image/png;base64,{content}"></p>'
