"""Closed surfaces that move: the shaft and the solid foundation as they are drawn in three dimensions.

Axes: Z along the shaft, X horizontal, Y up.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from rbfound.rotor import Rotor

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Points around a circle: a cylinder is drawn with this many sides.
SIDES = 24

# Two faces that enclose an angle with a smaller cosine meet in an edge that one would draw.
SHARP = 0.8


@dataclass(frozen=True, eq=False)
class Body:
    """A closed surface of quadrilaterals, and how modes move its points.

    Attributes
    ----------
    name : what a reader calls it
    points : (p, 3) [m]
    faces : (f, 4) indices of points, anticlockwise as seen from outside
        A corner may stand twice: a triangle.
    shapes : (modes, p, 3) real or complex displacements, in one unit for all bodies of a picture
    marks : labels of points; a point may be marked without belonging to a face
    sheer : whether it is drawn so that what stands inside is seen
    """

    name: str
    points: Array
    faces: Indices
    shapes: NDArray[Any]
    marks: Mapping[str, int] = field(default_factory=dict)
    sheer: bool = False

    def __post_init__(self) -> None:
        p = len(self.points)
        if np.shape(self.points) != (p, 3) or np.ndim(self.shapes) != 3 or np.shape(self.shapes)[1:] != (p, 3):
            raise ValueError(
                f"{self.name}: points are {np.shape(self.points)} and shapes {np.shape(self.shapes)}: "
                "they must be (p, 3) and (modes, p, 3)."
            )
        if np.ndim(self.faces) != 2 or np.shape(self.faces)[1] != 4 or not len(self.faces):
            raise ValueError(f"{self.name}: faces are {np.shape(self.faces)}: they must be (faces, 4).")
        numbers = [*np.ravel(self.faces), *self.marks.values()]
        if min(numbers) < 0 or max(numbers) >= p:
            raise ValueError(f"{self.name}: a face or mark names point {max(numbers)} of {p}: they count from 0.")
        if not (np.isfinite(self.points).all() and np.isfinite(self.shapes).all()):
            raise ValueError(f"{self.name}: points and shapes must be finite.")
        if self.volume <= 0:
            raise ValueError(
                f"{self.name}: its faces enclose {self.volume:.3g} m³: they must close a body and run anticlockwise "
                "as seen from outside."
            )

    @property
    def volume(self) -> float:
        """What the faces enclose [m^3], from two triangles each."""
        a, b, c, d = np.moveaxis(self.points[self.faces] - self.points.mean(axis=0), 1, 0)
        return float(np.sum(a * (np.cross(b, c) + np.cross(c, d))) / 6)

    @property
    def normals(self) -> Array:
        """Unit vectors that point out of each face, (f, 3)."""
        return _normals(self.points, self.faces)

    def edges(self, towards: ArrayLike, moved: Array | None = None) -> Indices:
        """The edges that a draughtsman would draw, seen from the direction `towards` (3,): pairs of points (e, 2).

        Sharp ones of a face in sight, and those where the body turns away from the viewer; `moved` are other
        positions of its points.
        """
        normals = _normals(self.points if moved is None else moved, self.faces)
        pairs = np.sort(self.faces[:, [[0, 1], [1, 2], [2, 3], [3, 0]]], axis=2).reshape(-1, 2)
        owner = np.repeat(np.arange(len(self.faces)), 4)
        order = np.lexsort(pairs.T)
        pairs, owner = pairs[order], owner[order]
        first = np.flatnonzero((pairs[1:] == pairs[:-1]).all(axis=1) & (pairs[1:, 0] != pairs[1:, 1]))
        a, b = owner[first], owner[first + 1]
        front = normals @ np.asarray(towards, dtype=float) > 0
        sharp = np.sum(normals[a] * normals[b], axis=1) < SHARP
        return np.asarray(pairs[first][(front[a] != front[b]) | (sharp & front[a])])


def rotor_body(
    rotor: Rotor,
    z: ArrayLike,
    shapes: ArrayLike,
    bearings: Sequence[float] = (),
    on: Body | None = None,
    name: str = "rotor",
) -> Body:
    """The shaft's surface, each section moved as a rigid disk by the beam's node in its middle.

    Parameters
    ----------
    rotor : Rotor
    z : (nodes,) positions of the nodes [m], as in `Mesh.z`: a node at each end of a segment
    shapes : (4 nodes, modes) displacements x, y and rotations theta, psi node by node
        For a mounted rotor the first rows of `Modes.shapes`.
    bearings : positions [m] to mark as bearing 1, 2, ...; the disks are marked with their mass
    on : what it stands on, of `solid_body`
        The shaft is put where its first bearing meets seat 1, and the marks of the seats stand for the bearings'.
        Alone it begins at the origin.
    """
    z, shapes = np.asarray(z, dtype=float), np.atleast_2d(np.asarray(shapes))
    if len(shapes) != 4 * len(z):
        raise ValueError(f"{len(z)} nodes have {4 * len(z)} coordinates: shapes has {len(shapes)} rows.")
    node, radius = _profile(rotor, z)
    angle = 2 * np.arange(SIDES) * np.pi / SIDES
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    offset = (radius[:, None, None] * ring).reshape(-1, 3)
    node = np.repeat(node, SIDES)
    faces = _strips(len(radius))
    places = {} if on is not None else {f"bearing {k + 1}": float(at) for k, at in enumerate(sorted(bearings))}
    places |= {f"{disk.mass:g} kg": float(at) for at, disk in rotor.disks.items()}
    marked = [_node(z, at) for at in places.values()]
    marks = {label: len(offset) + k for k, label in enumerate(places)}
    offset, node = np.vstack([offset, np.zeros((len(marked), 3))]), np.concatenate([node, marked]).astype(int)
    x, y, theta, psi = np.moveaxis(shapes.reshape(len(z), 4, -1)[node], (1, 2), (0, 1))
    # the rotation (theta, psi, 0) of a section moves what lies beside the axis along z
    along = (theta * offset[:, None, 1].T) - (psi * offset[:, None, 0].T)
    points = offset + np.stack([0 * z[node], 0 * z[node], z[node]], axis=1)
    if on is not None:
        points = points + _seat(on) - [0, 0, min(bearings, default=0.0)]
    return Body(name, points, faces, np.stack([x, y, along], axis=2), marks)


def solid_body(solid: Any, Phi: ArrayLike, drawn: Any = None, sheer: bool = False, name: str = "foundation") -> Body:
    """The skin of a `rbfound.solid.elastic.Solid`, corner by corner, with its seats marked.

    Parameters
    ----------
    solid : Solid
    Phi : (n, modes) displacements of all its coordinates, as `natural_modes` gives them
        Under a rotor: `Phi @ q`, with Phi of `ritz_modes` and q the foundation's rows of `Modes.shapes`.
    drawn : Solid, `solid` itself unless told
        The same body in a coarser mesh, whose skin is drawn in place of a fine one's: each of its corners moves as
        the node of `solid` that is nearest to it.
    """
    Phi = np.asarray(Phi)
    places = np.asarray(solid.mesh.doflocs.T, dtype=float)
    if Phi.ndim != 2 or len(Phi) != 3 * len(places):
        raise ValueError(f"The solid has {3 * len(places)} coordinates: Phi is {Phi.shape}.")
    moves = np.moveaxis(Phi.reshape(3, len(places), -1), (0, 1, 2), (2, 1, 0))
    points, faces = _skin((drawn or solid).mesh)
    distance, nearest = cKDTree(places).query(points)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if distance.max() > 0.02 * size:
        raise ValueError(f"A corner of `drawn` lies {distance.max():.3g} m from every node: it is another body.")
    # a seat is a mean over its bore, and so is the place where its mark stands
    weights = np.asarray(solid.B)[0::2, : len(places)]
    marks = {f"seat {k + 1}": len(points) + k for k in range(len(weights))}
    seats = np.einsum("sp,mpi->msi", weights, moves)
    shapes = np.concatenate([moves[:, nearest], seats], axis=1)
    return Body(name, np.vstack([points, weights @ places]), faces, shapes, marks, sheer)


def _normals(points: Array, faces: Indices) -> Array:
    a, b, c, d = np.moveaxis(points[faces], 1, 0)
    n = np.cross(c - a, d - b)
    return np.asarray(n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-300))


def _seat(body: Body) -> Array:
    """Where the first bearing stands."""
    if "seat 1" not in body.marks:
        raise ValueError(f"{body.name} has no mark 'seat 1' to put a rotor on: its marks are {', '.join(body.marks)}.")
    return np.asarray(body.points[body.marks["seat 1"]])


def _profile(rotor: Rotor, z: Array) -> tuple[Indices, Array]:
    """Half the shaft's section as a line from the axis to the axis: node and radius of each of its corners."""
    ends = rotor.shaft.ends
    node, radius = [0], [0.0]
    for left, right, diameter in zip(ends[:-1], ends[1:], rotor.shaft.diameter, strict=True):
        inside = np.arange(_node(z, float(left)), _node(z, float(right)) + 1)
        node += inside.tolist()
        radius += [diameter / 2] * len(inside)
    return np.array([*node, len(z) - 1]), np.array([*radius, 0.0])


