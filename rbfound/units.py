"""Hertz, revolutions per minute and radians per second: the only place with a 2 pi or a 60; and units of FRFs.

Inside rbfound every circular frequency and every spin speed is in rad/s, every receptance in m/N.
These functions stand at the two ends of a computation.
"""

import re
from math import isclose
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike


def hertz(omega: ArrayLike) -> Any:
    """Frequency [Hz] of a circular frequency [rad/s]."""
    return np.asarray(omega)[()] / (2 * np.pi)


def from_hertz(frequency: ArrayLike) -> Any:
    """Circular frequency [rad/s] of a frequency [Hz]."""
    return np.asarray(frequency)[()] * (2 * np.pi)


def rpm(speed: ArrayLike) -> Any:
    """Revolutions per minute of a spin speed [rad/s]."""
    return hertz(speed) * 60


def from_rpm(revolutions: ArrayLike) -> Any:
    """Spin speed [rad/s] of revolutions per minute."""
    return from_hertz(np.asarray(revolutions)[()] / 60)


# Size in SI, and powers of length, time and force. g is the standard acceleration of gravity; lb is a force here.
SIZES: dict[str, tuple[float, tuple[int, int, int]]] = {
    **{name: (size, (1, 0, 0)) for name, size in {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}.items()},
    **{name: (size, (1, 0, 0)) for name, size in {"in": 0.0254, "mil": 2.54e-5, "ft": 0.3048}.items()},
    **{name: (size, (0, 0, 1)) for name, size in {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605}.items()},
    "s": (1.0, (0, 1, 0)),
    "kg": (1.0, (-1, 2, 1)),
    "g": (9.80665, (1, -2, 0)),
}
ALIASES = {"lb": "lbf", "sec": "s", "inch": "in", "G": "g"}
# 1 Hz of each unit of an abscissa.
FREQUENCIES = {"": 1.0, "hz": 1.0, "1/s": 1.0, "khz": 1e3, "rad/s": 0.5 / np.pi, "rad/sec": 0.5 / np.pi, "rev/s": 1.0}
FREQUENCIES |= dict.fromkeys(("rpm", "cpm", "rev/min", "1/min"), 1 / 60)
# How often a quantity is differentiated in time, and whether it is a force over a motion.
QUANTITIES = {
    "receptance": (0, False), "mobility": (1, False), "accelerance": (2, False),
    "stiffness": (0, True), "impedance": (1, True), "apparent mass": (2, True),
}  # fmt: skip
FACTOR = re.compile(r"(1(?!\d)|[A-Za-z]+)(?:\^?(-?\d))?|([*/()])")
DECIBELS = re.compile(r"dB\b\s*(?:re\b|ref\b|rel\b)?[.:]?\s*(.*)", re.IGNORECASE)


class Unit(NamedTuple):
    """What a unit says: 20 log10 or not, size in SI, the quantity, and whether it is for a unit force (or motion)."""

    decibels: bool
    size: float
    quantity: str
    whole: bool


def parsed_unit(text: str) -> Unit:
    """The meaning of a unit of FRFs such as "mm", "g/N", "m/(N s²)", "N/m" or "dB re 1 m/N".

    Raises
    ------
    ValueError
        When it is neither a motion, nor a motion over a force, nor a force over a motion.
    """
    decibels = DECIBELS.fullmatch(text.strip().strip("[]"))
    plain = (decibels[1] if decibels else text).strip().strip("[]").replace("**", "^")
    for mark, meant in {"²": "2", "³": "3", "⁻": "-", "¹": "1", "µ": "u", "μ": "u", "·": "*", "⋅": "*"}.items():
        plain = plain.replace(mark, meant)
    plain = re.sub(r"\s*([*/()^])\s*", r"\1", plain.strip())
    plain = re.sub(r"\s+|(?<=[\w)])(?=\()", "*", plain)
    size, powers = _product(plain) if len(plain) < 60 else (0.0, ())
    for quantity, (order, over) in QUANTITIES.items():
        for force in (-1, 0):
            kind = (-1, order, 1) if over else (1, -order, force)
            if powers == kind:
                return Unit(decibels is not None, size, quantity, force == -1)
    reference = " The reference is missing: 'dB re 1 m/N'." if decibels and not plain else ""
    raise ValueError(
        f"The unit {text!r} is not known: it must be a motion (m, cm, mm, um, in, g, m/s, mm/s2, ...), alone or over a "
        f"force (N, kN, lbf), or a force over a motion.{reference}"
    )


def _product(text: str) -> tuple[float, tuple[int, ...]]:
    """Size and powers of a product of units; no powers where it is none."""
    if not re.fullmatch(rf"(?:{FACTOR.pattern})*", text):
        return 0.0, ()
    size, powers = 1.0, [0, 0, 0]
    sign, outer = 1, [1]
    for word, exponent, mark in FACTOR.findall(text):
        if mark == "(":
            outer.append(outer[-1] * sign)
        elif mark == ")" and len(outer) > 1:
            outer.pop()
        elif mark == ")" or (word != "1" and word and ALIASES.get(word, word) not in SIZES):
            return 0.0, ()
        elif word not in ("", "1"):
            scale, dimension = SIZES[ALIASES.get(word, word)]
            power = sign * outer[-1] * int(exponent or 1)
            size *= scale**power
            powers = [p + power * d for p, d in zip(powers, dimension, strict=True)]
        sign = -1 if mark == "/" else 1
    return (size, tuple(powers)) if len(outer) == 1 else (0.0, ())


def agreed_unit(
    source: str, found: str | None, unit: str | None, quantity: str | None, measured: str | None = None
) -> Unit:
    """The unit that holds for a source: what it says itself (`found`) and what the caller says must agree.

    `measured` is the quantity where the source says that apart from its unit. A force over a motion becomes a
    receptance only where the caller names the quantity.
    """
    if quantity not in (None, *QUANTITIES):
        raise ValueError(f"quantity is {quantity!r}: it must be {', '.join(QUANTITIES)}.")
    told = found if unit is None else unit
    if told is None:
        raise ValueError(
            f"{source} does not say in which unit its responses are. Say it with unit=: 'm', 'mm', 'm/s', 'm/s2', "
            "'mm/s2', 'g', ... (or 'mm/N': per unit of force)."
        )
    try:
        said = parsed_unit(told)
        bare = (found or "").strip("[] ").lower() == "db"  # decibels of something
        read = None if bare else said if found is None else parsed_unit(found)
    except ValueError as error:
        more = f" unit= says {unit!r}: where the heading is wrong, mend it." if unit is not None and found else ""
        raise ValueError(f"{source}: {error}{more}") from None
    alike = read is None or (read.quantity == said.quantity and isclose(read.size, said.size))
    if not alike or said.decibels != (read is None or read.decibels):
        raise ValueError(f"{source} says that its unit is {found!r}, unit= says {unit!r}: only one can be right.")
    for named in (quantity, measured):
        if named not in (None, said.quantity):
            raise ValueError(f"{source}: the unit {told!r} is that of {said.quantity}, not of {named}.")
    if QUANTITIES[said.quantity][1] and quantity is None:
        raise ValueError(
            f"{source}: the unit {told!r} is that of {said.quantity}. Say quantity={said.quantity!r} where "
            "the matrix of all seats, each driven with the others held, is to be inverted."
        )
    return said
