"""How many modes a fit has: added where one is missing, taken away where noise would do as well."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.identification.added_modes import (
    SCARCE,
    SPARE,
    arranged,
    candidates,
    in_band,
    inside,
    missing_mode,
    prominence_of,
    weight_of,
    within,
    without_weakest,
)
from rbfound.identification.decimation import noise_of, scale_of_data
from rbfound.identification.least_squares import (
    CAREFUL,
    HEAVY,
    LIGHT,
    SURE,
    Array,
    Complex,
    Problem,
    State,
    cost,
    curvature,
    parameters,
    refine,
    scale_of,
)
from rbfound.identification.lsfd import first_modes
from rbfound.identification.plscf import groups_of
from rbfound.units import hertz


def covariance_of(problem: Problem, state: State) -> tuple[Array, float]:
    """Covariance of phi, log omega, log zeta and, of coupled damping, R_ab with a > b; the spread of a residual."""
    variance = _variance(problem, state)
    turn = _to_shapes(state)
    return turn @ _inverse(curvature(problem, state)) @ turn.T * variance, float(np.sqrt(2 * variance))


def _variance(problem: Problem, state: State) -> float:
    """Of the real part of a weighted residual; the imaginary part has the same."""
    return cost(problem, state) / max(2 * problem.H.size - parameters(state), 1)


def _inverse(N: Array) -> Array:
    scale = scale_of(N)
    return np.asarray(linalg.pinvh(N / scale[:, None] / scale, rtol=1e-13) / scale[:, None] / scale)


def _to_shapes(state: State) -> Array:
    """From shapes relative to their frequency, as the fit has them, to shapes; and from V to R = U U'."""
    seats, m = state.Phi.shape
    n = (seats + 2) * m
    rows, columns = np.tril_indices(m, -1) if state.V is not None else (np.zeros(0, dtype=int),) * 2
    turn = np.zeros((n + len(rows), parameters(state)))
    turn[:n, :n] = np.eye(n)
    for i, row in enumerate(state.Phi):
        turn[i * m : (i + 1) * m, seats * m : (seats + 1) * m] = np.diag(row)
    if state.V is not None:
        U = state.U
        for k, (a, b) in enumerate(zip(*np.nonzero(state.V), strict=True)):
            along = U @ (U[a, a] * (np.eye(m)[b] - U[a, b] * U[a]))
            turn[n:, n + k] = np.where(rows == a, along[columns], 0) + np.where(columns == a, along[rows], 0)
    return turn


# A new mode has seats + 2 parameters and about a hundred places to be tried at: by chance the cost falls, in units of
# the noise's variance, by 20 in less than one fit of a thousand. A pseudo-mode too many above the band does no harm,
# but what one too few leaves undone makes the others wrong by more than their error bars: 5 falls by chance in one fit
# of five. What was found as a whole lacks none. One too many below would be a slow critical speed that is not there.
WORTH, WORTH_ABOVE = 20.0, 5.0


# A pseudo-mode that does less, in units of the noise's variance, stands for nothing.
IDLE = 2.0


# A search that goes on ends at a step that lowers the cost by less than this part of it.
ROUGH = 0.0003


# A good fit ends at a step that lowers the cost by less than this part of the noise's variance.
ENOUGH = 0.1


# A damping matrix that was diagonal is coupled by this at first, and a search for a full one turns to the next mode at
# a step that lowers the cost by less than TURN of it.
BARELY, TURN = 1e-3, 1e-3


# Damping is coupled if that lowers the cost by so many times what Schwarz's criterion asks for; it is looked for where
# real modes at the poles leave more than FAR times what noise does.
SURELY, FAR = 5.0, 2.0


# A rough fit that leaves less than this many times what noise does lacks nothing that a good one would not show sooner.
GOOD = 1.1


# Data are taken for no better than this part of |H|: below it, the search for what is missing ends.
FINEST = 2e-4


