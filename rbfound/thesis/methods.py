"""Methods from the same FRFs to the machine, compared with the reference model: error and solution time."""

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
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]

# A natural frequency that is further away is another mode's.
REACH = 0.03


@dataclass(frozen=True, eq=False)
class MethodResult:
    """What one method leads to, from FRFs to a machine.

    Attributes
    ----------
    name : of the method
    frequency : (m,) [Hz]   natural frequencies of the machine at rest
    response : (s, n) complex [m]   of the shaft to an unbalance, at the speeds that were asked for
    seconds : CPU time from the FRFs to the foundation; 0 where there is none to be made
    """

    name: str
    frequency: Array
    response: NDArray[np.complex128]
    seconds: float


def usual_methods(
    twice: Sequence[float], distinct: Sequence[float], band: tuple[float, float], modes: int
) -> dict[str, Callable[[FRF], Foundation]]:
    """The methods to identify a foundation that the book compares, by name.

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


def compare_methods(
    methods: Mapping[str, Callable[[FRF], Foundation]],
    frf: FRF,
    rotor: Rotor,
    bearings: Mapping[float, Bearing],
    lines: ArrayLike,
    unbalance: Mapping[float, complex],
    band: tuple[float, float],
) -> list[MethodResult]:
    """The result of each method, and last without any foundation model: the FRFs themselves under the rotor.

    Parameters
    ----------
    lines : (s,) [Hz]
        Lines of the FRFs, taken as speeds of the unbalance response.
    band : (lowest, highest) [Hz]
        In which the natural frequencies of the machine are wanted.
    """
    out = []
    speeds = np.asarray(from_hertz(np.asarray(lines, dtype=float)))
    for name, method in methods.items():
        begun = time.process_time()
        foundation = method(frf)
        seconds = time.process_time() - begun
        out.append(method_result(name, rotor, bearings, foundation, speeds, unbalance, band, seconds))
    measured = mount_measured(rotor, bearings, on=frf)
    shaft = len(out[0].response[0]) if out else None
    response = unbalance_on_lines(measured, speeds, unbalance)[:, :shaft]
    found = np.asarray(hertz(coupled_poles(measured, band=band).imag))
    return [*out, MethodResult("FRFs line by line", found, response, 0.0)]


def method_result(
    name: str,
    rotor: Rotor,
    bearings: Mapping[float, Bearing],
    foundation: Foundation | None,
    speeds: ArrayLike,
    unbalance: Mapping[float, complex],
    band: tuple[float, float],
    seconds: float = 0.0,
) -> MethodResult:
    """What the machine on one foundation does; speeds in [rad/s], band in [Hz]."""
    machine = mount(rotor, bearings, on=foundation)
    response = unbalance_response(machine, speeds, unbalance)[:, : len(machine.mesh.M)]
    modes = machine.at(0.0).modes().above(band[0]).below(band[1])
    return MethodResult(name, modes.frequency, response, seconds)


def frequency_errors(reference: ArrayLike, found: ArrayLike, reach: float = REACH) -> Array:
    """Errors [%] of natural frequencies, (m,); nan where one of the reference model has no partner.

    Each found frequency belongs to one of the reference at most: pairs are made so that as few as possible are missing
    and the sum of the differences is least.

    Parameters
    ----------
    reference : (m,) [Hz]
    found : (k,) [Hz]
    reach : no pair is further apart than this part of the frequency
    """
    reference, found = np.atleast_1d(np.asarray(reference, dtype=float)), np.atleast_1d(np.asarray(found, dtype=float))
    errors = np.full(len(reference), np.nan)
    if not len(found):
        return errors
    apart = found[None, :] / reference[:, None] - 1
    rows, columns = linear_sum_assignment(np.minimum(np.abs(apart), 10 * reach))
    near = np.abs(apart[rows, columns]) <= reach
    errors[rows[near]] = 100 * apart[rows[near], columns[near]]
    return errors


def response_error(reference: MethodResult, result: MethodResult, coordinate: int) -> float:
    """Root mean square over the speeds of the error of one coordinate's response, relative to the reference [%]."""
    error = np.abs(result.response[:, coordinate] / reference.response[:, coordinate] - 1)
    return float(100 * np.sqrt(np.mean(error**2)))
