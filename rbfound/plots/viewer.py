"""Mode shapes that a reader can turn in the page, without a kernel and without a network. Needs rbfound[plots].

A cell that ends with `turnable(...)` shows them: the page gets a still picture, the shapes in a few hundred kilobytes,
and a script that draws them. Where scripts are off, and on paper, the still picture stands alone.
"""

import json
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from io import BytesIO
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from rbfound.plots.solids import TILT, TURN, VIEW
from rbfound.plots.style import BLACK, STYLE
from rbfound.plots.surfaces import Body
from rbfound.tables import number

Array = NDArray[np.float64]

# Little motion and much, on white and on black: on both what moves more is darker, so that the shade tells it without
# the colour. The first body's, the second's, the third's.
RAMPS = (
    (("#e4edf5", "#0b4a83"), ("#e4edf5", "#2a78bd")),
    (("#fbe6cf", "#a83a00"), ("#fbe6cf", "#c85a10")),
    (("#dff2ea", "#00614a"), ("#dff2ea", "#1f8e6c")),
)
# The largest displacement is drawn as this part of the picture's size.
EXAGGERATION = 0.08
# A mode whose points are out of step by less than this part of the largest displacement is drawn in step.
UNSEEN = 0.03
LIGHT = np.array([-0.45, 0.75, 0.48])


@dataclass(frozen=True, eq=False)
class Turnable:
    """What a notebook shows: `html` in a page, `text` where there is nothing else."""

    text: str
    html: str

    def __repr__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return self.html


def turnable(bodies: Sequence[Body], frequency: ArrayLike, title: str) -> Turnable:
    """A picture of mode shapes that can be turned and set moving. Let a cell end with it.

    Parameters
    ----------
    bodies : what moves, with the same modes and in the same unit; the shaft and what it stands on, for instance
    frequency : (modes,) [Hz]
    title : says what is seen
    """
    labels = [f"{k}: {number(float(f))} Hz" for k, f in enumerate(np.atleast_1d(frequency), start=1)]
    bodies = normalised(bodies)
    if len(labels) != len(bodies[0].shapes):
        raise ValueError(f"{len(labels)} frequencies and {len(bodies[0].shapes)} shapes: give one for each mode.")
    names = " and ".join(body.name for body in bodies)
    text = f"{title} ({names}): modes {', '.join(labels)}."
    picture = still(bodies, labels)
    package = files("rbfound.plots")
    script, style = (package.joinpath(f"viewer.{kind}").read_text(encoding="utf-8") for kind in ("js", "css"))
    # a closing tag in the data would end the script
    data = json.dumps(encoded(bodies, labels) | {"title": title}, ensure_ascii=True).replace("<", "\\u003c")
    image = b64encode(picture).decode("ascii")
    html = (
        f'<figure class="rbfound-view"><style>{style}</style>'
        f'<img class="rbfound-still" alt="{escape(text)}" src="data:image/webp;base64,{image}">'
        f'<script type="application/json">{data}</script><script>{script}</script></figure>'
    )
    return Turnable(text, html)


def normalised(bodies: Sequence[Body]) -> list[Body]:
    """The bodies with the largest displacement of each mode 1, over all of them together, and at its largest now.

    A complex shape is turned in phase so that the point which moves most is at the end of its way. An imaginary part
    too small to be seen is dropped.
    """
    if not bodies or len({len(body.shapes) for body in bodies}) != 1:
        counts = ", ".join(f"{body.name} {len(body.shapes)}" for body in bodies) or "no body"
        raise ValueError(f"The bodies of a picture move in the same modes: here are {counts}.")
    joint = np.concatenate([body.shapes for body in bodies], axis=1)
    factors = []
    for k, shape in enumerate(joint, start=1):
        # the longer half axis of a point's ellipse, squared, is (|x|^2 + |y|^2 + |z|^2 + |x^2 + y^2 + z^2|) / 2, and
        # the phase of x^2 + y^2 + z^2 is twice that of the instant at which the point is there
        point = (np.sum(np.abs(shape) ** 2, axis=1) + np.abs(np.sum(shape**2, axis=1))).argmax()
        phase = np.angle(np.sum(shape[point] ** 2)) / 2 if np.iscomplexobj(shape) else 0.0
        size = np.linalg.norm((shape[point] * np.exp(-1j * phase)).real)
        if not size > 0:
            raise ValueError(f"Nothing moves in shape {k}.")
        factors.append(np.exp(-1j * phase) / size)
    turned = joint * np.array(factors)[:, None, None]
    if np.iscomplexobj(turned):
        turned.imag[np.abs(turned.imag).max(axis=(1, 2)) < UNSEEN] = 0.0
    ends = np.cumsum([0, *(len(body.points) for body in bodies)])
    return [
        Body(body.name, body.points, body.faces, turned[:, start:end], body.marks, body.sheer)
        for body, start, end in zip(bodies, ends[:-1], ends[1:], strict=True)
    ]


