"""A few modes of a large body, from a factor of its stiffness."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from rbfound.theory import orthonormal

Array = NDArray[np.float64]

# Columns of a block, and how far a mode may lead out of the space in the end, relative: its shape is then known to
# about this part, its frequency to the square of it.
BLOCK, CONVERGED = 4, 1e-9
# Vectors that there is room for at first, in parts of what is asked for and a block: most bodies need six or so.
ROOM = 8


def nearest_modes(
    M: sparse.csc_array, solve: Callable[[Array], Array], count: int, square: float = 0.0
) -> tuple[Array, Array]:
    """The undamped modes whose omega^2 are nearest to a square: omega^2 [rad^2/s^2] (count,), Phi (n, count).

    omega^2 ascends. Block Lanczos iteration on (K - square M)^-1 M, orthogonalised in full, from a fixed start, so
    that the result is the same each time. A factor answers a block of forces in half the time that it takes to answer
    them one by one. (Grimes, Lewis and Simon 1994, DOI 10.1137/S0895479888151111.)

    Parameters
    ----------
    M : (n, n) sparse, positive definite
    solve : function of forces (n, p) that returns (K - square M)^-1 times them

    Raises
    ------
    ValueError
        When there are not so many modes.
    """
    n = M.shape[0]
    if not 1 <= count < n:
        raise ValueError(f"count is {count}: of {n} free coordinates it must be from 1 to {n - 1}.")
    # what of the room is never written takes no memory, and a basis that grows in place is held once
    room, projected = np.empty((n, ROOM * (count + BLOCK)), order="F"), np.zeros((0, 0))
    basis = room[:, :0]
    start = np.sin(np.outer(np.arange(1.0, n + 1), np.arange(1.0, BLOCK + 1)))
    block = orthonormal(solve(M @ start), M, basis)
    while True:
        before, after = basis.shape[1], basis.shape[1] + block.shape[1]
        if after > room.shape[1]:
            room = np.hstack([room, np.empty_like(room)])
        room[:, before:after] = block
        basis = room[:, :after]
        answer = solve(M @ block)
        moved = M @ answer
        inside = basis.T @ moved
        projected = np.block([[projected, inside[:before]], [inside[:before].T, inside[before:]]])
        values, Q = np.linalg.eigh((projected + projected.T) / 2)
        wanted = np.argsort(-np.abs(values))[:count]
        following = orthonormal(answer, M, basis) if basis.shape[1] < n else basis[:, :0]
        # what leads out of the space so far, of each mode: its length in the mass's norm, relative
        outside = (following.T @ moved) @ Q[before:, wanted]
        done = len(wanted) == count and np.linalg.norm(outside, axis=0) <= CONVERGED * np.abs(values[wanted])
        if np.all(done) or not following.shape[1]:
            break
        block = following
    squares = square + 1 / values[wanted]
    order = np.argsort(squares)
    return squares[order], basis @ Q[:, wanted[order]]
