"""What moves in a notebook: peaks on a picture, sliders with numbers beside them. Needs the extra rbfound[widgets]."""

from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

import anywidget
import ipywidgets as W
import numpy as np
import traitlets as T

from rbfound.bench import Bench, bench_of
from rbfound.coupling import mount
from rbfound.fitting import PseudoModes, equivalent_matrices, pseudo_modes
from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.frontend import answer, scene
from rbfound.peaks import Peaks
from rbfound.picking import METHODS, Picked, picks_of
from rbfound.rotor import Bearing, Rotor
from rbfound.tables import table


class PeakPicker(anywidget.AnyWidget):
    """FRFs with peaks that can be moved, and what follows from them; made by `peak_picker`.

    All traits can be observed, and `peaks` and `method` be set from a cell, with or without a browser.

    Attributes
    ----------
    peaks : list of {"seat", "frequency" [Hz], "damping"}
        Damping None is read from the curve. Set it to frequencies in the order of the seats, or to such a list.
    method : "pmsm", "distinct" or "identify"; see `rbfound.picking.picked`
    picked : Picked, or None where the peaks give no foundation
    foundation : Foundation, or None
    message : why there is no foundation, "" where there is one
    """

    _esm = files("rbfound").joinpath("picker.js").read_text(encoding="utf-8")
    _css = files("rbfound").joinpath("picker.css").read_text(encoding="utf-8")

    # what the picture sends need not come back to it: the answer bears its stamp
    peaks: Any = T.List().tag(sync=True, echo_update=False)
    method = T.Enum(list(METHODS), "pmsm").tag(sync=True, echo_update=False)
    stamp = T.Int(0).tag(sync=True, echo_update=False)
    scene = T.Dict().tag(sync=True)
    data = T.Bytes(b"").tag(sync=True)
    result = T.Dict().tag(sync=True)
    curves = T.Bytes(b"").tag(sync=True)
    picked = T.Instance(Picked, allow_none=True)
    foundation = T.Instance(Foundation, allow_none=True)
    message = T.Unicode("")

    def __init__(self, bench: Bench, method: str = "pmsm", peaks: Sequence[Any] | None = None):
        """A prepared bench; the first peaks, if they are not to be looked for."""
        self.bench = bench
        names, curves = scene(bench)
        self._first: dict[str, list[Any]] = dict(names["first"])
        if peaks is not None:
            self._first[method] = names["first"][method] = picks_of(bench, peaks)
        super().__init__(scene=names, data=curves, method=method, peaks=self._first[method])
        self.observe(self._follow, names=["peaks", "method", "stamp"])
        self._answered: Any = None
        self._follow()

    @T.validate("peaks")
    def _as_picks(self, proposal: dict[str, Any]) -> list[Any]:
        return picks_of(self.bench, proposal["value"])

    def _follow(self, change: Any = None) -> None:
        # a method chosen in a cell comes without its peaks; the picture sends both
        if change is not None and change["name"] == "method" and self._answered == (change["old"], self.peaks):
            self._first[change["old"]] = list(self.peaks)
            with self.hold_trait_notifications():
                self.peaks = self._first[change["new"]]
        asked = self.method, list(self.peaks)
        if asked == self._answered:
            if self.result["stamp"] != self.stamp:
                self.result = {**self.result, "stamp": self.stamp}
            return
        self._answered = asked
        found, told, curves = answer(self.bench, self.peaks, self.method)
        with self.hold_sync():
            self.curves = curves
            self.result = {**told, "stamp": self.stamp}
        self.message = told["message"]
        self.picked = found
        self.foundation = None if found is None else found.foundation

    def __repr__(self) -> str:
        if self.picked is None:
            return f"Peak picker, {METHODS[self.method]}: {self.message}"
        said = ", ".join(
            f"{seat} {frequency:.1f}".strip()
            for seat, frequency in zip(self.picked.seats, self.picked.peaks.frequency, strict=True)
        )
        return f"Peak picker, {METHODS[self.method]}: {said} Hz, cond(Phi) {self.picked.condition:.3g}"