def encoded(bodies: Sequence[Body], labels: Sequence[str]) -> dict[str, Any]:
    """Bodies as the script reads them: little-endian numbers in base64.

    Points are 16-bit, with 32767 for half the picture's largest extent; faces 16-bit; displacements 8-bit, with
    127 for `size`.
    """
    everywhere = np.concatenate([body.points for body in bodies])
    centre = (everywhere.max(axis=0) + everywhere.min(axis=0)) / 2
    half = float(np.ptp(everywhere, axis=0).max() / 2)
    out = []
    for k, body in enumerate(bodies):
        if len(body.points) > 65535:
            raise ValueError(f"{body.name} has {len(body.points)} points, and a page takes 65535: draw a coarser mesh.")
        out.append(
            {
                "name": body.name,
                "points": packed((body.points - centre) / half * 32767, "<i2"),
                "faces": packed(body.faces, "<u2"),
                "shapes": [displacements(shape) for shape in body.shapes],
                "marks": dict(body.marks),
                "sheer": body.sheer,
                "ramp": RAMPS[k % len(RAMPS)],
            }
        )
    view = {"turn": float(TURN), "tilt": float(TILT), "exaggeration": EXAGGERATION, "light": LIGHT.tolist()}
    return {"labels": list(labels), "bodies": out, **view}


def packed(values: ArrayLike, kind: str) -> str:
    """Numbers rounded to a kind of integer, in base64."""
    return b64encode(np.rint(values).astype(kind).tobytes()).decode("ascii")


def displacements(shape: ArrayLike) -> dict[str, Any]:
    """One mode of one body: `size` times the 8-bit numbers of its real and, if it has one, its imaginary part."""
    shape = np.asarray(shape)
    parts = {"real": shape.real} | ({"imag": shape.imag} if np.any(np.imag(shape)) else {})
    size = max(float(np.abs(part).max()) for part in parts.values())
    return {"size": size} | {name: packed(part / (size or 1.0) * 127, "i1") for name, part in parts.items()}


def still(bodies: Sequence[Body], labels: Sequence[str]) -> bytes:
    """All modes at their largest displacement over the undeformed outline, as a WebP: a fifth of a PNG's size.

    Shapes are taken as they are: see `normalised`.
    """
    columns = min(len(labels), 2 if len(labels) == 4 else 3)
    rows = -(-len(labels) // columns)
    wide, high = np.ptp(np.concatenate([body.points for body in bodies]) @ VIEW[:2].T, axis=0)
    out = BytesIO()
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.2, rows * (0.35 + 7.2 / columns * min(1.1 * high / wide, 1.0))))
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax in axes:
            ax.set_axis_off()
        for mode, (ax, label) in enumerate(zip(axes, labels, strict=False)):
            mode_on(ax, bodies, mode, marks=columns < 3)
            ax.set_title(label, fontsize=9)
        figure.savefig(out, format="webp", dpi=130, pil_kwargs={"quality": 75, "method": 6})
    return out.getvalue()


def mode_on(ax: Axes, bodies: Sequence[Body], mode: int, marks: bool = True) -> None:
    """One mode of some bodies into given axes, seen as in `rbfound.plots.solids.body`; far faces first."""
    size = float(np.ptp(np.concatenate([body.points for body in bodies]), axis=0).max())
    drawn: list[tuple[Array, Any, Any]] = []
    for k, body in enumerate(bodies):
        moved = body.points + EXAGGERATION * size * body.shapes[mode].real
        flat, rest = moved @ VIEW.T, body.points @ VIEW.T
        quads = flat[body.faces]
        front = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])[:, 2] > 0
        paint = _shades(body, mode, RAMPS[k % len(RAMPS)][0])
        drawn += zip(quads[front], paint[front], paint[front], strict=True)
        for places, edges, grey in ((rest, body.edges(VIEW[2]), 0.5), (flat, body.edges(VIEW[2], moved), 0.2)):
            # an edge is a flat face, a little nearer than those that it belongs to
            lines = places[edges[:, [0, 1, 1, 0]]] + [0, 0, 0.01 * size]
            drawn += [(line, (0, 0, 0, 0), (grey, grey, grey, 0.7)) for line in lines]
    drawn.sort(key=lambda item: float(item[0][:, 2].mean()))
    quads, inside, around = zip(*drawn, strict=True)
    ax.add_collection(PolyCollection([q[:, :2] for q in quads], facecolors=inside, edgecolors=around, linewidths=0.4))
    for body in bodies if marks else []:
        for name, point in body.marks.items():
            x, y, _ = VIEW @ (body.points[point] + EXAGGERATION * size * body.shapes[mode][point].real)
            ax.plot(x, y, "o", color=BLACK, markersize=2.5)
            box = {"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.7}
            ax.annotate(name, (x, y), (0, 12), textcoords="offset points", ha="center", fontsize=7, bbox=box)
    ax.autoscale_view()
    ax.set_aspect("equal")


def _shades(body: Body, mode: int, ramp: Sequence[str]) -> Array:
    """The colour of each face, (f, 4): its motion from one end of the ramp to the other, and a little light."""
    low, high = (np.array(to_rgb(color)) for color in ramp)
    motion = np.linalg.norm(np.abs(body.shapes[mode]), axis=1)[body.faces].mean(axis=1)[:, None]
    light = 0.72 + 0.28 * np.clip(body.normals @ VIEW.T @ LIGHT, 0, 1)[:, None]
    opacity = np.full_like(light, 0.35 if body.sheer else 1.0)
    return np.hstack([light * (low + np.minimum(motion, 1.0) * (high - low)), opacity])
