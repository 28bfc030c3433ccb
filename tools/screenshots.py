"""Full-page pictures of every page of the built book, wide (1280) and narrow (390), to look at.

    python tools/screenshots.py _build/html _build/screenshots [--cdn FOLDER] [--pages PAGE ...]

Nothing is fetched from the network. Without it formulas stay raw TeX and widgets are missing, so `--cdn` names a folder with
the packages that the pages take from a CDN, as npm unpacks them (`npm pack mathjax@3.2.2` and so on):

    FOLDER/mathjax/..., FOLDER/requirejs/..., FOLDER/@jupyter-widgets/html-manager/...
"""

import argparse
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

from playwright.sync_api import sync_playwright

WIDTHS = (1280, 390)
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


class Quiet(SimpleHTTPRequestHandler):
    """A file server without a line on stderr for each request."""

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
        """Say nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on a free port of this machine; yields its address."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
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


def pages(html: Path) -> list[str]:
    """Every page that a reader can reach from the table of contents, relative to the built book."""
    made = [*sorted((html / "notebooks").glob("*.html")), *sorted((html / "book").glob("*.html"))]
    return ["index.html", *(page.relative_to(html).as_posix() for page in made)]


def local_file(cdn: Path | None, url: str) -> Path | None:
    """The file of the CDN folder that a CDN's address names, if it is there."""
    if cdn is None:
        return None
    address = url.split("?")[0]
    if REQUIRE.search(address):
        return next(iter(cdn.glob("requirejs/require.js")), None)
    match = PACKAGE.search(address)
    if match is None:
        return None
    path = cdn / match["name"] / match["path"]
    return next((p for p in (path, path.with_name(path.name + ".js")) if p.is_file()), None)


def router(cdn: Path | None) -> Callable[[Any], None]:
    """Answers requests: this machine's as they are, a CDN's from the folder, and nothing else."""

    def answer(route: Any) -> None:
        url = route.request.url
        if url.startswith(("http://127.0.0.1", "data:", "blob:")):
            route.continue_()
        elif path := local_file(cdn, url):
            kind = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
            route.fulfill(path=path, content_type=kind, headers={"access-control-allow-origin": "*"})
        else:
            route.abort()

    return answer


def main() -> int:
    """Write the pictures; 1 where there is no browser."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("html", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--cdn", type=Path)
    parser.add_argument("--pages", nargs="+")
    args = parser.parse_args()
    executable = chromium()
    if executable is None:
        print("There is no Chromium here: install it (Debian, Ubuntu: apt-get install chromium).", file=sys.stderr)
        return 1
    args.out.mkdir(parents=True, exist_ok=True)
    with served(args.html) as address, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=executable, args=FLAGS)
        for width in WIDTHS:
            context = browser.new_context(viewport={"width": width, "height": 900})
            context.route("**/*", router(args.cdn))
            for name in args.pages or pages(args.html):
                page = context.new_page()
                page.goto(f"{address}/{name}", wait_until="load")
                page.wait_for_timeout(1500 if args.cdn else 300)
                path = args.out / f"{Path(name).with_suffix('').as_posix().replace('/', '-')}-{width}.png"
                page.screenshot(path=path, full_page=True)
                print(path, flush=True)
                page.close()
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
