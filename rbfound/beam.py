"""One Timoshenko beam element of a shaft: consistent mass with rotary inertia, stiffness, gyroscopic matrix."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Section:
    """A round cross-section and its material.

    Attributes
    ----------
    diameter, inner : outer and inner diameter [m]
    E : Young's modulus [Pa]
    rho : density [kg/m^3]
    nu : Poisson's ratio [-]
    """

    diameter: float
    inner: float = 0.0
    E: float = 2.1e11
    rho: float = 7850.0
    nu: float = 0.3

    def __post_init__(self) -> None:
        if not 0 <= self.inner < self.diameter < np.inf:
            raise ValueError(
                f"diameter {self.diameter:g} m with inner diameter {self.inner:g} m: need 0 <= inner < diameter."
            )
        for name in ("E", "rho"):
            if not 0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} = {getattr(self, name):g}: it must be positive and finite.")
        if not -1 < self.nu <= 0.5:
            raise ValueError(f"nu = {self.nu:g}: Poisson's ratio must lie between -1 and 0.5.")

    @property
    def area(self) -> float:
        """Area of the cross-section [m^2]."""
        return float(np.pi / 4 * (self.diameter**2 - self.inner**2))

    @property
    def inertia(self) -> float:
        """Second moment of area about a diameter [m^4]; the polar one is twice that."""
        return float(np.pi / 64 * (self.diameter**4 - self.inner**4))

    @property
    def shear_stiffness(self) -> float:
        """kappa G A [N], with the shear coefficient of Cowper 1966 (DOI 10.1115/1.3625046) for a round tube."""
        m2 = (self.inner / self.diameter) ** 2
        ring = (1 + m2) ** 2
        kappa = 6 * (1 + self.nu) * ring / ((7 + 6 * self.nu) * ring + (20 + 12 * self.nu) * m2)
        return kappa * self.E / (2 * (1 + self.nu)) * self.area


@dataclass(frozen=True, eq=False)
class BeamElement:
    """Matrices (4, 4) of one plane in the coordinates w1, s1, w2, s2: displacement and slope at both ends.

    G couples the planes: spinning at Omega, the moment on the x plane's slopes is Omega G times the y plane's slope
    rates, and minus that the other way round. See `rbfound.rotor` for the signs.
    """

    M: Array
    K: Array
    G: Array


def element(length: float, section: Section) -> BeamElement:
    """One element of a given length [m].

    Its shape functions solve the static Timoshenko beam exactly, so that stiffness and slope fit each other and
    nothing locks; the integrals are taken by four Gauss points, exact for their degree.
    (Nelson 1980, DOI 10.1115/1.3254824; Friswell, Penny, Garvey and Lees 2010, DOI 10.1017/CBO9780511780509.)
    """
    bending, shear = section.E * section.inertia, section.shear_stiffness
    points, weights = np.polynomial.legendre.leggauss(4)
    xi, weights = (points + 1) / 2, weights / 2 * length
    phi = 12 * bending / (shear * length**2)
    w, slope, curvature = _shape_functions(xi, length, phi)
    strain = _shear_strain(length, phi)

    def integral(a: Array, b: Array) -> Array:
        return np.asarray(np.einsum("g,gi,gj->ij", weights, a, b))

    return BeamElement(
        M=section.rho * (section.area * integral(w, w) + section.inertia * integral(slope, slope)),
        K=bending * integral(curvature, curvature) + shear * length * np.outer(strain, strain),
        G=2 * section.rho * section.inertia * integral(slope, slope),
    )


def _shape_functions(xi: Array, length: float, phi: float) -> tuple[Array, Array, Array]:
    """Displacement, bending slope and curvature of the four unit end displacements at xi = z / length: (points, 4)."""
    one = np.ones_like(xi)
    w = np.array(
        [
            1 - 3 * xi**2 + 2 * xi**3 + phi * (1 - xi),
            length * (xi - 2 * xi**2 + xi**3 + phi / 2 * (xi - xi**2)),
            3 * xi**2 - 2 * xi**3 + phi * xi,
            length * (-(xi**2) + xi**3 - phi / 2 * (xi - xi**2)),
        ]
    )
    slope = np.array(
        [
            6 * (xi**2 - xi) / length,
            1 - 4 * xi + 3 * xi**2 + phi * (1 - xi),
            6 * (xi - xi**2) / length,
            -2 * xi + 3 * xi**2 + phi * xi,
        ]
    )
    curvature = np.array(
        [
            (12 * xi - 6) / length**2,
            (6 * xi - 4 - phi * one) / length,
            (6 - 12 * xi) / length**2,
            (6 * xi - 2 + phi * one) / length,
        ]
    )
    return w.T / (1 + phi), slope.T / (1 + phi), curvature.T / (1 + phi)


def _shear_strain(length: float, phi: float) -> Array:
    """w' - slope of the four shape functions, constant over the element: (4,)."""
    return phi / (1 + phi) * np.array([-1 / length, -1 / 2, 1 / length, -1 / 2])
