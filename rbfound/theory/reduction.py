"""Fewer coordinates: a basis T with u = T q, and the matrices T'MT, T'CT, T'KT that belong to it.

Each way to get a basis is a function of M, C, K (arrays or sparse), of the interface and of what it keeps. The
interface is where forces act and neighbours are tied: indices of coordinates, or rows B with x = B u, as the seats of
a solid are. `rb.Foundation(r.M, r.C, r.K, r.B)` puts a reduction r under a rotor. (equations 15-18)
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from rbfound.system import System
from rbfound.units import hertz, radians

Array = NDArray[np.float64]
Solve = Callable[[Array], Array]

# Static shapes of which the modes leave less than this share have nothing to add: the rest is rounding.
NOTHING = 1e-7

# A direction of which others leave less than this share is theirs already.
DEPENDENT = 1e-6

# A factor whose answer to forces of size one leaves so much of them unbalanced is that of a singular matrix.
LOST = 1e-4

# An interface that is stiffer than the body by more than one over this cannot be moved.
STIFFEST = 1e-9

FREE = "The stiffness is singular: a part of the body can move freely. Hold it, or name an interface that does."


@dataclass(frozen=True, eq=False)
class Reduction:
    """A reduced model, u = T q.

    Attributes
    ----------
    T : (n, r)
        Static shapes first, one for each entry of the interface, if the method has them; then modes, ascending.
    M, C, K : (r, r) [kg, N s/m, N/m in the units of q]
    B : (interface, r)
        x = B q gives the displacements of the interface.
    """

    T: Array
    M: Array
    C: Array
    K: Array
    B: Array

    def first(self, count: int) -> "Reduction":
        """The same with the first coordinates only: fewer modes at no further cost."""
        if not len(self.B) <= count <= len(self.M):
            raise ValueError(f"count = {count}: it must be from {len(self.B)}, the interface, to {len(self.M)}.")
        small = slice(0, count)
        M, C, K = (A[small, small] for A in (self.M, self.C, self.K))
        return Reduction(self.T[:, small], M, C, K, self.B[:, small])

    def damped(self, zeta: float) -> "Reduction":
        """The same with one damping ratio [-] for all of its own undamped modes."""
        squares, Q = linalg.eigh(self.K, self.M)
        MQ = self.M @ Q
        return replace(self, C=(MQ * (2 * zeta * np.sqrt(np.maximum(squares, 0)))) @ MQ.T)

    @property
    def frequency(self) -> Array:
        """Undamped natural frequencies [Hz], (r,), ascending."""
        squares = linalg.eigh(self.K, self.M, eigvals_only=True)
        return np.asarray(hertz(np.sqrt(np.maximum(squares, 0))))

    def receptance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Receptances at the interface on the given lines [Hz], (f, s, s)."""
        return System(self.M, self.C, self.K).receptance(frequency, self.B, self.B.T)


def guyan(M: Any, C: Any, K: Any, interface: ArrayLike) -> Reduction:
    """Static condensation on the interface: what else there is follows without inertia (equations 15-16).

    Exact at 0 Hz. The condensed dynamic stiffness is right up to omega^2. (Guyan 1965.)

    Parameters
    ----------
    M, C, K : (n, n), arrays or sparse; C = None is no damping
    interface : (s,) indices of the master coordinates, or (s, n) rows B of x = B u
    """
    B = _rows(interface, M, K)
    return _reduced(_static_shapes(K, B), M, C, K, B)


def dynamic_reduction(M: Any, C: Any, K: Any, interface: ArrayLike, frequency: float) -> Reduction:
    """Condensation with the inertia of one frequency [Hz] (equations 17-18).

    The thesis prints 17 without its stiffness part. Exact at that frequency for an undamped body; at 0 Hz it is
    `guyan`, whose parameters it has.
    """
    B = _rows(interface, M, K)
    return _reduced(_static_shapes(K - float(radians(frequency)) ** 2 * M, B), M, C, K, B)


