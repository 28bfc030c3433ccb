"""An order of a mesh's nodes in which the factor of its matrix stays sparse."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# A part of a mesh of so many nodes is not cut again.
SMALL = 700
# Where a part may be cut: so many of its nodes lie before the cut, relative.
BEFORE = np.linspace(0.3, 0.7, 9)
# Nodes as near to a cut as this are on it [m].
BESIDE = 1e-8


def dissected(graph: sparse.csr_array, places: Array) -> Indices:
    """Nodes at places (3, n) in the order of nested dissection: one half, the other half, what joins them.

    A part is cut across x, y or z, about in its middle, where few nodes join two halves that are nearly alike, and the
    halves are cut again; what is small enough has minimum degree. (George 1973, DOI 10.1137/0710032.)

    Parameters
    ----------
    graph : (n, n) sparse, an entry wherever two nodes are tied, of the same pattern as its transpose
    places : (3, n) [m]
    """
    cuts = []
    for along in places if graph.shape[0] > SMALL else []:
        for level in np.unique(np.quantile(along, BEFORE, method="nearest")):
            first = along < level - BESIDE
            seam = ~first & (graph @ first.astype(float) > 0)
            second = ~first & ~seam
            sizes = first.sum(), second.sum(), seam.sum()
            if min(sizes[:2]) > sizes[2]:
                cuts.append((sizes[2] / (sizes[0] * sizes[1]), first, second, seam))
    if not cuts:
        return _minimum_degree(graph)
    _, first, second, seam = min(cuts, key=lambda cut: cut[0])
    halves = (np.flatnonzero(half) for half in (first, second))
    inside = [half[dissected(graph[half][:, half], places[:, half])] for half in halves]
    return np.concatenate([*inside, np.flatnonzero(seam)])


def _minimum_degree(graph: sparse.csr_array) -> Indices:
    """Of the nodes of a graph, the order in which SuperLU would eliminate them."""
    if graph.shape[0] == 0:
        return np.array([], dtype=np.intp)
    n = graph.shape[0]
    # any matrix of this pattern that needs no pivots
    dominant = sparse.csc_array((np.full(graph.nnz, -1.0), graph.indices, graph.indptr), shape=(n, n))
    dominant = sparse.csc_array(dominant + sparse.diags_array(np.full(n, 2.0 * n)))
    factor = splu(dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.argsort(factor.perm_c)
