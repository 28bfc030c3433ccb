"""The house of the package: which room imports from which, as a picture, and the pages of the reference.

All of it is read from the source when the book is built, so that it cannot go stale. ROOMS has the order of the rooms;
`tests/project/test_floors.py` takes it from here and keeps it.
"""

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "rbfound"
FOLDER = "book/api"
FACES = ("__init__", "_faces")
# A module imports from its own room and from those before it; "" is the core.
ROOMS = ("", "theory", "measurement", "files", "identification", "solid", "plots", "thesis", "live")
# These lie beside the core, and above all rooms.
LAST = ("studies", "cli")
PAGES = {room: room or "core" for room in ROOMS} | dict.fromkeys(LAST, "studies_cli")


@cache
def modules() -> tuple[str, ...]:
    """All modules, faces excepted, as dotted names without the package's: theory.rigid."""
    paths = (path.relative_to(PACKAGE).with_suffix("") for path in PACKAGE.rglob("*.py"))
    return tuple(sorted(".".join(path.parts) for path in paths if path.name != "__init__"))


def room_of(module: str) -> str:
    """The room of a module, "" for the core."""
    return module.rpartition(".")[0]


def modules_in(room: str) -> list[str]:
    """The modules of a room; of the core, without those above all rooms."""
    return [module for module in modules() if room_of(module) == room and module not in (*LAST, *FACES)]


@cache
def tree_of(module: str) -> ast.Module:
    """The parsed source of a module."""
    return ast.parse((PACKAGE / f"{module.replace('.', '/')}.py").read_text(encoding="utf-8"))


