"""Foundations for other programs: each file is read back by a small reader of its format, and told apart from ours."""

import json
import re

import numpy as np
import pytest
from samples import foundation
from scipy import io as scipy_io
from solver_files import DEGREES, assembled, read_ansys, read_bulk

import rbfound as rb
from rbfound.files import dmig, matrix27

FREQUENCY = np.linspace(1.0, 300.0, 40)


def model(kind):
    """Foundations of each kind: fewer modes than seats, more than two nodes hold, full matrices, odd labels."""
    if kind == "full":
        return rb.thesis.unrounded_foundation()
    if kind == "one mode":
        return foundation(2, 1)
    if kind == "three bearings":
        return foundation(6, 15)
    return foundation(4, 9)


KINDS = ["full", "one mode", "three bearings", "nine modes"]


# --- JSON and MATLAB ---


@pytest.mark.parametrize("ending", ["json", "npz", "mat"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_foundation_comes_back_to_the_last_bit(kind, ending, tmp_path):
    kept = model(kind)
    rb.save_foundation(kept, tmp_path / f"kept.{ending}")
    back = rb.load_foundation(tmp_path / f"kept.{ending}")
    for name in "MCKB":
        np.testing.assert_array_equal(getattr(back, name), getattr(kept, name))
    assert (back.labels, back.notes) == (kept.labels, kept.notes)
    assert [path.name for path in tmp_path.iterdir()] == [f"kept.{ending}"]


def test_json_says_its_units_and_keeps_letters_beyond_ascii(tmp_path):
    kept = rb.Foundation([[2.0]], [[0.1 + 0.2]], [[1e300]], [[1.0]], ("x1",), ('ζ = 2 % "at" 5 Hz\n',))
    rb.save_foundation(kept, tmp_path / "kept.json")
    stored = json.loads((tmp_path / "kept.json").read_text(encoding="utf-8"))
    assert stored["units"]["K"] == "N/m"
    assert stored["C"] == [[0.30000000000000004]]
    assert rb.load_foundation(tmp_path / "kept.json").notes == kept.notes


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "it is no JSON"),
        ("[" * 100_000, "it is no JSON"),
        ("[1]", "it is no foundation"),
        ('{"format": "rbfound foundation 1"}', "it lacks M, C, K, B, labels, notes"),
    ],
)
def test_a_json_of_something_else_is_refused(text, told, tmp_path):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(ValueError, match=rf"a\.json is not a readable \.json file of a foundation: {told}"):
        rb.load_foundation(tmp_path / "a.json")


@pytest.mark.parametrize(
    "wrong", [{"M": [[1, 2], [3]]}, {"M": "heavy"}, {"K": [[float("nan")]]}, {"labels": "x1"}, {"B": [[1e999]]}]
)
def test_a_json_with_a_part_of_the_wrong_kind_is_refused(wrong, tmp_path):
    good = {
        "format": "rbfound foundation 1",
        "M": [[1]],
        "C": [[1]],
        "K": [[1]],
        "B": [[1]],
        "labels": ["x1"],
        "notes": [],
    }
    (tmp_path / "a.json").write_text(json.dumps(good))
    rb.load_foundation(tmp_path / "a.json")
    (tmp_path / "a.json").write_text(json.dumps(good | wrong))
    with pytest.raises(ValueError, match=r"a\.json is not a readable"):
        rb.load_foundation(tmp_path / "a.json")


def test_matlab_finds_the_matrices_under_their_names(tmp_path):
    kept = model("nine modes")
    rb.save_foundation(kept, tmp_path / "kept.mat")
    stored = scipy_io.loadmat(tmp_path / "kept.mat")
    np.testing.assert_array_equal(stored["B"], kept.B)
    assert list(stored["labels"]) == list(kept.labels)


@pytest.mark.parametrize("ending", ["json", "npz", "mat"])
def test_a_write_that_fails_before_its_end_leaves_the_old_file_whole(ending, tmp_path, monkeypatch):
    path = tmp_path / f"kept.{ending}"
    rb.save_foundation(model("full"), path)
    before = path.read_bytes()

    def killed(here, there):
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", killed)
    with pytest.raises(KeyboardInterrupt):
        rb.save_foundation(model("one mode"), path)
    assert path.read_bytes() == before
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


# --- ANSYS ---


