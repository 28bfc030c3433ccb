"""Every road from the same FRFs to the machine, beside the truth: what each costs and how far off it ends."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linear_sum_assignment

from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.identification import (
    coupled_poles,
    identify,
    lscf,
    mount_measured,
    pmsm,
    rational_fraction,
    unbalance_on_lines,
)
from rbfound.machine import mount
from rbfound.rotor import Bearing, Rotor
from rbfound.unbalance import unbalance_response
from rbfound.units import hertz, radians

Array = NDArray[np.float64]

# A natural frequency that is further away is another mode's.
REACH = 0.03


@dataclass(frozen=True, eq=False)
class Road:
    """One road from FRFs to a machine.

    Attributes
    ----------
    name : what the road is called
    frequency : (m,) [Hz]   natural frequencies of the machine at rest
    response : (s, n) complex [m]   of the shaft to an unbalance, at the speeds that were asked for
    seconds : CPU time from the FRFs to the foundation; 0 where there is none to be made
    """

    name: str
    frequency: Array
    response: NDArray[np.complex128]
    seconds: float


def usual_roads(
    twice: Sequence[float], distinct: Sequence[float], band: tuple[float, float], modes: int
) -> dict[str, Callable[[FRF], Foundation]]:
    """The ways to a foundation that the book compares, by name.

    Parameters
    ----------
    twice, distinct : peaks for `pmsm` [Hz], one a seat
        The thesis's two peaks, each read at two seats, and four different ones.
    band : (lowest, highest) [Hz]
    modes : for `rational_fraction`
    """
    return {
        "PMSM, thesis": partial(pmsm, peaks=twice),
        "PMSM, distinct": partial(pmsm, peaks=distinct),
        "RFP": partial(rational_fraction, modes=modes, band=band),
        "LSCF": partial(lscf, band=band),
        "identify": partial(identify, band=band),
    }


def travelled(
    roads: Mapping[str, Callable[[FRF], Foundation]],
    frf: FRF,
    rotor: Rotor,
    bearings: Mapping[float, Bearing],
    lines: ArrayLike,
    unbalance: Mapping[float, complex],
    band: tuple[float, float],
) -> list[Road]:
    """Each road to its end, and last the one without any foundation model: the FRFs themselves under the rotor.

    Parameters
    ----------
    lines : (s,) [Hz]
        Lines of the FRFs, taken as speeds of the unbalance response.
    band : (lowest, highest) [Hz]
        In which the natural frequencies of the machine are wanted.
    """
    out = []
    speeds = np.asarray(radians(np.asarray(lines, dtype=float)))
    for name, road in roads.items():
        begun = time.process_time()
        foundation = road(frf)
        seconds = time.process_time() - begun
        out.append(ended(name, rotor, bearings, foundation, speeds, unbalance, band, seconds))
    measured = mount_measured(rotor, bearings, on=frf)
    shaft = len(out[0].response[0]) if out else None
    response = unbalance_on_lines(measured, unbalance, speeds)[:, :shaft]
    found = np.asarray(hertz(coupled_poles(measured, band=band).imag))
    return [*out, Road("FRFs line by line", found, response, 0.0)]


def ended(
    name: str,
    rotor: Rotor,
    bearings: Mapping[float, Bearing],
    foundation: Foundation | None,
    speeds: ArrayLike,
    unbalance: Mapping[float, complex],
    band: tuple[float, float],
    seconds: float = 0.0,
) -> Road:
    """What the machine on one foundation does; speeds in [rad/s], band in [Hz]."""
    machine = mount(rotor, bearings, on=foundation)
    response = unbalance_response(machine, speeds, unbalance)[:, : len(machine.mesh.M)]
    modes = machine.at(0.0).modes().above(band[0]).below(band[1])
    return Road(name, modes.frequency, response, seconds)


def frequency_errors(truth: ArrayLike, found: ArrayLike, reach: float = REACH) -> Array:
    """Errors [%] of natural frequencies, (m,); nan where a true one has no partner.

    Each found frequency belongs to one true one at most: pairs are made so that as few as possible are missing and the
    sum of the differences is least.

    Parameters
    ----------
    truth : (m,) [Hz]
    found : (k,) [Hz]
    reach : no pair is further apart than this part of the frequency
    """
    truth, found = np.atleast_1d(np.asarray(truth, dtype=float)), np.atleast_1d(np.asarray(found, dtype=float))
    errors = np.full(len(truth), np.nan)
    if not len(found):
        return errors
    apart = found[None, :] / truth[:, None] - 1
    rows, columns = linear_sum_assignment(np.minimum(np.abs(apart), 10 * reach))
    near = np.abs(apart[rows, columns]) <= reach
    errors[rows[near]] = 100 * apart[rows[near], columns[near]]
    return errors


def response_error(truth: Road, road: Road, coordinate: int) -> float:
    """Root mean square over the speeds of the error of one coordinate's response, relative to the true one [%]."""
    error = np.abs(road.response[:, coordinate] / truth.response[:, coordinate] - 1)
    return float(100 * np.sqrt(np.mean(error**2)))
