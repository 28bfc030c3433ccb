"""How large the noise of receptances is, told by how far each line lies off the curve through its neighbours."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Lines whose median tells the noise at one place.
TOGETHER = 40

# Noise is in proportion to |H| if its part of |H| differs by less than this between the places and FRFs where it is
# small and those where it is large, a tenth of all on either side. Estimates from forty lines differ by 1.5.
PROPORTIONAL = 3.0

# Where a parabola more through the neighbours takes away more than this part, lines differ by curvature, not by noise.
CURVED = 0.5

# Noise below this part of |H| matters less than what a model lacks.
CLEAN = 1e-3


def beside_neighbours(frequency: Array, H: Complex, reach: int = 2) -> Array:
    """Squared distance of each line from the curve through `reach` neighbours on each side, (n - 2 reach, ...).

    Divided by what it is for independent errors of variance 1, so that its mean is their variance where the curve is
    smooth; for complex normal errors its median is ln 2 of that.
    """
    n, around = len(frequency), np.array([k for k in range(-reach, reach + 1) if k])
    place = np.arange(reach, n - reach)[:, None] + around
    x = frequency[place] - frequency[reach : n - reach, None]
    # Lagrange's weights at the line itself
    apart = x[:, :, None] - x[:, None, :] + np.eye(2 * reach)
    weight = np.prod(np.where(np.eye(2 * reach, dtype=bool), 1.0, -x[:, None, :] / apart), axis=2)
    each = (-1, *[1] * (H.ndim - 1))
    rest = H[reach : n - reach].copy()
    for k, step in enumerate(around):
        rest -= weight[:, k].reshape(each) * H[reach + step : n - reach + step]
    square = rest.real**2 + rest.imag**2
    return np.asarray(square / (1 + np.sum(weight**2, axis=1)).reshape(each))


def own_errors(frequency: Array, H: Complex) -> Array | None:
    """Standard deviation of each receptance on each line, (n, outputs, inputs) [m/N], if not in proportion to |H|.

    Two parts: one in proportion to |H|, the least that is seen anywhere; and one that changes slowly over frequency, in
    each FRF by itself, as the noise of an acceleration does.

    Returns
    -------
    None when the noise is in proportion to |H|, when it is too small to matter, and when the lines are too few, or too
    far apart, to tell noise from resonances.
    """
    count = (len(frequency) - 4) // TOGETHER
    if count < 4:
        return None
    square, size = beside_neighbours(frequency, H), np.abs(H[2:-2]) ** 2
    size = np.maximum(size, np.finfo(float).tiny)
    straight = beside_neighbours(frequency, H, 1)[1:-1]
    parts = np.array_split(np.arange(len(square)), count)

    def told(values: Array) -> Array:
        """Variances from squares: one for each place and FRF."""
        # the first places have a line more: two stacks of equal height
        more, height = len(values) % count, len(values) // count
        tall, low = np.split(values, [more * (height + 1)])
        tall = tall.reshape(-1, height + 1, *values.shape[1:])
        low = low.reshape(-1, height, *values.shape[1:])
        return np.concatenate([np.median(tall, axis=1), np.median(low, axis=1)]) / np.log(2)

    level, noisy = told(square / size), told(square) > CURVED * told(straight)
    if noisy.mean() < 0.5 or np.median(level[noisy]) < CLEAN**2:
        return None
    least, most = np.quantile(level[noisy], (0.1, 0.9))
    if most < PROPORTIONAL**2 * least:
        return None
    slow = np.maximum(told(square) - least * told(size) * np.log(2), 1e-6 * told(square))
    line, value = np.log(frequency), np.log(slow).reshape(count, -1)
    centre = np.array([line[2:-2][part].mean() for part in parts])
    # over the first lines and the last ones it goes on as it came
    for end, beside, edge in ((0, 1, 0), (count - 1, count - 2, -1)):
        way = (line[edge] - centre[end]) / (centre[beside] - centre[end])
        centre[end], value[end] = line[edge], value[end] + way * (value[beside] - value[end])
    over = np.array([np.interp(line, centre, column) for column in value.T])
    return np.asarray(np.sqrt(np.exp(over).T.reshape(H.shape) + least * np.abs(H) ** 2))
