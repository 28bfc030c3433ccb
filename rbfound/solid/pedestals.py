"""The parametric foundation: two pedestals with bearing houses and a hollow stator between them, as curved blocks.

The thesis never draws its foundation. This body is a stand-in of plain steel: its nine lowest natural frequencies are
those of the thesis's ANSYS model within 1 %. Needs the extra rbfound[solid].
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbfound.solid.mesh import STEEL, Block, Material, Section, cuts, rectangle, ring, ring_in_square

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Lines = tuple[float, ...]

# A node this close [m] to a plane or a cylinder of the drawing lies on it.
ON_IT = 1e-8


@dataclass(frozen=True)
class Bed:
    """What lies between a pad and the ground: a stiffness per area of the pad [N/m^3], across it and along it.

    Notes
    -----
    Cement grout of 25 to 35 GPa, 20 to 80 mm thick, makes E / t = 0.3e12 to 1.8e12 N/m^3 across the pad, and along it
    G / t = E / t / (2 (1 + nu)), 0.42 of that at nu = 0.2 (0.37 where the layer cannot widen, which makes it stiffer
    across). A bolt of 24 mm with 200 mm of free length adds 4.8e8 N/m: 0.03e12 N/m^3 over a pad of 133 x 133 mm.
    These are our estimates from textbook moduli, not a measurement; the defaults lie within them.
    """

    normal: float = 0.89e12
    tangential: float = 0.275e12

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not 0 < value < np.inf:
                raise ValueError(f"{item.name} = {value:g} N/m^3: it must be positive and finite.")


BED = Bed()


@dataclass(frozen=True)
class Grid:
    """Where the grid lines of the mesh lie, as fractions from 0 to 1 of each length of the drawing.

    Close lines stand where the body has an edge that goes inwards: there the stress has no limit, and a mesh that is
    coarse there is too stiff. Named by what is divided: `neck_side` from the neck outwards under the head,
    `beside_neck` from the neck to the pad, `beside_web` from the web to the pad's edge, `stator` and `house_out` from
    the web away. `quarter` is the number of elements along a quarter of the circumference, except the bottom one.
    """

    quarter: int = 4
    house: Lines = (0, 1)
    plate: Lines = (0, 1)
    wall: Lines = (0, 0.2, 0.8, 1)
    margin: Lines = (0, 0.3, 1)
    neck_side: Lines = (0, 0.05, 0.3, 1)
    neck: Lines = (0, 0.06, 0.3, 0.7, 0.94, 1)
    neck_height: Lines = (0, 0.15, 0.5, 0.85, 1)
    web: Lines = (0, 0.5, 1)
    foot: Lines = (0, 0.4, 0.75, 0.94, 1)
    beside_neck: Lines = (0, 0.15, 1)
    pad: Lines = (0, 0.5, 1)
    beside_pad: Lines = (0, 1)
    beside_web: Lines = (0, 0.1, 0.35, 1)
    foot_end: Lines = (0, 1)
    house_out: Lines = (0, 0.4, 1)
    stator: Lines = (0, 0.08, 0.35, 1)

    def lines(self, refinement: int) -> dict[str, Array]:
        """All fractions by name, each step divided into so many equal parts."""
        names = [item.name for item in fields(self) if item.name != "quarter"]
        parts = np.arange(refinement) / refinement
        given = {name: np.asarray(getattr(self, name), dtype=float) for name in names}
        return {
            name: np.append((lines[:-1, None] + np.diff(lines)[:, None] * parts).ravel(), lines[-1])
            for name, lines in given.items()
        }

    def halved(self, *names: str) -> "Grid":
        """The same grid with each step of the named lengths halved."""
        finer = self.lines(2)
        given: dict[str, Any] = {name: tuple(finer[name].tolist()) for name in names}
        return replace(self, **given)


WORKING = Grid()

# About a fifth of the coordinates: to see what the working grid gains.
COARSE = Grid(
    wall=(0, 1),
    margin=(0, 1),
    neck_side=(0, 1),
    neck=(0, 0.2, 0.8, 1),
    neck_height=(0, 0.5, 1),
    web=(0, 1),
    foot=(0, 0.6, 1),
    beside_neck=(0, 1),
    beside_web=(0, 0.3, 1),
    house_out=(0, 1),
    stator=(0, 0.3, 1),
)


@dataclass(frozen=True)
class FoundationGeometry:
    """Lengths [m], materials and bed of the foundation. Z lies along the shaft, X is horizontal, Y points up.

    Both pedestals are alike, and the body is its own mirror image in the plane half way along the stator; only the
    beds differ (`uneven`). Pedestal 1 has its web at z = 0 to `web`, then come the stator and the web of pedestal 2.
    The shaft runs at x = 0, y = `shaft_height`; the ground is y = 0.

    Attributes
    ----------
    shaft_height : from the ground to the centre of the bores
    head_width : side of the square head around the bore
    neck_width, neck_offset : width of the neck between head and foot, and how far its middle stands beside x = 0
        The neck is as high as what `shaft_height` leaves between the head and the foot.
    web : thickness of head and neck along z
    foot_thickness, foot_half_width, foot_half_length : along y, x and z
    pad_place, pad_half_size : the squares under the feet that stand on the bed lie at x = +- pad_place, in the middle
        of the web
    bore_radius : of the bearing seats
    house_radius, house_length : the rings around the bores that stick out of both webs
    stator_inner, stator_outer, stator_length : radii and length of the hollow stator
    pedestal, stator : Material
    bed : Bed under the pads, or None: then the pads are clamped
    uneven : by which part the bed of pedestal 1 is stiffer, and that of pedestal 2 softer, than `bed`
        No two pads are grouted alike. With 0 the whole is its own mirror image, and every mode looks the same from
        both seats: no measured foundation is like that.

    Notes
    -----
    The defaults are of steel throughout and were found by least squares on the thesis's nine frequencies, on the grid
    WORKING, then rounded to tenths of a millimetre. The middles of the two seats are 805 mm apart, as the bearings of
    `rbfound.thesis.beam_models.rotor` are: this was asked of the fit. `data/README.md` says what the mesh still
    changes.
    """

    shaft_height: float = 0.2951
    head_width: float = 0.4134
    neck_width: float = 0.1803
    neck_offset: float = -0.03
    web: float = 0.0288
    foot_thickness: float = 0.0646
    foot_half_width: float = 0.3596
    foot_half_length: float = 0.198
    pad_place: float = 0.2767
    pad_half_size: float = 0.0663
    bore_radius: float = 0.02
    house_radius: float = 0.0403
    house_length: float = 0.0332
    stator_inner: float = 0.1392
    stator_outer: float = 0.1996
    stator_length: float = 0.743
    pedestal: Material = STEEL
    stator: Material = STEEL
    bed: Bed | None = BED
    uneven: float = 0.03

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, float) and item.name not in ("neck_offset", "uneven") and not 0 < value < np.inf:
                raise ValueError(f"{item.name} = {value:g} m: it must be positive and finite.")
        if not -1 < self.uneven < 1:
            raise ValueError(f"uneven = {self.uneven:g}: it must lie between -1 and 1.")
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
            ("neck_width / 2 + |neck_offset|", beside, "head_width / 2", head),
            ("neck_width / 2 + |neck_offset|", beside, "pad_place - pad_half_size", pads[0]),
            ("pad_place + pad_half_size", pads[1], "foot_half_width", self.foot_half_width),
            ("web / 2", self.web / 2, "pad_half_size", self.pad_half_size),
            ("pad_half_size", self.pad_half_size, "foot_half_length", self.foot_half_length),
            ("foot_half_length", self.foot_half_length, "half of stator_length", self.stator_length / 2),
        ):
            if not value < limit:
                raise ValueError(f"{low} = {value:g} m must be smaller than {high} = {limit:g} m.")

    def mirrored(self, z: Array) -> Array:
        """Ascending heights z [m] on the other side of the plane of symmetry, ascending again."""
        return 2 * self.middle - np.asarray(z)[::-1]

    @property
    def middle(self) -> float:
        """z of the plane of symmetry [m]."""
        return self.web + self.stator_length / 2

    @property
    def pads(self) -> Array:
        """Middles of the four pads [m], (4, 3)."""
        webs = self.web / 2, 1.5 * self.web + self.stator_length
        return np.array([(x, 0, z) for z in webs for x in (-self.pad_place, self.pad_place)])

    def on_pads(self, places: Array, pedestal: int | None = None) -> Flags:
        """Which of the places (3, n) lie in one of the four squares on the ground, or in the two of one pedestal."""
        x, y, z = places
        reach = self.pad_half_size + ON_IT
        # both feet at once: the distance of a place from the plane of symmetry says where it lies on its foot
        along = np.abs(np.abs(z - self.middle) - (self.middle - self.web / 2))
        here = True if pedestal is None else (z < self.middle) == (pedestal == 1)
        return here & (np.abs(y) <= ON_IT) & (np.abs(np.abs(x) - self.pad_place) <= reach) & (along <= reach)

    def on_bore(self, places: Array, seat: int) -> Flags:
        """Which of the places (3, n) lie on the bore of seat 1 or 2."""
        x, y, z = places
        here = (z < self.middle) == (seat == 1)
        return here & (np.abs(np.hypot(x, y - self.shaft_height) - self.bore_radius) <= ON_IT)


def foundation_blocks(
    geometry: FoundationGeometry, refinement: int = 1, grid: Grid = WORKING, half: bool = False
) -> list[Block]:
    """The body as blocks that fit together.

    Parameters
    ----------
    refinement : into how many equal parts each step of the grid is divided
    half : pedestal 1 and the stator up to the plane of symmetry only
    """
    if refinement < 1:
        raise ValueError(f"refinement is {refinement}: it must be 1 or more.")
    g, f = geometry, grid.lines(refinement)
    centre, turns = (0.0, g.shaft_height), np.linspace(0, 1, grid.quarter * refinement + 1)
    x_foot, under = _lines_across(g, f)
    x_neck = under[(under >= g.neck_offset - g.neck_width / 2) & (under <= g.neck_offset + g.neck_width / 2)]
    below = (0.5 - under / g.head_width)[::-1]
    first = cuts([0.0, g.web], [f["web"]])
    pad, middle = g.pad_half_size, g.web / 2
    z_foot = cuts(
        [middle - g.foot_half_length, middle - pad, 0.0, g.web, middle + pad, middle + g.foot_half_length],
        [_back(f["foot_end"]), _back(f["beside_web"]), f["web"], f["beside_web"], f["foot_end"]],
    )
    y_neck = cuts([g.foot_thickness, g.shaft_height - g.head_width / 2], [f["neck_height"]])

    def around(sections: list[Section], v: Array, z: Array, material: Material = g.pedestal) -> list[Block]:
        """Four quarters; the bottom one has the lines of the neck."""
        return [Block(section, turns if k else below, v, z, material) for k, section in enumerate(sections)]

    def tube(inner: float, outer: float, v: Array, z: Array, material: Material = g.pedestal) -> list[Block]:
        return around([ring(centre, inner, outer, quarter) for quarter in range(4)], v, z, material)

    out = []
    for turn in (np.asarray, g.mirrored)[: 1 if half else 2]:
        web = turn(first)
        out += tube(g.bore_radius, g.house_radius, f["house"], web)
        out += tube(g.house_radius, g.stator_inner, f["plate"], web)
        out += tube(g.stator_inner, g.stator_outer, f["wall"], web)
        out += around([ring_in_square(centre, g.stator_outer, g.head_width, k) for k in range(4)], f["margin"], web)
        out.append(Block(rectangle, x_neck, y_neck, web, g.pedestal))
        out.append(Block(rectangle, x_foot, g.foot_thickness * f["foot"], turn(z_foot), g.pedestal))
        outside = turn(cuts([-g.house_length, 0.0], [_back(f["house_out"])]))
        out += tube(g.bore_radius, g.house_radius, f["house"], outside)
        inside = turn(cuts([g.web, g.middle], [f["stator"]]))
        out += tube(g.stator_inner, g.stator_outer, f["wall"], inside, g.stator)
    return out


def _lines_across(g: FoundationGeometry, f: dict[str, Array]) -> tuple[Array, Array]:
    """x of the grid lines in the foot, and on the lower edge of the head."""
    left, right = g.neck_offset - g.neck_width / 2, g.neck_offset + g.neck_width / 2
    near, far, end = g.pad_place - g.pad_half_size, g.pad_place + g.pad_half_size, g.foot_half_width
    out = [f["beside_neck"], f["pad"], f["beside_pad"]]
    foot = cuts([-end, -far, -near, left, right, near, far, end], [*map(_back, out[::-1]), f["neck"], *out])
    under = cuts([-g.head_width / 2, left, right, g.head_width / 2], [_back(f["neck_side"]), f["neck"], f["neck_side"]])
    return foot, under


def _back(fractions: Array) -> Array:
    return 1 - fractions[::-1]