def peak_picker(
    frf: FRF,
    rotor: Rotor | None = None,
    bearings: Mapping[float, Bearing] | None = None,
    truth: Foundation | None = None,
    peaks: Sequence[Any] | None = None,
    method: str = "pmsm",
) -> PeakPicker:
    """FRFs on which peaks can be moved by mouse, touch and keys, with the foundation that follows from them.

    Parameters
    ----------
    frf : FRF
    rotor, bearings : what stands on the foundation; both or neither
    truth : Foundation
        To be compared with, if it is known.
    peaks : frequencies [Hz] in the order of the seats, or mappings with "seat", "frequency" and "damping"
        Unless given, peaks are looked for.
    method : "pmsm", "distinct" or "identify"
        How a foundation comes from the FRFs, see `rbfound.picking.picked`. Can be changed in the picture.

    Returns
    -------
    PeakPicker
        Its traits `peaks`, `method` and `foundation` follow the hand, and `peaks` and `method` can be set.
    """
    if method not in METHODS:
        raise ValueError(f"There is no method {method!r}: the methods are {', '.join(METHODS)}.")
    return PeakPicker(bench_of(frf, rotor, bearings, truth), method, peaks)


class PeakTweaker(W.VBox):
    """Two sliders, the X and the Y peak [Hz]; Phi and the natural frequencies follow.

    Attributes
    ----------
    x, y : sliders [Hz]
        Set `x.value` and `y.value` from another cell, as a reader would by hand.
    modes : PseudoModes of the peaks as they stand
    foundation : Foundation of the peaks as they stand
    report : str, what is shown below the sliders
    """

    def __init__(self, frf: FRF, rotor: Rotor, bearings: Mapping[float, Bearing], x: float, y: float, zeta: float):
        """FRFs, the machine that stands on them, the first X and Y peak [Hz], and the damping ratio of both."""
        self._frf, self._rotor, self._bearings, self._zeta = frf, rotor, bearings, zeta
        self.x, self.y = (
            W.FloatSlider(
                value=value,
                min=float(frf.frequency[1]),
                max=float(frf.frequency[-2]),
                step=0.5,
                description=f"{name} peak [Hz]",
                layout=W.Layout(width="34em"),
                style={"description_width": "7em"},
            )
            for name, value in (("X", x), ("Y", y))
        )
        self._text = W.HTML()
        super().__init__([self.x, self.y, self._text])
        for slider in (self.x, self.y):
            slider.observe(lambda _: self._follow(), names="value")
        self._follow()

    def _follow(self) -> None:
        pairs = len(self._frf.labels) // 2
        peaks = Peaks(np.array([self.x.value, self.y.value] * pairs), np.array(self._zeta))
        try:
            self.modes: PseudoModes = pseudo_modes(self._frf, peaks)
            self.foundation: Foundation = equivalent_matrices(
                self.modes.Phi, self.modes.omega, self.modes.zeta, self._frf.labels
            )
        except ValueError as error:
            self.report = str(error)
        else:
            self.report = self._summary()
        self._text.value = f'<pre style="line-height:1.25">{self.report}</pre>'

    def _summary(self) -> str:
        machine = mount(self._rotor, self._bearings, on=self.foundation)
        coupled = machine.at(0.0).modes().above(1.0).frequency
        Phi = {f"peak {j + 1}": column for j, column in enumerate(self.modes.Phi.T)}
        frequencies = {
            "foundation alone [Hz]": self.foundation.modes().frequency,
            "under the rotor [Hz]": coupled[:8],
        }
        return "\n".join(
            [
                f"Phi, with condition number {self.modes.condition:.4g}",
                table({"seat": self._frf.labels, **Phi}),
                "",
                table(frequencies),
            ]
        )
