# ruff: noqa: E501  (a case stands on one line)
"""Files as other programs leave them: what is read to the right receptances, and what is refused with which words.

The table of book/formats.md is made of CASES: `python tests/files/test_as_they_come.py` writes it anew.
"""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pytest
from samples import foundation
from scipy import io as scipy_io

import rbfound as rb
from rbfound.files import explained, load_errors
from rbfound.units import from_hertz

PAGE = Path(__file__).parents[2] / "book" / "formats.md"
LINES = np.array([10.0, 20.0, 30.0, 45.0])
FRFS = foundation(2, 3).frf(LINES)
PAIRS = [(i, j) for i in range(2) for j in range(2)]
A = -(from_hertz(LINES)[:, None, None] ** 2) * FRFS.H  # accelerance [m/s2/N]
STIFFNESS = np.linalg.inv(FRFS.H)


def parts(H):
    return H.real, H.imag


def polar(H):
    return np.abs(H), np.degrees(np.angle(H))


def decibels(H):
    return 20 * np.log10(np.abs(H)), np.degrees(np.angle(H))


def written(columns, frequency=LINES, separator="\t"):
    return [separator.join(f"{value:.12g}" for value in row) for row in zip(frequency, *columns, strict=True)]


def texts(heading: str, H=A, cells=parts, name="{i}_from_{j}.txt", frequency=LINES, body=None):
    """A folder with a file for each pair; `body` changes the rows of a file."""

    def make(folder: Path) -> Path:
        for i, j in PAIRS:
            rows = written(cells(H[:, i, j]), frequency)
            rows = rows if body is None else body(rows)
            path = folder / name.format(i="xy"[i] + "1", j="xy"[j] + "1", u="XY"[i], v="XY"[j])
            path.write_text("\n".join([*heading.split("|"), *rows, ""]), encoding="utf-8")
        return folder

    return make


def table(heading: Callable[[int, int], list[str]], cells=parts, name="all.csv", separator=","):
    """One file with all pairs."""

    def make(folder: Path) -> Path:
        words = [word for i, j in PAIRS for word in heading(i, j)]
        columns = [column for i, j in PAIRS for column in cells(A[:, i, j])]
        path = folder / name
        path.write_text("\n".join([separator.join(["Frequency [Hz]", *words]), *written(columns, LINES, separator)]))
        return path

    return make


def complex_cells(folder: Path) -> Path:
    """As pandas writes complex columns."""
    rows = [",".join([f"{f:g}", *(f"{A[k, i, j]:.12g}" for i, j in PAIRS)]) for k, f in enumerate(LINES)]
    words = [f"{'xy'[i]}1/{'xy'[j]}1 [m/s2/N]" for i, j in PAIRS]
    (folder / "all.csv").write_text("\n".join([",".join(["frequency", *words]), *rows]))
    return folder / "all.csv"


def universal(
    H=A, kind=(12, 13), labels=("m/s^2", "N"), abscissa=(18, "Hz"), scale=1.0, real=False, pad=0, word=None,
    directions=((7, 1), (7, 2)), ending="uff", coherence=False,
):  # fmt: skip
    """Datasets 58 in text, unevenly spaced, as the format's description lays them out."""

    def make(folder: Path) -> Path:
        blocks = []
        sets = [(4, i, j) for i, j in PAIRS] + [(6, i, j) for i, j in PAIRS if coherence]
        for function, i, j in sets:
            values = H[:, i, j] if function == 4 else np.full(len(LINES), 0.9)
            rows = [
                f"{scale * f:13.5E}{h.real:20.11E}" + ("" if real or function == 6 else f"{h.imag:20.11E}")
                for f, h in zip(LINES, values, strict=True)
            ]
            width = 1 if real or function == 6 else 2
            rows += [f"{0:13.5E}" + f"{0:20.11E}" * width] * pad
            if word and (i, j) == (1, 1):
                rows[2] = f"{30:13.5E}" + f"{word:>20}" * 2
            ends = [f" NONE      {node:10d}{direction:4d}" for node, direction in (directions[i], directions[j])]
            axes = [(*abscissa,), (kind[0], labels[0]), (kind[1], labels[1]), (0, "NONE")]
            heading = [
                "    -1", "    58", *["NONE"] * 5, f"{function:5d}{0:10d}{0:5d}{0:10d}" + "".join(ends),
                f"{4 if width == 1 else 6:10d}{len(LINES):10d}{0:10d}" + f"{0:13.5E}" * 3,
                *(f"{code:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} {label:20}" for code, label in axes),
            ]  # fmt: skip
            blocks += [*heading, *rows, "    -1"]
        path = folder / f"rig.{ending}"
        path.write_text("\n".join([*blocks, ""]))
        return path

    return make


