"""Error bars: from the covariance of fitted modes to the natural frequencies and critical speeds of the machine.

A pole of D(lambda) = lambda^2 M + lambda (C + G) + K moves with a parameter p by

    d lambda = - psi' (dD/dp) phi / (psi' (2 lambda M + C + G) phi),      D phi = 0,  psi' D = 0

and with all parameters of a fit, whose covariance is known, the spread of each pole follows. (Sensitivity of poles:
Lancaster 1964, DOI 10.1007/BF01386060; Fox and Kapoor 1968, DOI 10.2514/3.5008.) Linear, so good while the error bars
are small against the distance of two poles; `monte_carlo` tells whether they are.
"""

import os
from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from rbfound.campbell_diagram import Campbell
from rbfound.files import read_arrays, replaced
from rbfound.frf import FRF
from rbfound.identification.modal_fit import ModalFit, fit_modes
from rbfound.machine import Machine, mount
from rbfound.parallel import one_thread, run
from rbfound.rotor import Bearing, Rotor
from rbfound.units import hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class ErrorBars:
    """Poles of a machine with their standard deviations; all of one shape, (m,), or (speeds, m) of a diagram.

    Attributes
    ----------
    poles : complex [rad/s]
        nan where a branch of the diagram has ended.
    frequency_deviation : [Hz]   of the damped natural frequency
    damping_deviation : [-]
    """

    poles: Complex
    frequency_deviation: Array
    damping_deviation: Array

    @property
    def frequency(self) -> Array:
        """Damped natural frequencies [Hz]."""
        return np.asarray(hertz(self.poles.imag))

    @property
    def damping(self) -> Array:
        """Damping ratios [-]."""
        return np.asarray(-self.poles.real / np.abs(self.poles))

    def interval(self, level: float = 0.95) -> tuple[Array, Array]:
        """Lowest and highest frequency [Hz] of the interval that holds the true one with this probability."""
        half = _quantile(level) * self.frequency_deviation
        return self.frequency - half, self.frequency + half


@dataclass(frozen=True, eq=False)
class CriticalBars:
    """Critical speeds with their standard deviations, ascending: speed and deviation (c,) [rad/s]."""

    speed: Array
    deviation: Array

    def interval(self, level: float = 0.95) -> tuple[Array, Array]:
        """Lowest and highest speed [rad/s] of the interval that holds the true one with this probability."""
        half = _quantile(level) * self.deviation
        return self.speed - half, self.speed + half


@one_thread
def error_bars(
    fit: ModalFit, machine: Machine, speed: float = 0.0, *, above: float = 1.0, below: float = np.inf
) -> ErrorBars:
    """How sure the natural frequencies and dampings of a machine are that stands on an identified foundation.

    Parameters
    ----------
    fit : ModalFit
    machine : Machine
        mount(rotor, bearings, on=fit.foundation()); rotor and bearings are taken to be known.
    speed : [rad/s]
    above, below : [Hz]
        Which natural frequencies are wanted.

    Raises
    ------
    ValueError
        When the machine does not stand on this fit.
    """
    modes = machine.at(speed).modes().above(above).below(below)
    return _bars(fit, machine, speed, modes.poles)


@one_thread
def campbell_bars(fit: ModalFit, diagram: Campbell) -> ErrorBars:
    """Error bars of each point of a Campbell diagram, (speeds, m), whose machine stands on an identified foundation.

    Parameters and errors are those of `error_bars`.
    """
    rows = [
        _bars(fit, diagram.machine, float(speed), poles)
        for speed, poles in zip(diagram.speeds, diagram.poles, strict=True)
    ]
    deviations = (
        np.array([getattr(row, name) for row in rows]) for name in ("frequency_deviation", "damping_deviation")
    )
    return ErrorBars(diagram.poles, *deviations)


@one_thread
def critical_bars(fit: ModalFit, diagram: Campbell) -> CriticalBars:
    """Error bars of the critical speeds of a Campbell diagram.

    A critical speed is where Im lambda(speed) = speed, so that it moves by d Im lambda / (1 - d Im lambda / d speed).
    """
    critical = diagram.critical_speeds()
    deviation = np.empty(len(critical.speed))
    for k, (speed, zeta) in enumerate(zip(critical.speed, critical.damping, strict=True)):
        pole = speed * complex(-zeta / np.sqrt(1 - zeta**2), 1)
        slope, turning = _slopes(fit, diagram.machine, float(speed), pole)
        along = slope.imag / (1 - turning.imag)
        deviation[k] = _spread(fit, along)
    return CriticalBars(critical.speed, deviation)


