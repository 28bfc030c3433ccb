"""Writers that are killed: whatever the moment, the old file or the new one stands there whole."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from samples import foundation

import rbfound as rb
from rbfound.files import exports, frf_sets

# Writes one thing over another, once for each moment at which it can be killed: before each step that the system is
# asked for inside the folder (a file opened, made, renamed, removed), and in the middle of each file's bytes, where a
# limit of the system ends the process. Looks at what is there then; in a process of its own, for it forks. Prints how
# many moments there were, how many left a file half written, and after how many the folder said that it may hold two
# sets.
KILLED = """
import os, resource, signal, sys
from pathlib import Path
import numpy as np
import rbfound as rb
from rbfound.files.exports import dmig, matrix27
from rbfound.files.exports import text_replaced

bodies = [rb.modal_foundation(scale * np.eye(4), [300.0, 600.0, 900.0, 1200.0], [0.02] * 4) for scale in (1.0, 2.0)]
frfs = [body.frf(np.arange(1.0, 40.0)) for body in bodies]

def write(path, which):
    if path.name.startswith("foundation"):
        rb.save_foundation(bodies[which], path)
    elif path.name in ("ansys", "nastran"):
        text_replaced(path, {"ansys": matrix27, "nastran": dmig}[path.name](bodies[which], (1, 2)))
    else:
        rb.save_frf(frfs[which], path)

def content(path):
    if path.is_file():
        # the first 128 bytes of a .mat file hold the time
        return path.read_bytes()[128 if path.suffix == ".mat" else 0 :]
    return b"".join(file.read_bytes() for file in sorted(path.glob("*.txt")))

STEPS = ("open", "os.rename", "os.mkdir", "os.remove", "os.rmdir", "os.link", "os.truncate")

def ends(path, step, size):
    # how a child ends that writes the second thing: killed before a step of that number, or where a file is that long
    child = os.fork()
    if child == 0:
        count = 0

        def watched(event, arguments):
            nonlocal count
            if event in STEPS and str(path.parent) in str(arguments[0]):
                count += 1
                if count == step:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(watched)
        if size is not None:
            signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        write(path, 1)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

for kind in sys.argv[2:]:
    path = Path(sys.argv[1]) / kind / kind
    whole = []
    for which in (1, 0):
        write(path, which)
        whole.append(content(path))
    assert whole[0] != whole[1]
    where = path if path.is_dir() else path.parent
    files = [path] if path.is_file() else list(path.glob("*.txt"))
    largest = max(file.stat().st_size for file in files)
    half = mixed = step = 0
    sizes = [0, 1, largest // 2, largest - 1]
    while True:
        size = sizes[step] if step < len(sizes) else None
        step += 1
        ended = ends(path, step - len(sizes), size)
        assert ended in (-signal.SIGKILL if size is None else -signal.SIGXFSZ, 0), ended
        if size is not None:
            assert ended < 0, f"nothing was written beyond {size} bytes"
            half += any(where.glob(".writing-*/*"))
        if path.is_dir() and (path / "half-written").exists():
            mixed += 1
            try:
                rb.load_frf(path)
                sys.exit("a half-written folder was read")
            except ValueError as error:
                assert "may hold files of two sets" in str(error)
            write(path, 1)
        assert content(path) in whole, f"{kind}, step {step}: neither the old nor the new one"
        for left in where.glob(".writing-*"):
            os.utime(left, (0, 0))
        write(path, 0)
        assert content(path) == whole[1]
        assert not any(where.glob(".writing-*")), "what killed writes left is still there"
        if ended == 0:
            break
    print(kind, step, half, mixed, sep=",")
"""
KINDS = ("foundation.json", "foundation.npz", "foundation.mat", "frf.npz", "frf.mat", "frf", "ansys", "nastran")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this test kills processes as POSIX does")
def test_a_kill_at_any_moment_leaves_the_old_or_the_new_one_whole(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(tmp_path), *KINDS], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    told = [line.split(",") for line in done.stdout.split()]
    assert [kind for kind, *_ in told] == list(KINDS)
    for kind, steps, half, mixed in told:
        # four in the middle of the bytes; the folder aside is made, the file in it opened and renamed
        assert int(steps) > 4 + 3
        assert int(half) == 4
        # of sixteen files one after the other is renamed
        assert int(mixed) > 15 if kind == "frf" else mixed == "0"


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
    with pytest.raises(ValueError, match=rf"may hold files of two sets: save it again.*{frf_sets.MIXED}"):
        rb.load_frf(tmp_path / "set")
    monkeypatch.undo()
    rb.save_frf(other, tmp_path / "set")
    np.testing.assert_allclose(rb.load_frf(tmp_path / "set").H, other.H, rtol=1e-8)
    assert len(list((tmp_path / "set").iterdir())) == 4


def test_what_a_killed_write_left_is_removed_once_it_is_old_and_nothing_else_is(tmp_path):
    names = ("old", "new", "other")
    old, new, other = (tmp_path / (exports.ASIDE * (name != "other") + name) for name in names)
    for folder in (old, new, other):
        folder.mkdir()
        (folder / "part").write_text("half a file")
    os.utime(old, (time.time() - 2 * exports.STALE,) * 2)
    os.utime(other, (0, 0))
    exports.text_replaced(tmp_path / "kept.txt", "whole")
    assert {path.name for path in tmp_path.iterdir()} == {new.name, other.name, "kept.txt"}
    assert exports.ASIDE.startswith(".")  # hidden from those who list the folder
