"""A rotor in its bearings beside ROSS: equal answers, what they cost, and how the cost grows with the elements.

`make bench` installs ROSS into an environment of its own, runs this script and writes rotor.md. Both build the same
machine of the same elements (Timoshenko, consistent mass with rotary inertia, gyroscopic), on one BLAS thread.
"""

import contextlib
import io
import os
import platform
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

# before numpy is loaded
os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", NUMBA_NUM_THREADS="1")

import numpy as np
from scipy import linalg

# ROSS prints what it does not find
with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()), warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import ross

from importlib.metadata import version

import rbfound as rb

SPEEDS = np.linspace(0.0, 1000.0, 50)
LINES = np.linspace(1.0, 1000.0, 500)
# Lateral modes; those along and about the shaft that ROSS finds among them.
COUNT, OTHERS = 10, 4
# Elements; repeats of ours and of ROSS; speeds and lines that ROSS is given, scaled up to all.
CASES = ((40, 5, 3, 50, 500), (400, 3, 1, 2, 3))
SIZES = (10, 20, 40, 100, 200, 400, 800)
DENSE = 200
LATERAL_SPEED = 500.0
UNBALANCE = 1e-4


def ours(elements: int) -> rb.Machine:
    disks = {0.25: rb.Disk(10.0, 0.02, 0.04), 0.5: rb.Disk(20.0, 0.05, 0.1)}
    rotor = rb.Rotor(rb.Shaft([1.0], [0.05]), disks, element=1.0 / elements)
    bearing = rb.Bearing(1e7, 2e7, cxx=1e3, cyy=1e3)
    return rb.mount(rotor, {0.0: bearing, 1.0: bearing})


