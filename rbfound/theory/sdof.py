"""One degree of freedom in closed form, and the half-power points of a resonance peak.

m x'' + c x' + k x = f        omega = sqrt(k/m),  zeta = c / (2 m omega)        (equations 1-3)
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.units import from_hertz

Array = NDArray[np.float64]

# A rise by less than this part is noise on the lines, more is another peak.
RIPPLE = 0.05


def natural(m: float, c: float, k: float) -> tuple[float, float]:
    """Undamped natural frequency omega [rad/s] and damping ratio zeta [-] of a mass, a damper and a spring."""
    if not (m > 0 and k > 0 and c >= 0):
        raise ValueError(f"m = {m:g} kg, c = {c:g} N s/m, k = {k:g} N/m: m and k must be positive, c not negative.")
    omega = float(np.sqrt(k / m))
    return omega, c / (2 * m * omega)


def poles(m: float, c: float, k: float) -> NDArray[np.complex128]:
    """The two roots lambda of m lambda^2 + c lambda + k = 0 [rad/s]; |Im lambda| = omega sqrt(1 - zeta^2)."""
    omega, zeta = natural(m, c, k)
    root = np.sqrt(complex(zeta**2 - 1))
    return np.array([-zeta + root, -zeta - root]) * complex(omega)


def receptance(frequency: ArrayLike, m: float, c: float, k: float) -> NDArray[np.complex128]:
    """Displacement for a unit harmonic force, 1 / (k - omega^2 m + i omega c) [m/N], at frequencies [Hz]."""
    omega = from_hertz(frequency)
    return np.asarray(1 / (k - omega**2 * m + 1j * omega * c))


def transmissibility(frequency: ArrayLike, m: float, c: float, k: float) -> NDArray[np.complex128]:
    """Force on the ground for a unit harmonic force on the mass [-], complex (equations 25-31).

    (k + i omega c) / (k - omega^2 m + i omega c): what spring and damper carry of it. Its angle is the phase of the
    force below, negative behind the one above. The same ratio is the displacement of the mass for a unit displacement
    of the ground. At omega = sqrt(2 k / m) its size is 1, whatever the damper.
    """
    through = k + 1j * from_hertz(frequency) * c
    return np.asarray(through * receptance(frequency, m, c, k))


def free_vibration(time: ArrayLike, m: float, c: float, k: float, x0: float = 0.0, v0: float = 0.0) -> Array:
    """Displacement [m] at the times [s] after a release at x0 [m] with v0 [m/s] (equation 2)."""
    fast, slow = poles(m, c, k)
    t = np.asarray(time, dtype=float)
    if fast == slow:
        return np.asarray(np.real((x0 + (v0 - fast * x0) * t) * np.exp(fast * t)))
    a = (v0 - slow * x0) / (fast - slow)
    return np.asarray(np.real(a * np.exp(fast * t) + (x0 - a) * np.exp(slow * t)))


@dataclass(frozen=True)
class Peak:
    """One resonance peak: its frequency [Hz], height, half-power points [Hz] (nan where not reached), damping [-]."""

    frequency: float
    height: float
    low: float
    high: float

    @property
    def damping(self) -> float:
        """Equation 33: (high - low) / (2 frequency)."""
        return (self.high - self.low) / (2 * self.frequency)


def half_power(frequency: ArrayLike, magnitude: ArrayLike, line: int, interpolate: bool = True) -> Peak:
    """Peak and half-power points |H| = peak / sqrt(2) about a line that is a local maximum (equations 32, 33).

    With `interpolate`, three lines at a time are joined by a parabola of 1/|H|^2 over frequency squared: exactly
    the curve of one degree of freedom, 1/|H|^2 = ((k - omega^2 m)^2 + omega^2 c^2). Without, the peak is the line
    itself and |H| runs straight from line to line, as one reads it off a plot.

    A half-power point is nan where the curve rises again, or ends, before it has fallen to 1/sqrt(2). A rise by less
    than a twentieth is taken for noise, unless the point then lies more than twice as far away as the other one: a
    single mode is nearly symmetric.

    Parameters
    ----------
    frequency : (n,) [Hz], ascending
    magnitude : (n,) |H|
    line : int
        Index of a local maximum of the magnitude, with a line on either side.
    """
    f = np.asarray(frequency, dtype=float)
    a = np.asarray(magnitude, dtype=float)
    if not 0 < line < len(f) - 1 or a[line] < max(a[line - 1], a[line + 1]):
        raise ValueError(f"Line {line} of {len(f)} is not a local maximum with a line on either side.")
    if not interpolate:
        low, high = (_straight_crossing(f, a, line, step) for step in (-1, 1))
        return _peak(float(f[line]), float(a[line]), low, high)
    # a line without any response (0 Hz in many measured sets) would be infinite
    s, q = np.maximum(a, 1e-6 * a[line]) ** -2.0, f**2
    top, least = _vertex(q[line - 1 : line + 2], s[line - 1 : line + 2])
    low, high = (_resonance_crossing(q, s, line, step, 2 * least) for step in (-1, 1))
    return _peak(float(np.sqrt(top)), float(least**-0.5), low, high)


def local_maxima(magnitude: ArrayLike) -> NDArray[np.intp]:
    """Indices of the lines that stand above both neighbours, the two ends excluded."""
    a = np.asarray(magnitude, dtype=float)
    return np.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:])) + 1


def _peak(top: float, height: float, low: tuple[float, bool], high: tuple[float, bool]) -> Peak:
    """A peak from its half-power points, each with whether the curve rose on the way there."""
    (below, rose_below), (above, rose_above) = low, high
    left, right = top - below, above - top
    if rose_below and not left <= 2 * right:
        below = float("nan")
    if rose_above and not right <= 2 * left:
        above = float("nan")
    return Peak(top, height, below, above)


def _straight_crossing(f: Array, a: Array, line: int, step: int) -> tuple[float, bool]:
    lowest, level = a[line], a[line] / np.sqrt(2)
    inner, rose = line, False
    while 0 <= inner + step < len(f):
        outer = inner + step
        if a[outer] > (1 + RIPPLE) * lowest:
            break
        rose = rose or a[outer] > lowest
        lowest = min(lowest, a[outer])
        if a[outer] <= level:
            return float(f[inner] + (f[outer] - f[inner]) * (a[inner] - level) / (a[inner] - a[outer])), rose
        inner = outer
    return float("nan"), rose


def _resonance_crossing(q: Array, s: Array, line: int, step: int, level: float) -> tuple[float, bool]:
    inner, highest, rose = line, s[line], False
    while 0 <= inner + step < len(q):
        outer = inner + step
        # s is 1/|H|^2
        if s[outer] < highest / (1 + RIPPLE) ** 2:
            break
        rose = rose or s[outer] < highest
        highest = max(highest, s[outer])
        if s[outer] >= level:
            three = sorted((inner - step, inner, outer))
            c2, c1, c0 = _parabola(q[three], s[three])
            if c2 > 0 and c1**2 >= 4 * c2 * (c0 - level):
                root = (-c1 + step * np.sqrt(c1**2 - 4 * c2 * (c0 - level))) / (2 * c2)
            else:  # neighbours bend the curve the other way: a straight line between the two
                root = q[inner] + (q[outer] - q[inner]) * (level - s[inner]) / (s[outer] - s[inner])
            return float(np.sqrt(root)), rose
        inner = outer
    return float("nan"), rose


def _parabola(x: Array, y: Array) -> tuple[float, float, float]:
    """Coefficients c2, c1, c0 of the parabola through three points."""
    slope = np.diff(y) / np.diff(x)
    c2 = (slope[1] - slope[0]) / (x[2] - x[0])
    c1 = slope[0] - c2 * (x[0] + x[1])
    return float(c2), float(c1), float(y[0] - x[0] * (c1 + c2 * x[0]))


def _vertex(x: Array, y: Array) -> tuple[float, float]:
    """Lowest point of the parabola through three points whose middle one is the lowest."""
    c2, c1, c0 = _parabola(x, y)
    if c2 <= 0:
        return float(x[1]), float(y[1])
    at = -c1 / (2 * c2)
    least = c0 + c1 * at / 2
    # the parabola of a heavily disturbed peak may dip below zero: then the line itself is the peak
    return (at, least) if least > 0 else (float(x[1]), float(y[1]))
