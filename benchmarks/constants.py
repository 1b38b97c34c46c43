"""Effects of the numbers in the code: every constant moved by -30 % and +40 %, and how skeletons and scores change.

The constants are the numbers with upper-case names at the top level of the modules that contract, refine, edit, compose
and score, and of those that measure local radii, find crumbs, and choose proxies and automatic preprocessing. They are
changed one at a time in the syntax trees of their modules, and lbskel is imported anew, so that names and defaults that
derive from them change too. Integers move by at least one.

Skeletons are made of a fixed set of meshes: the shapes of the catalog, fine and coarse, some of them noisy, one with
enough faces for a proxy, and the meshes of the repository. One coarse shape also goes through code that no default
runs: other presets and options, joining, simplified branches, and the diagnostics of operators.
"""

from __future__ import annotations

__all__ = ["Constant", "changed", "find_constants", "run", "shifted"]

import ast
import hashlib
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import markdown_table, save_json, save_markdown

ROOT = Path(__file__).parent.parent
PLACES = (
    "geometry/components.py",
    "geometry/shape_diameter.py",
    "contraction",
    "refinement",
    "skeleton",
    "pipeline",
    "evaluation",
    "preprocess/proxy.py",
    "preprocess/automatic.py",
    "preprocess/subdivision.py",
)
SEEDS = ("SEED",)  # names of numbers that are no quantities
SHIFTS = {"-30 %": 0.7, "+40 %": 1.4}
N_VERTICES = 1500  # of a shape as it is made, about
FACES = {"fine": 2400, "coarse": 800}  # to which it is simplified
NOISY = ("hand", "ladder")  # as made, with noise of a quarter of an edge
LARGE, LARGE_VERTICES = "octopus", 9_000  # about 18,000 faces, so that a proxy is contracted
WITH_OPTIONS = "tripod, coarse"  # the mesh for what no default needs
QUICK = ("tripod",)
TIME_LIMIT = 180  # seconds for all meshes with one changed constant; they take about 5
GROUND_TRUTH = "lbskel.evaluation.ground_truth"  # the module whose constants change distances of equal skeletons

Arrays = tuple[NDArray[np.float64], NDArray[np.int64]]


@dataclass(frozen=True)
class Constant:
    """A number of the code.

    Parameters
    ----------
    module : str
        As it is imported.
    name : str
    value : int or float
    """

    module: str
    name: str
    value: float


@dataclass(frozen=True)
class Input:
    """A mesh of the set, as arrays, which are the same for every import of lbskel.

    Parameters
    ----------
    mesh : tuple of arrays
        Vertices and faces.
    truth : tuple of arrays or None
        Nodes, edges and radii of the known axis.
    """

    mesh: Arrays
    truth: tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]] | None


def run(quick: bool, results: Path) -> None:
    """Change every constant in both directions, and write constants.json and constants.md."""
    inputs = make_inputs(quick)
    constants = find_constants(ROOT / "lbskel")[: 4 if quick else None]
    baseline = measure(inputs)
    rows: list[dict[str, Any]] = []
    for number, constant in enumerate(constants, 1):
        row = {"module": constant.module, "constant": constant.name, "value": constant.value}
        for shift, factor in SHIFTS.items():
            with changed(constant, shifted(constant.value, factor)):
                reused = None if constant.module == GROUND_TRUTH else baseline
                row[shift] = difference(baseline, measure(inputs, reused))
        rows.append(row)
        print(f"{number}/{len(constants)} {constant.module}.{constant.name}", file=sys.stderr, flush=True)
    paths = [] if quick else sorted(path for path in (ROOT / "meshes").iterdir() if path.suffix != ".md")
    save_json(results / "constants.json", {"inputs": baseline, "rows": rows}, meshes=paths)
    save_markdown(results / "constants.md", "What the constants do", tables(baseline, rows))