def arrays(ending="npz", **changes):
    def make(folder: Path) -> Path:
        given = {"frequency": LINES, "H": A, "labels": np.array(["x1", "y1"]), "unit": np.array(["m/s2/N"]), **changes}
        given = {name: value for name, value in given.items() if value is not None}
        path = folder / f"rig.{ending}"
        scipy_io.savemat(path, given) if ending == "mat" else np.savez(path, **given)
        return path

    return make


def holding(content: bytes, name: str):
    def make(folder: Path) -> Path:
        (folder / name).write_bytes(content)
        return folder / name

    return make


def with_static_nan(rows):
    return ["0\tnan\tnan", *rows]


class Case(NamedTuple):
    """A kind of file, what it has of its own, its maker, what the caller says, and the refusal (None: it is read)."""

    format: str
    what: str
    make: Callable[[Path], Path]
    said: Mapping[str, Any] = MappingProxyType({})
    refused: str | None = None


IN_G = "Frequency [Hz]\tReal [g/N]\tImaginary [g/N]"
SI = "Frequency [Hz]\tReal [m/s2/N]\tImaginary [m/s2/N]"
INVERSE = "unit 'N/m' is that of stiffness. Say quantity='stiffness'"
G = A / 9.80665
CASES = [
    Case("text", "`(mm/s)/N`", texts("Frequency\tReal [(mm/s)/N]\tImag [(mm/s)/N]", 1e3 * A / (2j * np.pi * LINES[:, None, None]))),
    Case("text", "`m/(N s²)`", texts("Frequency\tReal [m/(N s²)]\tImag [m/(N s²)]")),
    Case("text", "`1/kg`", texts("Frequency\tReal [1/kg]\tImag [1/kg]")),
    Case("text", "`G/lb`", texts("Frequency\tReal [G/lb]\tImag [G/lb]", G * 4.4482216152605)),
    Case("text", "`Re(H) [..]`", texts("Frequency [Hz]\tRe(H) [m/s2/N]\tIm(H) [m/s2/N]")),
    Case("text", "`Mag (..)`", texts("Freq (Hz)\tMag (g/N)\tPhase (deg)", G, polar)),
    Case("text", "a row of units below the heading", texts("Frequency\tReal\tImaginary|Hz\tm/s2/N\tm/s2/N")),
    Case("text", "lines above the heading that begin with a number", texts(f"16 averages\t2 s|801\t0.5|{SI}")),
    Case("text", "pages that repeat the heading", texts(SI, body=lambda rows: [*rows[:2], "", SI, *rows[2:]])),
    Case("text", "`rad/sec`", texts(SI.replace("Hz", "rad/sec"), frequency=from_hertz(LINES))),
    Case("text", "`CPM`", texts(SI.replace("Hz", "CPM"), frequency=60 * LINES)),
    Case("text", "no number at 0 Hz", texts(SI, body=with_static_nan)),
    Case("text", "grids that differ in the seventh digit", texts(SI, frequency=LINES * (1 + 1e-7))),
    Case("text", "`dB re 1 m/s2/N`", texts("Frequency [Hz]\tMag [dB re 1 m/s2/N]\tPhase [deg]", A, decibels)),
    Case("text", "decibels, their reference said by the caller", texts("Frequency [Hz]\tMagnitude (dB)\tPhase (deg)", A, decibels), {"unit": "dB re m/s2/N"}),
    Case("text", "stiffness, said by the caller", texts("Frequency [Hz]\tReal [N/m]\tImaginary [N/m]", STIFFNESS), {"quantity": "stiffness"}),
    Case("text", "phases of exp(-iωt), said by the caller", texts(SI, A.conj()), {"conjugate": True}),
    Case("text", "a motion recorded later than the force, said by the caller", texts(SI, A * np.exp(-1e-3j * from_hertz(LINES)[:, None, None])), {"delay": 1e-3}),
    Case("text", "seats named `x01`", texts(SI, name="{u}01_from_{v}01.txt")),
    Case("text", "seats named `1X`", texts(SI, name="h_1{u}_from_1{v}.txt")),
    Case("text", "[N/m], and no quantity said", texts("Frequency [Hz]\tReal [N/m]\tImaginary [N/m]"), {}, INVERSE),
    Case("text", "[N/m], and `unit=` says m", texts("Frequency [Hz]\tReal [N/m]\tImaginary [N/m]"), {"unit": "m"}, "says that its unit is 'N/m', unit= says 'm'"),
    Case("text", "[V/V], whatever `unit=` says", texts("Frequency [Hz]\tReal [V/V]\tImaginary [V/V]"), {"unit": "g"}, "'V/V' is not known.* where the heading is wrong, mend it"),
    Case("text", "(dB), and `unit=` says m/s2", texts("Frequency [Hz]\tMagnitude (dB)\tPhase (deg)", A, decibels), {"unit": "m/s2"}, "unit is 'dB', unit= says 'm/s2'"),
    Case("text", "(dB) without a reference", texts("Frequency [Hz]\tMagnitude (dB)\tPhase (deg)", A, decibels), {}, "reference is missing: 'dB re 1 m/N'"),
    Case("text", "`columns=` with another unit than the heading", texts(IN_G), {"columns": "frequency [Hz], real [m/s2/N], imaginary [m/s2/N]"}, "heading says 'Real \\[g/N\\]', columns= says 'real \\[m/s2/N\\]'"),
    Case("text", "`columns=` with another order than the heading", texts(IN_G), {"columns": "frequency [Hz], imaginary [g/N], real [g/N]"}, "heading says 'Real \\[g/N\\]', columns= says 'imaginary \\[g/N\\]'"),
    Case("text", "a workbook of Excel", holding(b"PK\x03\x04\x14\x00\x06\x00", "rig.xlsx"), {}, "rig.xlsx is a workbook of Excel.*: save the sheet as text"),
    Case("text, one table", "`x1/y1 re [..]`", table(lambda i, j: [f"{'xy'[i]}1/{'xy'[j]}1 {part} [m/s2/N]" for part in ("re", "im")])),
    Case("text, one table", "complex cells below `x1/y1 [..]`", complex_cells),
    Case("text, one table", "points `1:+X`, `1:-Y`", table(lambda i, j: [f"1:+{'XY'[i]} from 1:+{'XY'[j]} {part} [m/s2/N]" for part in ("re", "im")])),
    Case("text, one table", "`pattern=`", table(lambda i, j: [f"{'xy'[i]}1/{'xy'[j]}1 {part} [m/s2/N]" for part in ("re", "im")]), {"pattern": "{response}_{force}.txt"}, "pattern= means nothing for such a file"),
    Case("Universal File", "abscissa in rad/s", universal(abscissa=(18, "rad/s"), scale=2 * np.pi)),
    Case("Universal File", "abscissa in rpm, by its label or its type", universal(abscissa=(19, "NONE"), scale=60.0)),
    Case("Universal File", "the unit in the ordinate's label alone", universal(kind=(1, 0), labels=("(1/N)*(m/s^2)", "NONE"))),
    Case("Universal File", "a last row filled up with zeros", universal(pad=2)),
    Case("Universal File", "the ending .txt", universal(ending="txt")),
    Case("Universal File", "any directions, mapped by the caller", universal(directions=((12, 3), (7, -1))), {"seats": "12+Z = x1, 7-X = y1"}),
    Case("Universal File", "apparent mass, said by the caller", universal(np.linalg.inv(A), (13, 12), ("N", "m/s^2")), {"quantity": "apparent mass"}),
    Case("Universal File", "directions of Z, not mapped", universal(directions=((12, 3), (7, 1))), {}, "at node 12 in direction 3: .* seats='12Z = y1"),
    Case("Universal File", "rotations", universal(directions=((12, 4), (7, 1))), {}, "dataset 1 is at node 12 in direction 4"),
    Case("Universal File", "real ordinates", universal(real=True), {}, "dataset 1 holds real ordinates"),
    Case("Universal File", "force over motion, and `unit=` says m/s2", universal(kind=(13, 12), labels=("NONE", "NONE")), {"unit": "m/s2"}, "that of accelerance, not of apparent mass"),
    Case("Universal File", "another unit than `unit=` says", universal(kind=(1, 0), labels=("(m/s^2)/N", "NONE")), {"unit": "g"}, "says that its unit is '\\(m/s\\^2\\)/N', unit= says 'g'"),
    Case("Universal File", "NaN", universal(word="NaN"), {}, "dataset 4: the value at 30 is .*nan"),
    Case("Universal File", "text among the numbers", universal(word="*****"), {}, "dataset 4, line 70 is not readable"),
    Case("Universal File", "`columns=`", universal(), {"columns": "f [Hz], re, im"}, "columns= means nothing for such a file"),
    *(
        case
        for kind in ("npz", "mat")
        for case in (
            Case(f".{kind}", "no number at 0 Hz", arrays(kind, frequency=np.append(0, LINES), H=np.concatenate([np.full((1, 2, 2), np.nan), A]))),
            Case(f".{kind}", "labels `1X`, `y01`", arrays(kind, labels=np.array(["1X", "y01"]))),
            Case(f".{kind}", "decibels", arrays(kind, unit=np.array(["dB re 1 m/N"])), {}, "decibels have lost their phase"),
            Case(f".{kind}", "other names: those that are there are listed", arrays(kind, H=None, Y=A), {}, "holds no H: .* It holds .*Y"),
            *(Case(f".{kind}", f"`{name}=`", arrays(kind), {name: value}, f"{name}= means nothing for such a file") for name, value in {"columns": "f", "pattern": "{number}", "fill": True}.items()),
        )
    ),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.format}: {case.what}")
