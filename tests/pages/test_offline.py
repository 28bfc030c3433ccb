"""A book built for machines without a network: nothing in its pages has an address elsewhere, and it runs from a file.

It needs the packages that the pages otherwise take from CDNs: `make pyodide` fetches Python, RBFOUND_PACKAGES names a
folder that has the others (see tools/offline.py), which npm fetches where it is not set.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import is_local
from browsing import launched, pyodide_folder

ROOT = Path(__file__).resolve().parents[2]
# Formulas, a widget with its manager, and a live thing: one page for each need of the book.
TOC = "format: jb-book\nroot: notebooks/01_sdof\nchapters:\n  - file: notebooks/03_peaks_pmsm\n"
# what loads by itself; links that a reader may follow are no part of it
LOADS = re.compile(r"<(?:script|link|img|iframe)\b[^>]*?\s(?:src|href)=\"(https?:[^\"]+)\"")
HARMLESS = 'rel="canonical"'

pytestmark = [pytest.mark.book, pytest.mark.slow]


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("offline")
    if shutil.which("jupyter-book", path=Path(sys.executable).parent) is None:
        pytest.skip("The offline book's tests build one, and there is no jupyter-book here: make test installs it.")
    pyodide = pyodide_folder()
    packages = os.environ.get("RBFOUND_PACKAGES")
    if not packages and shutil.which("npm") is None:
        pytest.skip("MathJax and others come from npm, which is not here: install it, or set RBFOUND_PACKAGES.")
    own = ["--packages", packages] if packages else []
    fetch = [sys.executable, ROOT / "tools" / "offline.py", folder / "needs", "--pyodide", pyodide, *own]
    subprocess.run(fetch, check=True)
    (folder / "_toc.yml").write_text(TOC, encoding="utf-8")
    build = [Path(sys.executable).with_name("jupyter-book"), "build", ROOT, "--toc", folder / "_toc.yml"]
    environment = {**os.environ, "RBFOUND_OFFLINE": str(folder / "needs")}
    run = subprocess.run(
        [*build, "--path-output", folder], env=environment, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-2000:]
    return folder / "_build" / "html"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched("The offline book's tests") as browser:
        yield browser


def test_no_page_loads_anything_from_elsewhere(book: Path) -> None:
    pages = list(book.rglob("*.html"))
    assert {page.name for page in pages} >= {"01_sdof.html", "03_peaks_pmsm.html"}
    for page in pages:
        tags = [match for match in LOADS.finditer(page.read_text(encoding="utf-8")) if HARMLESS not in match[0]]
        assert [match[1] for match in tags] == [], page.name


def test_no_style_sheet_loads_anything_from_elsewhere(book: Path) -> None:
    sheets = list(book.rglob("*.css"))
    assert sheets
    for sheet in sheets:
        assert re.findall(r"(?:@import\s+|url\()[\"']?(https?:[^\"')]+)", sheet.read_text(encoding="utf-8")) == []


def test_formulas_widgets_and_python_work_from_a_file_without_a_network(book: Path, browser: Any) -> None:
    context = browser.new_context(offline=True)
    away: list[str] = []
    troubles: list[str] = []
    context.on("request", lambda request: None if is_local(request.url) else away.append(request.url))
    page = context.new_page()
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.goto((book / "notebooks" / "01_sdof.html").as_uri())
    page.wait_for_selector("mjx-container", timeout=30_000)
    page.locator(".rbfound-live-run").click()
    page.wait_for_selector("[data-ready], [data-failed]", timeout=120_000)
    status = page.locator("#live-oscillator > .rbfound-live-status").inner_text()
    assert "Pyodide 0.27.7" in status
    page.goto((book / "notebooks" / "03_peaks_pmsm.html").as_uri())
    page.wait_for_selector(".jupyter-widgets, .rbfound-picker", timeout=30_000)
    context.close()
    assert away == []
    assert troubles == []
