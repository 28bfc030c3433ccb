"""An elastic body of 20-node bricks with its bearing seats. Needs the extra rbfound[solid] (scikit-fem)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, ElementHex0, ElementHexS2, FacetBasis, LinearForm
from skfem.helpers import dot

from rbfound.solid.mesh import Block, SerendipityMesh, join

Array = NDArray[np.float64]

Places = Callable[[Array], NDArray[np.bool_]]

Indices = NDArray[np.intp]

# Products of strains are integrated by 2 x 2 x 2 points (fewer than exact: the exact brick is too stiff in bending) or
# by 3 x 3 x 3, products of displacements by 3 x 3 x 3 (2 x 2 x 2 would leave some displacements without mass).
REDUCED, FULL = 3, 5


def stiffness(mesh: SerendipityMesh, first: Array, second: Array, order: int = REDUCED) -> sparse.csc_array:
    """K [N/m] from lambda and mu [Pa] of every element."""
    basis = Basis(mesh, ElementHexS2(), intorder=order)
    lame, mu = (basis.with_element(ElementHex0()).interpolate(values) for values in (first, second))

    def block(i: int, j: int) -> sparse.csr_array:
        @BilinearForm
        def work(u, v, w):  # type: ignore[no-untyped-def]
            across = w.lame * v.grad[i] * u.grad[j] + w.mu * v.grad[j] * u.grad[i]
            return across + w.mu * dot(v.grad, u.grad) if i == j else across

        return sparse.csr_array(work.assemble(basis, lame=lame, mu=mu))

    xx, yy, zz, xy, xz, yz = (block(*ij) for ij in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return sparse.csc_array(sparse.block_array([[xx, xy, xz], [xy.T, yy, yz], [xz.T, yz.T, zz]]))


def mass(mesh: SerendipityMesh, rho: Array) -> sparse.csc_array:
    """M [kg] from the density [kg/m^3] of every element."""
    basis = Basis(mesh, ElementHexS2(), intorder=FULL)

    @BilinearForm
    def inertia(u, v, w):  # type: ignore[no-untyped-def]
        return w.rho * u * v

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
