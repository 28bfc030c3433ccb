"""What is committed of the notebooks: cells that a reader takes in at a glance, and text outputs of a whole run."""

import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from statistics import median, quantiles
from typing import Any

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "notebooks").glob("*.ipynb"))
TEXT = {"text/plain", "text/markdown", "text/latex"}


@cache
def cells_of(path: Path) -> list[dict[str, Any]]:
    return list(json.loads(path.read_text(encoding="utf-8"))["cells"])


def code(path: Path) -> list[dict[str, Any]]:
    return [cell for cell in cells_of(path) if cell["cell_type"] == "code"]


def source(cell: dict[str, Any]) -> str:
    return "".join(cell["source"])


def unmet(rule: Callable[[Path], bool]) -> list[str]:
    """The notebooks that do not meet a rule."""
    return [path.stem for path in NOTEBOOKS if not rule(path)]


def test_every_cell_has_been_run_in_order_from_a_fresh_start() -> None:
    # nbval compares only what is there: a notebook without outputs would pass it
    def in_order(path: Path) -> bool:
        return [cell["execution_count"] for cell in code(path)] == list(range(1, len(code(path)) + 1))

    assert unmet(in_order) == [], "run `make notebooks`"


def test_every_printed_cell_has_its_text_committed() -> None:
    def printed(cell: dict[str, Any]) -> bool:
        return any(out["output_type"] == "stream" and out["name"] == "stdout" for out in cell["outputs"])

    silent = [
        f"{path.stem}: {source(cell)}"
        for path in NOTEBOOKS
        for cell in code(path)
        if re.search(r"^print\(", source(cell), re.MULTILINE) and not printed(cell)
    ]
    assert silent == []


def test_every_notebook_prints_numbers_and_not_only_pictures() -> None:
    def prints(path: Path) -> bool:
        printed = [out for cell in code(path) for out in cell["outputs"] if out["output_type"] == "stream"]
        return any(re.search(r"\d", "".join(out["text"])) for out in printed)

    assert unmet(prints) == []


def test_outputs_are_text_without_errors_or_warnings() -> None:
    def text(path: Path) -> bool:
        outputs = [out for cell in code(path) for out in cell["outputs"]]
        kinds = {out["output_type"] for out in outputs} <= {"stream", "execute_result", "display_data"}
        streams = {out["name"] for out in outputs if out["output_type"] == "stream"} <= {"stdout"}
        return kinds and streams and {kind for out in outputs for kind in out.get("data", {})} <= TEXT

    assert unmet(text) == [], "run `make notebooks`: figures are made when the book is built"


def test_nothing_is_committed_that_changes_from_run_to_run() -> None:
    def kept(path: Path) -> bool:
        metadata = json.loads(path.read_text(encoding="utf-8"))["metadata"]
        ids = [cell["id"] for cell in cells_of(path)]
        return (
            set(metadata) == {"kernelspec", "language_info"}
            and ids == [f"cell-{number:02d}" for number in range(1, len(ids) + 1)]
            and {key for cell in cells_of(path) for key in cell["metadata"]} <= {"tags", "mystnb"}
            # an object's address in memory
            and not re.search(r"0x[0-9a-f]{8,}", "".join(str(cell["outputs"]) for cell in code(path)))
        )

    assert unmet(kept) == []


def test_cells_hold_no_logic() -> None:
    logic = [
        f"{path.stem}: {source(cell)}"
        for path in NOTEBOOKS
        for cell in code(path)
        if re.search(r"^\s*(def|class|try|with warnings)\b|sys\.path|%matplotlib", source(cell), re.MULTILINE)
    ]
    assert logic == []


def test_cells_are_short() -> None:
    def short(path: Path) -> bool:
        lines = [sum(map(bool, source(cell).splitlines())) for cell in code(path)]
        return median(lines) <= 4 and quantiles(lines, n=10, method="inclusive")[-1] <= 9 and max(lines) <= 20

    assert unmet(short) == []


def test_a_notebook_begins_with_its_title_and_explains_more_than_it_computes() -> None:
    def explains(path: Path) -> bool:
        words = sum(len(source(cell).split()) for cell in cells_of(path) if cell["cell_type"] == "markdown")
        computed = sum(len(source(cell).split()) for cell in code(path))
        return source(cells_of(path)[0]).startswith("# ") and words > 2 * computed

    assert unmet(explains) == []


def test_a_chapter_opens_with_a_question_and_a_picture_and_closes_with_what_was_found() -> None:
    for path in NOTEBOOKS[1:]:
        cells = cells_of(path)
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
    toc = (Path(__file__).resolve().parents[2] / "_toc.yml").read_text(encoding="utf-8")
    assert re.findall(r"notebooks/(\w+)", toc) == [path.stem for path in NOTEBOOKS]


def test_the_first_page_has_a_row_for_every_chapter() -> None:
    first = "\n".join(source(cell) for cell in cells_of(NOTEBOOKS[0]))
    rows = dict(re.findall(r"^\| \[(\d+) [^]]+\]\((\w+)\.ipynb\) \|", first, re.MULTILINE))
    assert list(rows.values()) == [path.stem for path in NOTEBOOKS[1:]]
    assert all(int(number) == int(stem[:2]) for number, stem in rows.items())
