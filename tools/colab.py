"""Copies of the notebooks for Colab, which opens one notebook without the repository that it belongs to.

    python tools/colab.py https://github.com/OWNER/REPOSITORY _build/colab

Each copy begins with a cell that fetches the repository, installs the package and goes to the notebooks' folder.
"""

import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
FETCH = """# Colab only: fetch the book's repository, install its package
!test -d /content/book || git clone --quiet --depth 1 {repository} /content/book
%pip install --quiet "/content/book[plots,solid]" anywidget
%cd -q /content/book/notebooks"""


def with_fetch(notebook: Path, repository: str) -> str:
    """A notebook's text with the cell put before all others."""
    content = json.loads(notebook.read_text(encoding="utf-8"))
    cell: dict[str, Any] = {
        "cell_type": "code",
        "execution_count": None,
        "id": "cell-00",
        "metadata": {},
        "outputs": [],
        "source": FETCH.format(repository=repository).splitlines(keepends=True),
    }
    content["cells"].insert(0, cell)
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def main() -> int:
    """Write the copies."""
    if len(sys.argv) != 3 or not sys.argv[1].startswith("https://"):
        print(__doc__, file=sys.stderr)
        return 2
    out = Path(sys.argv[2]) / "notebooks"
    out.mkdir(parents=True, exist_ok=True)
    for notebook in sorted(ROOT.glob("notebooks/*.ipynb")):
        (out / notebook.name).write_text(with_fetch(notebook, sys.argv[1]), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