# Modes at the poles leave more than this part of the data, and a single one more takes more than that part of the rest
# away, only where a pole is missing. If none is, the rest is the remainder's, and no mode of the band helps with it.
UNEXPLAINED, PLAIN = 0.25, 0.02


# Modes that are nearer to each other than this many times their damping -Re lambda may be one too many.
CROWDED = 1.0


# A fit with a mode less that is not within this many times WORTH after a few steps is given up.
FAR_OFF = 100.0


def variance_of(problem: Problem, state: State) -> float:
    """The noise's variance in the units of the cost, at least that of the finest data there are."""
    return max(noise_of(problem, state), FINEST * scale_of_data(problem)) ** 2


def started(problem: Problem, poles: Complex, zeta: float, most: int) -> State:
    """Modes at the poles, and at those that are plainly missing among them; one pseudo-mode a seat above the band.

    A mode that comes before the others are refined spares the way on which they do its work. `zeta` is the
    damping ratio that it starts with, and `most` so many of them are added.
    """
    thin = problem.thinned()
    tried = within(candidates(*problem.edges, zeta), problem.edges)
    data = float(np.sum(np.abs(thin.weight * thin.H) ** 2))
    state = first_modes(thin, poles)
    left = cost(thin, state)
    for _ in range(most):
        gain = missing_mode(thin, state, tried, zeta, PLAIN * left)[1] if left >= UNEXPLAINED * data else np.zeros(1)
        if gain.max() < PLAIN * left:
            break
        poles = np.append(poles, tried[gain.argmax()] * (-zeta + 1j * np.sqrt(1 - zeta**2)))
        more = first_modes(thin, poles)
        # a pole that is there already makes the problem singular
        if cost(thin, more) >= left:
            break
        state, left = more, cost(thin, more)
    return state


def freed(problem: Problem, state: State) -> State:
    """Modes of the band first, their damping coupled with one another's and with that of the pseudo-modes."""
    own = inside(state, problem.edges)
    state = state.only(np.argsort(~own, kind="stable"))
    V = state.V if state.V is not None else np.zeros((len(own),) * 2)
    V = np.tril(np.where(V == 0, BARELY, V), -1)
    V[:, own.sum() :] = 0
    return replace(state, V=V)


def coupled(problem: Problem, poles: Complex, zeta: float, most: int) -> tuple[State | None, bool]:
    """Modes with a full damping matrix, from the poles: refined and added by turns until noise could do as much.

    None where modal damping does as well; and whether no more than noise is left. `zeta` and `most` are those of
    `completed`.
    """
    thin = problem.thinned()
    if not len(poles):
        return None, False
    starts = [freed(problem, first_modes(thin, poles, below=below)) for below in (False, True)]
    variance = variance_of(problem, starts[0])
    tries = [refine(thin, start, small=variance, rough=TURN, iterations=25) for start in starts]
    state, left = min(tries, key=lambda end: end[1])
    ends = [(state, left)]
    tried = candidates(*problem.edges, zeta)
    for _ in range(most):
        variance = variance_of(problem, state)
        # every mode comes with its row of the damping matrix: noise does as much as half of its variance a parameter
        worth = np.where(tried > problem.edges[1], WORTH_ABOVE, WORTH) + inside(state, problem.edges).sum() / 2
        new, gain = missing_mode(thin, state, tried, zeta, variance * worth)
        best = int(np.where(gain > variance * worth, gain, 0.0).argmax())
        least = variance * worth[best]
        trial, then = state, left
        if gain[best] > least:
            trial = freed(problem, state.joined(new.only(np.array([best]))))
            trial, then = refine(thin, trial, small=variance, rough=TURN, iterations=60)
        if left - then < least:
            # at the end of their range pseudo-modes stand in the way of better ones
            keep = inside(state, problem.edges) | (state.zeta < 0.98 * HEAVY)
            if keep.all():
                break
            trial, then = refine(thin, freed(problem, state.only(keep)), small=variance, rough=TURN, iterations=60)
        state, left = trial, then
        ends.append((state, left))
    state, left = min(ends, key=lambda end: end[1])
    variance = variance_of(problem, state)
    modal, _ = refine(thin, replace(state, V=None), small=variance, iterations=30)
    if likelier(problem, modal, state):
        return None, False
    state, left = refine(thin, state, small=ENOUGH * variance, damping=SURE)
    return state, left < GOOD**2 * variance * thin.H.size


