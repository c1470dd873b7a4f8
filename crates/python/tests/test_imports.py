"""The modules of the package import each other without circles."""

import ast
from pathlib import Path

import gfmd

FOLDER = Path(gfmd.__file__).parent


def imported(module):
    """Modules of the package that a module imports, also inside functions and for type checking alone."""
    names = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            names |= {node.module} if node.module else {alias.name for alias in node.names}
    return {name for name in names if (FOLDER / f"{name}.py").exists()}


def floors(above):
    """Modules in floors that import lower floors alone; the last floor has all modules of circles."""
    found, left = [], dict(above)
    while left:
        floor = {name for name, needs in left.items() if not needs & set(left)}
        found.append(floor or set(left))
        left = {name: needs for name, needs in left.items() if floor and name not in floor}
    return found


def test_imports_form_no_circle():
    # The stub `_columns.pyi` is not seen here: it is made from Rust, and names `Residual` of `_load`, which derives
    # from the class that the stub types.
    above = {module.stem: imported(module) for module in FOLDER.glob("*.py")}
    assert len(above) > 25 and "_units" in above["_record"]
    found = floors(above)
    place = {name: number for number, floor in enumerate(found) for name in floor}
    circle = {name for name, needs in above.items() if any(place[need] >= place[name] for need in needs)}
    assert not circle, circle
    order = ["_errors", "_units", "_record", "_columns", "_surface", "_contact", "_files"]
    assert [place[name] for name in order] == sorted(place[name] for name in order)


def test_a_circle_would_be_found():
    circle = {"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}
    assert floors(circle) == [{"d"}, {"a", "b", "c"}]
