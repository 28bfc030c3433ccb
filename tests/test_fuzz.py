"""Whatever stands in a file: a result or a ValueError, nothing else, in bounded time and memory.

Good files are damaged (cut, bytes changed, pieces doubled, put in or taken out), or made of nothing but noise. A short
run here; `make fuzz` does RBFOUND_FUZZ = 5000 cases for each name, and as many again as atheris is given
(fuzz_atheris.py).
"""

import contextlib
import os
import struct
import subprocess
import sys
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import fuzzing
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_files import foundation

import rbfound as rb

CASES = int(os.environ.get("RBFOUND_FUZZ", "40"))
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
WORDS += [b"9" * 400, b"x1 from y1", b"\r", b"1_0", b"\xb2", b"\x80\x04\x95", b"../", b"/dev/zero"]


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


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """The folder with what stands beside a file, and good files by name."""
    pytest.importorskip("pyuff", reason="UFF needs pyuff: pip install 'rbfound[uff]'")
    folder = tmp_path_factory.mktemp("good")
    return folder, fuzzing.good_files(folder)


@pytest.mark.parametrize("name", fuzzing.NAMES)
def test_a_damaged_file_gives_a_result_or_a_value_error(good, name):
    slowest = 0.0
    with fuzzing.beside(good[0]) as folder:

        @settings(max_examples=CASES, deadline=None, database=None, suppress_health_check=list(HealthCheck))
        @given(st.sampled_from(good[1][name]), damage())
        def case(content, changes):
            nonlocal slowest
            slowest = max(slowest, fuzzing.outcome(folder, name, damaged(content, changes)))

        case()
    # files of some kilobytes: far below a second each
    assert slowest < 1.0


@pytest.mark.parametrize("name", fuzzing.NAMES)
def test_the_good_files_are_read(good, name):
    # or the damaged ones would be refused for nothing; these say no unit, or one file for three pairs
    with fuzzing.beside(good[0]) as folder:
        for content in good[1][name]:
            assert fuzzing.read(folder, name, content) is not None


# --- a second and some memory for each megabyte ---

# Reads a file; prints what came of it, seconds of CPU, and the peak of memory beyond that of the imports [MB].
MEASURED = """
import resource, sys, time
import rbfound as rb
path = sys.argv[1]
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
start = time.process_time()
try:
    rb.load_foundation(path) if "body" in path else rb.load_frf(path, unit="m", fill=True)
    print("read")
except ValueError as error:
    print("ValueError", error)
print(time.process_time() - start, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e3)
"""
# A row of text becomes a Python string, some floats and their list: some sixty bytes for each byte of short rows.
MEMORY = 100


def measured(path: Path) -> tuple[str, float, float]:
    """What came of reading a file in a process of its own, seconds of CPU, and megabytes of memory."""
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, str(path)], capture_output=True, text=True, check=True, timeout=300
    )
    said, figures = done.stdout.strip().rsplit("\n", 1)
    seconds, memory = map(float, figures.split())
    return said, seconds, memory


def large(folder: Path, kind: str) -> Path:
    """A file of some megabytes that is hard on its reader."""
    row = "1,2,3\n"
    head = "frequency [Hz],x1:x1 re [m],x1:x1 im [m]\n"
    texts = {
        "a million lines that do not ascend.csv": head + row * 1_000_000,
        "one long line.csv": head + "1," * 2_000_000,
        "a long heading.csv": "x1 from y1 (" * 300_000 + "\n1,2,3\n",
        "many words.csv": "real [m] " * 400_000 + "\n1 2 3\n",
        "text alone.csv": "abc def\n" * 500_000,
        "blank lines.csv": head + "\n" * 4_000_000,
        "one number.csv": "frequency\n" + "9" * 4_000_000,
        "an index of nothing.csv": "file,response,force\n" + "a,x1,x1\n" * 500_000,
        "body of brackets.json": "[" * 4_000_000,
        "body of rows.json": '{"format": "rbfound foundation 1", "M": [' + "[1]," * 1_000_000 + "[1]]}",
        "sets.uff": "    -1\n    58\n" * 300_000,
        "zeros.uff": "    -1\n" + "\0" * 4_000_000,
    }
    path = folder / kind
    if kind == "members.npz":
        with zipfile.ZipFile(path, "w") as archive:
            for k in range(30_000):
                archive.writestr(f"{k}.npy", b"")
    else:
        path.write_text(texts[kind], encoding="utf-8")
    return path


