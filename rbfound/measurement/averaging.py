"""From blocks of time to FRFs: windows, averaged spectra, H1, H2 and coherence, as a spectrum analyser makes them.

With the spectra F of the force and X of the response in each block, and a bar for the mean over all blocks:

    H1 = mean(X F*) / mean(F F*),   H2 = mean(X X*) / mean(F X*),   coherence = |mean(X F*)|^2 / (mean(F F*) mean(X X*))

Noise on the response leaves H1 right and makes H2 too large, noise on the force leaves H2 right and makes H1 too small.
(Bendat and Piersol, Random Data, 2010, DOI 10.1002/9781118032428, chapters 6 and 9.)
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from rbfound.frf import FRF, SEATS
from rbfound.units import from_hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Analysers show lines up to this part of the sampling rate: above it their filter against aliases begins to close.
USABLE = 1 / 2.56

# Over this part of its length more a force window falls to zero.
FALL = 0.25


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of time of a modal test: one force at a time, all accelerations at once.

    Attributes
    ----------
    rate : samples a second [Hz]
    force : (inputs, averages, samples) [N]
    response : (outputs, inputs, averages, samples) [m/s^2]
    labels : names of the seats, for inputs and outputs
    """

    rate: float
    force: Array
    response: Array
    labels: tuple[str, ...] = SEATS

    def __post_init__(self) -> None:
        seats = len(self.labels)
        if self.force.ndim != 3 or len(self.force) != seats or self.response.shape != (seats, *self.force.shape):
            raise ValueError(
                f"force has shape {self.force.shape}, response {self.response.shape}: with the seats "
                f"{', '.join(self.labels)} they must be ({seats}, averages, samples) and ({seats}, {seats}, averages, "
                "samples)."
            )
        if not self.rate > 0:
            raise ValueError(f"rate is {self.rate:g} Hz: it must be positive.")

    @property
    def time(self) -> Array:
        """Time from the start of a block [s], (samples,)."""
        return np.arange(self.force.shape[-1]) / self.rate


@dataclass(frozen=True, eq=False)
class Spectra:
    """Means over the blocks, from which H1, H2 and the coherence follow.

    Attributes
    ----------
    frequency : (n,) [Hz]
    force : (n, inputs)
        Mean of |F|^2.
    response, cross : (n, outputs, inputs)
        Means of |X|^2 and of X times the conjugate of F.
    averages : number of blocks
    decay : [1/s]
        Of the exponential window, 0 without.
    alike : float
        How many neighbouring lines share one error: a window makes them alike, and n lines tell no more than n / alike.
    labels : names of the seats
    """

    frequency: Array
    force: Array
    response: Array
    cross: Complex
    averages: int
    decay: float = 0.0
    alike: float = 1.0
    labels: tuple[str, ...] = SEATS

    def h1(self) -> FRF:
        """Receptances by H1: right with noise on the response, too small with noise on the force."""
        return self._receptance(self.cross / self.force[:, None, :])

    def h2(self) -> FRF:
        """Receptances by H2: right with noise on the force, too large with noise on the response."""
        return self._receptance(self.response / self.cross.conj())

    def coherence(self) -> Array:
        """Part of the response's power that the force explains, (n, outputs, inputs), 0 to 1; of one block it is 1."""
        return np.asarray(np.abs(self.cross) ** 2 / (self.force[:, None, :] * self.response))

    def deviation(self) -> Array:
        """Standard deviation of |H1| as a part of it, sqrt((1 - c) / (2 averages c)), (n, outputs, inputs).

        So is that of its phase [rad]; the complex error has sqrt(2) times as much. For noise on the response.
        """
        c = self.coherence()
        return np.asarray(np.sqrt(np.maximum(1 - c, 0) / (2 * self.averages * c)))

    def errors(self, lines: int = 9) -> Array:
        """Standard deviation of the complex error of `h1()` [m/N], (n, outputs, inputs), for `rbfound.fit_modes`.

        From the power that the force does not explain, mean |X|^2 (1 - coherence), which has averages - 1 of its
        averages left. It is taken as even over some lines: one line's own guess, of five blocks say, is too rough
        to weigh with. Each line's share of it grows by what the window made alike, as if all lines were independent.

        Raises
        ------
        ValueError
            With one block, which cannot tell.
        """
        if self.averages < 2:
            raise ValueError("One block has a coherence of 1, noise or not: errors need two blocks or more.")
        rest = self.response * (1 - self.coherence()) * self.averages / (self.averages - 1)
        even = uniform_filter1d(np.maximum(rest, 0), lines, axis=0, mode="nearest")
        s = np.abs(1j * from_hertz(self.frequency) + self.decay)[:, None, None]
        return np.asarray(np.sqrt(self.alike * even / (self.averages * self.force[:, None, :])) / s**2)

    def _receptance(self, accelerance: Complex) -> FRF:
        # under an exponential window all happens at i omega + decay in place of i omega, two time derivatives too
        s = 1j * from_hertz(self.frequency) + self.decay
        notes = (f"An exponential window added {self.decay:g} 1/s to the decay of every mode.",) if self.decay else ()
        return FRF(self.frequency, accelerance / s[:, None, None] ** 2, self.labels, notes)


