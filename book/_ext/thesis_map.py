"""The map of the thesis: where each of its equations, tables and figures is in the book, the package and the tests.

Nothing of it is written by hand, so that it cannot go stale. A chapter is found by the labels of its equations
(eq-62-64 holds 62, 63 and 64) and by the tables and figures that its text names, a function by the numbers in its
docstring, a test by the functions that it uses. `book/thesis.toml` has a few words for each number, and the reason for
each figure that is not made.
"""

import ast
import json
import re
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = "book/map"
SPAN = r"\d+(?:[-–]\d+| to \d+)?"
SPANS = rf"({SPAN}(?:(?:, | and ){SPAN})*)"
LABEL = re.compile(r"^\$\$ *\(eq-(\d+(?:-\d+)?)\)", re.MULTILINE)


@dataclass(frozen=True)
class Place:
    """Where one number of the thesis is."""

    number: int
    what: str
    pages: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    functions: tuple[str, ...] = ()  # dotted names; a module where only its own docstring has the number
    tests: tuple[str, ...] = ()  # files, those with the most tests first
    remark: str = ""


def spans(text: str) -> set[int]:
    """The numbers in "7, 50-52 and 54"."""
    found = set()
    for span in re.findall(SPAN, text):
        first, *last = map(int, re.findall(r"\d+", span))
        found |= set(range(first, (last or [first])[0] + 1))
    return found


@cache
def named(text: str, word: str) -> frozenset[int]:
    """The numbers that a text gives after a word: equation(s), table(s) or figure(s)."""
    return frozenset(n for match in re.findall(rf"\b{word}s? {SPANS}", text, re.IGNORECASE) for n in spans(match))


