"""What axe-core finds on each page of the built book: nothing serious, in light and in dark."""

from collections.abc import Iterator
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from browser import pages, router, served
from browsing import launched, missing

ROOT = Path(__file__).resolve().parent.parent
HTML = ROOT / "_build" / "html"
PAGES = pages(ROOT / "_toc.yml")[1:]
SERIOUS = ("serious", "critical")

pytestmark = [pytest.mark.book, pytest.mark.slow]


@pytest.fixture(scope="module")
def axe() -> str:
    if not find_spec("axe_playwright_python"):
        missing("The accessibility tests need axe-core: pip install axe-playwright-python, or make test.")
    return files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def browser(axe: str) -> Iterator[Any]:
    if not (HTML / "index.html").is_file():
        missing("The accessibility tests need the built book: make book.")
    with launched("The accessibility tests") as browser:
        yield browser


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_serious(browser: Any, axe: str, name: str, theme: str) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    context.route("**/*", router())
    page = context.new_page()
    with served(HTML) as address:
        page.goto(f"{address}/{name}", wait_until="load")
        # half-way through a change of theme nothing has its contrast
        page.add_style_tag(content="*, *::before, *::after { transition: none !important; }")
        page.evaluate("theme => { document.documentElement.dataset.theme = theme; }", theme)
        page.evaluate(axe)
        found = page.evaluate("axe.run({resultTypes: ['violations']})")
    context.close()
    serious = [
        f"{one['id']} ({len(one['nodes'])}): {one['nodes'][0]['target']} {one['nodes'][0].get('failureSummary')}"
        for one in found["violations"]
        if one["impact"] in SERIOUS
    ]
    assert serious == []
