"""Steps of a shaft: beside one, the outer fibres of the thicker side carry no bending.

Beam theory lets the whole section of the thick side work right from the step on, and is too stiff there. The usual
remedy lets what works widen like a cone from the thin side's diameter, commonly by 45 degrees; the mass stays.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rbfound.rotor import Shaft

Array = NDArray[np.float64]


def with_cones(shaft: Shaft, angle: float = 45.0, slices: int = 6) -> Shaft:
    """The same shaft with stiffness diameters that widen like cones behind each step.

    Parameters
    ----------
    shaft : Shaft
    angle : half the opening of the cones [degrees]; 90 is plain beam theory
    slices : how many cylinders stand for one cone
    """
    if not 0 < angle < 90:
        raise ValueError(f"angle = {angle:g} degrees: it must lie between 0 and 90, both excluded.")
    if slices < 1:
        raise ValueError(f"slices = {slices}: a cone needs at least one.")
    ends, diameter = shaft.ends, np.asarray(shaft.diameter, dtype=float)
    slope = 2 * np.tan(np.radians(angle))
    reach = (diameter.max() - np.minimum(diameter[:-1], diameter[1:])) / slope
    beside = [step + side * r * np.linspace(0, 1, slices + 1) for step, r in _pairs(ends, reach) for side in (-1, 1)]
    cuts = np.sort(np.concatenate([ends, *beside]))
    cuts = cuts[(cuts >= 0) & (cuts <= ends[-1])]
    cuts = cuts[np.concatenate([[True], np.diff(cuts) > 1e-9 * ends[-1]])]
    middle = np.array([(a + b) / 2 for a, b in pairwise(cuts)])
    segment = np.searchsorted(ends, middle) - 1
    inner = np.broadcast_to(shaft.inner, len(diameter))[segment]
    return Shaft(
        list(np.diff(cuts)),
        list(diameter[segment]),
        list(inner),
        shaft.E,
        shaft.rho,
        shaft.nu,
        stiff=list(_widening(ends, diameter, slope, middle, segment)),
    )


def _pairs(ends: Array, reach: Array) -> list[tuple[float, float]]:
    return [(float(step), float(r)) for step, r in zip(ends[1:-1], reach, strict=True)]


def _widening(ends: Array, diameter: Array, slope: float, z: Array, segment: NDArray[np.intp]) -> Array:
    """Diameter of what works at each z [m]: no more than the segment's, no more than any cone that reaches there."""
    working = diameter[segment]
    for k, step in enumerate(ends[1:-1]):
        left, right = diameter[k], diameter[k + 1]
        behind = z < step if left > right else z > step
        cone = min(left, right) + slope * np.abs(z - step)
        working = np.where(behind, np.minimum(working, cone), working)
    return np.asarray(working)
