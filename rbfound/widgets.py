"""What moves in a notebook: sliders with numbers beside them. Needs the extra rbfound[widgets]."""

from collections.abc import Mapping

import ipywidgets as W
import numpy as np

from rbfound.coupling import mount
from rbfound.fitting import PseudoModes, equivalent_matrices, pseudo_modes
from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.peaks import Peaks
from rbfound.rotor import Bearing, Rotor
from rbfound.tables import table


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
