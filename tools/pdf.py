"""The built book as one PDF, printed by a headless Chromium: a title page, the contents, and every page in its order.

It is printed twice: the first print tells on which page each chapter begins, the second has these numbers in its
contents. Where they would differ from where the chapters then are, this says so.

    python tools/pdf.py _build/html _build/pdf/book.pdf [--cdn FOLDER]

The pages take their formulas' typesetter from a CDN. Without a network `--cdn` names a folder that has it, as for
tools/screenshots.py. Without Chromium this says so, and makes nothing.
"""

import argparse
import re
import sys
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from posixpath import dirname, join, normpath
from typing import Any

from browser import FLAGS, chromium, is_local, pages, router, served
from bs4 import BeautifulSoup, Tag
from playwright.sync_api import sync_playwright
from pypdf import PdfReader

ROOT = Path(__file__).resolve().parent.parent
OUTSIDE = re.compile(r"^(?:[a-z]+:|//)")
# what a reader of paper cannot use
SCREEN_ONLY = "a.headerlink, button, script, .prev-next-footer, .viewcode-link, .toctree-wrapper, .tag_hide-output"
SCREEN_ONLY += ", .sd-summary-state-marker"
# of a picture for each theme and width, paper has the one for a wide light page
SCREEN_ONLY += ", picture:has(> .only-dark), picture > source"
STYLE = """
@page { size: A4; margin: 22mm 20mm 20mm 20mm; @bottom-center { content: counter(page); FOLIO } }
@page :first { @bottom-center { content: ""; } }
html { font-size: 10pt; }
body { font-family: Georgia, "DejaVu Serif", serif; line-height: 1.42; color: #111; background: white; }
h1, h2, h3, .title, nav { font-family: "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; color: #14324f; }
h1 { font-size: 21pt; margin: 0 0 8mm; } h2 { font-size: 14pt; margin-top: 7mm; } h3 { font-size: 11.5pt; }
h1, h2, h3 { break-after: avoid; } p { orphans: 3; widows: 3; margin: 0 0 0.75em; }
section.page { break-before: page; }
.title { height: 235mm; display: flex; flex-direction: column; justify-content: center; }
.title h1 { font-size: 38pt; border: 0; } .title p { font-size: 14pt; max-width: 130mm; } .title img { width: 100%; }
nav { break-before: page; line-height: 1.25; } nav h2 { font-size: 11.5pt; margin: 3mm 0 0.3mm; }
nav p { margin: 0; } nav a { color: #111; text-decoration: none; display: flex; align-items: baseline; }
nav a i { flex: 1; border-bottom: 0.3mm dotted #999; margin: 0 2mm; } nav a b { font-weight: normal; width: 3em; }
nav a b { text-align: right; }
a { color: #14507f; text-decoration: none; }
img { max-width: 100%; height: auto; break-inside: avoid; }
pre, code { font-family: "DejaVu Sans Mono", monospace; } code { font-size: 0.85em; }
pre { font-size: 7.6pt; line-height: 1.35; white-space: pre-wrap; overflow-wrap: anywhere; }
pre { margin: 0; padding: 2mm 3mm; }
.cell { margin: 3mm 0; } .cell_input { break-inside: avoid; break-after: avoid; }
.cell_input pre { background: #f4f5f7; border-left: 0.8mm solid #9fb3c8; }
.cell_output pre { white-space: pre; overflow: hidden; break-inside: avoid; }
.cell_output img { display: block; margin: 0 auto; }
table { border-collapse: collapse; font-size: 8.4pt; width: 100%; margin: 3mm 0; }
td, th { border-bottom: 0.2mm solid #bbb; padding: 0.8mm 1.5mm; text-align: left; vertical-align: top; }
td code { overflow-wrap: anywhere; }
p.live { border: 0.3mm dashed #9fb3c8; padding: 4mm; text-align: center; color: #555; }
dl.glossary dt, dt strong { font-weight: bold; } .classifier::before { content: ": "; }
tr { break-inside: avoid; } th { border-bottom: 0.4mm solid #444; }
details { border-left: 0.8mm solid #ccc; padding-left: 3mm; } .math { break-inside: avoid; }
div.math { position: relative; } .eqno { position: absolute; right: 0; top: 0.6em; z-index: 1; }
dt.sig { font-family: "DejaVu Sans Mono", monospace; font-size: 8pt; margin-top: 3mm; overflow-wrap: anywhere; }
dd { margin-left: 6mm; } mjx-container { font-size: 100% !important; }
"""
FOLIO = 'font: 8pt "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; color: #555;'
TYPESET = "window.MathJax?.startup?.promise?.then(() => document.querySelectorAll('mjx-container').length)"
WRONG = "Array.from(document.querySelectorAll('[data-mjx-error]'), e => e.getAttribute('data-mjx-error'))"
CHAPTERS = "Array.from(document.querySelectorAll('nav b'), b => b.dataset.at)"
NUMBERS = "pages => document.querySelectorAll('nav b').forEach(b => { b.textContent = pages[b.dataset.at]; })"
MISSING = "Array.from(document.images).filter(i => !i.naturalWidth).map(i => i.src)"


