"""Whether a machine is a chain of nodes: a round shaft, tied to other things at a few of them."""

import numpy as np
from numpy.typing import NDArray

from rbfound.nodechain import SIGN, Chain, U, V

Array = NDArray[np.float64]

# More ties than this part of all coordinates, and a dense matrix is the better road.
MOST_TIES = 0.25


def chain_of(M: Array, C: Array, K: Array, G: Array, shaft: tuple[Array, Array, Array]) -> Chain | None:
    """The chain of a machine, or None if it is none: a shaft that is not round, or ties nearly everywhere.

    Parameters
    ----------
    M, C, K, G : (n, n)
        The machine; four coordinates a node first, in the order x, y, theta, psi, G for a spin of 1 rad/s.
    shaft : M, K and G of the shaft alone and free, (4 nodes, 4 nodes)
    """
    size = len(shaft[0])
    parts = [_round_parts(A, turning) for A, turning in zip(shaft, (False, False, True), strict=True)]
    whole, alone = (M, C, K, G), (shaft[0], None, shaft[1], shaft[2])
    # copies of whole matrices would cost more than all that follows
    held = np.flatnonzero(np.any([_touched(A, own, size) for A, own in zip(whole, alone, strict=True)], axis=0))
    slope = np.isin(held % 4, (2, 3)).astype(int)
    points = np.unique(np.stack([held // 4, slope], axis=1), axis=0)
    rest = np.arange(size, len(M))
    if any(part is None for part in parts) or 2 * len(points) + len(rest) > MOST_TIES * len(M):
        return None
    node, slope = points.T
    order = np.concatenate([4 * node + U[slope], 4 * node + V[slope], rest])
    sign = np.concatenate([np.ones(len(node)), SIGN[slope], np.ones(len(rest))])
    ties, own = (
        np.array([A[np.ix_(some, some)] for A in part])
        for some, part in ((order, whole), (order[: 2 * len(node)], shaft))
    )
    ties[[0, 2, 3], : 2 * len(node), : 2 * len(node)] -= own
    ties *= np.outer(sign, sign)
    inner, outer = (np.array([part[k] for part in parts if part is not None])[[0, 2, 1]] for k in range(2))
    return Chain(inner, outer, node, slope, ties)


def _touched(A: Array, own: Array | None, size: int) -> NDArray[np.bool_]:
    """Which of the shaft's coordinates are in more than the shaft's own matrix: (size,)."""
    more = A[:size, :size] != (0.0 if own is None else own)
    behind = (A[:size, size:] != 0).any(axis=1) | (A[size:, :size] != 0).any(axis=0)
    return np.asarray(more.any(axis=0) | more.any(axis=1) | behind)


def _round_parts(A: Array, turning: bool) -> tuple[Array, Array] | None:
    """Entries of one plane's blocks, (nodes, 3) and (nodes - 1, 4); None unless A is a chain without directions."""
    nodes = len(A) // 4
    blocks, k = A.reshape(nodes, 4, nodes, 4), np.arange(nodes)
    order, sign = np.concatenate([U, V]), np.concatenate([[1.0, 1.0], SIGN])
    own, next_ = (blocks[a, :, b][:, order][:, :, order] * np.outer(sign, sign) for a, b in ((k, k), (k[:-1], k[1:])))
    back = (blocks[k[1:], :, k[:-1]][:, order][:, :, order] * np.outer(sign, sign)).transpose(0, 2, 1)
    same, across = (slice(0, 2), slice(0, 2)), (slice(0, 2), slice(2, 4))
    taken, other = (across, same) if turning else (same, across)
    least = 1e-12 * np.abs(A).max(initial=0.0)

    def near(a: Array, b: Array | float) -> bool:
        return bool(np.abs(a - b).max(initial=0.0) <= least)

    flipped = (slice(2, 4), slice(0, 2)) if turning else (slice(2, 4), slice(2, 4))
    fine = all(
        near(B[:, *flipped], (-1 if turning else 1) * B[:, *taken]) and near(B[:, *other], 0.0) for B in (own, next_)
    )
    fine &= near(own[:, *taken], own[:, *taken].transpose(0, 2, 1)) and near(back, -next_ if turning else next_)
    inside = sum(np.count_nonzero(B) for B in (own, next_, back))
    if not fine or inside != np.count_nonzero(A):
        return None
    a, b = own[:, *taken], next_[:, *taken]
    return np.stack([a[:, 0, 0], a[:, 0, 1], a[:, 1, 1]], axis=1), b.reshape(-1, 4)