@cache
def pages() -> dict[str, str]:
    """The text of each page, without its code: docname to Markdown."""
    texts = {}
    for path in sorted(ROOT.glob("notebooks/*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        texts[f"notebooks/{path.stem}"] = "\n\n".join(
            "".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown"
        )
    for path in sorted(ROOT.glob("book/*.md")):
        texts[f"book/{path.stem}"] = path.read_text(encoding="utf-8")
    return texts


def chapters_first(names: Iterable[str]) -> tuple[str, ...]:
    """Chapters in their order; another page only where no chapter has it."""
    names = sorted(names, key=lambda name: (not name.startswith("notebooks/"), name))
    return tuple(name for name in names if name.startswith("notebooks/")) or tuple(names)


def module_of(path: Path) -> str:
    """The dotted name of a module of the package."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def modules() -> frozenset[str]:
    """The dotted names of all modules of the package."""
    return frozenset(module_of(path) for path in ROOT.glob("rbfound/**/*.py"))


def documented(path: Path) -> Iterator[tuple[str, str]]:
    """Dotted name and docstring of a module and of all that is public in it."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    module = module_of(path)
    todo: list[tuple[str, ast.Module | ast.ClassDef | ast.FunctionDef]] = [(module, tree)]
    while todo:
        name, node = todo.pop(0)
        yield name, ast.get_docstring(node) or ""
        if isinstance(node, ast.Module | ast.ClassDef):
            inside = [n for n in node.body if isinstance(n, ast.ClassDef | ast.FunctionDef)]
            todo += [(f"{name}.{n.name}", n) for n in inside if not n.name.startswith("_")]


@cache
def docstrings() -> dict[str, str]:
    """Docstrings of the package, by dotted name."""
    return {name: text for path in sorted(ROOT.glob("rbfound/**/*.py")) for name, text in documented(path)}


def functions(number: int, word: str) -> tuple[str, ...]:
    """What has the number in its docstring; a module only where nothing in any module has."""
    all_of_them = [name for name, text in docstrings().items() if number in named(text, word)]
    narrow = [name for name in all_of_them if name not in modules()]
    return tuple(narrow or all_of_them)


@cache
def uses() -> dict[str, dict[str, set[str]]]:
    """Names that each test uses, itself or through the helpers of its file: file, test, names."""
    found = {}
    for path in sorted(ROOT.glob("tests/*/test_*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        bodies = {node.name: names_in(node) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        reached = {}
        for test in (name for name in bodies if name.startswith("test_")):
            names: set[str] = set()
            todo = {test}
            while todo:
                one = todo.pop()
                new = bodies.get(one, set()) - names
                names |= new
                todo |= new & set(bodies)
            reached[test] = names
        found[path.stem] = reached
    return found


def names_in(node: ast.AST) -> set[str]:
    """Every name, attribute and argument in a piece of code."""
    parts = ast.walk(node)
    return {getattr(part, "id", None) or getattr(part, "attr", None) or getattr(part, "arg", "") for part in parts}


def tests(names: Iterable[str]) -> tuple[str, ...]:
    """Test files that use one of these functions, those with the most such tests first."""
    count: dict[str, int] = defaultdict(int)
    for name in names:
        whole_module = name in modules()
        wanted = {n.rpartition(".")[2] for n in docstrings() if n.rpartition(".")[0] == name} if whole_module else set()
        wanted.add(name.rpartition(".")[2])
        for file, found in uses().items():
            # a module's functions may have common names, so the file has to name the module as well
            if not whole_module or re.search(rf"\b{name.rpartition('.')[2]}\b", source(file)):
                count[file] += sum(bool(wanted & used) for used in found.values())
    return tuple(sorted((file for file in count if count[file]), key=lambda file: (-count[file], file)))


@cache
def source(file: str) -> str:
    """Text of a test file."""
    (path,) = ROOT.glob(f"tests/*/{file}.py")
    return path.read_text(encoding="utf-8")


def tests_that_name(number: int, word: str) -> tuple[str, ...]:
    """Test files whose text has the number; the test of this map has some only to try it out."""
    files = [path for path in sorted(ROOT.glob("tests/*/test_*.py")) if path.name != "test_map.py"]
    return tuple(path.stem for path in files if number in named(source(path.stem), word))


@cache
def words() -> dict[str, dict[str, str]]:
    """`book/thesis.toml`."""
    return tomllib.loads((ROOT / "book" / "thesis.toml").read_text(encoding="utf-8"))


def equations() -> list[Place]:
    """All equations of the thesis."""
    labels = defaultdict(list)
    for page, text in pages().items():
        for label in LABEL.findall(text):
            for number in spans(label):
                labels[number].append((page, f"eq-{label}"))
    places = []
    for number, what in ((int(n), what) for n, what in words()["equations"].items()):
        told = functions(number, "equation")
        places.append(
            Place(
                number,
                what,
                tuple(page for page, _ in labels[number]),
                tuple(label for _, label in labels[number]),
                told,
                tuple(dict.fromkeys((*tests_that_name(number, "equation"), *tests(told)))),
                "definition" if number in words()["definitions"] else "",
            )
        )
    return places


def mentioned(kind: str) -> list[Place]:
    """All tables, or all figures, of the thesis."""
    word = kind.removesuffix("s")
    places = []
    for number, what in ((int(n), what) for n, what in words()[kind].items()):
        where = chapters_first(p for p, text in pages().items() if p != PAGE and number in named(text, word))
        told = functions(number, word)
        remark = words()["instead"].get(str(number), "") if kind == "figures" else ""
        places.append(Place(number, what, where, (), told, tests_that_name(number, word), remark))
    return places


def link(name: str) -> str:
    """A reference to something of the package."""
    return f"{{py:mod}}`{name}`" if name in modules() else f"{{py:obj}}`{name.removeprefix('rbfound.')} <{name}>`"


def chapter(page: str) -> str:
    """A reference to a page, by the number of its chapter where it has one."""
    number = re.match(r"notebooks/(\d+)", page)
    return f"{{doc}}`{int(number[1]) if number else page.removeprefix('book/')} </{page}>`"


def some(items: Iterable[str], most: int) -> str:
    """The first few, and how many more."""
    items = list(items)
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(items[:most]) + more


def table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    lines = [list(heads), ["---"] * len(list(heads)), *map(list, rows)]
    return "\n".join(f"| {' | '.join(cell or '–' for cell in line)} |" for line in lines)


def equation_rows() -> Iterator[list[str]]:
    """One row an equation."""
    for p in equations():
        where = " ".join(f"{chapter(page)} {{eq}}`{label}`" for page, label in zip(p.pages, p.labels, strict=True))
        what = f"{p.what} (*definition*)" if p.remark else p.what
        checks = some((f"`{t}`" for t in p.tests), 2)
        yield [f"({p.number})", what, where, some(map(link, p.functions), 3), checks]


def table_rows() -> Iterator[list[str]]:
    """One row a table."""
    for p in mentioned("tables"):
        yield [str(p.number), p.what, ", ".join(map(chapter, p.pages)), some((f"`{t}`" for t in p.tests), 3)]


def figure_rows() -> Iterator[list[str]]:
    """One row a figure."""
    for p in mentioned("figures"):
        yield [str(p.number), p.what, ", ".join(map(chapter, p.pages)) or p.remark]


def sentence() -> str:
    """The counts, as a sentence."""
    every, tables, figures = equations(), mentioned("tables"), mentioned("figures")
    definitions = sum(bool(p.remark) for p in every)
    shown = sum(bool(p.pages) for p in figures)
    return (
        f"**{sum(bool(p.labels) for p in every)} of {len(every)} equations** are in a chapter, {definitions} of them "
        f"definitions, which no test can fail; **{sum(bool(p.pages) for p in tables)} of {len(tables)} tables** are; "
        f"and **{shown} of {len(figures)} figures** are made again under their number, of our own machine where the "
        f"original's is not at hand. Where one is not made, its line says why."
    )


def generated() -> dict[str, str]:
    """What the page's four markers stand for."""
    return {
        "counts": sentence(),
        "equations": table(["no.", "what it is", "chapter", "function", "tests"], equation_rows()),
        "tables": table(["no.", "what it shows", "chapter", "tests"], table_rows()),
        "figures": table(["no.", "what it shows", "chapter, or why none"], figure_rows()),
    }


def process(app: "Sphinx", docname: str, source: list[str]) -> None:
    """Sphinx's hook: fill in the page before it is read."""
    if docname == PAGE:
        for name, text in generated().items():
            source[0] = source[0].replace(f"% generated: {name}", text)


def outdated(app: "Sphinx", env: object, added: set[str], changed: set[str], removed: set[str]) -> list[str]:
    """Sphinx's hook: the page depends on all others, so it is read each time."""
    return [PAGE]


def setup(app: "Sphinx") -> dict[str, bool]:
    """Register the hooks."""
    app.connect("source-read", process)
    app.connect("env-get-outdated", outdated)
    return {"parallel_read_safe": True}
