"""The foundation as a three-dimensional elastic body: mesh, modes, receptances at the bearing seats, reduced model.

Two pedestals (foot plate, neck, square head with a bore, bearing house) carry a hollow stator between them and stand
on the elastic bed of four pads. Z lies along the shaft, X is horizontal, Y points up from the ground. Needs the extra
rbfound[solid] (scikit-fem); `import rbfound` does not load this module.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from rbfound.foundation import Foundation, modal_foundation
from rbfound.frf import FRF
from rbfound.solid.elastic import Solid, Under, elastic_solid
from rbfound.solid.pedestals import COARSE, ON_IT, WORKING, FoundationGeometry, Grid, foundation_blocks
from rbfound.theory import factorised, lowest_modes, ritz
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Factor = Callable[[sparse.csc_array], Callable[[Array], Array]]

GEOMETRY = FoundationGeometry()
MESHES = {"coarse": COARSE, "working": WORKING}


def foundation_solid(
    geometry: FoundationGeometry = GEOMETRY, refinement: int = 1, grid: Grid = WORKING, full: bool = False
) -> Solid:
    """The foundation on its bed, or clamped where the geometry has none, with the seats x1, y1, x2, y2.

    Parameters
    ----------
    refinement, grid : the mesh, as in `rbfound.solid.pedestals.foundation_blocks`
    full : as in `elastic_solid`
    """
    return elastic_solid(
        foundation_blocks(geometry, refinement, grid),
        geometry.on_pads if geometry.bed is None else None,
        [partial(geometry.on_bore, seat=seat) for seat in (1, 2)],
        beds_of(geometry),
        full,
    )


def beds_of(geometry: FoundationGeometry) -> list[Under]:
    """The beds of the two pedestals as `elastic_solid` takes them; none where the pads are clamped."""
    bed = geometry.bed
    if bed is None:
        return []
    parts = (1, 1 + geometry.uneven), (2, 1 - geometry.uneven)
    per_area = np.array([bed.tangential, bed.normal, bed.tangential])
    return [(partial(geometry.on_pads, pedestal=pedestal), tuple(part * per_area)) for pedestal, part in parts]


def mirror_halves(
    geometry: FoundationGeometry = GEOMETRY, refinement: int = 1, grid: Grid = WORKING
) -> tuple[Solid, Solid]:
    """The foundation on its bed cut in its plane of symmetry: two bodies whose frequencies together are the whole's.

    In the first the cut moves within its plane, in the second across it. Each has half the coordinates, so a fine mesh
    costs much less than the whole. They have no seats, and stand on even beds.
    """
    bed = beds_of(replace(geometry, uneven=0.0))[:1]
    half = elastic_solid(foundation_blocks(geometry, refinement, grid, half=True), beds=bed)
    cut = np.abs(half.mesh.doflocs[2] - geometry.middle) <= ON_IT
    off = np.zeros_like(cut)
    held = (off, off, cut), (cut, cut, off)
    first, second = (replace(half, free=np.flatnonzero(~np.concatenate(these))) for these in held)
    return first, second


def mesh_study(
    grids: Mapping[str, Grid] = MESHES, geometry: FoundationGeometry = GEOMETRY, count: int = 9
) -> dict[str, list[Any]]:
    """Natural frequencies against mesh and integration: columns for `rbfound.table`, one row for each mesh.

    Each grid, the coarse and the working one unless told otherwise, with the stiffness integrated by 2 x 2 x 2 and by
    3 x 3 x 3 points: its coordinates, its longest edge [mm], the lowest frequencies [Hz], and the seconds from drawing
    to modes.
    """
    rows: list[list[Any]] = []
    for name, grid in grids.items():
        for points, full in (("2 x 2 x 2", False), ("3 x 3 x 3", True)):
            start = perf_counter()
            solid = foundation_solid(geometry, grid=grid, full=full)
            frequency = hertz(natural_modes(solid, count)[0])
            seconds = perf_counter() - start
            size, edge = solid.K.shape[0], 1e3 * float(solid.mesh.param())
            rows.append([name, points, size, edge, *frequency, seconds])
    frequencies = [f"f{k + 1} [Hz]" for k in range(count)]
    names = ["mesh", "points", "coordinates", "longest edge [mm]", *frequencies, "time [s]"]
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def natural_modes(solid: Solid, count: int, shift: float = 0.0, factor: Factor | None = None) -> tuple[Array, Array]:
    """The undamped natural modes nearest to a frequency: omega (count,) [rad/s], ascending, and Phi (n, count).

    The columns of Phi are mass-normalised [1/sqrt(kg)] and zero where the body is held; see
    `rbfound.theory.reduction.lowest_modes`.

    Parameters
    ----------
    shift : [Hz]
        0 gives the lowest modes of a held body. A body that can move freely needs a negative one: the iteration
        then works around a square of omega below zero, where the stiffness is not singular.
    factor : function of a symmetric sparse matrix that returns its inverse as a function of forces (n,)
        SciPy's SuperLU unless given. For large bodies a Cholesky factor takes half the memory and less than half the
        time: `benchmarks/solid.py` shows it with PARDISO.

    Raises
    ------
    ValueError
        When nothing holds the body and the shift is not below zero, or it has not so many modes.
    """
    M, K = _free(solid, solid.M, solid.K)
    squares, Phi = lowest_modes(M, K, count, shift, factor)
    # a free body's six zeros come out as rounding on either side of zero
    return np.sqrt(np.maximum(squares, 0)), _whole(solid, Phi)


def ritz_modes(solid: Solid, modes: int = 16, blocks: int = 3, shift: float = 0.0) -> tuple[Array, Array]:
    """Frequencies omega [rad/s] and mass-normalised shapes Phi (n, m) that carry the receptances at the seats.

    See `rbfound.theory.reduction.ritz`; the forces are those at the seats.

    Parameters
    ----------
    modes : natural modes kept
    blocks : terms of the series kept, each with one coordinate for every seat
    shift : [Hz], below 0 for a body that can move freely; see `natural_modes`
    """
    M, K = _free(solid, solid.M, solid.K)
    omega, Phi = ritz(M, K, solid.B[:, solid.free].T, modes, blocks, shift)
    return omega, _whole(solid, Phi)


def reduce(solid: Solid, modes: int = 16, blocks: int = 3, zeta: float = 0.02, notes: Sequence[str] = ()) -> Foundation:
    """The body in the coordinates of `ritz_modes`: M = I, K = diag(omega^2), C = diag(2 zeta omega), B = its seats.

    Parameters
    ----------
    modes, blocks : as in `ritz_modes`
    zeta : damping ratio of every coordinate [-]
    notes : sentences for the foundation to carry
    """
    omega, Phi = ritz_modes(solid, modes, blocks)
    return modal_foundation(solid.B @ Phi, omega, np.full(len(omega), zeta), solid.labels, tuple(notes))


def momentum(solid: Solid, Phi: ArrayLike) -> Array:
    """Momentum of the whole body along X and along Y for a unit velocity of each shape, (2, m) [sqrt(kg)].

    What `rbfound.theory.transmissibility.ground_forces` needs to know of a reduced solid.

    Parameters
    ----------
    Phi : (n, m), as `natural_modes` or `ritz_modes` give them
    """
    nodes = solid.mesh.doflocs.shape[1]
    along = np.kron(np.eye(3)[:2], np.ones(nodes))
    return np.asarray(along @ (solid.M @ np.asarray(Phi, dtype=float)))


def direct_receptance(
    solid: Solid, frequency: ArrayLike, damped: tuple[Array, Array], zeta: float | Array = 0.02
) -> FRF:
    """The receptances at the seats by solving the whole system on each line [Hz]: slow, and a check of `reduce`.

    Parameters
    ----------
    damped : omega (m,) [rad/s] and Phi (n, m), as `natural_modes` or `ritz_modes` give them
        The body is damped in these shapes and not beyond: C = sum of 2 zeta omega (M phi)(M phi)^T, a matrix of low
        rank that enters by Woodbury's formula. M and K remain those of the whole mesh.
    zeta : damping ratios of these shapes [-]
    """
    omega, Phi = damped
    M, K = _free(solid, solid.M, solid.K)
    BT, U = solid.B[:, solid.free].T, M @ Phi[solid.free]
    frequency = np.atleast_1d(np.asarray(frequency, dtype=float))
    H = np.empty((len(frequency), len(solid.B), len(solid.B)), dtype=complex)
    for line, w in enumerate(from_hertz(frequency)):
        undamped = factorised(K - w**2 * M)
        X, Y = undamped(BT), undamped(U)
        small = np.diag(1 / (2j * w * zeta * omega)) + U.T @ Y
        H[line] = BT.T @ X - (BT.T @ Y) @ np.linalg.solve(small, U.T @ X)
    return FRF(frequency, H, solid.labels)


def surface(solid: Solid) -> tuple[Array, Indices]:
    """The body's skin for drawing: all nodes' positions (nodes, 3) [m] and its faces (faces, 8).

    A face is the ring of its nodes, corner, midside, corner, ...; every second one, `faces[:, ::2]`, is a corner.
    A mode phi moves node k by `phi.reshape(3, -1).T[k]`.
    """
    mesh = solid.mesh
    skin = mesh.boundary_facets()
    corners, sides = mesh.facets[:, skin], mesh.nvertices + mesh.f2e[:, skin]
    return mesh.doflocs.T.copy(), np.stack([corners, sides], axis=1).reshape(8, -1).T


def _free(solid: Solid, *matrices: sparse.csc_array) -> list[sparse.csc_array]:
    every = len(solid.free) == solid.K.shape[0]
    return [A if every else A[:, solid.free][solid.free].tocsc() for A in matrices]


def _whole(solid: Solid, shapes: Array) -> Array:
    """Shapes of the free coordinates as those of the whole body, and their signs at the seats where it has any."""
    Phi = np.zeros((solid.K.shape[0], shapes.shape[1]))
    Phi[solid.free] = shapes
    return Phi * _sign(solid.B @ Phi if len(solid.B) else Phi)


def _sign(shapes: Array) -> Array:
    """1 or -1 for each column: the first entry of at least half the largest size shall be positive."""
    size = np.abs(shapes)
    first = (size >= size.max(axis=0) / 2).argmax(axis=0)
    return np.where(shapes[first, np.arange(shapes.shape[1])] < 0, -1.0, 1.0)
