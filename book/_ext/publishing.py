"""What a published copy of the book has beside its pages: launch buttons, a card for links, a page for lost readers.

Where it is published is its owner's business: `repository: url` and `html: baseurl` in _config.yml, or the environment
variables BOOK_REPOSITORY, BOOK_BRANCH and BOOK_BASEURL, which the workflow file sets. Without a repository there are no
launch buttons, as they would lead nowhere.
"""

import os
import re
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote, urljoin

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config

LOST = """<h1>There is no such page</h1>
<p>The address may be old: chapters keep their numbers, but not always their names. All of them are in the
column of contents; <a href="search.html">search</a> finds words in any of them; or begin
<a href="index.html">at the beginning</a>.</p>"""


# at the top of the book there is no page, only the way to the first one
DOOR = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8" />
<title>{title}</title>
<meta http-equiv="Refresh" content="0; url={first}.html" />
</head>
<body><p><a href="{first}.html">{title}</a></p></body>
</html>
"""


def configured(app: Sphinx, config: Config) -> None:
    """Sphinx's hook: the environment says where this copy is published."""
    options = config.html_theme_options
    options["repository_url"] = os.environ.get("BOOK_REPOSITORY", options.get("repository_url", ""))
    options["repository_branch"] = os.environ.get("BOOK_BRANCH", options.get("repository_branch", "main"))
    address = os.environ.get("BOOK_BASEURL", config.html_baseurl)
    config.html_baseurl = address.rstrip("/") + "/" if address else ""


def launchers(repository: str, branch: str, page: str) -> list[dict[str, str]]:
    """Buttons that open a chapter where it can be run. Colab's copies have a cell that installs the package."""
    owner = re.sub(r"(\.git)?/*$", "", repository.removeprefix("https://github.com/"))
    tree = quote(f"lab/tree/{page}.ipynb", safe="")
    places = {
        "JupyterLab (Binder)": f"https://mybinder.org/v2/gh/{owner}/{branch}?urlpath={tree}",
        "Colab": f"https://colab.research.google.com/github/{owner}/blob/colab/{page}.ipynb",
    }
    return [
        {"type": "link", "text": name, "tooltip": f"Open in {name}", "icon": "fas fa-rocket", "url": url}
        for name, url in places.items()
    ]


def summary(doctree: nodes.document | None) -> str:
    """The first paragraph of a page; of a chapter, the question that it answers."""
    paragraph = next(iter(doctree.findall(nodes.paragraph)), None) if doctree else None
    text = " ".join(paragraph.astext().split()) if paragraph else ""
    return text if len(text) <= 200 else text[:197].rsplit(" ", 1)[0] + " ..."


def card(title: str, text: str, site: str, base: str, page: str) -> str:
    """Meta elements for those who show a link as a card. Pictures and addresses in them must be absolute."""
    told = {"og:type": "website", "og:site_name": site, "og:title": title, "og:description": text}
    if base:
        told |= {"og:url": urljoin(base, f"{page}.html"), "og:image": urljoin(base, "_static/social.png")}
    lines = [f'<meta property="{key}" content="{escape(value)}" />' for key, value in told.items() if value]
    return "\n".join([*lines, '<meta name="twitter:card" content="summary_large_image" />' if base else ""])


def page_context(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Sphinx's hook, called for each page before its template is filled in, after the theme's own."""
    options, base = app.config.html_theme_options, app.config.html_baseurl
    title = re.sub(r"<[^>]+>", "", context.get("title", "")) or app.config.html_title
    tags = [context.get("metatags", ""), card(title, summary(doctree), app.config.html_title, base, page)]
    if page == "404":  # it is shown at any depth, so its links start at the top
        tags.insert(0, f'<base href="{base or "/"}" />')
    context["metatags"] = "\n".join(tags)
    if options["repository_url"].startswith("https://github.com/") and page.startswith("notebooks/"):
        buttons = launchers(options["repository_url"], options["repository_branch"], page)
        group = {"type": "group", "tooltip": "Run this chapter", "icon": "fas fa-rocket", "label": "launch-buttons"}
        context["header_buttons"].insert(0, {**group, "buttons": buttons})


def lost(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Sphinx's hook: pages that have no source."""
    yield "404", {"title": "There is no such page", "body": LOST}, "page.html"


def door(app: Sphinx, error: Exception | None) -> None:
    """Sphinx's hook: the book opens at its first page. What would be written otherwise is no valid HTML."""
    if app.builder.format == "html" and not error:
        text = DOOR.format(title=escape(app.config.html_title), first=app.config.root_doc)
        Path(app.outdir, "index.html").write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the hooks."""
    app.connect("config-inited", configured, priority=900)
    app.connect("html-page-context", page_context, priority=900)
    app.connect("html-collect-pages", lost)
    app.connect("build-finished", door)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
