"""Solids of revolution that bend: the rotor as a three-dimensional body, on a mesh of half its section.

Bending in one plane varies around the axis as the first circumferential harmonic: with the angle a from that plane

    u_r = (S + D) cos a,    u_a = -(S - D) sin a,    u_z = W cos a

so that S, D, W over (z, r) are the whole body, exactly. S is the mean displacement of a circle in the plane; on the
axis D = W = 0. Both planes of a round rotor have the same matrices. Needs the extra rbfound[solid].
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, Element, ElementLineP2, ElementQuadS2, FacetBasis, LinearForm, MeshQuad1

from rbfound.rotor import Rotor, Shaft, with_cones
from rbfound.solid.elastic import Solid
from rbfound.solid.modes import natural_modes
from rbfound.units import hertz

Array = NDArray[np.float64]

# Three by three points: exact for the displacements of a rectangle, and no element is left without stiffness.
ORDER = 5


@dataclass(repr=False)
class SectionMesh(MeshQuad1):
    """Quadrilaterals with midside nodes, in the coordinates z and r."""

    elem: type[Element] = ElementQuadS2

    @property
    def bndelem(self) -> ElementLineP2:
        return ElementLineP2()


def solid_rotor(rotor: Rotor, seats: Sequence[float], size: float = 0.01) -> Solid:
    """A rotor as a solid of revolution that bends in one plane, free in space.

    Parameters
    ----------
    rotor : Rotor
        Its disks count as masses, spread over the section at which they stand.
    seats : positions along the shaft [m]
        B has a row for each: the mean displacement over the section there.
    size : float
        Longest edge of an element [m].

    Returns
    -------
    Solid
        With the coordinates S of all nodes first, then D, then W. For both planes together take it twice.
    """
    shaft = rotor.shaft
    for z in seats:
        rotor.check_position(z, "seat")
    mesh = section_mesh(shaft, [*seats, *rotor.disks], size)
    M, K = _matrices(mesh, shaft)
    for z, disk in rotor.disks.items():
        if disk.Id or disk.Ip:
            raise ValueError(f"The disk at {z:g} m has moments of inertia: draw it as a segment of the shaft.")
        row = sparse.csc_array(_mean(mesh, shaft, z)[None, :])
        M = M + disk.mass * (row.T @ row)
    B = np.array([_mean(mesh, shaft, z) for z in seats]).reshape(len(seats), M.shape[0])
    nodes = mesh.doflocs.shape[1]
    axis = np.flatnonzero(mesh.doflocs[1] < 1e-12)
    free = np.setdiff1d(np.arange(3 * nodes), np.concatenate([nodes + axis, 2 * nodes + axis]))
    return Solid(mesh, sparse.csc_array(M), K, B, tuple(f"{z:g} m" for z in seats), free)


def gyroscopic(rotor: Solid, shaft: Shaft) -> sparse.csc_array:
    """G (n, n) for a spin of 1 rad/s: Omega G drives one plane by the rates of the other, -Omega G the other way.

    From the change of the velocity around the circumference, 2 rho Omega du/da, as the body turns past a fixed
    observer. Only the tilt W and the ovalling D of a section feel it. The terms with Omega^2, centrifugal stiffening
    against softening, are left out, as beam theory does.
    """
    one = _inertia(rotor.mesh, shaft)
    return sparse.csc_array(sparse.block_diag([0 * one, 8 * one, 2 * one]))


def cone_angle(thin: float, thick: float, size: float = 0.0025) -> float:
    """The cone angle [degrees] with which a beam bends as the solid does at one step between two diameters [m].

    Found on a body of its own: two cylinders, each three thick diameters long, free in space. The angle is the one
    for which the first bending frequency of the beam, `rbfound.rotor.with_cones`, is that of the solid; the length of
    the cylinders hardly matters, the ratio of the diameters does.

    Parameters
    ----------
    size : longest edge of the solid's elements [m]
    """
    if not 0 < thin < thick:
        raise ValueError(f"thin = {thin:g} m, thick = {thick:g} m: a step needs 0 < thin < thick.")
    shaft = Shaft([3 * thick, 3 * thick], [thin, thick])
    solid = float(hertz(natural_modes(solid_rotor(Rotor(shaft), [], size), 3, shift=-100.0)[0][2]))
    low, high = 5.0, 85.0
    while high - low > 0.01:
        angle = (low + high) / 2
        beam = Rotor(with_cones(shaft, angle, slices=12), element=thick / 4).at(0.0).modes().above(1.0).frequency[0]
        low, high = (angle, high) if beam < solid else (low, angle)
    return (low + high) / 2


def section_mesh(shaft: Shaft, stations: ArrayLike, size: float) -> SectionMesh:
    """Rectangles over half the section of a shaft, with lines at the stations [m] and edges no longer than `size`."""
    if np.any(np.asarray(shaft.inner) > 0):
        raise ValueError("The shaft is hollow: only full shafts are meshed as solids.")
    z = _fill(np.concatenate([shaft.ends, np.ravel(stations)]), size)
    r = _fill(np.concatenate([[0.0], np.asarray(shaft.diameter) / 2]), size)
    grid = MeshQuad1.init_tensor(z, r)
    z_middle, r_middle = grid.p[:, grid.t].mean(axis=1)
    outside = np.asarray(shaft.diameter)[_segment(shaft, z_middle)] / 2
    body = grid.restrict(np.flatnonzero(r_middle < outside))
    return SectionMesh.from_mesh(body)


def _fill(stations: Array, size: float) -> Array:
    """Grid lines through all stations, no further apart than `size`; stations closer than 1e-9 m are one."""
    sorted_ = np.sort(stations)
    kept = sorted_[np.concatenate([[True], np.diff(sorted_) > 1e-9])]
    pieces = [np.linspace(a, b, int(np.ceil((b - a) / size - 1e-9)) + 1)[:-1] for a, b in pairwise(kept)]
    return np.concatenate([*pieces, kept[-1:]])


def _segment(shaft: Shaft, z: ArrayLike) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(shaft.ends, z) - 1, 0, len(shaft.diameter) - 1)


def _matrices(mesh: SectionMesh, shaft: Shaft) -> tuple[sparse.csc_array, sparse.csc_array]:
    """M and K of the first harmonic. The integral over the circumference is pi for every product."""
    basis = Basis(mesh, ElementQuadS2(), intorder=ORDER)
    shear = shaft.E / (2 * (1 + shaft.nu))
    lame = 2 * shear * shaft.nu / (1 - 2 * shaft.nu)
    stiffness = np.diag([2 * shear] * 3 + [shear] * 3)
    stiffness[:3, :3] += lame

    def strains(u, r, component):  # type: ignore[no-untyped-def]
        """rr, aa, zz, rz, ra, za of a displacement in S, D or W alone; the common cos a or sin a is left out."""
        dz, dr, none = u.grad[0], u.grad[1], 0 * r
        if component == 0:
            return dr, none, none, dz, -dr, -dz
        if component == 1:
            return dr, 2 * u / r, none, dz, dr - 2 * u / r, dz
        return none, none, dz, dr, none, -u / r

    rows = []
    for i in range(3):
        row = []
        for j in range(3):

            @BilinearForm
            def work(u, v, w, i=i, j=j):  # type: ignore[no-untyped-def]
                r = w.x[1]
                first, second = strains(u, r, j), strains(v, r, i)
                energy = sum(
                    stiffness[a, b] * second[a] * first[b] for a in range(6) for b in range(6) if stiffness[a, b]
                )
                return np.pi * r * energy

            row.append(work.assemble(basis))
        rows.append(row)

    one = _inertia(mesh, shaft)
    # u_r^2 + u_a^2 gives (S + D)^2 + (S - D)^2 = 2 S^2 + 2 D^2
    return sparse.csc_array(sparse.block_diag([2 * one, 2 * one, one])), sparse.csc_array(sparse.block_array(rows))


def _inertia(mesh: SectionMesh, shaft: Shaft) -> sparse.csc_array:
    """pi rho r u v over the section: the mass of one displacement that goes with cos a or sin a."""

    @BilinearForm
    def inertia(u, v, w):  # type: ignore[no-untyped-def]
        return np.pi * shaft.rho * w.x[1] * u * v

    return sparse.csc_array(inertia.assemble(Basis(mesh, ElementQuadS2(), intorder=ORDER)))


def _mean(mesh: SectionMesh, shaft: Shaft, z: float) -> Array:
    """Row that takes the mean displacement over the section at z, up to the smaller of the radii that meet there."""
    beside = _segment(shaft, np.array([z - 1e-6, z + 1e-6]))
    radius = np.asarray(shaft.diameter)[beside].min() / 2
    middle = mesh.p[:, mesh.facets].mean(axis=1)
    on = np.flatnonzero((np.ptp(mesh.p[0, mesh.facets], axis=0) < 1e-9) & (np.abs(middle[0] - z) < 1e-9))
    facets = on[middle[1, on] < radius]

    @LinearForm
    def moment(v, w):  # type: ignore[no-untyped-def]
        return w.x[1] * v

    share = moment.assemble(FacetBasis(mesh, ElementQuadS2(), facets=facets, intorder=ORDER))
    none = np.zeros_like(share)
    return np.concatenate([share / share.sum(), none, none])
