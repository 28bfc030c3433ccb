"""The repository's own promises: one version, a README whose example runs, a book that leaves no module out."""

import re
import tomllib
from pathlib import Path

import pytest

import rbfound

ROOT = Path(__file__).resolve().parents[2]


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_is_the_same_everywhere() -> None:
    version = tomllib.loads(text("pyproject.toml"))["project"]["version"]
    assert rbfound.__version__ == version
    assert f"\nversion: {version}\n" in text("CITATION.cff")
    assert f"\n## [{version}]" in text("CHANGELOG.md")


def test_the_core_needs_numpy_and_scipy_only() -> None:
    needs = tomllib.loads(text("pyproject.toml"))["project"]["dependencies"]
    assert [re.split(r"[<>=]", need)[0] for need in needs] == ["numpy", "scipy"]


def test_the_page_of_the_package_is_built_without_the_extras_that_the_book_does_not_need() -> None:
    # `make book` installs .[book] alone: a module of another extra is shown with that package mocked
    extras = tomllib.loads(text("pyproject.toml"))["project"]["optional-dependencies"]
    (own,) = (re.findall(r"\w+", need) for need in extras["book"] if need.startswith("rbfound["))
    beyond = set(extras) - {*own, "book", "test", "dev"}
    imported = {"progress": "tqdm", "ross": "ross"}
    assert beyond == set(imported)
    (mocked,) = re.findall(r"autodoc_mock_imports: \[(.+)\]", text("_config.yml"))
    assert set(mocked.split(", ")) == set(imported.values())


def test_every_module_is_on_the_page_of_the_package_once() -> None:
    shown = re.findall(r"automodule:: (rbfound[.\w]*)", text("book/api.md"))
    paths = [path.relative_to(ROOT).with_suffix("") for path in ROOT.glob("rbfound/**/*.py")]
    names = {".".join(path.parts).removesuffix(".__init__") for path in paths}
    assert sorted(shown) == sorted(names - {"rbfound", "rbfound._faces"})


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
