"""Fewer coordinates: a basis T with u = T q, and the matrices T'MT, T'CT, T'KT that belong to it.

Each way to get a basis is a function of M, C, K (arrays or sparse), of the interface and of what it keeps. The
interface is where forces act and neighbours are tied: indices of coordinates, or rows B with x = B u, as the seats of
a solid are. `rb.Foundation(r.M, r.C, r.K, r.B)` puts a reduction r under a rotor. (equations 15-18)

What the rotors and solids of this package are reduced with is `ritz`: natural modes, and static answers to forces.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from rbfound.system import System
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]
Solve = Callable[[Array], Array]
Factor = Callable[[Any], Solve]

# A direction of which others leave less than this share is theirs already: the rest is rounding.
DEPENDENT = 1e-6

# A factor whose answer to forces of size one leaves so much of them unbalanced is that of a singular matrix.
LOST = 1e-4

# An interface that is stiffer than the body by more than one over this cannot be moved.
STIFFEST = 1e-9

FREE = (
    "The stiffness is singular: a part of the body can move freely. Hold it, name an interface that does, or shift "
    "below 0 Hz."
)


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
    static : number of static shapes
    """

    T: Array
    M: Array
    C: Array
    K: Array
    B: Array
    static: int = 0

    def first(self, count: int) -> "Reduction":
        """The same with the first coordinates only: fewer modes at no further cost; the static shapes stay."""
        fewest = max(self.static, 1)
        if not fewest <= count <= len(self.M):
            raise ValueError(
                f"count = {count}: it must be from {fewest} to {len(self.M)}, as there are {self.static} static shapes."
            )
        small = slice(0, count)
        M, C, K = (A[small, small] for A in (self.M, self.C, self.K))
        return Reduction(self.T[:, small], M, C, K, self.B[:, small], self.static)

    def damped(self, zeta: float) -> "Reduction":
        """The same with one damping ratio [-] for all of its own undamped modes."""
        squares, Q = linalg.eigh(self.K, self.M)
        MQ = self.M @ Q
        return replace(self, C=(MQ * (2 * zeta * np.sqrt(np.maximum(squares, 0)))) @ MQ.T)

    @property
    def natural_frequency(self) -> Array:
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
    return _reduced(_static_shapes(K, B), M, C, K, B, len(B))


def dynamic_reduction(M: Any, C: Any, K: Any, interface: ArrayLike, frequency: float) -> Reduction:
    """Condensation with the inertia of one frequency [Hz] (equations 17-18).

    The thesis prints 17 without its stiffness part. Exact at that frequency for an undamped body; at 0 Hz it is
    `guyan`, whose parameters it has.
    """
    B = _rows(interface, M, K)
    return _reduced(_static_shapes(K - float(from_hertz(frequency)) ** 2 * M, B), M, C, K, B, len(B))


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
    return _reduced(shapes, M, C, K, B, len(B))


