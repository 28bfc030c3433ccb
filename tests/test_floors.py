"""The floors of the package: what imports what, read from the source."""

import ast
import inspect
import json
import math
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import rbfound

PACKAGE = Path(rbfound.__file__).parent

# A module imports from lower floors only: neither from its own floor nor from above. A new module gets its line here.
FLOORS = {
    "adaptive": 0,
    "arc": 0,
    "balance": 0,
    "beam": 0,
    "dissection": 0,
    "nodechain": 0,
    "plots_style": 0,
    "leastsquares": 0,
    "mesh": 0,
    "noise": 0,
    "orbits": 0,
    "orthogonal": 0,
    "tables": 0,
    "parallel": 0,
    "units": 0,
    "additions": 1,
    "compression": 1,
    "sketch": 1,
    "assembly": 1,
    "calculix": 1,
    "complexmodes": 1,
    "elimination": 1,
    "roundshaft": 1,
    "frf": 1,
    "geometry": 1,
    "sdof": 1,
    "system": 1,
    "peaks": 2,
    "averaging": 2,
    "confidence": 2,
    "modesearch": 3,
    "remainder": 2,
    "polyreference": 2,
    "elastic": 2,
    "lowest": 2,
    "lumped": 2,
    "reduction": 2,
    "synthesis": 2,
    "live_sdof": 2,
    "checking": 3,
    "circle": 3,
    "foundation": 3,
    "lanczos": 3,
    "rotor": 3,
    "bodies": 4,
    "coupling": 4,
    "files": 5,
    "exports": 4,
    "gathering": 3,
    "uff": 3,
    "textfiles": 2,
    "arrays": 1,
    "quantities": 1,
    "matfile": 0,
    "rows": 0,
    "writing": 0,
    "fitting": 4,
    "light": 4,
    "folders": 4,
    "modalfit": 4,
    "reading": 4,
    "residues": 4,
    "rigid": 4,
    "partialfractions": 1,
    "polynomials": 5,
    "rig": 5,
    "solid": 4,
    "revolved": 5,
    "uncertainty": 6,
    "steps": 4,
    "sweeps": 5,
    "thesis": 5,
    "transmitted": 5,
    "whirl": 5,
    "bench": 5,
    "full": 6,
    "impedance": 6,
    "picking": 6,
    "inverse": 6,
    "machinefile": 6,
    "plots": 6,
    "live_machine": 6,
    "live_reduction": 6,
    "frontend": 7,
    "command": 9,
    "reportpage": 8,
    "rossbearing": 4,
    "roads": 7,
    "plots_bars": 7,
    "plots_check": 7,
    "plots_measured": 7,
    "plots_cost": 7,
    "plots_coupling": 7,
    "plots_peaks": 7,
    "plots_poles": 7,
    "plots_theory": 7,
    "plots_rotor": 7,
    "plots_bodies": 7,
    "plots_sketches": 8,
    "viewer": 8,
    "live": 8,
    "widgets": 8,
}

# Packages beyond numpy and scipy, and the modules that may import them: each an extra of its own.
EXTRAS = {
    "matplotlib": {
        "plots",
        "plots_bars",
        "plots_bodies",
        "plots_check",
        "plots_measured",
        "plots_cost",
        "plots_coupling",
        "plots_peaks",
        "plots_poles",
        "plots_rotor",
        "plots_sketches",
        "plots_style",
        "plots_theory",
        "reportpage",
        "viewer",
    },
    "skfem": {"assembly", "mesh", "revolved"},
    "ipywidgets": {"widgets"},
    "anywidget": {"widgets"},
    "IPython": {"widgets"},
    "traitlets": {"widgets"},
    "pyarrow": {"sweeps"},
    "pyuff": {"uff"},
    "ross": {"rossbearing"},
}

# Doors: a function that is asked for something only an extra can do imports the module of that extra there and then.
DOORS = {"files": {"rbfound.uff"}, "command": {"rbfound.reportpage"}}

MODULES = sorted(path.stem for path in PACKAGE.glob("*.py") if path.stem != "__init__")


@cache
def tree_of(module):
    return ast.parse((PACKAGE / f"{module}.py").read_text(encoding="utf-8"))


@cache
def nodes_of(tree):
    return list(ast.walk(tree))


def stub_imports():
    """(module, public name) of each import of `__init__.pyi`."""
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    return [(node.module, alias.name) for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]


