"""The page on how to cite, filled in from CITATION.cff."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = "book/cite"


def name(author: dict[str, str]) -> str:
    """An author: a group by its name, a person surname first."""
    return author.get("name") or f"{author['family-names']}, {author['given-names']}"


def entry(cff: dict[str, Any]) -> str:
    """The citation as a BibTeX entry."""
    fields = {
        "author": " and ".join(f"{{{name(a)}}}" if "name" in a else name(a) for a in cff["authors"]),
        "title": f"{{{cff['title']}}}",
        "version": cff["version"],
        "year": str(cff.get("date-released", ""))[:4],
        "doi": cff.get("doi", ""),
        "url": cff.get("url", cff.get("repository-code", "")),
        "note": f"Licence: {cff['license']}",
    }
    lines = [f"  {key} = {{{value}}}," for key, value in fields.items() if value]
    key = re.sub(r"\W", "", cff["title"].split(":")[0])
    return "\n".join([f"@software{{{key},", *lines, "}"])


def generated() -> str:
    """The citation as a sentence and as BibTeX."""
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    authors = "; ".join(map(name, cff["authors"]))
    sentence = f"> {authors}: *{cff['title']}*, version {cff['version']}."
    return f"{sentence}\n\n```bibtex\n{entry(cff)}\n```"


def process(app: "Sphinx", docname: str, source: list[str]) -> None:
    """Sphinx's hook: fill in the page before it is read."""
    if docname == PAGE:
        source[0] = source[0].replace("% generated: citation", generated())


def setup(app: "Sphinx") -> dict[str, bool]:
    """Register the hook."""
    app.connect("source-read", process)
    return {"parallel_read_safe": True}
