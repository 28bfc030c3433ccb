"""Writers that are killed: whatever the moment, the old file or the new one stands there whole."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from test_files import foundation

import rbfound as rb
from rbfound import folders, writing

KILLS = 20
# Writes two things over one another until it is killed, and looks at what is there then; in a process of its own, for
# it forks. Prints how often a kill struck in the middle of a write, and how often the folder said of itself that it is
# half written.
KILLED = """
import os, signal, sys, time
from pathlib import Path
import numpy as np
import rbfound as rb
from rbfound.exports import dmig, matrix27
from rbfound.writing import text_replaced

kind, folder, kills = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
path = folder / kind
rng = np.random.default_rng(7)
bodies = [
    rb.modal_foundation(rng.standard_normal((4, n)), 300.0 * np.arange(1, n + 1), np.full(n, 0.02)) for n in (90, 100)
]
frfs = [body.frf(np.arange(1.0, 400.0)) for body in bodies]

def write(which):
    if kind.startswith("foundation"):
        rb.save_foundation(bodies[which], path)
    elif kind in ("ansys", "nastran"):
        text_replaced(path, {"ansys": matrix27, "nastran": dmig}[kind](bodies[which], (1, 2)))
    else:
        rb.save_frf(frfs[which], path)

def content():
    if path.is_file():
        # the first 128 bytes of a .mat file hold the time
        return path.read_bytes()[128 if kind.endswith(".mat") else 0 :]
    return b"".join(file.read_bytes() for file in sorted(path.glob("*.txt")))

whole = []
for which in (0, 1):
    start = time.monotonic()
    write(which)
    took = time.monotonic() - start
    whole.append(content())
assert whole[0] != whole[1]
middle = mixed = 0
where = path if path.is_dir() else folder
for number in range(kills):
    child = os.fork()
    if child == 0:
        while True:
            write(0)
            write(1)
    if number % 2:
        time.sleep(rng.uniform(0, 3 * took))
    else:
        # most of the time may go into making the text: every other kill waits until something is written
        while not any(where.glob(".writing-*")):
            pass
        time.sleep(rng.uniform(0, 0.2 * took))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    middle += any(where.glob(".writing-*"))
    if path.is_dir() and (path / "half-written").exists():
        mixed += 1
        try:
            rb.load_frf(path)
            sys.exit("a half-written folder was read")
        except ValueError as error:
            assert "may hold files of two sets" in str(error)
        write(1)
    assert content() in whole, "neither the old nor the new one"
    for left in where.glob(".writing-*"):
        os.utime(left, (0, 0))
write(0)
assert not any(where.glob(".writing-*")), "what killed writes left is still there"
print(middle, mixed)
"""
KINDS = ("foundation.json", "foundation.npz", "foundation.mat", "frf.npz", "frf.mat", "frf", "ansys", "nastran")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this test kills processes as POSIX does")
@pytest.mark.parametrize("kind", KINDS)
def test_twenty_kills_leave_the_old_or_the_new_one_whole(kind, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", KILLED, kind, str(tmp_path), str(KILLS)], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    middle, mixed = map(int, done.stdout.split())
    # or no kill struck a write, and the test says nothing
    assert middle > 0
    assert mixed <= middle


def test_a_folder_in_which_two_sets_are_mixed_is_refused_until_it_is_saved_again(tmp_path, monkeypatch):
    rb.save_frf(foundation(2, 1).frf([1.0, 2.0]), tmp_path / "set")
    real, done = os.replace, []

    def killed(here, there):
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(there)
        real(here, there)

    monkeypatch.setattr("os.replace", killed)
    other = foundation(2, 2).frf([1.0, 2.0])
    with pytest.raises(KeyboardInterrupt):
        rb.save_frf(other, tmp_path / "set")
    with pytest.raises(ValueError, match=rf"may hold files of two sets: save it again.*{folders.MIXED}"):
        rb.load_frf(tmp_path / "set")
    monkeypatch.undo()
    rb.save_frf(other, tmp_path / "set")
    np.testing.assert_allclose(rb.load_frf(tmp_path / "set").H, other.H, rtol=1e-8)
    assert len(list((tmp_path / "set").iterdir())) == 4


def test_what_a_killed_write_left_is_removed_once_it_is_old_and_nothing_else_is(tmp_path):
    names = ("old", "new", "other")
    old, new, other = (tmp_path / (writing.ASIDE * (name != "other") + name) for name in names)
    for folder in (old, new, other):
        folder.mkdir()
        (folder / "part").write_text("half a file")
    os.utime(old, (time.time() - 2 * writing.STALE,) * 2)
    os.utime(other, (0, 0))
    writing.text_replaced(tmp_path / "kept.txt", "whole")
    assert {path.name for path in tmp_path.iterdir()} == {new.name, other.name, "kept.txt"}
    assert writing.ASIDE.startswith(".")  # hidden from those who list the folder
