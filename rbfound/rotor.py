"""The rotor: a shaft in steps, of Timoshenko elements, with disks, and the bearings that it may run in."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rbfound.beam import Section, element
from rbfound.system import System

Array = NDArray[np.float64]

# Coordinates of one element's two nodes that belong to the x plane (w = x, slope = psi) and to the y plane
# (w = y, slope = -theta), with the signs that turn slopes into rotations.
X_PLANE, Y_PLANE = np.array([0, 3, 4, 7]), np.array([1, 2, 5, 6])


Y_SIGN = np.array([1.0, -1.0, 1.0, -1.0])


# Its matrices are full: 2000 elements have three of half a gigabyte.
MOST_ELEMENTS = 2000


@dataclass(frozen=True)
class Shaft:
    """A stepped shaft, segment by segment from the left end at z = 0.

    Attributes
    ----------
    length : lengths of the segments [m]
    diameter : their outer diameters [m]
    inner : their inner diameters [m], one for all or one each
    E, rho, nu : Young's modulus [Pa], density [kg/m^3], Poisson's ratio [-] of all segments; steel unless given
    stiff : outer diameters that carry bending and shear [m]; those of the segments unless given
        Beside a step the outer fibres of the thicker side carry nothing: see `rbfound.rotor`.
    """

    length: Sequence[float]
    diameter: Sequence[float]
    inner: float | Sequence[float] = 0.0
    E: float = 2.1e11
    rho: float = 7850.0
    nu: float = 0.3
    stiff: Sequence[float] | None = None

    def __post_init__(self) -> None:
        if len(self.length) == 0 or len(self.length) != len(self.diameter):
            raise ValueError(
                f"{len(self.length)} lengths and {len(self.diameter)} diameters: give one of each for every segment."
            )
        for number, length in enumerate(self.length, start=1):
            if not 0 < length < np.inf:
                raise ValueError(f"Segment {number} is {length:g} m long: lengths must be positive and finite.")
        if np.size(self.inner) not in (1, len(self.length)):
            raise ValueError(
                f"{np.size(self.inner)} inner diameters and {len(self.length)} lengths: give one for all or one each."
            )
        if self.stiff is not None and len(self.stiff) != len(self.length):
            raise ValueError(f"{len(self.stiff)} stiff diameters and {len(self.length)} lengths: give one each.")
        for name in ("E", "rho", "nu"):
            if np.ndim(getattr(self, name)):
                raise ValueError(f"{name} is {getattr(self, name)!r:.60}: it must be one number for all segments.")
        self.sections()
        self.stiff_sections()

    @property
    def ends(self) -> Array:
        """Positions where segments begin and end [m], (segments + 1,)."""
        return np.concatenate([[0.0], np.cumsum(self.length)])

    def sections(self) -> list[Section]:
        """The cross-section of each segment."""
        return self._sections(self.diameter)

    def stiff_sections(self) -> list[Section]:
        """What bends of each segment's cross-section."""
        return self._sections(self.diameter if self.stiff is None else self.stiff)

    def _sections(self, outer: Sequence[float]) -> list[Section]:
        inner = np.broadcast_to(self.inner, len(self.length))
        return [Section(float(d), float(i), self.E, self.rho, self.nu) for d, i in zip(outer, inner, strict=True)]


@dataclass(frozen=True)
class Disk:
    """A rigid disk: mass [kg], diametral and polar moment of inertia [kg m^2]; without these a point mass.

    The polar moment is at most twice the diametral one: that of a thin disk.
    """

    mass: float
    Id: float = 0.0
    Ip: float = 0.0

    def __post_init__(self) -> None:
        for name in ("mass", "Id", "Ip"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} = {getattr(self, name):g}: it must be finite and not negative.")
        # printed moments of a thin disk are rounded
        if self.Ip > 2.02 * self.Id:
            raise ValueError(
                f"Ip = {self.Ip:g} kg m^2 is more than twice Id = {self.Id:g} kg m^2, which no body has: a thin disk "
                "has Ip = 2 Id, a thick one less."
            )


