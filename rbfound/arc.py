"""A circle through points of the complex plane, by algebra."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Complex = NDArray[np.complex128]


def kasa(points: ArrayLike) -> tuple[complex, float]:
    """Centre and radius of a circle through complex points, by linear least squares of |z - centre|^2 - radius^2.

    Noise on a short arc makes it too small. (Kasa 1976, DOI 10.1109/TIM.1976.6312298.)
    """
    z, origin, size = _centred(points)
    A = np.column_stack([2 * z.real, 2 * z.imag, np.ones(len(z))])
    a, b, c = np.linalg.lstsq(A, np.abs(z) ** 2, rcond=None)[0]
    return origin + size * complex(a, b), float(size * np.sqrt(c + a**2 + b**2))


def taubin(points: ArrayLike) -> tuple[complex, float]:
    """Centre and radius of a circle through complex points, by Taubin's algebraic fit.

    The same distances as `kasa`, over their mean gradient: large circles are no longer dear, and little of the bias
    is left. (Taubin 1991, DOI 10.1109/34.103273.)
    """
    z, origin, size = _centred(points)
    square = np.abs(z) ** 2
    mean = square.mean()
    # a |z|^2 + b x + c y - a mean = 0; with the first column scaled, the constraint is that the vector has length 1
    A = np.column_stack([(square - mean) / (2 * np.sqrt(mean)), z.real, z.imag])
    a, b, c = np.linalg.svd(A, full_matrices=False)[2][-1]
    a /= 2 * np.sqrt(mean)
    if abs(a) < 1e-12:
        raise ValueError("The points lie on a straight line: there is no circle through them.")
    centre = complex(-b, -c) / (2 * a)
    return origin + size * centre, float(size * np.sqrt(abs(centre) ** 2 + mean))


def _centred(points: ArrayLike) -> tuple[Complex, complex, float]:
    """Points about their centroid, in units of their mean distance from it: mobilities are small numbers."""
    z = np.asarray(points, dtype=complex).ravel()
    if len(z) < 3:
        raise ValueError(f"{len(z)} points are given: a circle needs three.")
    origin = complex(z.mean())
    size = float(np.abs(z - origin).mean())
    if not size > 0:
        raise ValueError("All points are one: there is no circle through them.")
    return (z - origin) / size, origin, size
