"""What nbval does not compare: pictures. Their text stands beside them, and is compared."""

from pathlib import Path
from typing import Any


def pytest_collectstart(collector: Any) -> None:
    """A picture that can be turned is HTML; its text is compared."""
    if Path(collector.path).suffix == ".ipynb":
        collector.skip_compare += ("text/html",)
