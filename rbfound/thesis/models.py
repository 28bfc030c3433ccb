"""The thesis's twelve models by their letters: beams (a to f), and bodies of ours (g to l)."""

from functools import cache
from typing import Any

from rbfound.foundation import Foundation
from rbfound.machine import mount
from rbfound.theory import mount_reduced
from rbfound.thesis import beam_models

LETTERS, BEAMS = "abcdefghijkl", "abcdef"
WITHOUT_MASS, IN_BEARINGS, ON_FOUNDATION = "adgj", "cfil", "defjkl"


def model(letter: str, foundation: Foundation | None = None, size: float = 0.01, modes: int = 12) -> Any:
    """One of the thesis's models: a Machine of beams for a to f, a ReducedMachine of solids for g to l.

    a: the rotor; b: with the point mass; c: b in its bearings on rigid ground; d: a beside the equivalent matrices;
    e: b beside them; f: b through its bearings on them. g to l are the same with a solid rotor and a solid foundation.

    Parameters
    ----------
    foundation : what j, k and l stand on
        Unless given, the solid foundation with its reduced coordinates: some seconds when it is first needed.
    size, modes : of the solid rotor, see `rbfound.thesis.full_models.reduced_solid`

    Raises
    ------
    ValueError
        When there is no such letter, when a to i are given a foundation, or when scikit-fem is not there for g to l.
    """
    if letter not in tuple(LETTERS):
        raise ValueError(f"The thesis has no model {letter!r}: the letters are a to l.")
    beams = letter in BEAMS
    if foundation is not None and (beams or letter not in ON_FOUNDATION):
        raise ValueError(f"Model {letter} takes no foundation: j, k and l do.")
    rotor = beam_models.rotor(0.0 if letter in WITHOUT_MASS else beam_models.POINT_MASS)
    bearings = beam_models.bearings()
    tied = bearings if letter in IN_BEARINGS else {}
    if beams:
        return mount(rotor, tied, on=beam_models.foundation() if letter in ON_FOUNDATION else None)
    try:
        from rbfound.thesis.full_models import reduced_solid
    except ImportError as error:
        raise ValueError(f"Models g to l are solids: pip install 'rbfound[solid]' ({error}).") from None
    if foundation is None and letter in ON_FOUNDATION:
        foundation = _solid_foundation()
    return mount_reduced(reduced_solid(rotor, list(bearings), size, modes), tied, foundation)


def beside(letter: str, foundation: Foundation | None = None, limit: float = 1200.0) -> dict[str, list[Any]]:
    """A model's natural frequencies beside the printed ones, as columns for `rbfound.table`.

    Every mode from 1 Hz to `limit` is a row; the two planes of a round rotor share one. What the thesis does not list
    has no printed frequency: nothing is left out. See `rbfound.thesis.beam_models.compare`, and `model` for the rest.
    """
    machine = model(letter, foundation)
    modes = machine.at(0.0).modes().above(1.0).below(limit)
    return beam_models.compare(beam_models.printed(letter), modes.frequency, machine.foundation_share(modes))


@cache
def _solid_foundation() -> Foundation:
    from rbfound.solid import foundation_solid, reduce

    return reduce(foundation_solid())