def find_constants(package: Path, places: Sequence[str] = PLACES) -> list[Constant]:
    """The numbers with upper-case names at the top level of modules, in the order of the modules and their lines.

    Parameters
    ----------
    package : Path
        The folder of an importable package.
    places : sequence of str
        Subpackages, of which all modules count, but not their subpackages, and single modules.
    """
    paths = [
        path
        for place in places
        for path in ([package / place] if place.endswith(".py") else sorted((package / place).glob("*.py")))
    ]
    constants = []
    for path in paths:
        module = ".".join((package.name, *path.relative_to(package).with_suffix("").parts))
        values = vars(import_module(module))
        for name in _assigned(ast.parse(path.read_text(encoding="utf-8"))):
            value = values[name]
            if isinstance(value, int | float) and not isinstance(value, bool) and name not in SEEDS:
                constants.append(Constant(module, name, value))
    return constants


def _assigned(tree: ast.Module) -> Iterator[str]:
    """Upper-case names that are assigned at the top level."""
    for node in tree.body:
        targets: list[ast.expr] = []
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        for target in targets:
            for leaf in target.elts if isinstance(target, ast.Tuple) else [target]:
                if isinstance(leaf, ast.Name) and leaf.id.strip("_").isupper():
                    yield leaf.id


def shifted(value: float, factor: float) -> float:
    """The value times a factor; an integer is rounded, and moves by one at least."""
    if not isinstance(value, int):
        return value * factor
    moved = round(value * factor)
    return moved if moved != value else value + (1 if factor > 1 else -1)


@contextmanager
def changed(constant: Constant, value: float) -> Iterator[None]:
    """Inside the block, imports of the package find the constant with another value; after it, all is as before."""
    package = constant.module.split(".")[0]
    origin = sys.modules[constant.module].__file__
    assert origin is not None
    before = {name: module for name, module in sys.modules.items() if _is_replaced(name, package)}
    finder = _Finder(constant, value, origin)
    for name in before:
        del sys.modules[name]
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        for name in [name for name in sys.modules if _is_replaced(name, package)]:
            del sys.modules[name]
        sys.modules.update(before)


def _is_replaced(name: str, package: str) -> bool:
    """Whether a module is imported anew; compiled ones cannot be, and import nothing of the package."""
    return (name == package or name.startswith(f"{package}.")) and not name.startswith(f"{package}._kernels")


