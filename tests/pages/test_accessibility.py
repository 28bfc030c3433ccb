"""What axe-core finds on each page of the built book: nothing serious, in light and in dark."""

from collections.abc import Iterator
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from browser import pages, served
from browsing import ALONE, launched, missing

ROOT = Path(__file__).resolve().parents[2]
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
def window(axe: str) -> Iterator[Any]:
    """A window for pages that are opened one after the other, and the book's address."""
    if not (HTML / "index.html").is_file():
        missing("The accessibility tests need the built book: make book.")
    with launched("The accessibility tests", ALONE) as browser, served(HTML) as address:
        yield browser.new_context(viewport={"width": 1280, "height": 900}, base_url=address)


@pytest.fixture(scope="module", params=PAGES)
def page(request: pytest.FixtureRequest, window: Any, axe: str) -> Iterator[Any]:
    page = window.new_page()
    page.set_default_timeout(120_000)
    page.goto(f"/{request.param}", wait_until="load")
    # half-way through a change of theme nothing has its contrast
    page.add_style_tag(content="*, *::before, *::after { transition: none !important; }")
    page.evaluate(axe)
    yield page
    page.close()


# All rules but that of the contrast see the page as it is. For the contrast axe asks of every word what lies above and
# below it, in a time that grows with the square of the page. A word's colours follow from the elements around it: a
# part in which each element has the same ones around it, classes and styles alike, as one that stays, is taken out.
FOUND = """async () => {
  const contrast = { runOnly: { type: "rule", values: ["color-contrast"] }, resultTypes: ["violations"] };
  const rest = { rules: { "color-contrast": { enabled: false } }, resultTypes: ["violations"] };
  const found = (await axe.run(rest)).violations;
  const around = (one) => { let told = "";
    for (; one; one = one.parentElement) told += `${one.tagName}.${one.className}[${one.getAttribute("style")}]`;
    return told; };
  const parts = [...document.querySelectorAll("article section, article dl.py, .bd-sidebar-secondary li")].reverse();
  const known = new Set(), out = [];
  // what lies within parts belongs to the innermost
  const inner = parts.filter((one) => !one.querySelector("section, dl.py, li"));
  const within = new Set(inner.flatMap((one) => [...one.querySelectorAll("*")]).concat(inner));
  for (const one of document.querySelectorAll("body *")) if (!within.has(one)) known.add(around(one));
  for (const one of inner) {
    const kinds = [one, ...one.querySelectorAll("*")].map(around);
    if (kinds.every((kind) => known.has(kind))) {
      const mark = document.createComment("here");
      one.replaceWith(mark);
      out.push([mark, one]);
    } else kinds.forEach((kind) => known.add(kind));
  }
  found.push(...(await axe.run(contrast)).violations);
  for (const [mark, one] of out) mark.replaceWith(one);
  return found; }"""


@pytest.mark.parametrize("page", ["book/notation.html"], indirect=True)
def test_axe_sees_a_word_without_contrast_in_any_section(page: Any) -> None:
    page.evaluate("""() => { const all = document.querySelectorAll("article section");
      for (const one of [all[0], all[all.length - 1]]) one.insertAdjacentHTML("beforeend",
        '<p class="pale" style="color: #ddd; background: #fff">pale</p>'); }""")
    found = [one for one in page.evaluate(FOUND) if one["id"] == "color-contrast"]
    page.evaluate("document.querySelectorAll('.pale').forEach((one) => one.remove())")
    assert len({str(node["target"]) for one in found for node in one["nodes"] if "pale" in node["html"]}) == 2


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_serious(page: Any, theme: str) -> None:
    page.evaluate("theme => { document.documentElement.dataset.theme = theme; }", theme)
    serious = [
        f"{one['id']} ({len(one['nodes'])}): {one['nodes'][0]['target']} {one['nodes'][0].get('failureSummary')}"
        for one in page.evaluate(FOUND)
        if one["impact"] in SERIOUS
    ]
    assert serious == []