KINDS = (
    "a million lines that do not ascend.csv", "one long line.csv", "a long heading.csv",
    "many words.csv", "text alone.csv", "blank lines.csv", "one number.csv", "an index of nothing.csv",
    "body of brackets.json", "body of rows.json", "sets.uff", "zeros.uff", "members.npz",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS if "RBFOUND_FUZZ" in os.environ else KINDS[:1])
def test_a_large_file_is_refused_in_a_second_and_a_hundred_megabytes_a_megabyte_at_most(kind, tmp_path):
    path = large(tmp_path, kind)
    said, seconds, memory = measured(path)
    assert said.startswith("ValueError"), said[:300]
    assert len(said) < 2000  # a message that a person can read
    size = path.stat().st_size / 1e6
    assert seconds < max(size, 1.0)
    assert memory < MEMORY * max(size, 1.0)


@pytest.mark.slow
def test_two_hundred_thousand_lines_are_read_in_a_second_and_a_hundred_megabytes_a_megabyte_at_most(tmp_path):
    path = tmp_path / "long.csv"
    pairs = [f"{i} from {j} {part} [m]" for i in ("x1", "y1") for j in ("x1", "y1") for part in ("re", "im")]
    rows = (f"{k},1e-9,-2e-9,1e-9,-2e-9,1e-9,-2e-9,1e-9,-2e-9" for k in range(1, 200_001))
    path.write_text("\n".join([",".join(["frequency [Hz]", *pairs]), *rows]))
    said, seconds, memory = measured(path)
    assert said == "read"
    assert seconds < path.stat().st_size / 1e6
    assert memory < MEMORY * path.stat().st_size / 1e6


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_a_bomb_of_a_gigabyte_is_refused_in_bounded_memory(ending, tmp_path):
    """The real thing, with the limit as it is: some megabytes that unpack to a thousand."""
    path = tmp_path / f"bomb.{ending}"
    piece = bytes(10**7)
    if ending == "npz":
        with (
            zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
            archive.open("H.npy", "w", force_zip64=True) as member,
        ):
            for _ in range(100):
                member.write(piece)
    else:
        packer = zlib.compressobj(1)
        data = b"".join([*(packer.compress(piece) for _ in range(100)), packer.flush()])
        path.write_bytes(fuzzing.MAT_HEAD + struct.pack("<II", 15, len(data)) + data)
    said, seconds, memory = measured(path)
    assert said.startswith("ValueError")
    assert "unpacks to" in said
    assert seconds < path.stat().st_size / 1e6
    # nothing of a .npz is unpacked; of a .mat, whose size nobody knows before, no more than the limit
    assert memory < (50 if ending == "npz" else 1400)


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_a_size_that_lies_is_refused_in_little_memory(ending, tmp_path):
    """Two gigabytes written over every seventh place of a small file: some of these are sizes."""
    path = tmp_path / f"lies.{ending}"
    rb.save_frf(foundation(2, 1).frf(np.arange(1.0, 5.0)), path)
    content = path.read_bytes()
    for at in range(0, len(content) - 4, 7):
        path.write_bytes(content[:at] + b"\xff\xff\xff\x7f" + content[at + 4 :])
        tracemalloc.start()
        with contextlib.suppress(ValueError):
            rb.load_frf(path)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 5e6


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this test makes a pipe that has a name, as POSIX has them")
@pytest.mark.parametrize("place", ["/dev/zero", "pipe", "set"])
def test_an_index_that_names_what_is_no_file_is_refused_at_once(place, tmp_path):
    (tmp_path / "set").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "index.csv").write_text(f"file,response,force\n{place},x1,x1\n")
    with pytest.raises(ValueError, match="is not a file"):
        rb.load_frf(tmp_path / "index.csv")
