"""What a column of numbers measures: its unit says whether it is a receptance, a mobility or an accelerance."""

import re

import numpy as np
from numpy.typing import NDArray

from rbfound.units import radians

Complex = NDArray[np.complex128]

# How often a quantity is differentiated in time.
QUANTITIES = {"receptance": 0, "mobility": 1, "accelerance": 2}

# Derivative and size in SI of a response's unit, and newtons of a force's. g is the standard acceleration of gravity.
RESPONSES = {
    "m": (0, 1.0),
    "cm": (0, 1e-2),
    "mm": (0, 1e-3),
    "um": (0, 1e-6),
    "in": (0, 0.0254),
    "m/s": (1, 1.0),
    "mm/s": (1, 1e-3),
    "in/s": (1, 0.0254),
    "m/s2": (2, 1.0),
    "mm/s2": (2, 1e-3),
    "in/s2": (2, 0.0254),
    "g": (2, 9.80665),
}
FORCES = {"N": 1.0, "kN": 1e3, "lbf": 4.4482216152605}

ASK = "Say it with unit=: 'm', 'mm', 'm/s', 'm/s2', 'mm/s2', 'g', ... (or 'mm/N': per unit of force)."


def parsed_unit(unit: str) -> tuple[int, float, bool]:
    """(times differentiated, size in SI, whether it is for a unit force) of a text such as "mm", "g/N" or "m/s²"."""
    text = unit.strip().strip("[]").replace(" ", "").replace("²", "2").replace("^", "").replace("**", "")
    text = (
        text.replace("µ", "u").replace("μ", "u").replace("s/s", "s2").replace("(m/s2)", "m/s2").replace("(m/s)", "m/s")
    )
    response, force = text, None
    match = re.fullmatch(r"(.+)/(N|kN|lbf)", text)
    if match:
        response, force = match[1], match[2]
    if response not in RESPONSES:
        raise ValueError(
            f"The unit {unit!r} is not known: responses are in {', '.join(RESPONSES)}, forces in {', '.join(FORCES)}."
        )
    derivative, size = RESPONSES[response]
    return derivative, size / (FORCES[force] if force else 1.0), force is not None


def said_unit(source: str, found: str | None, unit: str | None, quantity: str | None) -> str:
    """The unit that holds for a source: what it says itself, what the caller says, and a ValueError if they differ."""
    if quantity is not None and quantity not in QUANTITIES:
        raise ValueError(f"quantity is {quantity!r}: it must be {', '.join(QUANTITIES)}.")
    said = found if unit is None else unit
    if said is None:
        raise ValueError(f"{source} does not say in which unit its responses are. {ASK}")
    try:
        derivative, size, _ = parsed_unit(said)
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from None
    if found is not None and unit is not None and parsed_unit_or_none(found) not in (None, (derivative, size)):
        raise ValueError(f"{source} says that its unit is {found!r}, unit= says {unit!r}: only one can be right.")
    if quantity is not None and QUANTITIES[quantity] != derivative:
        (name,) = (name for name, order in QUANTITIES.items() if order == derivative)
        raise ValueError(f"{source}: the unit {said!r} is that of {name}, not of {quantity}.")
    return said


def parsed_unit_or_none(unit: str) -> tuple[int, float] | None:
    """Derivative and size of a unit, or None where it is not known."""
    try:
        return parsed_unit(unit)[:2]
    except ValueError:
        return None


def receptance(frequency: NDArray[np.float64], values: Complex, unit: str, force: float = 1.0) -> Complex:
    """Values (n, ...) in a unit, for a force [N], as receptances [m/N]; no line may then be at 0 Hz unless they are.

    A unit for a unit force ("m/N") and a force other than 1 N contradict each other.
    """
    derivative, size, whole = parsed_unit(unit)
    if not np.isfinite(force) or force == 0:
        raise ValueError(f"force is {force} N: it must be finite and not zero.")
    if whole and force != 1:
        raise ValueError(f"The unit {unit!r} is for a unit force already, and force= says {force:g} N: leave one out.")
    omega = np.asarray(radians(frequency)).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values * (size / force) / (1j * omega) ** derivative if derivative else values * (size / force))
