"""Studies of very many machines: against the whole machine one by one, and through kills, changes and executors."""

import os
import signal
import subprocess
import sys
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rbfound as rb
from rbfound import studies
from rbfound.studies import Study, results, sweep

OVERHUNG = rb.Rotor(
    rb.Shaft([0.2, 1.0, 0.3], [0.06, 0.08, 0.05]), {0.7: rb.Disk(20, 0.2, 0.4), 1.5: rb.Disk(40, 0.6, 1.2)}, 0.1
)
JOURNALS = {z: rb.Bearing(1e8, 1.5e8, 2e7, -2e7, 1e4, 2e4) for z in (0.2, 1.2)}
GROUNDS = (None, rb.thesis.unrounded_foundation())
SMALL = Study(
    OVERHUNG, JOURNALS, speeds=[0.0, 300.0, 600.0], foundations=GROUNDS, stiffness=[0.1, 1.0], damping=[1.0, 3.0]
)


def the_same(a: np.ndarray, b: np.ndarray) -> bool:
    return np.array_equal(a, b, equal_nan=True)


@pytest.mark.parametrize("limit", [300.0, 1000.0])
@pytest.mark.parametrize(
    ("rotor", "bearings"), [(rb.thesis.rotor(), rb.thesis.bearings()), (OVERHUNG, JOURNALS)], ids=["thesis", "overhung"]
)
def test_poles_are_those_of_the_whole_machine_as_promised(
    rotor: rb.Rotor, bearings: dict, limit: float, tmp_path: Path
) -> None:
    study = Study(
        replace(rotor, element=0.15),
        bearings,
        speeds=[0.0, float(rb.from_hertz(limit))],
        foundations=GROUNDS,
        stiffness=[0.01, 1.0, 100.0],
        damping=[0.1, 10.0],
        limit=limit,
    )
    sweep(study, tmp_path)
    rows = results(tmp_path)
    assert rows.shape == (len(study), study.count) == (24, 12)
    for number in range(len(study)):
        whole = study.system(number).modes().above(study.above)
        known = whole.poles[np.abs(whole.poles) < rb.from_hertz(0.999 * limit)][: study.count]
        found = rows[number, : len(known)]
        assert (np.abs(found - known) < 2e-4 * np.abs(known)).all()


def test_the_axes_are_those_of_the_study(tmp_path: Path) -> None:
    sweep(SMALL, tmp_path, chunk=5)
    poles = results(tmp_path).reshape(*SMALL.shape, SMALL.count)
    last = SMALL.system(len(SMALL) - 2).modes().above(1.0).poles[:4]
    np.testing.assert_allclose(poles[1, 1, 1, 1, :4], last, rtol=2e-4)


def test_a_machine_on_rigid_ground_and_one_with_few_modes_below_the_limit_leave_the_rest_empty(tmp_path: Path) -> None:
    sweep(replace(SMALL, limit=60.0, foundations=[None]), tmp_path)
    rows = results(tmp_path)
    count = np.isfinite(rows).sum(axis=1)
    poles = [SMALL.system(k).modes().above(1.0).poles for k in range(12)]
    whole = [(np.abs(p) <= rb.from_hertz(60.0)).sum() for p in poles]
    np.testing.assert_array_equal(count, whole)
    assert np.isnan(rows[:, 11]).all()


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_any_executor_gives_the_same(pool: type, tmp_path: Path) -> None:
    sweep(SMALL, tmp_path / "here", chunk=4)
    with pool(2) as executor:
        sweep(SMALL, tmp_path / "there", chunk=4, executor=executor)
    assert the_same(results(tmp_path / "here"), results(tmp_path / "there"))


def test_a_bar_shows_how_many_parts_are_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm", reason="bars are tqdm's: pip install 'rbfound[progress]'")
    sweep(SMALL, tmp_path, chunk=4, progress=True)
    assert "6/6" in capsys.readouterr().err


# What a shell starts in the background ignores Ctrl-C, and so would all that it starts.
CAUGHT = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from test_studies import SMALL
from rbfound import studies
replaced = studies.replaced
def caught(path, write):
    def half(whole):
        whole.write_bytes(b"NUMPY")
        print("half written", flush=True)
        time.sleep(60)
    replaced(path, half if path.name == sys.argv[2] else write)
