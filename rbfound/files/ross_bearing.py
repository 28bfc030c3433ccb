"""A foundation under two bearings as one element of ROSS (extra `rbfound[ross]`), with all its cross-talk.

ROSS knows supports bearing by bearing; this element joins the two support nodes by the full 4 x 4 matrices of a
foundation in the coordinates x1, y1, x2, y2. Along the shaft, which our foundation leaves open, it gets a stiffness and
a mass of its own.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from ross.bearing_seal_element import BearingElement

from rbfound.foundation import Foundation

Array = NDArray[np.float64]

# Where x1, y1, x2, y2 stand among x, y, z of the two nodes, and where z does.
LATERAL, AXIAL = np.array([0, 1, 3, 4]), np.array([2, 5])


class FoundationElement(BearingElement):
    """A foundation between two support nodes of a ROSS rotor.

    Parameters
    ----------
    foundation : Foundation
        With the seats x1, y1, x2, y2 and as many modes: a square B. What `rbfound.equivalent_matrices` and
        `rbfound.pmsm` give, or an identified foundation of four modes.
    n, n_link : int
        The support nodes of bearing 1 and of bearing 2, which lie behind the nodes of the shaft. ROSS needs a
        point mass at both (of 0 kg) and a bearing at n_link (of zero stiffness) beside this element.
    axial_stiffness, axial_mass : float [N/m], [kg]
        Of each seat along the shaft.

    Raises
    ------
    ValueError
        When the foundation has other seats, or more or fewer modes than seats: ROSS has no place for them.
    """

    def __init__(
        self, foundation: Foundation, n: int, n_link: int, axial_stiffness: float = 1e9, axial_mass: float = 1.0
    ) -> None:
        self.at_seats = {name: _six(A) for name, A in seat_matrices(foundation).items()}
        self.at_seats["K"][AXIAL, AXIAL] = axial_stiffness
        self.at_seats["M"][AXIAL, AXIAL] = axial_mass
        super().__init__(n=n, n_link=n_link, kxx=0.0, cxx=0.0, tag="foundation")

    def M(self, frequency: Any = 0) -> Array:
        """Mass (6, 6) [kg]."""
        return self.at_seats["M"]

    def C(self, frequency: Any = 0) -> Array:
        """Damping (6, 6) [N s/m]."""
        return self.at_seats["C"]

    def K(self, frequency: Any = 0) -> Array:
        """Stiffness (6, 6) [N/m]."""
        return self.at_seats["K"]


def seat_matrices(foundation: Foundation) -> dict[str, Array]:
    """M, C and K of a foundation with a square B, as the seats feel them: B⁻ᵀ A B⁻¹."""
    if foundation.labels != ("x1", "y1", "x2", "y2"):
        raise ValueError(f"The seats are {', '.join(foundation.labels)}: this element has x1, y1, x2, y2.")
    if foundation.B.shape != (4, 4):
        raise ValueError(
            f"The foundation has {foundation.B.shape[1]} coordinates at 4 seats: here it must have 4. "
            "Give a square one (rbfound.pmsm), or use MATRIX27 or DMIG, which hold all of them."
        )
    inverse = np.linalg.inv(foundation.B)
    return {name: inverse.T @ getattr(foundation, name) @ inverse for name in "MCK"}


def _six(A: Array) -> Array:
    out = np.zeros((6, 6))
    out[np.ix_(LATERAL, LATERAL)] = A
    return out
