"""A book that needs no network: `make book OFFLINE=1` names the folder that tools/offline.py has filled.

Without that folder this extension does nothing, and the pages take MathJax, require.js, the widgets and Python from
their CDNs.
"""

import os
from importlib.resources import files
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

WIDGETS = "offline/html-manager/embed-amd.js"


def local(app: Sphinx, config: Any) -> None:
    """Sphinx's hook once the configuration is read: addresses become files of the book."""
    folder = Path(os.environ["RBFOUND_OFFLINE"])
    if not (folder / "static" / "offline").is_dir():
        raise ExtensionError(f"RBFOUND_OFFLINE is {folder}: tools/offline.py has not filled it.")
    script = files("anywidget").joinpath("nbextension", "index.js").read_text(encoding="utf-8")
    (folder / "static" / "offline" / "anywidget.js").write_text(script, encoding="utf-8")
    config.html_static_path = [*config.html_static_path, str(folder / "static")]
    config.mathjax_path = "offline/mathjax/tex-mml-chtml.js"
    config.nb_ipywidgets_js = {"offline/require.js": {}, WIDGETS: {}}
    config.live_pyodide = str(folder / "pyodide")


def widgets(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Sphinx's hook for each page: where widgets are shown, require.js is told where the one of anywidget lies."""
    names = [str(getattr(script, "filename", script)) for script in context.get("script_files", [])]
    if any(name.endswith(WIDGETS) for name in names):
        place = context["pathto"]("_static/offline/anywidget", 1)
        app.add_js_file(None, body=f'var require = {{paths: {{anywidget: "{place}"}}}};', priority=100)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the hook, if there is a folder."""
    if os.environ.get("RBFOUND_OFFLINE"):
        app.connect("config-inited", local, priority=100)
        app.connect("html-page-context", widgets)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
