"""The house of the package: which room may import what, read from the source. One test a rule.

What can be seen in one file, ruff keeps: docstrings, imports at the top, no print, no hidden error (pyproject.toml).
"""

import ast
import json
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module

import pytest
from house import FACES, LAST, PACKAGE, ROOMS, imports_of, modules, modules_in, own_imports, room_of, tree_of

import rbfound

MOST_MODULES, MOST_LINES, MOST_NAMES = 12, 400, 40

# Packages beyond numpy and scipy, and who may import them: a room, or a module. Each is an extra of its own.
EXTRAS = {
    "matplotlib": {"plots", "thesis.sketches"},
    "skfem": {"solid"},
    "ipywidgets": {"live.widgets"},
    "anywidget": {"live.widgets"},
    "IPython": {"live.widgets"},
    "traitlets": {"live.widgets"},
    "tqdm": {"parallel"},
    "pyuff": {"files.uff"},
    "ross": {"files.ross_bearing"},
}

# Imported only when it is asked for something that needs the extra: no part of a circle.
DOORS = {"thesis.models": {"thesis.full_models"}}

MODULES = modules()


def floor_of(module):
    return len(ROOMS) + LAST.index(module) if module in LAST else ROOMS.index(room_of(module))


@cache
def face_of(room):
    """Name and module of each name in the stub of a room, or of the package ("")."""
    stub = ast.parse((PACKAGE / room / "__init__.pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module for node in imports for alias in node.names}


def stands_in(module, line):
    return f"{module}, line {line.lineno}"


def test_every_room_is_in_the_order_and_has_a_face():
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders == set(ROOMS) - {""}
    assert {room_of(module) for module in MODULES} == set(ROOMS)
    assert all((PACKAGE / room / name).exists() for room in ROOMS for name in ("__init__.py", "__init__.pyi"))


def test_imports_go_down_the_order_of_rooms():
    faults = []
    for module in MODULES:
        if module in FACES:
            continue
        for place, _, node in own_imports(module):
            top = place.partition(".")[0]
            there = ROOMS.index(top) if top in ROOMS[1:] else floor_of(top) if top in MODULES else len(ROOMS) + 9
            if there > floor_of(module) or (module in LAST and there >= floor_of(module)):
                faults.append(f"{stands_in(module, node)}: rbfound.{place}")
    assert faults == []


def test_another_room_is_entered_through_its_face_and_the_own_room_by_module():
    faults = []
    for module in MODULES:
        if module in FACES:
            continue
        for place, names, node in own_imports(module):
            room, _, inner = place.partition(".")
            if room not in ROOMS[1:]:
                right = place in modules_in("") or place in LAST
            elif room == room_of(module):
                right = place in MODULES or all(f"{room}.{name}" in MODULES for name in names)
            else:
                right = not inner and names and set(names) <= set(face_of(room))
            if not right:
                faults.append(f"{stands_in(module, node)}: {', '.join(names)} from rbfound.{place}")
    assert faults == []


def test_within_a_room_no_import_leads_round_in_a_circle():
    for room in ROOMS:
        below = {}
        for module in modules_in(room):
            found = set()
            for place, names, _ in own_imports(module):
                found |= {place} if place in MODULES else {f"{place}.{name}" for name in names}
            below[module] = found & set(modules_in(room)) - DOORS.get(module, set())
        try:
            TopologicalSorter(below).prepare()
        except CycleError as error:
            pytest.fail(f"{room or 'the core'}: {' -> '.join(error.args[1])}")


def test_a_room_has_few_modules_and_a_module_few_lines():
    for room in ROOMS:
        assert len(modules_in(room)) <= MOST_MODULES, room
    lines = {m: (PACKAGE / f"{m.replace('.', '/')}.py").read_text(encoding="utf-8").count("\n") for m in MODULES}
    assert {module: n for module, n in lines.items() if n > MOST_LINES} == {}


def test_only_the_modules_of_an_extra_import_it():
    faults = []
    for module in MODULES:
        own = {module, room_of(module)}
        core = {"numpy", "scipy", "rbfound"} | ({"threadpoolctl"} if module == "parallel" else set())
        allowed = core | {package for package, users in EXTRAS.items() if own & users}
        for name, _, node in imports_of(module):
            package = name.split(".")[0]
            if package not in allowed and package not in sys.stdlib_module_names:
                faults.append(f"{stands_in(module, node)}: {name}")
    assert faults == []


def test_a_face_is_a_sentence_and_the_names_of_its_stub():
    for room in ROOMS:
        tree = ast.parse((PACKAGE / room / "__init__.py").read_text(encoding="utf-8"))
        assert ast.get_docstring(tree)
        code = [ast.unparse(node) for node in tree.body[1:] if not ast.unparse(node).startswith("__version__")]
        assert code == [
            "from rbfound._faces import face",
            "__getattr__, __dir__, __all__ = face(__name__, __file__)",
        ], room
        names = import_module(f"rbfound.{room}".rstrip(".")).__all__
        assert names == sorted(face_of(room))


def test_a_face_hands_on_what_its_modules_define_and_nothing_private():
    for room in ROOMS:
        for name, home in face_of(room).items():
            assert not name.startswith("_")
            if home == f"rbfound.{room}".rstrip("."):  # a module or a room as a whole
                assert name in ROOMS or f"{room}.{name}" in MODULES
            elif room == "" and home.partition(".")[2] in ROOMS:
                assert name in face_of(home.partition(".")[2])
            else:
                place = home.removeprefix("rbfound.")
                assert room_of(place) == room
                defined = {getattr(node, "name", None) for node in tree_of(place).body}
                for node in tree_of(place).body:
                    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
                    defined |= {n.id for t in targets if t for n in ast.walk(t) if isinstance(n, ast.Name)}
                assert name in defined, f"{name} of {home}"


def test_importing_rbfound_loads_neither_numpy_nor_a_module_of_its_own():
    code = "import json, sys, rbfound; print(json.dumps(sorted(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = json.loads(run.stdout)
    assert [name for name in loaded if name.startswith(("rbfound.", "numpy", "scipy"))] == ["rbfound._faces"]


def test_the_names_of_rbfound_are_those_of_the_modules_that_the_stub_says():
    for name, home in face_of("").items():
        thing = getattr(rbfound, name)
        assert thing is (sys.modules[f"rbfound.{name}"] if home == "rbfound" else getattr(sys.modules[home], name))
    assert set(rbfound.__all__) <= set(dir(rbfound))
    assert len(rbfound.__all__) <= MOST_NAMES


def test_a_name_that_is_not_there_is_an_attribute_error_and_an_import_error():
    with pytest.raises(AttributeError, match=r"module 'rbfound' has no attribute 'campbel'"):
        _ = rbfound.campbel
    with pytest.raises(AttributeError, match=r"module 'rbfound.theory' has no attribute 'guyann'"):
        _ = rbfound.theory.guyann
    with pytest.raises(ImportError, match="campbel"):
        exec("from rbfound import campbel", {})


def test_importing_all_names_of_rbfound_loads_no_extra():
    # in a fresh interpreter: this one may have loaded anything
    code = "import json, sys; from rbfound import *; print(json.dumps(sorted({m.split('.')[0] for m in sys.modules})))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(json.loads(run.stdout))
    assert run.stderr == ""
    assert "numpy" in loaded
    assert not loaded & {*EXTRAS, "jupyterlab"}


def test_no_module_bears_the_name_of_a_public_function():
    # `rbfound.room.name` would then be the one or the other, depending on who was imported last
    for room in ROOMS:
        whole = {name for name, home in face_of(room).items() if home == f"rbfound.{room}".rstrip(".")}
        assert not (set(face_of(room)) - whole) & {module.rpartition(".")[2] for module in modules_in(room)}, room


def test_no_module_defines_a_function_of_its_own_name():
    for module in MODULES:
        names = {node.name for node in tree_of(module).body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
        assert module.rpartition(".")[2] not in names


def test_only_units_knows_that_a_turn_is_2_pi_and_a_minute_60_seconds():
    # `2 * np.pi` elsewhere would be a second place where hertz and rad/s meet
    for module in set(MODULES) - {"units"}:
        for node in ast.walk(tree_of(module)):
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div):
                assert ast.unparse(node) not in ("2 * np.pi", "np.pi * 2", "2.0 * np.pi"), stands_in(module, node)


def test_results_are_frozen():
    # every class that a face hands on, where its extra is here
    for room in ROOMS:
        package = import_module(f"rbfound.{room}".rstrip("."))
        for name in face_of(room):
            try:
                thing = getattr(package, name)
            except ImportError:
                continue
            if hasattr(thing, "__dataclass_params__"):
                assert thing.__dataclass_params__.frozen, f"{room}.{name}"