class _Finder(MetaPathFinder):
    """Finds the module of the constant, and leaves all others to the usual finders."""

    def __init__(self, constant: Constant, value: float, origin: str):
        self._constant, self._value, self._origin = constant, value, origin

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The module with the changed constant."""
        if fullname != self._constant.module:
            return None
        loader = _Loader(fullname, self._origin)
        loader.name_to_change, loader.value = self._constant.name, self._value
        return spec_from_file_location(fullname, self._origin, loader=loader)


class _Loader(SourceFileLoader):
    """Compiles a module with one constant assigned once more, right after its first assignment."""

    name_to_change: str
    value: float

    def get_code(self, fullname: str) -> Any:
        """The code of the changed syntax tree; the compiled module on the disk is neither read nor written."""
        tree = ast.parse(self.get_data(self.path))
        at = next(i for i, node in enumerate(tree.body) if self.name_to_change in _assigned(ast.Module([node], [])))
        tree.body[at + 1 : at + 1] = ast.parse(f"{self.name_to_change} = {self.value!r}").body
        return compile(tree, self.path, "exec", dont_inherit=True)


def make_inputs(quick: bool) -> dict[str, Input]:
    """The meshes by name."""
    from lbskel import read_mesh
    from lbskel.preprocess import simplify
    from lbskel.shapes import SHAPES, Shape, make

    made: dict[str, Shape] = {}
    for name in QUICK if quick else SHAPES:
        shape = make(name, n_vertices=N_VERTICES)
        for size, n_faces in FACES.items():
            made[f"{name}, {size}"] = Shape(simplify(shape.mesh, target_faces=n_faces).mesh, shape.truth, name)
    if not quick:
        made |= {f"{name}, noisy": make(name, n_vertices=N_VERTICES, noise=0.25) for name in NOISY}
        made |= {f"{LARGE}, large": make(LARGE, n_vertices=LARGE_VERTICES)}
    inputs = {
        name: Input(
            (np.array(shape.mesh.vertices), np.array(shape.mesh.faces)),
            (np.array(shape.truth.nodes), np.array(shape.truth.edges), np.array(shape.truth.radii)),
        )
        for name, shape in made.items()
    }
    for path in sorted((ROOT / "meshes").iterdir()) if not quick else ():
        if path.suffix != ".md":
            mesh = read_mesh(path)
            inputs[path.name] = Input((np.array(mesh.vertices), np.array(mesh.faces)), None)
    return inputs


def measure(
    inputs: Mapping[str, Input], baseline: Mapping[str, Mapping[str, Any]] | None = None
) -> dict[str, dict[str, Any]]:
    """What the lbskel that is imported now makes of each mesh; ``error`` where it fails.

    Distances to the axis are taken from ``baseline`` where it is given and has the same skeleton.
    """
    found: dict[str, dict[str, Any]] = {}
    previous = signal.signal(signal.SIGALRM, _too_late)
    signal.alarm(TIME_LIMIT)
    try:
        for name, given in inputs.items():
            try:
                found[name] = _measure_one(given, baseline[name] if baseline else {})
                if name == WITH_OPTIONS:
                    found[name]["options"] = _measure_options(given)
            except Exception as error:  # whatever a wrong constant leads to
                found[name] = {"error": f"{type(error).__name__}: {error}"[:200]}
    except _TooLateError:
        found |= {name: {"error": f"over {TIME_LIMIT} s"} for name in inputs if name not in found}
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)
    return found


class _TooLateError(BaseException):
    """Not an Exception, so that it ends everything."""


def _too_late(*_: object) -> None:
    raise _TooLateError


def _measure_one(given: Input, baseline: Mapping[str, Any]) -> dict[str, Any]:
    """Distances to the axis, counts, the score, and a digest of every number of the skeleton."""
    import lbskel

    skeleton = lbskel.skeletonize(given.mesh)
    scored = skeleton.report["score"]
    row = {
        "tips": len(skeleton.tips),
        "junctions": len(skeleton.junctions),
        "cycles": skeleton.cycle_rank,
        "verdict": scored["verdict"],
        "measures": scored["measures"],
        "digest": _digest(skeleton),
    }
    if given.truth is None:
        return row
    if row["digest"] == baseline.get("digest"):
        return {**row, "accuracy": baseline["accuracy"], "coverage": baseline["coverage"]}
    distances = lbskel.ground_truth_distances(skeleton, lbskel.Skeleton(*given.truth))
    return {**row, "accuracy": distances.accuracy, "coverage": distances.coverage}


def _digest(skeleton: Any) -> str:
    """A hash of every number of a skeleton."""
    arrays = (skeleton.nodes, skeleton.edges, skeleton.radii, skeleton.mean_radii, skeleton.node_of_vertex)
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def _measure_options(given: Input) -> dict[str, Any]:
    """Digests of what other presets, options, joining and simplification give, and the diagnostics of an operator."""
    import lbskel

    mesh = lbskel.Mesh(*given.mesh)
    shift = np.ptp(mesh.vertices[:, 0]) + 0.3 * mesh.diagonal
    two = lbskel.Mesh(
        np.concatenate([mesh.vertices, mesh.vertices + [shift, 0, 0]]),
        np.concatenate([mesh.faces, mesh.faces + len(mesh.vertices)]),
    )
    presets = {name: lbskel.skeletonize(mesh, preset=name) for name in lbskel.PRESETS}
    made = presets | {
        "surface tips, anchor": lbskel.skeletonize(mesh, tip_position="surface", anchors=[0]),
        "short branches": lbskel.skeletonize(mesh, min_branch_ratio=0.5),
        "long branches": lbskel.skeletonize(mesh, min_branch_ratio=3.0),
        "simplified": lbskel.simplify_branches(lbskel.skeletonize(mesh), tolerance=0.5),
        "joined": lbskel.join_components(lbskel.skeletonize(two)),
    }
    diagnostics = lbskel.laplacian_diagnostics(lbskel.laplacian(mesh), mesh)
    return {name: _digest(skeleton) for name, skeleton in made.items()} | {
        "diagnostics": repr(diagnostics),
        "properties": repr(diagnostics.passed),
    }


def difference(before: Mapping[str, Mapping[str, Any]], after: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """How results change: the mean accuracy, and names of the meshes on which something else changes."""
    done = [name for name in before if "error" not in before[name] and "error" not in after[name]]
    known = [name for name in done if "accuracy" in before[name]]
    accuracy = [after[name]["accuracy"] - before[name]["accuracy"] for name in known]
    changes = {
        what: [name for name in done if before[name][what] != after[name][what]]
        for what in ("digest", "tips", "junctions", "cycles", "measures", "verdict")
    }
    return {
        "accuracy": float(np.mean(accuracy)) if accuracy else 0.0,
        **changes,
        "distances": [
            name for name in known if any(before[name][key] != after[name][key] for key in ("accuracy", "coverage"))
        ],
        "verdicts": {name: f"{before[name]['verdict']} -> {after[name]['verdict']}" for name in changes["verdict"]},
        "options": [
            what
            for name in done
            for what, value in before[name].get("options", {}).items()
            if after[name]["options"][what] != value
        ],
        "errors": {name: after[name]["error"] for name in before if name not in done},
    }


def has_effect(change: Mapping[str, Any]) -> bool:
    """Whether anything differs, in the last digit even."""
    return any(change[what] for what in ("digest", "measures", "distances", "options", "errors"))


def text_of(change: Mapping[str, Any]) -> str:
    """A change as a table cell."""
    if not has_effect(change):
        return "no effect"
    parts = [f"skeletons of {len(change['digest'])}"] if change["digest"] else []
    if change["accuracy"]:
        parts.append(f"accuracy {change['accuracy']:+.2g}")
    parts += [f"{what} of {len(change[what])}" for what in ("tips", "junctions", "cycles") if change[what]]
    if change["measures"] and not change["digest"]:
        parts.append(f"scores of {len(change['measures'])}")
    if change["verdicts"]:
        parts.append("verdicts: " + "; ".join(f"{name}: {text}" for name, text in change["verdicts"].items()))
    if change["options"] and not change["digest"]:
        parts.append("only " + ", ".join(change["options"]))
    if change["errors"]:
        parts.append(f"errors on {len(change['errors'])}")
    return ", ".join(parts) or "distances, in the last digits"


def tables(baseline: Mapping[str, Mapping[str, Any]], rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """One line for each constant, and those that do nothing."""
    accuracies = [row["accuracy"] for row in baseline.values() if "accuracy" in row]
    intro = (
        f"Each cell says on how many of {len(baseline)} meshes something changes, and by how much the mean accuracy "
        "does, which is the distance to the known axis in local radii: "
        f"{np.mean(accuracies):.4f} over {len(accuracies)} shapes. "
        "No effect: not one digit changes on any of these meshes, all of which are sound: guards against damaged, open "
        "or very large ones have nothing to do here. "
        f"Only: nothing changes by default, but what follows does on one mesh ({WITH_OPTIONS}).\n\n"
    )
    lines = [
        {
            "module": row["module"].split(".", 1)[-1],
            "constant": row["constant"],
            "value": f"{row['value']:.12g}",
            **{shift: text_of(row[shift]) for shift in SHIFTS},
        }
        for row in rows
    ]
    idle = [line for line, row in zip(lines, rows, strict=True) if not any(has_effect(row[shift]) for shift in SHIFTS)]
    return {
        f"{len(rows)} constants": intro + markdown_table(lines),
        f"{len(idle)} without effect on these meshes": markdown_table(idle, ["module", "constant", "value"])
        if idle
        else "None.\n",
    }
