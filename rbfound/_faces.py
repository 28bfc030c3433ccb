"""The face of a package: the names that its stub hands on, each loaded when it is first asked for (PEP 562).

A program waits for no more than what it uses, and an extra is needed only by those who use it. Type checkers and
editors read the same stub.
"""

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

Face = tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]


def face(package: str, file: str) -> Face:
    """`__getattr__`, `__dir__` and `__all__` of a package.

    Parameters
    ----------
    package, file : its `__name__` and `__file__`
        The stub beside the file has nothing but statements `from module import name as name`, and below an empty line
        what is no import.
    """
    with open(f"{file}i", encoding="utf-8") as stub:  # __init__.pyi
        statements = stub.read().split("\nfrom ")[1:]
    homes: dict[str, str] = {}
    for statement in statements:
        module, _, names = statement.partition("\n\n")[0].partition(" import ")
        homes |= {name.split()[0]: module for name in names.strip("() \n").split(",") if name.strip()}
    there = vars(sys.modules[package])

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home = homes[name]
        value = import_module(f"{package}.{name}") if home == package else getattr(import_module(home), name)
        there[name] = value
        return value

    return load, lambda: sorted({*there, *homes}), sorted(homes)