studies.replaced = caught
studies.sweep(SMALL, sys.argv[1], chunk=2)
"""


as_posix = pytest.mark.skipif(os.name != "posix", reason="this test sends signals to a process as POSIX does")


def stopped(folder: Path, how: signal.Signals, part: str) -> int:
    """Run the small study in another process, and stop that while it writes a part: what it ends with."""
    where = os.pathsep.join([str(Path(__file__).parent), str(Path(rb.__file__).parents[1])])
    with subprocess.Popen(
        [sys.executable, "-c", CAUGHT, str(folder), part],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": where},
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "half written\n"
        process.send_signal(how)
        return process.wait(30)


@as_posix
def test_after_a_kill_the_finished_parts_stay_and_the_rest_is_made_up(tmp_path: Path) -> None:
    assert stopped(tmp_path / "killed", signal.SIGKILL, "part-00004.npy") == -signal.SIGKILL
    finished = {path: path.stat().st_mtime_ns for path in (tmp_path / "killed").glob("part-*")}
    assert len(finished) == 4
    # what the kill caught in the middle is hidden from readers of the folder
    assert any((tmp_path / "killed").rglob(".writing-*/part-00004.npy"))
    assert len(results(tmp_path / "killed")) == 8
    sweep(SMALL, tmp_path / "killed", chunk=2)
    sweep(SMALL, tmp_path / "whole", chunk=2)
    assert the_same(results(tmp_path / "killed"), results(tmp_path / "whole"))
    assert {path: path.stat().st_mtime_ns for path in finished} == finished


@as_posix
def test_an_interrupt_leaves_nothing_half_written(tmp_path: Path) -> None:
    assert stopped(tmp_path, signal.SIGINT, "part-00003.npy") != 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "part-00000.npy",
        "part-00001.npy",
        "part-00002.npy",
        "study.json",
    ]


def test_a_finished_study_is_not_solved_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep(SMALL, tmp_path)
    monkeypatch.setattr(studies, "_work_off", lambda *_: pytest.fail("a part was solved"))
    sweep(SMALL, tmp_path)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("speeds", [0.0, 300.0, 601.0]),
        ("damping", [1.0, 2.0]),
        ("foundations", (None, None)),
        ("rotor", replace(OVERHUNG, element=0.05)),
        ("bearings", {0.2: rb.Bearing(1e8, 1e8), 1.2: rb.Bearing(1e8, 1e8)}),
        ("limit", 900.0),
    ],
)
def test_a_folder_with_another_study_is_refused_and_the_difference_named(
    name: str, value: object, tmp_path: Path
) -> None:
    sweep(SMALL, tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(ValueError, match=rf"other {name}: take another folder"):
        sweep(replace(SMALL, **{name: value}), tmp_path)
    with pytest.raises(ValueError, match="other chunk"):
        sweep(SMALL, tmp_path, chunk=7)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_memory_does_not_grow_with_the_study(tmp_path: Path) -> None:
    peaks = []
    for speeds in (50, 500):
        study = replace(SMALL, speeds=np.linspace(0, 600, speeds), foundations=[None], stiffness=[1.0], damping=[1.0])
        tracemalloc.start()
        sweep(study, tmp_path / str(speeds), chunk=25)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # ten times as many machines
    assert peaks[1] < 1.2 * peaks[0]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"bearings": {}}, "needs bearings"),
        ({"speeds": []}, "speeds is empty"),
        ({"stiffness": [np.nan]}, "finite"),
        ({"limit": 0.5}, "above < limit"),
        ({"count": 0}, "count = 0"),
    ],
)
def test_a_study_that_makes_no_sense_is_refused(changed: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(SMALL, **changed)


def test_what_does_not_fit_together_and_empty_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="seats"):
        sweep(replace(SMALL, bearings={0.2: rb.Bearing(1e8, 1e8)}), tmp_path / "a")
    with pytest.raises(ValueError, match="stands at 9 m"):
        sweep(replace(SMALL, bearings={0.2: rb.Bearing(1e8), 9.0: rb.Bearing(1e8)}), tmp_path / "b")
    with pytest.raises(ValueError, match="chunk = 0"):
        sweep(SMALL, tmp_path, chunk=0)
    with pytest.raises(ValueError, match="no part"):
        results(tmp_path)
    (tmp_path / "part-00000.npy").touch()
    with pytest.raises(ValueError, match=r"no study\.json"):
        sweep(SMALL, tmp_path)
