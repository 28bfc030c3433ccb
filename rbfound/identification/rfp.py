"""Rational fraction polynomials: sixteen FRFs as polynomials in s = iw over one common denominator.

H_ij(s) = N_ij(s) / D(s).  N_ij - H_ij D = 0 is linear in all coefficients. (Richardson and Formenti 1982.)

Written in powers of s the columns are nearly parallel; written in polynomials that are orthogonal on the lines they are
not (`rbfound.identification.rfp`).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from rbfound.foundation import Foundation
from rbfound.frf import FRF, SEATS
from rbfound.identification.least_squares import problem_of
from rbfound.identification.lsfd import fit_residues
from rbfound.identification.plscf import HEAVY, lines_in
from rbfound.parallel import one_thread
from rbfound.units import from_hertz, hertz

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


# A further iteration that changes no |D| by more than this part is the last.
SETTLED = 1e-6


@dataclass(frozen=True, eq=False)
class Fraction:
    """All FRFs as polynomials over one denominator.

    Attributes
    ----------
    denominator, numerator : Basis
        Of s / scale.
    d : (n + 1,)
        Coefficients of D.
    c : (k, seats, seats)
        Coefficients of the N_ij [m/N].
    scale : float
        The upper edge of the band [rad/s].
    condition : float
        Condition number of the least-squares matrix, but for the column of the highest power of D. That of the normal
        equations is its square.
    iterations : how often D was solved for
    band : (lowest, highest) [Hz]
    labels : names of the seats
    """

    denominator: Basis
    numerator: Basis
    d: Array
    c: Array
    scale: float
    condition: float
    iterations: int
    band: tuple[float, float]
    labels: tuple[str, ...] = SEATS

    @property
    def poles(self) -> Complex:
        """All roots of D [rad/s], by size: pairs, and real ones."""
        roots = self.denominator.roots(self.d) * self.scale
        return roots[np.argsort(np.abs(roots))]

    def frf(self, frequency: ArrayLike) -> FRF:
        """N / D on the given lines [Hz]."""
        frequency = np.atleast_1d(np.asarray(frequency, dtype=float))
        s = 1j * np.asarray(from_hertz(frequency)) / self.scale
        H = np.einsum("kij,kn->nij", self.c, self.numerator.values(s))
        return FRF(frequency, H / (self.d @ self.denominator.values(s))[:, None, None], self.labels)


def fit_fraction(
    frf: FRF,
    modes: int,
    *,
    band: tuple[float, float] | None = None,
    basis: str = "orthogonal",
    extra: int = 2,
    relative: bool = True,
    leading: bool = False,
    iterations: int = 10,
) -> Fraction:
    """Polynomials over a common denominator, by linear least squares on N - H D.

    The method as it was published is `relative=False, leading=True, iterations=0`. What is changed unless asked for,
    and why: N - H D is the error of H times |D|, so each solution weighs the next one by 1 / |D| (Sanathanan and
    Koerner 1963); and D is measured by all its coefficients instead of the last one. In the orthogonal basis the error
    that noise relative to |H| leaves in N - H D is the same for all D of that size, so that noise does not prefer one.

    Parameters
    ----------
    frf : FRF
        Its symmetric part is fitted.
    modes : int
        In the band.
    band : (lowest, highest) [Hz]
        Unless given, all lines but those at 0 Hz.
    basis : "orthogonal" or "power"
    extra : int
        Pairs of poles for what lies outside the band. N is of two degrees more than D.
    relative : bool
        Whether an error counts relative to |H| or as it is.
    leading : bool
        Whether the highest coefficient of D is set to one, or the sum of the squares of all.
    iterations : int
        The most; 0 is the plain equation error.

    Raises
    ------
    ValueError
        When `modes`, `extra` or `iterations` is too small, `basis` is neither, or there are too few lines.
    """
    part, band = lines_in(frf, band)
    _check(part, modes, extra, iterations, basis)
    degree = 2 * (modes + extra)
    problem = problem_of(np.asarray(from_hertz(part.frequency)), part.H, relative)
    size = np.abs(problem.H).max()
    H, x = problem.H / size, problem.omega / problem.omega[-1]
    weight = problem.weight / np.sqrt(np.mean(problem.weight**2))
    shape, count = np.ones_like(x), 0
    while True:
        count += 1
        w = weight / shape
        if basis == "power":
            lower, upper = power_basis(degree), power_basis(degree + 2)
        else:
            lower = orthogonal_basis(x, ((np.abs(H) * w) ** 2).sum(axis=0), degree)
            upper = orthogonal_basis(x, (w**2).mean(axis=0), degree + 2)
        d, c, stack = _solved(H, w, lower.values(1j * x), upper.values(1j * x), leading)
        D = np.abs(d @ lower.values(1j * x))
        new = np.maximum(D / np.median(D), 1e-6)
        change, shape = np.abs(new / shape - 1).max(), new
        if count > iterations or change < SETTLED:
            break
    seats = len(part.labels)
    N = np.zeros((degree + 3, seats, seats))
    N[:, problem.rows, problem.columns] = N[:, problem.columns, problem.rows] = c.T * size
    return Fraction(
        lower, upper, d, N, float(problem.omega[-1]), _condition(stack, degree + 3), count, band, part.labels
    )


@one_thread
def rational_fraction(
    frf: FRF,
    modes: int,
    *,
    band: tuple[float, float] | None = None,
    basis: str = "orthogonal",
    extra: int = 2,
    relative: bool = True,
    leading: bool = False,
    iterations: int = 10,
) -> Foundation:
    """A foundation by rational fraction polynomials with a common denominator, and least-squares residues.

    Of the roots of the denominator those in the band that are stable and damped by less than 30 % are kept; where they
    are more than `modes`, those with the highest peaks. Residues and the remainder are then those of `fit_residues`.

    Parameters and errors are those of `fit_fraction`; it is a ValueError, too, when no root may be kept.
    """
    part, band = lines_in(frf, band)
    fraction = fit_fraction(
        part,
        modes,
        band=band,
        basis=basis,
        extra=extra,
        relative=relative,
        leading=leading,
        iterations=iterations,
    )
    roots = fraction.poles[fraction.poles.imag > 0]
    own = np.asarray(hertz(np.abs(roots)))
    physical = (roots.real < 0) & (-roots.real < HEAVY * np.abs(roots)) & (own >= band[0]) & (own <= band[1])
    if not physical.any():
        raise ValueError(
            f"No root of the denominator from {band[0]:g} to {band[1]:g} Hz is a stable pole: {modes} modes may be too "
            "few, or the band too wide."
        )
    kept = _highest(part, roots[physical], band, modes)
    made = fit_residues(part, kept, band=band).foundation()
    gone = [f"{hertz(np.abs(p)):.4g} Hz {-100 * p.real / np.abs(p):.3g} %" for p in roots if p not in kept]
    notes = [
        f"Rational fraction polynomials, {basis} basis, {modes} + {extra} modes, condition number "
        f"{fraction.condition:.1e}; roots that were dropped: {', '.join(gone) or 'none'}."
    ]
    if len(kept) < modes:
        notes.append(f"Warning: {modes} modes were asked for, {len(kept)} stable ones were found in the band.")
    return replace(made, notes=(*notes, *made.notes))


def _check(part: FRF, modes: int, extra: int, iterations: int, basis: str) -> None:
    if modes < 1 or extra < 0 or iterations < 0:
        raise ValueError(
            f"modes is {modes}, extra {extra}, iterations {iterations}: there must be one mode at least, and neither "
            "of the others may be negative."
        )
    if basis not in ("orthogonal", "power"):
        raise ValueError(f'basis is {basis!r}: it must be "orthogonal" or "power".')
    unknowns = 4 * (modes + extra) + 3
    if 2 * len(part.frequency) < unknowns:
        raise ValueError(
            f"{len(part.frequency)} lines are too few for {modes} + {extra} modes: {(unknowns + 1) // 2} are the least."
        )
    if not np.abs(part.H).any():
        raise ValueError("All receptances are zero: nothing moves.")


def _solved(H: Complex, w: Array, lower: Complex, upper: Complex, leading: bool) -> tuple[Array, Array, list[Array]]:
    """Coefficients d (n + 1,) and c (entries, k), and the triangular factor of each entry's [N, -H D].

    The N of an entry appear in its rows only: what they can do is taken out by a QR factorisation of each entry.
    """
    k, stack = len(upper), []
    for e in range(len(H)):
        both = np.vstack([upper, -lower * H[e]]) * w[e]
        stack.append(_triangle(np.ascontiguousarray(both).view(float).T))
    rest = _triangle(np.vstack([R[k:, k:] for R in stack]))
    if leading:
        d = np.append(linalg.lstsq(rest[:, :-1], -rest[:, -1])[0], 1.0)
    else:
        d = np.linalg.svd(rest)[2][-1]
    c = np.array([linalg.lstsq(R[:k, :k], -R[:k, k:] @ d)[0] for R in stack])
    return d, c, stack


def _triangle(A: Array) -> Array:
    """R of A = Q R, (columns, columns)."""
    return np.asarray(np.linalg.qr(A, mode="r"))


def _condition(stack: list[Array], k: int) -> float:
    """Condition number of the least-squares matrix of all entries, from their triangular factors, without its last
    column."""
    own = linalg.block_diag(*(R[:k, :k] for R in stack))
    shared = np.vstack([R[:k, k:-1] for R in stack])
    rest = _triangle(np.vstack([R[k:, k:-1] for R in stack]))
    whole = np.block([[own, shared], [np.zeros((len(rest), own.shape[1])), rest]])
    return float(np.linalg.cond(whole))


def _highest(part: FRF, poles: Complex, band: tuple[float, float], modes: int) -> Complex:
    """As many poles as there are modes: those that are highest on the line next to them, relative to |H| there."""
    if len(poles) <= modes:
        return poles
    fit = fit_residues(part, poles, band=band)
    line = np.abs(part.frequency[:, None] - hertz(np.abs(fit.poles))).argmin(axis=0)
    # not at the pole itself: one that is sharper than the lines are apart can be as high as it likes there
    reach = np.abs(1j * from_hertz(part.frequency[line]) - fit.poles)[:, None, None]
    height = (np.abs(fit.R) / reach / np.maximum(np.abs(part.H[line]), np.finfo(float).tiny)).max(axis=(1, 2))
    return fit.poles[np.sort(np.argsort(-height)[:modes])]