@one_thread
def monte_carlo(
    fit: ModalFit,
    frequency: ArrayLike,
    rotor: Rotor,
    bearings: Mapping[float, Bearing],
    *,
    speed: float = 0.0,
    above: float = 1.0,
    below: float = np.inf,
    count: int = 100,
    seed: int = 0,
    executor: Executor | None = None,
    progress: bool | None = None,
    kept: str | os.PathLike[str] | None = None,
) -> Complex:
    """Poles of the machine on foundations that the same measurement, done again, could have given: (count, m) [rad/s].

    Each time the FRFs of the fit get fresh noise of the size that was estimated, and are identified anew. Column by
    column the poles belong to those of `error_bars`, whose linear road this checks; a mode that one of the foundations
    lacks has the pole nearest to it.

    Parameters
    ----------
    fit : ModalFit
    frequency : (n,) [Hz]
        The lines of the data.
    rotor, bearings : what stands on the foundation
    speed, above, below : as for `error_bars`
    count, seed : how many, and where their random numbers begin
    executor, progress : see `rbfound.parallel.run`
    kept : path of a .npz file, optional
        Holds what has been computed, after each foundation. Called again with the same arguments, after an interrupt or
        with a larger `count`, the function goes on from there.

    Raises
    ------
    ValueError
        When `kept` holds the poles of something else, or is damaged.
    """
    machine = mount(rotor, bearings, on=fit.foundation())
    poles = machine.at(speed).modes().above(above).below(below).poles
    lines = np.asarray(frequency, dtype=float)
    lines = lines[(lines >= fit.band[0]) & (lines <= fit.band[1])]
    task = partial(_again, fit, lines, rotor, bearings, speed, poles)
    seeds = np.random.SeedSequence(seed).spawn(count)
    bar: dict[str, Any] = {"executor": executor, "progress": progress, "title": "machines"}
    if kept is None:
        return np.array(run(task, seeds, **bar)).reshape(count, len(poles))
    path = Path(kept)
    errors = 0.0 if fit.errors is None else fit.errors
    data = (fit.Phi, fit.omega, fit.C, fit.noise, fit.band, fit.relative, errors, lines)
    told = repr(
        [np.asarray(part).tobytes() for part in data] + [rotor, sorted(bearings.items()), speed, above, below, seed]
    )
    asked = sha256(told.encode()).hexdigest()
    begun = _begun(path, asked) if path.exists() else []

    def keep(found: list[Complex]) -> None:
        replaced(path, lambda whole: np.savez(whole, asked=np.array(asked), poles=np.array(found)))

    return np.array(run(task, seeds, **bar, begun=begun, keep=keep)).reshape(count, len(poles))


def without_window(fit: ModalFit, decay: float) -> ModalFit:
    """A fit to FRFs under an exponential window, less what the window has added to each mode of the band.

    H(i omega + decay) has the poles of H moved by -decay and the same shapes: omega'^2 = omega^2 + 2 zeta omega decay +
    decay^2, zeta' omega' = zeta omega + decay. Pseudo-modes stay as they are. The covariance goes along.

    Parameters
    ----------
    decay : [1/s]
        As for `rbfound.measurement.averaging.spectra`.

    Raises
    ------
    ValueError
        When a mode has less damping than the window alone gives, or when damping couples the modes.
    """
    if fit.coupling is not None:
        raise ValueError("The damping of this fit couples the modes: the window's part cannot be taken out of it.")
    own = fit.inside
    was, rest = fit.omega, fit.zeta * fit.omega - decay
    if (rest[own] <= 0).any():
        k = np.flatnonzero(own & (rest <= 0))[0]
        raise ValueError(
            f"The mode at {fit.natural_frequency[k]:.4g} Hz decays with {fit.zeta[k] * was[k]:.3g} 1/s, the window "
            f"alone with {decay:g} 1/s: no damping would be left. Was this window on the data?"
        )
    omega = np.where(own, np.sqrt(was**2 - 2 * fit.zeta * was * decay + decay**2), was)
    zeta = np.where(own, rest / omega, fit.zeta)
    # derivatives of log omega and log zeta by those of the fit
    both = np.where(own, decay * fit.zeta * was / omega**2, 0)
    frequency = np.where(own, (was / omega) ** 2, 1) - both
    swing = np.where(own, fit.zeta * was / np.where(own, rest, 1), 1)
    n, m = fit.Phi.size, len(was)
    J = np.eye(n + 2 * m)
    at, behind = n + np.arange(m), n + m + np.arange(m)
    J[at, at], J[at, behind] = frequency, -both
    J[behind, at], J[behind, behind] = np.where(own, swing - frequency, 0), swing + both
    return replace(fit, omega=omega, zeta=zeta, covariance=J @ fit.covariance @ J.T)


