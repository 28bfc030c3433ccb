"""Second-order linear systems: M q'' + (C + G) q' + K q = f, their modes and their receptance.

Everything in rbfound ends here: a foundation, a rotor at one speed, a rotor on its foundation.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from rbfound.parallel import one_thread
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# A pole smaller than this part of the largest one is the rounding of a zero: eigenvalues of K carry an error of
# eps * max(lambda^2), so poles of sqrt(eps) * max|lambda|; a factor of seven above that is safe.
ZERO_POLE = 1e-7
# What is taken for zero so must not be a mode above this frequency [Hz].
LOST = 1.0
# Where even a mode of this frequency [Hz] would be taken for zero, its shape is rounding too and tells nothing.
HOPELESS = 1e5


@dataclass(frozen=True, eq=False)
class Modes:
    """Damped modes, sorted by damped frequency and then by damping.

    Attributes
    ----------
    poles : (m,) complex [rad/s]
        One of each conjugate pair (Im >= 0). A rigid-body mode is one zero; each real pole of an overdamped
        mode stands alone, with frequency 0.
    shapes : (n, m) complex
        Displacements, largest entry 1.
    """

    poles: Complex
    shapes: Complex

    @property
    def frequency(self) -> Array:
        """Damped natural frequencies |Im lambda| / 2 pi [Hz], (m,)."""
        return np.asarray(hertz(np.abs(self.poles.imag)))

    @property
    def damping(self) -> Array:
        """Damping ratios -Re lambda / |lambda| [-], (m,); negative is unstable, 0 for a rigid-body mode."""
        size = np.abs(self.poles)
        return -self.poles.real / np.where(size > 0, size, 1.0)

    def above(self, frequency: float) -> "Modes":
        """The modes above a frequency [Hz]: without rigid-body and overdamped ones, for instance."""
        return self._only(self.frequency > frequency)

    def below(self, frequency: float) -> "Modes":
        """The modes up to a frequency [Hz]."""
        return self._only(self.frequency <= frequency)

    def whirl(self, planes: tuple[NDArray[np.intp], NDArray[np.intp]] | None) -> Array:
        """Direction of whirl along a shaft, from 1 (circles from X to Y) to -1, (m,); nan without a shaft.

        The turning sense of each node's orbit, -2 Im(conj(x) y), over the sum of |x|^2 + |y|^2.
        """
        if planes is None:
            return np.full(len(self.poles), np.nan)
        x, y = (self.shapes[plane] for plane in planes)
        size = (np.abs(x) ** 2 + np.abs(y) ** 2).sum(axis=0)
        return np.asarray(-2 * np.imag(x.conj() * y).sum(axis=0) / np.where(size > 0, size, 1.0))

    def _only(self, keep: NDArray[np.bool_]) -> "Modes":
        return Modes(self.poles[keep], self.shapes[:, keep])


@dataclass(frozen=True, eq=False)
class System:
    """A second-order system M q'' + (C + G) q' + K q = f (equations 7, 50-52).

    Attributes
    ----------
    M, C, K : (n, n)
        Mass, damping and stiffness. M must be positive definite.
    G : (n, n)
        Gyroscopic matrix, already multiplied by the spin speed; zero unless given.
    planes : pair of index arrays, optional
        Which coordinates are the x and which the y displacements along a shaft, for the whirl's direction.
    """

    M: Array
    C: Array
    K: Array
    G: Array = field(default_factory=lambda: np.zeros((0, 0)))
    planes: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None

    def __post_init__(self) -> None:
        n = np.shape(self.M)[0] if np.ndim(self.M) == 2 else -1
        if np.size(self.G) == 0:
            object.__setattr__(self, "G", np.zeros((max(n, 0), max(n, 0))))
        for name in "MCKG":
            matrix = np.asarray(getattr(self, name), dtype=float)
            if matrix.shape != (n, n):
                raise ValueError(f"{name} has shape {matrix.shape}: M, C, K and G must be square and of one size.")
            if not np.isfinite(matrix).all():
                row, column = np.argwhere(~np.isfinite(matrix))[0]
                raise ValueError(f"{name}[{row}, {column}] is {matrix[row, column]}: every entry must be finite.")
            object.__setattr__(self, name, matrix)

    def state_matrix(self) -> tuple[Array, Array]:
        """The real state matrix A of (y, y') with y = Lᵀ q, M = L Lᵀ, and L itself.

        One Cholesky factor of M serves both blocks, and a symmetric K stays symmetric in A.
        """
        L = _cholesky(self.M)
        half = [linalg.solve_triangular(L, matrix, lower=True) for matrix in (self.K, self.C + self.G)]
        stiffness, damping = (linalg.solve_triangular(L, matrix.T, lower=True).T for matrix in half)
        n = len(L)
        return np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]]), L

    @one_thread
    def modes(self) -> Modes:
        """All damped modes, from the eigenvalues of the real state matrix; see `Modes` for what is returned.

        Raises
        ------
        ValueError
            When M is not positive definite, or when stiffness or damping reach over so many orders of magnitude that
            modes above 1 Hz drown in rounding.
        """
        A, L = self.state_matrix()
        n = len(L)
        if n == 0:
            return Modes(np.zeros(0, complex), np.zeros((0, 0), complex))
        # time in units of the fastest mode, so that both halves of the state have one size
        rate = np.sqrt(linalg.norm(A[n:, :n], np.inf)) or 1.0
        A[n:, :n] /= rate**2
        A[n:, n:] /= rate
        poles, vectors = linalg.eig(A)
        poles = poles * rate
        shapes = linalg.solve_triangular(L.T, vectors[:n])
        smallest = ZERO_POLE * np.abs(poles).max()
        poles[np.abs(poles) <= smallest] = 0
        kept = np.flatnonzero((poles != 0) & (poles.imag >= 0))
        rigid = self._rigid_shapes(A[n:, :n], L, most=int((poles == 0).sum()))
        if hertz(smallest) > LOST:
            self._check_rigid(rigid, int((poles == 0).sum()), float(hertz(smallest)))
        poles = np.concatenate([np.zeros(rigid.shape[1]), poles[kept]])
        shapes = np.concatenate([rigid, shapes[:, kept]], axis=1)
        return in_order(poles, shapes)

    def growth(self, pole: complex) -> float:
        """How fast the mode near a pole grows, Re lambda [rad/s], from the energy of its shape x.

        lambda solves lambda^2 x^H M x + lambda x^H (C + G) x + x^H K x = 0. The symmetric parts of C and K give real
        numbers there and the skew ones imaginary numbers, whatever x is rounded to: where C is skew and K symmetric,
        the answer is 0 and not a rounding of it.
        """
        turned = self.C + self.G
        D = pole**2 * self.M + pole * turned + self.K
        # beside the pole by less than the shape shows
        D = D + 1e-12 * np.diag(np.abs(D).max(axis=1))
        x = np.random.default_rng(0).standard_normal(len(D)) + 0j
        for _ in range(3):
            x = np.linalg.solve(D, x / linalg.norm(x))
        x = x / linalg.norm(x)

        def energy(A: Array) -> complex:
            return complex((x.conj() @ (A + A.T) @ x).real / 2, (x.conj() @ (A - A.T) @ x).imag / 2)

        m, c, k = energy(self.M).real, energy(turned), energy(self.K)
        root = np.sqrt(c * c - 4 * m * k)
        roots = np.array([-c + root, -c - root]) / (2 * m)
        return float(roots[np.abs(roots - pole).argmin()].real)

    @staticmethod
    def _rigid_shapes(stiffness: Array, L: Array, most: int) -> Array:
        """Shapes that no spring feels, (n, r). Eigenvectors of a double zero come in equal pairs: no use here."""
        if most == 0:
            return np.zeros((len(L), 0))
        _, sizes, rows = linalg.svd(stiffness)
        free = sizes <= ZERO_POLE**2 * max(sizes[0], 1e-300)
        return np.asarray(linalg.solve_triangular(L.T, rows[free][:most].T))

    def _check_rigid(self, rigid: Array, zeros: int, below: float) -> None:
        """Raise a ValueError unless the poles taken for zero are those of shapes (n, r) that no spring feels."""
        largest = np.abs(self.K).max() or 1.0
        K, size = self.K / largest, np.abs(rigid)
        # the shapes have a mass of one, so that the energy is Rayleigh's quotient, the omega^2 of what moves so. Sums
        # of many products, of entries that are rounded themselves, miss it by some dozens of eps
        energy = np.abs(np.einsum("nr,nm,mr->r", rigid, K, rigid))
        rounding = 1e2 * np.finfo(float).eps * np.einsum("nr,nm,mr->r", size, np.abs(K), size)
        felt = energy + rounding > float(from_hertz(LOST)) ** 2 / largest
        # a rigid shape has two poles at zero, or one if it is damped
        if below > HOPELESS or zeros > 2 * rigid.shape[1] or felt.any():
            raise ValueError(
                f"Stiffness and damping reach over too many orders of magnitude: modes below {below:.2g} Hz drown in "
                f"rounding. The largest entry of K is {np.abs(self.K).max():.2g}, of C {np.abs(self.C).max():.2g}: "
                "a bearing of 1e12 N/m is as good as rigid, a segment under a hundredth of the shaft's diameter is "
                "better left out."
            )

    @one_thread
    def receptance(self, frequency: ArrayLike, outputs: Array | None = None, inputs: Array | None = None) -> Complex:
        """Displacement for a unit force, H = outputs (K + i omega (C + G) - omega^2 M)^-1 inputs.

        Solved line by line, never inverted (equations 11-14, 44-46).

        Parameters
        ----------
        frequency : (f,) [Hz]
        outputs : (o, n), optional
            Rows that pick the displacements; every coordinate unless given.
        inputs : (n, i), optional
            Columns that place the forces; every coordinate unless given.

        Returns
        -------
        (f, o, i) complex [m/N]
        """
        n = len(self.M)
        outputs = np.eye(n) if outputs is None else np.asarray(outputs, dtype=float)
        inputs = np.eye(n) if inputs is None else np.asarray(inputs, dtype=float)
        omega = np.atleast_1d(from_hertz(frequency)).astype(float)
        H = np.empty((len(omega), len(outputs), inputs.shape[1]), dtype=complex)
        for line, w in enumerate(omega):
            H[line] = outputs @ self.solve(float(w), inputs)
        return H

    def solve(self, omega: float, force: Array | Complex) -> Complex:
        """Displacements under harmonic forces of one circular frequency [rad/s]: (n,) or (n, i), as the forces."""
        stiffness = self.K - omega**2 * self.M + 1j * omega * (self.C + self.G)
        try:
            # at rest no inertia hides that a body is free: its K is singular but for rounding
            if omega == 0 and np.any(force) and _singular(self.K):
                raise np.linalg.LinAlgError
            return np.asarray(np.linalg.solve(stiffness, force), dtype=complex)
        except np.linalg.LinAlgError:
            raise ValueError(
                f"The system is singular at {hertz(omega):g} Hz: an undamped or rigid-body mode lies there. "
                "Add damping or leave the line out."
            ) from None


def in_order(poles: Complex, shapes: Complex) -> Modes:
    """Poles (m,) and shapes (n, m) as modes: sorted, and the largest entry of each shape 1."""
    damping = -poles.real / np.maximum(np.abs(poles), np.finfo(float).tiny)
    order = np.lexsort((damping, poles.imag))
    return Modes(poles[order], _largest_entry_one(shapes[:, order]))


def mac(A: ArrayLike, B: ArrayLike) -> Array:
    """Modal assurance criterion between the columns of A (n, a) and B (n, b): (a, b), 1 for parallel shapes."""
    A, B = np.atleast_2d(np.asarray(A)), np.atleast_2d(np.asarray(B))
    overlap = np.abs(A.conj().T @ B) ** 2
    size = np.outer((np.abs(A) ** 2).sum(axis=0), (np.abs(B) ** 2).sum(axis=0))
    return np.asarray(overlap / np.where(size > 0, size, 1.0))


def _cholesky(M: Array) -> Array:
    scale = np.abs(M).max(initial=0.0)
    if np.abs(M - M.T).max(initial=0.0) > 1e-9 * scale:
        raise ValueError("M is not symmetric: a mass matrix must equal its transpose.")
    try:
        return np.asarray(linalg.cholesky((M + M.T) / 2, lower=True))
    except linalg.LinAlgError:
        smallest = linalg.eigvalsh(M)[0]
        raise ValueError(
            f"M is not positive definite: its smallest eigenvalue is {smallest:.3g}, its largest entry {scale:.3g}. "
            "Every coordinate needs some mass."
        ) from None


def _singular(K: Array) -> bool:
    """Whether K is singular but for rounding, each coordinate in its own unit."""
    size = np.sqrt(np.maximum(np.abs(K).max(axis=1, initial=0.0), np.finfo(float).tiny))
    scaled = K / np.outer(size, size)
    factor, _, failed = linalg.lapack.dgetrf(scaled)
    # each entry is a sum of some terms that are rounded themselves
    return bool(failed or linalg.lapack.dgecon(factor, linalg.norm(scaled, 1))[0] <= 20 * np.finfo(float).eps)


def _largest_entry_one(shapes: Complex) -> Complex:
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]
    return np.asarray(shapes / largest)