def craig_bampton(M: Any, C: Any, K: Any, interface: ArrayLike, modes: int) -> Reduction:
    """Static shapes of the interface and the lowest modes of the body that is held there. (Craig and Bampton 1968.)

    Frequencies come from above, and fall with every mode that is added. The first coordinates are the displacements of
    the interface.

    Parameters
    ----------
    modes : number of modes of the held body; others as in `guyan`

    Raises
    ------
    ValueError
        When the body has not so many, or can move freely though its interface is held.
    """
    B = _rows(interface, M, K)
    most = K.shape[0] - len(B)
    if not 0 <= modes <= most:
        raise ValueError(f"modes = {modes}: held at its interface, the body has {most}.")
    shapes = _static_shapes(K, B)
    if modes:
        shapes = np.hstack([shapes, _held_modes(M, K, B, modes)])
    return _reduced(shapes, M, C, K, B)


def modal_reduction(M: Any, C: Any, K: Any, interface: ArrayLike, modes: int, static: bool = False) -> Reduction:
    """The lowest modes of the body as it stands, plain or with the static answer to forces at the interface.

    Plain, every omitted mode is missing from 0 Hz on. With `static`, exact at 0 Hz: K^-1 B' is a part of the basis, as
    with `rbfound.solid.modes.ritz_modes` and one block.

    Parameters
    ----------
    modes : number of modes; others as in `guyan`
    static : whether static shapes are added

    Raises
    ------
    ValueError
        When the body has not so many modes, can move freely (`static`), or the modes leave nothing to complete.
    """
    B = _rows(interface, M, K)
    if not 0 < modes <= K.shape[0]:
        raise ValueError(f"modes = {modes}: it must be from 1 to {K.shape[0]}.")
    Phi = _lowest_modes(M, K, modes)
    if not static:
        return _reduced(Phi, M, C, K, B)
    answer = _factor(K)(B.T.copy())
    answer = answer / np.sqrt(np.einsum("ij,ij->j", answer, M @ answer))
    left = answer - Phi @ (Phi.T @ (M @ answer))
    rest = linalg.eigvalsh(left.T @ (M @ left))[0]
    if rest < NOTHING**2:
        raise ValueError(f"{modes} modes leave nothing to complete at the interface: keep fewer, or static=False.")
    return _reduced(np.hstack([answer, Phi]), M, C, K, B)


def orthonormal(X: Array, M: Any, basis: Array) -> Array:
    """What the columns of X (n, p) add to the M-orthonormal ones of a basis (n, m): M-orthonormal, p or fewer.

    A direction of which the others leave all but nothing is left out.
    """
    # twice, against rounding
    for _ in range(2):
        X = X - basis @ (basis.T @ (M @ X))
        products = X.T @ (M @ X)
        size = np.sqrt(np.diag(products))
        squares, Q = linalg.eigh(products / np.outer(size, size))
        new = squares > DEPENDENT**2
        X = X @ (Q[:, new] / np.outer(size, np.sqrt(squares[new])))
    return np.asarray(X)


def _reduced(T: Array, M: Any, C: Any, K: Any, B: Array) -> Reduction:
    small = [T.T @ (A @ T) if A is not None else np.zeros((T.shape[1],) * 2) for A in (M, C, K)]
    # rounding only; C may be that of journal bearings and keeps its sides
    return Reduction(T, (small[0] + small[0].T) / 2, small[1], (small[2] + small[2].T) / 2, B @ T)


