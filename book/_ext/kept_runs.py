"""Notebooks are run side by side, and only when something that their numbers hang on has changed.

jupyter-cache knows a run again by the notebook's code alone, and so would show an old number when only the package has
changed. Here each state of all the rest has a cache of its own: the package, the data, Python, what is installed beside
it, the number of threads. What is not in the cache is run before the pages are read, one notebook a core. A notebook
that fails is not kept: myst-nb runs it again, and reports it.
"""

import asyncio
import hashlib
import os
import platform
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from pathlib import Path
from typing import Any

import nbformat
from jupyter_cache import get_cache
from jupyter_cache.base import CacheBundleIn
from jupyter_cache.cache.db import NbCacheRecord
from nbclient import NotebookClient
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util import logging

import rbfound

PACKAGE = Path(rbfound.__file__).parent
# Beside the package: what notebooks read, and what they could import because it lies beside them.
FOLDERS = ("data", "notebooks")
KINDS = ("*.dist-info", "*.egg-info")
# Kernels hold meshes and their factors in memory; beyond a few, the longest notebook decides.
MOST = 4

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


def opened(folder: Path) -> Any:
    """The cache in a folder; one that was interrupted at its birth is begun anew."""
    cache = get_cache(str(folder))
    try:
        cache.list_cache_records()
    except RuntimeError:
        cache.db.dispose()
        cache.clear_cache()
    return cache


def is_kept(cache: Any, notebook: Any) -> bool:
    """Whether its run is in the cache; what an interrupt left of one is removed."""
    record = None
    with suppress(KeyError, ValueError):  # there is no record, no file behind it, or half a file
        record = cache.match_cache_notebook(notebook)
        cache.get_cache_bundle(record.pk)
        return True
    _, name = cache.create_hashed_notebook(notebook)
    shutil.rmtree(cache.path / "executed" / name, ignore_errors=True)
    if record is not None:
        NbCacheRecord.remove_record(record.pk, cache.db)
    return False


def client(path: Path, notebook: Any, timeout: int) -> NotebookClient:
    """What runs a notebook, as myst-nb itself does it."""
    return NotebookClient(
        notebook, timeout=timeout, record_timing=False, resources={"metadata": {"path": str(path.parent)}}
    )


def timed(client: NotebookClient) -> float:
    """Run a notebook; the seconds that it took."""
    start = time.perf_counter()
    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as loop:  # a thread's own, and closed at the end
        loop.run(client.async_execute())
    return time.perf_counter() - start


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(clients: Sequence[NotebookClient], report: Callable[[int, float | None], None]) -> None:
    """Run notebooks, a core each, and report each one as it ends: its place and its seconds, None if it failed.

    Threads do, as a kernel is a process of its own. After an interrupt the kernels are ended: a thread would wait for
    the rest of its notebook.
    """
    with ThreadPoolExecutor(min(cores(), MOST)) as pool:
        runs = {pool.submit(timed, client): place for place, client in enumerate(clients)}
        try:
            for run in as_completed(runs):
                report(runs[run], None if run.exception() else run.result())
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            while not all(run.done() for run in runs):
                for client in clients:
                    end(client)
                time.sleep(0.1)


def end(client: NotebookClient) -> None:
    """End a notebook's kernel, if it has one."""
    process = getattr(getattr(client.km, "provisioner", None), "process", None)
    if process is not None:
        process.kill()


def run_ahead(app: Sphinx, env: Any, names: list[str]) -> None:
    """Sphinx's hook before pages are read: run the notebooks among them that are not in the cache."""
    if app.config.nb_execution_mode != "cache":
        return
    cache = opened(Path(app.config.nb_execution_cache_path))
    paths = {name: Path(env.doc2path(name)) for name in names}
    read = {name: nbformat.read(path, as_version=4) for name, path in paths.items() if path.suffix == ".ipynb"}
    new = [name for name, notebook in read.items() if not is_kept(cache, notebook)]
    logger.info("notebooks: %d to run, %d as they were run before", len(new), len(read) - len(new))
    done = 0

    def report(place: int, seconds: float | None) -> None:
        nonlocal done
        name, done = new[place], done + 1
        if seconds is None:
            logger.info("%d of %d: %s failed, and is run again below", done, len(new), name)
            return
        if changed(app):
            raise ExtensionError("The package, the data or the environment changed while notebooks ran: build again.")
        run = CacheBundleIn(read[name], str(paths[name]), data={"execution_seconds": seconds})
        cache.cache_notebook_bundle(run, check_validity=False, overwrite=True)
        logger.info("%d of %d: %s, %.1f s", done, len(new), name, seconds)

    side_by_side([client(paths[name], read[name], app.config.nb_execution_timeout) for name in new], report)


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