def test_a_file_is_read_to_its_receptances_or_refused_with_the_reason(case, tmp_path):
    if case.format == "Universal File":
        pytest.importorskip("pyuff", reason="UFF needs pyuff: pip install 'rbfound[uff]'")
    path = case.make(tmp_path)
    if case.refused is not None:
        with pytest.raises(ValueError, match=case.refused):
            rb.load_frf(path, **case.said)
        return
    frf = rb.load_frf(path, **case.said)
    assert frf.labels == FRFS.labels
    # six digits of an uneven grid, of which an acceleration takes the square; eleven or more of the values, which an
    # inverse loses to the condition of these matrices
    np.testing.assert_allclose(frf.frequency, LINES, rtol=1e-5 if case.format == "Universal File" else 1e-6)
    largest = np.abs(FRFS.H).max(axis=(1, 2), keepdims=True)
    grid = 2 * np.abs(frf.frequency / LINES - 1).max()
    np.testing.assert_array_less(
        np.abs(frf.H - FRFS.H) / largest, grid * (1 + 1e-3) + 1e-9 * np.linalg.cond(FRFS.H).max()
    )


def generated() -> str:
    rows: dict[str, tuple[list[str], list[str]]] = {}
    for case in CASES:
        rows.setdefault(case.format, ([], []))[case.refused is not None].append(case.what)
    told = [f"| {name} | {'; '.join(read)} | {'; '.join(refused)} |" for name, (read, refused) in rows.items()]
    return "\n".join(["| Format | Read | Refused |", "| --- | --- | --- |", *told])


