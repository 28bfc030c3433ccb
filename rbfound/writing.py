"""Write a file so that a killed or failing write leaves the old one whole."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path


def replaced(path: str | os.PathLike[str], write: Callable[[Path], object]) -> None:
    """Let `write` make a file aside, in the same folder, and put it in the place of `path` once it is complete.

    What a kill leaves of it lies in a hidden folder, .name-..., which readers of whole folders pass by.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.stem}-") as aside:
        whole = Path(aside) / path.name
        write(whole)
        os.replace(whole, path)


def text_replaced(path: str | os.PathLike[str], text: str) -> None:
    """The same for a text, in UTF-8 with the line ends as they are in it."""
    replaced(path, lambda whole: whole.write_text(text, encoding="utf-8", newline="\n"))
