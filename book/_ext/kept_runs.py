"""Notebooks are run side by side, and only when something that their numbers hang on has changed.

jupyter-cache knows a run again by the notebook's code alone, and so would show an old number when only the package has
changed. Here each state of all the rest has a cache of its own: the package, the data, Python, what is installed beside
it, the number of threads. What is not in the cache jupyter-cache runs before the pages are read, one notebook a core. A
notebook that fails is not kept: myst-nb runs it again, and reports it.
"""

import hashlib
import logging
import os
import platform
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from jupyter_cache import get_cache
from jupyter_cache.executors import load_executor
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

import rbfound

PACKAGE = Path(rbfound.__file__).parent
# Beside the package: what notebooks read, and what they could import because it lies beside them.
FOLDERS = ("data", "notebooks")
KINDS = ("*.dist-info", "*.egg-info")

logger = logging.getLogger(__name__)


def contents(folder: Path) -> Iterator[str]:
    """Each file of a folder and what is in it; notebooks, whose code jupyter-cache compares, and leavings excepted."""
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder)
        left = any(part.startswith(".") or part == "__pycache__" for part in inside.parts)
        if path.is_file() and path.suffix != ".ipynb" and not left:
            yield f"{folder.name}/{inside.as_posix()} {hashlib.sha256(path.read_bytes()).hexdigest()}"


def state(source: Path) -> str:
    """What a notebook's numbers hang on, beside its code, as a short name."""
    threads = sorted(f"{name}={value}" for name, value in os.environ.items() if name.endswith("_NUM_THREADS"))
    # a distribution's folder bears its version; importlib.metadata takes ten times as long, and each notebook asks
    installed = sorted({one.name for place in sys.path for kind in KINDS for one in Path(place).glob(kind)})
    told = [sys.version, platform.platform(), *threads, *installed]
    for folder in (PACKAGE, *(source / name for name in FOLDERS)):
        told += contents(folder)
    return hashlib.sha256("\n".join(told).encode()).hexdigest()[:20]


def choose(app: Sphinx, config: Any) -> None:
    """Sphinx's hook once the configuration is read: the cache of the present state; those of others are removed."""
    if config.nb_execution_mode != "cache":
        return
    caches = Path(app.outdir).parent / ".jupyter_cache"
    own = caches / state(Path(app.srcdir))
    for other in set(caches.glob("*")) - {own}:
        shutil.rmtree(other) if other.is_dir() else other.unlink()
    config.nb_execution_cache_path = str(own)


def run_ahead(app: Sphinx, env: Any, names: list[str]) -> None:
    """Sphinx's hook before pages are read: jupyter-cache runs the notebooks that it does not have, one a core."""
    if app.config.nb_execution_mode != "cache":
        return
    cache = get_cache(app.config.nb_execution_cache_path)
    for path in (Path(env.doc2path(name)) for name in names):
        if path.suffix == ".ipynb":
            cache.add_nb_to_project(str(path))
    logger.setLevel(logging.INFO)  # each notebook is named on stderr as it begins and ends
    executor = load_executor("local-parallel", cache, logger=logger)
    told = executor.run_and_cache(timeout=app.config.nb_execution_timeout)
    for name in (*told.excepted, *told.errored):
        logger.warning("%s failed, and is run again below", name)
    if changed(app):
        check(app, None)
        raise ExtensionError("The package, the data or the environment changed while notebooks ran: build again.")


def changed(app: Sphinx) -> bool:
    """Whether the state is no longer that of the cache."""
    return state(Path(app.srcdir)) != Path(app.config.nb_execution_cache_path).name


def check(app: Sphinx, error: Exception | None) -> None:
    """Sphinx's hook at the end: what myst-nb has run itself must belong to the state, too."""
    if app.config.nb_execution_mode == "cache" and changed(app):
        shutil.rmtree(app.config.nb_execution_cache_path, ignore_errors=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the hooks."""
    app.connect("config-inited", choose)
    app.connect("env-before-read-docs", run_ahead)
    app.connect("build-finished", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
