"""Resonance peaks of a set of FRFs: where they are, how damped they are, and what tells them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.frf import FRF
from rbfound.theory import RIPPLE, Peak, half_power, local_maxima

Array = NDArray[np.float64]

# How far (as a part of the asked frequency) a peak may lie from where it was asked for.
REACH = 0.15


@dataclass(frozen=True, eq=False)
class Peaks:
    """Resonance peaks.

    Attributes
    ----------
    frequency : (p,) [Hz]
    damping : (p,) [-]
        Half-power damping ratio; nan where the peak does not fall to 1/sqrt(2) before its neighbour rises.
    """

    frequency: Array
    damping: Array

    def __post_init__(self) -> None:
        frequency = np.atleast_1d(np.asarray(self.frequency, dtype=float))
        damping = np.asarray(self.damping, dtype=float)
        if damping.shape not in ((), frequency.shape):
            raise ValueError(
                f"{len(frequency)} frequencies and {damping.size} damping ratios: give one for all or one each."
            )
        damping = np.broadcast_to(damping, frequency.shape).copy()
        object.__setattr__(self, "frequency", frequency)
        object.__setattr__(self, "damping", damping)

    def __len__(self) -> int:
        return len(self.frequency)


def mode_indicator(frf: FRF) -> Array:
    """Complex mode indicator function: singular values of H on each line, largest first, (n, seats) [m/N].

    The first one peaks at every mode that any seat can see; a second one that peaks too tells two modes apart
    that lie in one place. (Shih, Tsuei, Allemang and Brown 1988, DOI 10.1016/0888-3270(88)90060-X.)
    """
    return np.asarray(np.linalg.svd(frf.H, compute_uv=False))


def pick_peaks(
    frf: FRF, count: int | None = None, *, near: Sequence[float] | None = None, interpolate: bool = True
) -> Peaks:
    """Peaks of the first mode indicator, in ascending order.

    Parameters
    ----------
    count : int
        The most prominent ones (prominence of log |H|), or
    near : sequence of frequencies [Hz]
        the peak nearest to each.
    interpolate : bool
        See `rbfound.theory.sdof.half_power`.
    """
    if (count is None) == (near is None):
        raise ValueError("Say either count=, how many peaks, or near=, a list of frequencies [Hz] to look about.")
    curve = mode_indicator(frf)[:, 0]
    lines = local_maxima(curve)
    if count is not None:
        if not 1 <= count <= len(lines):
            raise ValueError(f"count is {count}: the first mode indicator has {len(lines)} peaks in this band.")
        prominent = np.argsort(-prominence(_logarithm(curve), lines))[:count]
        found = [half_power(frf.frequency, curve, int(k), interpolate) for k in np.sort(lines[prominent])]
    else:
        found = [nearest_peak(frf.frequency, curve, f, interpolate) for f in sorted(near or ())]
    return Peaks(np.array([p.frequency for p in found]), np.array([p.damping for p in found]))


def nearest_peak(
    frequency: ArrayLike, magnitude: ArrayLike, near: float, interpolate: bool = True, name: str = "the curve"
) -> Peak:
    """The peak of a curve that lies nearest to a frequency [Hz], not further than 15 % away."""
    f, curve = np.asarray(frequency, dtype=float), _logarithm(magnitude)
    lines = local_maxima(curve)
    # with noise on the lines most maxima are ripples; a peak stands above the valleys beside it
    standing = lines[prominence(curve, lines) > np.log1p(RIPPLE)]
    lines = standing if len(standing) else lines
    if not len(lines):
        raise ValueError(f"{name} has no peak between {f[0]:g} and {f[-1]:g} Hz.")
    k = int(lines[np.abs(f[lines] - near).argmin()])
    if not abs(f[k] - near) <= REACH * near:
        raise ValueError(f"{name} has no peak within {REACH:.0%} of {near:g} Hz: the nearest one is at {f[k]:g} Hz.")
    return half_power(f, magnitude, k, interpolate)


def _logarithm(curve: ArrayLike) -> Array:
    """log |H|, far down where there is no response at all."""
    return np.log(np.maximum(np.asarray(curve, dtype=float), np.finfo(float).tiny))


def prominence(curve: ArrayLike, lines: NDArray[np.intp]) -> Array:
    """How far each local maximum stands above the higher of the two valleys beside it, (len(lines),)."""
    y = np.asarray(curve, dtype=float)
    out = np.empty(len(lines))
    for n, k in enumerate(lines):
        higher = np.flatnonzero(y > y[k])
        left = higher[higher < k].max(initial=-1) + 1
        right = higher[higher > k].min(initial=len(y))
        out[n] = y[k] - max(y[left : k + 1].min(), y[k:right].min())
    return out