MADE = re.compile(r"(?<=<!-- made -->\n\n).*?(?=\n\n<!-- end -->)", re.DOTALL)


def test_the_page_shows_the_table_of_these_cases():
    assert MADE.search(PAGE.read_text(encoding="utf-8"))[0] == generated()


def test_arrays_in_memory_become_receptances_and_contradictions_are_refused():
    velocity = A / (1j * from_hertz(LINES)[:, None, None])
    frf = rb.FRF.from_arrays(LINES, 1e3 * velocity, FRFS.labels, unit="mm/s/N", quantity="mobility")
    np.testing.assert_allclose(frf.H, FRFS.H, rtol=1e-12)
    with pytest.raises(ValueError, match="of mobility, not of receptance"):
        rb.FRF.from_arrays(LINES, velocity, FRFS.labels, unit="m/s/N", quantity="receptance")
    with pytest.raises(ValueError, match="singular"):
        rb.FRF.from_arrays(LINES, np.zeros((4, 2, 2)), FRFS.labels, unit="N/m", quantity="stiffness")


@pytest.mark.parametrize(
    "make",
    [
        universal(coherence=True),
        arrays(coherence=np.full(A.shape, 0.9)),
        texts(SI + "\tCoherence", A, lambda H: (H.real, H.imag, np.full(len(H), 0.9))),
    ],
)
def test_coherence_in_a_file_becomes_the_errors_of_its_frfs(make, tmp_path):
    pytest.importorskip("pyuff", reason="UFF needs pyuff: pip install 'rbfound[uff]'")
    # even over all lines, as four are fewer than nine: the mean of what each line's edge-padded window sees of |A|^2
    seen = np.pad(np.abs(A) ** 2, ((4, 4), (0, 0), (0, 0)), mode="edge")
    even = np.array([seen[k : k + 9].mean(axis=0) for k in range(4)])
    expected = np.sqrt(even * 0.1 / 0.9 / 10) / from_hertz(LINES)[:, None, None] ** 2
    np.testing.assert_allclose(load_errors(make(tmp_path), 11), expected, rtol=1e-4)


