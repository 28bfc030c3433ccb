"""Plain-text tables: what a notebook prints and what nbval compares."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def number(value: Any, digits: int = 4) -> str:
    """One entry as text: `digits` significant digits, "-" for None or nan, text as it is.

    Fixed point where that is readable (1e-3 to 1e6), scientific notation elsewhere.
    """
    if value is None:
        return "-"
    if isinstance(value, str | bool | int | np.integer):
        return str(value)
    value = float(value)
    if np.isnan(value):
        return "-"
    if value == 0:
        return "0"
    # rounded first: 9999.7 has five digits before the point once it is printed with four
    value = float(f"{value:.{digits - 1}e}")
    if 1e-3 <= abs(value) < 1e6:
        decimals = max(digits - 1 - int(np.floor(np.log10(abs(value)))), 0)
        return f"{value:.{decimals}f}"
    return f"{value:.{digits - 1}e}"


def table(columns: Mapping[str, Any], digits: int = 4) -> str:
    """Columns under their headings, right-aligned; columns of words are aligned left.

    Parameters
    ----------
    columns : mapping from a heading to a sequence of entries
        Shorter columns are filled with blanks below. None and nan print as "-".
    digits : int
        Significant digits of a number.
    """
    height = max((len(entries) for entries in columns.values()), default=0)
    blocks = []
    for heading, entries in columns.items():
        cells = [heading, *(number(entry, digits) for entry in entries)]
        cells += [""] * (height + 1 - len(cells))
        width = max(len(cell) for cell in cells)
        left = any(isinstance(entry, str) and any(letter.isalpha() for letter in entry) for entry in entries)
        blocks.append([cell.ljust(width) if left else cell.rjust(width) for cell in cells])
    return "\n".join("  ".join(row).rstrip() for row in zip(*blocks, strict=True))


def bound(value: float, rounding: float = 1e-11) -> str:
    """A residual as a power of ten at least three times as large: 3e-9 gives "< 1e-08", 5e-9 gives "< 1e-07".

    What lies below the floor `rounding`, a power of ten, is not told apart: rounding differs from one processor to the
    next. A floor that is thirty times what rounding leaves, or more, prints alike on each.
    """
    if not np.isfinite(value) or value < 0:
        raise ValueError(f"A residual is finite and not negative, this one is {value}.")
    decade = round(float(np.log10(rounding))) if 0 < rounding < np.inf else 0
    if rounding != float(f"1e{decade}"):
        raise ValueError(f"The floor of a residual is a power of ten, for example 1e-11, and not {rounding}.")
    # powers as they are read: 10.0**-5 is not 1e-5 in the last bit
    while 3 * value > float(f"1e{decade}"):
        decade += 1
    return f"< 1e{decade:+03d}"
