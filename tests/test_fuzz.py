"""Whatever stands in a file: a result or a ValueError, nothing else, in bounded time.

Good files are damaged (cut, bytes changed, pieces doubled, put in or taken out), or made of nothing but noise. A short
run here; `make fuzz` does RBFOUND_FUZZ = 20 000 cases for each format.
"""

import contextlib
import os
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_command import MACHINE
from test_files import foundation
from test_formats import FRFS
from written import universal

import rbfound as rb
from rbfound.machinefile import load_machine

CASES = int(os.environ.get("RBFOUND_FUZZ", "60"))
LINES = np.array([10.0, 20.0, 30.0, 45.0, 60.0, 80.0])
WORDS = [
    b"",
    b"nan",
    b"inf",
    b"-1",
    b"1e999",
    b"\0",
    b"\xff\xfe",
    b"\n",
    b"\t",
    b",",
    b";",
    b"    -1\n",
    b"    58b",
    b"[",
]
WORDS += [b"9" * 400, b"x1 from y1", b"\r", b"1_0", b"\xb2"]


def seeds(folder: Path) -> dict[str, bytes]:
    """A good file of each format, as bytes."""
    frf = foundation(2, 3).frf(LINES)
    small = rb.modal_foundation([[1.0], [0.5]], [100.0], [0.1], ("x1", "y1"))
    out = {}
    for name in ("f.npz", "f.mat"):
        rb.save_frf(frf, folder / name)
        out[name] = (folder / name).read_bytes()
    for name in ("m.npz", "m.json", "m.mat"):
        rb.save_foundation(small, folder / name)
        out[name] = (folder / name).read_bytes()
    pairs = [(i, j) for i in range(2) for j in range(2)]
    heading = [
        "Frequency [Hz]",
        *(f"{frf.labels[i]} from {frf.labels[j]} {p} [mm/N]" for i, j in pairs for p in ("re", "im")),
    ]
    rows = [
        [f, *(p for i, j in pairs for p in (h[i, j].real, h[i, j].imag))] for f, h in zip(LINES, frf.H, strict=True)
    ]
    out["t.csv"] = "\n".join([";".join(heading), *(";".join(f"{v:.6g}" for v in row) for row in rows)]).encode()
    rb.save_frf(frf, folder / "set")
    out["index.csv"] = b"file,response,force\n" + b"\n".join(
        f"set/{path.name},{path.name[6:8]},{path.name[14:16]}".encode() for path in sorted((folder / "set").iterdir())
    )
    out["one.txt"] = next((folder / "set").glob("*x1_from_x1.txt")).read_bytes()
    out["machine.toml"] = MACHINE.encode()
    out["u.uff"] = universal(folder / "u.uff", FRFS).read_bytes()[:4000]
    out["b.uff"] = universal(folder / "b.uff", FRFS, binary=1).read_bytes()[:6000]
    return out


@st.composite
def damage(draw):
    """Up to four changes of a file: (kind, place as a part of its length, length, bytes)."""
    change = st.tuples(
        st.sampled_from(["cut", "change", "double", "put", "take", "noise"]),
        st.floats(0, 1),
        st.integers(1, 64),
        st.one_of(st.sampled_from(WORDS), st.binary(max_size=12)),
    )
    return draw(st.lists(change, min_size=1, max_size=4))


def damaged(content: bytes, changes) -> bytes:
    for kind, part, length, word in changes:
        at = int(part * len(content))
        head, tail = content[:at], content[at:]
        content = {
            "cut": head,
            "change": head + word + tail[len(word) :],
            "double": head + tail[:length] + tail,
            "put": head + word + tail,
            "take": head + tail[length:],
            "noise": word * length,
        }[kind]
    return content


NAMES = ("f.npz", "f.mat", "m.npz", "m.json", "m.mat", "t.csv", "index.csv", "one.txt", "machine.toml")
NAMES += ("u.uff", "b.uff")


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    pytest.importorskip("pyuff", reason="UFF needs pyuff: pip install 'rbfound[uff]'")
    return seeds(tmp_path_factory.mktemp("good"))


def read(folder: Path, name: str) -> object:
    """Read a file by the loader that its name calls for."""
    if name == "machine.toml":
        return load_machine(folder / name)
    if name.startswith("m."):
        return rb.load_foundation(folder / name)
    if name == "one.txt":
        (folder / name).rename(folder / "x1_from_x1.txt")
        return rb.load_frf(folder, fill=True)
    return rb.load_frf(folder / name)


@pytest.mark.filterwarnings("ignore:Mat 4:FutureWarning")
@pytest.mark.parametrize("name", NAMES)
def test_a_damaged_file_gives_a_result_or_a_value_error(good, name):
    slowest = 0.0

    @settings(max_examples=CASES, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(damage())
    def case(changes):
        nonlocal slowest
        content = damaged(good[name], changes)
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / name).write_bytes(content)
            start = time.process_time()
            result = None
            with contextlib.suppress(ValueError):
                result = read(Path(folder), name)
            if isinstance(result, rb.FRF):
                assert np.isfinite(result.H).all()
            slowest = max(slowest, time.process_time() - start)

    case()
    # files of some kilobytes: far below a second each
    assert slowest < 1.0


def test_the_good_files_are_read(good, tmp_path):
    # or the damaged ones would be refused for nothing
    for name in ("f.npz", "f.mat", "m.npz", "m.json", "m.mat", "t.csv"):
        (tmp_path / name).write_bytes(good[name])
        assert read(tmp_path, name) is not None


@pytest.mark.slow
def test_a_million_lines_are_read_or_refused_within_a_second_a_megabyte(tmp_path):
    path = tmp_path / "long.csv"
    path.write_text("frequency [Hz],x1:x1 re [m],x1:x1 im [m]\n" + "1,2,3\n" * 1_000_000)
    start = time.process_time()
    with pytest.raises(ValueError, match=r"line 3: .*frequencies must ascend"):
        rb.load_frf(path)
    assert time.process_time() - start < path.stat().st_size / 1e6
