"""Roles that a screen reader can follow: docutils calls a bibliography a list and its entries something else."""

import re
from typing import Any

from sphinx.application import Sphinx

ENTRY = re.compile(r'(<div class="citation"[^>]*?) role="doc-biblioentry"')


def process(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Sphinx's hook, called for each page before its template is filled in."""
    if "citation-list" in context.get("body", ""):
        body = context["body"].replace('role="list" class="citation-list"', 'class="citation-list"')
        context["body"] = ENTRY.sub(r"\1", body)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the hook."""
    app.connect("html-page-context", process)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
