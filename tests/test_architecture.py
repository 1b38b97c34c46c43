"""The architecture as the imports show it: who may know whom, and the form of every module."""

import ast
import functools
import importlib
from pathlib import Path

import pytest

import lbskel

PACKAGE = Path(lbskel.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
LONGEST = 300
LONGEST_KERNEL = 400  # a quarter of which are types

LAYERS = {
    0: ("errors", "graphs", "kernels", "ordering"),
    1: ("boxes", "conversion", "mesh", "skeleton", "surface", "triangulation"),
    2: ("operators", "solvers"),
    3: (
        "anchors",
        "applications",
        "axes",
        "bones",
        "clock",
        "coarsening",
        "contraction",
        "degeneracy",
        "energies",
        "extremities",
        "handles",
        "health",
        "inside",
        "joining",
        "junctions",
        "limbs",
        "mapping",
        "pointclouds",
        "pruning",
        "quality",
        "refinement",
        "regrowth",
        "resampling",
        "sampling",
        "scoring",
        "sections",
        "settings",
        "steps",
        "surgery",
        "tips",
        "weights",
    ),
    4: ("files", "preprocess", "shapes", "views"),
    5: ("batch", "comparison", "judging", "pipeline", "stages"),
    6: ("__init__", "__main__", "cli", "commands"),
}
LAYER_OF = {part: layer for layer, parts in LAYERS.items() for part in parts}

# beyond the order of the layers: operators never solve, solvers never see a Mesh
STRANGERS = {("operators", "solvers"), ("solvers", "operators"), ("solvers", "mesh"), ("solvers", "conversion")}
# views and files take finished values; shapes and preprocess know no algorithm either
LAYER_4_KNOWS = {0, 1, 2, 4}

# heavy or optional: imported where they are used and nowhere else
LAZY = {
    "dask",
    "distributed",
    "matplotlib",
    "meshio",
    "networkx",
    "plotly",
    "pymeshlab",
    "trimesh",
    "vtk",
    "vtkmodules",
}

MAY_PRINT = ("cli", "commands")


def name_of(path):
    return path.relative_to(PACKAGE).as_posix()


def part_of(path):
    """The module or package right under lbskel that a file belongs to."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@functools.cache
def tree_of(path):
    """The syntax of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(tree):
    """The dotted name of everything that a tree imports, at its top or inside functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def imports_anywhere(path):
    """The packages that a file imports."""
    return {name.split(".")[0] for name in imports(tree_of(path))}


def parts_known(path):
    """The parts of lbskel that a file imports; ``__init__`` for the package's own names."""
    known = set()
    for name in imports(tree_of(path)):
        first, *rest = name.split(".")
        if first == "lbskel":
            is_part = rest and ((PACKAGE / rest[0]).is_dir() or (PACKAGE / f"{rest[0]}.py").exists())
            known.add(rest[0] if is_part else "__init__")
    return known - {part_of(path)}


every_module = pytest.mark.parametrize("path", MODULES, ids=name_of)


def test_the_modules_are_found():
    assert {part_of(path) for path in MODULES} >= {"errors", "mesh", "operators", "pipeline", "cli"}
    assert parts_known(PACKAGE / "cli.py") == {"__init__", "commands", "errors"}
    assert "pymeshlab" in imports_anywhere(PACKAGE / "preprocess" / "pymeshlab_adapter.py")


@every_module
def test_every_module_knows_only_its_own_layer_and_those_below(path):
    part = part_of(path)
    assert part in LAYER_OF, f"give {part} a layer"
    layer = LAYER_OF[part]
    allowed = LAYER_4_KNOWS if layer == 4 else set(range(layer + 1))
    for other in parts_known(path):
        assert LAYER_OF[other] in allowed, f"{name_of(path)}, of layer {layer}, must not import {other}"
        assert (part, other) not in STRANGERS, f"{name_of(path)} must not import {other}"


@every_module
def test_pymeshlab_is_known_to_preprocess_alone(path):
    assert part_of(path) == "preprocess" or "pymeshlab" not in imports_anywhere(path)


@every_module
def test_optional_packages_are_imported_where_they_are_used(path):
    tree = tree_of(path)
    inside = {id(node) for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for node in ast.walk(f)}
    at_the_top = [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom) and id(n) not in inside]
    names = {name.split(".")[0] for node in at_the_top for name in imports(ast.Module([node], []))}
    assert not names & LAZY


@every_module
def test_only_the_command_line_prints(path):
    if part_of(path) in MAY_PRINT or path.name == "__main__.py":
        return
    calls = [node.func for node in ast.walk(tree_of(path)) if isinstance(node, ast.Call)]
    assert not [call for call in calls if isinstance(call, ast.Name) and call.id == "print"]


@every_module
def test_every_module_opens_with_what_it_is(path):
    first = (ast.get_docstring(tree_of(path)) or "").split("\n")[0]
    assert len(first.split()) > 3


@every_module
def test_every_module_says_what_is_public(path):
    if path.name == "__main__.py":
        return
    dotted = ".".join(("lbskel", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
    module = importlib.import_module(dotted)
    assert len(set(module.__all__)) == len(module.__all__)
    for name in module.__all__:
        assert hasattr(module, name), f"{dotted}.{name}"
    defined_here = [name for name in module.__all__ if getattr(getattr(module, name), "__module__", "") == dotted]
    undocumented = [name for name in defined_here if not (getattr(module, name).__doc__ or "").strip()]
    if part_of(path) != "commands":
        assert undocumented == []


@every_module
def test_no_module_is_long(path):
    longest = LONGEST_KERNEL if path.parent.name == "kernels" else LONGEST
    assert len(path.read_text(encoding="utf-8").splitlines()) <= longest
