"""Which printed numbers of the notebooks differ from processor to processor, and which might.

BLAS and numpy choose their kernels by the processor, and each rounds differently. A notebook runs under each kind that
this machine can play, and once with FRFs that are off by up to 1e-13 of themselves. Every number formatted on its way
into an output is kept in full: those of f-strings, `round`, `rb.table` and `rb.bound`, in cells and in the package.
Listed is what prints differently, and what would if it were off by ten times the spread of the runs or 1e-12 of itself.

    python tools/rounding_edges.py [--kinds=Prescott,Haswell,perturbed] notebooks/*.ipynb
"""

import ast
import builtins
import contextlib
import io
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from kernels import Kind, environment, playable

ROOT = Path(__file__).resolve().parent.parent
MARGIN, RELATIVE, PERTURBED = 10, 1e-12, 1e-13
# Not a processor, but data that differ in the last digits.
PERTURBATION = Kind("perturbed", {"RBFOUND_PERTURBED": "1"})
# What stands at the end of a module while its numbers are kept.
ADDED = {
    "rbfound.tables": "number, bound = _keeping('number', number, 4), _keeping('bound', bound, 1e-11)",
    "rbfound.files.load_save": "load_frf = _perturbed(load_frf)",
}
# Each formatted number of the cell that runs: how and with what setting it is formatted, its value, the text around it.
records: list[tuple[str, Any, complex, str]] = []


def formatted(how: str, setting: Any, value: Any) -> str:
    """A number's text, as the notebook made it."""
    from rbfound import tables  # not before `child` has had its way with the package

    if how == "round":
        return str(np.round(value, setting) + 0.0)
    if how == "format":
        return format(value, setting)
    return tables.number(value, setting) if how == "number" else tables.bound(value, setting)


def keep(how: str, setting: Any, value: Any, text: str) -> None:
    """Record a number, if it is finite and no count."""
    if isinstance(value, float | complex | np.floating | np.complexfloating) and np.isfinite(value):
        records.append((how, setting, complex(value), text))


def joined(*parts: Any) -> str:
    """What stands in for an f-string, whose parts are texts and pairs of a value and its format."""
    text = "".join(part if isinstance(part, str) else format(*part) for part in parts)
    for part in parts:
        if not isinstance(part, str):
            keep("format", part[1], part[0], text)
    return text


def rounded(function: Callable[..., Any], value: Any, digits: int = 0) -> Any:
    """What stands in for round(value, digits), np.round(value, digits) and value.round(digits) of a cell."""
    for one in np.ravel(value):
        keep("round", digits, one, "")  # what becomes of it is not known
    return function(value, digits) if digits else function(value)


def keeping(how: str, function: Callable[..., str], default: Any) -> Callable[..., str]:
    """`number` or `bound` of `rbfound.tables`, with a record of what it formats."""

    def call(value: Any, *setting: Any, **named: Any) -> str:
        text = function(value, *setting, **named)
        keep(how, next(iter([*setting, *named.values()]), default), value, text)
        return text

    return call


def perturbed(load: Callable[..., Any]) -> Callable[..., Any]:
    """`rb.load_frf` with each entry of the files in data/ off by up to 1e-13 of itself, alike in each run."""

    def loading(path: Any, *arguments: Any, **named: Any) -> Any:
        frf = load(path, *arguments, **named)
        off = np.random.default_rng(0).uniform(-PERTURBED, PERTURBED, frf.H.shape)
        off = (off + off.transpose(0, 2, 1)) / 2  # a reciprocal set stays one: fits weigh others differently
        return replace(frf, H=frf.H * (1 + off)) if Path(path).resolve().is_relative_to(ROOT / "data") else frf

    return loading if "RBFOUND_PERTURBED" in os.environ else load


class Kept(ast.NodeTransformer):
    """Code whose f-strings, and in a cell calls of round, keep a record."""

    def __init__(self, cell: bool) -> None:
        self.cell = cell

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        parts: list[ast.expr] = []
        for part in node.values:
            if isinstance(part, ast.FormattedValue) and part.conversion == -1:
                parts.append(ast.Tuple([self.visit(part.value), part.format_spec or ast.Constant("")], ast.Load()))
            else:
                parts.append(part if isinstance(part, ast.Constant) else ast.JoinedStr([part]))
        return ast.Call(ast.Name("_joined", ast.Load()), parts, [])

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        to = node.func
        if not self.cell or "round" not in (getattr(to, "id", ""), getattr(to, "attr", "")):
            return node
        # round(value), np.round(value) or value.round()
        value = [to.value] if isinstance(to, ast.Attribute) and getattr(to.value, "id", "") != "np" else []
        name = "_np_round" if isinstance(to, ast.Attribute) else "_round"
        return ast.Call(ast.Name(name, ast.Load()), [*value, *node.args], node.keywords)


def kept(source: str, cell: bool = False) -> ast.Module:
    """Code as `Kept`."""
    return ast.fix_missing_locations(Kept(cell).visit(ast.parse(source)))


