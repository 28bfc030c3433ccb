"""The built book as a reader's browser sees it: headless Chromium, and no network.

`make test` builds the book first. Without a network the pages lack MathJax, require.js and the widget manager, which
they take from a CDN: their formulas stay TeX, and nothing else may break.
"""

import re
import shutil
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import html5lib
import pytest
from browser import is_local, pages, served
from browsing import ALONE, launched, missing

ROOT = Path(__file__).resolve().parents[2]
HTML = ROOT / "_build" / "html"
PAGES = pages(ROOT / "_toc.yml")

pytestmark = pytest.mark.book


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with launched("The browser tests", ALONE) as browser:
        yield browser


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    if not (HTML / "index.html").is_file():
        missing("The browser tests need the built book: make book.")
    with served(HTML) as url:
        yield url


class Visit:
    """One page, opened in a window that has a width, and all that went wrong on the way."""

    def __init__(self, context: Any, url: str) -> None:
        self.troubles: list[str] = []
        self.page = context.new_page()
        self.page.on("pageerror", lambda error: self.troubles.append(f"page error: {error}"))
        self.page.on("console", self.heard)
        self.page.on("response", self.answered)
        self.page.goto(url, wait_until="load")
        self.page.wait_for_selector("article h1")
        self.page.wait_for_load_state("load")
        # all scripts have had their turn
        self.page.evaluate("new Promise(done => requestIdleCallback(done))")

    def heard(self, message: Any) -> None:
        """An error on the console, unless it says that the (absent) network did not bring a file."""
        away = not is_local(message.location.get("url", ""))
        if message.type == "error" and not (away and "net::ERR_" in message.text):
            self.troubles.append(f"console: {message.text} ({message.location.get('url')})")

    def answered(self, response: Any) -> None:
        """A file of the book itself that is not there."""
        if response.status >= 400:
            self.troubles.append(f"{response.status} {response.url}")


def window(browser: Any, width: int) -> Any:
    """A window for pages that are opened one after the other; what they share is loaded once."""
    context = browser.new_context(viewport={"width": width, "height": 900})
    context.set_default_timeout(10_000)
    return context


@pytest.fixture(scope="module")
def wide_window(browser: Any) -> Iterator[Any]:
    with window(browser, 1280) as context:
        yield context


@pytest.fixture(scope="module")
def narrow_window(browser: Any) -> Iterator[Any]:
    with window(browser, 390) as context:
        yield context


@pytest.fixture(scope="module", params=PAGES)
def visit(request: pytest.FixtureRequest, wide_window: Any, address: str) -> Iterator[Visit]:
    visit = Visit(wide_window, f"{address}/{request.param}")
    yield visit
    visit.page.close()


@pytest.fixture(scope="module", params=PAGES[1:])
def narrow(request: pytest.FixtureRequest, narrow_window: Any, address: str) -> Iterator[Visit]:
    visit = Visit(narrow_window, f"{address}/{request.param}")
    yield visit
    visit.page.close()


def test_a_page_opens_without_an_error_and_with_all_its_pictures(visit: Visit) -> None:
    pictures = "Array.from(document.images).filter(i => i.loading != 'lazy' && !i.naturalWidth).map(i => i.src)"
    assert visit.page.evaluate(pictures) == []
    assert visit.troubles == []


def test_a_page_shows_no_message_of_its_builder_and_no_traceback(visit: Visit) -> None:
    assert visit.page.locator(".system-message, .problematic, .output.traceback, .output.stderr").count() == 0


def test_every_link_within_the_book_leads_somewhere(visit: Visit, address: str) -> None:
    links = visit.page.evaluate("Array.from(document.links, a => a.href)")
    broken = [link for link in set(links) if link.startswith(address) and not leads_somewhere(link)]
    assert broken == []


def leads_somewhere(link: str) -> bool:
    """Whether the page is there, and the place on it."""
    parts = urlsplit(link)
    page = HTML / unquote(parts.path).lstrip("/")
    if not page.is_file():
        return False
    return not parts.fragment or f'id="{unquote(parts.fragment)}"' in page.read_text(encoding="utf-8")


class Links(HTMLParser):
    """Every place of one page, and everything that it links to or loads."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.places: set[str] = set()
        self.base = ""
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take the links, pictures, scripts and places of one element."""
        found = dict(attrs)
        self.places |= {name for key in ("id", "name") if (name := found.get(key))}
        if tag == "base":
            self.base = found["href"] or ""
        elif tag not in ("link", "meta") or found.get("rel") in ("stylesheet", "icon"):
            self.links += [link for key in ("href", "src") if (link := found.get(key))]