def anchor(page: str, place: str = "") -> str:
    """The name of a place of the book within the one document."""
    return re.sub(r"[^\w-]", "-", page.removesuffix(".html")) + (f"--{place}" if place else "")


def target(page: str, link: str, known: set[str]) -> str:
    """Where a link of a page leads to in the one document; unchanged where it leads out of the book."""
    path, _, place = link.partition("#")
    if OUTSIDE.match(link):
        return link
    to = normpath(join(dirname(page), path)) if path else page
    return f"#{anchor(to, place)}" if to in known else ""


def article(html: Path, page: str, known: set[str]) -> tuple[str, str, Tag]:
    """Title, number and text of a page, with its links and pictures made those of the one document."""
    soup = BeautifulSoup((html / page).read_text(encoding="utf-8"), "html.parser")
    body = soup.select_one("article.bd-article")
    if body is None:
        raise ValueError(f"{page} has no article: build the book first.")
    for element in body.select('script[type*="widget-view"]'):
        note = soup.new_tag("p", attrs={"class": "live"})
        note.string = "On screen there is a part here that can be moved by hand."
        element.insert_before(note)
    for element in body.select(SCREEN_ONLY):
        element.decompose()
    for element in body.select("details"):
        element["open"] = ""
    for element in body.select("[id]"):
        element["id"] = anchor(page, str(element["id"]))
    for element in body.select("a[href]"):
        element["href"] = target(page, str(element["href"]), known)
    for element in body.select("img[src]"):
        source = str(element["src"])
        element["src"] = source if OUTSIDE.match(source) else "/" + normpath(join(dirname(page), source))
        element.attrs.pop("loading", None)
    heading = body.select_one("h1")
    number = heading.select_one(".section-number") if heading else None
    digits = number.extract().get_text().strip() if number else ""
    title = heading.get_text().strip() if heading else page
    if heading and digits:
        heading.string = f"{digits} {title}"
    return title, digits, body


def parts(toc: Path) -> dict[str, str]:
    """The part of the book that begins with a page."""
    found = re.findall(
        r"caption: (.+)\n(?:    numbered.+\n)?    chapters:\n      - file: (\S+)", toc.read_text(encoding="utf-8")
    )
    return {f"{page}.html": caption for caption, page in found}


def running_head(name: str, heading: str) -> str:
    """The style that puts a chapter's title at the top of its pages."""
    quoted = heading.replace("\\", "\\\\").replace('"', '\\"')
    return f'@page {name} {{ @top-right {{ content: "{quoted}"; {FOLIO} }} }} #{name} {{ page: {name}; }}'


def beginnings(pdf: Path, names: set[str]) -> dict[str, int]:
    """The page of a print on which each of these places is, counted from 1."""
    reader = PdfReader(pdf)
    found = {name.lstrip("/"): place for name, place in reader.named_destinations.items()}
    numbers = {name: reader.get_destination_page_number(found[name]) for name in sorted(names & set(found))}
    lost = names - {name for name, number in numbers.items() if number is not None}
    if lost:
        raise ValueError(f"{pdf} has no page for {', '.join(sorted(lost))}.")
    return {name: number + 1 for name, number in numbers.items() if number is not None}


