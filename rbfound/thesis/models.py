"""The thesis's twelve models by their letters: beams (a to f), and bodies of ours (g to l)."""

from functools import cache
from typing import Any

from rbfound.foundation import Foundation
from rbfound.thesis import beam_models

BEAMS, SOLIDS, ON_FOUNDATION = "abcdef", "ghijkl", "jkl"


def model(letter: str, foundation: Foundation | None = None, size: float = 0.01, modes: int = 12) -> Any:
    """One of the thesis's models: a Machine of beams for a to f, a FullMachine of solids for g to l.

    a: the rotor; b: with the point mass; c: b in its bearings on rigid ground; d: a beside the equivalent matrices;
    e: b beside them; f: b through its bearings on them. g to l are the same with a solid rotor and a solid foundation.

    Parameters
    ----------
    foundation : what j, k and l stand on
        Unless given, the solid foundation with its reduced coordinates: some seconds when it is first needed.
    size, modes : of the solid rotor, see `rbfound.thesis.full_models.reduced_rotor`

    Raises
    ------
    ValueError
        When there is no such letter, when a to i are given a foundation, or when scikit-fem is not there for g to l.
    """
    _check(letter)
    if letter in BEAMS:
        if foundation is not None:
            raise ValueError(f"Model {letter} takes no foundation: j, k and l do.")
        return beam_models.model(letter)
    return _full_models().model(letter, _ground(letter, foundation), size, modes)


def beside(letter: str, foundation: Foundation | None = None, limit: float = 1200.0) -> dict[str, list[Any]]:
    """A model's natural frequencies beside the printed ones, as columns for `rbfound.table`.

    Every mode from 1 Hz to `limit` is a row; see `rbfound.thesis.beam_models.compare`, and `model` for the rest.
    """
    _check(letter)
    if letter in BEAMS:
        return beam_models.beside(letter, limit)
    return _full_models().beside(letter, _ground(letter, foundation), limit)


def _check(letter: str) -> None:
    if letter not in tuple(BEAMS + SOLIDS):
        raise ValueError(f"The thesis has no model {letter!r}: the letters are a to l.")


def _full_models() -> Any:
    try:
        from rbfound.thesis import full_models
    except ImportError as error:
        raise ValueError(f"Models g to l are solids: pip install 'rbfound[solid]' ({error}).") from None
    return full_models


def _ground(letter: str, foundation: Foundation | None) -> Foundation | None:
    return _solid_foundation() if foundation is None and letter in ON_FOUNDATION else foundation


@cache
def _solid_foundation() -> Foundation:
    from rbfound.solid import foundation_solid, reduce

    return reduce(foundation_solid())