def test_errors_are_refused_without_coherences_and_for_impossible_ones(tmp_path):
    with pytest.raises(ValueError, match="does not hold the coherence"):
        load_errors(arrays()(tmp_path), 11)
    with pytest.raises(ValueError, match=r"coherences from 1\.1 to 1\.1 of 11 averages"):
        load_errors(arrays(coherence=np.full(A.shape, 1.1))(tmp_path), 11)


def test_what_is_understood_of_a_file_is_shown_line_by_line(tmp_path):
    told = explained(texts(IN_G + "\tTime", G, lambda H: (H.real, H.imag, np.zeros(len(H))))(tmp_path))
    row = next(line for line in told.splitlines() if "x1_from_y1.txt" in line)
    assert re.search(r"x1 +y1 +accelerance +g/N +exp\(i w t\) +10.* +45.* +4 +Time", row)


def test_a_smaller_set_leaves_no_file_of_a_larger_one_before_it_and_all_others(tmp_path):
    rb.save_frf(foundation(4, 3).frf(LINES), tmp_path)
    (tmp_path / "x3_from_x3.md").write_text("mine")
    rb.save_frf(FRFS, tmp_path)
    assert len(list(tmp_path.glob("*.txt"))) == 4
    assert (tmp_path / "x3_from_x3.md").exists()
    assert rb.load_frf(tmp_path).labels == ("x1", "y1")


if __name__ == "__main__":
    PAGE.write_text(MADE.sub(lambda _: generated(), PAGE.read_text(encoding="utf-8")), encoding="utf-8")
