"""What a screen reader needs beyond the theme.

docutils calls a bibliography a list and its entries something else; the arrow that unfolds pages in the contents has no
name.
"""

import re
from typing import Any

from sphinx.application import Sphinx

ENTRY = re.compile(r'(<div class="citation"[^>]*?) role="doc-biblioentry"')


def process(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Sphinx's hook, called for each page before its template is filled in."""
    if "citation-list" in context.get("body", ""):
        body = context["body"].replace('role="list" class="citation-list"', 'class="citation-list"')
        context["body"] = ENTRY.sub(r"\1", body)
    contents = context.get("generate_toctree_html")

    def named(*args: Any, **kwargs: Any) -> Any:
        tree = contents(*args, **kwargs)
        for arrow in tree.select("li > details > summary") if hasattr(tree, "select") else ():
            arrow["aria-label"] = f"Pages of {arrow.find_parent('li').a.get_text(' ', strip=True)}"
        return tree

    if contents:
        context["generate_toctree_html"] = named


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the hook."""
    app.connect("html-page-context", process, priority=900)  # after the theme's own
    return {"parallel_read_safe": True, "parallel_write_safe": True}
