"""From known poles to a foundation: residues by linear least squares, with what lies below and above the band.

H(w) = sum over r of [R_r / (iw - p_r) + conj(R_r) / (iw - conj(p_r))]  -  lower / w^2  +  U_0 + U_1 w^2 + ...

A mode far below the band is a free mass there, -1 / (m w^2); one far above it is a spring, 1 / k, and one that is near
bends the spring's line upwards, hence w^2. (Ewins 2000 has the two plain residuals.)
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from rbfound.foundation import Foundation, modal_foundation
from rbfound.frf import FRF, SEATS
from rbfound.identification.least_squares import Problem, State, compliance, problem_of
from rbfound.identification.plscf import ALIKE, groups_of, lines_in, stabilisation, stable_poles
from rbfound.parallel import one_thread
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Where pseudo-modes stand that are below the band, as a part of its lower edge; and those above it that have only
# a static residual, or that may be anywhere between two bounds, in multiples of its upper edge.
BELOW, ABOVE, NEAR = 0.1, 20.0, 1.02

# A lower residual that is smaller than so many times the misfit is left out: it takes up what other terms lack.
SURE = 3.0

# Directions in which the remainder is smaller than this part of its largest give are left out.
NOTHING = 1e-6


# Of nearly alike poles each stands for a mode if the residue that they share has that many eigenvalues above this part
# of the largest. Where the second is a larger part, a pole that was found once is a repeated one: neither noise nor a
# remainder that is not yet known leaves as much.
RANK, PLAINLY = 1e-6, 0.5

# Where pseudo-modes below the band start, as a part of its lower edge, and their damping ratio.
FREE = (0.5, 0.2)


@dataclass(frozen=True, eq=False)
class Residues:
    """Poles, their residues, and the remainder of what lies outside the band.

    Attributes
    ----------
    poles : (m,) complex [rad/s]
        One of each pair, Im > 0.
    R : (m, seats, seats) complex [m/(N s)]
        Symmetric. A real mode of unit modal mass has R = phi phi' / (2 i Im p).
    lower : (seats, seats) [1/kg]
        Of what lies below the band.
    upper : (terms, seats, seats) [m/N s^2k]
        Of what lies above it, the coefficients of w^0, w^2, ...; there may be none.
    misfit : (outputs, inputs)
        Root mean square of data - fit of each FRF, as a part of |H| (relative=False: [m/N]).
    band : (lowest, highest) [Hz]
    labels : names of the seats
    relative : whether errors were taken relative to |H|
    """

    poles: Complex
    R: Complex
    lower: Array
    upper: Array
    misfit: Array
    band: tuple[float, float]
    labels: tuple[str, ...] = SEATS
    relative: bool = True

    @property
    def modal_constants(self) -> Complex:
        """2 i Im(p) R [1/kg], (m, seats, seats): real and phi phi' for a real mode of unit modal mass."""
        return np.asarray(2j * self.poles.imag[:, None, None] * self.R)

    def frf(self, frequency: ArrayLike) -> FRF:
        """What was fitted, on the given lines [Hz]; without the lower residual at 0 Hz, where it has no end."""
        frequency = np.atleast_1d(np.asarray(frequency, dtype=float))
        w = np.asarray(from_hertz(frequency))
        H = np.einsum("rij,rn->nij", self.R, 1 / (1j * w - self.poles[:, None]))
        H = H + np.einsum("rij,rn->nij", self.R.conj(), 1 / (1j * w - self.poles.conj()[:, None]))
        for k, U in enumerate(self.upper):
            H = H + w[:, None, None] ** (2 * k) * U
        free = np.divide(-1.0, w**2, where=w > 0, out=np.zeros_like(w))
        return FRF(frequency, H + free[:, None, None] * self.lower, self.labels)

    def foundation(self) -> Foundation:
        """Real modes that are nearest to it: reciprocal and passive. The notes say what was cut.

        Of each modal constant, the real part, and of that the largest eigenvector, as long as it is positive (compare
        equations 57-61); of either residual, the positive part as pseudo-modes.

        Raises
        ------
        ValueError
            When no residue has such a part.
        """
        values, vectors = np.linalg.eigh(self.modal_constants.real)
        real = values[:, -1] > NOTHING * np.abs(values).max(axis=1)
        if not real.any():
            raise ValueError(
                f"None of the {len(self.poles)} residues is one of a real mode: the driving points have Im H > 0 "
                "at the poles. A sensor or a force may be the wrong way round."
            )
        Phi = (vectors[real, :, -1] * np.sqrt(values[real, -1:])).T
        own, zeta = np.abs(self.poles), -self.poles.real / np.abs(self.poles)
        typical = float(np.median(zeta))
        parts = [(Phi, own[real], zeta[real]), self._below(typical), self._above(typical)]
        shapes, omega, damping = zip(*parts, strict=True)
        order = np.argsort(np.concatenate(omega))
        made = modal_foundation(
            np.hstack(shapes)[:, order], np.concatenate(omega)[order], np.concatenate(damping)[order], self.labels
        )
        return replace(made, notes=self._notes(made, real, [len(part[1]) for part in parts]))

    def _below(self, zeta: float) -> tuple[Array, Array, Array]:
        """Pseudo-modes for the lower residual: its positive part, where it is clearly more than the misfit."""
        low = float(from_hertz(max(self.band[0], 1e-3 * self.band[1])))
        values, vectors = np.linalg.eigh(self.lower)
        edge = np.abs(self.frf([hertz(low)]).H).max()
        error = float(self.misfit.max()) * (edge if self.relative else 1.0)
        kept = values / low**2 > max(SURE * error, NOTHING * edge)
        count = int(kept.sum())
        return vectors[:, kept] * np.sqrt(values[kept]), np.full(count, BELOW * low), np.full(count, zeta)

    def _above(self, zeta: float) -> tuple[Array, Array, Array]:
        """Pseudo-modes for the upper residual U_0 + U_1 w^2: sum phi phi' / omega^2 and sum phi phi' / omega^4.

        Both are diagonal in the eigenvectors of U_1 - lambda U_0 with lambda = 1 / omega^2, within the subspace in
        which U_0 is positive.
        """
        high = float(from_hertz(self.band[1]))
        if not len(self.upper):
            return np.zeros((len(self.labels), 0)), np.zeros(0), np.zeros(0)
        values, vectors = np.linalg.eigh(self.upper[0])
        kept = values > NOTHING * np.abs(values).max()
        half, inverse = vectors[:, kept] * np.sqrt(values[kept]), vectors[:, kept] / np.sqrt(values[kept])
        squared, turn = np.full(int(kept.sum()), (ABOVE * high) ** -2), np.eye(int(kept.sum()))
        if len(self.upper) > 1 and kept.any():
            squared, turn = np.linalg.eigh(inverse.T @ self.upper[1] @ inverse)
            squared = np.clip(squared, (ABOVE * high) ** -2, (NEAR * high) ** -2)
        omega = 1 / np.sqrt(squared)
        return half @ turn * omega, omega, np.full(len(omega), zeta)

    def _notes(self, made: Foundation, real: NDArray[np.bool_], counts: list[int]) -> tuple[str, ...]:
        """What was fitted, and what a real, passive model had to leave out of it."""
        lines = np.linspace(max(self.band[0], 1e-3 * self.band[1]), self.band[1], 400)
        fit, passive = self.frf(lines).H, made.frf(lines).H
        point = np.sqrt(np.mean(np.abs(fit - passive) ** 2) / np.mean(np.abs(fit) ** 2))
        A = self.modal_constants
        size = np.linalg.norm(A, axis=(1, 2))
        turned = np.linalg.norm(A.imag, axis=(1, 2)) / np.where(size > 0, size, 1.0)
        worst = int(turned.argmax())
        unit = " of |H|" if self.relative else " m/N"
        misfit = 100 * self.misfit if self.relative else self.misfit
        notes = [
            f"Residues at {len(self.poles)} poles from {self.band[0]:g} to {self.band[1]:g} Hz; misfit, root mean "
            f"square, {np.sqrt(np.mean(misfit**2)):.3g}{' %' if self.relative else ''}{unit} over all FRFs, "
            f"{misfit.max():.3g}{' %' if self.relative else ''}{unit} at the worst.",
            f"{counts[1]} pseudo-modes stand for what lies below the band and {counts[2]} for what lies above it; they "
            "mean nothing one by one.",
            f"Real modes are all that was kept: of the modal constants the imaginary part was cut, at the most "
            f"{100 * turned[worst]:.2g} % of one ({hertz(np.abs(self.poles[worst])):.4g} Hz), and what is not of rank "
            f"one; of the residuals, what was negative. All this moves H by {100 * point:.2g} %, root mean square.",
        ]
        notes += [
            f"Warning: the pole at {f:.4g} Hz was dropped: no real mode has such a residue."
            for f in hertz(np.abs(self.poles[~real]))
        ]
        return tuple(notes)


