"""Errors: their base classes, their messages, and that an unknown name is answered with the valid names."""

import pickle

import numpy as np
import pytest

from lbskel import (
    OPERATORS,
    PRESETS,
    ContractionSettings,
    FormatError,
    LbskelError,
    MemoryLimitError,
    MeshError,
    MissingDependency,
    OperatorError,
    SolveError,
    UnknownChoice,
    errors,
    factorize,
    laplacian,
    skeletonize,
)
from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES
from lbskel.errors import checked_count, choose, counted, first_few, nearest, were
from lbskel.io import FORMATS, MESH_READERS, read_mesh, read_skeleton
from lbskel.operators import MASSES
from lbskel.pipeline.options import DOMAINS
from lbskel.shapes import SHAPES, make
from lbskel.solvers import ALL_SOLVERS

BUILTIN_BASE = {
    MeshError: ValueError,
    OperatorError: TypeError,
    UnknownChoice: ValueError,
    FormatError: ValueError,
    SolveError: ArithmeticError,
    MissingDependency: ImportError,
    MemoryLimitError: MemoryError,
}


def test_every_error_has_a_builtin_base_class():
    defined = {kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, Exception)}
    assert defined == {LbskelError, *BUILTIN_BASE}
    for kind, base in BUILTIN_BASE.items():
        assert kind.__bases__ == (LbskelError, base)


def test_solve_error_has_a_residual():
    assert SolveError("no").residual == float("inf")
    assert SolveError("no", 0.5).residual == 0.5


def test_missing_dependency_gives_the_pip_command():
    error = MissingDependency("networkx", "graph", "to_networkx()")
    assert str(error) == "to_networkx() needs networkx, which is not installed: pip install 'lbskel[graph]'"


@pytest.mark.parametrize(
    "error",
    [MeshError("a"), UnknownChoice("a"), FormatError("a"), SolveError("a", 0.5), MissingDependency("p", "e", "it")],
    ids=lambda error: type(error).__name__,
)
def test_errors_can_be_pickled(error):
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back), vars(back)) == (type(error), str(error), vars(error))


def test_choose_returns_the_entry_or_lists_the_names():
    assert choose({"a": 1}, "a", "letter") == 1
    for name in ("b", "", None, ["a"], 3):
        with pytest.raises(UnknownChoice, match=r"unknown letter .*; choose one of: a$"):
            choose({"a": 1}, name, "letter")


def test_a_count_is_a_whole_number():
    assert checked_count(np.int32(3), "k", 1) == 3
    for wrong in (0, 2.0, True, None, "3"):
        with pytest.raises(UnknownChoice, match=f"k must be a whole number from 1 on, not {wrong!r}"):
            checked_count(wrong, "k", 1)
    assert checked_count(5, "k", 1, 5) == 5
    with pytest.raises(UnknownChoice, match="k must be a whole number from 1 to 5, not 6"):
        checked_count(6, "k", 1, 5)


def test_first_few_counts_the_rest():
    assert first_few([]) == ""
    assert first_few(range(5)) == "0, 1, 2, 3, 4"
    assert first_few(range(6)) == "0, 1, 2, 3, 4 and 1 more"
    assert first_few([3, 17, 40], at_most=1) == "3 and 2 more"


def test_one_thing_is_singular():
    assert [counted(n, "face") for n in (0, 1, 2304)] == ["0 faces", "1 face", "2,304 faces"]
    assert [counted(n, noun) for n in (1, 2) for noun in ("vertex", "branch")] == [
        "1 vertex",
        "1 branch",
        "2 vertices",
        "2 branches",
    ]


CHOICES = {
    "operator": (OPERATORS, lambda name, mesh: laplacian(mesh, operator=name)),
    "operator of skeletonize": (OPERATORS, lambda name, mesh: skeletonize(mesh, operator=name)),
    "mass": (MASSES, lambda name, mesh: laplacian(mesh, mass=name)),
    "solver": (ALL_SOLVERS, lambda name, mesh: factorize(laplacian(mesh).mass, name)),
    "solver of skeletonize": (ALL_SOLVERS, lambda name, mesh: skeletonize(mesh, solver=name)),
    "energy": (ENERGIES, lambda name, mesh: skeletonize(mesh, energy=name)),
    "preset": (PRESETS | DOMAINS, lambda name, mesh: skeletonize(mesh, preset=name)),
    "treatment": (ROW_TREATMENTS, lambda name, mesh: ContractionSettings(degenerate_rows=name)),
    "shape": (SHAPES, lambda name, mesh: make(name)),
}


@pytest.mark.parametrize("what", CHOICES)
def test_an_unknown_name_lists_the_valid_names(what, tetrahedron):
    table, ask = CHOICES[what]
    with pytest.raises(UnknownChoice) as caught:
        ask("nosuch", tetrahedron)
    assert "'nosuch'" in str(caught.value)
    assert str(caught.value).endswith(", ".join(table))


@pytest.mark.parametrize(("read", "table"), [(read_mesh, MESH_READERS), (read_skeleton, FORMATS)])
def test_an_unknown_format_lists_the_valid_extensions(read, table, tmp_path):
    with pytest.raises(FormatError) as caught:
        read(tmp_path / "a.nosuch")
    assert str(caught.value).endswith(", ".join(table))


def test_the_nearest_name_is_suggested():
    assert nearest("robsut", OPERATORS) == ", did you mean 'robust'?"
    assert nearest("x", OPERATORS) == nearest(None, OPERATORS) == nearest("--preprocess", ["--report"]) == ""
    with pytest.raises(
        UnknownChoice, match=r"unknown operator 'cotangnet', did you mean 'cotangent'\?; choose one of: "
    ):
        laplacian([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]], operator="cotangnet")


def test_the_verb_agrees_with_the_number():
    assert [were(n, noun) for n, noun in ((0, "cap"), (1, "cavity"), (2, "cavity"), (2304, "open component"))] == [
        "0 caps were",
        "1 cavity was",
        "2 cavities were",
        "2,304 open components were",
    ]
