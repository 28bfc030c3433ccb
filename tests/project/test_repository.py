"""The repository's own promises: one version, a README whose example runs, a book that leaves no module out."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import accessible
import house
import plain_kernels
import pytest
import yaml
from bs4 import BeautifulSoup
from sphinx.project import Project

import rbfound

ROOT = Path(__file__).resolve().parents[2]


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_is_the_same_everywhere() -> None:
    version = tomllib.loads(text("pyproject.toml"))["project"]["version"]
    assert rbfound.__version__ == version
    assert f"\nversion: {version}\n" in text("CITATION.cff")
    assert f"\n## [{version}]" in text("CHANGELOG.md")


def test_the_core_needs_numpy_and_scipy_and_what_limits_their_threads() -> None:
    needs = tomllib.loads(text("pyproject.toml"))["project"]["dependencies"]
    assert [re.split(r"[<>=]", need)[0] for need in needs] == ["numpy", "scipy", "threadpoolctl"]


def test_the_page_of_the_package_is_built_without_the_extras_that_the_book_does_not_need() -> None:
    # `make book` installs .[book] alone: a module of another extra is shown with that package mocked
    extras = tomllib.loads(text("pyproject.toml"))["project"]["optional-dependencies"]
    (own,) = (re.findall(r"\w+", need) for need in extras["book"] if need.startswith("rbfound["))
    beyond = set(extras) - {*own, "book", "test", "dev"}
    imported = {"progress": "tqdm", "ross": "ross"}
    assert beyond == set(imported)
    (mocked,) = re.findall(r"autodoc_mock_imports: \[(.+)\]", text("_config.yml"))
    assert set(mocked.split(", ")) == set(imported.values())


def test_every_module_is_in_the_reference_once_and_each_page_says_what_its_room_is_for() -> None:
    pages = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "book" / "api").glob("*.md")}
    assert set(pages) == set(house.PAGES.values()) == set(re.findall(r"file: book/api/(\w+)", text("_toc.yml")))
    shown = re.findall(r"automodule:: rbfound\.(\S+)", "\n".join(map(house.reference, pages)))
    assert sorted(shown) == sorted(set(house.modules()) - set(house.FACES))
    for page in pages.values():
        idea, _, rest = page.partition("\n\n")[2].partition("\n\n")
        assert len(re.findall(r"\.(?:\s|$)", idea)) == 3, idea
        assert rest == "% generated: modules\n"


def test_the_picture_of_the_house_shows_each_import_between_rooms_as_a_dot_and_links_each_room() -> None:
    picture, count = house.picture(), house.uses()
    assert ("cli", "files") in count
    assert all(house.floors().index(above) > house.floors().index(below) for above, below in count)
    assert picture.count('class="taken"') == len(count) > 20
    assert re.findall(r'href="api/(\w+)\.html"', picture) == [house.PAGES[floor] for floor in house.floors()]
    assert "theory imports from the core; " in picture


@pytest.mark.parametrize("name", [".env", "env", ".venv"])
def test_a_virtual_environment_is_no_part_of_the_book_whatever_its_name(name: str, tmp_path: Path) -> None:
    for place in ("lib/python3.12/site-packages/numpy/README.md", "share/jupyter/lab/README.md"):
        (tmp_path / name / place).parent.mkdir(parents=True)
        (tmp_path / name / place).write_text("# not a page", encoding="utf-8")
    (tmp_path / "page.md").write_text("# a page", encoding="utf-8")
    excluded = yaml.safe_load(text("_config.yml"))["exclude_patterns"]
    assert Project(str(tmp_path), {".md": "markdown"}).discover(excluded) == {"page"}


def test_kernels_are_alike_without_make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "IPYTHONDIR", "JUPYTER_PREFER_ENV_PATH"):
        monkeypatch.setenv(name, "of this process")  # so that it is put back
        monkeypatch.delenv(name)
    monkeypatch.setenv("MPLBACKEND", "svg")
    plain_kernels.settle(SimpleNamespace(outdir=str(tmp_path / "html")), None)
    said = "import json, os; print(json.dumps(dict(os.environ)))"
    around = json.loads(subprocess.run([sys.executable, "-c", said], capture_output=True, check=True).stdout)
    assert around["OPENBLAS_NUM_THREADS"] == around["OMP_NUM_THREADS"] == around["MKL_NUM_THREADS"] == "1"
    assert "MPLBACKEND" not in around
    settings = Path(around["IPYTHONDIR"]) / "profile_default" / "ipython_kernel_config.py"
    assert "log_level" in settings.read_text(encoding="utf-8")


def test_the_arrow_that_unfolds_pages_in_the_contents_has_a_name() -> None:
    tree = '<li><a href="api.html">The package</a><details><summary><span></span></summary><ul></ul></details></li>'
    context = {"generate_toctree_html": lambda kind: BeautifulSoup(tree, "html.parser") if kind == "sidebar" else ""}
    accessible.process(None, "page", "page.html", context, None)  # type: ignore[arg-type]
    shown = context["generate_toctree_html"]("sidebar")
    assert shown.summary["aria-label"] == "Pages of The package"
    assert context["generate_toctree_html"]("raw") == ""


def test_the_example_of_the_readme_runs(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    (example,) = re.findall(r"```python\n(.+?)```", text("README.md"), re.DOTALL)
    (promised,) = re.findall(r"```text\n(.+?)```", text("README.md"), re.DOTALL)
    monkeypatch.chdir(ROOT)
    exec(compile(example, "README.md", "exec"), {})
    assert capsys.readouterr().out.split() == promised.split()


def test_every_file_that_the_readme_names_is_there() -> None:
    readme = text("README.md")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", readme) if "://" not in link]
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_every_make_target_that_the_readme_names_is_there() -> None:
    targets = set(re.findall(r"^([a-z]+):", text("Makefile"), re.MULTILINE))
    named = set(re.findall(r"make ([a-z]+)", text("README.md") + text("CONTRIBUTING.md")))
    assert named <= targets


def test_every_work_in_the_bibliography_is_cited_by_a_chapter_or_by_its_own_page() -> None:
    keys = set(re.findall(r"^@\w+\{(\w+),", text("book/references.bib"), re.MULTILINE))
    pages = [*ROOT.glob("book/*.md"), *ROOT.glob("notebooks/*.ipynb")]
    cited = re.findall(r"\{cite(?::\w+)?\}`([\w, ]+)`", "".join(page.read_text(encoding="utf-8") for page in pages))
    assert {key.strip() for keys in cited for key in keys.split(",")} == keys


def test_every_work_in_the_bibliography_can_be_found_and_the_page_says_what_it_is_used_for() -> None:
    entries = re.split(r"^@", text("book/references.bib"), flags=re.MULTILINE)[1:]
    keys = {entry.split("{")[1].split(",")[0].strip(): entry for entry in entries}
    # a proceedings paper and a standard without one, and two journals whose numbers we could not look up
    without = {"richardson1982", "iso21940", "vazquez2001", "balmes1997"}
    assert {key for key, entry in keys.items() if not re.search(r"^ *(doi|isbn) *=", entry, re.MULTILINE)} == without
    assert set(re.findall(r"\{cite:t\}`(\w+)`", text("book/bibliography.md"))) == set(keys)


def test_no_test_file_imports_another() -> None:
    # what two of them need is in a file of its own beside their folders: samples, written, browsing
    texts = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py")}
    assert len(texts) > 50
    # a test may start a Python of its own that imports the test's file
    taken = {name: set(re.findall(r"^(?:from|import) (test_\w+)", text, re.MULTILINE)) for name, text in texts.items()}
    assert {name: others - {name} for name, others in taken.items() if others - {name}} == {}
