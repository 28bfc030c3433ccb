"""One degree of freedom to play with: what mass, damper and spring do to the peak and to the circle."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from rbfound.live.sketch import axis, figure, line, listing, mark, slider
from rbfound.theory import sdof
from rbfound.units import hertz

# Frequencies [Hz]: evenly over the band, and about a peak as tangents of so many angles, so that a circle is round.
BAND = 1.0, 400.0
EVEN, ROUND = np.linspace(*BAND, 400), np.tan(np.linspace(-1.54, 1.54, 121))

CONTROLS = [
    slider("m", "mass m", "kg", 5.0, 100.0, 23.0, log=True),
    slider("c", "damper c", "N s/m", 20.0, 20000.0, 870.0, log=True),
    slider("k", "spring k", "N/m", 1e6, 1e8, 20.6e6, log=True),
]


def oscillator(settings: Mapping[str, float]) -> dict[str, Any]:
    """Receptance, circle and half-power points of m [kg], c [N s/m] and k [N/m]."""
    m, c, k = (float(settings[name]) for name in "mck")
    omega, zeta = sdof.natural(m, c, k)
    natural = float(hertz(omega))
    damped = float(hertz(abs(sdof.poles(m, c, k)[0].imag)))
    lines = np.concatenate([EVEN, natural * (1 + min(zeta, 0.5) * ROUND)])
    lines = np.unique(lines[(lines >= BAND[0]) & (lines <= BAND[1])])
    H = sdof.receptance(lines, m, c, k)
    size = np.abs(H)
    top = int(size.argmax())
    inside = 0 < top < len(lines) - 1
    peak = sdof.half_power(lines, size, top) if inside else sdof.Peak(*[float("nan")] * 4)
    points = {"peak": peak.frequency, "lower half-power point": peak.low, "upper half-power point": peak.high}
    points = {name: f for name, f in points.items() if np.isfinite(f)}
    at = {name: complex(sdof.receptance(f, m, c, k)) for name, f in points.items()}
    frequency = axis("frequency [Hz]", *BAND)

    def marks(y: Any) -> list[dict[str, Any]]:
        return [mark("" if f != peak.frequency else "peak", f, y(at[name]), 1) for name, f in points.items()]

    micro = {name: 1e6 * value for name, value in at.items()}
    figures = [
        figure("Magnitude", frequency, axis("|H| [m/N]", log=True), [line("", lines, size)], marks(abs)),
        figure(
            "Phase",
            frequency,
            axis("phase [deg]", -180.0, 0.0),
            [line("", lines, np.degrees(np.angle(H)))],
            marks(lambda h: np.degrees(np.angle(h))),
        ),
        figure(
            "Circle (Nyquist plot)",
            axis("real part [µm/N]"),
            axis("imaginary part [µm/N]"),
            [line("", 1e6 * H.real, 1e6 * H.imag)],
            [mark("peak" if name == "peak" else "", h.real, h.imag, 1) for name, h in micro.items()],
            equal=True,
        ),
    ]
    rows = {
        "natural frequency [Hz]": natural,
        "damped frequency [Hz]": damped,
        "damping ratio ζ [%]": 100 * zeta,
        "peak [Hz]": peak.frequency,
        "half-power points [Hz]": peak.low,
        "": peak.high,
        "ζ from them [%]": 100 * peak.damping,
    }
    return {"figures": figures, "tables": [listing("Read from the peak", {"": list(rows), " ": list(rows.values())})]}