def imports_of(tree):
    """(full name, node) of each module that a tree imports; `from rbfound import x` counts as rbfound.x."""
    for node in nodes_of(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, node
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: a relative import; write from rbfound.… import …"
            if node.module == "rbfound":
                for alias in node.names:
                    yield f"rbfound.{alias.name}", node
            else:
                yield node.module, node


def test_every_module_has_a_floor():
    assert set(MODULES) <= set(FLOORS), "give the new module a floor"


def test_every_module_imports_from_lower_floors_only():
    faults = []
    for module in MODULES:
        for name, node in imports_of(tree_of(module)):
            if name.split(".")[0] == "rbfound":
                imported = name.split(".")[1] if "." in name else "rbfound itself"
                here, there = FLOORS[module], FLOORS.get(imported, math.inf)
                if there >= here:
                    faults.append(f"{module}.py, line {node.lineno}: floor {here} imports {imported} of floor {there}")
    assert not faults, "\n".join(faults)


def test_imports_stand_at_the_top_of_a_module():
    faults = []
    for module in (*MODULES, "__init__"):
        tree = tree_of(module)
        top = set(tree.body)
        doors = DOORS.get(module, set())
        faults += [
            f"{module}.py, line {node.lineno}: imports {name} inside a function or a branch"
            for name, node in imports_of(tree)
            if node not in top and name not in doors
        ]
        # of what it offers, the package itself imports by name what is asked for, and nothing else does
        faults += [
            f"{module}.py, line {node.lineno}: imports by name"
            for node in nodes_of(tree)
            if isinstance(node, ast.Name | ast.Attribute)
            and (getattr(node, "id", None) or getattr(node, "attr", None)) in ("__import__", "import_module")
            and module != "__init__"
        ]
    assert not faults, "\n".join(faults)


def test_only_the_module_of_an_extra_imports_it():
    faults = []
    for module in (*MODULES, "__init__"):
        allowed = {"numpy", "scipy", "rbfound"} | {package for package, users in EXTRAS.items() if module in users}
        for name, node in imports_of(tree_of(module)):
            package = name.split(".")[0]
            if package not in allowed and package not in sys.stdlib_module_names:
                faults.append(f"{module}.py, line {node.lineno}: {name}")
    assert not faults, "\n".join(faults)


def test_no_public_name_comes_from_a_module_of_an_extra():
    users = set().union(*EXTRAS.values())
    homes = {module.partition(".")[2] or name for module, name in stub_imports()}
    assert homes
    assert not homes & users


def test_importing_rbfound_loads_neither_numpy_nor_a_module_of_its_own():
    code = "import json, sys, rbfound; print(json.dumps(sorted(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = json.loads(run.stdout)
    assert "rbfound" in loaded
    assert not [name for name in loaded if name.startswith(("rbfound.", "numpy", "scipy"))]


def test_names_are_those_of_the_stub_from_the_modules_that_it_says():
    for module, name in stub_imports():
        thing = getattr(rbfound, name)
        home = sys.modules[f"rbfound.{name}" if module == "rbfound" else module]
        assert thing is (home if module == "rbfound" else getattr(home, name)), name
    assert sorted(name for _, name in stub_imports()) == sorted(rbfound.__all__)
    assert set(rbfound.__all__) <= set(dir(rbfound))


def test_a_name_that_is_not_there_is_an_attribute_error_and_an_import_error():
    with pytest.raises(AttributeError, match=r"module 'rbfound' has no attribute 'campbel'"):
        _ = rbfound.campbel
    with pytest.raises(ImportError, match="campbel"):
        exec("from rbfound import campbel", {})


def test_importing_all_names_of_rbfound_loads_no_extra():
    # in a fresh interpreter: this one may have loaded anything
    code = "import json, sys; from rbfound import *; print(json.dumps(sorted({m.split('.')[0] for m in sys.modules})))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(json.loads(run.stdout))
    assert run.stderr == ""
    assert "numpy" in loaded
    assert not loaded & {
        "matplotlib",
        "skfem",
        "ipywidgets",
        "anywidget",
        "IPython",
        "jupyterlab",
        "pyarrow",
        "pyuff",
    }


def test_all_names_exist_and_are_there_once():
    names = rbfound.__all__
    assert len(set(names)) == len(names)
    assert all(hasattr(rbfound, name) for name in names)


def test_no_module_bears_the_name_of_a_public_function():
    # `rbfound.name` would then be the one or the other, depending on who was imported last
    functions = {name for name in rbfound.__all__ if not inspect.ismodule(getattr(rbfound, name))}
    assert not functions & set(MODULES)


def test_no_module_defines_a_function_of_its_own_name():
    # `from rbfound.whirl import whirl` and `from rbfound import whirl` would be two things
    for module in MODULES:
        names = {node.name for node in tree_of(module).body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
        assert module not in names


def test_every_module_and_public_function_class_and_method_has_a_docstring():
    faults = []
    for module in MODULES:
        tree = tree_of(module)
        public = [tree]
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                # a subclass's methods are told of by the class that they come from
                inner = node.body if isinstance(node, ast.ClassDef) and not node.bases else []
                methods = [n for n in inner if isinstance(n, ast.FunctionDef) and not n.name.startswith("_")]
                public += [node, *methods]
        faults += [f"{module}.py: {getattr(n, 'name', 'the module')}" for n in public if not ast.get_docstring(n)]
    assert not faults, "\n".join(faults)


def test_no_module_hides_errors_or_prints():
    # a bare except, a print and a silenced warning are the ways in which a result goes wrong unseen
    hiding = ("print", "warnings.simplefilter", "warnings.filterwarnings")
    faults = []
    for module in MODULES:
        for node in nodes_of(tree_of(module)):
            bare = isinstance(node, ast.ExceptHandler) and node.type is None
            if bare or (isinstance(node, ast.Call) and ast.unparse(node.func) in hiding):
                faults.append(f"{module}.py, line {node.lineno}")
    assert not faults, "\n".join(faults)


def test_only_units_knows_that_a_turn_is_2_pi_and_a_minute_60_seconds():
    # `2 * np.pi` elsewhere would be a second place where hertz and rad/s meet
    for module in MODULES:
        if module == "units":
            continue
        for node in nodes_of(tree_of(module)):
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div):
                assert ast.unparse(node) not in ("2 * np.pi", "np.pi * 2", "2.0 * np.pi"), f"{module}.py, {node.lineno}"


def test_results_are_frozen():
    for name in rbfound.__all__:
        thing = getattr(rbfound, name)
        if inspect.isclass(thing):
            assert thing.__dataclass_params__.frozen, name