def spectra(blocks: Blocks, *, hann: bool = False, force_window: float | None = None, decay: float = 0.0) -> Spectra:
    """Averaged spectra of all blocks, from the first line above 0 Hz to 1/2.56 of the sampling rate.

    Parameters
    ----------
    hann : bool
        Hann's window on both channels: for random forces that know no blocks.
    force_window : [s]
        How much of a block's force is kept, for a hammer: behind its pulse there is only noise.
    decay : [1/s]
        Of an exponential window on both channels. With it H(i omega + decay) is measured, exactly: every pole moves
        by -decay. `rbfound.identification.without_window` takes that from a fit.

    Raises
    ------
    ValueError
        When the force window is not positive, the decay negative, or a force vanishes on a line.
    """
    t, samples = blocks.time, blocks.force.shape[-1]
    if decay < 0 or (force_window is not None and force_window <= 0):
        raise ValueError(
            f"decay is {decay:g} 1/s, force_window {force_window or 0:g} s: neither may be negative, nor a window 0."
        )
    window = np.exp(-decay * t)
    # a blow's answer lies where its window is 1; that of noise is everywhere, and force and answer are alike both
    alike = 1 / np.mean(window**2)
    if hann:
        window = window * np.sin(np.pi * np.arange(samples) / samples) ** 2
        alike = np.mean(window**4) / np.mean(window**2) ** 2
    gate = np.ones(samples)
    if force_window is not None:
        past = np.clip((t - force_window) / (FALL * force_window), 0, 1)
        gate = (1 + np.cos(np.pi * past)) / 2
    f = np.asarray(np.fft.rfftfreq(samples, 1 / blocks.rate), dtype=float)
    shown = (f > 0) & (f <= USABLE * blocks.rate * (1 + 1e-12))
    F = np.fft.rfft(blocks.force * (window * gate))[..., shown]
    X = np.fft.rfft(blocks.response * window)[..., shown]
    force = np.mean(np.abs(F) ** 2, axis=1).T
    if (force == 0).any():
        line, seat = np.argwhere(force == 0)[0]
        raise ValueError(f"The force at {blocks.labels[seat]} has nothing at {f[shown][line]:g} Hz: no FRF there.")
    response = np.moveaxis(np.mean(np.abs(X) ** 2, axis=2), -1, 0)
    cross = np.moveaxis(np.einsum("ijan,jan->ijn", X, F.conj()) / F.shape[1], -1, 0)
    return Spectra(f[shown], force, response, cross, F.shape[1], decay, float(alike), blocks.labels)