def likelier(problem: Problem, modal: State, state: State) -> bool:
    """Whether modal damping explains the data as well, by a margin (Schwarz 1978, DOI 10.1214/aos/1176344136)."""
    more = max(parameters(state) - parameters(modal), 0)
    worse = cost(problem.thinned(), modal) - cost(problem.thinned(), state)
    return bool(worse < SURELY * np.log(problem.H.size) / 2 * more * variance_of(problem, state))


def completed(problem: Problem, state: State, zeta: float, most: int, other: Callable[[], State | None]) -> State:
    """Refine and add what is missing, by turns, until noise could do as much.

    A mode of the band comes alone. What lies above it is found as a whole. Where noise would hide it, pseudo-modes are
    none too many; else there is first one a seat, in case that these are the very modes.

    Parameters
    ----------
    zeta : damping ratio that a new mode starts with
    most : modes to add
    other : what to take if real modes at the poles leave more than noise, and if it gives something
    """
    edges = problem.edges
    tried = candidates(*edges, zeta)
    own = in_band(tried, edges)
    thin, variance = problem.thinned(), variance_of(problem, state)
    added, whole, thorough, untried = 0, False, False, True
    # few lines neither tell noise from resonances nor determine modes to spare
    noisy = problem.nodes is not None and noise_of(problem, state) > FINEST * scale_of_data(problem)
    at_once = arranged(thin, state.only(inside(state, edges)), zeta, variance, SPARE if noisy else SCARCE)
    # to first order it is better; of nearly repeated modes a long step is not
    better = at_once is not None and cost(thin, at_once) < cost(thin, state)
    state, whole = (at_once if at_once is not None and better else state), noisy and better
    while True:
        # a rough fit tells where a mode of the band is missing; a good one, that none is, and whether those outside do
        small, rough, damping = (ENOUGH * variance, 0.0, SURE) if thorough else (variance, ROUGH, CAREFUL)
        state, left = refine(thin, state, small=small, rough=rough, damping=damping, iterations=80)
        variance = variance_of(problem, state)
        idle = ~inside(state, edges) & (weight_of(thin, state) < IDLE * variance)
        if idle.any():
            state = state.only(~idle)
            if idle.all():
                return state
            continue
        if not thorough and left < GOOD * variance * thin.H.size:
            thorough = True
            continue
        if added < most and left > FINEST**2 * problem.H.size:
            least = variance * np.where((tried > edges[1]) & (not whole), WORTH_ABOVE, WORTH)
            new, gain = missing_mode(thin, state, tried, zeta, least)
            best = int(np.where(gain > least, gain, 0.0).argmax())
            found, more = gain[best] > least[best] and (thorough or own[best]), None
            if untried and found and own[best] and left > FAR * variance * thin.H.size:
                untried, found_coupled = False, other()
                if found_coupled is not None:
                    return found_coupled
            if found and not own[best] and not whole:
                whole = True
                more = _with_other_remainder(thin, state, left, zeta, variance)
            if found and more is None:
                added += 1
                more = _added(thin, state, left, new.only(np.array([best])), float(least[best]))
                thorough = thorough and more is None
            if more is not None:
                state = more
                continue
        if thorough:
            found_coupled = other() if untried and left > FAR * variance * thin.H.size else None
            return found_coupled or state
        thorough = True


def _with_other_remainder(problem: Problem, state: State, left: float, zeta: float, variance: float) -> State | None:
    """The modes of the band and pseudo-modes that were found at once, if they lower the cost."""
    other = arranged(problem, state.only(inside(state, problem.edges)), zeta, variance)
    if other is None:
        return None
    more, then = refine(problem, other, small=ENOUGH * variance, iterations=80)
    return more if then < left else None


