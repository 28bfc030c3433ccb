"""CalculiX as an independent check: a body of 20-node bricks as its input deck, and the frequencies that it answers.

CalculiX (https://www.calculix.de) is a finite-element program of its own; nothing but the nodes, the bricks, the
materials and what holds them goes to it. Needs the extra rbfound[solid].
"""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from rbfound.files import text_replaced
from rbfound.solid import Block, Places, join
from rbfound.solid.mesh import Material, SerendipityMesh
from rbfound.units import hertz

Array = NDArray[np.float64]

# Points of integration: 3 x 3 x 3 for both matrices, or 2 x 2 x 2 for both.
ELEMENTS = ("C3D20", "C3D20R")

# Where CalculiX's twenty nodes are in a brick from 0 to 1: the corners of the bottom and of the top, the middles of
# the bottom's edges, of the top's, and of those that stand (user's manual of CalculiX CrunchiX, "Twenty-node brick").
_BOTTOM = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
_CORNERS = np.vstack([np.column_stack([_BOTTOM, np.full(4, z)]) for z in (0, 1)])
_EDGES = (
    [(k, (k + 1) % 4) for k in range(4)] + [(4 + k, 4 + (k + 1) % 4) for k in range(4)] + [(k, 4 + k) for k in range(4)]
)
NODES = np.vstack([_CORNERS, [(_CORNERS[a] + _CORNERS[b]) / 2 for a, b in _EDGES]])

# CalculiX reads sixteen entries of a line and twenty characters of a number.
ENTRIES = 16

# What a sum in another order may leave between two entries that should be the same, relative to the largest.
SYMMETRIC = 1e-12


def write_deck(
    path: str | os.PathLike[str],
    blocks: Sequence[Block],
    fixed: Places | None = None,
    *,
    count: int = 20,
    element: str = "C3D20",
    springs: sparse.sparray | None = None,
) -> None:
    """Write the input deck that asks CalculiX for the lowest natural frequencies of a held body.

    The body is that of `rbfound.solid.elastic.elastic_solid(blocks, fixed)`, node for node: number k there is k + 1
    here.

    Parameters
    ----------
    path : of the deck, with the ending .inp
        `ccx -i name` reads name.inp and writes name.dat, which `read_frequencies` reads.
    blocks : pieces that share the corners on their common faces
    fixed : function of nodes' positions (3, n) that says which of them are held in all three directions
    count : how many frequencies
    element : "C3D20" integrates stiffness and mass by 3 x 3 x 3 points, "C3D20R" both by 2 x 2 x 2
    springs : (3 nodes, 3 nodes) symmetric [N/m], a stiffness beside that of the bricks, such as a bed's
        In the coordinates of a Solid: x of every node, then y, then z. Each pair of coordinates that it ties becomes
        one spring, and each coordinate with a row that does not sum to zero a spring to the ground.
    """
    path = Path(path)
    if path.suffix != ".inp":
        raise ValueError(f"The deck is called {path.name}: CalculiX reads files that end in .inp only.")
    if element not in ELEMENTS:
        raise ValueError(f"The element is {element!r}: it must be one of {', '.join(ELEMENTS)}.")
    mesh, owner = join(blocks)
    places = mesh.doflocs
    held = np.array([], dtype=int) if fixed is None else np.flatnonzero(fixed(places))
    if not len(held) and springs is None:
        raise ValueError("Nothing holds the body, and CalculiX works around 0 Hz: fix nodes, or give springs.")
    size = places.size
    if springs is not None and springs.shape != (size, size):
        raise ValueError(f"The springs are {springs.shape}: of {size // 3} nodes they must be {(size, size)}.")
    if springs is not None and abs(springs - springs.T).max() > SYMMETRIC * abs(springs).max():
        raise ValueError("The springs are not symmetric, and a spring pulls both its ends alike.")
    free = size - 3 * len(held)
    if not 1 <= count < free:
        raise ValueError(f"{count} frequencies of {free} free coordinates: ask for at least 1 and fewer than all.")
    bricks = _bricks(mesh, [block.material for block in blocks], owner, element)
    more = () if springs is None else _springs(springs, mesh.nelements)
    text_replaced(path, "\n".join(chain(bricks, more, _step(held, count))) + "\n")


