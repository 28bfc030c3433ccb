"""Structured meshes of 20-node bricks: curved blocks, swept along z and joined. Needs the extra rbfound[solid]."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from skfem import Element, ElementHexS2, ElementQuadS2, MeshHex1

Array = NDArray[np.float64]
Section = Callable[[Array, Array], tuple[Array, Array]]

# Corners of neighbouring blocks closer than this [m] are one node.
SAME_POINT = 1e-8


@dataclass(frozen=True)
class Material:
    """A linear elastic, isotropic material: E [Pa], Poisson's ratio nu [-], rho [kg/m^3]."""

    E: float = 210e9
    nu: float = 0.3
    rho: float = 7850.0

    def __post_init__(self) -> None:
        for name in ("E", "rho"):
            if not 0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} = {getattr(self, name):g}: it must be positive and finite.")
        if not -1 < self.nu < 0.5:
            raise ValueError(
                f"nu = {self.nu:g}: Poisson's ratio of a solid must lie between -1 and 0.5, both excluded."
            )

    @property
    def lame(self) -> tuple[float, float]:
        """lambda and mu [Pa]: stress = lambda tr(strain) I + 2 mu strain."""
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu)), self.E / (2 * (1 + self.nu))


STEEL = Material()


@dataclass(repr=False)
class SerendipityMesh(MeshHex1):
    """Hexahedra with 8 corners and 12 midside nodes: the geometry is as curved as the displacement may be.

    scikit-fem has the element (ElementHexS2) but no mesh to go with it; a mesh knows where its nodes are by `elem`.
    """

    elem: type[Element] = ElementHexS2

    @property
    def bndelem(self) -> ElementQuadS2:
        return ElementQuadS2()


@dataclass(frozen=True, eq=False)
class Block:
    """A piece of the body whose outline in the x, y plane is the same for every z.

    Attributes
    ----------
    section : function of (u, v), arrays of one shape, that returns x and y [m] of that shape
    u, v : ascending parameters of the grid lines of the section
    z : ascending heights of the grid lines along z [m]
    material : Material, steel unless told
    """

    section: Section
    u: Array
    v: Array
    z: Array
    material: Material = STEEL

    def elements(self) -> Array:
        """Positions of the twenty nodes of every element, (20, elements, 3), in the order of ElementHexS2."""
        grid = np.meshgrid(*(np.arange(len(lines) - 1) for lines in (self.u, self.v, self.z)), indexing="ij")
        places = []
        for lines, index, local in zip((self.u, self.v, self.z), grid, ElementHexS2.doflocs.T, strict=True):
            start, step = lines[index.ravel()], np.diff(lines)[index.ravel()]
            places.append(start + np.outer(local, step))
        x, y = self.section(places[0], places[1])
        return np.stack([x, y, places[2]], axis=-1)


def join(blocks: Sequence[Block]) -> tuple[SerendipityMesh, NDArray[np.intp]]:
    """One mesh out of blocks that share the corners on their common faces, and the block of each element.

    Nodes are numbered as the blocks bring them, not by position: a slightly changed body keeps its numbers.
    """
    pieces = [block.elements() for block in blocks]
    owner = np.repeat(np.arange(len(blocks)), [piece.shape[1] for piece in pieces])
    nodes = np.concatenate(pieces, axis=1)
    corners = nodes[:8].reshape(-1, 3)
    pairs = cKDTree(corners).query_pairs(SAME_POINT, output_type="ndarray")
    touching = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(len(corners), len(corners)))
    _, number = connected_components(touching, directed=False)
    _, first = np.unique(number, return_index=True)
    t = number.reshape(8, -1).astype(np.int32)
    plain = MeshHex1(np.ascontiguousarray(corners[first].T), t)
    places = np.empty((3, plain.nvertices + plain.nedges))
    places[:, : plain.nvertices] = plain.p
    places[:, plain.nvertices + plain.t2e] = np.moveaxis(nodes[8:], -1, 0)
    return SerendipityMesh(places, t), owner


def cuts(places: Sequence[float], fractions: Sequence[Array]) -> Array:
    """Grid lines through the given places; between each two of them at the given fractions from 0 to 1."""
    pieces = [
        low + (high - low) * within[:-1] for low, high, within in zip(places[:-1], places[1:], fractions, strict=True)
    ]
    return np.append(np.concatenate(pieces), places[-1])


def rectangle(x: Array, y: Array) -> tuple[Array, Array]:
    """The section whose parameters are x and y themselves."""
    return x, y


def ring(centre: tuple[float, float], inner: float, outer: float, turn: float = 0.0) -> Section:
    """A quarter of a ring: u = 0 to 1 turns clockwise by 90 degrees, v = 0 to 1 goes outwards.

    It is centred on straight down, turned by so many quarters anticlockwise.
    """

    def section(u: Array, v: Array) -> tuple[Array, Array]:
        direction, radius = _direction(u, turn), inner + (outer - inner) * v
        return centre[0] + radius * direction[0], centre[1] + radius * direction[1]

    return section


def ring_in_square(centre: tuple[float, float], inner: float, side: float, turn: float = 0.0) -> Section:
    """A quarter of what lies between a circle and the square around it, with the parameters of `ring`."""

    def section(u: Array, v: Array) -> tuple[Array, Array]:
        direction = _direction(u, turn)
        along, out = side * (0.5 - u), np.full_like(u, side / 2)
        corner = _turned(along, -out, turn)
        x, y = (inner * d * (1 - v) + c * v for d, c in zip(direction, corner, strict=True))
        return centre[0] + x, centre[1] + y

    return section


def brick(size: ArrayLike, divisions: Sequence[int]) -> Block:
    """A plain cuboid from the origin, size (3,) [m], with so many elements along x, y and z."""
    x, y, z = (np.linspace(0, length, n + 1) for length, n in zip(np.asarray(size, float), divisions, strict=True))
    return Block(rectangle, x, y, z)


def _direction(u: Array, turn: float) -> tuple[Array, Array]:
    angle = np.pi / 2 * (turn - 0.5 - u)
    return np.cos(angle), np.sin(angle)


def _turned(x: Array, y: Array, quarters: float) -> tuple[Array, Array]:
    c, s = np.cos(np.pi / 2 * quarters), np.sin(np.pi / 2 * quarters)
    return c * x - s * y, s * x + c * y
