"""The parametric foundation: two pedestals with bearing houses and a hollow stator between them, as curved blocks.

The thesis never draws its foundation. This body is a stand-in: its nine lowest natural frequencies are those of the
thesis's ANSYS model within 1 %, on the mesh built here. Needs the extra rbfound[solid].
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from rbfound.mesh import STEEL, Block, Material, cuts, rectangle, ring, ring_in_square, taper

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# A node this close [m] to a plane or a cylinder of the drawing lies on it.
ON_IT = 1e-8

# Elements along a quarter of the circumference in the mesh that the lengths were fitted on.
QUARTER = 6

# Not a real material: found together with the lengths. An all-steel body was only fitted within 5 %.
STATOR = Material(E=0.81567 * STEEL.E, rho=0.45058 * STEEL.rho)


@dataclass(frozen=True)
class FoundationGeometry:
    """Lengths [m] and materials of the foundation. Z lies along the shaft, X is horizontal, Y points up.

    Pedestal 1 has its web at z = 0 to `web_1`, the stator follows, then the web of pedestal 2. The shaft runs at
    x = 0, y = `shaft_height`; the ground is y = 0.

    Attributes
    ----------
    shaft_height : from the ground to the centre of the bores
    head_width : side of the square head around the bore
    neck_width, neck_offset : width of the web where it meets the foot, and how far its middle stands beside x = 0
    web_1, web_2 : thickness of the webs along z
    foot_thickness, foot_half_width, foot_half_length : along y, x and z
    pad_place, pad_half_size : the clamped squares under the feet lie at x = +- pad_place, in the middle of the web
    bore_radius : of the bearing seats
    house_radius, house_length : the rings around the bores that stick out of both webs
    stator_inner, stator_outer, stator_length : radii and length of the hollow stator
    pedestal, stator : Material

    Notes
    -----
    The defaults were found by least squares on the thesis's nine frequencies, on the mesh of `foundation_blocks`, and
    belong to it: with every element edge halved the nine fall by 0.3 to 2.5 % (`data/README.md` has the table). The
    edges of the clamped pads are singular, so the frequencies settle slowly on any mesh.
    """

    shaft_height: float = 0.2739
    head_width: float = 0.48191
    neck_width: float = 0.21411
    neck_offset: float = -0.01085
    web_1: float = 0.02085
    web_2: float = 0.03572
    foot_thickness: float = 0.02601
    foot_half_width: float = 0.26556
    foot_half_length: float = 0.10973
    pad_place: float = 0.22549
    pad_half_size: float = 0.03187
    bore_radius: float = 0.01572
    house_radius: float = 0.0923
    house_length: float = 0.09775
    stator_inner: float = 0.21314
    stator_outer: float = 0.23115
    stator_length: float = 0.84035
    pedestal: Material = STEEL
    stator: Material = STATOR

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, float) and item.name != "neck_offset" and not 0 < value < np.inf:
                raise ValueError(f"{item.name} = {value:g} m: it must be positive and finite.")
        beside = self.neck_width / 2 + abs(self.neck_offset)
        pads = self.pad_place - self.pad_half_size, self.pad_place + self.pad_half_size
        head = self.head_width / 2
        # blocks that overlap would still give a mesh, of another body
        for low, value, high, limit in (
            ("bore_radius", self.bore_radius, "house_radius", self.house_radius),
            ("house_radius", self.house_radius, "stator_inner", self.stator_inner),
            ("stator_inner", self.stator_inner, "stator_outer", self.stator_outer),
            ("stator_outer", self.stator_outer, "head_width / 2", head),
            ("foot_thickness", self.foot_thickness, "shaft_height - head_width / 2", self.shaft_height - head),
            ("neck_width / 2 + |neck_offset|", beside, "pad_place - pad_half_size", pads[0]),
            ("pad_place + pad_half_size", pads[1], "foot_half_width", self.foot_half_width),
            ("half of the thicker web", max(self.web_1, self.web_2) / 2, "pad_half_size", self.pad_half_size),
            ("pad_half_size", self.pad_half_size, "foot_half_length", self.foot_half_length),
            ("foot_half_length", self.foot_half_length, "half of stator_length", self.stator_length / 2),
        ):
            if not value < limit:
                raise ValueError(f"{low} = {value:g} m must be smaller than {high} = {limit:g} m.")

    @property
    def webs(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where the webs of pedestal 1 and 2 begin and end along z [m]."""
        second = self.web_1 + self.stator_length
        return (0.0, self.web_1), (second, second + self.web_2)

    def on_pads(self, places: Array) -> Flags:
        """Which of the places (3, n) lie in one of the four clamped squares on the ground."""
        x, y, z = places
        reach = self.pad_half_size + ON_IT
        middle = np.array([sum(web) / 2 for web in self.webs])
        beside = np.abs(np.abs(x) - self.pad_place) <= reach
        return (np.abs(y) <= ON_IT) & beside & (np.abs(z[:, None] - middle) <= reach).any(axis=1)

    def on_bore(self, places: Array, seat: int) -> Flags:
        """Which of the places (3, n) lie on the bore of seat 1 or 2."""
        x, y, z = places
        here = (z < self.stator_length / 2) == (seat == 1)
        return here & (np.abs(np.hypot(x, y - self.shaft_height) - self.bore_radius) <= ON_IT)