def _added(problem: Problem, state: State, left: float, new: State, least: float) -> State | None:
    """The modes and one other, if it lowers the cost by as much as it has to."""
    more = state.joined(new)
    # a rough fit is gone on with if it does not
    for rough in (ROUGH, 0.0):
        more, then = refine(problem, more, small=0.05 * least, rough=rough, iterations=80)
        if left - then > least:
            return more
    return None


def doubtful(problem: Problem, state: State, deviation: tuple[Array, Array], noise: float) -> NDArray[np.bool_]:
    """Modes that the data hardly determine, (m,).

    Of which the frequency is known to no better than 0.3 % or the damping to no better than 15 %; that stand nowhere
    above five times the noise; or whose damping has gone to the end of its range.
    """
    known = (deviation[0] < 0.003) & (deviation[1] < 0.15)
    free = (state.zeta > 1.01 * LIGHT) & (state.zeta < 0.99 * HEAVY)
    return np.asarray(~known | ~free | (prominence_of(problem, state) < 5 * noise))


def pruned(problem: Problem, state: State, suspects: NDArray[np.intp]) -> State:
    """Without those of the suspects that noise would do as well as."""
    variance = variance_of(problem, state)
    left = refine(problem, state, small=variance, iterations=0)[1]
    gone: list[int] = []
    for k in suspects:
        rest = np.setdiff1d(np.arange(len(state.omega)), [*gone, int(k)])
        # the modes of `state` keep their numbers: what was refined meanwhile is refined again in the end
        _, then = refine(problem, state.only(rest), small=variance, iterations=12)
        if then - left < WORTH * variance:
            gone.append(int(k))
            left = then
    if not gone:
        return state
    rest = np.setdiff1d(np.arange(len(state.omega)), gone)
    return refine(problem, state.only(rest), small=0.3 * variance, iterations=20)[0]


def uncrowded(problem: Problem, state: State) -> State:
    """Without what closely spaced modes of the band have too many: of k modes, one combination that noise would do.

    Modes that are nearer than CROWDED share what they do: each may be needed although k - 1 others would do as well.
    """
    thin, variance = problem.thinned(), variance_of(problem, state)
    left, done = cost(thin, state), False
    while not done:
        own = np.flatnonzero(inside(state, problem.edges))
        poles = state.omega[own] * (-state.zeta[own] + 1j * np.sqrt(1 - state.zeta[own] ** 2))
        done = True
        for group in (own[group] for group in groups_of(poles, CROWDED) if len(group) > 1):
            fewer = without_weakest(problem, state, group)
            # a few steps, and many only where these lead somewhere
            for iterations in (3, 60):
                fewer, then = refine(thin, fewer, small=ENOUGH * variance, iterations=iterations)
                if then - left > FAR_OFF * WORTH * variance:
                    break
            if then - left < WORTH * variance:
                state, left, done = fewer, then, False
                break
    return state


def counted(problem: Problem, state: State, zeta: float, modes: int) -> State:
    """With a given number of modes inside the band, when the data show fewer: the best candidates come.

    Raises
    ------
    ValueError
        When the data show more, or no candidate is left.
    """
    edges = problem.edges
    tried = within(candidates(*edges, zeta), edges)
    for _ in range(modes):
        own = np.flatnonzero(inside(state, edges))
        if len(own) >= modes:
            break
        new, gain = missing_mode(problem, state, tried, zeta)
        if gain.max() <= 0:
            break
        state = state.joined(new.only(np.array([int(gain.argmax())])))
        state, _ = refine(problem, state, small=variance_of(problem, state), iterations=20)
    own = np.flatnonzero(inside(state, edges))
    if len(own) != modes:
        found = ", ".join(f"{f:.4g}" for f in np.sort(hertz(state.omega[own])))
        raise ValueError(
            f"modes is {modes}, but the data show {len(own)} in the band, at {found} Hz: give that number, or another "
            "band."
        )
    return state
