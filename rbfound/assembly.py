"""Mass, stiffness and surface sums of a mesh of 20-node bricks. Needs the extra rbfound[solid].

Coordinates: x of every node, then y, then z.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, ElementHex0, ElementHexS2, FacetBasis, LinearForm
from skfem.helpers import dot, grad

from rbfound.mesh import SerendipityMesh

Array = NDArray[np.float64]
Places = Callable[[Array], NDArray[np.bool_]]

# Products of strains are integrated by 2 x 2 x 2 points (fewer than exact: the exact brick is too stiff in bending) or
# by 3 x 3 x 3, products of displacements by 3 x 3 x 3 (2 x 2 x 2 would leave some displacements without mass).
REDUCED, FULL = 3, 5


def stiffness(mesh: SerendipityMesh, first: Array, second: Array, order: int = REDUCED) -> sparse.csc_array:
    """K [N/m] from lambda and mu [Pa] of every element: its nine blocks xx, xy, ..., of which three are transposes."""
    basis = Basis(mesh, ElementHexS2(), intorder=order)
    cell = basis.with_element(ElementHex0())
    given = {"lame": cell.interpolate(first), "mu": cell.interpolate(second)}
    rows: list[list[sparse.csr_array]] = []
    for i in range(3):
        row = []
        for j in range(i + 1):

            @BilinearForm
            def work(u, v, w, i=i, j=j):  # type: ignore[no-untyped-def]
                shear = w["mu"] * (v.grad[j] * u.grad[i] + (i == j) * dot(grad(v), grad(u)))
                return w["lame"] * v.grad[i] * u.grad[j] + shear

            row.append(sparse.csr_array(work.assemble(basis, **given)))
        rows.append(row)
    full = [[rows[i][j] if j <= i else rows[j][i].T for j in range(3)] for i in range(3)]
    return sparse.csc_array(sparse.block_array(full))


def mass(mesh: SerendipityMesh, rho: Array) -> sparse.csc_array:
    """M [kg] from the density [kg/m^3] of every element."""
    basis = Basis(mesh, ElementHexS2(), intorder=FULL)

    @BilinearForm
    def inertia(u, v, w):  # type: ignore[no-untyped-def]
        return w["rho"] * u * v

    one = sparse.csr_array(inertia.assemble(basis, rho=basis.with_element(ElementHex0()).interpolate(rho)))
    return sparse.csc_array(sparse.block_diag([one] * 3))


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
