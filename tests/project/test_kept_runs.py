"""What decides whether a notebook is run again for the book: its numbers can never be older than what they hang on."""

import json
import os
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import kept_runs
import nbformat
import pytest
from sphinx.errors import ExtensionError

ROOT = Path(__file__).resolve().parents[2]


def write(path: Path, *cells: str, **metadata: Any) -> None:
    """A notebook of these cells, each with this metadata."""
    made = [nbformat.v4.new_code_cell(cell, metadata=metadata) for cell in cells]
    about = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    path.write_text(nbformat.writes(nbformat.v4.new_notebook(cells=made, metadata=about)), encoding="utf-8")


@pytest.fixture
def book(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A book of one notebook, with a package and a datum that it could read, and what its hooks are called with."""
    for name in ("package/sliders.css", "data/foundation/fine.txt", "data/README.md"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("1\n", encoding="utf-8")
    (tmp_path / "notebooks").mkdir()
    write(tmp_path / "notebooks" / "one.ipynb", 'open("../data/foundation/fine.txt").read()')
    monkeypatch.setattr(kept_runs, "PACKAGE", tmp_path / "package")
    config = SimpleNamespace(nb_execution_mode="cache", nb_execution_timeout=60, nb_execution_cache_path="")
    return SimpleNamespace(srcdir=tmp_path, outdir=tmp_path / "_build" / "html", config=config)


def run(book: Any, *names: str) -> Any:
    """Begin a build; the cache afterwards."""
    kept_runs.choose(book, book.config)
    env = SimpleNamespace(doc2path=lambda name: str(book.srcdir / f"{name}.ipynb"))
    kept_runs.run_ahead(book, env, list(names or ["notebooks/one"]))
    return kept_runs.get_cache(book.config.nb_execution_cache_path)


def printed(book: Any, cache: Any) -> str:
    """What the notebook's run shows."""
    notebook = nbformat.read(book.srcdir / "notebooks" / "one.ipynb", as_version=4)
    _, merged = cache.merge_match_into_notebook(notebook)
    return str(merged.cells[0].outputs[0].data["text/plain"])


def test_the_state_is_another_when_a_file_of_the_package_or_a_datum_changes_comes_or_goes(book: Any) -> None:
    states = [kept_runs.state(book.srcdir)]
    css, datum = book.srcdir / "package" / "sliders.css", book.srcdir / "data" / "foundation" / "fine.txt"
    changes = [
        lambda: css.write_text("2\n", encoding="utf-8"),
        lambda: datum.write_text("2\n", encoding="utf-8"),
        lambda: (css.parent / "new.py").write_text("", encoding="utf-8"),
        lambda: (book.srcdir / "notebooks" / "helper.py").write_text("", encoding="utf-8"),
        lambda: datum.rename(datum.with_name("coarse.txt")),
        lambda: css.unlink(),
    ]
    for change in changes:
        change()
        states.append(kept_runs.state(book.srcdir))
    assert len(set(states)) == len(states)


def test_the_state_is_another_with_another_version_of_anything_or_other_threads(
    book: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    states = [kept_runs.state(book.srcdir)]
    (tmp_path / "site" / "numpy-2.0.0.dist-info").mkdir(parents=True)
    states.append(kept_runs.state(book.srcdir))
    (tmp_path / "site" / "numpy-2.0.0.dist-info").rename(tmp_path / "site" / "numpy-2.0.1.dist-info")
    states.append(kept_runs.state(book.srcdir))
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    states.append(kept_runs.state(book.srcdir))
    monkeypatch.setattr(kept_runs.sys, "version", "4.0.0")
    states.append(kept_runs.state(book.srcdir))
    assert len(set(states)) == 5


def test_the_state_stays_when_files_are_touched_and_when_notebooks_pages_and_leavings_change(book: Any) -> None:
    before = kept_runs.state(book.srcdir)
    os.utime(book.srcdir / "package" / "sliders.css", (1, 1))
    write(book.srcdir / "notebooks" / "one.ipynb", "2")
    for name in ("book/page.md", "package/__pycache__/a.pyc", "notebooks/.ipynb_checkpoints/a.py", "data/.DS_Store"):
        (book.srcdir / name).parent.mkdir(parents=True, exist_ok=True)
        (book.srcdir / name).write_text("3\n", encoding="utf-8")
    assert kept_runs.state(book.srcdir) == before


def test_every_installed_distribution_is_in_the_state_by_its_version() -> None:
    known = {
        one.name.lower() for kind in kept_runs.KINDS for path in kept_runs.sys.path for one in Path(path).glob(kind)
    }
    for name in ("numpy", "scipy", "matplotlib"):
        version = __import__(name).__version__
        assert f"{name}-{version}.dist-info" in known


def test_notebooks_read_nothing_but_the_data() -> None:
    # a folder that is read, but is not in FOLDERS, would leave old numbers in the book
    code = [
        "".join(cell["source"])
        for path in (ROOT / "notebooks").glob("*.ipynb")
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]
        if cell["cell_type"] == "code"
    ]
    above = re.findall(r"\.\./(\w*)", "\n".join(code))
    assert set(above) == {"data"}
    assert "data" in kept_runs.FOLDERS


@pytest.mark.slow
def test_a_notebook_shows_the_new_number_when_only_a_datum_has_changed(book: Any) -> None:
    assert printed(book, run(book)) == r"'1\n'"
    first = Path(book.config.nb_execution_cache_path)
    (book.srcdir / "data" / "foundation" / "fine.txt").write_text("2\n", encoding="utf-8")
    assert printed(book, run(book)) == r"'2\n'"
    assert not first.exists()


@pytest.mark.slow
def test_a_notebook_is_run_once_until_its_code_changes_and_a_run_that_failed_is_not_kept(book: Any) -> None:
    path = book.srcdir / "notebooks" / "one.ipynb"
    count = 'print(open("../count.txt", "a").write("x"))'
    for code, runs in ((count, 1), (count, 1), (f"{count}  # again", 2)):
        write(path, code)
        run(book)
        assert (book.srcdir / "count.txt").read_text() == "x" * runs
    write(path, "raise ValueError")
    write(path.with_name("two.ipynb"), "2")
    records = run(book, "notebooks/one", "notebooks/two").list_cache_records()
    assert [Path(record.uri).stem for record in records if record.uri.endswith("two.ipynb")] == ["two"]
    assert len(records) == 3  # and the two of the first notebook that did not fail


def test_nothing_is_kept_when_the_package_changes_while_notebooks_run(
    book: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run_and_cache(timeout: int) -> Any:
        (book.srcdir / "package" / "new.py").write_text("", encoding="utf-8")
        return SimpleNamespace(succeeded=["one"], excepted=[], errored=[])

    executor = SimpleNamespace(run_and_cache=run_and_cache)
    monkeypatch.setattr(kept_runs, "load_executor", lambda *args, **kwargs: executor)
    with pytest.raises(ExtensionError, match="build again"):
        run(book)
    assert not Path(book.config.nb_execution_cache_path).exists()


def test_another_way_to_run_notebooks_is_left_alone(book: Any) -> None:
    book.config.nb_execution_mode = "force"
    kept_runs.choose(book, book.config)
    kept_runs.run_ahead(book, None, ["notebooks/one"])
    kept_runs.check(book, None)
    assert book.config.nb_execution_cache_path == ""
    assert not (book.outdir.parent / ".jupyter_cache").exists()
