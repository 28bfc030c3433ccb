"""A virtual test rig: hammer, shaker and sensors on a foundation that is known, so that what they do wrong is seen.

Forces are limited to the band below half of the sampling rate, as the filters of a rig limit both channels alike. What
the foundation answers is exact on the lines of a record that is longer than what has to be known; blocks are cut out of
it, and what leaks out of them is truly there.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.measurement.averaging import USABLE, Blocks
from rbfound.units import from_hertz

Array = NDArray[np.float64]

Complex = NDArray[np.complex128]

# A blow's answer has died out when it is down by exp(-DEAD); before a blow or a burst there are so many samples of
# rest, in which the filter rings.
DEAD, REST = 25.0, 96


# The filter against aliases falls like erfc from -STEEP to STEEP: 1e-8 is left of it and of what it rings.
STEEP = 4.0


# Hits of one hand differ by so much in strength.
SCATTER = 0.15


# Lines that are summed at a time: keeps what is in memory to some megabytes.
BATCH = 8192


KINDS = ("random", "burst", "periodic")


@dataclass(frozen=True, eq=False)
class Sensors:
    """What the sensors of a rig add to the truth.

    Attributes
    ----------
    force_noise, response_noise : [N], [m/s^2]
        Standard deviation of the white noise on each sample.
    mass : [kg]
        Of an accelerometer for both directions, one at each bearing.
    roving : bool
        One accelerometer goes from bearing to bearing, so that each row of H has its own mass in its own place.
    gain : mapping from a seat to the factor on its acceleration
        1 unless given; -1 is a sensor mounted the wrong way round.
    """

    force_noise: float = 0.0
    response_noise: float = 0.0
    mass: float = 0.0
    roving: bool = False
    gain: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("force_noise", "response_noise", "mass"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} is {getattr(self, name)}: it must not be negative.")


def hammer(
    foundation: Foundation,
    sensors: Sensors | None = None,
    *,
    rate: float = 2560.0,
    block: float = 2.0,
    averages: int = 5,
    width: float = 8e-4,
    peak: float = 1000.0,
    seed: int = 0,
) -> Blocks:
    """Blows of a hammer, half-sine pulses, at each seat in turn.

    Parameters
    ----------
    foundation : Foundation
        The truth; each of its modes must be damped.
    sensors : Sensors
        Perfect ones unless given.
    rate, block : [Hz], [s]
        Samples a second, and the length of a block.
    averages : number of blows at each seat
    width, peak : [s], [N]
        Of the half-sine, and how strong it is in the mean.
    seed : where the random numbers begin

    Raises
    ------
    ValueError
        For a mode without damping, a gain of a seat that is not there, or a setting that is not positive.
    """
    sensors = sensors or Sensors()
    samples = _samples(rate, block, averages, width=width, peak=peak)
    rng = np.random.default_rng(seed)
    slowest = _slowest(foundation)
    length = samples * int(np.ceil(1 + DEAD / slowest / block))
    f = np.asarray(np.fft.rfftfreq(length, 1 / rate), dtype=float)
    pulse = np.sinc(f * width - 0.5) + np.sinc(f * width + 0.5)
    F = peak * width / 2 * rate * pulse * _closing(f, rate) * np.exp(-1j * from_hertz(f) * (REST / rate + width / 2))
    strength = 1 + SCATTER * rng.standard_normal((len(foundation.labels), averages, 1))
    force = np.fft.irfft(F, length)[:samples] * np.abs(strength)
    one = np.fft.irfft(np.moveaxis(_accelerance(foundation, f, sensors), 0, -1) * F, length)[..., :samples]
    return _sensed(foundation, sensors, rate, force, one[:, :, None] * np.abs(strength), rng)


def shaker(
    foundation: Foundation,
    kind: str,
    sensors: Sensors | None = None,
    *,
    rate: float = 2560.0,
    block: float = 2.0,
    averages: int = 20,
    rms: float = 20.0,
    burst: float = 0.5,
    seed: int = 0,
) -> Blocks:
    """A shaker at each seat in turn, with one of three random forces.

    Parameters
    ----------
    foundation, sensors, rate, block, seed : as for `hammer`
    kind : "random", "burst" or "periodic"
        Noise that never ends, from which blocks are cut; noise in the first part of each block and silence behind it,
        in which the answer should die out; noise that repeats block by block until nothing changes any more.
    averages : number of blocks at each seat
    rms : [N]
        Of the force while it acts.
    burst : the part of a block in which a burst acts

    Raises
    ------
    ValueError
        As `hammer`, and for another kind.
    """
    sensors = sensors or Sensors()
    samples = _samples(rate, block, averages, rms=rms, burst=burst)
    if kind not in KINDS:
        raise ValueError(f"kind is {kind!r}: a shaker can be {', '.join(KINDS)}.")
    _slowest(foundation)
    rng = np.random.default_rng(seed)
    seats = len(foundation.labels)
    records, length = (averages, samples) if kind == "periodic" else (1, averages * samples)
    raw = rms * rng.standard_normal((seats, records, length))
    if kind == "burst":
        within = np.arange(length) % samples
        raw *= (within >= REST) & (within < REST + burst * samples)
    f = np.asarray(np.fft.rfftfreq(length, 1 / rate), dtype=float)
    F = np.fft.rfft(raw) * _closing(f, rate)
    A = np.moveaxis(_accelerance(foundation, f, sensors), 0, -1)
    force, response = (np.fft.irfft(part, length) for part in (F, A[:, :, None] * F))
    shape = (averages, samples)
    return _sensed(foundation, sensors, rate, force.reshape(seats, *shape), response.reshape(seats, seats, *shape), rng)


def with_mass(frf: FRF, mass: float, *, roving: bool = False) -> FRF:
    """FRFs with a mass [kg] at every bearing, felt in both directions; a negative one takes sensors away again.

    x = H (f + omega^2 m x), so that (I - omega^2 m H) x = H f. Where one accelerometer roves, each row of H has its
    mass at its own bearing, and of the H in parentheses what ties two bearings is left out.
    """
    return replace(frf, H=_loaded(frf.H, np.asarray(from_hertz(frf.frequency)), frf.labels, mass, roving))


def _samples(rate: float, block: float, averages: int, **settings: float) -> int:
    settings = {"rate": rate, "block": block, "averages": averages, **settings}
    for name, value in settings.items():
        if not value > 0:
            raise ValueError(f"{name} is {value}: it must be positive.")
    return round(rate * block)


def _slowest(foundation: Foundation) -> float:
    """Decay of the mode that lasts longest [1/s]."""
    modes = foundation.modes()
    decay = -modes.poles.real
    if not (decay > 0).all():
        raise ValueError(
            f"The mode at {modes.frequency[decay.argmin()]:g} Hz is not damped: on this rig every motion must die out."
        )
    return float(decay.min())


def _closing(f: Array, rate: float) -> Array:
    """The filter against aliases: open up to the last line that is shown, closed at half of the sampling rate."""
    past = 2 * (f / rate - USABLE) / (0.5 - USABLE) - 1
    return np.asarray(special.erfc(STEEP * past) / 2)


def _accelerance(foundation: Foundation, f: Array, sensors: Sensors) -> Complex:
    """(n, outputs, inputs) on lines from 0 Hz, with the sensors' mass on the foundation."""
    omega = np.asarray(from_hertz(f))
    H = _loaded(_receptance(foundation, omega), omega, foundation.labels, sensors.mass, sensors.roving)
    return np.asarray(-(omega**2)[:, None, None] * H)


