"""One peak read in several ways, side by side, and how far each is from the reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.identification import circle_fit
from rbfound.measurement import nearest_peak
from rbfound.units import from_hertz

Array = NDArray[np.float64]

# The lines of one mode end where |Im H| has fallen to this part of its peak; half of it is left where |Re H| peaks.
ENOUGH = 0.25
# Decimals of an error in per cent: what is smaller is rounding.
DECIMALS = 2


@dataclass(frozen=True)
class Reading:
    """What was read off one peak; nan where it cannot be.

    Attributes
    ----------
    frequency : float [Hz]
    damping : float [-]
    constant : float [1/kg]
        Modal constant phi_i phi_j.
    """

    frequency: float
    damping: float
    constant: float


def by_parts(frequency: ArrayLike, H: ArrayLike, near: float) -> Reading:
    """On the lines: the peak of |Im H|, the quadrature, and the largest and smallest Re H beside it.

    One mode has these two where w^2 = omega^2 (1 -+ 2 zeta), and its quadrature at resonance is the modal constant
    over 2 zeta omega^2 (equation 56).
    """
    f, H = np.asarray(frequency, dtype=float), np.asarray(H, dtype=complex)
    peak = nearest_peak(f, np.abs(H.imag), near, interpolate=False)
    top = int(np.abs(f - peak.frequency).argmin())
    small = np.flatnonzero(np.abs(H.imag) < ENOUGH * np.abs(H.imag[top]))
    first = int(small[small < top].max(initial=-1)) + 1
    last = int(small[small > top].min(initial=len(f)))
    # driving points have Im H < 0 and a real part that falls through zero
    real = -np.sign(H.imag[top]) * H.real[first:last]
    low, high = f[first + real.argmax()], f[first + real.argmin()]
    if not low < f[top] < high:
        return Reading(float(f[top]), float("nan"), float("nan"))
    damping = (high**2 - low**2) / (4 * f[top] ** 2)
    constant = -2 * damping * float(from_hertz(f[top])) ** 2 * H.imag[top]
    return Reading(float(f[top]), float(damping), float(constant))


def by_half_power(frequency: ArrayLike, H: ArrayLike, near: float, interpolate: bool = True) -> Reading:
    """The peak of |H| and its half-power points (equations 32 and 33), between the lines or on them."""
    peak = nearest_peak(frequency, np.abs(np.asarray(H)), near, interpolate)
    constant = 2 * peak.damping * float(from_hertz(peak.frequency)) ** 2 * peak.height
    return Reading(peak.frequency, peak.damping, constant)


def by_circle(frequency: ArrayLike, H: ArrayLike, near: float, slope: bool = False) -> Reading:
    """The circle of the mobility: `rbfound.identification.circle_fit`; with `slope` over half as many lines again."""
    fit = circle_fit(frequency, H, near, width=1.5 if slope else 1.0, slope=slope)
    return Reading(fit.natural_frequency, fit.damping, fit.constant.real)


METHODS: Mapping[str, Callable[[ArrayLike, ArrayLike, float], Reading]] = {
    "parts": by_parts,
    "half-power, on lines": lambda f, H, near: by_half_power(f, H, near, interpolate=False),
    "half-power, between": by_half_power,
    "circle": by_circle,
    "circle with slope": lambda f, H, near: by_circle(f, H, near, slope=True),
}


def readings(frequency: ArrayLike, H: ArrayLike, near: float) -> dict[str, Reading]:
    """One receptance [m/N] about one peak by each method; a `Reading` of nan where a method finds nothing to read.

    Parameters
    ----------
    frequency : (n,) [Hz]
    H : (n,) complex [m/N]
    near : frequency [Hz]
    """
    out = {}
    for name, method in METHODS.items():
        try:
            out[name] = method(frequency, H, near)
        except ValueError:
            # the methods say why when they are called alone; here it is a dash in a table
            out[name] = Reading(float("nan"), float("nan"), float("nan"))
    return out


def reading_errors(
    samples: Sequence[Mapping[str, Reading]], frequency: float, damping: float, constant: float
) -> dict[str, list[str] | list[float] | list[int]]:
    """Root mean square errors over samples, in per cent of the reference, as columns of a table: "read" counts samples.

    Parameters
    ----------
    samples : results of `readings`, one a noise
    frequency, damping, constant : of the reference [Hz, -, 1/kg]
    """
    names = list(samples[0])
    exact = np.array([frequency, damping, constant])
    values = np.array([[(s[n].frequency, s[n].damping, s[n].constant) for n in names] for s in samples])
    read = np.isfinite(values).all(axis=2)
    wrong = np.where(read[..., None], 100 * (values / exact - 1), 0.0)
    count = read.sum(axis=0)
    rms = np.sqrt((wrong**2).sum(axis=0) / np.where(count > 0, count, np.nan)[:, None])
    errors = {
        f"{what} [%]": [float(x) for x in np.round(column, DECIMALS)]
        for what, column in zip(("frequency", "damping", "constant"), rms.T, strict=True)
    }
    return {"method": names, **errors, "read": [int(c) for c in count]}
