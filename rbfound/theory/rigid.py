"""The rigid rotor on two elastic supports: four coordinates, and what of it has a closed form (equations 19-24).

The centre of mass moves by x and y, the rotor tilts by theta about X and psi about Y; bearing 1 stands a distance `a`
to the left of the centre of mass, bearing 2 a distance `b` to its right. At the bearings the shaft moves by

    x1 = x - a psi,   y1 = y + a theta,   x2 = x + b psi,   y2 = y - b theta        (equation 21)

(Friswell, Penny, Garvey and Lees 2010, DOI 10.1017/CBO9780511780509.)
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.rotor import Bearing, Rotor, assemble
from rbfound.system import System

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RigidRotor:
    """A rigid rotor in two bearings on rigid ground (equations 19-24).

    Attributes
    ----------
    mass : [kg]
    Id, Ip : moments of inertia about a diameter through the centre of mass, and about the shaft [kg m^2]
    a, b : from the centre of mass to the left to bearing 1, to the right to bearing 2 [m]; negative: the other side
    bearings : the two of them, with damping and cross terms if they have any
    """

    mass: float
    Id: float
    Ip: float
    a: float
    b: float
    bearings: tuple[Bearing, Bearing]

    def __post_init__(self) -> None:
        for name in ("mass", "Id"):
            if not 0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} = {getattr(self, name):g}: it must be positive and finite.")
        if not 0 <= self.Ip <= 2 * self.Id * (1 + 1e-9):
            raise ValueError(
                f"Ip = {self.Ip:g} kg m²: it lies between 0 and that of a thin disk, 2 Id = {2 * self.Id:g}."
            )
        if not 0 < self.a + self.b < np.inf:
            raise ValueError(f"a + b = {self.a + self.b:g} m: bearing 2 must stand to the right of bearing 1.")
        if len(self.bearings) != 2:
            raise ValueError(f"{len(self.bearings)} bearings: this rotor has two.")

    @property
    def journals(self) -> Array:
        """Displacements x1, y1, x2, y2 of the shaft in its bearings from x, y, theta, psi, (4, 4) (equation 21)."""
        return np.array(
            [
                [1.0, 0.0, 0.0, -self.a],
                [0.0, 1.0, self.a, 0.0],
                [1.0, 0.0, 0.0, self.b],
                [0.0, 1.0, -self.b, 0.0],
            ]
        )

    def about_centre(self, speed: float) -> System:
        """The system in x, y, theta, psi at a speed [rad/s] (equations 20, 22, 24)."""
        T, M = self.journals, np.diag([self.mass, self.mass, self.Id, self.Id])
        C, K = (T.T @ linalg.block_diag(*(getattr(bearing, name) for bearing in self.bearings)) @ T for name in "CK")
        G = np.zeros((4, 4))
        G[2, 3], G[3, 2] = self.Ip * speed, -self.Ip * speed
        return System(M, C, K, G)

    def at(self, speed: float) -> System:
        """The same system in the displacements x1, y1, x2, y2 of its journals: these have orbits and a whirl."""
        centre, back = self.about_centre(speed), np.linalg.inv(self.journals)
        M, C, K, G = (back.T @ getattr(centre, name) @ back for name in "MCKG")
        return System((M + M.T) / 2, C, K, G, (np.array([0, 2]), np.array([1, 3])))


def rigid_rotor(rotor: Rotor, bearings: Mapping[float, Bearing]) -> RigidRotor:
    """A rotor of beam elements with all its bending left out.

    Mass, centre and moments of inertia are those of its matrices in rigid motion, disks included.

    Parameters
    ----------
    bearings : mapping from a position [m] to a Bearing, two of them
    """
    if len(bearings) != 2:
        raise ValueError(f"{len(bearings)} bearings: a rigid rotor stands in two.")
    mesh = assemble(rotor)
    moved, tilted = np.zeros((2, len(mesh.M)))
    moved[0::4] = 1.0
    tilted[0::4], tilted[3::4] = mesh.z, 1.0
    mass = float(moved @ mesh.M @ moved)
    centre = float(moved @ mesh.M @ tilted) / mass
    tilted -= centre * moved
    about_x = np.zeros(len(mesh.M))
    about_x[1::4], about_x[2::4] = -(mesh.z - centre), 1.0
    first, second = sorted(bearings)
    return RigidRotor(
        mass,
        Id=float(tilted @ mesh.M @ tilted),
        Ip=float(about_x @ mesh.G @ tilted),
        a=centre - first,
        b=second - centre,
        bearings=(bearings[first], bearings[second]),
    )


def support_stiffness(k1: float, k2: float, a: float, b: float) -> tuple[float, float, float]:
    """Stiffness against displacement kT [N/m], between the two kC [N], and against tilting kR [N m] (equation 23).

    They hold in the x plane, between x and psi. In the y plane kT and kR are the same, but theta turns y the other way:
    its coupling is -kC. Equation 23 prints kC there, and equation 24 then has it with both signs.
    """
    return k1 + k2, -a * k1 + b * k2, a**2 * k1 + b**2 * k2


def conical(Id: float, Ip: float, speed: float, kx: float, ky: float | None = None) -> tuple[float, float]:
    """Natural frequencies [rad/s] of a rotor that only tilts, the lower and the higher one (equations 19-24).

    Alike in both planes it whirls in circles: the roots of omega^2 Id -+ omega speed Ip - k = 0, the lower one
    backward, the higher one forward. Otherwise the two planes together give a quadratic in omega^2,
    (kx - omega^2 Id) (ky - omega^2 Id) = (omega speed Ip)^2.

    Parameters
    ----------
    kx, ky : stiffness against tilting in the x and the y plane [N m], kR of `support_stiffness`; ky as kx unless given
    """
    ky = kx if ky is None else ky
    if not (kx > 0 and ky > 0):
        raise ValueError(f"kx = {kx:g}, ky = {ky:g} N m: both must be positive, or nothing holds the rotor upright.")
    gyro = (Ip * speed) ** 2
    half = (Id * (kx + ky) + gyro) / 2
    # the discriminant without the difference of two large squares
    root = np.sqrt((Id * (kx - ky)) ** 2 + gyro * (2 * Id * (kx + ky) + gyro)) / 2
    higher = (half + root) / Id**2
    return float(np.sqrt(kx * ky / Id**2 / higher)), float(np.sqrt(higher))


def isotropic_whirl(rotor: RigidRotor, speed: float) -> Array:
    """The four natural frequencies [rad/s] with elastic coupling, supports alike in x and y: (4,) (equations 19-24).

    With r = x + iy and s = psi - i theta the four equations become two complex ones,

        m r'' + kT r + kC s = 0,    Id s'' - i speed Ip s' + kC r + kR s = 0,

    and e^(i omega t) makes of them a polynomial of fourth degree in omega. Positive roots are forward whirl, negative
    ones backward. Ascending by their size.
    """
    k1, k2 = (_isotropic_stiffness(bearing, number) for number, bearing in enumerate(rotor.bearings, start=1))
    kT, kC, kR = support_stiffness(k1, k2, rotor.a, rotor.b)
    gyro = rotor.Ip * speed
    # time in units of the translation, so that the coefficients have one size
    unit = np.sqrt(kT / rotor.mass)
    translation = np.array([-1.0, 0.0, 1.0])
    tilting = np.array([-rotor.Id, gyro / unit, kR / unit**2])
    polynomial = np.polymul(translation, tilting)
    polynomial[-1] -= kC**2 / (kT * unit**2)
    roots = np.real(np.roots(polynomial)) * unit
    return np.asarray(roots[np.argsort(np.abs(roots), kind="stable")])


def _isotropic_stiffness(bearing: Bearing, number: int) -> float:
    alike = np.allclose(bearing.K, bearing.kxx * np.eye(2), rtol=1e-12, atol=0) and not bearing.C.any()
    if not alike or bearing.kxx <= 0:
        raise ValueError(
            f"Bearing {number} has K = {bearing.K.tolist()} N/m, C = {bearing.C.tolist()} N s/m: the closed form needs "
            "one positive stiffness in all directions and no damping."
        )
    return bearing.kxx
