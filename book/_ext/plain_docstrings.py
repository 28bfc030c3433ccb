"""Let the package's docstrings be plain text, and still look right in the book.

A docstring is read in an editor far more often than here. So it says |H| and M q'' as one would on paper, and this
extension tells Sphinx what that means: bars, stars and trailing underscores are themselves, an indented formula keeps
its line breaks.
"""

import re
from typing import Any

from sphinx.application import Sphinx

CODE = re.compile(r"(`+[^`]*`+)")
SPECIAL = re.compile(r"[|*]|(?<=\w)_(?!\w)")


def indent(line: str) -> int:
    """Number of leading blanks."""
    return len(line) - len(line.lstrip())


def escaped(line: str) -> str:
    """The line with each character that has a meaning in reStructuredText made a plain one, `code` excepted."""
    parts = CODE.split(line)
    return "".join(part if k % 2 else SPECIAL.sub(r"\\\g<0>", part) for k, part in enumerate(parts))


def marked_up(lines: list[str]) -> list[str]:
    """A plain docstring as reStructuredText: formulas (indented after an empty line) literal, all else escaped."""
    out: list[str] = []
    text = 0  # indentation of the last line of running text
    literal = False
    for line in lines:
        if not line.strip():
            out.append(line)
            continue
        if literal and indent(line) > text:
            out.append(line)
            continue
        literal = bool(out) and not out[-1].strip() and indent(line) > text
        if literal:
            out += [" " * text + "::", "", line]
        else:
            text = indent(line)
            out.append(escaped(line))
    return out


def process(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Sphinx's hook: rewrite the docstring's lines in place, before numpydoc reads its sections."""
    lines[:] = marked_up(lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the hook."""
    app.connect("autodoc-process-docstring", process, priority=100)
    return {"parallel_read_safe": True}
