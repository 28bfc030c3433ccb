"""What the fuzzers share: good files to start from, and the reader that each name calls for.

The good files come from other writers than ours where there is one: numpy, scipy, pyuff, the standard library.
"""

import contextlib
import csv
import io
import json
import shutil
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from samples import FREQUENCY, MACHINE, foundation
from scipy import io as scipy_io
from written import universal

import rbfound as rb
from rbfound.files import load_machine

LINES = np.array([10.0, 20.0, 30.0, 45.0, 60.0, 80.0])
# One set in a file of each kind, foundations, a table, an index, a file of a folder, a machine. A checksum or a
# compression shields the inside of some from damage: the inside of H.npy and packed.mat is damaged before it is packed.
NAMES = ("f.npz", "H.npy", "f.mat", "packed.mat", "u.uff", "b.uff", "t.csv", "index.csv", "one.txt")
NAMES += ("m.npz", "m.json", "m.mat", "machine.toml")
MAT_HEAD = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"


def small() -> rb.Foundation:
    return rb.modal_foundation([[1.0], [0.5]], [100.0], [0.1], ("x1", "y1"))


def good_files(folder: Path) -> dict[str, list[bytes]]:
    """Good files of each name; `folder` gets the files beside them that an index and a machine name, too."""
    frf = foundation(2, 3).frf(LINES)
    four = foundation().frf(FREQUENCY[1:])
    body = small()
    rb.save_frf(frf, folder / "set")
    rb.save_foundation(foundation(4, 2), folder / "foundation.json")
    words = {"labels": np.array(["x1", "y1"]), "unit": np.array(["m/N"])}
    arrays = {"frequency": LINES, "H": frf.H, **words}
    parts = {name: getattr(body, name) for name in "MCKB"} | {"labels": words["labels"]}
    np.savez(folder / "a.npz", **arrays)
    np.savez_compressed(folder / "b.npz", **arrays)
    np.savez(folder / "m.npz", **parts, notes=np.array(["a note"]))
    scipy_io.savemat(folder / "a.mat", arrays)
    scipy_io.savemat(folder / "b.mat", arrays, do_compression=True, oned_as="column")
    scipy_io.savemat(folder / "c.mat", {"H": frf.H})
    scipy_io.savemat(folder / "m.mat", parts | {"notes": np.array(["a note"])})
    member = io.BytesIO()
    np.save(member, frf.H)
    told = {name: value.tolist() for name, value in parts.items()} | {"format": "rbfound foundation 1", "notes": []}
    pairs = [(i, j) for i in range(2) for j in range(2)]
    names = [f"{frf.labels[i]} from {frf.labels[j]} {part} [mm/N]" for i, j in pairs for part in ("re", "im")]
    rows = [
        [f, *(p for i, j in pairs for p in (h[i, j].real, h[i, j].imag))] for f, h in zip(LINES, frf.H, strict=True)
    ]
    index = ["file,response,force"]
    index += [f"set/{path.name},{path.name[6:8]},{path.name[14:16]}" for path in sorted((folder / "set").iterdir())]
    one = next((folder / "set").glob("*x1_from_x1.txt")).read_bytes()
    comma = "Frequency [Hz]\tAmplitude [mm]\tPhase [°]\n10\t1,5\t350\n20,5\t2e-3\t-1\n"
    files = {
        name: (folder / name).read_bytes() for name in ("a.npz", "b.npz", "m.npz", "a.mat", "b.mat", "c.mat", "m.mat")
    }
    return {
        "f.npz": [files["a.npz"], files["b.npz"]],
        "H.npy": [member.getvalue()],
        "f.mat": [files["a.mat"], files["b.mat"]],
        "packed.mat": [files["c.mat"][128:]],
        "u.uff": [universal(folder / "u.uff", four).read_bytes()],
        "b.uff": [universal(folder / "b.uff", four, binary=1).read_bytes()],
        "t.csv": [_table(["Frequency [Hz]", *names], rows, mark) for mark in ",;\t"],
        "index.csv": ["\n".join(index).encode()],
        "one.txt": [one, comma.encode(), comma.encode("utf-16"), comma.encode("latin-1")],
        "m.npz": [files["m.npz"]],
        "m.json": [json.dumps(told).encode()],
        "m.mat": [files["m.mat"]],
        "machine.toml": [MACHINE.encode()],
    }


def _table(heading: list[str], rows: list[list[float]], mark: str) -> bytes:
    out = io.StringIO()
    csv.writer(out, delimiter=mark).writerows([heading, *rows])
    return out.getvalue().encode()


@contextlib.contextmanager
def beside(good: Path) -> Iterator[Path]:
    """A folder for one damaged file, with what an index and a machine name beside it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # copies, as not every system lets everyone make links
        shutil.copytree(good / "set", folder / "set")
        shutil.copyfile(good / "foundation.json", folder / "foundation.json")
        yield folder


def read(folder: Path, name: str, content: bytes) -> object:
    """Write a file into the folder and read it by the loader that its name calls for."""
    path = folder / name
    if name == "H.npy":
        path = folder / "f.npz"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("H.npy", content)
            for part, array in {"frequency": LINES, "unit": np.array(["m"])}.items():
                with archive.open(f"{part}.npy", "w") as stream:
                    np.save(stream, array)
    elif name == "packed.mat":
        packed, plain = zlib.compress(content), io.BytesIO()
        scipy_io.savemat(plain, {"frequency": LINES, "unit": "m"})
        path.write_bytes(plain.getvalue() + struct.pack("<II", 15, len(packed)) + packed)
    elif name == "one.txt":
        path = folder / "alone" / "x1_from_x1.txt"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
        (path.parent / "y1_from_y1.txt").write_bytes(content)
        (path.parent / "x1_from_y1.txt").write_bytes(content)
        return rb.load_frf(path.parent, fill=True)
    else:
        path.write_bytes(content)
    if name == "machine.toml":
        return load_machine(path)
    return rb.load_foundation(path) if name.startswith("m.") else rb.load_frf(path)


def outcome(folder: Path, name: str, content: bytes) -> None:
    """Read: a ValueError, or a result of finite numbers, or something is wrong."""
    result = None
    with contextlib.suppress(ValueError):
        result = read(folder, name, content)
    if isinstance(result, rb.FRF):
        assert np.isfinite(result.H).all()
        assert (np.diff(result.frequency) > 0).all()
    if isinstance(result, rb.Foundation):
        assert all(np.isfinite(getattr(result, part)).all() for part in "MCKB")
