"""The built book in a headless Chromium, without a network: what the browser tests and the screenshots share."""

import mimetypes
import re
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
# .../npm/mathjax@3/es5/tex-mml-chtml.js, .../ajax/libs/require.js/2.3.4/require.min.js
PACKAGE = re.compile(r"/npm/(?P<name>(@[^/]+/)?[^/@]+)(@[^/]+)?/(?P<path>.+)")
REQUIRE = re.compile(r"/require(\.min)?\.js$")
PYODIDE = re.compile(r"^https://cdn\.jsdelivr\.net/pyodide/v[\d.]+/full/(?P<name>[^/?]+)$")
# a CDN's file is named with its checksum, and another build of the same file has another one
CHECKSUM = re.compile(rb"\sintegrity=\"[^\"]*\"")


class Quiet(SimpleHTTPRequestHandler):
    """A file server without a line on stderr for each request."""

    def log_message(self, *args: Any) -> None:
        """Say nothing."""


class Server(ThreadingHTTPServer):
    """A server that takes it calmly when a page is closed before its files have come."""

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Tell of anything else."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on a free port of this machine; yields its address."""
    server = Server(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()


def chromium() -> str | None:
    """Path of an installed Chromium or Chrome."""
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    return next(filter(None, map(shutil.which, names)), None)


def pages(toc: Path) -> list[str]:
    """The built page of each chapter in `_toc.yml`, relative to the built book; the first one is where it opens."""
    chapters = re.findall(r"^\s*(?:- )?(?:root|file): *(\S+)", toc.read_text(encoding="utf-8"), re.MULTILINE)
    return ["index.html", *(f"{chapter}.html" for chapter in chapters)]


def is_local(url: str) -> bool:
    """Whether an address needs no network."""
    return url.startswith(("http://127.0.0.1", "data:", "blob:", "file:"))


def local_file(cdn: Path | None, url: str) -> Path | None:
    """The file of the CDN folder that a CDN's address names, if it is there."""
    if cdn is None:
        return None
    address = url.split("?")[0]
    if REQUIRE.search(address):
        return next(cdn.glob("requirejs/require.js"), None)
    match = PACKAGE.search(address)
    if match is None:
        return None
    path = cdn / match["name"] / match["path"]
    return next((p for p in (path, path.with_name(path.name + ".js")) if p.is_file()), None)


def pyodide_file(folder: Path | None, url: str) -> Path | None:
    """The file of a Pyodide folder that an address of Pyodide's CDN names, if it is there."""
    match = PYODIDE.match(url)
    if folder is None or match is None:
        return None
    return next((path for path in [folder / match["name"]] if path.is_file()), None)


def router(cdn: Path | None = None, pyodide: Path | None = None) -> Callable[[Any], None]:
    """Answers requests: this machine's as they are, a CDN's from a folder where it has the file, and nothing else.

    `pyodide` is the folder that stands for Pyodide's own CDN.
    """

    def answer(route: Any) -> None:
        url = route.request.url
        if cdn and is_local(url) and route.request.resource_type == "document":
            response = route.fetch()
            route.fulfill(response=response, body=CHECKSUM.sub(b"", response.body()))
        elif is_local(url):
            route.continue_()
        elif path := local_file(cdn, url) or pyodide_file(pyodide, url):
            kind = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
            route.fulfill(path=path, content_type=kind, headers={"access-control-allow-origin": "*"})
        else:
            route.abort()

    return answer
