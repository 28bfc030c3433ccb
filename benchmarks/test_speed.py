"""What is used most, timed over our own history: `make speed`, and `make speed AT=commit` for how it was then."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rbfound as rb
from rbfound import measurement
from rbfound.measurement import spectra
from rbfound.solid import COARSE, foundation_solid, natural_modes, reduce

SPEEDS = np.linspace(0.0, 1000.0, 50)
LINES = np.linspace(1.0, 1000.0, 500)
DATA = Path(__file__).parents[1] / "data" / "foundation"
MEASURED, TRUTH = DATA / "fine", DATA / "truth.npz"

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


def test_mesh_to_receptances_of_the_working_solid(timed: Timed) -> None:
    timed(lambda lines: reduce(foundation_solid()).frf(lines), lambda: np.arange(0.5, 1000.5, 0.5))


def test_sixteen_frfs_measured_by_a_shaker(timed: Timed) -> None:
    sensors = measurement.Sensors(force_noise=0.1, response_noise=1e-3)
    timed(
        lambda truth: spectra(measurement.shaker(truth, "random", sensors, seed=4), hann=True).h1(),
        lambda: rb.load_foundation(TRUTH),
    )


def test_a_text_file_of_two_hundred_thousand_lines(timed: Timed, tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    pairs = [f"{i} from {j} {part} [m]" for i in ("x1", "y1") for j in ("x1", "y1") for part in ("re", "im")]
    rows = (f"{k},1e-9,-2e-9,1e-9,-2e-9,1e-9,-2e-9,1e-9,-2e-9" for k in range(1, 200_001))
    path.write_text("\n".join([",".join(["frequency [Hz]", *pairs]), *rows]))
    timed(rb.load_frf, lambda: path)
