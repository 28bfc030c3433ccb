"""A study of 1e5 machines: CPU time a machine, one core and two, dask.distributed, memory. Writes sweep.md.

`make bench` runs it with the others. Each way is an interpreter of its own, so that its peak of memory is its own too.
"""

import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from importlib.metadata import version
from pathlib import Path

os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")

import numpy as np
from dask.distributed import Client, LocalCluster

import rbfound as rb
from rbfound.studies import Study, results, sweep

try:
    import resource
except ImportError:  # Windows has no such count
    resource = None  # type: ignore[assignment]

WHOLE, PART, SHARED = 100, 10, 50
REPEATS = 3
CHECKED = 20


def study(speeds: int) -> Study:
    """A thousand machines at each of so many speeds: ten stiffnesses, ten dampings, ten foundations."""
    foundation = rb.thesis.unrounded_foundation()
    grounds = [
        rb.Foundation(foundation.M, foundation.C, factor * foundation.K, foundation.B)
        for factor in np.geomspace(0.5, 5, 10)
    ]
    factors = np.geomspace(0.1, 10, 10)
    return Study(
        rb.thesis.rotor(),
        rb.thesis.bearings(),
        np.linspace(0, rb.from_rpm(30000), speeds),
        grounds,
        stiffness=factors,
        damping=factors,
        limit=500.0,
    )


def ways(name: str) -> AbstractContextManager[Executor | None]:
    """The executor of this name."""
    if name == "serial":
        return nullcontext()
    if name.startswith("processes"):
        return ProcessPoolExecutor(int(name.split()[1]))
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    return Client(cluster).get_executor()


def measured(name: str, speeds: int) -> dict[str, float]:
    """One way in this interpreter: seconds, peak of memory [MB], and how far its rows are from the whole machines."""
    these = study(speeds)
    with tempfile.TemporaryDirectory() as folder, ways(name) as executor:
        wall, before = time.perf_counter(), os.times()
        sweep(these, folder, executor=executor, progress=False)
        wall = time.perf_counter() - wall
        size = sum(path.stat().st_size for path in Path(folder).iterdir())
        numbers = np.random.default_rng(0).choice(len(these), CHECKED, replace=False)
        f1 = rb.hertz(results(folder)[numbers, 0].imag)
    # behind the executor's end: what its processes took is known only then
    after = os.times()
    whole = [these.system(number).modes().above(these.above).frequency[0] for number in numbers]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024 if resource else float("nan")
    return {
        "wall": wall,
        "cpu": sum(after[:4]) - sum(before[:4]),
        "memory": peak,
        "disk": size / 1e6,
        "apart": float(np.abs(f1 / whole - 1).max()),
    }


def counting(processes: int) -> float:
    """Wall [s] of so many processes that only count, side by side."""
    with ProcessPoolExecutor(processes) as executor:
        list(executor.map(sum, [range(10)] * processes))
        start = time.perf_counter()
        list(executor.map(sum, [range(100_000_000)] * processes))
        return time.perf_counter() - start


def asked(name: str, speeds: int) -> dict[str, float]:
    """The same in an interpreter of its own."""
    command = [sys.executable, __file__, name, str(speeds)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def page() -> str:
    small, large = asked("serial", PART), asked("serial", WHOLE)
    rows = []
    runs: dict[str, list[dict[str, float]]] = {"processes 1": [], "processes 2": [], "dask.distributed, 2 workers": []}
    for _ in range(REPEATS):
        for name, row in runs.items():
            row.append(asked(name, SHARED))
    # other work only adds to a wall: the shortest is the nearest to the truth
    one = min(run["wall"] for run in runs["processes 1"])
    for name, row in runs.items():
        seconds = sorted(run["wall"] for run in row)
        told = " ".join(f"{value:.1f}" for value in seconds)
        rows.append(f"| {name} | {told} | {one / seconds[0]:.2f} |")
    alone, both = (min(counting(n) for _ in range(REPEATS)) for n in (1, 2))
    sizes = "\n".join(
        f"| {1000 * speeds} | {run['cpu']:.1f} | {run['cpu'] / speeds:.3f} | {run['memory']:.0f} | {run['disk']:.1f} "
        f"| {run['apart']:.0e} |"
        for speeds, run in ((PART, small), (WHOLE, large))
    )
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "distributed"))
    return f"""# A study of many machines

Written by `make bench` (`benchmarks/sweep.py`): do not edit by hand.

The thesis's rotor over ten factors of bearing stiffness, ten of damping, ten foundations and up to {WHOLE} speeds: all
poles up to 500 Hz, to a folder. Python {platform.python_version()}, {packages};
{os.cpu_count()} cores, which other work may share: CPU time is what counts, and walls are given run by run.

| machines | CPU [s] | CPU a machine [ms] | peak of memory [MB] | on disk [MB] | first frequency, worst of {CHECKED} |
| ---: | ---: | ---: | ---: | ---: | ---: |
{sizes}

The last column is relative to the unreduced machine, solved by itself.

The same script through executors, {1000 * SHARED} machines, {REPEATS} runs by turns:

| executor | wall [s] | speed-up of the shortest |
| --- | ---: | ---: |
{chr(10).join(rows)}

What the machine had to give meanwhile: two processes that only count were {2 * alone / both:.2f} times as fast as one.
"""


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measured(sys.argv[1], int(sys.argv[2]))))
    else:
        text = page()
        (Path(__file__).parent / "sweep.md").write_text(text, encoding="utf-8")
        print(text)