def _node(z: Array, at: float) -> int:
    k = int(np.abs(z - at).argmin())
    if abs(z[k] - at) > 1e-6 * float(np.ptp(z)):
        raise ValueError(f"No node stands at {at:g} m; the nearest one is at {z[k]:g} m.")
    return k


def _strips(rings: int) -> Indices:
    """The faces between circles of SIDES points, one after the other along z, anticlockwise from outside."""
    first = SIDES * np.arange(rings - 1)[:, None]
    here = np.arange(SIDES)
    beside = (here + 1) % SIDES
    corners = [first + here, first + beside, first + SIDES + beside, first + SIDES + here]
    return np.stack(corners, axis=2).reshape(-1, 4)


def _skin(mesh: Any) -> tuple[Array, Indices]:
    """The corners on a hexahedral mesh's surface (p, 3), and its faces (f, 4), anticlockwise from outside."""
    skin = mesh.boundary_facets()
    corners = mesh.p.T
    faces = mesh.facets[:, skin].T
    inside = corners[mesh.t[:8, mesh.f2t[0, skin]]].mean(axis=0)
    outwards = np.sum(_normals(corners, faces) * (corners[faces].mean(axis=1) - inside), axis=1)
    faces = np.where(outwards[:, None] > 0, faces, faces[:, ::-1])
    kept, numbers = np.unique(faces, return_inverse=True)
    return np.asarray(corners[kept], dtype=float), numbers.reshape(-1, 4)
