"""What the tests in a browser share: a Chromium that is started for them, and what happens where there is none."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from browser import FLAGS, chromium


def missing(sentence: str) -> None:
    """Skip, with what to do about it; in CI a skip would hide a broken page, so there it fails."""
    if os.environ.get("RBFOUND_REQUIRE_BROWSER"):
        pytest.fail(sentence)
    pytest.skip(sentence)


ROOT = Path(__file__).resolve().parent.parent


def pyodide_folder() -> Path:
    """Where Pyodide's files are: RBFOUND_PYODIDE, where `make pyodide` puts them, or shared/ beside the repository."""
    if own := os.environ.get("RBFOUND_PYODIDE"):
        places = [Path(own)]
    else:
        places = [ROOT / "_build" / "pyodide", ROOT.parent / "shared" / "pyodide-0.27.7"]
    for place in places:
        if (place / "pyodide-lock.json").is_file():
            return place
    pytest.skip("Python for the pages, Pyodide, is not here: make pyodide fetches it.")


# Chromium asks nothing of the network, and loads what pages share once; where requests are routed it keeps nothing.
ALONE = "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1"


@contextmanager
def launched(tests: str, *flags: str) -> Iterator[Any]:
    """A headless Chromium for some tests, which are named in the sentence that says what is missing."""
    executable = chromium()
    if executable is None:
        missing(f"{tests} need Chromium: install it (Debian, Ubuntu: apt-get install chromium).")
    if not find_spec("playwright"):
        missing(f"{tests} need playwright: make test installs it.")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=executable, args=[*FLAGS, *flags])
        yield browser
        browser.close()
