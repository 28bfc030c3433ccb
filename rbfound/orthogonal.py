"""Polynomials of s = ix in a basis of powers, or in one that is orthogonal on the measured lines.

Either basis is a recurrence of three terms, and the roots of a polynomial are the eigenvalues of a matrix that holds
it: no power of s is needed on the way. (Forsythe 1957, DOI 10.1137/0105007; Richardson and Formenti 1982.)
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Basis:
    """Polynomials of s by a recurrence: p_0 = first, s p_k = up[k] p_k+1 - down[k] p_k-1.

    Attributes
    ----------
    first : float
    up, down : (degree,)
        For powers of s, ones and zeros.
    """

    first: float
    up: Array
    down: Array

    def values(self, s: ArrayLike) -> Complex:
        """All polynomials at some s, (degree + 1, len(s))."""
        s = np.atleast_1d(np.asarray(s, dtype=complex))
        P = np.empty((len(self.up) + 1, len(s)), dtype=complex)
        P[0] = self.first
        for k, (up, down) in enumerate(zip(self.up, self.down, strict=True)):
            P[k + 1] = (s * P[k] + (down * P[k - 1] if k else 0)) / up
        return P

    def roots(self, coefficients: ArrayLike) -> Complex:
        """Roots of sum c_k p_k, from the eigenvalues of the comrade matrix, (degree,).

        At a root the values v = (p_0, ..., p_n-1) satisfy s v = T v: the recurrence, in whose last row p_n is the sum
        of the others. For powers of s this is the companion matrix.
        """
        c = np.asarray(coefficients, dtype=float)
        n = len(c) - 1
        T = np.diag(self.up[: n - 1], 1) - np.diag(self.down[1:n], -1)
        T[-1] -= self.up[n - 1] * c[:-1] / c[-1]
        return np.asarray(np.linalg.eigvals(T), dtype=complex)


def power_basis(degree: int) -> Basis:
    """1, s, s^2, ..."""
    return Basis(1.0, np.ones(degree), np.zeros(degree))


def orthogonal_basis(x: ArrayLike, weight: ArrayLike, degree: int) -> Basis:
    """Polynomials of s = ix that are orthonormal on the lines: Re sum weight conj(p_j) p_k = 1 if j = k, else 0.

    Only x > 0 is measured. At -x a receptance is the conjugate of that at x, and over both halves p_k is i^k times a
    real polynomial of x that is even or odd as k is: the term in p_k of the recurrence vanishes, and half of the lines
    serve for all (the half functions of Richardson and Formenti).

    Parameters
    ----------
    x : (n,)
        Lines, positive.
    weight : (n,)
        Not negative.
    """
    x, weight = np.asarray(x, dtype=float), np.asarray(weight, dtype=float)
    if degree + 1 > 2 * np.count_nonzero(weight):
        raise ValueError(
            f"{np.count_nonzero(weight)} lines cannot tell {degree + 1} polynomials apart: half as many lines as "
            "polynomials are the least."
        )
    now = np.full(len(x), 1 / np.sqrt(weight.sum()))
    before, beta = np.zeros(len(x)), [0.0]
    for _ in range(degree):
        higher = x * now - beta[-1] * before
        beta.append(float(np.sqrt((weight * higher**2).sum())))
        before, now = now, higher / beta[-1]
    return Basis(float(1 / np.sqrt(weight.sum())), np.array(beta[1:]), np.array(beta[:-1]))