@one_thread
def fit_residues(
    frf: FRF,
    poles: ArrayLike,
    *,
    band: tuple[float, float] | None = None,
    lower: bool = True,
    upper: int = 2,
    relative: bool = True,
) -> Residues:
    """Symmetric residues at known poles, and the remainder, by linear least squares over all FRFs.

    Parameters
    ----------
    frf : FRF
        Its symmetric part is fitted.
    poles : (m,) complex [rad/s]
        One of each pair.
    band : (lowest, highest) [Hz]
        Unless given, all lines but those at 0 Hz.
    lower : bool
        Whether modes may lie below the band.
    upper : int
        Terms of the remainder of what lies above: 0 none, 1 a constant, 2 a constant and w^2, ...
    relative : bool
        Whether an error counts relative to |H| or as it is.

    Raises
    ------
    ValueError
        When a pole is unstable or not above 0 Hz, two are the same, or the band holds too few lines.
    """
    part, band = lines_in(frf, band)
    poles = _checked(poles)
    if upper < 0:
        raise ValueError(f"upper is {upper}: the remainder has no terms (0), a constant (1) or more.")
    unknowns = 2 * len(poles) + upper + lower
    if 2 * len(part.frequency) < unknowns:
        raise ValueError(
            f"{len(part.frequency)} lines from {band[0]:g} to {band[1]:g} Hz cannot tell {unknowns} numbers of each "
            f"FRF: {(unknowns + 1) // 2} lines are the least."
        )
    problem = problem_of(np.asarray(from_hertz(part.frequency)), part.H, relative)
    w, seats, m = problem.omega, len(part.labels), len(poles)
    one, other = 1 / (1j * w - poles[:, None]), 1 / (1j * w - poles.conj()[:, None])
    terms = [one + other, 1j * (one - other), (w / w[-1]) ** (2 * np.arange(upper)[:, None]) + 0j]
    columns = np.vstack([*terms, -((w[0] / w) ** 2)[None, :] * np.ones((int(lower), 1))])
    solved = np.zeros((len(columns), seats, seats))
    for e, (i, j) in enumerate(zip(problem.rows, problem.columns, strict=True)):
        A = np.ascontiguousarray(columns * problem.weight[e]).view(float).T
        size = np.linalg.norm(A, axis=0)
        data = np.ascontiguousarray(problem.H[e] * problem.weight[e]).view(float)
        solved[:, i, j] = solved[:, j, i] = linalg.lstsq(A / size, data)[0] / size
    scale = w[-1] ** (-2.0 * np.arange(upper))[:, None, None]
    below = solved[-1] * w[0] ** 2 if lower else np.zeros((seats, seats))
    R = solved[:m] + 1j * solved[m : 2 * m]
    fit = Residues(
        poles, R, below, solved[2 * m : 2 * m + upper] * scale, np.zeros((seats, seats)), band, part.labels, relative
    )
    error = np.abs(part.H - fit.frf(part.frequency).H)
    # an FRF that is zero has no size to compare with
    error = error / np.maximum(np.abs(part.H), np.finfo(float).tiny) if relative else error
    misfit = np.sqrt(np.mean(error**2, axis=0))
    return Residues(poles, R, below, fit.upper, misfit, band, part.labels, relative)


