"""Poles of all FRFs at once: poly-reference least-squares complex frequency, and its stabilisation chart.

H(z) = N(z) D(z)^-1 with matrix polynomials in z = exp(i pi (f - f0)/(f1 - f0)): the lines of the band lie on the upper
half of the unit circle, where the powers of z are nearly orthogonal, whatever their order. (Guillaume, Verboven,
Vanlanduit, Van der Auweraer and Peeters 2003; Peeters, Van der Auweraer, Guillaume and Leuridan 2004,
DOI 10.1155/2004/523692.)
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from rbfound.frf import FRF
from rbfound.parallel import one_thread
from rbfound.units import from_hertz, hertz

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# A pole is stable when the next lower order has one that differs by less than this: as a part of the frequency, as a
# part of the damping, and as a MAC of the two participation vectors.
FREQUENCY, DAMPING, PARTICIPATION = 0.01, 0.2, 0.9

# Participation vectors of length 1 span as many dimensions as they have singular values above this.
INDEPENDENT = 0.3

# Poles that are nearer to each other than this part of their damping -Re lambda are one repeated pole to the
# data: noise or rounding decides which combination of the shapes belongs to which of them.
ALIKE = 0.3

# No structure that is worth a pole is damped more than this; what is, fits the remainder.
HEAVY = 0.3


@dataclass(frozen=True, eq=False)
class Stabilisation:
    """Poles over the order of the polynomial, one row a pole.

    Attributes
    ----------
    order : (p,)
        The order of D that each pole comes from, ascending.
    poles : (p,) complex [rad/s]
        One of each pair, stable (Re < 0), within the band.
    participation : (p, inputs) complex
        Which seats drive it; length 1.
    stable_frequency, stable_damping, stable_participation : (p,) bool
        Whether the next lower order has it too.
    band : (lowest, highest) [Hz]
    """

    order: NDArray[np.intp]
    poles: Complex
    participation: Complex
    stable_frequency: NDArray[np.bool_]
    stable_damping: NDArray[np.bool_]
    stable_participation: NDArray[np.bool_]
    band: tuple[float, float]

    @property
    def orders(self) -> NDArray[np.intp]:
        """The orders that were tried, ascending."""
        return np.unique(self.order)

    @property
    def natural_frequency(self) -> Array:
        """|lambda| / 2 pi of each pole [Hz], (p,)."""
        return np.asarray(hertz(np.abs(self.poles)))

    @property
    def damping(self) -> Array:
        """Damping ratio of each pole [-], (p,)."""
        return np.asarray(-self.poles.real / np.abs(self.poles))

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Stable in frequency, damping and participation, (p,)."""
        return self.stable_frequency & self.stable_damping & self.stable_participation


def groups_of(poles: Complex, alike: float = ALIKE) -> list[NDArray[np.intp]]:
    """Indices of the poles that cannot be told from a repeated pole, group by group, ascending in frequency.

    Neighbours belong together when they are nearer than `alike` times the damping -Re lambda of the lighter one.
    """
    order = np.argsort(np.abs(poles))
    if not len(order):
        return []
    damping, apart = -poles.real[order], np.abs(np.diff(poles[order]))
    ends = np.flatnonzero(apart >= alike * np.minimum(damping[1:], damping[:-1])) + 1
    return np.split(order, ends)


@one_thread
def stabilisation(
    frf: FRF, orders: Iterable[int] | None = None, band: tuple[float, float] | None = None
) -> Stabilisation:
    """Poles of the FRFs for a range of orders of the denominator.

    Parameters
    ----------
    frf : FRF
    orders : orders of D, at least two
        An order p has room for p * seats / 2 modes. Unless given, from 4 to 20, or to what the lines allow.
    band : (lowest, highest) [Hz]
        Unless given, all lines but those at 0 Hz.

    Raises
    ------
    ValueError
        When the band lies outside the data, has too few lines for the orders, or an order is below 1.
    """
    part, band = lines_in(frf, band)
    most = largest_order(len(part.frequency), len(frf.labels))
    tried = sorted({int(p) for p in (range(min(4, max(most - 1, 1)), min(20, most) + 1) if orders is None else orders)})
    if len(tried) < 2 or tried[0] < 1:
        raise ValueError(
            f"orders are {tried}: give at least two, each at least 1; {len(part.frequency)} lines allow {most}."
        )
    if tried[-1] > most:
        raise ValueError(
            f"Order {tried[-1]} is too high: {len(part.frequency)} lines from {band[0]:g} to {band[1]:g} Hz "
            f"and {len(frf.labels)} seats allow {most}."
        )
    rows = []
    before: tuple[Complex, Complex] | None = None
    for order, D in zip(tried, _denominators(part, tried), strict=True):
        poles, participation = _poles(D, part.frequency[0], part.frequency[-1])
        rows.append((np.full(len(poles), order), poles, participation, *_agreement(poles, participation, before)))
        before = (poles, participation)
    several, lambdas, drive, frequency, damping, shape = (np.concatenate(c) for c in zip(*rows, strict=True))
    return Stabilisation(several, lambdas, drive, frequency, damping, shape, band)


