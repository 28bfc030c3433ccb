"""Write a file so that a killed or failing write leaves the old one whole."""

import contextlib
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

# A write that is killed leaves its folder of this name behind; a later write removes it when it is an hour old, for
# nobody writes that long.
ASIDE, STALE = ".writing-", 3600.0


@contextlib.contextmanager
def aside(folder: Path) -> Iterator[Path]:
    """A folder inside `folder`, which is made if need be, for what is not complete yet; gone in the end."""
    folder.mkdir(parents=True, exist_ok=True)
    for left in folder.glob(f"{ASIDE}*"):
        # another program may remove it first
        with contextlib.suppress(OSError):
            if time.time() - left.stat().st_mtime > STALE:
                shutil.rmtree(left)
    with tempfile.TemporaryDirectory(prefix=ASIDE, dir=folder) as name:
        yield Path(name)


def replaced(path: str | os.PathLike[str], write: Callable[[Path], object]) -> None:
    """Let `write` make a file aside, in the same folder, and put it in the place of `path` once it is complete."""
    path = Path(path)
    with aside(path.parent) as folder:
        write(folder / path.name)
        os.replace(folder / path.name, path)


def text_replaced(path: str | os.PathLike[str], text: str) -> None:
    """The same for a text, in UTF-8 with the line ends as they are in it."""
    replaced(path, lambda whole: whole.write_text(text, encoding="utf-8", newline="\n"))