def test_the_reader_counts_the_constants_as_the_manual_of_matrix27_does():
    # its example, a spring along UX between both nodes, has C1 = C58 = k and C7 = -k
    constants = np.zeros(78)
    constants[[0, 57]], constants[6] = 5.0, -5.0
    text = "ET,1,MATRIX27\nKEYOPT,1,2,0\nKEYOPT,1,3,4\nR,1," + ",".join(map(str, constants)) + "\nTYPE,1\nREAL,1\nE,8,9"
    matrices, _, _ = read_ansys(text)
    spring = {pair: value for pair, value in matrices[4].items() if value}
    one, two = (8, "UX"), (9, "UX")
    assert spring == {(one, one): 5.0, (two, two): 5.0, (one, two): -5.0, (two, one): -5.0}


@pytest.mark.parametrize("kind", KINDS)
def test_ansys_commands_hold_the_same_foundation_to_the_last_bit(kind):
    kept = model(kind)
    nodes = tuple(100 + 7 * k for k in range(len(kept.labels) // 2))
    matrices, ties, fixed = read_ansys(matrix27(kept, nodes))
    seats = [(nodes[int(label[1]) - 1], "U" + label[0].upper()) for label in kept.labels]
    free = [(9001 + k // 6, DEGREES[k % 6]) for k in range(len(kept.M))]
    assert not fixed & set(free)
    # nothing is left loose: each unknown of the nodes that were made is either a coordinate or fixed
    made = {name for matrix in matrices.values() for pair in matrix for name in pair}
    assert made == set(free) | fixed
    for option, name in ((2, "M"), (4, "K"), (5, "C")):
        A, B = assembled(matrices[option], ties, free, seats)
        np.testing.assert_array_equal(A, (getattr(kept, name) + getattr(kept, name).T) / 2)
        np.testing.assert_array_equal(B, kept.B)
    assert max(map(len, matrix27(kept, nodes).splitlines())) < 160


# --- NASTRAN ---


@pytest.mark.parametrize("kind", KINDS)
def test_a_nastran_bulk_file_holds_the_same_foundation_to_ten_digits(kind):
    kept = model(kind)
    nodes = tuple(1000001 + 5 * k for k in range(len(kept.labels) // 2))
    matrices, ties, points = read_bulk(dmig(kept, nodes, first=501))
    n = len(kept.M)
    assert points == set(range(501, 501 + n))
    back = {}
    for name in "MKC":
        A = np.zeros((n, n))
        for (i, j), value in matrices[f"{name}FOUND"].items():
            A[i - 501, j - 501] = value
        back[name] = A
        np.testing.assert_allclose(A, getattr(kept, name), rtol=5.1e-10, atol=1e-12 * np.abs(getattr(kept, name)).max())
    B = np.zeros_like(kept.B)
    for row, (label, tie) in enumerate(zip(kept.labels, ties, strict=True)):
        assert tie[0] == ((nodes[int(label[1]) - 1], 1 + "xy".index(label[0])), -1.0)
        for (point, component), value in tie[1:]:
            assert component == 0
            B[row, point - 501] = value
    np.testing.assert_allclose(B, kept.B, rtol=5.1e-10)
    if kind != "full":  # whose Phi with condition number 99 multiplies the rounding
        other = rb.Foundation(back["M"], back["C"], back["K"], B, kept.labels)
        H = kept.frf(FREQUENCY).H
        # a resonance with 2 % damping multiplies a relative error by some fifty
        np.testing.assert_allclose(other.frf(FREQUENCY).H, H, rtol=1e-7, atol=1e-8 * np.abs(H).max())


@pytest.mark.parametrize("write", [matrix27, dmig])
def test_what_these_formats_cannot_hold_is_refused(write):
    with pytest.raises(ValueError, match="1 nodes for 2 bearings"):
        write(foundation(), [1])
    with pytest.raises(ValueError, match="2 nodes for 2 bearings"):
        write(foundation(), [1, 1])
    lopsided = rb.Foundation(np.eye(2), np.eye(2), [[1.0, 0.1], [0.0, 1.0]], np.eye(2), ("x1", "y1"))
    with pytest.raises(ValueError, match=r"differs from its transpose by 0\.1 of its largest entry"):
        write(lopsided, [1])
    with pytest.raises(ValueError, match="The seat left has no direction"):
        write(rb.Foundation([[1.0]], [[1.0]], [[1.0]], [[1.0]], ("left",)), [1])
    assert re.search(r"^! seats x1, y1|^\$ seats x1, y1", write(foundation(2, 1), [1]), re.MULTILINE)
