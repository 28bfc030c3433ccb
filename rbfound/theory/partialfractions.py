"""A transfer function as a ratio of polynomials, as partial fractions, and as real blocks of second order.

The path of Vazquez (equations 66-74):

    sum A_k / (omega_k^2 + 2 zeta_k omega_k s + s^2)  =  N(s) / D(s)  =  sum B_k / (s + D_k)

One FRF or a matrix of them: whatever stands over the poles may have any shape behind its first axis.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbfound.units import from_hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# A root of D that is smaller than this part of the largest one is a zero: a free motion.
FREE = 1e-6

# Two roots that are nearer to each other than this part of their size are one double root.
DOUBLE = 1e-7


@dataclass(frozen=True, eq=False)
class PartialFractions:
    """H(s) = A / s^2 + sum B_k / (s + D_k)   (equation 74), and a polynomial where N / D has one.

    Attributes
    ----------
    A : (...) [1/kg]
        Of the free motions, all in one.
    B : (2m, ...) complex [m/(N s)]
    D : (2m,) complex [rad/s]
        The poles are -D. Pairs stand together: conjugates, or two real ones.
    whole : (k, ...)
        Coefficients of s^0, s^1, ...; none where N is of lower degree than D.
    """

    A: Array
    B: Complex
    D: Complex
    whole: Array

    def receptance(self, frequency: ArrayLike) -> Complex:
        """H [m/N] at frequencies above zero [Hz], (n, ...)."""
        s = 1j * np.atleast_1d(np.asarray(from_hertz(frequency), dtype=float))
        H = np.tensordot(1 / (s[:, None] + self.D), self.B, axes=1) + np.multiply.outer(1 / s**2, self.A)
        return np.asarray(H + np.tensordot(s[:, None] ** np.arange(len(self.whole)), self.whole, axes=1))

    def blocks(self) -> tuple[Array, Array, Array, Array]:
        """Real blocks (b1 s + b0) / (s^2 + c s + k): b1 (m, ...), b0 (m, ...), c (m,), k (m,).

        B / (s + D) + B' / (s + D') has b1 = B + B', b0 = B D' + B' D, c = D + D' and k = D D', which are real for a
        conjugate pair and for two real ones. A real mode has b1 = 0.
        """
        (B, E), (D, F) = (self.B[::2], self.B[1::2]), (self.D[::2], self.D[1::2])
        over = (slice(None), *(None,) * (self.B.ndim - 1))
        return (B + E).real, (B * F[over] + E * D[over]).real, (D + F).real, (D * F).real


def expanded(A: ArrayLike, omega: ArrayLike, zeta: ArrayLike, free: ArrayLike | None = None) -> PartialFractions:
    """Partial fractions of modes (equations 70-74).

    d and e are conjugates, and a and b have opposite signs: with both alike, as equation 71 is printed, the sum of the
    two fractions is no real mode.

    Parameters
    ----------
    A : (m, ...) [1/kg]
        phi_i phi_j of each mode.
    omega, zeta : (m,) [rad/s], [-]
        zeta below 1.
    free : (...) [1/kg]
        The same of the free motions, summed.
    """
    A, omega, zeta = np.asarray(A, dtype=float), np.asarray(omega, dtype=float), np.asarray(zeta, dtype=float)
    if omega.shape != zeta.shape or omega.shape != A.shape[:1]:
        raise ValueError(
            f"A has shape {A.shape}, omega {omega.shape} and zeta {zeta.shape}: the first axes must agree."
        )
    if (zeta >= 1).any() or (omega <= 0).any():
        raise ValueError(
            f"The largest damping ratio is {zeta.max():g}, the lowest frequency {omega.min():g} rad/s: these fractions "
            "are those of modes that swing, zeta < 1 and omega > 0."
        )
    damped = omega * np.sqrt(1 - zeta**2)
    d = zeta * omega + 1j * damped
    a = 1j * A / (2 * damped[(slice(None), *(None,) * (A.ndim - 1))])
    B, D = np.stack([a, -a], axis=1), np.stack([d, d.conj()], axis=1)
    rest = np.zeros(A.shape[1:]) if free is None else np.asarray(free, dtype=float)
    return PartialFractions(rest, B.reshape(-1, *A.shape[1:]), D.ravel(), np.zeros((0, *A.shape[1:])))


def ratio(A: ArrayLike, omega: ArrayLike, zeta: ArrayLike) -> tuple[Array, Array]:
    """The same modes as one ratio N / D (equation 67): coefficients of s^0, s^1, ..., N (2m - 1, ...) and D (2m + 1,).

    In powers of s the coefficients of D run from 1 to the product of all omega^2: take a unit of s in which omega is
    about one.
    """
    A = np.asarray(A, dtype=float)
    factors = [np.array([w**2, 2 * z * w, 1.0]) for w, z in zip(np.asarray(omega), np.asarray(zeta), strict=True)]
    N = np.zeros((2 * len(factors) - 1, *A.shape[1:]))
    for k in range(len(factors)):
        N += np.multiply.outer(_product([*factors[:k], *factors[k + 1 :]]), A[k])
    return N, _product(factors)


def partial_fractions(numerator: ArrayLike, denominator: ArrayLike) -> PartialFractions:
    """Partial fractions of N(s) / D(s): the poles are the roots of D, B = N(p) / D'(p).

    Parameters
    ----------
    numerator : (k, ...)
        Real coefficients of s^0, s^1, ...
    denominator : (n + 1,)
        The same of D.

    Raises
    ------
    ValueError
        When D is no polynomial, a root is double, the free motions are not those of a mass (two zeros and no term in
        1 / s), or the number of real roots is odd.
    """
    N, D = np.array(numerator, dtype=float), np.asarray(denominator, dtype=float)
    n = len(D) - 1
    if n < 2 or D[-1] == 0:
        raise ValueError(
            f"The denominator has {len(D)} coefficients, the last is {D[-1]:g}: it needs three at least, and the last "
            "must not be zero."
        )
    whole, N = _divided(N, D)
    roots = np.roots(D[::-1]).astype(complex)
    zeros = np.abs(roots) <= FREE * np.abs(roots).max()
    if zeros.sum() not in (0, 2):
        raise ValueError(f"D has {zeros.sum()} roots at zero: a free mass has two, a foundation on the ground none.")
    free = np.zeros(N.shape[1:])
    if zeros.any():
        # H = N / (s^2 D2): with N = A D2 + s^2 N2, N2 / D2 is what is left
        D, size = D[2:], np.abs(N).max()
        free = N[0] / D[0]
        N[: len(D)] -= np.multiply.outer(D, free)
        if np.abs(N[1]).max() > FREE * size:
            raise ValueError("N / D has a term in 1 / s: a free mass has 1 / s^2 alone.")
        N, roots = N[2:], roots[~zeros]
    return PartialFractions(free, *_residues(N, D, _paired(roots)), whole)


def _divided(N: Array, D: Array) -> tuple[Array, Array]:
    """Quotient, and remainder with as many coefficients as D has roots."""
    n = len(D) - 1
    quotient = np.zeros((max(len(N) - n, 0), *N.shape[1:]))
    for k in range(len(quotient) - 1, -1, -1):
        quotient[k] = N[k + n] / D[-1]
        N[k : k + n + 1] -= np.multiply.outer(D, quotient[k])
    rest = np.zeros((n, *N.shape[1:]))
    rest[: len(N)] = N[:n]
    return quotient, rest


def _residues(N: Array, D: Array, poles: Complex) -> tuple[Complex, Complex]:
    slope = np.polynomial.polynomial.polyval(poles, np.polynomial.polynomial.polyder(D))
    powers = poles[:, None] ** np.arange(len(N))
    return np.tensordot(powers / slope[:, None], N, axes=1), -poles


def _paired(roots: Complex) -> Complex:
    """Conjugates one after the other, then the real roots two by two."""
    apart = np.abs(roots[:, None] - roots[None, :]) + np.diag(np.full(len(roots), np.inf))
    if len(roots) > 1 and (apart.min(axis=1) < DOUBLE * np.abs(roots)).any():
        raise ValueError(f"D has a double root at {roots[apart.min(axis=1).argmin()]:.6g}: it has no simple fractions.")
    swinging, real = roots[roots.imag > 0], np.sort(roots[roots.imag == 0].real)
    if len(real) % 2:
        raise ValueError(f"D has {len(real)} real roots: without its partner the last one makes no block.")
    # conj(p) first: D = -p, and d of equation 71 has the positive imaginary part
    pairs = np.stack([swinging.conj(), swinging], axis=1)[np.argsort(np.abs(swinging))].ravel()
    return np.concatenate([pairs, real])


def _product(factors: list[Array]) -> Array:
    out = np.ones(1)
    for factor in factors:
        out = np.convolve(out, factor)
    return out
