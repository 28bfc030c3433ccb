"""Mass, stiffness and surface sums of a mesh of 20-node bricks. Needs the extra rbfound[solid].

Coordinates: x of every node, then y, then z.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence

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
    # products[e, a, b]: the integral over element e of d N_a / d x_i times d N_b / d x_j
    products = [
        [np.einsum("aeq,beq->eab", u, v, optimize=True) for v in slopes.swapaxes(0, 1)] for u in weighted.swapaxes(0, 1)
    ]
    both = sum(products[k][k] for k in range(3))
    lame, mu = first[:, None, None], second[:, None, None]
    return _summed(
        basis,
        ({j: lame * products[i][j] + mu * (products[j][i] + (i == j) * both) for j in range(3)} for i in range(3)),
    )


def mass(mesh: SerendipityMesh, rho: Array) -> sparse.csc_array:
    """M [kg] from the density [kg/m^3] of every element."""
    basis = Basis(mesh, ElementHexS2(), intorder=FULL)
    heights = np.array([np.asarray(function[0])[0] for function in basis.basis])
    one = np.einsum("aq,bq,eq->eab", heights, heights, rho[:, None] * basis.dx, optimize=True)
    return _summed(basis, ({i: one} for i in range(3)))


def _summed(basis: Basis, lines: Iterable[Mapping[int, Array]]) -> sparse.csc_array:
    """The sums over all elements of symmetric 3 x 3 blocks (elements, 20, 20), which share one pattern.

    Parameters
    ----------
    lines : the blocks of one row after the other, by their column
    """
    nodes = basis.mesh.doflocs.shape[1]
    # scikit-fem's numbers have 32 bits, of which a pair of nodes needs more
    place = basis.element_dofs.T.astype(np.int64)
    pairs, where = np.unique(place[:, :, None] * nodes + place[:, None, :], return_inverse=True)
    row, column = np.divmod(pairs, nodes)
    start = np.searchsorted(row, np.arange(nodes + 1))
    data, indices, ends = [], [], [np.zeros(1, dtype=np.intp)]
    for line in lines:
        # written where it will stay: joining finished blocks takes five times the memory
        values, columns = np.empty(len(line) * len(pairs)), np.empty(len(line) * len(pairs), dtype=np.int32)
        at = np.arange(len(pairs)) + (len(line) - 1) * start[row]
        for k, block in sorted(line.items()):
            values[at] = np.bincount(where.ravel(), block.ravel(), len(pairs))
            columns[at] = column + k * nodes
            at += np.diff(start)[row]
        data.append(values)
        indices.append(columns)
        ends.append(ends[-1][-1] + len(line) * start[1:])
    size, whole = 3 * nodes, np.concatenate(ends).astype(np.int32)
    # symmetric: its columns are its rows
    return sparse.csc_array((np.concatenate(data), np.concatenate(indices), whole), shape=(size, size))


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
