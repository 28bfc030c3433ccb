"""Lines where a response needs them: few where it is smooth, many at its resonances."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Intervals are halved at most so many times: a response with a jump would never end.
HALVINGS = 30


def adaptive_lines(
    response: Callable[[Array], Complex], lines: ArrayLike, tolerance: float = 1e-3
) -> tuple[Array, Complex]:
    """Lines between which a cubic through four neighbours holds a tolerance, and the response on them.

    Each interval is tried at its middle, which becomes a line: everything returned has been asked for, nothing is
    interpolated. An interval is halved until the cubic through the lines around it has met its middle.

    Parameters
    ----------
    response : function of lines (k,), in any unit, that gives (k, ...) complex
        `rbfound.unbalance_response` over speeds, or `machine.frf(lines, ...).H`.
    lines : (n,) to begin with, ascending, four at least
        A resonance so narrow that it shows at no line and no middle is not seen: put the natural frequencies in.
    tolerance : float
        Of the largest difference at the middle, relative to the largest entry there.

    Returns
    -------
    (m,) lines and (m, ...) responses

    Raises
    ------
    ValueError
        When there are fewer than four lines, they do not ascend, or the tolerance is not positive.
    """
    x = np.asarray(lines, dtype=float)
    if x.ndim != 1 or len(x) < 4 or not np.isfinite(x).all() or (np.diff(x) <= 0).any():
        raise ValueError(f"{x.size} lines: at least four are needed, finite and ascending.")
    if not 0 < tolerance < np.inf:
        raise ValueError(f"tolerance = {tolerance:g}: it must be positive and finite.")
    y = np.asarray(response(x), dtype=complex)
    open_ = np.ones(len(x) - 1, dtype=bool)
    for _ in range(HALVINGS):
        left = np.flatnonzero(open_)
        if not len(left):
            break
        middle = (x[left] + x[left + 1]) / 2
        found = np.asarray(response(middle), dtype=complex)
        flat = found.reshape(len(middle), -1)
        off = np.abs(flat - _cubic(x, y.reshape(len(x), -1), left, middle)).max(axis=1)
        rough = off > tolerance * np.abs(flat).max(axis=1)
        x, y = np.insert(x, left + 1, middle), np.insert(y, left + 1, found, axis=0)
        open_ = np.insert(open_, left, rough)
        open_[left + np.arange(1, len(left) + 1)] = rough
    return x, y


def _cubic(x: Array, y: Complex, left: NDArray[np.intp], at: Array) -> Complex:
    """The cubic through the four lines around each interval, at a place in it: (k, entries)."""
    four = np.clip(left - 1, 0, len(x) - 4)[:, None] + np.arange(4)
    known = x[four]
    weight = np.ones_like(known)
    for i in range(4):
        for j in range(4):
            if i != j:
                weight[:, i] *= (at - known[:, j]) / (known[:, i] - known[:, j])
    return np.asarray(np.einsum("ki,kie->ke", weight, y[four]))
