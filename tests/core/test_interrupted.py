"""Ctrl-C on long work: it ends early, leaves no process and no half of a file behind, and goes on from where it was."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

# Tasks of a hundredth of a second end within a second, all three thousand of them in minutes: what takes no notice of
# an interrupt is not waited for [s].
PATIENCE = 60
WORK = """
import signal
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
import numpy as np
import rbfound as rb

def asked(count, kept=None, executor=None):
    lines = np.arange(50.0, 300.0, 2.0)
    Phi = [[0.1, 0.05, 0.02], [0.02, 0.1, -0.05]]
    clean = rb.modal_foundation(Phi, rb.from_hertz(np.array([80.0, 140.0, 220.0])), [0.02] * 3, ("x1", "y1")).frf(lines)
    noise = np.random.default_rng(0).standard_normal((*clean.H.shape, 2)) @ [1, 1j]
    fit = rb.fit_modes(rb.FRF(lines, clean.H * (1 + 0.01 * noise), clean.labels), modes=3)
    rotor = rb.Rotor(rb.Shaft([0.3], [0.05]), {0.3: rb.Disk(5.0, 0.01, 0.02)}, element=0.15)
    bearings = {0.0: rb.Bearing(1e7, 1e7)}
    options = {"above": 5, "below": 300, "count": count, "kept": kept, "executor": executor}
    return rb.identification.monte_carlo(fit, lines, rotor, bearings, **options)

if __name__ == "__main__":
    # what a shell starts in the background ignores Ctrl-C, and so would all that it starts
    signal.signal(signal.SIGINT, signal.default_int_handler)
    way, kept = sys.argv[1:]
    if way == "here":
        asked(3_000, kept)
    else:
        with ProcessPoolExecutor(2) as executor:
            asked(3_000, kept, executor)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="this test interrupts processes as POSIX does")
@pytest.mark.parametrize(("way", "all_of_them"), [("here", True), ("processes", True), ("processes", False)])
def test_an_interrupted_monte_carlo_ends_early_leaves_nothing_and_goes_on(way, all_of_them, tmp_path, monkeypatch):
    """A terminal's Ctrl-C reaches the workers too; a signal of another program only the process that it is sent to."""
    (tmp_path / "work.py").write_text(WORK)
    kept = tmp_path / "kept" / "poles.npz"
    with (tmp_path / "said").open("w+") as said:
        work = subprocess.Popen(
            [sys.executable, str(tmp_path / "work.py"), way, str(kept)], stderr=said, start_new_session=True
        )
        while not kept.exists():
            assert work.poll() is None, (tmp_path / "said").read_text()
            time.sleep(0.05)
        (os.killpg if all_of_them else os.kill)(work.pid, signal.SIGINT)
        assert work.wait(timeout=PATIENCE) != 0
    said = (tmp_path / "said").read_text()
    assert "KeyboardInterrupt" in said
    with pytest.raises(ProcessLookupError):
        # no process of its group is left
        os.killpg(work.pid, 0)
    assert [path.name for path in kept.parent.iterdir()] == ["poles.npz"]
    found = np.load(kept)["poles"]
    assert 0 < len(found) < 3_000
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "work", raising=False)
    from work import asked

    more = asked(len(found) + 2, kept)
    np.testing.assert_array_equal(more[:-2], found)
    # what comes of it without an interrupt, to the last bit: each has random numbers of its own
    np.testing.assert_array_equal(more[:3], asked(3))


def test_poles_kept_of_something_else_are_refused(tmp_path, monkeypatch):
    (tmp_path / "work.py").write_text(WORK)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "work", raising=False)
    from work import asked

    kept = tmp_path / "poles.npz"
    first = asked(2, kept)
    # fewer are asked than there are: nothing is computed again
    with monkeypatch.context() as patched:
        patched.setattr("rbfound.identification.error_propagation._again", lambda *_: 1 / 0)
        np.testing.assert_array_equal(asked(1, kept), first[:1])
    np.savez(kept, asked=np.array("else"), poles=first)
    with pytest.raises(ValueError, match=r"poles\.npz is not of this fit, rotor, speed and seed"):
        asked(2, kept)
    kept.write_bytes(b"half")
    with pytest.raises(ValueError, match=r"poles\.npz is not a readable \.npz file"):
        asked(2, kept)
