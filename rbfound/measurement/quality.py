"""What a set of FRFs is worth before anything is made of it: a report that a person can act on."""

from dataclasses import dataclass
from textwrap import fill

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from rbfound.frf import FRF
from rbfound.measurement.noise import beside_neighbours
from rbfound.measurement.peaks import mode_indicator, prominence
from rbfound.parallel import one_thread
from rbfound.tables import number, table
from rbfound.theory import half_power, local_maxima

Array = NDArray[np.float64]

# A peak stands this far above the valleys beside it, and above what noise alone would do [log |H|].
STANDING = 0.3
# Half-power widths need a few lines for a damping ratio; a second mode is seen where it has this part of the first.
FEW_LINES, SECOND = 4.0, 0.02
# Noise is that of so many lines side by side; what is this many standard deviations of it or more is not noise.
WINDOW, BEYOND = 15, 4.0
# Rounding, or the digits of a text file, as a part of |H|.
WRITTEN = 1e-6
# Reciprocity errors beyond this part of the largest receptance are more than calibration.
NOT_RECIPROCAL = 0.05
# The static limit is reached well below the first peak: at a third of it receptances are 12 % above.
STATIC_PART = 1 / 3
# The next four lines of a static limit are within this part of it, or it is none.
APART = 1.0

NO_PHASE = (
    "The FRFs have no phase: Im H is zero. Magnitudes, or real parts alone, are not enough to identify a foundation. "
    "Export real and imaginary parts, or magnitude and phase."
)


@dataclass(frozen=True, eq=False)
class Report:
    """What was found in a set of FRFs; `print(report)` says it in words.

    Attributes
    ----------
    labels : names of the seats
    lines, low, high, spacing : number of lines, the first, the last, and the median distance between two [Hz]
    gaps : (low, high) [Hz] of neighbouring lines that are more than twice as far apart as those beside them
    noise : (outputs, inputs)
        Standard deviation of the complex error as a part of |H|, from what a line differs from its neighbours.
    nonreciprocity : where |H_ij - H_ji| stands out of the noise most, as a part of the largest receptance there
        0 where it stands out nowhere.
    nonreciprocal_at : (response, force, frequency [Hz]) of it
    gaining : (seats,)
        Part of the lines on which a driving point gives energy away, see `gains`: 0 for a sound measurement, near 1 for
        a flipped sensor or a phase of the other sign.
    peaks, damping, resolution : (p,) [Hz], [-], [-]
        Peaks of the mode indicator, their half-power damping, and how many lines lie in the half-power width.
    double : (p,) bool
        Where a second mode shows at the same place.
    static : (seats,) [m/N]
        Real part of each driving point on the lowest line, nan where noise hides it.
    reaches_static : whether the lowest line lies so far below the first peak that `static` is the static limit
    has_phase : whether the receptances have imaginary parts, as those of anything that is damped
    warnings : sentences that say what to mend
    notes : those of the FRFs
    """

    labels: tuple[str, ...]
    lines: int
    low: float
    high: float
    spacing: float
    gaps: tuple[tuple[float, float], ...]
    noise: Array
    nonreciprocity: float
    nonreciprocal_at: tuple[str, str, float]
    gaining: Array
    peaks: Array
    damping: Array
    resolution: Array
    double: NDArray[np.bool_]
    static: Array
    reaches_static: bool
    has_phase: bool
    warnings: tuple[str, ...]
    notes: tuple[str, ...]

    def __str__(self) -> str:
        i, j, f = self.nonreciprocal_at
        told = [
            f"{len(self.labels)} seats ({', '.join(self.labels)}), {self.lines} lines "
            f"from {self.low:g} to {self.high:g} Hz, every {self.spacing:.4g} Hz.",
            f"Noise: {100 * np.median(self.noise):.2g} % of |H| (median of the FRFs), "
            f"{100 * self.noise.max():.2g} % at the worst.",
            "Reciprocity: no pair differs by more than its noise."
            if self.nonreciprocity == 0
            else f"Reciprocity: {i} from {j} and {j} from {i} differ by {number(100 * self.nonreciprocity, 2)} % of "
            f"the largest receptance at {f:.4g} Hz, where it stands out of the noise most.",
            *self.notes,
        ]
        peaks = {
            "peak [Hz]": self.peaks,
            "damping [%]": 100 * self.damping,
            "lines in its width": self.resolution,
            "modes": ["two or more" if two else "one" for two in self.double],
        }
        seats = {
            "driving point": list(self.labels),
            f"Re H at {self.low:g} Hz [m/N]": self.static,
            "lines with Im H > 0 [%]": 100 * self.gaining,
        }
        parts = [*(fill(line, 92) for line in told), table(peaks, 3) if len(self.peaks) else "", table(seats, 3)]
        parts += [fill(f"Warning: {line}", 92) for line in self.warnings] or ["Nothing to warn of."]
        return "\n".join(part for part in parts if part)