@one_thread
def lscf(
    frf: FRF,
    *,
    band: tuple[float, float] | None = None,
    orders: Iterable[int] | None = None,
    share: float = 0.4,
    lower: bool = True,
    upper: int = 2,
) -> Foundation:
    """A foundation by poly-reference least-squares complex frequency and least-squares residues.

    The poles that are stable over the orders (`stabilisation`, `stable_poles`), then their residues with a lower and an
    upper residual (`fit_residues`), then the real modes nearest to these. No iteration: `identify` starts where this
    ends.

    Parameters and errors are those of these three functions.
    """
    part, band = lines_in(frf, band)
    poles, _ = stable_poles(stabilisation(part, orders), share)
    return fit_residues(part, poles, band=band, lower=lower, upper=upper).foundation()


def first_modes(problem: Problem, poles: Complex, *, below: bool = False) -> State:
    """Modes at known poles with the shapes that linear least squares gives them, and one pseudo-mode a seat above.

    With `below`, what lies below the band is as many pseudo-modes, heavily damped as those of a body on soft springs.

    Each entry is a real combination of the modes' compliances, of a remainder U + V w^2 of what lies above the band and
    of one -L / w^2 of what lies below. The largest eigenvector of a mode's symmetric residue is its shape. Poles that
    cannot be told from a repeated one have a residue together, and `repeated_modes` tells them apart.
    """
    groups = groups_of(poles)
    mean = np.array([poles[group].mean() for group in groups], dtype=complex)
    own, zeta = np.abs(mean), np.clip(-mean.real / np.abs(mean), 1e-4, 0.3)
    seats, m = int(problem.rows.max()) + 1, len(mean)
    low, high = problem.edges
    w = problem.omega
    several = np.flatnonzero([len(group) > 1 for group in groups])
    g = compliance(w, own, zeta)
    columns = np.vstack([g, np.ones_like(w), (w / high) ** 2, -((low / w) ** 2), g[several] ** 2])
    residue = np.zeros((len(columns), seats, seats))
    for e, (i, j) in enumerate(zip(problem.rows, problem.columns, strict=True)):
        A = (columns * problem.weight[e]).view(float).T
        size = np.linalg.norm(A, axis=0)
        solved = linalg.lstsq(A / size, (problem.H[e] * problem.weight[e]).view(float))[0] / size
        residue[:, i, j] = residue[:, j, i] = solved
    level = level_of(problem)
    residue[:m] *= level[:, None] * level
    slope = np.zeros((m, seats, seats))
    slope[several] = residue[m + 3 :] * level[:, None] * level
    inside = State(np.zeros((seats, 0)), np.zeros(0), np.zeros(0))
    for k, group in enumerate(groups):
        values = np.linalg.eigvalsh(residue[k])
        rank, plain = (int((values > part * values[-1]).sum()) for part in (RANK, PLAINLY))
        Phi, shift = repeated_modes(residue[k], slope[k], max(1, plain, min(len(group), rank)))
        # a step to first order, no longer than the poles that were found are apart
        most = 2 * own[k] ** 2 * ALIKE * zeta[k]
        omega = np.sqrt(own[k] ** 2 + np.clip(shift, -most, most))
        inside = inside.joined(State(Phi / level[:, None], omega, np.full(len(omega), zeta[k])))
    if below:
        values, vectors = np.linalg.eigh(residue[m + 2])
        Phi = vectors[:, values > 0] * np.sqrt(values[values > 0]) * low
        count = Phi.shape[1]
        inside = inside.joined(State(Phi / level[:, None], np.full(count, FREE[0] * low), np.full(count, FREE[1])))
    return inside.joined(_above(residue[m], residue[m + 1] / high**2, high, float(np.median(zeta)) if m else 0.02))


