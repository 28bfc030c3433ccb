"""The rotor's inverse problem: a shaft from the natural frequencies of models a, b and c, and what they leave open.

A *design* is a function that turns a few lengths in millimetres into a shaft and the positions of its two bearings;
the point mass sits on its right tip. The logarithms of the lengths are fitted to the logarithms of the printed
frequencies, so that an entry of the Jacobian is per cent of frequency per per cent of length.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg
from scipy.optimize import least_squares

from rbfound.machine import Machine, mount
from rbfound.rotor import Disk, Rotor, Shaft, assemble
from rbfound.system import System
from rbfound.thesis import beam_models
from rbfound.units import hertz

Array = NDArray[np.float64]
Design = Callable[[Array], tuple[Shaft, tuple[float, float]]]

# Of models a, b, c: printed frequencies, in the order of `frequencies`. Model a's 601 Hz is 601.7 in table 5.
TARGETS = np.array([*beam_models.printed("d")[3:], *beam_models.printed("b"), *beam_models.printed("c")])
NAMES = ("a1", "a2", "b1", "b2", "c1", "c2", "c3", "c4")

# The bearing of table 1.
BEARING = next(iter(beam_models.bearings().values()))

# A step of the logarithms for central differences: the error of eig is near 1e-11 of a frequency.
STEP = 1e-4


def two_segments(values: Array) -> tuple[Shaft, tuple[float, float]]:
    """Body and overhang: diameter, length of each, and bearing 2 so far beyond the body; bearing 1 at the end [mm]."""
    d1, l1, d2, l2, gap = np.asarray(values) / 1e3
    return Shaft([l1, l2], [d1, d2]), (0.0, l1 + gap)


def three_segments(values: Array) -> tuple[Shaft, tuple[float, float]]:
    """Stub, body, overhang: diameter of both thin ones, diameter and length of the body, length of the overhang, and
    both bearings so far outside the body, the stub being as long [mm]."""
    thin, d2, l2, l3, gap = np.asarray(values) / 1e3
    return Shaft([gap, l2, l3], [thin, d2, thin]), (0.0, l2 + 2 * gap)


def four_segments(values: Array) -> tuple[Shaft, tuple[float, float]]:
    """Journal, body, seat, overhang: four diameters, four lengths, both bearings' positions [mm], and E [GPa]."""
    d, l, (z1, z2) = np.asarray(values[:4]) / 1e3, np.asarray(values[4:8]) / 1e3, np.asarray(values[8:10]) / 1e3
    return Shaft(list(l), list(d), E=1e9 * float(values[10]), rho=7800.0), (float(z1), float(z2))


# The names of a design's parameters, in their order.
PARAMETERS: dict[Design, tuple[str, ...]] = {
    two_segments: ("D body", "L body", "D overhang", "L overhang", "gap 2"),
    three_segments: ("D thin", "D body", "L body", "L overhang", "gaps"),
    four_segments: (
        *(f"D{k}" for k in range(1, 5)),
        *(f"L{k}" for k in range(1, 5)),
        "z1",
        "z2",
        "E",
    ),
}


@dataclass(frozen=True, eq=False)
class ShaftFit:
    """A shaft that has the frequencies of models a, b and c, and how well these determine it.

    Attributes
    ----------
    design : which lengths there are
    values : (p,) [mm] (and GPa)
    frequency : (8,) [Hz] of models a, b, c: see NAMES
    jacobian : (8, p) change of ln frequency for a change of ln value
    """

    design: Design
    values: Array
    frequency: Array
    jacobian: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return PARAMETERS[self.design]

    @property
    def error(self) -> Array:
        """Computed against printed frequencies, (8,) [%]."""
        return np.asarray(100 * (self.frequency / TARGETS - 1))

    def directions(self) -> tuple[Array, Array]:
        """Singular values of the Jacobian, descending, (p,), and the directions in parameter space, (p, p).

        Row k of the directions holds parts of the parameters' logarithms. A step of 1 % along it changes the eight
        frequencies by so many per cent (root of the sum of squares) as singular value k says. Where there are more
        parameters than frequencies, zeros fill up the singular values.
        """
        _, sizes, rows = np.linalg.svd(self.jacobian)
        return np.concatenate([sizes, np.zeros(len(rows) - len(sizes))]), rows

    def moved(self, direction: ArrayLike, percent: float) -> Array:
        """The values after a step along a direction of their logarithms [%], (p,)."""
        return np.asarray(self.values * np.exp(percent / 100 * np.asarray(direction)))

    def machine(self, letter: str) -> Machine:
        """Model a to f of the thesis with this shaft in place of `rbfound.thesis.beam_models.rotor`."""
        return machine(self.design, self.values, letter)


