"""What is committed of the notebooks: cells that a reader takes in at a glance, and text outputs of a whole run."""

import json
import re
from pathlib import Path
from statistics import median, quantiles
from typing import Any

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parent.parent / "notebooks").glob("*.ipynb"))
TEXT = {"text/plain", "text/markdown", "text/latex"}


@pytest.fixture(params=NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def notebook(request: pytest.FixtureRequest) -> dict[str, Any]:
    return dict(json.loads(request.param.read_text(encoding="utf-8")))


def code(notebook: dict[str, Any]) -> list[dict[str, Any]]:
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def source(cell: dict[str, Any]) -> str:
    return "".join(cell["source"])


def test_every_cell_has_been_run_in_order_from_a_fresh_start(notebook: dict[str, Any]) -> None:
    # nbval compares only what is there: a notebook without outputs would pass it
    cells = code(notebook)
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1)), "run `make notebooks`"


def test_every_printed_cell_has_its_text_committed(notebook: dict[str, Any]) -> None:
    silent = [source(cell) for cell in code(notebook) if re.search(r"^print\(", source(cell), re.MULTILINE)]
    with_text = [
        source(cell)
        for cell in code(notebook)
        if any(out["output_type"] == "stream" and out["name"] == "stdout" for out in cell["outputs"])
    ]
    assert [cell for cell in silent if cell not in with_text] == []


def test_the_notebook_prints_numbers_and_not_only_pictures(notebook: dict[str, Any]) -> None:
    printed = [out for cell in code(notebook) for out in cell["outputs"] if out["output_type"] == "stream"]
    assert any(re.search(r"\d", "".join(out["text"])) for out in printed)


def test_outputs_are_text_without_errors_or_warnings(notebook: dict[str, Any]) -> None:
    outputs = [out for cell in code(notebook) for out in cell["outputs"]]
    assert {out["output_type"] for out in outputs} <= {"stream", "execute_result", "display_data"}
    assert {out["name"] for out in outputs if out["output_type"] == "stream"} <= {"stdout"}
    kinds = {kind for out in outputs for kind in out.get("data", {})}
    assert kinds <= TEXT, "run `make notebooks`: figures are made when the book is built"


def test_nothing_is_committed_that_changes_from_run_to_run(notebook: dict[str, Any]) -> None:
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    ids = [cell["id"] for cell in notebook["cells"]]
    assert ids == [f"cell-{number:02d}" for number in range(1, len(ids) + 1)]
    assert {key for cell in notebook["cells"] for key in cell["metadata"]} <= {"tags", "mystnb"}
    outputs = "".join(str(cell["outputs"]) for cell in code(notebook))
    assert not re.search(r"0x[0-9a-f]{8,}", outputs), "an object's address in memory"


def test_cells_hold_no_logic(notebook: dict[str, Any]) -> None:
    for cell in code(notebook):
        assert not re.search(r"^\s*(def|class|try|with warnings)\b", source(cell), re.MULTILINE), source(cell)
        assert "sys.path" not in source(cell)
        assert "%matplotlib" not in source(cell)


def test_cells_are_short(notebook: dict[str, Any]) -> None:
    lines = [sum(map(bool, source(cell).splitlines())) for cell in code(notebook)]
    assert median(lines) <= 4
    assert quantiles(lines, n=10, method="inclusive")[-1] <= 9
    assert max(lines) <= 20


def test_a_notebook_begins_with_its_title_and_explains_more_than_it_computes(notebook: dict[str, Any]) -> None:
    words = sum(len(source(cell).split()) for cell in notebook["cells"] if cell["cell_type"] == "markdown")
    assert source(notebook["cells"][0]).startswith("# ")
    assert words > 2 * sum(len(source(cell).split()) for cell in code(notebook))


def test_a_chapter_opens_with_a_question_and_a_picture_and_closes_with_what_was_found() -> None:
    for path in NOTEBOOKS[1:]:
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        first = next(k for k, cell in enumerate(cells) if "<Figure size" in str(cell.get("outputs")))
        before = "\n".join(source(cell) for cell in cells[:first] if cell["cell_type"] == "markdown")
        assert re.search(r"^\*\*.+\?\*\*$", before, re.MULTILINE), f"{path.stem} asks nothing"
        assert len(re.findall("^## ", before, re.MULTILINE)) <= 1, f"{path.stem} has no picture in its first section"
        end = "\n".join(source(cell) for cell in cells[-3:])
        assert "## What was found" in end, f"{path.stem} does not say what was found"
        assert all(f"({k}) " in end.split("**Exercises.**")[1] for k in (1, 2, 3)), f"{path.stem}: three exercises"
        assert ":::{dropdown} Solutions" in end, f"{path.stem} has no solutions"
        assert re.match(r"Next: .*\.(ipynb|md)", end.splitlines()[-1]), f"{path.stem} does not lead on"


def test_the_notebooks_of_the_book_are_all_here_in_the_order_of_their_numbers() -> None:
    # the book numbers its chapters as they come: "chapter 19" has to be the file that begins with 19
    toc = (Path(__file__).resolve().parent.parent / "_toc.yml").read_text(encoding="utf-8")
    assert re.findall(r"notebooks/(\w+)", toc) == [path.stem for path in NOTEBOOKS]


def test_the_first_page_has_a_row_for_every_chapter() -> None:
    first = "\n".join(source(cell) for cell in json.loads(NOTEBOOKS[0].read_text(encoding="utf-8"))["cells"])
    rows = dict(re.findall(r"^\| \[(\d+) [^]]+\]\((\w+)\.ipynb\) \|", first, re.MULTILINE))
    assert list(rows.values()) == [path.stem for path in NOTEBOOKS[1:]]
    assert all(int(number) == int(stem[:2]) for number, stem in rows.items())
