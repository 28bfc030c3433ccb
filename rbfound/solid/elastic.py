"""An elastic body of 20-node bricks with its bearing seats. Needs the extra rbfound[solid] (scikit-fem)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, ElementHexS2, FacetBasis, LinearForm
from skfem.quadrature import get_quadrature

from rbfound.solid.mesh import Block, SerendipityMesh, join

Array = NDArray[np.float64]

Places = Callable[[Array], NDArray[np.bool_]]

Indices = NDArray[np.intp]

# Products of strains are integrated by 2 x 2 x 2 points (fewer than exact: the exact brick is too stiff in bending) or
# by 3 x 3 x 3, products of displacements by 3 x 3 x 3 (2 x 2 x 2 would leave some displacements without mass).
REDUCED, FULL = 3, 5


def stiffness(mesh: SerendipityMesh, first: Array, second: Array, order: int = REDUCED) -> sparse.csc_array:
    """K [N/m] from lambda and mu [Pa] of every element."""
    slopes, weighted = _slopes(mesh, order)
    lame, mu = first[:, None, None], second[:, None, None]

    def product(i: int, j: int) -> Array:
        """The integral over each element of d N_a / d x_i times d N_b / d x_j: (elements, a, b)."""
        return np.asarray(np.einsum("aeq,beq->eab", weighted[i], slopes[j], optimize=True))

    both = product(0, 0) + product(1, 1) + product(2, 2)

    def block(i: int, j: int) -> Array:
        # a product is made when it is wanted, some of them twice: all nine would take more room than K
        one = product(i, j)
        return lame * one + mu * (one.swapaxes(1, 2) + (i == j) * both)

    return _summed(mesh, [range(3)] * 3, block)


def mass(mesh: SerendipityMesh, rho: Array) -> sparse.csc_array:
    """M [kg] from the density [kg/m^3] of every element."""
    element = ElementHexS2()
    # no Basis: the slopes in it, which nobody needs here, would be the largest thing there is until then
    points, weights = get_quadrature(element.refdom, FULL)
    heights = np.array([element.lbasis(points, a)[0] for a in range(len(element.doflocs))])
    dx = np.abs(mesh.mapping().detDF(points)) * weights
    one = np.einsum("aq,bq,eq->eab", heights, heights, rho[:, None] * dx, optimize=True)
    return _summed(mesh, [[i] for i in range(3)], lambda i, j: one)


def _slopes(mesh: SerendipityMesh, order: int) -> tuple[Array, Array]:
    """d N_a / d x_i at the points of each element, (3, a, elements, points), plain and times the volume of a point."""
    basis = Basis(mesh, ElementHexS2(), intorder=order)
    slopes = np.array([function[0].grad for function in basis.basis]).swapaxes(0, 1)
    return slopes, slopes * basis.dx


def _summed(
    mesh: SerendipityMesh, pattern: Sequence[Sequence[int]], block: Callable[[int, int], Array]
) -> sparse.csc_array:
    """The sums over all elements of a symmetric matrix of 3 x 3 blocks, which share one pattern of nodes.

    Parameters
    ----------
    pattern : the columns of the blocks that are not zero, ascending, for each row of blocks
    block : function of a row and a column of blocks that returns this one, (elements, 20, 20)
    """
    nodes = mesh.doflocs.shape[1]
    # scikit-fem's numbers have 32 bits, of which a pair of nodes needs more
    place = mesh.dofs.element_dofs.T.astype(np.int64)
    pairs, where = np.unique(place[:, :, None] * nodes + place[:, None, :], return_inverse=True)
    row, column = np.divmod(pairs, nodes)
    start = np.searchsorted(row, np.arange(nodes + 1))
    length = sum(map(len, pattern)) * len(pairs)
    # written where it will stay: joining finished blocks takes five times the memory
    values, columns, ends = np.empty(length), np.empty(length, dtype=np.int32), [np.zeros(1, dtype=np.intp)]
    for i, line in enumerate(pattern):
        at = ends[-1][-1] + np.arange(len(pairs)) + (len(line) - 1) * start[row]
        for j in line:
            values[at] = np.bincount(where.ravel(), block(i, j).ravel(), len(pairs))
            columns[at] = column + j * nodes
            at += np.diff(start)[row]
        ends.append(ends[-1][-1] + len(line) * start[1:])
    whole = np.concatenate(ends).astype(np.int32)
    # symmetric: its columns are its rows
    return sparse.csc_array((values, columns, whole), shape=(3 * nodes, 3 * nodes))


def bed_stiffness(mesh: SerendipityMesh, where: Places, per_area: Sequence[float]) -> sparse.csc_array:
    """What an elastic bed under a part of the surface adds to K [N/m]: consistent, spread as the displacement is.

    Parameters
    ----------
    where : function of places (3, n) that says which of them stand on the bed
    per_area : stiffness per area along x, y and z [N/m^3]
    """

    @BilinearForm
    def product(u, v, _):  # type: ignore[no-untyped-def]
        return u * v

    one = sparse.csr_array(product.assemble(_faces(mesh, where, "bed")))
    return sparse.csc_array(sparse.block_diag([k * one for k in per_area]))


def mean_motion(mesh: SerendipityMesh, where: Places) -> list[Array]:
    """Rows (3 nodes,) that average the displacement along x and along y over a part of the surface."""

    @LinearForm
    def value(v, _):  # type: ignore[no-untyped-def]
        return v

    share = value.assemble(_faces(mesh, where, "bore"))
    share = share / share.sum()
    none = np.zeros_like(share)
    return [np.concatenate([share, none, none]), np.concatenate([none, share, none])]


def _faces(mesh: SerendipityMesh, where: Places, name: str) -> FacetBasis:
    on = where(mesh.p[:, : mesh.nvertices])
    skin = mesh.boundary_facets()
    facets = skin[on[mesh.facets[:, skin]].all(axis=0)]
    if not len(facets):
        raise ValueError(f"A {name} has no face on the surface of the mesh: all four corners of one must lie on it.")
    return FacetBasis(mesh, ElementHexS2(), facets=facets, intorder=FULL)


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
