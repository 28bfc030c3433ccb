"""What the tests in a browser share: a Chromium that is started for them, and what happens where there is none."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

import pytest
from browser import FLAGS, chromium


def missing(sentence: str) -> None:
    """Skip, with what to do about it; in CI a skip would hide a broken page, so there it fails."""
    if os.environ.get("RBFOUND_REQUIRE_BROWSER"):
        pytest.fail(sentence)
    pytest.skip(sentence)


@contextmanager
def launched(tests: str) -> Iterator[Any]:
    """A headless Chromium for some tests, which are named in the sentence that says what is missing."""
    executable = chromium()
    if executable is None:
        missing(f"{tests} need Chromium: install it (Debian, Ubuntu: apt-get install chromium).")
    if not find_spec("playwright"):
        missing(f"{tests} need playwright: make test installs it.")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=executable, args=FLAGS)
        yield browser
        browser.close()