def modal_reduction(M: Any, C: Any, K: Any, interface: ArrayLike, modes: int, static: bool = False) -> Reduction:
    """The lowest modes of the body as it stands, plain or with the static answer to forces at the interface.

    Plain, every omitted mode is missing from 0 Hz on. With `static`, exact at 0 Hz: K^-1 B' is a part of the basis, as
    in `ritz` with one block.

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
    Phi = lowest_modes(M, K, modes)[1]
    if not static:
        return _reduced(Phi, M, C, K, B)
    answer = factorised(K)(B.T)
    if orthonormal(answer, M, Phi).shape[1] < len(B):
        raise ValueError(f"{modes} modes leave nothing to complete at the interface: keep fewer, or static=False.")
    # as they are, with what the modes have of them: `first` may take modes away
    answer = answer / np.sqrt(np.einsum("ij,ij->j", answer, M @ answer))
    return _reduced(np.hstack([answer, Phi]), M, C, K, B, len(B))


def ritz(M: Any, K: Any, forces: Array, modes: int, blocks: int = 1, shift: float = 0.0) -> tuple[Array, Array]:
    """Frequencies omega (m,) [rad/s] and mass-normalised shapes Phi (n, m) that carry the answers to some forces.

    Ritz's method in the space of the lowest natural modes and of the static answers to the forces, followed by the
    answers to their own inertia: K^-1 F, K^-1 M K^-1 F, ... These are the first terms of what all the higher modes add
    to the receptance, in powers of omega^2 (Rubin 1975, DOI 10.2514/3.60497, with one term or more). The lowest shapes
    remain the natural modes.

    Parameters
    ----------
    M, K : (n, n), arrays or sparse
    forces : (n, p)
    modes : how many natural modes are kept
    blocks : terms of the series kept, each with one coordinate for every force that it adds something to
    shift : [Hz], 0 or, for a body that can move freely, below: the answers are then those at omega^2 below zero
    """
    solve = factorised(K - _signed_square(shift) * M, definite=shift <= 0)
    basis = lowest_modes(M, K, modes, shift, lambda _: solve)[1] if modes else np.zeros((K.shape[0], 0))
    for _ in range(blocks):
        answer = orthonormal(solve(forces), M, basis)
        basis, forces = np.hstack([basis, answer]), M @ answer
    squares, Q = linalg.eigh(basis.T @ (K @ basis), basis.T @ (M @ basis))
    return np.sqrt(np.maximum(squares, 0.0)), basis @ Q


def lowest_modes(M: Any, K: Any, count: int, shift: float = 0.0, factor: Factor | None = None) -> tuple[Array, Array]:
    """The undamped modes nearest to a frequency: omega^2 (count,) [rad^2/s^2], ascending, and Phi (n, count).

    Of sparse matrices by Lanczos iteration on (K - omega_s^2 M)^-1 M from a fixed start, so that the result is the
    same each time; densely where most of the modes are asked for, which that iteration cannot find.

    Parameters
    ----------
    shift : [Hz], below 0 for omega^2 below zero: there the stiffness of a free body is not singular
    factor : function of a symmetric sparse matrix that returns its inverse as a function of forces (n,); SuperLU
    """
    n = K.shape[0]
    if not 0 < count <= n:
        raise ValueError(f"modes = {count}: it must be from 1 to {n}.")
    square = _signed_square(shift)
    if not sparse.issparse(K) or 2 * count >= n:
        squares, Phi = linalg.eigh(*(A.toarray() if sparse.issparse(A) else A for A in ((K + K.T) / 2, M)))
        first = np.abs(squares - square).argsort(kind="stable")[:count]
        first.sort()
        return squares[first], Phi[:, first]
    solve = (factor or partial(factorised, definite=square <= 0))(sparse.csc_array(K - square * M))
    return _lanczos(M, K, solve, count, square)


def _signed_square(shift: float) -> float:
    """omega^2 [rad^2/s^2] of a frequency [Hz], with its sign."""
    return float(np.sign(shift) * from_hertz(shift) ** 2)


def orthonormal(X: Array, M: Any, basis: Array) -> Array:
    """What the columns of X (n, p) add to the M-orthonormal ones of a basis (n, m): M-orthonormal, p or fewer.

    A direction of which the others leave all but nothing is left out.
    """
    whole = np.sqrt(np.einsum("ij,ij->j", X, M @ X))
    # twice, against rounding
    for _ in range(2):
        X = X - basis @ (basis.T @ (M @ X))
        products = X.T @ (M @ X)
        size = np.sqrt(np.maximum(np.diag(products), 0.0))
        left = np.flatnonzero(size > DEPENDENT * whole)
        if not len(left):
            return np.zeros((len(X), 0))
        X, size = X[:, left], size[left]
        squares, Q = linalg.eigh(products[np.ix_(left, left)] / np.outer(size, size))
        new = squares > DEPENDENT**2
        X = X @ (Q[:, new] / np.outer(size, np.sqrt(squares[new])))
        whole = np.ones(X.shape[1])
    return np.asarray(X)


def _reduced(T: Array, M: Any, C: Any, K: Any, B: Array, static: int = 0) -> Reduction:
    small = [T.T @ (A @ T) if A is not None else np.zeros((T.shape[1],) * 2) for A in (M, C, K)]
    # rounding only; C may be that of journal bearings and keeps its sides
    return Reduction(T, (small[0] + small[0].T) / 2, small[1], (small[2] + small[2].T) / 2, B @ T, static)


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
    return np.asarray(linalg.solve(compliance.T, answer(B.T).T).T)


def _held(A: Any, B: Array) -> tuple[Solve, Array]:
    """The answer of A with its interface on springs to the ground, and B times that to forces on the interface.

    The springs drop out of every result in which the interface is prescribed; they make a free body's A regular.
    """
    spring = np.abs(A.diagonal()).max() / np.abs(B).sum(axis=1).max() ** 2
    tied = sparse.csc_array(B)
    answer = factorised(A + spring * (tied.T @ tied) if sparse.issparse(A) else A + spring * (B.T @ B))
    compliance = np.asarray(B @ answer(B.T))
    if np.linalg.svd(spring * compliance, compute_uv=False)[-1] < STIFFEST:
        raise ValueError("The interface has no static shapes: a row stands twice, or the held body resonates there.")
    return answer, compliance


def _held_modes(M: Any, K: Any, B: Array, count: int) -> Array:
    """Mass-normalised lowest modes with B u = 0, (n, count)."""
    if not sparse.issparse(K) or 2 * count >= K.shape[0] - len(B):
        null = linalg.qr(B.T)[0][:, len(B) :]
        return np.asarray(null @ lowest_modes(null.T @ (M @ null), null.T @ (K @ null), count)[1])
    answer, compliance = _held(K, B)
    reach = answer(B.T)

    def solve(force: Array) -> Array:
        free = answer(force)
        return np.asarray(free - reach @ linalg.solve(compliance, B @ free))

    return _lanczos(M, K, solve, count)[1]


def _lanczos(M: Any, K: Any, solve: Solve, count: int, square: float = 0.0) -> tuple[Array, Array]:
    inverse = LinearOperator(K.shape, matvec=solve, dtype=float)
    start = solve(M @ np.random.default_rng(0).standard_normal(K.shape[0]))
    squares, Phi = eigsh(K, k=count, M=M, sigma=square, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return squares[order], Phi[:, order]


def factorised(A: Any, definite: bool = False) -> Solve:
    """A^-1 of a symmetric matrix, array or sparse, as a function; a ValueError where A is singular to rounding."""
    if sparse.issparse(A):
        # a definite matrix needs no pivots, and keeps a sparser factor without
        threshold = 0.0 if definite else 0.1
        try:
            solve = splu(
                sparse.csc_array(A),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=threshold,
                options={"SymmetricMode": True},
            ).solve
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