def cells(path: Path) -> Iterator[tuple[int, str, list[Any]]]:
    """Run a notebook here: each code cell's number from 1, its output, and the numbers that it formatted."""
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(json.loads(path.read_text(encoding="utf-8"))["cells"], start=1):
        if cell["cell_type"] != "code":
            continue
        tree = kept("".join(cell["source"]), cell=True)
        last: ast.expr = ast.Constant(None)
        if isinstance(tree.body[-1], ast.Expr):
            last = tree.body.pop().value  # type: ignore[attr-defined]
        records.clear()
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(tree, path.name, "exec"), names)
            shown = eval(compile(ast.fix_missing_locations(ast.Expression(last)), path.name, "eval"), names)
            print("" if shown is None else repr(shown))
        plt.close("all")
        yield number, out.getvalue(), records.copy()


def child(path: Path) -> None:
    """Run one notebook in this process, with the package's code `kept`, and write what it gave to stdout."""
    vars(builtins).update(_joined=joined, _keeping=keeping, _perturbed=perturbed)
    vars(builtins).update({"_round": partial(rounded, round), "_np_round": partial(rounded, np.round)})
    usual = SourceFileLoader.get_code

    def get_code(loader: SourceFileLoader, name: str) -> Any:
        if name.split(".")[0] != "rbfound":
            return usual(loader, name)
        return compile(kept(f"{loader.get_data(loader.path).decode()}\n{ADDED.get(name, '')}"), loader.path, "exec")

    SourceFileLoader.get_code = get_code  # type: ignore[method-assign, assignment]
    os.chdir(path.parent)
    warnings.simplefilter("error")
    ran = list(cells(path))
    warnings.resetwarnings()  # a folder for a while, which a notebook may leave to the end, warns when it goes
    # a number may be formatted in one cell and printed, in lines of any width, in another
    whole = " ".join("".join(text for _, text, _ in ran).split())
    inside = [(n, text, [r for r in of if " ".join(r[3].split()) in whole]) for n, text, of in ran]
    json.dump([(n, text, [(*r[:2], r[2].real, r[2].imag) for r in of]) for n, text, of in inside], sys.stdout)


def play(path: Path, kind: Kind) -> Any:
    """What `cells` gives under one kind of processor."""
    env = environment(kind, dict(os.environ)) | {"MPLBACKEND": "agg", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, __file__, "--child", str(path)]
    return json.loads(subprocess.run(command, env=env, stdout=subprocess.PIPE, check=True).stdout)


def complaints(runs: dict[str, Any]) -> Iterator[str]:
    """What differs between the runs of a notebook under several kinds, and what might."""
    for same in zip(*runs.values(), strict=True):
        texts, kept = [text for _, text, _ in same], [numbers for _, _, numbers in same]
        where = f"  cell {same[0][0]}:"
        for kind, text in zip(runs, texts, strict=True):
            lines = [pair for pair in zip(texts[0].splitlines(), text.splitlines(), strict=False) if len(set(pair)) > 1]
            if text != texts[0]:
                yield f"{where} prints otherwise under {kind}: " + " | ".join(lines[0] if lines else ["lines"])
        if len({len(numbers) for numbers in kept}) > 1:
            yield f"{where} formats another count of numbers from kind to kind"
            continue
        for number in zip(*kept, strict=True):
            how, by = number[0][:2]
            values = [complex(*one[2:]) if any(n[3] for n in number) else one[2] for one in number]
            spread, size = max(abs(v - values[0]) for v in values), max(map(abs, values))
            if spread == 0 and size == float(f"{size:.9g}"):
                continue  # a number as it was typed in
            off = max(MARGIN * spread, RELATIVE * size)
            near = [v + d for v in values for d in (-off, 0, off)]
            if all(isinstance(v, float) and v >= 0 for v in values):
                near = [abs(v + abs(v)) / 2 for v in near]  # what has no sign gets none
            ways = sorted({formatted(how, by, v) for v in near})
            if len(ways) > 1:
                yield f"{where} {values[0]:.12g}, spread {spread:.1g}, prints as {' or '.join(ways)}"


def main(arguments: list[str]) -> int:
    """Compare the runs of each notebook; 1 if anything is listed."""
    named = [a.removeprefix("--kinds=").split(",") for a in arguments if a.startswith("--kinds=")]
    kinds = [kind for kind in (*playable(), PERTURBATION) if not named or kind.name in named[0]]
    print("kinds:", *(kind.name for kind in kinds))
    found = 0
    for name in (a for a in arguments if not a.startswith("--")):
        listed = list(complaints({kind.name: play(Path(name), kind) for kind in kinds}))
        print(f"{name}: {len(listed)} listed", *listed, sep="\n", flush=True)
        found += len(listed)
    return 1 if found else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        child(Path(sys.argv[2]).resolve())
    else:
        sys.exit(main(sys.argv[1:]))