def theirs(elements: int) -> Any:
    # its modes are kept from call to call: a fresh one each time
    steel = ross.Material("steel", rho=7850, E=2.1e11, Poisson=0.3)
    shaft = [ross.ShaftElement(1.0 / elements, 0.0, 0.05, material=steel, shear_effects=True) for _ in range(elements)]
    disks = [
        ross.DiskElement(n=elements // 4, m=10.0, Id=0.02, Ip=0.04),
        ross.DiskElement(n=elements // 2, m=20.0, Id=0.05, Ip=0.1),
    ]
    bearings = [ross.BearingElement(n=n, kxx=1e7, kyy=2e7, cxx=1e3, cyy=1e3) for n in (0, elements)]
    return ross.Rotor(shaft, disks, bearings)


def cpu(work: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def median(repeats: int, prepare: Callable[[], Any], work: Callable[[Any], Any]) -> tuple[float, Any]:
    """Median CPU time of what is done to something fresh, and the last answer."""
    spent, answer = [], None
    for _ in range(repeats):
        fresh = prepare()
        seconds, answer = cpu(lambda fresh=fresh: work(fresh))
        spent.append(seconds)
    return float(np.median(spent)), answer


def response(machine: rb.Machine) -> Any:
    return rb.unbalance_response(machine, LINES, {0.5: UNBALANCE})


def critical(machine: rb.Machine) -> Any:
    return rb.campbell(machine, SPEEDS, count=COUNT).critical_speeds()


def compare(elements: int, own: int, other: int, speeds: int, lines: int) -> tuple[list[list[str]], float, float]:
    """Rows of the table, and how far frequencies and responses are apart, relative."""
    few_speeds, few_lines = SPEEDS[:: len(SPEEDS) // speeds][:speeds], LINES[:: len(LINES) // lines][:lines]
    fresh = lambda: ours(elements)  # noqa: E731
    build, _ = median(own, lambda: None, lambda _: fresh())
    modes, _ = median(own, fresh, lambda m: rb.campbell(m, [LATERAL_SPEED], count=COUNT))
    sweep, _ = median(own, fresh, lambda m: rb.campbell(m, SPEEDS, count=COUNT))
    crossed, _ = median(own, fresh, critical)
    forced, answer = median(own, fresh, response)

    other_fresh = lambda: theirs(elements)  # noqa: E731
    their_build, _ = median(other, lambda: None, lambda _: other_fresh())
    their_modes, _ = median(other, other_fresh, lambda r: r.run_modal(LATERAL_SPEED))
    their_sweep, their_diagram = median(
        other, other_fresh, lambda r: r.run_campbell(few_speeds, frequencies=COUNT + OTHERS)
    )
    their_sweep *= len(SPEEDS) / len(few_speeds)
    their_crossed = median(other, other_fresh, lambda r: r.run_critical_speed())[0] if elements < 100 else np.nan
    their_forced, their_answer = median(
        other, other_fresh, lambda r: r.run_unbalance_response(elements // 2, UNBALANCE, 0.0, frequency=few_lines)
    )
    their_forced *= len(LINES) / len(few_lines)

    mine = rb.campbell(fresh(), few_speeds, count=COUNT).poles.imag
    frequency = max(
        float(np.abs(row / w - 1).min()) for row, ours_ in zip(their_diagram.wd, mine, strict=True) for w in ours_
    )
    x = answer[:: len(LINES) // lines][:lines, 4 * (elements // 2)]
    # its node has six coordinates, x first
    theirs_x = np.asarray(their_answer.forced_resp)[6 * (elements // 2)]
    off = float(np.abs(np.abs(theirs_x) - np.abs(x)).max() / np.abs(x).max())
    rows = []
    for name, mine_s, their_s in (
        ("build", build, their_build),
        (f"modes at {LATERAL_SPEED:g} rad/s", modes, their_modes),
        (f"Campbell diagram, {len(SPEEDS)} speeds", sweep, their_sweep),
        ("critical speeds, sweep included", crossed, their_crossed),
        (f"unbalance response, {len(LINES)} lines", forced, their_forced),
    ):
        ratio = f"{their_s / mine_s:.0f}" if np.isfinite(their_s) else "-"
        rows.append([str(elements), name, f"{mine_s:.3f}", f"{their_s:.2f}" if np.isfinite(their_s) else "-", ratio])
        print(*rows[-1], sep=" | ", flush=True)
    print(f"{frequency:.1e} {off:.1e}", flush=True)
    return rows, frequency, off


def growth() -> list[list[str]]:
    """CPU time against elements; beside it LAPACK alone, on the dense state matrix of one speed."""
    rows, known = [], []
    for elements in SIZES:
        fresh = lambda elements=elements: ours(elements)  # noqa: E731
        sweep = median(3, fresh, lambda m: rb.campbell(m, SPEEDS, count=COUNT))[0]
        forced = median(3, fresh, response)[0]
        dense = np.nan
        if elements <= DENSE:
            dense = median(1, lambda e=elements: ours(e).at(500.0).state_matrix()[0], linalg.eigvals)[0]
        known.append([sweep, forced, dense])
        told = f"{1000 * dense:.1f}" if np.isfinite(dense) else "-"
        rows.append([str(elements), f"{1000 * sweep / len(SPEEDS):.2f}", f"{1000 * forced / len(LINES):.3f}", told])
        print(*rows[-1], sep=" | ", flush=True)
    spent, size = np.log(np.array(known)), np.log(np.array(SIZES, dtype=float))
    slopes = []
    for column in spent.T:
        use = np.isfinite(column) & (size >= np.log(40))
        slopes.append(f"{np.polyfit(size[use], column[use], 1)[0]:.2f}")
    return [*rows, ["slope from 40 on", *slopes]]


def markdown(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def page() -> str:
    rows, told = [], []
    for case in CASES:
        more, frequency, off = compare(*case)
        rows += more
        told.append(
            f"- {case[0]} elements: the first {COUNT} lateral frequencies differ by {frequency:.1e} at most, "
            f"the unbalance response at the middle disk by {off:.1e} of its largest."
        )
    packages = ", ".join(f"{name} {version(name)}" for name in ("ross-rotordynamics", "plotly", "numpy", "scipy"))
    return "\n\n".join(
        [
            INTRODUCTION,
            f"Machine: {processor()}, {os.cpu_count()} cores, {platform.system()}; one BLAS thread. "
            f"Python {platform.python_version()}, rbfound {rb.__version__}, {packages}.",
            "## Equal answers",
            "\n".join(told),
            "## CPU time",
            markdown(["elements", "what", "rbfound [s]", "ROSS [s]", "ROSS / rbfound"], rows),
            "## Cost against size",
            markdown(
                ["elements", "Campbell, a speed [ms]", "unbalance, a line [ms]", "LAPACK eigvals alone, a speed [ms]"],
                growth(),
            ),
        ]
    )


INTRODUCTION = f"""# A rotor beside ROSS

Written by `make bench` (`benchmarks/rotor.py`): do not edit by hand.

A shaft of 1 m and 50 mm with two disks in two bearings of 1e7 and 2e7 N/m, {COUNT} lateral modes followed. ROSS has six
coordinates a node, rbfound four: modes along and about the shaft are among the lowest of ROSS. So it is asked for
{OTHERS} more, and each mode of ours is compared with the nearest one.

- CPU time, medians: {CASES[0][1]} runs of rbfound and {CASES[0][2]} of ROSS at {CASES[0][0]} elements, {CASES[1][1]}
  and {CASES[1][2]} at {CASES[1][0]}. There ROSS gets {CASES[1][3]} speeds and {CASES[1][4]} lines, and its time
  is scaled up to all of them; its critical speeds are not asked for.
- Every run starts from a machine of its own, made before the clock starts, so that nothing kept from before helps.
- LAPACK's `eigvals` of the dense state matrix, without vectors, is the floor for who solves each speed afresh. It is
  taken up to {DENSE} elements. Slopes are those of a straight line through the logarithms."""


if __name__ == "__main__":
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        critical(ours(40))
        response(ours(40))
        theirs(10).run_modal(LATERAL_SPEED)
        (Path(__file__).parent / "rotor.md").write_text(page() + "\n", encoding="utf-8")