@dataclass(frozen=True)
class Bearing:
    """Linear stiffness [N/m] and damping [N s/m] between the shaft and its seat, in the directions x and y.

    What is left out of kyy and cyy is kxx and cxx: alike in both directions. For a bearing that holds in x only, write
    kyy=0.
    """

    kxx: float = 0.0
    kyy: float = None  # type: ignore[assignment]  # a number once it is made
    kxy: float = 0.0
    kyx: float = 0.0
    cxx: float = 0.0
    cyy: float = None  # type: ignore[assignment]
    cxy: float = 0.0
    cyx: float = 0.0

    def __post_init__(self) -> None:
        for along, across in (("kxx", "kyy"), ("cxx", "cyy")):
            if getattr(self, across) is None:
                object.__setattr__(self, across, getattr(self, along))
        for name, value in vars(self).items():
            if callable(value) or np.ndim(value):
                raise ValueError(
                    f"{name} is {value!r:.60}: it must be one number. For coefficients that depend on speed, give "
                    "campbell and unbalance_response an object whose .at(speed) mounts the bearings of that speed."
                )
            if not np.isfinite(value):
                raise ValueError(f"{name} = {value}: it must be finite.")

    @property
    def K(self) -> Array:
        """Stiffness (2, 2) [N/m]."""
        return np.array([[self.kxx, self.kxy], [self.kyx, self.kyy]])

    @property
    def C(self) -> Array:
        """Damping (2, 2) [N s/m]."""
        return np.array([[self.cxx, self.cxy], [self.cyx, self.cyy]])


@dataclass(frozen=True)
class Rotor:
    """A shaft with disks at positions [m], free in space until it is mounted.

    Attributes
    ----------
    shaft : Shaft
    disks : mapping from a position [m] to a Disk
    element : longest element [m]; nodes are put at segment ends, disks and bearings in any case
    """

    shaft: Shaft
    disks: Mapping[float, Disk] = field(default_factory=dict)
    element: float = 0.05

    def __post_init__(self) -> None:
        if not 0 < self.element < np.inf:
            raise ValueError(f"element = {self.element:g} m: the longest element must have a positive, finite length.")
        count = sum(self.shaft.length) / self.element
        if count > MOST_ELEMENTS:
            raise ValueError(
                f"element = {self.element:g} m: the shaft of {sum(self.shaft.length):g} m would have {count:.2g} "
                f"elements, more than {MOST_ELEMENTS}."
            )
        for z in self.disks:
            self.check_position(z, "disk")

    @property
    def mass(self) -> float:
        """Mass of the shaft and its disks [kg]."""
        shaft = sum(s.rho * s.area * length for s, length in zip(self.shaft.sections(), self.shaft.length, strict=True))
        return float(shaft + sum(disk.mass for disk in self.disks.values()))

    def at(self, speed: float) -> System:
        """The free rotor, spinning at a speed [rad/s]."""
        mesh = assemble(self)
        zero = np.zeros_like(mesh.M)
        return System(mesh.M, zero, mesh.K, speed * mesh.G, mesh.planes)

    def check_position(self, z: float, what: str) -> None:
        """Raise a ValueError unless the position [m] lies on the shaft."""
        end = float(self.shaft.ends[-1])
        if not -1e-9 * end <= z <= end * (1 + 1e-9):
            raise ValueError(f"A {what} stands at {z:g} m: the shaft reaches from 0 to {end:g} m.")


