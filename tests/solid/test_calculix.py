"""The deck for CalculiX, read back word by word, and CalculiX's answers where it is installed."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse

pytest.importorskip("skfem", reason="the solid model needs scikit-fem: pip install 'rbfound[solid]'")

import crosscheck
from calculix import brick_nodes, read_frequencies, write_deck
from crosscheck import MISSING, ask_calculix, ask_rbfound, assemble

from rbfound.solid import (
    Block,
    brick,
    elastic_solid,
    join,
)
from rbfound.solid.mesh import STEEL, Material, rectangle, ring

# Nodes 9 to 20 of CalculiX's brick lie between these corners (counted from 1): its manual's figure of C3D20.
BETWEEN = [(1, 2), (2, 3), (3, 4), (4, 1), (5, 6), (6, 7), (7, 8), (8, 5), (1, 5), (2, 6), (3, 7), (4, 8)]

# CalculiX leaves out of a run what it can not do and goes on: these are all the cards that it may meet here.
CARDS = {"*NODE", "*ELEMENT", "*MATERIAL", "*ELASTIC", "*DENSITY", "*SOLID SECTION", "*SPRING", "*NSET", "*BOUNDARY"}
CARDS |= {"*STEP", "*FREQUENCY", "*END STEP"}

# Laid out as CalculiX 2.20 does it, numbers invented: omega^2 = 1e6 and 4e6 are 159.15... and 318.31... Hz.
SAMPLE = """
     E I G E N V A L U E   O U T P U T

 MODE NO    EIGENVALUE                       FREQUENCY   
                                     REAL PART            IMAGINARY PART
                           (RAD/TIME)      (CYCLES/TIME     (RAD/TIME)

      1   0.1000000E+07   0.1000000E+04   0.1591549E+03   0.0000000E+00
      2   0.4000000E+07   0.2000000E+04   0.3183099E+03   0.0000000E+00

     P A R T I C I P A T I O N   F A C T O R S

MODE NO.   X-COMPONENT     Y-COMPONENT     Z-COMPONENT     X-ROTATION      Y-ROTATION      Z-ROTATION

      1   0.5353908E+00  -0.1283854E-12  -0.9757820E-15   0.9429888E-14   0.3922681E-01  -0.8030862E-02

     E F F E C T I V E   M O D A L   M A S S

      1   0.2866434E+00   0.1648282E-25   0.9521504E-30   0.8892279E-28
"""  # noqa: W291


def at_the_end(places: np.ndarray) -> np.ndarray:
    return places[2] == 0


def bar(rho: float = STEEL.rho) -> list[Block]:
    """2 x 2 x 6 bricks; the upper half may be of another density."""
    (whole,) = [brick((0.02, 0.03, 0.24), (2, 2, 6))]
    return [replace(whole, z=whole.z[:4]), replace(whole, z=whole.z[3:], material=Material(rho=rho))]


def cards_of(path: Path) -> list[tuple[str, dict[str, str], list[list[str]]]]:
    """The cards of a deck: name, parameters, and lines of entries with continued lines put together."""
    cards: list[tuple[str, dict[str, str], list[list[str]]]] = []
    going_on = False
    for line in path.read_text().splitlines():
        assert line.strip()
        assert line.count(",") < 17
        if line.startswith("*"):
            assert not going_on
            name, *parameters = (word.strip() for word in line.split(","))
            cards.append((name, dict(word.split("=") for word in parameters), []))
            continue
        words = [word.strip() for word in line.rstrip(",").split(",")]
        assert all(0 < len(word) <= 20 for word in words)
        assert len(words) <= 16
        if going_on:
            cards[-1][2][-1].extend(words)
        else:
            cards[-1][2].append(words)
        going_on = line.endswith(",")
    return cards


def lines_of(path: Path, card: str) -> list[list[str]]:
    return [line for name, _, lines in cards_of(path) if name == card for line in lines]


def test_the_deck_has_each_node_brick_and_fixed_node_once(tmp_path: Path) -> None:
    write_deck(tmp_path / "bar.inp", bar(2700.0), at_the_end, count=7, element="C3D20R")
    solid = elastic_solid(bar(), at_the_end)
    assert {name for name, _, _ in cards_of(tmp_path / "bar.inp")} == CARDS - {"*SPRING"}
    nodes = np.array(lines_of(tmp_path / "bar.inp", "*NODE"), dtype=float)
    np.testing.assert_array_equal(nodes[:, 0], np.arange(1, solid.mesh.doflocs.shape[1] + 1))
    # 14 digits are written
    np.testing.assert_allclose(nodes[:, 1:], solid.mesh.doflocs.T, rtol=1e-13, atol=1e-15)
    bricks = np.array(lines_of(tmp_path / "bar.inp", "*ELEMENT"), dtype=int)
    assert bricks.shape == (24, 21)
    assert sorted(bricks[:, 0]) == list(range(1, 25))
    assert set(bricks[:, 1:].ravel()) == set(range(1, len(nodes) + 1))
    (fixed,) = lines_of(tmp_path / "bar.inp", "*NSET")
    np.testing.assert_array_equal(np.array(fixed, dtype=int) - 1, np.flatnonzero(at_the_end(solid.mesh.doflocs)))
    assert lines_of(tmp_path / "bar.inp", "*BOUNDARY") == [["FIXED", "1", "3"]]
    assert lines_of(tmp_path / "bar.inp", "*FREQUENCY") == [["7"]]
    assert cards_of(tmp_path / "bar.inp")[-1][0] == "*END STEP"


def test_midside_nodes_lie_between_the_corners_that_calculix_says() -> None:
    mesh, _ = join([brick((1.0, 2.0, 3.0), (2, 1, 1))])
    places = mesh.doflocs[:, brick_nodes(mesh)]
    for node, (a, b) in enumerate(BETWEEN, start=8):
        np.testing.assert_allclose(places[:, node], (places[:, a - 1] + places[:, b - 1]) / 2, atol=1e-15)


def test_a_brick_that_is_inside_out_is_refused() -> None:
    grid = np.linspace(0, 1, 2)
    mesh, _ = join([Block(lambda u, v: (v, u), grid, grid, grid)])
    with pytest.raises(ValueError, match="1 of 1 bricks are inside out, the first is number 0"):
        brick_nodes(mesh)


def test_springs_add_up_to_the_stiffness_that_they_stand_for(tmp_path: Path) -> None:
    blocks = [brick((1.0, 1.0, 1.0), (1, 1, 1))]
    random = np.random.default_rng(3)
    A = random.normal(size=(60, 60)) * (random.random((60, 60)) < 0.05)
    A = A + A.T
    write_deck(tmp_path / "body.inp", blocks, count=3, springs=sparse.csr_array(A))
    cards = cards_of(tmp_path / "body.inp")
    ends = {p["ELSET"]: (p["TYPE"], lines[0]) for name, p, lines in cards if name == "*ELEMENT"}
    assert len({line[0] for _, line in ends.values()}) == len(ends)
    again = np.zeros((60, 60))
    for name, parameters, lines in cards:
        if name == "*SPRING":
            kind, (_, *nodes) = ends[parameters["ELSET"]]
            axes, (stiffness,) = lines
            assert kind == f"SPRING{len(axes)}"
            where = [20 * (int(axis) - 1) + int(node) - 1 for axis, node in zip(axes, nodes, strict=True)]
            sign = np.array([1.0, -1.0])[: len(where)]
            again[np.ix_(where, where)] += float(stiffness) * np.outer(sign, sign)
    np.testing.assert_allclose(again, A, atol=1e-12)
    assert "*BOUNDARY" not in {name for name, _, _ in cards}


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"element": "C3D8"}, "'C3D8': it must be one of C3D20, C3D20R"),
        ({"count": 0}, "^0 frequencies of [0-9]+ free coordinates: ask for at least 1"),
        ({"count": 10**6}, "1000000 frequencies of"),
        ({"fixed": None}, "Nothing holds the body"),
        ({"fixed": lambda places: places[2] > 1}, "Nothing holds the body"),
        ({"springs": sparse.csr_array((3, 3))}, r"The springs are \(3, 3\)"),
        ({"springs": sparse.csr_array(([1.0], ([0], [1])), shape=(603, 603))}, "The springs are not symmetric"),
        ({"path": "bar.txt"}, "bar.txt: CalculiX reads files that end in .inp"),
    ],
)
def test_a_deck_that_can_not_be_run_is_refused(tmp_path: Path, changed: dict, message: str) -> None:
    given = {"path": "bar.inp", "fixed": at_the_end} | changed
    with pytest.raises(ValueError, match=message):
        write_deck(tmp_path / given.pop("path"), bar(), **given)
    assert list(tmp_path.iterdir()) == []


def test_frequencies_come_from_the_column_of_eigenvalues_and_from_no_table_below(tmp_path: Path) -> None:
    (tmp_path / "body.dat").write_text(SAMPLE)
    np.testing.assert_allclose(read_frequencies(tmp_path / "body.dat"), [500 / np.pi, 1000 / np.pi], rtol=1e-14)


def test_a_rigid_motion_whose_square_is_just_below_zero_has_no_frequency(tmp_path: Path) -> None:
    (tmp_path / "body.dat").write_text(SAMPLE.replace("   0.1000000E+07", "  -0.1000000E-03"))
    np.testing.assert_allclose(read_frequencies(tmp_path / "body.dat"), [0, 1000 / np.pi], rtol=1e-14)


@pytest.mark.parametrize("text", ["", SAMPLE.split("\n      1 ")[0], SAMPLE.split("O U T P U T")[1]])
def test_a_file_without_eigenvalues_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "body.dat").write_text(text)
    with pytest.raises(ValueError, match=r"body\.dat has no table of eigenvalues"):
        read_frequencies(tmp_path / "body.dat")


def test_the_second_assembly_gives_the_matrices_of_the_first() -> None:
    blocks = [
        Block(ring((0.0, 0.1), 0.1, 0.2, turn), np.linspace(0, 1, 4), np.linspace(0, 1, 3), np.linspace(0, 0.3, 3))
        for turn in range(4)
    ]
    blocks[1] = replace(blocks[1], material=Material(E=70e9, nu=0.33, rho=2700))
    blocks.append(Block(rectangle, np.linspace(5, 6, 2), np.linspace(5, 6, 3), np.linspace(5, 6, 2)))
    solid = elastic_solid(blocks)
    M, K = assemble(blocks, crosscheck.TWO, crosscheck.THREE)
    assert abs(M - solid.M).max() < 1e-13 * abs(M).max()
    assert abs(K - solid.K).max() < 1e-13 * abs(K).max()


def test_without_calculix_the_tool_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FileNotFoundError, match="apt-get install calculix-ccx"):
        ask_calculix(bar(), at_the_end, 3)
    with pytest.raises(SystemExit, match="apt-get install calculix-ccx"):
        crosscheck.main()


@pytest.fixture
def ccx() -> None:
    if shutil.which("ccx") is None:
        if os.environ.get("RBFOUND_REQUIRE_CCX"):
            pytest.fail(MISSING)
        pytest.skip(MISSING)


@pytest.mark.usefixtures("ccx")
@pytest.mark.parametrize(("element", "order"), [("C3D20", crosscheck.THREE), ("C3D20R", crosscheck.TWO)])
def test_calculix_finds_the_same_frequencies_where_both_integrate_alike(element: str, order: int) -> None:
    blocks = bar(2700.0)
    M, K = assemble(blocks, order, order)
    ours = ask_rbfound(elastic_solid(blocks, at_the_end), 20, M, K)
    # seven digits of omega^2 are printed: 2.5e-7 of omega at the worst
    np.testing.assert_allclose(ask_calculix(blocks, at_the_end, 20, element), ours, rtol=1e-6)


@pytest.mark.usefixtures("ccx")
def test_a_body_on_a_bed_is_compared_with_all_that_holds_it() -> None:
    blocks = [brick((0.2, 0.3, 0.4), (2, 2, 3))]
    solid = elastic_solid(blocks)
    under = np.flatnonzero(np.tile(at_the_end(solid.mesh.doflocs), 3))
    # each node under the body is tied to the ground and to the next one, along all three axes
    line = sparse.diags_array([2e8, -5e7, -5e7], offsets=[0, 1, -1], shape=(len(under),) * 2).tocoo()
    bed = sparse.coo_array((line.data, (under[line.row], under[line.col])), shape=solid.K.shape)
    ways = crosscheck.compare(blocks, replace(solid, K=sparse.csc_array(solid.K + bed)), 12)
    full, reduced = ways["K and M full"][0], ways["K and M reduced"][0]
    np.testing.assert_allclose(ways["C3D20"][0], full, rtol=1e-6)
    np.testing.assert_allclose(ways["C3D20R"][0], reduced, rtol=1e-6)
    # the body moves as a rigid one six times, on the springs: less than half as fast as it bends
    assert full[5] < 0.5 * full[6]
    # fewer points make the bricks softer; of the masses alone that is not so
    assert (ways["K alone reduced"][0] < full * (1 + 1e-9)).all()


@pytest.mark.usefixtures("ccx")
def test_calculix_says_why_it_stopped() -> None:
    hollow = replace(brick((1.0, 1.0, 1.0), (1, 1, 1)), section=lambda u, v: (u, v * (1 - 1.9 * u)))
    with pytest.raises(RuntimeError, match="ccx ended with"):
        ask_calculix([hollow], at_the_end, 3)
