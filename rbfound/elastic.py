"""An elastic body of 20-node bricks with its bearing seats. Needs the extra rbfound[solid] (scikit-fem)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from rbfound.assembly import FULL, REDUCED, bed_stiffness, mass, mean_motion, stiffness
from rbfound.mesh import Block, SerendipityMesh, join

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Places = Callable[[Array], NDArray[np.bool_]]
Under = tuple[Places, tuple[float, float, float]]


@dataclass(frozen=True, eq=False)
class Solid:
    """A meshed elastic body with its seats.

    Attributes
    ----------
    mesh : SerendipityMesh
        `mesh.doflocs` (3, nodes) holds the nodes' positions [m].
    M, K : (n, n) sparse [kg, N/m]
        n = 3 nodes: x of every node, then y, then z. Nothing is fixed in them.
    B : (seats, n)
        x = B u gives the displacements of the seats.
    labels : names of the seats
    free : indices of the coordinates that are not fixed
    """

    mesh: SerendipityMesh
    M: sparse.csc_array
    K: sparse.csc_array
    B: Array
    labels: tuple[str, ...]
    free: Indices

    @property
    def mass(self) -> float:
        """The whole body's mass [kg], from a rigid translation along x."""
        nodes = self.mesh.doflocs.shape[1]
        along = np.repeat([1.0, 0.0, 0.0], nodes)
        return float(along @ (self.M @ along))

    def __str__(self) -> str:
        return (
            f"Solid of {self.mesh.nelements} elements, {self.M.shape[0]} coordinates ({len(self.free)} free), "
            f"{self.mass:.4g} kg, seats {', '.join(self.labels) or 'none'}"
        )


def elastic_solid(
    blocks: Sequence[Block],
    fixed: Places | None = None,
    bores: Sequence[Places] = (),
    beds: Sequence[Under] = (),
    full: bool = False,
) -> Solid:
    """Mass and stiffness of a body of 20-node bricks, and the mean motion of its bores.

    Parameters
    ----------
    blocks : pieces that share the corners on their common faces
    fixed : function of nodes' positions (3, n) that says which of them are held in all three directions
    bores : such functions, one for each bearing: which nodes lie on its seat
        The seats x1, y1, x2, y2, ... are the area-weighted means of the displacement over these surfaces, so a
        force on a seat is spread evenly over the whole bore.
    beds : such functions, each with the stiffness per area along x, y and z [N/m^3] that ties its faces to the ground
    full : integrate the stiffness by 3 x 3 x 3 points in each brick instead of 2 x 2 x 2

    Notes
    -----
    With reduced integration a brick has six motions without strain that are not rigid. Neighbours on two sides stop
    them, a single file of bricks lets them pass: give a bar two elements across at least one side.
    """
    mesh, owner = join(blocks)
    materials = [block.material for block in blocks]
    first, second = np.array([material.lame for material in materials])[owner].T
    rho = np.array([material.rho for material in materials])[owner]
    held = np.zeros(mesh.doflocs.shape[1], bool) if fixed is None else fixed(mesh.doflocs)
    rows = [row for bore in bores for row in mean_motion(mesh, bore)]
    K = stiffness(mesh, first, second, FULL if full else REDUCED)
    return Solid(
        mesh,
        mass(mesh, rho),
        sparse.csc_array(sum((bed_stiffness(mesh, *bed) for bed in beds), start=K)),
        np.array(rows).reshape(-1, 3 * len(held)),
        tuple(f"{axis}{k + 1}" for k in range(len(bores)) for axis in "xy"),
        np.flatnonzero(np.tile(~held, 3)),
    )