@dataclass(frozen=True, eq=False)
class Mesh:
    """An assembled rotor: node positions z (nodes,) and M, K, G (4 nodes, 4 nodes), G for a spin of 1 rad/s."""

    z: Array
    M: Array
    K: Array
    G: Array

    @property
    def planes(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Indices of the x and of the y displacements, node by node."""
        nodes = 4 * np.arange(len(self.z))
        return nodes, nodes + 1

    def node(self, z: float) -> int:
        """Index of the node at a position [m]."""
        k = int(np.abs(self.z - z).argmin())
        if abs(self.z[k] - z) > 1e-6 * self.z[-1]:
            raise ValueError(
                f"No node stands at {z:g} m; the nearest one is at {self.z[k]:g} m. "
                "Nodes stand at segment ends, disks and bearings."
            )
        return k


def assemble(rotor: Rotor, positions: Iterable[float] = ()) -> Mesh:
    """Matrices of the free rotor, with nodes at the given positions [m] too."""
    z, segment = _nodes(rotor, positions)
    sections, stiff = rotor.shaft.sections(), rotor.shaft.stiff_sections()
    n = 4 * len(z)
    M, K, G = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for k, (length, s) in enumerate(zip(np.diff(z), segment, strict=True)):
        beam = element(float(length), sections[s])
        x, y = 4 * k + X_PLANE, 4 * k + Y_PLANE
        signs = np.outer(Y_SIGN, Y_SIGN)
        for total, part in ((M, beam.M), (K, element(float(length), stiff[s]).K)):
            total[np.ix_(x, x)] += part
            total[np.ix_(y, y)] += signs * part
        G[np.ix_(x, y)] += beam.G * Y_SIGN
        G[np.ix_(y, x)] -= Y_SIGN[:, None] * beam.G
    mesh = Mesh(z, M, K, G)
    for position, disk in rotor.disks.items():
        first = 4 * mesh.node(position)
        M[first : first + 4, first : first + 4] += np.diag([disk.mass, disk.mass, disk.Id, disk.Id])
        G[first + 2, first + 3] += disk.Ip
        G[first + 3, first + 2] -= disk.Ip
    return mesh


def _nodes(rotor: Rotor, positions: Iterable[float]) -> tuple[Array, NDArray[np.intp]]:
    """Node positions [m], and the segment in which each element lies."""
    ends = rotor.shaft.ends
    wanted = np.sort(np.concatenate([ends, list(rotor.disks), list(positions)]))
    wanted = np.clip(wanted, 0.0, ends[-1])
    stations = wanted[np.concatenate([[True], np.diff(wanted) > 1e-9 * ends[-1]])]
    pieces = [np.linspace(a, b, int(np.ceil((b - a) / rotor.element - 1e-9)) + 1)[:-1] for a, b in pairwise(stations)]
    z = np.concatenate([*pieces, stations[-1:]])
    middle = (z[:-1] + z[1:]) / 2
    return z, np.searchsorted(ends, middle) - 1


def with_cones(shaft: Shaft, angle: float = 45.0, slices: int = 6) -> Shaft:
    """The same shaft with stiffness diameters that widen like cones behind each step.

    Parameters
    ----------
    shaft : Shaft
    angle : half the opening of the cones [degrees]; 90 is plain beam theory
    slices : how many cylinders stand for one cone
    """
    if not 0 < angle < 90:
        raise ValueError(f"angle = {angle:g} degrees: it must lie between 0 and 90, both excluded.")
    if slices < 1:
        raise ValueError(f"slices = {slices}: a cone needs at least one.")
    ends, diameter = shaft.ends, np.asarray(shaft.diameter, dtype=float)
    slope = 2 * np.tan(np.radians(angle))
    reach = (diameter.max() - np.minimum(diameter[:-1], diameter[1:])) / slope
    beside = [step + side * r * np.linspace(0, 1, slices + 1) for step, r in _pairs(ends, reach) for side in (-1, 1)]
    cuts = np.sort(np.concatenate([ends, *beside]))
    cuts = cuts[(cuts >= 0) & (cuts <= ends[-1])]
    cuts = cuts[np.concatenate([[True], np.diff(cuts) > 1e-9 * ends[-1]])]
    middle = np.array([(a + b) / 2 for a, b in pairwise(cuts)])
    segment = np.searchsorted(ends, middle) - 1
    inner = np.broadcast_to(shaft.inner, len(diameter))[segment]
    return Shaft(
        list(np.diff(cuts)),
        list(diameter[segment]),
        list(inner),
        shaft.E,
        shaft.rho,
        shaft.nu,
        stiff=list(_widening(ends, diameter, slope, middle, segment)),
    )


def _pairs(ends: Array, reach: Array) -> list[tuple[float, float]]:
    return [(float(step), float(r)) for step, r in zip(ends[1:-1], reach, strict=True)]


def _widening(ends: Array, diameter: Array, slope: float, z: Array, segment: NDArray[np.intp]) -> Array:
    """Diameter of what works at each z [m]: no more than the segment's, no more than any cone that reaches there."""
    working = diameter[segment]
    for k, step in enumerate(ends[1:-1]):
        left, right = diameter[k], diameter[k + 1]
        behind = z < step if left > right else z > step
        cone = min(left, right) + slope * np.abs(z - step)
        working = np.where(behind, np.minimum(working, cone), working)
    return np.asarray(working)
