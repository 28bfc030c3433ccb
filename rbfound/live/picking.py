"""What moving a peak changes: from peaks on FRFs to Phi, its matrices, and the rotor that stands on them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linear_sum_assignment

from rbfound.foundation import Foundation
from rbfound.identification import compliance, equivalent_matrices, pseudo_modes
from rbfound.live.bench import Bench
from rbfound.measurement import Peaks, mode_indicator, prominence
from rbfound.theory import local_maxima
from rbfound.units import from_hertz

Array = NDArray[np.float64]

# The ways from FRFs to a foundation, as a reader sees them named.
METHODS: Mapping[str, str] = {"pmsm": "PMSM", "distinct": "PMSM, distinct modes", "identify": "identify"}

# Of the indicator's peaks so many, or one more than seats, are candidates for distinct modes. A seat sees the same peak
# within this part.
CANDIDATES, ALIKE = 7, 0.01

# What decides between assignments of peaks to seats that are equally good, beside logarithms of responses.
TIE = 1e-9

# seat, frequency [Hz], and a damping ratio or None: to be read from the curve
Pick = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Picked:
    """A foundation and what it was picked from.

    Attributes
    ----------
    method : one of METHODS
    peaks : Peaks
    seats : the seat that each peak was read at, "" where all of them were used
    order : which of the given peaks each one is
    Phi : (seats, modes) [1/sqrt(kg)]
        Of the modes in the band.
    foundation : Foundation
    omega, zeta, shapes : (m,) [rad/s], (m,), (seats, m)
        Modes whose sum are the FRFs of the foundation, those that stand for what lies outside the band among them.
    alone, under : natural frequencies [Hz] of the foundation alone and under the rotor, as far as the FRFs reach
        Those of `identify` alone are the modes of the band, without the residual ones.
    """

    method: str
    peaks: Peaks
    seats: tuple[str, ...]
    order: tuple[int, ...]
    Phi: Array
    foundation: Foundation
    omega: Array
    zeta: Array
    shapes: Array
    alone: Array
    under: Array

    @property
    def condition(self) -> float:
        """Condition number of Phi."""
        return float(np.linalg.cond(self.Phi))

    def receptance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """FRFs of the foundation as the sum of its modes, (f, seats, seats) [m/N]: sooner had than by solving."""
        if self.method == "identify":
            # its damping may couple modes
            return self.foundation.frf(frequency).H
        terms = compliance(np.asarray(from_hertz(frequency), dtype=float), self.omega, self.zeta)
        products = self.shapes[:, None, :] * self.shapes[None, :, :]
        return np.asarray(np.moveaxis(products @ terms, -1, 0))


def picked(bench: Bench, peaks: Sequence[Any], method: str = "pmsm") -> Picked:
    """The foundation that some peaks give.

    Parameters
    ----------
    peaks : as in `picks_of`
        They stay where they are put, on a peak or not. Without a damping ratio, that of the nearest peak of the
        driving point is taken. `identify` needs none and takes none.
    method : "pmsm", "distinct" or "identify"
        The pseudo mode shape method with each peak at its own seat; the same with each peak at the seat that sees it
        best, every seat taken once; or all modes by a fit of all FRFs.

    Raises
    ------
    ValueError
        As `rbfound.identification.pseudo_mode_shapes.pseudo_modes` and `rbfound.equivalent_matrices` do, and when a
        seat has no peak, or two.
    """
    if method not in METHODS:
        raise ValueError(f"There is no method {method!r}: the methods are {', '.join(METHODS)}.")
    if method == "identify":
        return _identified(bench)
    picks = picks_of(bench, peaks)
    if method == "distinct":
        picks = _assigned(bench, picks)
    labels = bench.frf.labels
    _check_seats(picks, labels)
    order = sorted(range(len(picks)), key=lambda k: labels.index(picks[k]["seat"]))
    chosen = Peaks(
        np.array([picks[k]["frequency"] for k in order]),
        np.array([_damping(bench, j, picks[k]) for j, k in enumerate(order)]),
    )
    modes = pseudo_modes(bench.frf, chosen)
    Phi = np.real(modes.Phi)
    foundation = equivalent_matrices(Phi, modes.omega, modes.zeta, labels)
    found = modes.omega, modes.zeta, Phi, *bench.frequencies(foundation)
    return Picked(method, chosen, labels, tuple(order), Phi, foundation, *found)


def _check_seats(picks: Sequence[Pick], labels: Sequence[str]) -> None:
    for label in labels:
        own = [f"{pick['frequency']:.4g} Hz" for pick in picks if pick["seat"] == label]
        if len(own) != 1:
            said = f"{label} has {len(own)}, at {' and '.join(own)}" if own else f"{label} has none"
            raise ValueError(f"Every seat needs one peak, {len(labels)} in all: {said}.")


def picks_of(bench: Bench, peaks: Sequence[Any]) -> list[Pick]:
    """Peaks as a list of seat, frequency [Hz] and damping ratio.

    Parameters
    ----------
    peaks : frequencies [Hz] in the order of the seats, or mappings with "seat", "frequency" and, perhaps, "damping"
    """
    out: list[Pick] = []
    for k, peak in enumerate(peaks):
        if not isinstance(peak, Mapping):
            if len(peaks) != len(bench.frf.labels):
                raise ValueError(
                    f"{len(peaks)} frequencies are given: there must be one a seat, {', '.join(bench.frf.labels)}."
                )
            peak = {"seat": bench.frf.labels[k], "frequency": peak}
        bench.frf.seat(peak["seat"])
        damping = peak.get("damping")
        out.append(
            {
                "seat": str(peak["seat"]),
                "frequency": float(peak["frequency"]),
                "damping": None if damping is None else float(damping),
            }
        )
    return out


def first_picks(bench: Bench, method: str) -> list[Pick]:
    """Peaks to begin with.

    "pmsm": at each seat the most prominent peak of its direction, so that every direction has one mode; "distinct":
    those of the indicator's peaks whose shapes differ most, one a seat.
    """
    frf = bench.frf
    if method == "distinct":
        return _most_different(bench)
    picks = []
    for k, label in enumerate(frf.labels):
        alike = [j for j in range(len(frf.labels)) if frf.labels[j][:1] == label[:1]]
        strongest = max((reading for reading in bench.readings[alike[0]]), key=lambda p: p.height, default=None)
        if strongest is None:
            raise ValueError(f"The driving point {frf.labels[alike[0]]} has no peak with half-power points.")
        own = bench.nearest(k, strongest.frequency)
        picks.append({"seat": label, "frequency": own.frequency, "damping": None})
    return picks


def _identified(bench: Bench) -> Picked:
    fit = bench.fit
    own, foundation = fit.inside, fit.foundation()
    alone, under = bench.frequencies(foundation)
    return Picked(
        "identify",
        Peaks(fit.natural_frequency[own], fit.zeta[own]),
        ("",) * int(own.sum()),
        (),
        fit.Phi[:, own],
        foundation,
        fit.omega,
        fit.zeta,
        fit.Phi,
        _nearest(alone, fit.natural_frequency[own]),
        under,
    )


def _nearest(found: Array, wanted: Array) -> Array:
    """Those frequencies that belong to modes of the band, without residual modes, which stand for what lies outside."""
    rows, _ = linear_sum_assignment(np.abs(np.subtract.outer(found, wanted)))
    return found[rows]


def _damping(bench: Bench, seat: int, pick: Pick) -> float:
    given = pick["damping"]
    return bench.nearest(seat, pick["frequency"]).damping if given is None else float(given)


def _assigned(bench: Bench, picks: Sequence[Pick]) -> list[Pick]:
    """The same peaks, each at the seat that sees it best, every seat taken once: the largest product of responses.

    Of assignments that are equally good the one is taken that has lower peaks at earlier seats: a term far above
    rounding, and far below what a reading means, chooses it. Neither factor of it is a mirror of the other, as a cycle
    of seats and its inverse would else come out alike.
    """
    labels = bench.frf.labels
    if len(picks) != len(labels):
        raise ValueError(f"{len(picks)} peaks are given: there must be one a seat, {len(labels)} in all.")
    lines = [int(np.abs(bench.frf.frequency - pick["frequency"]).argmin()) for pick in picks]
    seen = -np.einsum("nii->ni", bench.frf.H[lines]).imag
    seen = np.log(np.maximum(seen, np.finfo(float).tiny))
    rank = np.argsort(np.argsort([pick["frequency"] for pick in picks], kind="stable"), kind="stable")
    seen += TIE * np.outer(rank, np.arange(len(labels)) ** 1.5)
    _, best = linear_sum_assignment(seen, maximize=True)
    return [{**pick, "seat": labels[seat]} for pick, seat in zip(picks, best, strict=True)]


def _most_different(bench: Bench) -> list[Pick]:
    frf, seats = bench.frf, len(bench.frf.labels)
    curve = np.log(np.maximum(mode_indicator(frf)[:, 0], np.finfo(float).tiny))
    lines = local_maxima(curve)
    lines = np.sort(lines[np.argsort(-prominence(curve, lines))[: max(CANDIDATES, seats + 1)]])
    best, least = [], np.inf
    for some in combinations(lines, seats):
        picks = [{"seat": "", "frequency": float(frf.frequency[k]), "damping": None} for k in some]
        picks = [{**p, "frequency": _own(bench, p)} for p in _assigned(bench, picks)]
        try:
            condition = picked(bench, picks, "distinct").condition
        except ValueError:
            continue
        if condition < least:
            best, least = picks, condition
    if not best:
        raise ValueError(f"The FRFs do not show {seats} peaks from which a foundation could be read.")
    return best


def _own(bench: Bench, pick: Pick) -> float:
    """Where a seat coordinate shows a peak of the indicator: half a line makes a difference."""
    near = bench.nearest(bench.frf.seat(pick["seat"]), pick["frequency"]).frequency
    return near if abs(near / pick["frequency"] - 1) < ALIKE else pick["frequency"]
