"""Mass, stiffness and surface sums of a mesh of 20-node bricks. Needs the extra rbfound[solid].

Coordinates: x of every node, then y, then z.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, ElementHexS2, FacetBasis, LinearForm

from rbfound.mesh import SerendipityMesh

Array = NDArray[np.float64]
Places = Callable[[Array], NDArray[np.bool_]]

# Products of strains are integrated by 2 x 2 x 2 points (fewer than exact: the exact brick is too stiff in bending) or
# by 3 x 3 x 3, products of displacements by 3 x 3 x 3 (2 x 2 x 2 would leave some displacements without mass).
REDUCED, FULL = 3, 5


def stiffness(mesh: SerendipityMesh, first: Array, second: Array, order: int = REDUCED) -> sparse.csc_array:
    """K [N/m] from lambda and mu [Pa] of every element."""
    basis = Basis(mesh, ElementHexS2(), intorder=order)
    slopes = np.array([function[0].grad for function in basis.basis])
    weighted = slopes * basis.dx
    blocks = []
    # products[e, a, b]: the integral over element e of d N_a / d x_i times d N_b / d x_j
    products = [
        [np.einsum("aeq,beq->eab", u, v, optimize=True) for v in slopes.swapaxes(0, 1)] for u in weighted.swapaxes(0, 1)
    ]
    both = sum(products[k][k] for k in range(3))
    lame, mu = first[:, None, None], second[:, None, None]
    for i in range(3):
        blocks.append([lame * products[i][j] + mu * (products[j][i] + (i == j) * both) for j in range(3)])
    return _summed(basis, blocks)


def mass(mesh: SerendipityMesh, rho: Array) -> sparse.csc_array:
    """M [kg] from the density [kg/m^3] of every element."""
    basis = Basis(mesh, ElementHexS2(), intorder=FULL)
    heights = np.array([np.asarray(function[0])[0] for function in basis.basis])
    one = np.einsum("aq,bq,eq->eab", heights, heights, rho[:, None] * basis.dx, optimize=True)
    return _summed(basis, [[one if i == j else None for j in range(3)] for i in range(3)])


def _summed(basis: Basis, blocks: Sequence[Sequence[Array | None]]) -> sparse.csc_array:
    """The sums over all elements of 3 x 3 blocks (elements, 20, 20): one pattern, found once, serves all of them."""
    nodes = basis.mesh.doflocs.shape[1]
    place = basis.element_dofs.T
    pairs, where = np.unique(place[:, :, None] * nodes + place[:, None, :], return_inverse=True)
    row, column = np.divmod(pairs, nodes)
    start = np.searchsorted(row, np.arange(nodes + 1))

    def one(block: Array | None) -> sparse.csr_array:
        if block is None:
            return sparse.csr_array((nodes, nodes))
        data = np.bincount(where.ravel(), block.ravel(), len(pairs))
        return sparse.csr_array((data, column, start), shape=(nodes, nodes))

    return sparse.csc_array(sparse.block_array([[one(block) for block in line] for line in blocks]))


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
