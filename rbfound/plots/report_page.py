"""The page that `rbfound identify --report` writes: one HTML file with text and figures, nothing to load."""

import base64
import html
import io

import numpy as np
from matplotlib.figure import Figure

from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.measurement import Report, mode_indicator
from rbfound.plots.quality import check_figure

STYLE = """body { font: 16px/1.5 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; }
pre { background: #f4f4f4; padding: 1em; overflow-x: auto; } img { max-width: 100%; }"""


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
    head = f'<meta charset="utf-8"><title>A foundation from its FRFs</title><style>{STYLE}</style>'
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
