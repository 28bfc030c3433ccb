"""One resonance of one FRF by its circle in the complex plane: frequency, damping and modal constant.

A single mode with viscous damping moves its *mobility*, velocity over force, round an exact circle through the origin:

    i w H = D / (1 + i x),    x = (w^2 - omega^2) / (2 zeta omega w),    D = phi_i phi_j / (2 zeta omega)

with D for a diameter. (With hysteretic damping it is the receptance that does so; the thesis's damping is viscous.)
What the other modes add is nearly constant about a peak: it shifts the circle and leaves its size and the angles
alone. What it changes along the lines can be taken out too (slope=True).
(Kennedy and Pancu 1947, DOI 10.2514/8.1474; Ewins, Modal Testing, second edition, 2000.)
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

from rbfound.measurement import REACH, prominence
from rbfound.theory import local_maxima
from rbfound.units import from_hertz, hertz

Complex = NDArray[np.complex128]

Array = NDArray[np.float64]


def kasa(points: ArrayLike) -> tuple[complex, float]:
    """Centre and radius of a circle through complex points, by linear least squares of |z - centre|^2 - radius^2.

    Noise on a short arc makes it too small. (Kasa 1976, DOI 10.1109/TIM.1976.6312298.)
    """
    z, origin, size = _centred(points)
    A = np.column_stack([2 * z.real, 2 * z.imag, np.ones(len(z))])
    a, b, c = np.linalg.lstsq(A, np.abs(z) ** 2, rcond=None)[0]
    return origin + size * complex(a, b), float(size * np.sqrt(c + a**2 + b**2))


def taubin(points: ArrayLike) -> tuple[complex, float]:
    """Centre and radius of a circle through complex points, by Taubin's algebraic fit.

    The same distances as `kasa`, over their mean gradient: large circles are no longer dear, and little of the bias
    is left. (Taubin 1991, DOI 10.1109/34.103273.)
    """
    z, origin, size = _centred(points)
    square = np.abs(z) ** 2
    mean = square.mean()
    # a |z|^2 + b x + c y - a mean = 0; with the first column scaled, the constraint is that the vector has length 1
    A = np.column_stack([(square - mean) / (2 * np.sqrt(mean)), z.real, z.imag])
    a, b, c = np.linalg.svd(A, full_matrices=False)[2][-1]
    a /= 2 * np.sqrt(mean)
    if abs(a) < 1e-12:
        raise ValueError("The points lie on a straight line: there is no circle through them.")
    centre = complex(-b, -c) / (2 * a)
    return origin + size * centre, float(size * np.sqrt(abs(centre) ** 2 + mean))


def _centred(points: ArrayLike) -> tuple[Complex, complex, float]:
    """Points about their centroid, in units of their mean distance from it: mobilities are small numbers."""
    z = np.asarray(points, dtype=complex).ravel()
    if len(z) < 3:
        raise ValueError(f"{len(z)} points are given: a circle needs three.")
    origin = complex(z.mean())
    size = float(np.abs(z - origin).mean())
    if not size > 0:
        raise ValueError("All points are one: there is no circle through them.")
    return (z - origin) / size, origin, size


# Half-power widths that a window reaches to either side of its peak: x from -2 to 2, seven tenths of the circle.
WIDTH = 1.0


# A circle and the angles on it are six numbers, two lines fewer than this give no more than that.
LEAST = 5


# A maximum that stands above the valleys beside it by this factor is a peak: the ripples of 5 % of noise do not.
NEIGHBOUR = 1.25


# Rounds in search of the slope, each leaving about half of the last one's change, and the relative change of damping
# that counts as none; with noise, a hundredth of its spread does.
ROUNDS, REST = 60, 1e-5


@dataclass(frozen=True, eq=False)
class CircleFit:
    """The circle of one resonance in the plane of the mobility.

    Attributes
    ----------
    centre : complex [m/(N s)]
    radius : float [m/(N s)]
    angle : float [rad]
        Of the diameter D at resonance: 0 or pi for a real mode.
    omega, zeta : undamped natural frequency [rad/s] and damping ratio [-]
    scatter : float
        Root mean square distance of the lines from the circle, as a part of its radius. Noise, or a neighbour.
    spread : float
        Interquartile range of the damping ratios of all pairs of lines, as a part of zeta.
    lines : (first, behind the last)
        Which lines of the FRF were used.
    slope : complex [m/(N s)]
        What was taken out before, over (w - omega) / omega: the others' share that grows along the lines.
    """

    centre: complex
    radius: float
    angle: float
    omega: float
    zeta: float
    scatter: float
    spread: float
    lines: tuple[int, int]
    slope: complex = 0j

    @property
    def natural_frequency(self) -> float:
        """Undamped natural frequency [Hz]."""
        return float(hertz(self.omega))

    @property
    def damping(self) -> float:
        """Damping ratio zeta [-]."""
        return self.zeta

    @property
    def constant(self) -> complex:
        """Modal constant 2 zeta omega D [1/kg]: phi_i phi_j of a real mode, then nearly real."""
        return complex(4 * self.zeta * self.omega * self.radius * np.exp(1j * self.angle))

    @property
    def residue(self) -> complex:
        """Residue of H at its pole -zeta omega + i omega sqrt(1 - zeta^2) [m/(N s)]."""
        return complex(self.constant / (2j * self.omega * np.sqrt(1 - self.zeta**2)))

    @property
    def remainder(self) -> complex:
        """What the other modes add to the mobility [m/(N s)]: the point opposite to resonance."""
        return complex(self.centre - self.radius * np.exp(1j * self.angle))

    @property
    def half_power(self) -> tuple[float, float]:
        """Frequencies [Hz] a quarter of the circle before and behind resonance; 2 zeta f apart."""
        low, high = (self.natural_frequency * (np.sqrt(1 + self.zeta**2) + side * self.zeta) for side in (-1, 1))
        return float(low), float(high)

    def mobility(self, frequency: ArrayLike) -> Complex:
        """The fitted mobility [m/(N s)] at frequencies [Hz]: the mode, the constant remainder and its slope."""
        omega = from_hertz(frequency)
        turn = np.exp(-2j * np.arctan(_detuning(omega, self.omega, self.zeta)))
        rise = self.slope * (omega / self.omega - 1)
        return np.asarray(self.centre + rise + self.radius * np.exp(1j * self.angle) * turn)


def circle_fit(
    frequency: ArrayLike,
    H: ArrayLike,
    near: float | None = None,
    *,
    band: tuple[float, float] | None = None,
    width: float = WIDTH,
    slope: bool = False,
    through: Callable[[ArrayLike], tuple[complex, float]] = taubin,
    name: str = "the FRF",
) -> CircleFit:
    """Frequency, damping and modal constant of one resonance from the circle of its mobility.

    The circle is laid through the lines first. Their angles on it then tell where the sweep is fastest, the natural
    frequency, and each pair of lines a below and b above resonance tells the damping by the tangents of half the
    angles theta from there, exactly for one viscous mode:

        zeta = (w_b^2 - w_a^2) / (2 omega (w_a tan(theta_a / 2) + w_b tan(theta_b / 2)))

    The median over all pairs is taken, and the diameter gives the modal constant.

    Parameters
    ----------
    frequency : (n,) [Hz], ascending
    H : (n,) complex [m/N]
        One receptance.
    near : frequency [Hz]
        The nearest peak of |H| is fitted: the lines `width` half-power widths to either side of it, at least five, cut
        off at the valley where another peak follows. Or
    band : (lowest, highest) [Hz]
        these lines: where an FRF has no peak of its own, or its neighbour is near.
    width : float
        More lines average more of the noise and see more of the neighbours.
    slope : bool
        Take out what the other modes' share changes along the lines, in rounds: a fit, the slope of what it leaves,
        a fit without it. Less bias, more scatter: with noise take more lines, such as width=1.5.
    through : `rbfound.identification.circle.taubin` or `rbfound.identification.circle.kasa`
    name : what an error calls the FRF

    Raises
    ------
    ValueError
        When neither or both of near= and band= are given, there is no peak, its half-power points are not reached on
        either side, fewer than five lines are left, their angles show no resonance, or the rounds find no rest.
    """
    f, H = np.asarray(frequency, dtype=float), np.asarray(H, dtype=complex)
    if f.ndim != 1 or H.shape != f.shape:
        raise ValueError(f"frequency has shape {f.shape} and H {H.shape}: one FRF has one number a line.")
    if (near is None) == (band is None):
        raise ValueError("Say either near=, the frequency of a peak [Hz], or band=, the lowest and highest line [Hz].")
    lines = _band(f, band) if band is not None else _window(f, np.abs(H), float(near or 0), width, name)
    omega = np.asarray(from_hertz(f[lines]))
    Y = 1j * omega * H[lines]
    fit = _through(omega, Y, through, name, lines)
    for _ in range(ROUNDS if slope else 0):
        before = fit
        rise = complex(np.linalg.lstsq(_shares(omega, fit, True), Y, rcond=None)[0][2])
        fit = replace(_through(omega, Y - rise * (omega / fit.omega - 1), through, name, lines), slope=rise)
        if abs(fit.zeta - before.zeta) < max(REST, fit.spread / 100) * fit.zeta:
            return fit
    if slope:
        raise ValueError(
            f"{name}: after {ROUNDS} rounds the damping ratio at {fit.natural_frequency:.4g} Hz still moves, "
            f"{fit.zeta:.3g}: these lines do not tell a slope from the mode; use more of them, or slope=False."
        )
    return fit


def modal_constants(frequency: ArrayLike, H: ArrayLike, fit: CircleFit) -> Complex:
    """Modal constants phi_i phi_j [1/kg] of FRFs that share a mode whose frequency and damping a circle has told.

    With these two known the mobility is linear in the diameter and the constant remainder, so that a circle can be
    had where the mode is weak and has no peak of its own.

    Parameters
    ----------
    frequency : (n,) [Hz]
    H : (n, ...) complex [m/N]
        Receptances; the lines of the fit are used.
    """
    first, last = fit.lines
    omega = np.asarray(from_hertz(np.asarray(frequency, dtype=float)[first:last]))
    H = np.asarray(H, dtype=complex)[first:last]
    Y = 1j * omega[:, None] * H.reshape(len(omega), -1)
    D = np.linalg.lstsq(_shares(omega, fit, fit.slope != 0), Y, rcond=None)[0][0]
    return np.asarray(2 * fit.zeta * fit.omega * D.reshape(H.shape[1:]))


def _detuning(omega: Array, omega_r: float, zeta: float) -> Array:
    """x of the mobility 1 / (1 + i x): -1 and 1 at the half-power points."""
    return np.asarray((omega / omega_r - omega_r / omega) / (2 * zeta))


def _shares(omega: Array, fit: CircleFit, slope: bool) -> Complex:
    """What a mobility is made of: the mode, a constant and, with `slope`, what grows along the lines (n, 2 or 3)."""
    mode = 1 / (1 + 1j * _detuning(omega, fit.omega, fit.zeta))
    return np.column_stack([mode, np.ones(len(omega)), omega / fit.omega - 1][: 3 if slope else 2])


def _through(
    omega: Array, Y: Complex, through: Callable[[ArrayLike], tuple[complex, float]], name: str, lines: slice
) -> CircleFit:
    """The circle through these mobilities, and what the angles on it tell."""
    centre, radius = through(Y)
    point = (Y - centre) / radius
    omega_r, angle = _fastest_sweep(omega, point / np.abs(point))
    zeta, spread = _pairs(omega, omega_r, angle - np.angle(point))
    if not 0 < zeta < 1:
        raise ValueError(
            f"{name}: the circle at {hertz(omega_r):.4g} Hz has the damping ratio {zeta:.3g}: no resonance."
        )
    scatter = float(np.sqrt(np.mean((np.abs(point) - 1) ** 2)))
    return CircleFit(centre, radius, angle, omega_r, zeta, scatter, spread, (lines.start, lines.stop))


def _band(f: Array, band: tuple[float, float]) -> slice:
    first, last = int(np.searchsorted(f, band[0])), int(np.searchsorted(f, band[1], side="right"))
    # at 0 Hz nothing has a velocity
    return _enough(max(first, int(f[0] == 0)), last, f"between {band[0]:g} and {band[1]:g} Hz")


def _enough(first: int, last: int, where: str) -> slice:
    if last - first < LEAST:
        raise ValueError(f"Only {max(last - first, 0)} lines lie {where}: a circle and its angles need {LEAST}.")
    return slice(first, last)


def _window(f: Array, magnitude: Array, near: float, width: float, name: str) -> slice:
    """Lines about the nearest peak, up to the valleys where others begin."""
    if not width > 0:
        raise ValueError(f"width is {width:g} half-power widths: it must be positive.")
    curve = np.log(np.maximum(magnitude, np.finfo(float).tiny))
    tops = local_maxima(curve)
    tops = tops[prominence(curve, tops) > np.log(NEIGHBOUR)]
    if not len(tops) or not np.abs(f[tops] - near).min() <= REACH * near:
        raise ValueError(
            f"{name}: no peak within {REACH:.0%} of {near:g} Hz stands {NEIGHBOUR - 1:.0%} above the valleys beside "
            "it; say with band= which lines are to be fitted."
        )
    this = int(np.abs(f[tops] - near).argmin())
    top = int(tops[this])
    first = tops[this - 1] + curve[tops[this - 1] : top].argmin() if this else int(f[0] == 0)
    last = top + curve[top : tops[this + 1]].argmin() + 1 if this + 1 < len(tops) else len(f)
    away = np.abs(f[first:last] - f[top])
    # down to half power on the flank that falls first: the other one may lead to a neighbour
    fallen = away[curve[first:last] <= curve[top] - np.log(2) / 2]
    if not len(fallen):
        raise ValueError(
            f"{name}: the peak at {f[top]:g} Hz does not fall to half power on either side; say with band= which lines "
            "are its."
        )
    reach = max(2 * width * fallen.min(), np.sort(away)[min(LEAST, len(away)) - 1])
    inside = first + np.flatnonzero(away <= reach)
    return _enough(int(inside[0]), int(inside[-1]) + 1, f"about the peak at {f[top]:g} Hz")


def _fastest_sweep(omega: Array, u: Complex) -> tuple[float, float]:
    """Natural frequency and the angle there: angle - 2 arctan x laid through the angles of u.

    The location of the fastest sweep, found from all lines instead of from the differences of two neighbours: those
    would be all noise on fine lines, and miss it on coarse ones.
    """

    def turned(parameters: Array) -> Complex:
        return np.asarray(u * np.exp(2j * np.arctan(_detuning(omega, *np.exp(parameters)))))

    def residual(parameters: Array) -> Array:
        back = turned(parameters)
        return np.asarray(np.angle(back * np.conj(back.sum())))

    # the whole band for the half-power width, a half, a quarter; the middle or either quarter for the frequency
    starts = [
        np.log([omega[0] + share * (omega[-1] - omega[0]), (omega[-1] - omega[0]) / (part * omega.mean())])
        for share in (0.25, 0.5, 0.75)
        for part in (2, 4, 8)
    ]
    best = min(starts, key=lambda start: float(np.sum(residual(start) ** 2)))
    found = optimize.least_squares(residual, best, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    omega_r, zeta = (float(value) for value in np.exp(found))
    if not (omega[0] < omega_r < omega[-1] and zeta < 1):
        raise ValueError(
            f"The angles between {hertz(omega[0]):.4g} and {hertz(omega[-1]):.4g} Hz turn fastest at "
            f"{hertz(omega_r):.4g} Hz, with a damping ratio of {zeta:.3g}: these lines show no "
            "resonance, or are too far apart for it."
        )
    return omega_r, float(np.angle(turned(found).sum()))


def _pairs(omega: Array, omega_r: float, theta: Array) -> tuple[float, float]:
    """Median of the damping ratios of all pairs of lines, one on either side, and their relative spread."""
    # theta, up to whole turns, is 2 arctan x: the branch of the tangent needs no unwrapping
    x = np.tan(theta / 2)
    below, above = omega < omega_r, omega > omega_r
    sum_ = -(omega * x)[below][:, None] + (omega * x)[above]
    zeta = (omega[above] ** 2 - omega[below][:, None] ** 2) / (2 * omega_r * sum_)
    middle = float(np.median(zeta))
    low, high = np.percentile(zeta, [25, 75])
    return middle, float((high - low) / abs(middle))