def document(html: Path, toc: Path, title: str) -> str:
    """The whole book as one page."""
    names = pages(toc)[1:]
    starts, known = parts(toc), set(names)
    contents, bodies, heads = [], [], []
    for page in names:
        heading, number, body = article(html, page, known)
        name = f"{number} {heading}".strip()
        if page in starts:
            contents.append(f"<h2>{escape(starts[page])}</h2>")
        contents.append(f'<p><a href="#{anchor(page)}">{escape(name)}<i></i><b data-at="{anchor(page)}"></b></a></p>')
        heads.append(running_head(anchor(page), name))
        bodies.append(f'<section class="page" id="{anchor(page)}">{body.decode_contents()}</section>')
    first = BeautifulSoup((html / names[1]).read_text(encoding="utf-8"), "html.parser")
    head = [
        '<meta charset="utf-8" />',
        f"<title>{escape(title)}</title>",
        '<link rel="stylesheet" href="/_static/pygments.css" />',
        f"<style>{STYLE.replace('FOLIO', FOLIO)}{''.join(heads)}</style>",
        *(str(s) for s in first.find_all("script") if "mathjax" in str(s).lower()),
    ]
    picture = '<img src="/_static/overview.png" alt="" />'
    cover = f'<div class="title"><h1>{escape(title)}</h1><p>{datetime.now(UTC):%B %Y}</p>{picture}</div>'
    return (
        f'<!DOCTYPE html><html lang="en" data-theme="light"><head>{"".join(head)}</head><body>{cover}'
        f"<nav><h1>Contents</h1>{''.join(contents)}</nav>{''.join(bodies)}</body></html>"
    )


def printed(play: Any, executable: str, whole: str, address: str, cdn: Path | None, out: Path) -> list[str]:
    """Print the document; what went wrong, if anything did."""
    troubles: list[str] = []
    browser = play.chromium.launch(executable_path=executable, args=FLAGS)
    context = browser.new_context()
    if cdn:
        context.route("**/*", router(cdn))
    # it lies beside the pages for the browser only, so that their folder stays as it was built
    context.route("**/_book.html", lambda route: route.fulfill(body=whole, content_type="text/html; charset=utf-8"))
    page = context.new_page()
    page.set_default_timeout(300_000)
    page.on("pageerror", lambda error: troubles.append(f"page error: {error}"))
    page.on("requestfailed", lambda request: troubles.append(f"not there: {request.url}"))
    page.on(
        "response", lambda r: troubles.append(f"{r.status} {r.url}") if r.status >= 400 and is_local(r.url) else None
    )
    page.goto(f"{address}/_book.html", wait_until="load")
    if not page.evaluate(TYPESET):
        troubles.append(
            "formulas are not typeset: MathJax was not loaded. Without a network name a folder: --cdn FOLDER"
        )
    troubles += [f"formula: {error}" for error in page.evaluate(WRONG)]
    troubles += [f"picture: {source}" for source in page.evaluate(MISSING)]
    options = {"prefer_css_page_size": True, "print_background": True, "outline": True, "tagged": True}
    chapters = set(page.evaluate(CHAPTERS))
    page.pdf(path=out, **options)
    before = beginnings(out, chapters)
    page.evaluate(NUMBERS, before)
    page.pdf(path=out, **options)
    after = beginnings(out, chapters)
    troubles += [f"contents: {name} is on page {after[name]}" for name in chapters if after[name] != before[name]]
    browser.close()
    return troubles


def main() -> int:
    """Write the PDF; 1 where something in it is not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("html", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--cdn", type=Path)
    args = parser.parse_args()
    executable = chromium()
    if executable is None:
        print("No PDF: there is no Chromium here (Debian, Ubuntu: apt-get install chromium).")
        return 0
    (title,) = re.findall(r"^title: (.+)$", (ROOT / "_config.yml").read_text(encoding="utf-8"), re.MULTILINE)
    args.out.parent.mkdir(parents=True, exist_ok=True)
    whole = document(args.html, ROOT / "_toc.yml", title)
    with served(args.html) as address, sync_playwright() as play:
        troubles = printed(play, executable, whole, address, args.cdn, args.out)
    print(*troubles, f"{args.out}: {args.out.stat().st_size / 1e6:.1f} MB", sep="\n")
    return 1 if troubles else 0


if __name__ == "__main__":
    sys.exit(main())
