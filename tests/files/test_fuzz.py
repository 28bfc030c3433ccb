"""Whatever stands in a file: a result or a ValueError, nothing else, for bounded work and memory.

Good files are damaged (cut, bytes changed, pieces doubled, put in or taken out), or made of nothing but noise. A short
run here; `make fuzz` does RBFOUND_FUZZ = 5000 cases for each name, and as many again as atheris is given
(fuzz_atheris.py).
"""

import os
import struct
import subprocess
import sys
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import fuzzing
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from samples import foundation

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
WORDS += [b"1e308", b"-1.7e308", b"1e-320", b"L"]


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
    with fuzzing.beside(good[0]) as folder:

        @settings(max_examples=CASES, suppress_health_check=list(HealthCheck))
        @given(st.sampled_from(good[1][name]), damage())
        def case(content, changes):
            fuzzing.outcome(folder, name, damaged(content, changes))

        case()


@pytest.mark.parametrize("name", fuzzing.NAMES)
def test_the_good_files_are_read(good, name):
    # or the damaged ones would be refused for nothing; these say no unit, or one file for three pairs
    with fuzzing.beside(good[0]) as folder:
        assert good[1][name]
        for content in good[1][name]:
            assert fuzzing.read(folder, name, content) is not None


# --- what numpy and Python warn of ---


