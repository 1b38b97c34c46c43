"""The architecture as the imports show it: which package knows which, and the form of every module."""

import ast
import functools
import importlib
import itertools
from pathlib import Path

import pytest

import lbskel

PACKAGE = Path(lbskel.__file__).parent
MODULES = sorted(PACKAGE.rglob("*.py"))
TESTS = Path(__file__).parent

MAX_LINES = 300
MAX_KERNEL_LINES = 400  # a quarter of which are C types, and eight lines import what stands in for them
MAX_ENTRIES = 15
MAX_ARROWS = 100

BASE = {"errors", "display", "_kernels"}
KNOWS = {
    "errors": set(),
    "display": {"errors"},
    "_kernels": set(),
    "geometry": BASE,
    "solvers": BASE,
    "operators": BASE | {"geometry", "solvers"},
    "skeleton": BASE | {"geometry", "solvers"},
    "preprocess": BASE | {"geometry"},
    "contraction": BASE | {"geometry", "operators", "solvers"},
    "refinement": BASE | {"contraction", "geometry", "skeleton", "solvers"},
    "evaluation": BASE | {"contraction", "geometry", "operators", "refinement", "skeleton", "solvers"},
    "io": BASE | {"geometry", "skeleton"},
    "visualization": BASE | {"geometry", "io", "skeleton"},
    "shapes": BASE | {"geometry", "io", "preprocess", "skeleton"},  # preprocess: its isotropic remesher
    # preprocess: which way is out, and which vertices are one
    "applications": BASE | {"geometry", "operators", "preprocess", "skeleton", "solvers"},
}
ALGORITHMS = set(KNOWS)
KNOWS["pipeline"] = ALGORITHMS
KNOWS["cli"] = ALGORITHMS | {"pipeline", "__init__"}
TOP = {"__init__", "__main__"}  # may import everything

# heavy or optional packages: imported inside the functions that use them
LAZY = {
    "dask",
    "distributed",
    "laspy",
    "matplotlib",
    "meshio",
    "networkx",
    "pandas",
    "plotly",
    "pymeshlab",
    "pyvista",
    "trimesh",
    "vtk",
    "vtkmodules",
}


def name_of(path):
    return path.relative_to(PACKAGE).as_posix()


def entry_of(path):
    """The entry right under lbskel that a file belongs to."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@functools.cache
def tree_of(path):
    """The syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(tree):
    """The dotted name of everything that a tree imports, at its top or inside functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def packages_imported(path):
    """The top-level packages that a file imports."""
    return {name.split(".")[0] for name in imports(tree_of(path))}


def entries_known(tree, own):
    """The entries of lbskel that a tree imports; ``__init__`` for the package's own names."""
    known = set()
    for name in imports(tree):
        first, *rest = name.split(".")
        if first == "lbskel":
            is_entry = rest and ((PACKAGE / rest[0]).is_dir() or (PACKAGE / f"{rest[0]}.py").exists())
            known.add(rest[0] if is_entry else "__init__")
    return known - {own}


def forbidden(tree, own):
    """The entries that a tree of an entry imports against the rule."""
    return set() if own in TOP else entries_known(tree, own) - KNOWS[own]


every_module = pytest.mark.parametrize("path", MODULES, ids=name_of)


