"""What the thesis prints: its matrices (equations 75, 77-79), its tables of frequencies, its rotor.

The rotor's geometry is not printed there. `rotor()` is an equivalent one: found from the frequencies of models a, b
and c, it gives those of model f too.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rbfound.foundation import Foundation
from rbfound.identification import equivalent_matrices
from rbfound.rotor import Bearing, Disk, Rotor, Shaft
from rbfound.units import from_hertz

# Equation 75: columns 1 and 3 are the X mode at 150 Hz, columns 2 and 4 the Y mode at 350 Hz.
PHI = np.array(
    [
        [4.5600, -0.0882, 4.7124, -0.0857],
        [-0.9800, -4.7400, -0.9104, -4.5096],
        [4.7300, -0.0978, 4.6453, -0.0905],
        [-0.9712, -5.0270, -0.9544, -5.0201],
    ]
)

# Equations 77, 78, 79 [N/m, N s/m, kg]
KE = 1e8 * np.array(
    [
        [0.4123, -0.4223, -0.4129, 0.3894],
        [-0.4223, 1.9089, 0.4414, -1.7584],
        [-0.4129, 0.4414, 0.4139, -0.4068],
        [0.3894, -1.7584, -0.4068, 1.6207],
    ]
)
CE = 1e3 * np.array(
    [
        [8.8273, -0.8217, -8.7281, 0.7673],
        [-0.8217, 4.4634, 0.8683, -4.1112],
        [-8.7281, 0.8683, 8.6362, -0.8097],
        [0.7673, -4.1112, -0.8097, 3.7891],
    ]
)
ME = np.array(
    [
        [37.5159, -8.1160, -37.1879, 7.5196],
        [-8.1160, 39.4533, 8.5174, -36.3415],
        [-37.1879, 8.5174, 36.8920, -7.8852],
        [7.5196, -36.3415, -7.8852, 33.4949],
    ]
)

# What may have stood before the matrices were rounded, though the thesis does not print it: with Phi of equation 75
# these give equations 77 and 78 in every printed digit.
OMEGA = np.asarray(from_hertz(np.array([149.99, 350.10, 150.19, 350.18])))
DIAGONAL_C = np.array([232.591, 113.092, 251.358, 113.066])  # 2 zeta omega [1/s]
ZETA = DIAGONAL_C / (2 * OMEGA)

_A, _B, _C = (601.0, 1171.0), (281.9, 760.8), (185.7, 225.6, 544.6, 981.9)
_D = (118.7, 148.8, 350.0, 601.7, 1171.0)
_E = (118.7, 148.8, 281.9, 350.0, 760.8)
_F = (128.5, 188.0, 213.2, 337.9, 561.3, 579.1, 760.1)
_G, _H, _I = (598.0, 1118.0), (271.0, 752.0), (179.0, 225.0, 541.0, 980.0)
_J = (160.0, 280.0, 344.0, 480.0, 598.0, 627.0, 701.0, 760.0, 763.0, 1058.0, 1118.0)
_K = (160.0, 271.0, 280.0, 344.0, 480.0, 627.0, 701.0, 752.0, 760.0, 763.0, 1058.0)
_L = (160.0, 182.0, 271.0, 344.0, 472.0, 538.0, 627.0, 701.0, 752.0, 760.0, 763.0, 1058.0)

# Printed natural frequencies at zero speed [Hz], table by table and model by model.
# Table 17 is headed d and j; what stands in it are models e and k.
TABLES: Mapping[int, Mapping[str, tuple[float, ...]]] = MappingProxyType(
    {
        3: {"a": _A, "b": _B},
        4: {"b": _B, "c": _C},
        5: {"a": _A, "d": _D},
        6: {"b": _B, "e": _E},
        7: {"c": _C, "f": _F},
        8: {"d": _D, "e": _E, "f": _F},
        9: {"g": _G, "h": _H},
        10: {"h": _H, "i": _I},
        11: {"g": _G, "j": _J},
        12: {"h": _H, "k": _K},
        13: {"i": _I, "l": _L},
        14: {"j": _J, "k": _K, "l": _L},
        15: {"a": _A, "b": _B, "c": _C, "g": _G, "h": _H, "i": _I},
        16: {"d": _D, "j": _J},
        17: {"e": _E, "k": _K},
        18: {"f": _F, "l": _L},
    }
)

# The nine frequencies of the foundation alone in the three-dimensional model [Hz] (tables 11-14).
FOUNDATION = (160.0, 280.0, 344.0, 480.0, 627.0, 701.0, 760.0, 763.0, 1058.0)

# Table 1: the point mass on the shaft's tip [kg], the radius of its unbalance [m].
POINT_MASS, UNBALANCE_RADIUS = 10.0, 0.05


def rotor(point_mass: float = POINT_MASS) -> Rotor:
    """An equivalent of the thesis's rotor: 60 x 90, 100 x 745, 60 x 15, 40 x 150 mm, a point mass [kg] on its tip.

    Fitted to the frequencies of models a, b, c and rounded; not the original geometry, which is not printed.
    """
    shaft = Shaft(length=[0.09, 0.745, 0.015, 0.15], diameter=[0.06, 0.1, 0.06, 0.04], E=2.0e11, rho=7800.0)
    return Rotor(shaft, disks={1.0: Disk(point_mass)} if point_mass else {})


def bearings() -> dict[float, Bearing]:
    """The two bearings of table 1, 1e8 N/m and 1e4 N s/m in both directions, where the equivalent rotor has them."""
    bearing = Bearing(kxx=1e8, kyy=1e8, cxx=1e4, cyy=1e4)
    return {0.045: bearing, 0.85: bearing}


def foundation() -> Foundation:
    """The printed matrices (equations 77-79), taken as they stand."""
    return Foundation(ME, CE, KE, np.eye(4), notes=("Equations 77-79 as printed.",))


def unrounded_foundation() -> Foundation:
    """Equation 75 with the diagonal k and c that must have stood behind equations 77 and 78."""
    return equivalent_matrices(PHI, OMEGA, ZETA)


def compare(
    told: Sequence[float], frequency: ArrayLike, share: ArrayLike, within: float = 0.02
) -> dict[str, list[Any]]:
    """Printed frequencies beside computed ones, ascending, as columns for `rbfound.table`.

    Parameters
    ----------
    told : printed frequencies [Hz]
    frequency, share : (m,) computed frequencies [Hz], ascending, and the foundation's part of the kinetic energy
    within : how far (as a part) a printed frequency may lie from the mode that it is put beside
        One that finds no mode has a row of its own; so has a mode that no printed frequency is near to.
    """
    frequency, share = np.asarray(frequency, dtype=float), np.asarray(share, dtype=float)
    first = np.flatnonzero(np.diff(frequency, prepend=0.0) > 1e-6 * frequency)
    twins = np.diff(first, append=len(frequency))
    rows: list[tuple[Any, ...]] = []
    left = list(told)

    def apart(value: float) -> float:
        return float(np.abs(frequency - value).min())

    for k, count in zip(first, twins, strict=True):
        f = float(frequency[k])
        near = min(left, key=lambda value: abs(value - f), default=None)
        # only if no other mode is nearer to it; the twin of a pair is as near
        if near is not None and (abs(f - near) > within * near or abs(f - near) > apart(near) + 1e-6 * f):
            near = None
        if near is not None:
            left.remove(near)
        error = None if near is None else f"{100 * (f / near - 1):+.2f}"
        rows.append((near, f, error, int(count), "foundation" if share[k] > 0.5 else "shaft"))
    rows += [(value, None, None, None, "") for value in left]
    rows.sort(key=lambda row: row[1] or row[0])
    names = ("printed [Hz]", "rbfound [Hz]", "error [%]", "modes", "moves most")
    return {name: list(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def printed(letter: str) -> tuple[float, ...]:
    """A model's printed frequencies [Hz], from the first table that shows them."""
    for columns in TABLES.values():
        if letter in columns:
            return columns[letter]
    raise ValueError(f"The thesis has no model {letter!r}: the letters are a to l.")