def _begun(path: Path, asked: str) -> list[Complex]:
    """The poles that an earlier `monte_carlo` kept, if it was asked the same."""
    stored = read_arrays(path, ("asked", "poles"))[0]
    if "poles" not in stored or str(stored.get("asked")) != asked:
        raise ValueError(f"{path} is not of this fit, rotor, speed and seed: name another file, or remove it.")
    return list(stored["poles"])


def _quantile(level: float) -> float:
    if not 0 < level < 1:
        raise ValueError(f"level is {level}: the probability of an interval lies between 0 and 1, 0.95 for instance.")
    return float(special.ndtri(0.5 + level / 2))


def _bars(fit: ModalFit, machine: Machine, speed: float, poles: Complex) -> ErrorBars:
    frequency, damping = np.full(len(poles), np.nan), np.full(len(poles), np.nan)
    for k in np.flatnonzero(np.isfinite(poles)):
        slope, _ = _slopes(fit, machine, speed, poles[k])
        size = abs(poles[k])
        # of -Re / |pole|
        along = -slope.real / size + poles[k].real * np.real(poles[k].conj() * slope) / size**3
        frequency[k], damping[k] = hertz(_spread(fit, slope.imag)), _spread(fit, along)
    return ErrorBars(poles, frequency, damping)


def _spread(fit: ModalFit, slope: Array) -> float:
    return float(np.sqrt(slope @ fit.covariance @ slope))


def _slopes(fit: ModalFit, machine: Machine, speed: float, pole: complex) -> tuple[Complex, complex]:
    """Derivatives of a pole by the parameters of the fit in the order of its covariance, and by the speed."""
    n = len(machine.mesh.M)
    on = machine.foundation
    if on is None or not np.array_equal(on.B, fit.Phi) or not np.array_equal(on.C, fit.C):
        raise ValueError("The machine does not stand on this fit: mount the rotor on fit.foundation().")
    C = machine.C + speed * machine.G
    left, _, right = np.linalg.svd(pole**2 * machine.M + pole * C + machine.K)
    psi, phi = left[:, -1].conj(), right[-1].conj()
    rate = psi @ (2 * pole * machine.M + C) @ phi
    turning = psi @ machine.G @ phi
    # forces of the bearings upon the seats in either motion
    before, behind = np.zeros((2, len(fit.Phi)), dtype=complex)
    for k, (z, bearing) in enumerate(machine.bearings.items()):
        seat, node = slice(2 * k, 2 * k + 2), 4 * machine.mesh.node(z)
        Z = bearing.K + pole * bearing.C
        before[seat], behind[seat] = (
            tied @ (v[node : node + 2] - fit.Phi[seat] @ v[n:]) for tied, v in ((Z.T, psi), (Z, phi))
        )
    of_shapes = np.outer(behind, psi[n:]) + np.outer(before, phi[n:])
    psi, phi = psi[n:], phi[n:]
    of_damping = -pole / 2 * (psi * (fit.C @ phi) + (fit.C @ psi) * phi)
    of_frequency = -2 * psi * phi * fit.omega**2 + of_damping
    moved = np.concatenate([of_shapes.ravel(), of_frequency, of_damping])
    if fit.coupling is not None:
        half = np.sqrt(2 * fit.zeta * fit.omega)
        both = np.outer(half * psi, half * phi)
        moved = np.concatenate([moved, -pole * (both + both.T)[np.tril_indices(len(half), -1)]])
    return moved / rate, complex(-pole * turning / rate)


def _again(
    fit: ModalFit,
    frequency: Array,
    rotor: Rotor,
    bearings: Mapping[float, Bearing],
    speed: float,
    poles: Complex,
    seed: np.random.SeedSequence,
) -> Complex:
    """Poles of the machine on the foundation of one more measurement, each the nearest to one of the given."""
    clean = fit.foundation().frf(frequency)
    error = np.random.default_rng(seed).standard_normal((*clean.H.shape, 2)) @ [1, 1j] / np.sqrt(2)
    size = np.abs(clean.H) if fit.relative else 1.0 if fit.errors is None else fit.errors
    noisy = FRF(clean.frequency, clean.H + fit.noise * size * error, clean.labels)
    foundation = fit_modes(noisy, band=fit.band, relative=fit.relative, errors=fit.errors).foundation()
    found = mount(rotor, bearings, on=foundation).at(speed).modes().poles
    return np.asarray(found[np.abs(poles[:, None] - found).argmin(axis=1)])
