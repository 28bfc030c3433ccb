"""What is used most, timed over our own history: `make speed`, and `make speed AT=commit` for how it was then."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rbfound as rb
from rbfound.geometry import COARSE
from rbfound.solid import foundation_solid, natural_modes

SPEEDS = np.linspace(0.0, 1000.0, 50)
LINES = np.linspace(1.0, 1000.0, 500)
MEASURED = Path(__file__).parents[1] / "data" / "foundation" / "fine"

Timed = Callable[[Callable[[Any], Any], Callable[[], Any]], Any]


@pytest.fixture
def timed(benchmark: Any) -> Timed:
    """Run something on a fresh argument each time, so that nothing kept from before helps."""
    return lambda work, fresh: benchmark.pedantic(work, setup=lambda: ((fresh(),), {}), rounds=5, warmup_rounds=1)


def machine() -> rb.Machine:
    rotor = rb.Rotor(rb.Shaft([1.0], [0.05]), {0.5: rb.Disk(20.0, 0.05, 0.1)}, element=1 / 40)
    bearing = rb.Bearing(1e7, 2e7, cxx=1e3, cyy=1e3)
    return rb.mount(rotor, {0.0: bearing, 1.0: bearing})


def test_campbell_diagram_of_fifty_speeds(timed: Timed) -> None:
    timed(lambda m: rb.campbell(m, SPEEDS, count=10), machine)


def test_unbalance_response_of_five_hundred_lines(timed: Timed) -> None:
    timed(lambda m: rb.unbalance_response(m, LINES, {0.5: 1e-4}), machine)


def test_identification_of_the_foundation(timed: Timed) -> None:
    timed(rb.identify, lambda: rb.load_frf(MEASURED))


def test_modes_of_the_coarse_solid(timed: Timed) -> None:
    timed(lambda solid: natural_modes(solid, 12), lambda: foundation_solid(grid=COARSE))