def test_the_rule_lists_every_entry_that_exists_and_no_other():
    entries = {
        path.stem
        for path in PACKAGE.iterdir()
        if path.suffix == ".py" or (path.is_dir() and (path / "__init__.py").exists())
    }
    assert entries == set(KNOWS) | TOP
    packages = [path for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"]
    assert len(packages) <= MAX_ENTRIES
    for knows in KNOWS.values():
        assert knows <= entries


@pytest.mark.parametrize(
    ("entry", "line"),
    [
        ("solvers", "from lbskel.geometry.mesh import Mesh"),
        ("geometry", "import lbskel.skeleton.skeleton"),
        ("operators", "def f():\n    from lbskel.preprocess import check"),
        ("refinement", "from lbskel.pipeline.stages import skeletonize"),
        ("contraction", "from lbskel import Skeleton"),
    ],
)
def test_a_forbidden_import_is_found(entry, line):
    assert forbidden(ast.parse(line), entry)


@every_module
def test_every_module_knows_only_what_the_rule_allows(path):
    assert forbidden(tree_of(path), entry_of(path)) == set()


def test_there_are_few_arrows_between_entries_and_no_circle():
    arrows = {(entry_of(path), other) for path in MODULES for other in entries_known(tree_of(path), entry_of(path))}
    assert len(arrows) <= MAX_ARROWS
    reached = {(a, b) for a, b in arrows if a not in TOP and b not in TOP}
    while further := {(a, d) for (a, b), (c, d) in itertools.product(reached, reached) if b == c} - reached:
        reached |= further
    assert not [entry for entry, other in reached if entry == other]


@every_module
def test_pymeshlab_is_known_to_preprocess_alone(path):
    assert entry_of(path) == "preprocess" or "pymeshlab" not in packages_imported(path)


@every_module
def test_optional_packages_are_imported_where_they_are_used(path):
    tree = tree_of(path)
    inside = {id(node) for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for node in ast.walk(f)}
    at_the_top = [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom) and id(n) not in inside]
    names = {name.split(".")[0] for node in at_the_top for name in imports(ast.Module([node], []))}
    assert not names & LAZY


@every_module
def test_only_the_command_line_prints(path):
    if entry_of(path) == "cli" or path.name == "__main__.py":
        return
    calls = [node.func for node in ast.walk(tree_of(path)) if isinstance(node, ast.Call)]
    assert not [call for call in calls if isinstance(call, ast.Name) and call.id == "print"]


@every_module
def test_every_module_opens_with_what_it_is(path):
    first = (ast.get_docstring(tree_of(path)) or "").split("\n")[0]
    assert len(first.split()) > 3


def module_of(path):
    """The imported module of a file."""
    dotted = ".".join(("lbskel", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
    return importlib.import_module(dotted)


@every_module
def test_every_module_says_what_is_public_and_documents_it(path):
    if path.name == "__main__.py":
        return
    module = module_of(path)
    assert len(set(module.__all__)) == len(module.__all__)
    for name in module.__all__:
        assert hasattr(module, name), f"{module.__name__}.{name}"
    defined = [name for name in module.__all__ if getattr(getattr(module, name), "__module__", "") == module.__name__]
    assert [name for name in defined if not (getattr(module, name).__doc__ or "").strip()] == []


@pytest.mark.parametrize("path", [path for path in MODULES if path.name == "__init__.py"], ids=name_of)
def test_no_module_has_the_name_of_what_its_package_exports(path):
    siblings = {each.stem for each in path.parent.glob("*.py")} | {
        each.name for each in path.parent.iterdir() if each.is_dir()
    }
    assert not siblings & {name for name in module_of(path).__all__ if callable(getattr(module_of(path), name))}


@every_module
def test_no_module_is_long(path):
    limit = MAX_KERNEL_LINES if path.parent.name == "_kernels" else MAX_LINES
    assert len(path.read_text(encoding="utf-8").splitlines()) <= limit


@every_module
def test_every_module_has_a_test_of_its_name(path):
    if path.name in ("__init__.py", "__main__.py"):
        return
    relative = path.relative_to(PACKAGE)
    assert (TESTS / relative.parent / f"test_{relative.name}").exists(), f"tests/{relative.parent}/test_{relative.name}"


def test_only_the_modules_that_name_the_license_call_what_asks_for_it():
    """cvxopt and pymeshlab are GPL-3.0-or-later."""
    callers = {name_of(path) for path in MODULES if packages_imported(path) & {"cvxopt", "pymeshlab"}}
    named = {name_of(path) for path in MODULES if "SPDX-License-Identifier: GPL-3.0-or-later" in path.read_text()}
    assert callers == named == {"solvers/cholmod.py", "preprocess/pymeshlab_adapter.py"}
