"""The directive `live`: something to play with in the page, computed by the package itself in the reader's browser.

    ```{live} oscillator
    ```

The page holds a still picture, drawn at build by the same functions, and a button. The button loads Pyodide (from
`live_pyodide`: an address, or a folder whose files are then packed into the book) and the package, which is packed
here, from the work tree, at each build. All that is packed travels in scripts: a page opened from a file can load
those, and nothing else.
"""

import io
import json
import zipfile
from base64 import b64encode
from collections.abc import Iterable, Mapping
from functools import cache
from html import escape
from importlib.metadata import PackageNotFoundError, distribution
from itertools import product
from pathlib import Path
from typing import Any

import stills
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective

import rbfound
from rbfound import live
from rbfound.files import UNIVERSAL

ROOT = Path(__file__).resolve().parents[2]
WORKER = Path(__file__).with_name("live_worker.js")
# What Pyodide 0.27.7 fetches for numpy and scipy, before it is compressed for the way.
CORE = ("pyodide.js", "pyodide.asm.js", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json")
PACKAGES = ("numpy", "scipy", "openblas")
BYTES = 36_500_000
# Pure Python that only some of a reader's files need: it travels with the book, and is loaded when one is dropped.
READERS = {"pyuff": UNIVERSAL}
# Rooms and modules of the package that no page uses.
LEFT_OUT = {"plots", "solid", "cli.py", "studies.py", "live/widgets.py"}


class LiveDirective(SphinxDirective):
    """One line in a page's source: a still picture, its description, and room for a button."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """The figure as HTML; other builders get its description."""
        (name,) = self.arguments
        if name not in live.THINGS:
            raise self.error(f"There is nothing named {name!r} to play with: there are {', '.join(live.THINGS)}.")
        self.env.metadata[self.env.docname]["live"] = True
        text = stills.words(started(name, data_folder(self.config)))
        size = download(self.config.live_pyodide) / 1e6
        where = "with this book" if is_folder(self.config.live_pyodide) else "once, then your browser keeps it"
        html = (
            f'<figure class="rbfound-live" id="live-{name}" data-live="{name}" data-front="{live.front(name)}">'
            f'<div class="rbfound-live-still">{pictures(name, text, "../" * self.env.docname.count("/"))}</div>'
            f'<figcaption class="rbfound-live-bar"><span>Python comes into the page for it: {size:.0f} MB, {where}.'
            "<noscript> JavaScript is off here, so the picture stands still.</noscript></span></figcaption></figure>"
        )
        return [nodes.raw("", html, format="html")]


@cache
def started(name: str, folder: Path) -> live.Live:
    """A thing as it begins."""
    return live.start(name, folder)


def still_file(name: str, width: str, theme: str) -> str:
    """Where a still picture lies in the book."""
    return f"_static/live/{name}-{width}-{theme}.webp"


def pictures(name: str, text: str, root: str) -> str:
    """A still picture for each theme, with another one for narrow pages; the theme shows one of them."""
    out = ""
    for theme, kind in (("light", "only-light"), ("dark", "only-dark")):
        wide, narrow = (root + still_file(name, width, theme) for width in ("wide", "narrow"))
        out += f'<picture><source media="(max-width: 599px)" srcset="{narrow}">'
        out += f'<img class="{kind}" alt="{escape(text)}" src="{wide}"></picture>'
    return out


def base64(data: bytes) -> str:
    """Bytes as text."""
    return b64encode(data).decode("ascii")


def is_folder(pyodide: str) -> bool:
    """Whether Pyodide comes from a folder rather than from an address."""
    return "://" not in pyodide


def data_folder(config: Any) -> Path:
    """The folder whose files `live_data` names."""
    return ROOT / str(config.live_folder)


def carried(pyodide: str) -> list[Path]:
    """The files of a Pyodide folder that numpy and scipy need; none for an address."""
    if not is_folder(pyodide):
        return []
    folder = ROOT / pyodide
    lock = folder / "pyodide-lock.json"
    if not lock.is_file():
        raise ExtensionError(f"live_pyodide is {pyodide!r}: there is no pyodide-lock.json in {folder}.")
    known = json.loads(lock.read_text(encoding="utf-8"))["packages"]
    paths = [folder / name for name in (*CORE, *(known[name]["file_name"] for name in PACKAGES))]
    if absent := [path.name for path in paths if not path.is_file()]:
        raise ExtensionError(f"live_pyodide is {pyodide!r}: {', '.join(absent)} cannot be found in {folder}.")
    return paths


def download(pyodide: str) -> int:
    """Bytes that a reader's browser loads for Python."""
    return sum(path.stat().st_size for path in carried(pyodide)) or BYTES


def zipped(entries: Iterable[tuple[str, bytes]]) -> bytes:
    """A zip file that is the same whenever it is made of the same."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries:
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return out.getvalue()


def wheel() -> bytes:
    """The package as a wheel, from the work tree as it stands: the modules and stubs that a page can use."""
    package = Path(rbfound.__file__).parent
    about = f"rbfound-{rbfound.__version__}.dist-info"
    modules = [path.relative_to(package) for path in sorted(package.rglob("*.py*")) if path.suffix in (".py", ".pyi")]
    modules = [path for path in modules if not {path.as_posix(), path.parts[0]} & LEFT_OUT]
    entries = [(f"rbfound/{path.as_posix()}", (package / path).read_bytes()) for path in modules]
    metadata = f"Metadata-Version: 2.1\nName: rbfound\nVersion: {rbfound.__version__}\n"
    entries += [(f"{about}/METADATA", metadata.encode())]
    entries += [(f"{about}/WHEEL", b"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")]
    return zipped(entries)


def reader(name: str) -> bytes:
    """A pure Python package as a wheel, from the environment that builds the book: its modules and its licence."""
    try:
        listed = distribution(name).files or []
    except PackageNotFoundError:
        raise ExtensionError(f"The live pages carry {name}, which is not here: pip install 'rbfound[book]'.") from None
    taken = sorted(path for path in listed if path.suffix == ".py" or path.name in ("METADATA", "WHEEL", "LICENSE"))
    return zipped((path.as_posix(), path.read_binary()) for path in taken)


def data_of(folder: Path, names: Iterable[str]) -> bytes:
    """Some files, and some folders of files, as a zip."""
    paths = [
        path
        for name in names
        for path in ([folder / name] if (folder / name).is_file() else sorted((folder / name).iterdir()))
    ]
    return zipped((path.relative_to(folder).as_posix(), path.read_bytes()) for path in paths)


def scripts(config: Any) -> Mapping[str, Any]:
    """What is packed, by the name of its script."""
    names = sorted({live.front(thing) for thing in live.THINGS})
    fronts = {name: {"js": live.script(name), "css": live.sheet(name)} for name in names}
    own = carried(config.live_pyodide)
    about = {
        "base": "https://pyodide.invalid/" if own else config.live_pyodide.rstrip("/") + "/",
        "bytes": download(config.live_pyodide),
        "carried": [path.name for path in own] or None,
        "data": sorted(config.live_data),
        "readers": READERS,
        "worker": WORKER.read_text(encoding="utf-8"),
        "fronts": fronts,
    }
    data = {f"data-{name}": base64(data_of(data_folder(config), some)) for name, some in config.live_data.items()}
    wheels = {"wheel": base64(wheel()), **{name: base64(reader(name)) for name in READERS}}
    return {"about": about, **wheels, **data, **{path.name: base64(path.read_bytes()) for path in own}}


def pack(app: Sphinx, error: Exception | None) -> None:
    """Sphinx's hook at the end of a build: write the scripts and the still pictures."""
    if error or app.builder.format != "html":
        return
    folder = Path(app.outdir) / "_static" / "live"
    folder.mkdir(parents=True, exist_ok=True)
    for name, value in scripts(app.config).items():
        text = json.dumps(value, ensure_ascii=True)
        script = f"((globalThis.RBFOUND ??= {{}}).files ??= {{}})[{json.dumps(name)}] = {text};\n"
        (folder / f"{name}.js").write_text(script, encoding="ascii")
    for name in live.THINGS:
        thing = started(name, data_folder(app.config))
        for width, theme in product(stills.WIDTHS, stills.THEMES):
            (Path(app.outdir) / still_file(name, width, theme)).write_bytes(stills.still(thing, width, theme))


def add_scripts(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Sphinx's hook for each page: only those with something to play with load its script."""
    if app.env.metadata.get(page, {}).get("live"):
        app.add_js_file("live.js", loading_method="defer")
        app.add_css_file("live.css")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive, its configuration and the hooks."""
    app.add_config_value("live_pyodide", "https://cdn.jsdelivr.net/pyodide/v0.27.7/full/", "html", [str])
    app.add_config_value("live_folder", "data/foundation", "html", [str])
    app.add_config_value("live_data", {}, "html", [dict])
    app.add_directive("live", LiveDirective)
    app.connect("html-page-context", add_scripts)
    app.connect("build-finished", pack)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