def machine(design: Design, values: ArrayLike, letter: str) -> Machine:
    """One of the thesis's beam models a to f with a shaft of a design."""
    shaft, seats = design(np.asarray(values, dtype=float))
    mass = 0.0 if letter in "ad" else beam_models.POINT_MASS
    # disks without mass put the nodes where `frequencies` has them
    disks = {float(z): Disk(0.0) for z in _nodes(shaft)}
    disks[float(shaft.ends[-1])] = Disk(mass)
    tied = dict.fromkeys(seats, BEARING) if letter in "cf" else {}
    on = beam_models.foundation() if letter in "def" else None
    return mount(Rotor(shaft, disks, element=float(shaft.ends[-1])), tied, on)


def frequencies(design: Design, values: ArrayLike) -> Array:
    """The lowest natural frequencies of models a (2), b (2) and c (4) at rest, in one plane, (8,) [Hz]."""
    shaft, seats = design(np.asarray(values, dtype=float))
    mesh = assemble(Rotor(shaft, element=float(shaft.ends[-1])), [*_nodes(shaft), *seats])
    # x and psi of every node: at rest the two planes of a round shaft have nothing to do with each other
    plane = np.sort(np.concatenate([mesh.planes[0], mesh.planes[0] + 3]))
    M, K = (A[np.ix_(plane, plane)] for A in (mesh.M, mesh.K))
    bare = _elastic(M, K)
    M[-2, -2] += beam_models.POINT_MASS
    loaded = _elastic(M, K)
    C = np.zeros_like(K)
    for z in seats:
        k = 2 * mesh.node(z)
        K[k, k] += BEARING.kxx
        C[k, k] += BEARING.cxx
    return np.concatenate([bare, loaded, System(M, C, K).modes().above(1.0).frequency[:4]])


def _nodes(shaft: Shaft) -> Array:
    """Nodes of a mesh that a change of the lengths only stretches: 12 elements in the longest segment, 3 in others.

    Elements of a given length would change in number, and the frequencies with it in steps: no slope to follow.
    """
    longest = int(np.argmax(shaft.length))
    ends = shaft.ends
    return np.concatenate(
        [np.linspace(ends[k], ends[k + 1], 13 if k == longest else 4) for k in range(len(shaft.length))]
    )


def _elastic(M: Array, K: Array) -> Array:
    """The two lowest frequencies [Hz] of a free shaft in one plane, behind its two rigid motions."""
    squares = linalg.eigh(K, M, eigvals_only=True, subset_by_index=[2, 3])
    return np.asarray(hertz(np.sqrt(squares)))


def fit_shaft(design: Design, start: Sequence[float], pull: float = 0.0) -> ShaftFit:
    """Least-squares fit of a design's lengths to the printed frequencies of models a, b and c.

    Parameters
    ----------
    start : (p,) [mm]
    pull : how much a change of the lengths counts beside a change of the frequencies [-]
        Needed where there are more lengths than the eight frequencies determine: of all solutions one near the start.

    Raises
    ------
    ValueError
        When the start has not as many entries as the design has parameters, or one is not positive.
    """
    start_values = np.asarray(start, dtype=float)
    names = PARAMETERS[design]
    if start_values.shape != (len(names),):
        raise ValueError(f"start has shape {start_values.shape}: this design has the parameters {', '.join(names)}.")
    if not (start_values > 0).all():
        raise ValueError(f"start holds {start_values.min():g}: their logarithms are fitted, so all must be positive.")

    def residual(logs: Array) -> Array:
        apart = np.log(frequencies(design, start_values * np.exp(logs)) / TARGETS)
        return np.concatenate([apart, pull * logs])

    def slope(logs: Array) -> Array:
        return np.concatenate([sensitivity(design, start_values * np.exp(logs)), pull * np.eye(len(logs))])

    found = least_squares(residual, np.zeros(len(names)), slope, xtol=1e-9, ftol=1e-9)
    values = start_values * np.exp(found.x)
    return ShaftFit(design, values, frequencies(design, values), sensitivity(design, values))


def predicted(design: Design, values: ArrayLike) -> Array:
    """The frequencies of model f that the thesis prints, at rest, (7,) [Hz]: all above 60 Hz, of the pair one."""
    return machine(design, values, "f").at(0.0).modes().above(60.0).frequency[:7]


def sensitivity(design: Design, values: ArrayLike, of: Callable[[Design, ArrayLike], Array] = frequencies) -> Array:
    """Change of ln frequency for a change of ln value, by central differences, (frequencies, p).

    Parameters
    ----------
    of : `frequencies` of models a to c, or those `predicted` of f
    """
    values = np.asarray(values, dtype=float)
    columns = []
    for k in range(len(values)):
        step = np.zeros(len(values))
        step[k] = STEP
        up, down = (np.log(of(design, values * np.exp(s * step))) for s in (1, -1))
        columns.append((up - down) / (2 * STEP))
    return np.array(columns).T