def foundation_blocks(geometry: FoundationGeometry, refinement: int = 1) -> list[Block]:
    """The body as blocks that fit together; `refinement` multiplies the number of elements along every edge."""
    if refinement < 1:
        raise ValueError(f"refinement is {refinement}: it must be 1 or more.")
    g, n = geometry, refinement
    out = []
    for web in g.webs:
        z = np.linspace(*web, n + 1)
        out += _tube(g, n, g.bore_radius, g.house_radius, 1, z)
        out += _tube(g, n, g.house_radius, g.stator_inner, 2, z)
        out += _tube(g, n, g.stator_inner, g.stator_outer, 1, z)
        out += _margin_and_neck(g, n, z)
        out.append(_foot(g, n, web))
    (start, left), (right, end) = g.webs
    for low in (start - g.house_length, end):
        out += _tube(g, n, g.bore_radius, g.house_radius, 1, np.linspace(low, low + g.house_length, 2 * n + 1))
    z = np.linspace(left, right, 6 * n + 1)
    return out + _tube(g, n, g.stator_inner, g.stator_outer, 1, z, g.stator)


def _tube(
    g: FoundationGeometry, n: int, inner: float, outer: float, layers: int, z: Array, material: Material | None = None
) -> list[Block]:
    """A ring around the shaft as four quarters."""
    u, v = _steps(QUARTER * n), _steps(layers * n)
    sections = [ring((0.0, g.shaft_height), inner, outer, quarter) for quarter in range(4)]
    return [Block(section, u, v, z, material or g.pedestal) for section in sections]


def _margin_and_neck(g: FoundationGeometry, n: int, z: Array) -> list[Block]:
    """What makes the outermost ring of the head a square, and the taper from there to the foot."""
    u, v = _steps(QUARTER * n), _steps(n)
    centre = (0.0, g.shaft_height)
    sections = [ring_in_square(centre, g.stator_outer, g.head_width, quarter) for quarter in range(4)]
    top = (0.0, g.head_width, g.shaft_height - g.head_width / 2)
    sections.append(taper(top, (g.neck_offset, g.neck_width, g.foot_thickness)))
    return [Block(section, u, v, z, g.pedestal) for section in sections]


def _foot(g: FoundationGeometry, n: int, web: tuple[float, float]) -> Block:
    """A plate with grid lines along the pads, the neck and the web."""
    neck = (g.neck_offset - g.neck_width / 2, g.neck_offset + g.neck_width / 2)
    right = (g.pad_place - g.pad_half_size, g.pad_place + g.pad_half_size, g.foot_half_width)
    x = cuts([-right[2], -right[1], -right[0], *neck, *right], [n, 2 * n, n, QUARTER * n, n, 2 * n, n])
    y = np.linspace(0, g.foot_thickness, 2 * n + 1)
    middle = sum(web) / 2
    pad, end = g.pad_half_size, g.foot_half_length
    z = cuts([middle - end, middle - pad, *web, middle + pad, middle + end], [n, 2 * n, n, 2 * n, n])
    return Block(rectangle, x, y, z, g.pedestal)


def _steps(count: int) -> Array:
    return np.linspace(0, 1, count + 1)