def imports_of(module: str) -> Iterator[tuple[str, tuple[str, ...], ast.stmt]]:
    """(module, names, node) of each import of a module."""
    for node in ast.walk(tree_of(module)):
        if isinstance(node, ast.Import):
            yield from ((alias.name, (), node) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or "", tuple(alias.name for alias in node.names), node


def own_imports(module: str) -> list[tuple[str, tuple[str, ...], ast.stmt]]:
    """The imports of something of the package: (place, names, node), place is what follows `rbfound.`."""
    return [(name.partition(".")[2], *rest) for name, *rest in imports_of(module) if name.split(".")[0] == "rbfound"]


def floors() -> list[str]:
    """What the picture shows, from the ground up: the core, the rooms, and what is above them."""
    return [*ROOMS, *(module for module in LAST if module in modules())]


def uses() -> Counter[tuple[str, str]]:
    """How many names each floor imports from each other one."""
    count: Counter[tuple[str, str]] = Counter()
    for module in set(modules()) - set(FACES):
        here = module if module in LAST else room_of(module)
        for place, names, _ in own_imports(module):
            top = place.partition(".")[0]
            for name in names or ("",):
                there = next((one for one in (top, name) if one in (*ROOMS[1:], *LAST)), "")
                if there != here:
                    count[here, there] += 1
    return count


def first_sentence(floor: str) -> str:
    """What a floor is for: the first sentence of its docstring."""
    path = PACKAGE / f"{floor}.py" if floor in LAST else PACKAGE / floor / "__init__.py"
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return text.split("\n\n")[0].replace("\n", " ").split(". ")[0].rstrip(".") + "."


ROW, LEFT, WALL, RIGHT, TOP = 42, 8, 158, 352, 66


def picture() -> str:
    """The house as SVG: a storey for each room; a pipe from each goes down to the storeys that it imports from."""
    names, count = floors(), uses()
    height = TOP + ROW * len(names) + 10
    level = {floor: TOP + ROW * (len(names) - 1 - k) for k, floor in enumerate(names)}
    alone = [floor for floor in names if any(count[floor, below] for below in names)]
    step = (RIGHT - WALL - 14) / len(alone)
    parts = [f'<path class="roof" d="M{LEFT - 6} {TOP} L{(LEFT + RIGHT) / 2} 8 L{RIGHT + 6} {TOP} Z"/>']
    parts.append(
        f'<text class="name" x="{(LEFT + RIGHT) / 2}" y="{TOP - 20}" text-anchor="middle">import rbfound</text>'
    )
    for floor in names:
        y, label = level[floor], "core" if floor == "" else floor
        size = "one module" if floor in LAST else f"{len(modules_in(floor))} modules"
        parts.append(
            f'<a href="api/{PAGES[floor]}.html"><rect class="storey" x="{LEFT}" y="{y}" width="{RIGHT - LEFT}" '
            f'height="{ROW}"/><text class="name" x="{LEFT + 10}" y="{y + 18}">{label}</text>'
            f'<text class="size" x="{LEFT + 10}" y="{y + 34}">{size}</text></a>'
        )
    for k, floor in enumerate(reversed(alone)):
        x, y = WALL + step * (k + 0.5), level[floor] + ROW / 2
        lowest = max(level[below] for below in names if count[floor, below]) + ROW / 2
        dots = "".join(
            f'<circle class="taken" cx="{x:.1f}" cy="{level[below] + ROW / 2}" r="{3 + taken**0.5 / 2:.1f}">'
            f"<title>{floor} imports {taken} names from {below or 'the core'}</title></circle>"
            for below in names
            if (taken := count[floor, below])
        )
        tap = f'<rect class="tap" x="{x - 4:.1f}" y="{y - 4}" width="8" height="8"><title>{floor}</title></rect>'
        parts.append(f'<g class="pipe"><path d="M{x:.1f} {y} V{lowest}"/>{tap}{dots}</g>')
    return (
        f'<figure class="rbfound-house"><svg viewBox="0 0 {RIGHT + LEFT} {height}" role="group" aria-label="{words()}">'
        f"{''.join(parts)}</svg><figcaption>A square is a room, and the dots below it are the rooms from which it "
        f"imports. A larger dot stands for more names. Each storey is a link to its page.</figcaption></figure>"
    )


def words() -> str:
    """What the picture shows, for those who cannot see it."""
    count = uses()
    told = [
        f"{floor} imports from {', '.join(below or 'the core' for below in floors() if count[floor, below])}"
        for floor in floors()
        if any(count[floor, below] for below in floors())
    ]
    return escape(f"The rooms of the package from the core upwards. {'; '.join(told)}.")


def listing() -> str:
    """The rooms as a list of links, from the core upwards."""
    lines = [f"- [{floor or 'core'}](api/{PAGES[floor]}.md): {first_sentence(floor)}" for floor in floors()]
    return "\n".join(lines)


def reference(page: str) -> str:
    """The modules of a page of the reference, each with all that is public in it."""
    shown = [floor for floor in floors() if PAGES[floor] == page]
    names = [name for floor in shown for name in ([floor] if floor in LAST else modules_in(floor))]
    rooms = "".join(f"```{{py:module}} rbfound.{floor}\n```\n\n" for floor in shown if floor in ROOMS[1:])
    return rooms + "\n\n".join(
        f"## {name.rpartition('.')[2]}\n\n```{{eval-rst}}\n.. automodule:: rbfound.{name}\n   :members:\n```"
        for name in names
    )


def process(app: "Sphinx", docname: str, source: list[str]) -> None:
    """Sphinx's hook: fill in the pages of the reference before they are read."""
    if docname == FOLDER:
        source[0] = source[0].replace("% generated: house", picture()).replace("% generated: rooms", listing())
    elif docname.startswith(f"{FOLDER}/"):
        source[0] = source[0].replace("% generated: modules", reference(docname.rpartition("/")[2]))


def outdated(app: "Sphinx", env: object, added: set[str], changed: set[str], removed: set[str]) -> list[str]:
    """Sphinx's hook: these pages depend on the package, so they are read each time."""
    return [FOLDER, *(f"{FOLDER}/{page}" for page in set(PAGES.values()))]


def setup(app: "Sphinx") -> dict[str, bool]:
    """Register the hooks."""
    app.connect("source-read", process)
    app.connect("env-get-outdated", outdated)
    return {"parallel_read_safe": True}