def _rows(interface: ArrayLike, M: Any, K: Any) -> Array:
    """The interface as rows B (s, n), or a ValueError that says what is wrong with it, or with M and K."""
    n = K.shape[0]
    for name, A in (("M", M), ("K", K)):
        if A.shape != (n, n) or np.abs(A - A.T).max() > 1e-9 * np.abs(A).max():
            raise ValueError(f"{name} is {A.shape} beside K of {K.shape}: both must be square, symmetric, of one size.")
    given = np.asarray(interface)
    if given.ndim == 1 and np.issubdtype(given.dtype, np.integer):
        if len(given) == 0 or given.min() < 0 or given.max() >= n or len(set(given.tolist())) < len(given):
            raise ValueError(f"The interface is {given.tolist()}: name coordinates from 0 to {n - 1}, each once.")
        B = np.zeros((len(given), n))
        B[np.arange(len(given)), given] = 1.0
        return B
    if given.ndim != 2 or given.shape[1] != n or len(given) == 0:
        raise ValueError(f"The interface has shape {given.shape}: give coordinates (s,) as integers, or rows (s, {n}).")
    return np.asarray(given, dtype=float)


def _static_shapes(A: Any, B: Array) -> Array:
    """Displacements for a unit of each interface entry and no other force: (n, s), B times them is the identity."""
    answer, compliance = _held(A, B)
    return np.asarray(linalg.solve(compliance.T, answer(B.T.copy()).T).T)


def _held(A: Any, B: Array) -> tuple[Solve, Array]:
    """The answer of A with its interface on springs to the ground, and B times that to forces on the interface.

    The springs drop out of every result in which the interface is prescribed; they make a free body's A regular.
    """
    spring = np.abs(A.diagonal()).max() / np.abs(B).sum(axis=1).max() ** 2
    tied = sparse.csc_array(B)
    answer = _factor(A + spring * (tied.T @ tied) if sparse.issparse(A) else A + spring * (B.T @ B))
    compliance = np.asarray(B @ answer(B.T.copy()))
    if np.linalg.svd(spring * compliance, compute_uv=False)[-1] < STIFFEST:
        raise ValueError("The interface has no static shapes: a row stands twice, or the held body resonates there.")
    return answer, compliance


def _held_modes(M: Any, K: Any, B: Array, count: int) -> Array:
    """Mass-normalised lowest modes with B u = 0, (n, count)."""
    if not sparse.issparse(K):
        null = linalg.qr(B.T)[0][:, len(B) :]
        return np.asarray(null @ _lowest_modes(null.T @ M @ null, null.T @ K @ null, count))
    answer, compliance = _held(K, B)
    reach = answer(B.T.copy())

    def solve(force: Array) -> Array:
        free = answer(np.asarray(force, dtype=float).reshape(len(force), -1))
        return np.asarray((free - reach @ linalg.solve(compliance, B @ free)).reshape(np.shape(force)))

    return _lanczos(M, K, solve, count)


def _lowest_modes(M: Any, K: Any, count: int) -> Array:
    if sparse.issparse(K):
        return _lanczos(M, K, _factor(K), count)
    return np.asarray(linalg.eigh((K + K.T) / 2, M, subset_by_index=[0, count - 1])[1])


def _lanczos(M: Any, K: Any, solve: Solve, count: int) -> Array:
    """Inverse iteration from a fixed start, so that the result is the same each time."""
    inverse = LinearOperator(K.shape, matvec=solve, dtype=float)
    start = solve(M @ np.random.default_rng(0).standard_normal(K.shape[0]))
    squares, Phi = eigsh(K, k=count, M=M, sigma=0.0, OPinv=inverse, v0=start)
    return np.asarray(Phi[:, np.argsort(squares)])


def _factor(A: Any) -> Solve:
    """A^-1 as a function, or a ValueError where A is singular to rounding."""
    if sparse.issparse(A):
        try:
            solve = splu(sparse.csc_array(A), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve
        except RuntimeError:
            raise ValueError(FREE) from None
    else:
        lu, pivots, info = linalg.lapack.dgetrf(A)
        if info > 0:
            raise ValueError(FREE)

        def solve(b: Array) -> Any:
            return linalg.lapack.dgetrs(lu, pivots, b)[0]

    probe = np.random.default_rng(0).standard_normal(A.shape[0])
    if not np.abs(A @ solve(probe) - probe).max() < LOST:
        raise ValueError(FREE)
    return lambda b: np.asarray(solve(np.asarray(b, dtype=float)))
