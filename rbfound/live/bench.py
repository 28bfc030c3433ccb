"""FRFs, and a rotor in its bearings beside them, prepared for peaks to be moved.

What does not depend on the peaks is computed here, once: an answer to a move then takes a few milliseconds.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.identification import ModalFit, fit_modes
from rbfound.machine import couple
from rbfound.measurement import check, prominence
from rbfound.rotor import Bearing, Rotor
from rbfound.theory import RIPPLE, Peak, half_power, local_maxima, reduced_rotor

Array = NDArray[np.float64]

# A check needs so many lines.
FEWEST = 5
# Lines that a screen can show of curves that follow each move.
SOME_LINES = 700


@dataclass(frozen=True, eq=False)
class Bench:
    """What does not depend on the peaks; made by `bench_of`.

    Attributes
    ----------
    frf : FRF
    readings : for each seat the peaks of its driving point that have half-power points, ascending
    lines : (l,) [Hz], on which the FRFs of a picked foundation are drawn
    journals : Foundation, or None
        The rotor at rest, its displacements in the bearings taken for seats.
    bearings : one for each pair of seats
    truth : Foundation, or None
        What the picked one is compared with.
    """

    frf: FRF
    readings: tuple[tuple[Peak, ...], ...]
    lines: Array
    journals: Foundation | None = None
    bearings: tuple[Bearing, ...] = ()
    truth: Foundation | None = None

    @cached_property
    def fit(self) -> ModalFit:
        """All modes that the FRFs show, fitted when first asked for."""
        return fit_modes(self.frf)

    @cached_property
    def findings(self) -> tuple[str, ...]:
        """What there is to warn of in the FRFs, before anything is made of them."""
        if len(self.frf.frequency) < FEWEST:
            return (f"The FRFs have {len(self.frf.frequency)} lines: too few to be checked.",)
        return check(self.frf).warnings

    @cached_property
    def size(self) -> str:
        """How large the FRFs are, in a sentence: a wrong unit shows in it, and in nothing else."""
        H = np.abs(self.frf.H)
        stiff = 1 / np.einsum("nii->ni", H)[0].clip(np.finfo(float).tiny)
        return (
            f"On the lowest line, {self.frf.frequency[0]:.4g} Hz, the seats are as stiff as {stiff.min():.3g} to "
            f"{stiff.max():.3g} N/m, and the largest receptance is {H.max():.3g} m/N: a wrong unit shows here."
        )

    @cached_property
    def true_frequencies(self) -> tuple[Array, Array]:
        """Natural frequencies [Hz] of the reference model alone and under the rotor, as far as the FRFs reach."""
        return (np.zeros(0), np.zeros(0)) if self.truth is None else self.frequencies(self.truth)

    def nearest(self, seat: int, frequency: float) -> Peak:
        """The peak of a seat's driving point that lies nearest to a frequency [Hz] and has half-power points."""
        if not self.readings[seat]:
            raise ValueError(
                f"No peak of the driving point {self.frf.labels[seat]} falls to half power on both sides: "
                "give its peak a damping ratio."
            )
        return min(self.readings[seat], key=lambda peak: abs(peak.frequency - frequency))

    def frequencies(self, foundation: Foundation) -> tuple[Array, Array]:
        """Natural frequencies [Hz] of a foundation alone and under the rotor, as far as the FRFs reach."""
        systems = [foundation.system()]
        if self.journals is not None:
            systems.append(couple(self.journals, self.bearings, foundation))
        top = float(self.frf.frequency[-1])
        found = [system.modes().above(1.0).below(top).frequency for system in systems]
        return found[0], found[1] if len(found) > 1 else np.zeros(0)


def bench_of(
    frf: FRF,
    rotor: Rotor | None = None,
    bearings: Mapping[float, Bearing] | None = None,
    truth: Foundation | None = None,
) -> Bench:
    """Prepare FRFs, and a rotor in its bearings with them, for peaks to be moved.

    Parameters
    ----------
    rotor, bearings : Rotor, mapping from a position [m] to a Bearing
        Both or neither.
    truth : Foundation
        To be compared with, if it is known.
    """
    if (rotor is None) != (not bearings):
        raise ValueError("A rotor stands in bearings: give both, or neither.")
    seats = len(frf.labels)
    if bearings and seats != 2 * len(bearings):
        raise ValueError(
            f"{len(bearings)} bearings need {2 * len(bearings)} seats, x and y for each: "
            f"the FRFs have {seats} ({', '.join(frf.labels)})."
        )
    if truth is not None and truth.labels != frf.labels:
        raise ValueError(
            f"The reference model has the seats {', '.join(truth.labels)}, the FRFs {', '.join(frf.labels)}."
        )
    if len(frf.frequency) < 3:
        raise ValueError(f"{len(frf.frequency)} lines show no peak: at least three are needed.")
    places = sorted(bearings or {})
    top = float(frf.frequency[-1])
    return Bench(
        frf,
        tuple(_readings(frf.frequency, np.abs(frf.H[:, j, j])) for j in range(seats)),
        thinned(frf, SOME_LINES).frequency,
        None if rotor is None else reduced_rotor(rotor, places, top, blocks=2).body,
        tuple((bearings or {})[z] for z in places),
        truth,
    )


def thinned(frf: FRF, most: int) -> FRF:
    """At most so many lines, with the smallest and the largest responses among those that are left."""
    n = len(frf.frequency)
    if n <= most:
        return frf
    size = np.linalg.norm(frf.H, axis=(1, 2))
    edges = np.linspace(0, n, most // 2 + 1).astype(int)
    parts = [(a, size[a:b]) for a, b in pairwise(edges)]
    kept = np.unique([a + pick(part) for a, part in parts for pick in (np.argmin, np.argmax)])
    return FRF(frf.frequency[kept], frf.H[kept], frf.labels)


def _readings(frequency: Array, magnitude: Array) -> tuple[Peak, ...]:
    """The peaks of a curve that stand above the noise and fall to half power on both sides."""
    curve = np.log(np.maximum(magnitude, np.finfo(float).tiny))
    lines = local_maxima(curve)
    standing = lines[prominence(curve, lines) > np.log1p(RIPPLE)]
    found = [half_power(frequency, magnitude, int(k)) for k in standing]
    return tuple(peak for peak in found if np.isfinite(peak.damping))
