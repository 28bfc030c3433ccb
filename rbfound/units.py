"""Hertz, revolutions per minute and radians per second: the only place with a 2 pi or a 60.

Inside rbfound every circular frequency and every spin speed is in rad/s.
These four functions stand at the two ends of a computation.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def hertz(omega: ArrayLike) -> Any:
    """Frequency [Hz] of a circular frequency [rad/s]."""
    return np.asarray(omega)[()] / (2 * np.pi)


def radians(frequency: ArrayLike) -> Any:
    """Circular frequency [rad/s] of a frequency [Hz]."""
    return np.asarray(frequency)[()] * (2 * np.pi)


def rpm(speed: ArrayLike) -> Any:
    """Revolutions per minute of a spin speed [rad/s]."""
    return hertz(speed) * 60


def from_rpm(revolutions: ArrayLike) -> Any:
    """Spin speed [rad/s] of revolutions per minute."""
    return radians(np.asarray(revolutions)[()] / 60)
