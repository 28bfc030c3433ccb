"""Masses in a row: the matrices of a chain of masses, springs and dampers.

M x'' + C x' + K x = Q        (equations 4-7)
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.system import System

Array = NDArray[np.float64]


def chain(masses: Sequence[float], springs: Sequence[float], dampers: Sequence[float] | None = None) -> System:
    """A row of masses between two walls (equations 4-6).

    Parameters
    ----------
    masses : n of them [kg]
    springs : n + 1 [N/m]
        From the left wall to the first mass, from mass to mass, and from the last mass to the right wall. Zero is no
        spring: with zeros at both ends the chain is free.
    dampers : n + 1 [N s/m], beside the springs; none unless given

    Raises
    ------
    ValueError
        When the numbers do not fit together, a mass is not positive, or a spring or a damper is negative.
    """
    m = np.atleast_1d(np.asarray(masses, dtype=float))
    n = len(m)
    if (m <= 0).any() or not np.isfinite(m).all():
        raise ValueError(f"The masses hold {m.min():g} kg: every mass must be positive and finite.")
    return System(
        np.diag(m),
        _links(np.zeros(n + 1) if dampers is None else dampers, n, "dampers"),
        _links(springs, n, "springs"),
    )


def _links(values: ArrayLike, n: int, name: str) -> Array:
    """The matrix of what ties neighbours: each link adds its value to two diagonal entries and takes it off beside."""
    links = np.atleast_1d(np.asarray(values, dtype=float))
    if links.shape != (n + 1,):
        raise ValueError(f"{len(links)} {name} for {n} masses: it must be {n + 1}, one at either wall; zero is none.")
    if (links < 0).any() or not np.isfinite(links).all():
        raise ValueError(f"The {name} hold {links.min():g}: they must be finite and not negative.")
    return np.asarray(np.diag(links[:-1] + links[1:]) - np.diag(links[1:-1], 1) - np.diag(links[1:-1], -1))
