"""Full-page pictures of every page of the built book, wide (1280) and narrow (390), to look at.

    python tools/screenshots.py _build/html _build/screenshots [--cdn FOLDER] [--pages PAGE ...]

Nothing is fetched from the network. Without it formulas stay raw TeX and widgets are missing, so `--cdn` names a
folder with the packages that the pages take from a CDN, as npm unpacks them (`npm pack mathjax@3.2.2` and so on):

    FOLDER/mathjax/..., FOLDER/requirejs/..., FOLDER/@jupyter-widgets/html-manager/...
"""

import argparse
import sys
from pathlib import Path
from typing import Any

from browser import FLAGS, chromium, pages, router, served
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parent.parent
WIDTHS = (1280, 390)
UNREADABLE = "Array.from(document.querySelectorAll('[data-mjx-error]'), e => e.getAttribute('data-mjx-error'))"


def picture(page: Any, url: str, path: Path, patience: float) -> list[str]:
    """Open a page, wait for its formulas and widgets, save the picture; the errors in its formulas."""
    page.goto(url, wait_until="load")
    page.wait_for_timeout(patience)
    page.screenshot(path=path, full_page=True)
    return list(page.evaluate(UNREADABLE))


def main() -> int:
    """Write the pictures; 1 where there is no browser or a formula cannot be read."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("html", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--cdn", type=Path)
    parser.add_argument("--pages", nargs="+", default=pages(ROOT / "_toc.yml"))
    args = parser.parse_args()
    executable = chromium()
    if executable is None:
        print("There is no Chromium here: install it (Debian, Ubuntu: apt-get install chromium).", file=sys.stderr)
        return 1
    args.out.mkdir(parents=True, exist_ok=True)
    unreadable = 0
    with served(args.html) as address, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=executable, args=FLAGS)
        for width in WIDTHS:
            context = browser.new_context(viewport={"width": width, "height": 900})
            context.route("**/*", router(args.cdn))
            for name in args.pages:
                path = args.out / f"{name.removesuffix('.html').replace('/', '-')}-{width}.png"
                page = context.new_page()
                errors = picture(page, f"{address}/{name}", path, patience=2000 if args.cdn else 300)
                page.close()
                print(path, *(f"  cannot be read: {error}" for error in errors), sep="\n", flush=True)
                unreadable += len(errors)
        browser.close()
    return 1 if unreadable else 0


if __name__ == "__main__":
    sys.exit(main())
