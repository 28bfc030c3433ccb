"""What moves in a notebook: peaks on a picture, sliders with numbers beside them. Needs the extra rbfound[widgets]."""

from collections.abc import Mapping, Sequence
from typing import Any

import anywidget
import traitlets as T

from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.live.bench import Bench, bench_of
from rbfound.live.frontend import answer, scene
from rbfound.live.picking import METHODS, Picked, picks_of
from rbfound.live.things import script, sheet
from rbfound.rotor import Bearing, Rotor


class PeakPicker(anywidget.AnyWidget):
    """FRFs with peaks that can be moved, and what follows from them; made by `peak_picker`.

    All traits can be observed, and `peaks` and `method` be set from a cell, with or without a browser.

    Attributes
    ----------
    peaks : list of {"seat", "frequency" [Hz], "damping"}
        Damping None is read from the curve. Set it to frequencies in the order of the seats, or to such a list.
    method : "pmsm", "distinct" or "identify"; see `rbfound.live.picking.picked`
    picked : Picked, or None where the peaks give no foundation
    foundation : Foundation, or None
    message : why there is no foundation, "" where there is one
    """

    _esm = script("picker")
    _css = sheet("picker")

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
        # the picture's questions come as messages: of a model's changes a notebook lets one through at a time
        self.on_msg(lambda _, asked, buffers: self.set_state(asked))
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
        How a foundation comes from the FRFs, see `rbfound.live.picking.picked`. Can be changed in the picture.

    Returns
    -------
    PeakPicker
        Its traits `peaks`, `method` and `foundation` follow the hand, and `peaks` and `method` can be set.
    """
    if method not in METHODS:
        raise ValueError(f"There is no method {method!r}: the methods are {', '.join(METHODS)}.")
    return PeakPicker(bench_of(frf, rotor, bearings, truth), method, peaks)