def brick_nodes(mesh: SerendipityMesh) -> NDArray[np.intp]:
    """The nodes of every element in CalculiX's order, (20, elements): columns of `mesh.doflocs`.

    The order is found from the places of the nodes in the brick, not from a table of numbers.
    """
    theirs = [int(np.flatnonzero((mesh.elem.doflocs == place).all(axis=1))[0]) for place in NODES]
    nodes = np.asarray(mesh.dofs.element_dofs, dtype=np.intp)[theirs]
    # three edges out of the first corner: their triple product is the volume's sign
    first, *out = (mesh.doflocs[:, nodes[k]].T for k in (0, 1, 3, 4))
    sides = np.stack([end - first for end in out], axis=1)
    turned = np.flatnonzero(np.linalg.det(sides) <= 0)
    if len(turned):
        raise ValueError(
            f"{len(turned)} of {mesh.nelements} bricks are inside out, the first is number {turned[0]}: "
            "u, v and z of a block must be a right-handed system in this order."
        )
    return nodes


def read_frequencies(path: str | os.PathLike[str]) -> Array:
    """The natural frequencies [Hz] in a .dat file of a *FREQUENCY step, ascending.

    They come from the column of eigenvalues omega^2: it has seven digits as the others have, and its root is known
    twice as well, to 2.5e-7 at the worst.
    """
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    _, title, rest = text.partition("E I G E N V A L U E   O U T P U T")
    # the tables that follow (participation factors, effective masses) begin with a title of spaced capitals too
    table = re.split(r"^ *(?:[A-Z] ){3}", rest, maxsplit=1, flags=re.MULTILINE)[0]
    number = r"-?\d*\.\d+(?:E[+-]\d+)?"
    squares = re.findall(rf"^ *\d+ +({number})(?: +{number}){{3}} *$", table, re.MULTILINE)
    if not title or not squares:
        raise ValueError(
            f"{Path(path).name} has no table of eigenvalues: CalculiX writes one where a *FREQUENCY step ended well."
        )
    return np.sort(hertz(np.sqrt(np.maximum(np.array(squares, dtype=float), 0.0))))


def _bricks(
    mesh: SerendipityMesh, materials: Sequence[Material], owner: NDArray[np.intp], element: str
) -> Iterator[str]:
    """Nodes, elements and materials, line by line; elements of equal material make one set."""
    kinds = list(dict.fromkeys(materials))
    kind = np.array([kinds.index(material) for material in materials])[owner]
    nodes = brick_nodes(mesh) + 1
    yield "*NODE, NSET=ALL"
    for k, place in enumerate(mesh.doflocs.T, start=1):
        yield f"{k}, {', '.join(_number(x) for x in place)}"
    for k, material in enumerate(kinds, start=1):
        yield f"*ELEMENT, TYPE={element}, ELSET=PART{k}"
        for index in np.flatnonzero(kind == k - 1):
            yield from _lines(np.append(index + 1, nodes[:, index]))
        yield f"*MATERIAL, NAME=MATERIAL{k}"
        yield from ("*ELASTIC", f"{_number(material.E)}, {_number(material.nu)}", "*DENSITY", _number(material.rho))
        yield f"*SOLID SECTION, ELSET=PART{k}, MATERIAL=MATERIAL{k}"


def _springs(springs: sparse.sparray, bricks: int) -> Iterator[str]:
    """A symmetric stiffness as springs: -k_ij between the coordinates i and j, and the sum of row i to the ground."""
    nodes = springs.shape[0] // 3
    above = sparse.triu(springs, 1).tocoo()
    ground = np.asarray(springs.sum(axis=1)).ravel()
    ties: list[tuple[list[int], float]]
    ties = [([i, j], -k) for i, j, k in zip(above.row.tolist(), above.col.tolist(), above.data, strict=True)]
    ties += [([i], k) for i, k in enumerate(ground)]
    for number, (ends, stiffness) in enumerate((tie for tie in ties if tie[1]), start=1):
        yield f"*ELEMENT, TYPE=SPRING{len(ends)}, ELSET=SPRING{number}"
        yield ", ".join(str(word) for word in (bricks + number, *(end % nodes + 1 for end in ends)))
        yield f"*SPRING, ELSET=SPRING{number}"
        yield from (", ".join(str(end // nodes + 1) for end in ends), _number(stiffness))


def _step(held: NDArray[np.intp], count: int) -> Iterator[str]:
    if len(held):
        yield "*NSET, NSET=FIXED"
        yield from _lines(held + 1)
        yield from ("*BOUNDARY", "FIXED, 1, 3")
    yield from ("*STEP", "*FREQUENCY", str(count), "*END STEP")


def _number(x: float) -> str:
    """Fourteen significant digits in at most twenty characters; what rounding leaves of a zero [m] becomes one."""
    return f"{x if abs(x) > 1e-15 else 0.0:.13e}"


def _lines(entries: Iterable[int]) -> Iterator[str]:
    """A list of whole numbers over as many lines as it needs; a comma at the end says that another one follows."""
    words = [str(entry) for entry in entries]
    for start in range(0, len(words), ENTRIES):
        more = "," if start + ENTRIES < len(words) else ""
        yield ", ".join(words[start : start + ENTRIES]) + more