def npz(path: Path, heading: str, data: bytes) -> Path:
    """A set of FRFs whose frequencies have a heading of one's own."""
    text = heading.encode("latin-1")
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("frequency.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + data)
        for name, array in {"H": np.ones((2, 2, 2)), "unit": np.array(["m"])}.items():
            with archive.open(f"{name}.npy", "w") as stream:
                np.save(stream, array)
    return path


@pytest.mark.parametrize(
    ("kind", "shape"),
    [
        ("<f8", "(2L,)"),  # as Python 2 wrote it; found at random: numpy reads it and warns
        ("<f8", "(2if 1else 3,)"),  # Python warns of the letter after the digit
        (r"\d<f8", "(2,)"),  # and of this backslash
        ("a8", "(2,)"),  # a name that numpy gave up
    ],
)
def test_a_heading_that_is_read_with_a_warning_only_is_refused(kind, shape, tmp_path):
    heading = "{'descr': '%s', 'fortran_order': False, 'shape': %s, }"
    good = npz(tmp_path / "good.npz", heading % ("<f8", "(2,)"), np.array([1.0, 2.0]).tobytes())
    np.testing.assert_array_equal(rb.load_frf(good).frequency, [1.0, 2.0])
    path = npz(tmp_path / "a.npz", heading % (kind, shape), np.array([1.0, 2.0]).tobytes())
    with pytest.raises(ValueError, match=r"a\.npz is not a readable \.npz file: "):
        rb.load_frf(path)


@pytest.mark.parametrize(
    ("heading", "row"),
    [
        ("frequency [kHz],x1:x1 re [m],x1:x1 im [m]", "1e308,1,1"),
        ("frequency [Hz],x1:x1 re [m/s2],x1:x1 im [m/s2]", "1e308,1,1"),
        ("frequency [Hz],x1:x1 re [m/s2],x1:x1 im [m/s2]", "1e-320,1,1"),
        ("frequency [Hz],x1:x1 amplitude [m],x1:x1 phase [deg],x1:x1 re [m],x1:x1 im [m]", "1,1.7e308,180,1.7e308,0"),
    ],
)
def test_numbers_that_overflow_in_a_text_are_refused(heading, row, tmp_path):
    (tmp_path / "x1_from_x1.csv").write_text(f"{heading}\n{row}\n")
    pairs = [f"x1_from_x1.csv,{pair}\n" for pair in ("x1,x1", "x1,y1", "y1,y1")]
    (tmp_path / "index.csv").write_text("".join(["file,response,force\n", *pairs]))
    with pytest.raises(ValueError, match="too large or too small to reckon with"):
        rb.load_frf(tmp_path / "index.csv", fill=True)


def test_numbers_that_overflow_in_an_array_are_refused(tmp_path):
    np.savez(tmp_path / "a.npz", frequency=[1e308], H=np.ones((1, 2, 2)), unit=np.array(["m/s2"]))
    with pytest.raises(ValueError, match="too large or too small to reckon with"):
        rb.load_frf(tmp_path / "a.npz")


# --- work and memory grow with the file, and no faster ---

# A row of text becomes a Python string, some floats and their list: some fifty bytes for each byte of short rows.
MEMORY = 100
# A short row of numbers is the hardest: six calls for each byte.
CALLS = 10
# Some ten thousand bytes; some millions where no call is counted.
SMALL, LARGE = 2_000, 1_000_000
# Seconds of CPU for a megabyte; the slowest takes two on a slow core.
SECONDS = 20


def hard(count: int) -> dict[str, str]:
    """Files that are hard on their reader, of some times `count` bytes."""
    row = "1,2,3\n"
    head = "frequency [Hz],x1:x1 re [m],x1:x1 im [m]\n"
    return {
        "lines that do not ascend.csv": head + row * count,
        "one long line.csv": head + "1," * (2 * count),
        "a long heading.csv": "x1 from y1 (" * (count // 3) + "\n1,2,3\n",
        "many words.csv": "real [m] " * (count // 2) + "\n1 2 3\n",
        "text alone.csv": "abc def\n" * (count // 2),
        "blank lines.csv": head + "\n" * (4 * count),
        "one number.csv": "frequency\n" + "9" * (4 * count),
        "an index of nothing.csv": "file,response,force\n" + "a,x1,x1\n" * (count // 2),
        "body of brackets.json": "[" * (4 * count),
        "body of rows.json": '{"format": "rbfound foundation 1", "M": [' + "[1]," * count + "[1]]}",
        "sets.uff": "    -1\n    58\n" * (count // 3),
        "zeros.uff": "    -1\n" + "\0" * (4 * count),
    }


def large(path: Path, count: int) -> Path:
    """Write the hard file of this name, or one that is good and long, or an archive of many members."""
    if path.name == "members.npz":
        with zipfile.ZipFile(path, "w") as archive:
            for k in range(count // 30):
                archive.writestr(f"{k}.npy", b"")
    elif path.name == "good.csv":
        pairs = [f"{i} from {j} {part} [m]" for i in ("x1", "y1") for j in ("x1", "y1") for part in ("re", "im")]
        rows = (f"{k},1e-9,-2e-9,1e-9,-2e-9,1e-9,-2e-9,1e-9,-2e-9" for k in range(1, count // 10))
        path.write_text("\n".join([",".join(["frequency [Hz]", *pairs]), *rows]))
    else:
        path.write_text(hard(count)[path.name], encoding="utf-8")
    return path


def said_of(path: Path) -> str:
    """What comes of reading a file."""
    try:
        rb.load_foundation(path) if "body" in path.name else rb.load_frf(
            path, unit="m", fill=path.suffix not in (".npz", ".mat")
        )
    except ValueError as error:
        return f"ValueError {error}"
    return "read"


def calls(path: Path) -> int:
    """How many functions, of Python and of C, are called while a file is read: a measure of work without a clock."""
    count = 0

    def counted(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(counted)
    try:
        said_of(path)
    finally:
        sys.setprofile(before)
    return count


def peak(work: Callable[[], object]) -> int:
    """Bytes that some work holds at most at one time, as Python and numpy count them."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


NAMED = (*hard(0), "members.npz", "good.csv")


@pytest.mark.parametrize("name", NAMED)
def test_work_and_memory_of_a_hard_file_grow_no_faster_than_the_file(name, tmp_path):
    path = large(tmp_path / name, SMALL)
    said = said_of(path)
    assert said == "read" if name == "good.csv" else said.startswith("ValueError")
    assert len(said) < 2000  # a message that a person can read
    # the constants are what does not depend on the size: regular expressions, an archive's frame
    size = path.stat().st_size
    assert peak(lambda: said_of(path)) < 1e5 + MEMORY * size
    work = calls(path)
    assert work < 1000 + CALLS * size
    assert calls(large(tmp_path / name, 2 * SMALL)) < 1000 + 2.1 * work


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="this test limits the CPU time of a process as POSIX does")
@pytest.mark.parametrize("name", NAMED)
def test_work_that_no_call_shows_does_not_grow_faster_either(name, tmp_path):
    """A regular expression may take hours in one call: what takes ten times as long as a reader needs is killed."""
    path = large(tmp_path / name, LARGE)
    limit = int(5 + SECONDS * path.stat().st_size / 1e6)
    code = (
        "import resource, sys; from pathlib import Path; from test_fuzz import said_of; "
        f"resource.setrlimit(resource.RLIMIT_CPU, ({limit}, {limit})); print(said_of(Path(sys.argv[1])))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)],
        capture_output=True,
        text=True,
        # what these tests import from one another
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("read" if name == "good.csv" else "ValueError")


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_a_bomb_is_refused_in_bounded_memory(ending, tmp_path, monkeypatch):
    """Some kilobytes that unpack to a hundred megabytes, and a limit of ten."""
    monkeypatch.setattr("rbfound.files.arrays.LARGEST_UNPACKED", 10_000_000)
    path = tmp_path / f"bomb.{ending}"
    piece = bytes(10**6)
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
    said: list[str] = []
    memory = peak(lambda: said.append(said_of(path)))
    assert said[0].startswith("ValueError")
    assert "unpacks to" in said[0]
    # nothing of a .npz is unpacked; of a .mat, whose size nobody knows before, no more than the limit, in a buffer that
    # doubles as it fills, and is copied once
    assert memory < (5e6 if ending == "npz" else 30e6)


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_a_size_that_lies_is_refused_in_little_memory(ending, tmp_path):
    """Two gigabytes written over every seventh place of a small file: some of these are sizes."""
    path = tmp_path / f"lies.{ending}"
    rb.save_frf(foundation(2, 1).frf(np.arange(1.0, 5.0)), path)
    content = path.read_bytes()
    for at in range(0, len(content) - 4, 7):
        path.write_bytes(content[:at] + b"\xff\xff\xff\x7f" + content[at + 4 :])
        assert peak(lambda: said_of(path)) < 5e6


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this test makes a pipe that has a name, as POSIX has them")
@pytest.mark.parametrize("place", ["/dev/zero", "pipe", "set"])
def test_an_index_that_names_what_is_no_file_is_refused_at_once(place, tmp_path):
    (tmp_path / "set").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "index.csv").write_text(f"file,response,force\n{place},x1,x1\n")
    with pytest.raises(ValueError, match="is not a file"):
        rb.load_frf(tmp_path / "index.csv")
