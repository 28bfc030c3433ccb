"""Run notebooks and write them back with outputs that a diff can show.

Text outputs only, and nothing that changes from run to run: the figures are made when the book is built, and
`pytest --nbval` compares every committed line with a new run.

    python tools/refresh_notebooks.py notebooks/*.ipynb
"""

import sys
import time
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

TEXT = ("text/plain", "text/markdown", "text/latex")
CELL_METADATA = ("tags", "mystnb")
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def run(path: Path) -> Any:
    """The notebook at `path`, executed in its own folder as JupyterLab would do it."""
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        timeout=600,
        kernel_name="python3",
        resources={"metadata": {"path": str(path.parent)}},
        record_timing=False,
        store_widget_state=False,
        coalesce_streams=True,
    )
    return client.execute()


def complaints(notebook: Any) -> list[str]:
    """What would make the committed outputs differ from machine to machine: anything on stderr."""
    return [
        f"cell {number} wrote to stderr: {output.text.strip()}"
        for number, cell in enumerate(notebook.cells, start=1)
        for output in cell.get("outputs", [])
        if output.output_type == "stream" and output.name == "stderr"
    ]


def normalise(notebook: Any) -> Any:
    """Cells numbered in order, text outputs, and only the metadata that the book reads."""
    for number, cell in enumerate(notebook.cells, start=1):
        cell["id"] = f"cell-{number:02d}"
        cell["metadata"] = {key: cell.metadata[key] for key in CELL_METADATA if key in cell.metadata}
        for output in cell.get("outputs", []):
            if "data" in output:
                output["data"] = {kind: text for kind, text in output.data.items() if kind in TEXT}
                output["metadata"] = {}
    notebook["metadata"] = METADATA
    notebook["nbformat"], notebook["nbformat_minor"] = 4, 5
    return notebook


def refresh(path: Path) -> tuple[bool, list[str]]:
    """Run one notebook and write it back; whether its file changed, and what is wrong with it."""
    before = path.read_text(encoding="utf-8")
    try:
        notebook = run(path)
    except CellExecutionError as error:
        return False, [str(error)]
    wrong = complaints(notebook)
    if wrong:
        return False, wrong
    after = nbformat.writes(normalise(notebook)) + "\n"
    path.write_text(after, encoding="utf-8")
    return after != before, []


def main(names: list[str]) -> int:
    """Refresh each notebook with a line of progress; 1 if any of them failed, and that one is left as it was."""
    failed = 0
    for number, name in enumerate(names, start=1):
        print(f"{number}/{len(names)} {name} ... ", end="", flush=True)
        start = time.perf_counter()
        changed, wrong = refresh(Path(name))
        verdict = "FAILED" if wrong else "refreshed" if changed else "unchanged"
        print(f"{verdict}, {time.perf_counter() - start:.1f} s", *wrong, sep="\n", flush=True)
        failed += bool(wrong)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
