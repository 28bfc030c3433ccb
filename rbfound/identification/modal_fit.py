"""From sixteen FRFs to a foundation with all its modes, and what is known of each of them.

Poles from the poly-reference method start a fit of real mass-normalised modes to all FRFs at once, whose errors are
taken relative to each |H|: maximum likelihood when the noise is. What is fitted is reciprocal and passive at every
frequency, whatever the data are. What lies outside the band is the sum of a few pseudo-modes; only that sum, inside the
band, has to be right. A mode is added wherever it lowers the misfit by more than noise would.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rbfound.foundation import Foundation, modal_foundation
from rbfound.frf import FRF, SEATS
from rbfound.identification.added_modes import deviation_of, deviation_of_poles, inside
from rbfound.identification.decimation import compressed, noise_of, reweighted, scale_of_data
from rbfound.identification.least_squares import (
    SURE,
    Complex,
    Problem,
    State,
    cost,
    problem_of,
    receptances,
    refine,
)
from rbfound.identification.model_order import (
    ENOUGH,
    FINEST,
    completed,
    counted,
    coupled,
    covariance_of,
    doubtful,
    likelier,
    pruned,
    started,
    uncrowded,
    variance_of,
)
from rbfound.identification.plscf import largest_order, lines_in, stabilisation, stable_poles
from rbfound.measurement import NO_PHASE, has_phase, own_errors
from rbfound.parallel import one_thread
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]

# The most modes that are added to those the poles give and one a seat; with a full damping matrix, steps of that.
MOST, MOST_COUPLED = 16, 24


# A fit that misses the data by this many times their size is none.
ASTRAY = 2.0
# One that misses |H| by this part, or by so many times its errors, is no model of these data.
GROSS, MANY = 0.5, 20.0


# Orders of the denominator that are tried, where the lines allow them.
ORDERS = range(12, 25, 2)


# Beyond this, or below its reciprocal [m/N], squares of receptances leave the range of numbers.
HUGE = 1e100


@dataclass(frozen=True, eq=False)
class ModalFit:
    """Real modes that were fitted to FRFs, ascending in frequency.

    Attributes
    ----------
    Phi : (seats, m) [1/sqrt(kg)]
    omega : (m,) [rad/s]
    zeta : (m,) [-]
    inside : (m,) bool
        The modes of the band; the others are pseudo-modes that stand for what lies outside it.
    unsure : (m,) bool
        Modes of the band that the data hardly determine.
    covariance : (p, p)
        Of phi (seats, m) row by row, log omega (m,), log zeta (m,), and of the entries of the coupling below its
        diagonal, if there is any, row by row: the noise through the linearised fit.
    noise : float
        Standard deviation of the complex error of one FRF, as a part of |H| (relative=False: [m/N]; with errors: of
        these, and no less than 1), estimated from its change from line to line.
    misfit : (outputs, inputs)
        Root mean square of data - fit of each FRF, in the same unit. What exceeds the noise is an error of the model.
    band : (lowest, highest) [Hz]
    labels : names of the seats
    relative : whether errors are taken relative to |H|
    errors : (n, seats, seats) [m/N]
        Those that were given, or those that neighbouring lines tell, on the lines of the band.
    told : (low, high)
        If the lines told them: what part of |H| they are, but for a tenth of them at either end.
    coupling : (m, m)
        C_ab over the root of C_aa C_bb, where damping couples the modes: dashpots, isolators and soil do that.
    """

    Phi: Array
    omega: Array
    zeta: Array
    inside: NDArray[np.bool_]
    unsure: NDArray[np.bool_]
    covariance: Array
    noise: float
    misfit: Array
    band: tuple[float, float]
    labels: tuple[str, ...] = SEATS
    relative: bool = True
    errors: Array | None = None
    told: tuple[float, float] | None = None
    coupling: Array | None = None

    @property
    def C(self) -> Array:
        """Damping matrix [1/s], (m, m)."""
        own = 2 * self.zeta * self.omega
        return np.diag(own) if self.coupling is None else np.sqrt(own)[:, None] * self.coupling * np.sqrt(own)

    @property
    def natural_frequency(self) -> Array:
        """Undamped natural frequencies [Hz], (m,)."""
        return np.asarray(hertz(self.omega))

    @property
    def deviation(self) -> tuple[Array, Array]:
        """Standard deviations of frequency and of damping, each as a part of its value, (m,) and (m,)."""
        n, m = self.Phi.size, len(self.omega)
        spread = np.sqrt(np.maximum(np.diag(self.covariance), 0))
        return spread[n : n + m], spread[n + m : n + 2 * m]

    def foundation(self) -> Foundation:
        """The fit as a foundation, with notes on how good it is."""
        made = modal_foundation(self.Phi, self.omega, self.zeta, self.labels, _notes(self))
        return replace(made, C=self.C)


def identify(
    frf: FRF,
    *,
    band: tuple[float, float] | None = None,
    modes: int | None = None,
    relative: bool | None = None,
    errors: Array | None = None,
) -> Foundation:
    """A foundation from its measured FRFs: all modes of a band, and the sum of those outside it.

    `print(foundation)` says how well it fits, which modes were found in the band, and which of them are unsure.
    Parameters and errors are those of `fit_modes`, which gives the covariance too.
    """
    return fit_modes(frf, band=band, modes=modes, relative=relative, errors=errors).foundation()


@one_thread
def fit_modes(
    frf: FRF,
    *,
    band: tuple[float, float] | None = None,
    modes: int | None = None,
    relative: bool | None = None,
    errors: Array | None = None,
) -> ModalFit:
    """Real modes fitted to all FRFs at once.

    Parameters
    ----------
    frf : FRF
        Its symmetric part is fitted: a foundation is reciprocal.
    band : (lowest, highest) [Hz]
        Unless given, all lines but those at 0 Hz.
    modes : int
        How many modes the band holds, if you know.
    relative : bool
        Whether an FRF's error grows with |H| (a calibration, a finite number of averages) or is the same on all lines
        and in all FRFs. Unless given, it grows with |H|, but where neighbouring lines tell otherwise: then the errors
        are those that they tell (`rbfound.measurement.noise.own_errors`).
    errors : (n, seats, seats) [m/N]
        Standard deviation of the complex error of each receptance on each line, where a measurement tells it, as
        `rbfound.measurement.averaging.Spectra.errors` does. Then `relative` counts for nothing.

    Raises
    ------
    ValueError
        When the band lies outside the data or holds too few lines, `modes` is below 1 or cannot be told apart, an
        error is not positive, or no mode is found.
    """
    part, band = lines_in(frf, band)
    _check(part, band, modes)
    told = None
    if errors is not None:
        errors = _errors(frf, part, errors)
    elif relative is None:
        errors = own_errors(part.frequency, part.H)
        if errors is not None:
            low, high = np.quantile(errors / np.maximum(np.abs(part.H), np.finfo(float).tiny), (0.1, 0.9))
            told = float(low), float(high)
    relative = errors is None and relative is not False
    problem = problem_of(np.asarray(from_hertz(part.frequency)), part.H, relative, errors)
    poles = _poles(part)
    edges = problem.edges
    zeta = float(np.clip(np.median(-poles.real / np.abs(poles)), 2e-3, 0.05)) if len(poles) else 0.02
    problem = compressed(problem, poles, relative, FINEST * scale_of_data(problem))
    found: list[State] = []

    def other() -> State | None:
        full, good = coupled(problem, poles, zeta, MOST_COUPLED)
        found.extend([full] if full is not None else [])
        return full if good else None

    state = completed(problem, started(problem, poles, zeta, MOST), zeta, MOST, other)
    _check_any(len(state.omega), band)
    if state.V is None:
        state = uncrowded(problem, state)
    covariance, spread = covariance_of(problem, state)
    suspects = inside(state, edges) & doubtful(problem, state, deviation_of(state, covariance), spread)
    state = pruned(problem, state, np.flatnonzero(suspects))
    _check_any(len(state.omega), band)
    if found and not likelier(problem, state, found[0]):
        state = found[0]
    if modes is not None:
        state = counted(problem, state, zeta, modes)
    if relative:
        problem = reweighted(problem, state)
    # nearly all of the way on the nodes, the rest on all lines
    small = ENOUGH * variance_of(problem, state)
    for lines in (problem.thinned(), problem):
        state, _ = refine(lines, state, small=small, damping=SURE, iterations=40, held=~inside(state, edges))
    if state.V is None:
        state = state.only(np.argsort(state.omega))
    _check_any(int(inside(state, edges).sum()), band)
    _check_near(problem, state, band)
    return replace(_judged(problem, part, state, band, relative, errors), told=told)


def _check(part: FRF, band: tuple[float, float], modes: int | None) -> None:
    seats, lines = len(part.labels), len(part.frequency)
    if modes is not None and modes < 1:
        raise ValueError(f"modes is {modes}: a foundation has at least one mode.")
    # twice as many numbers as parameters of one mode and one pseudo-mode a seat, and of the modes that are asked for
    least = int(np.ceil(2 * (seats + max(modes or 0, 1)) * (seats + 2) / (seats * (seats + 1))))
    if lines < least:
        raise ValueError(
            f"Only {lines} lines lie between {band[0]:g} and {band[1]:g} Hz: {seats} seats and {modes or 'some'} modes "
            f"need at least {least}."
        )
    largest = np.abs(part.H).max()
    if largest == 0:
        raise ValueError(f"All receptances between {band[0]:g} and {band[1]:g} Hz are zero: nothing moves.")
    if not 1 / HUGE < largest < HUGE:
        raise ValueError(f"The largest receptance is {largest:.1g} m/N: is its unit right?")
    if not has_phase(part):
        raise ValueError(NO_PHASE)


def _check_any(found: int, band: tuple[float, float]) -> None:
    if not found:
        raise ValueError(
            f"No mode was found between {band[0]:g} and {band[1]:g} Hz: the FRFs have no resonance there, or too few "
            "lines."
        )


def _check_near(problem: Problem, state: State, band: tuple[float, float]) -> None:
    """A search that went astray must not end as a foundation: no model at all misses the data by their own size."""
    missed = float(np.sqrt(cost(problem, state) / np.sum(np.abs(problem.weight * problem.H) ** 2)))
    if missed > ASTRAY:
        raise ValueError(
            f"The fit did not converge: from {band[0]:g} to {band[1]:g} Hz it misses the FRFs by {missed:.2g} times "
            "their size. Look at them with rbfound.check, give another band, or say how many modes it holds."
        )


def _errors(frf: FRF, part: FRF, errors: Array) -> Array:
    """The errors on the lines of the band."""
    if np.shape(errors) != frf.H.shape:
        raise ValueError(f"errors has shape {np.shape(errors)}: there must be one for each entry of H, {frf.H.shape}.")
    errors = np.asarray(errors, dtype=float)[np.isin(frf.frequency, part.frequency)]
    bad = ~(np.isfinite(errors) & (errors > 0))
    if bad.any():
        line, i, j = np.argwhere(bad)[0]
        raise ValueError(
            f"errors at {part.frequency[line]:g} Hz, response {frf.labels[i]} to a force at {frf.labels[j]}, is "
            f"{errors[line, i, j]}: a standard deviation must be positive and finite."
        )
    return errors


def _poles(part: FRF) -> Complex:
    """Stable poles, or none: then every mode is looked for in what is left of the data."""
    try:
        enough = largest_order(len(part.frequency), len(part.labels)) >= ORDERS[-1]
        return stable_poles(stabilisation(part, ORDERS if enough else None))[0]
    except ValueError:
        return np.zeros(0, dtype=complex)


def _judged(
    problem: Problem,
    part: FRF,
    state: State,
    band: tuple[float, float],
    relative: bool,
    errors: Array | None,
) -> ModalFit:
    """What the fit is worth: covariance, noise, misfit, and which modes the data hardly determine."""
    covariance, spread = covariance_of(problem, state)
    own = inside(state, problem.edges)
    model = np.zeros_like(part.H)
    model[:, problem.rows, problem.columns] = model[:, problem.columns, problem.rows] = receptances(problem, state).T
    # the weight of one measurement: that of the mean of two is larger
    one = np.zeros(part.H.shape)
    both = np.where(problem.rows == problem.columns, 1.0, problem.averaging)[:, None]
    one[:, problem.rows, problem.columns] = one[:, problem.columns, problem.rows] = (problem.weight / both).T
    # with the same error everywhere all weights are one number
    unit = 1.0 if relative or errors is not None else float(one[0, 0, 0])
    misfit = np.sqrt(np.mean(np.abs((part.H - model) * one) ** 2, axis=0)) / unit
    noise = noise_of(problem, state) / unit
    unsure = own & doubtful(problem, state, deviation_of(state, covariance), spread)
    order = np.argsort(state.omega, kind="stable")
    seats, m = state.Phi.shape
    places = [*(k * m + order for k in range(seats + 2))]
    coupling = None
    if state.V is not None:
        coupling = (state.U @ state.U.T)[order][:, order]
        pairs = np.zeros((m, m), dtype=int)
        pairs[np.tril_indices(m, -1)] = (seats + 2) * m + np.arange(m * (m - 1) // 2)
        places.append((pairs + pairs.T)[order][:, order][np.tril_indices(m, -1)])
    index = np.concatenate(places)
    return ModalFit(
        state.Phi[:, order],
        state.omega[order],
        state.zeta[order],
        own[order],
        unsure[order],
        covariance[index[:, None], index],
        noise,
        misfit,
        band,
        part.labels,
        relative,
        errors,
        coupling=coupling,
    )


def _notes(fit: ModalFit) -> tuple[str, ...]:
    """How well it did, in sentences."""
    stated = " times the errors " + ("that neighbouring lines tell" if fit.told else "given")
    unit = " of |H|" if fit.relative else " m/N" if fit.errors is None else stated

    def told(value: float) -> str:
        return f"{100 * value:.3g} %{unit}" if fit.relative else f"{value:.3g}{unit}"

    worst = np.unravel_index(fit.misfit.argmax(), fit.misfit.shape)
    frequency, damping = fit.deviation
    if fit.coupling is not None:
        frequency, damping = deviation_of_poles(fit.omega, fit.C, fit.covariance)
    modes = ", ".join(
        f"{fit.natural_frequency[k]:.4g} Hz {100 * fit.zeta[k]:.3g} %{' (unsure)' if fit.unsure[k] else ''}"
        for k in np.flatnonzero(fit.inside)
    )
    notes = [
        f"Identified from {fit.band[0]:g} to {fit.band[1]:g} Hz: {fit.inside.sum()} modes in the band, {modes}; "
        f"{(~fit.inside).sum()} pseudo-modes stand for what lies outside it and mean nothing one by one.",
        f"Misfit, root mean square over the lines: {told(float(np.sqrt(np.mean(fit.misfit**2))))} over all FRFs, at "
        f"the worst {told(float(fit.misfit.max()))} (response {fit.labels[worst[0]]}, force {fit.labels[worst[1]]}); "
        f"the noise is estimated to be {told(fit.noise)}.",
    ]
    if fit.coupling is not None:
        notes[1:1] = ["Damping couples the modes, as dashpots, isolators and soil do: C is full, mode shapes complex."]
    if fit.told:
        notes.append(
            f"The noise is not in proportion to |H|: neighbouring lines tell of {100 * fit.told[0]:.2g} to "
            f"{100 * fit.told[1]:.2g} % of it, a tenth left out at either end. Each line weighs by its own."
        )
    missed = float(np.sqrt(np.mean(fit.misfit**2)))
    if missed > (GROSS if fit.relative else np.inf if fit.errors is None else MANY):
        # before all else: nothing below it is a result
        notes.insert(
            0,
            f"Warning: this is no model of the data, which it misses by {told(missed)}. No passive, reciprocal "
            "foundation has such FRFs: look for a flipped channel, a phase of the other sign, a delay between force "
            "and response, or a wrong factor on some of them. rbfound.check looks for these.",
        )
    elif fit.misfit.max() > 1.5 * max(fit.noise, 1e-3 * fit.relative):
        notes.append(
            "Warning: the misfit is larger than the noise: damping or stiffness that depends on frequency, data that "
            "do not belong together, or missing modes. rbfound.identification.mount_measured puts the rotor on the "
            "FRFs themselves, without a model."
        )
    notes += [
        f"Warning: the mode at {fit.natural_frequency[k]:.4g} Hz is unsure: its frequency is known to "
        f"{100 * frequency[k]:.2g} %, its damping to {100 * damping[k]:.2g} % (standard deviations)."
        for k in np.flatnonzero(fit.unsure)
    ]
    return tuple(notes)