def _receptance(foundation: Foundation, omega: Array) -> Complex:
    """What `Foundation.frf` gives, but from poles and residues: a rig needs tens of thousands of lines."""
    A, L = foundation.system().state_matrix()
    n, seats = len(L), len(foundation.labels)
    at = np.linalg.solve(L, foundation.B.T)
    # displacements and velocities in one size, for the sake of the eigenvectors
    rate = np.sqrt(np.abs(A[n:, :n]).max())
    A[:n, n:], A[n:, :n] = A[:n, n:] * rate, A[n:, :n] / rate
    poles, V = np.linalg.eig(A)
    left, right = at.T @ V[:n], np.linalg.solve(V, np.vstack([np.zeros((n, seats)), at / rate]))
    residues = np.einsum("im,mj->mij", left, right).reshape(2 * n, seats**2)
    parts = [omega[k : k + BATCH] for k in range(0, len(omega), BATCH)]
    H = np.concatenate([1 / (1j * part[:, None] - poles) @ residues for part in parts])
    return H.reshape(-1, seats, seats)


def _loaded(H: Complex, omega: Array, labels: tuple[str, ...], mass: float, roving: bool) -> Complex:
    if mass == 0:
        return H
    one_bearing = np.equal.outer([label[1:] for label in labels], [label[1:] for label in labels])
    felt = np.where(one_bearing, H, 0) if roving else H
    return np.asarray(np.linalg.solve(np.eye(len(labels)) - mass * (omega**2)[:, None, None] * felt, H))


def _sensed(
    foundation: Foundation,
    sensors: Sensors,
    rate: float,
    force: Array,
    response: Array,
    rng: np.random.Generator,
) -> Blocks:
    """What the channels show: gains, then noise."""
    labels = foundation.labels
    unknown = [seat for seat in sensors.gain if seat not in labels]
    if unknown:
        raise ValueError(f"gain has {unknown[0]!r}: the seats are {', '.join(labels)}.")
    gain = np.array([sensors.gain.get(label, 1.0) for label in labels])
    response = gain[:, None, None, None] * response
    return Blocks(
        rate,
        force + sensors.force_noise * rng.standard_normal(force.shape),
        response + sensors.response_noise * rng.standard_normal(response.shape),
        labels,
    )