def stable_poles(chart: Stabilisation, share: float = 0.4) -> tuple[Complex, Complex]:
    """Clusters of stable poles: (poles (m,) complex [rad/s], participation (m, inputs) complex), ascending.

    A cluster is a chain of stable poles, at most one from each order, alike in frequency and participation. It counts
    when it holds that share of the orders. The pole nearest to the median of its later half stands for it.

    Raises
    ------
    ValueError
        When no cluster is long enough.
    """
    chains = _chains(chart)
    needed = max(2, int(np.ceil(share * (len(chart.orders) - 1))))
    kept = [chain for chain in chains if len(chain) >= needed]
    if not kept:
        longest = max((len(chain) for chain in chains), default=0)
        raise ValueError(
            f"No stable pole between {chart.band[0]:g} and {chart.band[1]:g} Hz: the longest cluster holds {longest} "
            f"of {len(chart.orders)} orders, {needed} are needed. Try other orders, a narrower band or finer lines."
        )
    chosen = []
    for chain in kept:
        # the upper half of the orders: low ones are biased by what they have no room for
        late = np.array(chain[len(chain) // 2 :])
        middle = np.median(chart.poles[late].real) + 1j * np.median(chart.poles[late].imag)
        chosen.append(late[np.abs(chart.poles[late] - middle).argmin()])
    chosen = sorted(chosen, key=lambda k: abs(chart.poles[k]))
    return chart.poles[chosen], chart.participation[chosen]


def lines_in(frf: FRF, band: tuple[float, float] | None) -> tuple[FRF, tuple[float, float]]:
    """The lines of a band, without 0 Hz, and the band itself; the whole of the data when it is None."""
    positive = frf.frequency[frf.frequency > 0]
    if not len(positive):
        raise ValueError("The FRFs have no line above 0 Hz.")
    low, high = (float(positive[0]), float(positive[-1])) if band is None else (float(band[0]), float(band[1]))
    if not 0 <= low < high:
        raise ValueError(f"The band from {low:g} to {high:g} Hz is none: it must start at 0 or above and end higher.")
    if low > positive[-1] or high < positive[0]:
        raise ValueError(
            f"The band from {low:g} to {high:g} Hz lies outside the FRFs, which reach from {frf.frequency[0]:g} to "
            f"{frf.frequency[-1]:g} Hz."
        )
    return frf.between(max(low, float(positive[0])), high), (low, high)


def largest_order(lines: int, seats: int) -> int:
    """The highest order of D that leaves twice as many equations as unknowns."""
    return max(int(lines / (1 + seats)) - 1, 0)


def _denominators(frf: FRF, orders: list[int]) -> list[Array]:
    """D_0 ... D_p for each order p, (p + 1, inputs, inputs) with D_p = I; real, from reduced normal equations.

    Of each response row o, N_o - H_o D = 0, weighted by 1/|H_o|. On the unit circle every product of two powers of z is
    a power again, so all normal matrices are block Toeplitz; and of lower orders they are leading blocks.
    """
    H = frf.H
    n, outputs, inputs = H.shape
    top = orders[-1] + 1
    f = frf.frequency
    z = np.exp(1j * np.pi * (f - f[0]) / (f[-1] - f[0]))
    powers = z[:, None] ** np.arange(top)
    lag = np.arange(top)[None, :] - np.arange(top)[:, None]
    normal, halves = np.zeros((top, inputs, top, inputs)), []
    size = np.linalg.norm(H, axis=2)
    weight = 1 / np.maximum(size, 1e-6 * size.max()) ** 2
    for o in range(outputs):
        row, w = H[:, o, :], weight[:, o]
        quadratic = (row.conj()[:, :, None] * row[:, None, :] * w[:, None, None]).reshape(n, -1)
        # sums of z^d times each: the negative lags are those of the conjugates
        R, S, S_back, T, T_back = (
            np.real(powers.T @ column)
            for column in (w[:, None], row * w[:, None], (row * w[:, None]).conj(), quadratic, quadratic.conj())
        )
        R = R[np.abs(lag), 0]
        S = np.where(lag[:, :, None] >= 0, S[np.abs(lag)], S_back[np.abs(lag)])
        T = np.where(lag[:, :, None] >= 0, T[np.abs(lag)], T_back[np.abs(lag)]).reshape(top, top, inputs, inputs)
        factor = linalg.cholesky(R + 1e-13 * R[0, 0] * np.eye(top), lower=True)
        halves.append(linalg.solve_triangular(factor, S.reshape(top, top * inputs), lower=True))
        normal += T.transpose(0, 2, 1, 3)
    out = []
    for order in orders:
        q = order + 1
        M = normal[:q, :, :q, :].reshape(q * inputs, q * inputs).copy()
        for half in halves:
            block = half[:q, : q * inputs]
            M -= block.T @ block
        last = order * inputs
        solved = linalg.cho_solve(_factor(M[:last, :last]), M[:last, last:])
        out.append(np.concatenate([-solved, np.eye(inputs)]).reshape(q, inputs, inputs))
    return out


def _factor(M: Array) -> tuple[Array, bool]:
    """Cholesky factor; of data without noise the matrix of a high order is singular, and what is added is rounding."""
    for part in (1e-14, 1e-12, 1e-10):
        try:
            return linalg.cho_factor(M + part * np.trace(M) / len(M) * np.eye(len(M)), lower=True)
        except linalg.LinAlgError:
            continue
    raise ValueError("The FRFs are so much alike that no polynomial can be told: are they all the same?")


def _poles(D: Array, low: float, high: float) -> tuple[Complex, Complex]:
    """Poles in the band [Hz], from the companion matrix, and their participation vectors u, for which u D(z) = 0."""
    order, inputs = len(D) - 1, D.shape[1]
    companion = np.zeros((order * inputs, order * inputs))
    companion[:-inputs, inputs:] = np.eye((order - 1) * inputs)
    companion[-inputs:] = -np.concatenate(D[:-1].transpose(0, 2, 1), axis=1)
    values = linalg.eigvals(companion, overwrite_a=True)
    values = np.where(values == 0, np.finfo(float).tiny, values)
    step = np.pi / from_hertz(high - low)
    poles = np.log(values) / step + 1j * from_hertz(low)
    size = np.abs(poles)
    keep = (values.imag > 0) & (poles.real < 0) & (-poles.real < HEAVY * size)
    order_of = np.flatnonzero(keep)[np.argsort(size[keep])]
    # the companion matrix has these vectors, too, but all of them, and that takes as long as the poles
    at = np.tensordot(values[order_of, None] ** np.arange(order + 1), D, 1)
    vectors = np.linalg.svd(at)[0].conj()
    participation = vectors[:, :, -1]
    for group in groups_of(poles[order_of]):
        few = min(len(group), inputs)
        # a repeated pole has a space of them: of each of its poles comes any one, of two perhaps the same
        if np.linalg.svd(participation[group], compute_uv=False)[few - 1] < INDEPENDENT:
            participation[group[:few]] = vectors[group[0], :, -few:].T
    return poles[order_of], participation


def _spaces(poles: Complex, participation: Complex) -> list[Complex]:
    """Of each pole orthonormal rows (g, inputs) that span the vectors of all poles it cannot be told from."""
    spaces = [vector[None] for vector in participation]
    for group in groups_of(poles):
        if len(group) > 1:
            _, size, rows = np.linalg.svd(participation[group], full_matrices=False)
            for k in group:
                spaces[k] = rows[size > INDEPENDENT]
    return spaces


def _likeness(vector: Complex, space: Complex) -> float:
    """MAC of a participation vector (inputs,) and the nearest one in a space (g, inputs) of orthonormal ones."""
    return float(np.sum(np.abs(space.conj() @ vector) ** 2))


def _agreement(
    poles: Complex, participation: Complex, before: tuple[Complex, Complex] | None
) -> tuple[NDArray[np.bool_], ...]:
    """Stable in frequency, damping, participation, of each pole against those of the next lower order."""
    flags = np.zeros((3, len(poles)), dtype=bool)
    if before is None or not len(before[0]) or not len(poles):
        return tuple(flags)
    nearest = np.abs(poles[:, None] - before[0][None, :]).argmin(axis=1)
    old = before[0][nearest]
    flags[0] = np.abs(np.abs(poles) - np.abs(old)) < FREQUENCY * np.abs(poles)
    zeta, was = -poles.real / np.abs(poles), -old.real / np.abs(old)
    flags[1] = np.abs(zeta - was) < DAMPING * zeta
    spaces = _spaces(*before)
    flags[2] = [_likeness(u, spaces[k]) > PARTICIPATION for u, k in zip(participation, nearest, strict=True)]
    return tuple(flags)


def _chains(chart: Stabilisation) -> list[list[int]]:
    """Stable poles joined from order to order; a chain may skip one order."""
    chains: list[list[int]] = []
    orders = list(chart.orders)
    spaces = [
        space
        for order in orders
        for space in _spaces(chart.poles[chart.order == order], chart.participation[chart.order == order])
    ]
    for position, order in enumerate(orders):
        taken: set[int] = set()
        for k in np.flatnonzero((chart.order == order) & chart.stable):
            ends = [
                (abs(chart.poles[k] - chart.poles[chain[-1]]), c)
                for c, chain in enumerate(chains)
                if c not in taken
                and position - orders.index(chart.order[chain[-1]]) <= 3
                and _same(chart, int(k), chain[-1], spaces)
            ]
            if ends:
                chains[min(ends)[1]].append(int(k))
                taken.add(min(ends)[1])
            else:
                chains.append([int(k)])
                taken.add(len(chains) - 1)
    return chains


def _same(chart: Stabilisation, a: int, b: int, spaces: list[Complex]) -> bool:
    close = abs(chart.natural_frequency[a] - chart.natural_frequency[b]) < FREQUENCY * chart.natural_frequency[a]
    return bool(close and _likeness(chart.participation[a], spaces[b]) > PARTICIPATION)