@one_thread
def check(frf: FRF) -> Report:
    """Look at a set of FRFs as one would before using it: grid, noise, reciprocity, signs, resolution, static limit.

    Raises
    ------
    ValueError
        With fewer than five lines: nothing can be told of them.
    """
    f = frf.frequency
    if len(f) < 5:
        raise ValueError(f"The FRFs have {len(f)} lines: at least 5 are needed to tell anything.")
    local, noise = _noise(frf)
    difference = np.abs(frf.H - frf.H.transpose(0, 2, 1))
    largest = np.abs(frf.H).max(axis=(1, 2))
    largest = np.where(largest > 0, largest, 1.0)[:, None, None]
    beyond = difference - BEYOND * np.hypot(local, local.transpose(0, 2, 1))
    beyond /= largest
    k, i, j = np.unravel_index(beyond.argmax(), beyond.shape)
    nonreciprocity = float((difference / largest)[k, i, j]) if beyond[k, i, j] > 0 else 0.0
    driving = np.einsum("nii->ni", frf.H)
    peaks, damping, double = _peaks(frf, local)
    width = 2 * damping * peaks
    steps = np.diff(f)
    at = np.clip(np.searchsorted(f, peaks), 1, len(f) - 1)
    first = float(peaks[0]) if len(peaks) else float(f[-1])
    found = Report(
        labels=frf.labels,
        lines=len(f),
        low=float(f[0]),
        high=float(f[-1]),
        spacing=float(np.median(steps)),
        gaps=_gaps(f),
        noise=noise,
        nonreciprocity=nonreciprocity,
        nonreciprocal_at=(frf.labels[i], frf.labels[j], float(f[k])),
        gaining=_above(driving, local).mean(axis=0),
        peaks=peaks,
        damping=damping,
        resolution=width / steps[at - 1],
        double=double,
        static=np.where(_hidden(driving.real, local, f[0] <= STATIC_PART * first), np.nan, driving[0].real),
        reaches_static=bool(f[0] <= STATIC_PART * first),
        has_phase=has_phase(frf),
        warnings=(),
        notes=frf.notes,
    )
    return Report(**{**vars(found), "warnings": tuple(_warnings(found))})


def _hidden(static: Array, noise: Array, limit: bool) -> NDArray[np.bool_]:
    """Whether noise hides the first line of each driving point (n, seats).

    It does where it is as large, and where the lines that follow show another static limit, if the first one has to be
    one (`limit`): what was integrated from an acceleration at nearly 0 Hz is a number of any size.
    """
    next_ones = np.median(static[1:5], axis=0)
    small = np.abs(static[0]) < BEYOND * np.diag(noise[0])
    return np.asarray(small | (limit & (np.abs(static[0] - next_ones) > APART * np.abs(next_ones))))


def has_phase(frf: FRF) -> bool:
    """Whether more than one receptance in a hundred has an imaginary part that is not rounding."""
    size = np.abs(frf.H)
    return bool((np.abs(frf.H.imag) > WRITTEN * size).sum() > 0.01 * np.count_nonzero(size))


def gains(frf: FRF) -> NDArray[np.bool_]:
    """Lines on which a driving point gives energy away: Im H > 0, beyond the noise of the lines around, (n, seats)."""
    local, _ = _noise(frf)
    return _above(np.einsum("nii->ni", frf.H), local)


def _above(driving: NDArray[np.complex128], noise: Array) -> NDArray[np.bool_]:
    # half of the noise's variance is the imaginary part's
    beyond = BEYOND * np.einsum("nii->ni", noise) / np.sqrt(2)
    return np.asarray(driving.imag > beyond + WRITTEN * np.abs(driving))


