"""How much unbalance a rotor may have: balance quality grades of ISO 21940-11.

A grade G is the product of the permissible eccentricity of the centre of mass and the speed of rotation, in mm/s: a
rotor of grade G2.5 may have its centre of mass travel round at 2.5 mm/s. Turbines and the rotors of small electric
machines are usually given G2.5, pumps and fans G6.3.
"""

import numpy as np


def permissible_unbalance(mass: float, speed: float, grade: float = 2.5) -> float:
    """Permissible residual unbalance of a rotor [kg m], mass times eccentricity, at its highest service speed.

    Parameters
    ----------
    mass : [kg]
    speed : highest service speed [rad/s]
    grade : e_per times speed [mm/s]: 2.5 for G2.5
    """
    _check("mass", mass, "kg")
    return mass * permissible_eccentricity(speed, grade)


def permissible_eccentricity(speed: float, grade: float = 2.5) -> float:
    """How far the centre of mass may lie beside the axis [m], e_per = grade / speed [mm/s, rad/s]."""
    _check("speed", speed, "rad/s")
    _check("grade", grade, "mm/s")
    return 1e-3 * grade / speed


def grade_of(unbalance: float, mass: float, speed: float) -> float:
    """The balance quality grade [mm/s] that a rotor with an unbalance [kg m] has at a speed [rad/s]."""
    _check("mass", mass, "kg")
    return 1e3 * unbalance / mass * speed


def in_two_planes(unbalance: float, centre: float, left: float, right: float) -> dict[float, float]:
    """Share an unbalance [kg m] of the centre of mass between two planes, as a weight would rest on them.

    Parameters
    ----------
    centre, left, right : positions [m]; the centre of mass must lie between the planes

    Returns
    -------
    mapping from the position of a plane to its share [kg m], as `rbfound.unbalance_response` takes it
    """
    if not left <= centre <= right or left == right:
        raise ValueError(f"The centre of mass at {centre:g} m does not lie between planes at {left:g} and {right:g} m.")
    share = (centre - left) / (right - left)
    return {left: (1 - share) * unbalance, right: share * unbalance}


def _check(name: str, value: float, unit: str) -> None:
    if not 0 < value < np.inf:
        raise ValueError(f"{name} = {value:g} {unit}: it must be positive and finite.")