def test_no_link_of_any_page_is_broken_without_a_browser_to_look_at_it() -> None:
    # all pages that were built, those outside of the contents too: search, index, sources, the page for lost readers
    if not (HTML / "index.html").is_file():
        missing("The link check needs the built book: make book.")
    pages = {page: Links(page) for page in HTML.rglob("*.html") if "_static" not in page.parts}
    broken = []
    for page, found in pages.items():
        for link in set(found.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            start = HTML if found.base else page.parent
            to = (start / unquote(parts.path).lstrip("/" if found.base else "")).resolve() if parts.path else page
            there = to.is_file() and (
                not parts.fragment or to not in pages or unquote(parts.fragment) in pages[to].places
            )
            if not there:
                broken.append(f"{page.relative_to(HTML)}: {link}")
    assert len(pages) > len(PAGES)
    assert broken == []


def test_every_page_is_html_that_a_parser_reads_without_a_complaint() -> None:
    if not (HTML / "index.html").is_file():
        missing("The check of the HTML needs the built book: make book.")
    wrong = {}
    for page in sorted(HTML.rglob("*.html")):
        if not {"_static", "_modules"} & set(page.parts):
            parser = html5lib.HTMLParser()
            parser.parse(page.read_bytes())
            wrong[page.relative_to(HTML)] = parser.errors
    assert len(wrong) > len(PAGES)
    assert {page: errors for page, errors in wrong.items() if errors} == {}


def test_a_page_is_light_enough_for_a_slow_line() -> None:
    # its text and its pictures, without what only a live part loads; scripts and styles are shared by all pages
    if not (HTML / "index.html").is_file():
        missing("This needs the built book: make book.")
    weights = {}
    for name in PAGES[1:]:
        page = HTML / name
        pictures = {link for link in Links(page).links if re.search(r"\.(png|svg|jpg)$", link)}
        weights[name] = page.stat().st_size + sum((page.parent / link).stat().st_size for link in pictures)
    assert {name: size for name, size in weights.items() if size > 1.5e6} == {}


def test_a_lost_reader_finds_the_way_from_any_depth() -> None:
    if not (HTML / "index.html").is_file():
        missing("This needs the built book: make book.")
    page = Links(HTML / "404.html")
    assert page.base.endswith("/")
    assert {"search.html", "index.html"} <= set(page.links)


WIDTH = "document.scrollingElement.scrollWidth"
# The reader's machine may have other fonts: letters a quarter wider than those here, and letters further apart.
FACE = "@font-face {{ font-family: {0}; src: {1}; size-adjust: 125%; }}"
FONTS = """
body, body *:not([class*="fa-"]) { font-family: wider-text, sans-serif !important; }
body :is(code, pre, kbd, samp, .pre), body :is(code, pre) * { font-family: wider-code, monospace !important; }
"""
WIDER = [
    FACE.format("wider-text", "local('DejaVu Sans'), local('Liberation Sans'), local('Arial')")
    + FACE.format("wider-code", "local('DejaVu Sans Mono'), local('Liberation Mono'), local('Courier New')")
    + FONTS,
    "body * { letter-spacing: 0.12em !important; }",
]


def test_a_narrow_page_does_not_scroll_sideways_whichever_fonts_there_are(narrow: Visit) -> None:
    wide = narrow.page.evaluate(WIDTH)
    for style in WIDER:
        narrow.page.add_style_tag(content=style)
        narrow.page.evaluate("document.fonts.ready")
        wide = max(wide, narrow.page.evaluate(WIDTH))
        narrow.page.evaluate("document.head.lastElementChild.remove()")
    assert wide <= 390


LETTERS = """() => { const range = document.createRange();
  range.selectNodeContents(document.querySelector("h1")); return range.getBoundingClientRect().width; }"""


def test_the_wider_letters_are_wider(narrow_window: Any) -> None:
    # or the test before would test nothing: no font of that name may be here
    page = narrow_window.new_page()
    page.set_content("<h1 style='font: 16px sans-serif'>rbfound.plots.quality</h1>")
    widths = [page.evaluate(LETTERS)]
    for style in WIDER:
        page.add_style_tag(content=style)
        page.evaluate("document.fonts.ready")
        widths.append(page.evaluate(LETTERS))
        page.evaluate("document.head.lastElementChild.remove()")
    page.close()
    assert min(widths[1:]) > 1.1 * widths[0]


def test_the_book_opens_at_its_first_page(wide_window: Any, address: str) -> None:
    visit = Visit(wide_window, f"{address}/index.html")
    visit.page.wait_for_url(f"{address}/{PAGES[1]}")
    visit.page.close()


def test_the_book_opens_from_a_file_without_a_server(browser: Any, tmp_path: Path) -> None:
    if not (HTML / PAGES[1]).is_file():
        missing("The browser tests need the built book: make book.")
    copy = shutil.copytree(HTML, tmp_path / "book")
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto((copy / "index.html").as_uri(), wait_until="domcontentloaded")
    page.wait_for_selector("article h1")
    page.close()
    assert errors == []