def repeated_modes(R: Array, slope: Array, few: int) -> tuple[Array, Array]:
    """The modes of a repeated pole, or of nearly repeated ones: shapes (seats, few) and shifts of omega^2 (few,).

    To first order, modes near one pole are R g + slope g^2 with R = Phi Phi' and slope = -Phi diag(shift) Phi'. Both
    are diagonal in the right combination of the largest eigenvectors of R; where the pole is a repeated one, any is.
    """
    values, vectors = np.linalg.eigh(R)
    half = vectors[:, -few:] * np.sqrt(np.maximum(values[-few:], 1e-9 * np.abs(values).max()))
    inverse = half / (half**2).sum(axis=0)
    shift, turn = np.linalg.eigh(-inverse.T @ slope @ inverse)
    return half @ turn, shift


def level_of(problem: Problem) -> Array:
    """What brings all seats to one size, (seats,) [sqrt(N/m)]: else an eigenvector sees the one that moves most."""
    return np.asarray(np.sqrt(np.median(problem.weight[problem.rows == problem.columns], axis=1)))


def _above(U: Array, V: Array, high: float, zeta: float) -> State:
    """One pseudo-mode a seat for the remainder U + V w^2: U = sum phi phi' / omega^2, V = sum phi phi' / omega^4.

    Both are diagonal in the eigenvectors of V - lambda U, with lambda = 1 / omega^2; what noise made negative is cut.
    """
    values, vectors = np.linalg.eigh(U)
    values = np.maximum(values, 1e-3 * np.abs(values).max() + np.finfo(float).tiny)
    half = vectors * np.sqrt(values)
    inverse = (vectors / np.sqrt(values)).T
    squared, turn = np.linalg.eigh(inverse @ V @ inverse.T)
    omega = 1 / np.sqrt(np.clip(squared, (20 * high) ** -2, (1.05 * high) ** -2))
    return State(half @ turn * omega, omega, np.full(len(omega), zeta))


def _checked(poles: ArrayLike) -> Complex:
    """One of each pair, ascending, or a ValueError that says what is wrong."""
    poles = np.atleast_1d(np.asarray(poles, dtype=complex))
    if poles.ndim != 1 or not len(poles) or not np.isfinite(poles).all():
        raise ValueError(f"poles has shape {poles.shape}: it must be a row of at least one finite complex number.")
    if (poles.real >= 0).any() or (poles.imag <= 0).any():
        bad = poles[(poles.real >= 0) | (poles.imag <= 0)][0]
        raise ValueError(f"One pole is {bad:.6g} rad/s: give one of each pair, with Re < 0 and Im > 0.")
    poles = poles[np.argsort(np.abs(poles))]
    apart = np.abs(np.diff(poles)) / np.abs(poles[:-1])
    if (apart < 1e-9).any():
        raise ValueError(f"The pole at {hertz(np.abs(poles[apart.argmin()])):.6g} Hz is given twice.")
    return poles
