"""Many degrees of freedom: masses in a row, M x'' + C x' + K x = Q (equations 4-7), and their modes.

Receptances as sums of modes, anti-resonances, and real matrices of complex modes.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from rbfound.system import System
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]

Complex = NDArray[np.complex128]

# Rounds of the search for the nearest shapes that a real system can have, and what may be left then.
ROUNDS, LEFT = 50, 1e-10
# A sum that is smaller than this share of the sum of sizes is one that cancels.
NOTHING = 1e-9
# Two poles that are nearer to each other than this share of their size are one: their shapes are not unique.
DOUBLE = 1e-6
# A root of the sum with a larger imaginary part than this share of its size is no frequency at which it vanishes.
REAL = 1e-6


def chain(masses: Sequence[float], springs: Sequence[float], dampers: Sequence[float] | None = None) -> System:
    """A row of masses between two walls (equations 4-6).

    Parameters
    ----------
    masses : n of them [kg]
    springs : n + 1 [N/m]
        From the left wall to the first mass, from mass to mass, and from the last mass to the right wall. Zero is no
        spring: with zeros at both ends the chain is free.
    dampers : n + 1 [N s/m], beside the springs; none unless given

    Raises
    ------
    ValueError
        When the numbers do not fit together, a mass is not positive, or a spring or a damper is negative.
    """
    m = np.atleast_1d(np.asarray(masses, dtype=float))
    n = len(m)
    if (m <= 0).any() or not np.isfinite(m).all():
        raise ValueError(f"The masses hold {m.min():g} kg: every mass must be positive and finite.")
    return System(
        np.diag(m),
        _links(np.zeros(n + 1) if dampers is None else dampers, n, "dampers"),
        _links(springs, n, "springs"),
    )


def _links(values: ArrayLike, n: int, name: str) -> Array:
    """The matrix of what ties neighbours: each link adds its value to two diagonal entries and takes it off beside."""
    links = np.atleast_1d(np.asarray(values, dtype=float))
    if links.shape != (n + 1,):
        raise ValueError(f"{len(links)} {name} for {n} masses: it must be {n + 1}, one at either wall; zero is none.")
    if (links < 0).any() or not np.isfinite(links).all():
        raise ValueError(f"The {name} hold {links.min():g}: they must be finite and not negative.")
    return np.asarray(np.diag(links[:-1] + links[1:]) - np.diag(links[1:-1], 1) - np.diag(links[1:-1], -1))


def real_matrices(Phi: Complex, omega: Array, zeta: Array) -> tuple[Array, Array, Array]:
    """M, C and K of the real system whose complex modes are nearest to Phi, with these poles.

    Parameters
    ----------
    Phi : (n, n) complex [1/sqrt(kg)]
        Shapes; phi / sqrt(2 i omega_d) is psi.
    omega : (n,) [rad/s]
    zeta : (n,) [-]

    Raises
    ------
    ValueError
        When a mode does not oscillate, or the shapes are so complex that none of a real system are near.
    """
    if (zeta >= 1).any():
        raise ValueError(f"zeta holds {zeta.max():g}: a complex shape belongs to a mode that oscillates, zeta < 1.")
    omega_d = omega * np.sqrt(1 - zeta**2)
    poles = -zeta * omega + 1j * omega_d
    psi = _proper(Phi / np.sqrt(2j * omega_d))
    inverse_mass, inverse_stiffness, rate = (
        2 * np.real(psi * power @ psi.T) for power in (poles, -1 / poles, poles**2)
    )
    M, K = linalg.inv(inverse_mass), linalg.inv(inverse_stiffness)
    M, K, C = (A / 2 + A.T / 2 for A in (M, K, -M @ rate @ M))
    return M, C, K


def _proper(psi: Complex) -> Complex:
    """The nearest shapes (least squares) with Re psi psi' = 0: (1 - d^2)^-1 (psi - d conj(psi)) with d symmetric.

    The multipliers d follow from S - d P - P d + d S d = 0 with S = Re psi psi' and P = Re psi psi*: a Lyapunov
    equation with a small correction, as S is small for shapes that are nearly real.
    """
    S, P = np.real(psi @ psi.T), np.real(psi @ psi.conj().T)
    d = np.zeros_like(S)
    for _ in range(ROUNDS):
        d = linalg.solve_continuous_lyapunov(P, S + d @ S @ d)
    nearest = linalg.solve(np.eye(len(d)) - d @ d, psi - d @ psi.conj())
    left = np.abs(np.real(nearest @ nearest.T)).max() / np.abs(P).max()
    if not left < LEFT:
        raise ValueError(
            f"Phi is too complex for the modes of a real system: with {ROUNDS} rounds of correction {left:.1e} of it "
            "is left over. Keep the real parts, or look at the phases of its columns."
        )
    return np.asarray(nearest)


def normal_modes(M: ArrayLike, K: ArrayLike) -> tuple[Array, Array]:
    """Undamped modes: omega (n,) [rad/s], ascending, and mass-normalised shapes Phi (n, n) (equations 8-10, 34-39).

    K phi = omega^2 M phi, so the eigenvalue is omega^2 (the thesis prints its inverse below equation 9), with
    Phi' M Phi = I and Phi' K Phi = diag(omega^2). The largest entry of a shape is positive.

    Raises
    ------
    ValueError
        When M or K is not symmetric, or M not positive definite.
    """
    system = System(np.asarray(M), np.zeros(np.shape(M)), np.asarray(K))
    for name in "MK":
        A = getattr(system, name)
        if np.abs(A - A.T).max(initial=0.0) > 1e-9 * np.abs(A).max(initial=0.0):
            raise ValueError(f"{name} is not symmetric: normal modes are those of symmetric matrices.")
    try:
        squares, Phi = linalg.eigh(system.K, system.M)
    except linalg.LinAlgError:
        raise ValueError("M is not positive definite: every coordinate needs some mass.") from None
    largest = Phi[np.abs(Phi).argmax(axis=0), np.arange(Phi.shape[1])]
    return np.sqrt(np.maximum(squares, 0.0)), Phi * np.where(largest < 0, -1.0, 1.0)


def modal_terms(frequency: ArrayLike, omega: ArrayLike, zeta: ArrayLike, A: ArrayLike) -> Complex:
    """What each real mode adds to a receptance (equations 40-43, 47-49, 53-55): its sum over axis 1 is H.

    Parameters
    ----------
    frequency : (f,) [Hz]
    omega, zeta : (m,) [rad/s], [-]
        zeta may be one number for all.
    A : (m, ...) [1/kg]
        Modal constants phi_i phi_j of mass-normalised shapes: of one FRF, or of a matrix of them.

    Returns
    -------
    (f, m, ...) complex [m/N]
    """
    own, A = np.atleast_1d(np.asarray(omega, dtype=float)), np.asarray(A, dtype=float)
    if A.shape[:1] != own.shape:
        raise ValueError(f"A has shape {A.shape}: with {len(own)} modes its first axis must have {len(own)} entries.")
    w = np.atleast_1d(np.asarray(from_hertz(frequency), dtype=float))[:, None]
    share = 1 / (own**2 - w**2 + 2j * np.asarray(zeta) * own * w)
    return np.asarray(share[(..., *(None,) * (A.ndim - 1))] * A)


def pole_terms(frequency: ArrayLike, poles: ArrayLike, R: ArrayLike) -> Complex:
    """What each complex mode adds, R / (i omega - p) and its conjugate partner: its sum over axis 1 is H.

    The form of equation 54 for any viscous damping. With R = A / (2 i Im p) it is that equation again.

    Parameters
    ----------
    frequency : (f,) [Hz]
    poles : (m,) complex [rad/s], one of each pair
    R : (m, ...) complex [m/(N s)], residues

    Returns
    -------
    (f, m, ...) complex [m/N]
    """
    p, R = np.atleast_1d(np.asarray(poles, dtype=complex)), np.asarray(R, dtype=complex)
    if R.shape[:1] != p.shape:
        raise ValueError(f"R has shape {R.shape}: with {len(p)} poles its first axis must have {len(p)} entries.")
    s = 1j * np.atleast_1d(np.asarray(from_hertz(frequency), dtype=float))[:, None]
    over = (..., *(None,) * (R.ndim - 1))
    return np.asarray((1 / (s - p))[over] * R + (1 / (s - p.conj()))[over] * R.conj())


def residue_shapes(system: System) -> tuple[Complex, Complex]:
    """Poles p (m,) and shapes psi (n, m) whose products psi psi' are the residues of the receptance at the poles.

    From the damped modes, scaled so that psi' (2 p M + C) psi = 1. (Balmes 1997.)

    Raises
    ------
    ValueError
        When a matrix is not symmetric, a mode does not swing, or two poles are one.
    """
    C = system.C + system.G
    for name, A in (("M", system.M), ("C + G", C), ("K", system.K)):
        if np.abs(A - A.T).max(initial=0.0) > 1e-9 * np.abs(A).max(initial=0.0):
            raise ValueError(f"{name} is not symmetric: residues are products of one shape only where all of them are.")
    modes = system.modes()
    p, shapes = modes.poles, modes.shapes
    if (p.imag <= 0).any():
        raise ValueError(f"{(p.imag <= 0).sum()} poles do not swing: residue_shapes needs Im p > 0 for each of them.")
    gaps = np.abs(p[:, None] - p) + np.diag(np.full(len(p), np.inf))
    if len(p) > 1 and (gaps.min(axis=1) < DOUBLE * np.abs(p)).any():
        double = hertz(np.abs(p[gaps.min(axis=1).argmin()]))
        raise ValueError(f"Two poles lie at {double:.6g} Hz: the shapes of a double pole are not unique.")
    size = np.einsum("im,im->m", shapes, 2 * p * (system.M @ shapes) + C @ shapes)
    return p, shapes / np.sqrt(size)


def antiresonances(omega: ArrayLike, A: ArrayLike, residual: float = 0.0) -> Array:
    """Frequencies [Hz], ascending, at which the undamped sum of equation 49 vanishes.

    The zeros of sum A_r / (omega_r^2 - w^2) + residual, from an eigenvalue problem of m + 1 coordinates: the modes,
    and a force that holds the response still. Where all A are positive (a driving point) one zero lies between every
    two resonances; elsewhere there are as many as there are.

    Parameters
    ----------
    omega : (m,) [rad/s]
    A : (m,) [1/kg]
        Modal constants phi_i phi_j of one FRF.
    residual : [m/N]
        The static share of modes that are not in the sum.
    """
    own, A = np.atleast_1d(np.asarray(omega, dtype=float)), np.atleast_1d(np.asarray(A, dtype=float))
    if own.shape != A.shape or own.ndim != 1:
        raise ValueError(f"omega has shape {own.shape} and A {A.shape}: one FRF has one constant for each mode.")
    if not A.any():
        raise ValueError("Every A is zero: the response vanishes at all frequencies.")
    m = len(own)
    unit = max(own.max(initial=0.0), np.finfo(float).tiny) ** 2
    size = max(np.abs(A).max(initial=0.0), np.finfo(float).tiny)
    bordered = np.zeros((m + 1, m + 1))
    bordered[:m, :m] = np.diag(own**2 / unit)
    # sqrt on both sides keeps a driving point's problem symmetric
    root = np.sqrt(np.abs(A) / size)
    bordered[:m, m], bordered[m, :m] = np.sign(A) * root, root
    bordered[m, m] = -residual * unit / size
    top, bottom = linalg.eigvals(bordered, np.diag([*np.ones(m), 0.0]), homogeneous_eigvals=True)
    # far above all modes the sum is a series of sum A / w^2, sum A omega^2 / w^4, ...: each leading term that is
    # nothing takes one more zero away to infinity, and an eigenvalue there is rounding
    order = np.argsort(np.arctan2(np.abs(top), np.abs(bottom)))[: _finite_zeros(own, A, residual)]
    squares = top[order] / bottom[order]
    real = (np.abs(squares.imag) <= REAL * np.abs(squares)) & (squares.real > 0)
    return np.sort(np.asarray(hertz(np.sqrt(unit * squares.real[real]))))


def _finite_zeros(own: Array, A: Array, residual: float) -> int:
    if residual != 0:
        return len(own)
    moments = (own / own.max()) ** (2 * np.arange(len(own))[:, None])
    nothing = np.abs(moments @ A) <= NOTHING * (moments @ np.abs(A))
    return len(own) - 1 - int(nothing.argmin())