def _noise(frf: FRF) -> tuple[Array, Array]:
    """Standard deviation of each FRF's error, line by line [m/N], and in the whole as a part of |H|.

    A line differs from the cubic through its four neighbours by noise, and by curvature beside sharp peaks. That cubic
    follows the curve between resonances, so the better half of the lines tells the noise: of the lines around each one,
    as noise is another part of |H| in valleys and at low frequencies than at peaks; and of all.
    """
    f, H = frf.frequency, frf.H
    # the median of the square of a complex normal error is log 2 of its mean
    rest = np.sqrt(beside_neighbours(f, H) / np.log(2))
    size = np.abs(H[2:-2])
    # as of accelerations: over the first lines a receptance's noise falls by orders of magnitude
    square = np.maximum(f / f[-1], 1e-3)[:, None, None] ** 2
    local = ndimage.median_filter(rest * square[2:-2], (WINDOW, 1, 1), mode="reflect")
    local = np.pad(local, ((2, 2), (0, 0), (0, 0)), mode="edge") / square
    return local, np.median(rest / np.where(size > 0, size, np.inf), axis=0)


def _gaps(f: Array) -> tuple[tuple[float, float], ...]:
    steps = np.diff(f)
    beside = np.maximum(np.append(steps[1:], steps[-2]), np.insert(steps[:-1], 0, steps[1]))
    return tuple((float(f[k]), float(f[k + 1])) for k in np.flatnonzero(steps > 2 * beside * (1 + 1e-9)))


def _peaks(frf: FRF, noise: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Frequency [Hz] and half-power damping of each peak of the mode indicator, and whether it is a double one."""
    f, values = frf.frequency, mode_indicator(frf)
    size = np.linalg.norm(noise, axis=(1, 2))
    curve = values[:, 0]
    lines = _standing(curve, size)
    found = [half_power(f, curve, int(k)) for k in lines]
    damping = np.array([peak.damping for peak in found])
    double = np.zeros(len(lines), dtype=bool)
    if values.shape[1] > 1:
        # where two curves cross the lower one has a maximum too, but no mode: that one does not stand out
        seconds = _standing(values[:, 1], size)
        for n, (k, zeta) in enumerate(zip(lines, damping, strict=True)):
            reach = max(np.nan_to_num(zeta, nan=0.02) * f[k], f[k + 1] - f[k])
            near = seconds[np.abs(f[seconds] - f[k]) <= reach]
            double[n] = bool((values[near, 1] > SECOND * curve[k]).any())
    return np.array([peak.frequency for peak in found]), damping, double


def _standing(curve: Array, noise: Array) -> NDArray[np.intp]:
    """Lines of the maxima of a curve that noise of a size (n,) does not make."""
    tiny = np.finfo(float).tiny
    lines = local_maxima(curve)
    least = np.maximum(STANDING, 6 * noise[lines] / np.maximum(curve[lines], tiny))
    return lines[prominence(np.log(np.maximum(curve, tiny)), lines) > least]


def _warnings(report: Report) -> list[str]:
    """What a person should mend, worst first."""
    out = []
    if not report.has_phase:
        out.append(NO_PHASE)
    for label, part in zip(report.labels, report.gaining, strict=True):
        if part > 0.5:
            out.append(
                f"The driving point at {label} gives energy away on {part:.0%} of the lines (Im H > 0): a flipped "
                "sensor or force cell, or a phase of the other sign."
            )
        elif part > 0.01:
            out.append(
                f"The imaginary part of the driving point at {label} changes its sign ({part:.0%} of the lines are "
                "positive): response and force are not measured at one place or in one direction, or the sensor is bad."
            )
    i, j, f = report.nonreciprocal_at
    if report.nonreciprocity > NOT_RECIPROCAL:
        out.append(
            f"{i} from {j} and {j} from {i} differ by {report.nonreciprocity:.0%} of the largest receptance at "
            f"{f:.4g} Hz: look at these two measurements; a model made of the set takes their mean."
        )
    for low, high in report.gaps:
        out.append(f"No line lies between {low:g} and {high:g} Hz, more than twice the distance beside it.")
    for f0, lines in zip(report.peaks, report.resolution, strict=True):
        if lines < FEW_LINES:
            out.append(
                f"Only {lines:.2g} lines lie in the half-power width of the peak at {f0:.4g} Hz: its damping needs "
                f"{FEW_LINES:.0f} or more, a spacing of {report.spacing * lines / FEW_LINES:.2g} Hz."
            )
    if not len(report.peaks):
        out.append(
            "No peak stands out of the curves: the band holds no resonance, or it is narrower than one, which a fit of "
            "modes may find all the same."
        )
    elif not report.reaches_static:
        out.append(
            f"The lowest line, {report.low:g} Hz, lies above a third of the first peak's {report.peaks[0]:.4g} Hz: "
            "the static stiffness is not in the data."
        )
    elif (report.static < 0).any():
        seats = ", ".join(np.array(report.labels)[report.static < 0])
        out.append(
            f"Below the first peak the seats {seats} move against their force: a body that floats, or a flipped sign."
        )
    return out
