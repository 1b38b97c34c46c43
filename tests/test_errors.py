"""Errors: their families, their messages, and that every name that is unknown is answered with those that exist."""

import pickle

import pytest

from lbskel import (
    OPERATORS,
    PRESETS,
    ContractionSettings,
    FormatError,
    LbskelError,
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
from lbskel.errors import choose
from lbskel.io import FORMATS, MESH_READERS, read_mesh, read_skeleton
from lbskel.operators import MASSES
from lbskel.shapes import SHAPES, make
from lbskel.solvers import ALL_SOLVERS

FAMILY = {
    MeshError: ValueError,
    OperatorError: TypeError,
    UnknownChoice: ValueError,
    FormatError: ValueError,
    SolveError: ArithmeticError,
    MissingDependency: ImportError,
}


def test_every_error_has_its_family():
    defined = {kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, Exception)}
    assert defined == {LbskelError, *FAMILY}
    for kind, family in FAMILY.items():
        assert kind.__bases__ == (LbskelError, family)


def test_solve_error_carries_its_residual():
    assert SolveError("no").residual == float("inf")
    assert SolveError("no", 0.5).residual == 0.5


def test_missing_dependency_carries_the_pip_line():
    error = MissingDependency("networkx", "graph", "to_networkx()")
    assert str(error) == "to_networkx() needs networkx, which is not installed: pip install 'lbskel[graph]'"


@pytest.mark.parametrize(
    "error",
    [MeshError("a"), UnknownChoice("a"), FormatError("a"), SolveError("a", 0.5), MissingDependency("p", "e", "it")],
    ids=lambda error: type(error).__name__,
)
def test_errors_survive_the_way_between_processes(error):
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back), vars(back)) == (type(error), str(error), vars(error))


def test_choose():
    assert choose({"a": 1}, "a", "letter") == 1
    for name in ("b", "", None, ["a"], 3):
        with pytest.raises(UnknownChoice, match=r"unknown letter .*; choose one of: a$"):
            choose({"a": 1}, name, "letter")


ASKED = {
    "operator": (OPERATORS, lambda name, mesh: laplacian(mesh, operator=name)),
    "operator of skeletonize": (OPERATORS, lambda name, mesh: skeletonize(mesh, operator=name)),
    "mass": (MASSES, lambda name, mesh: laplacian(mesh, mass=name)),
    "solver": (ALL_SOLVERS, lambda name, mesh: factorize(laplacian(mesh).mass, name)),
    "solver of skeletonize": (ALL_SOLVERS, lambda name, mesh: skeletonize(mesh, solver=name)),
    "energy": (ENERGIES, lambda name, mesh: skeletonize(mesh, energy=name)),
    "preset": (PRESETS, lambda name, mesh: skeletonize(mesh, preset=name)),
    "treatment": (ROW_TREATMENTS, lambda name, mesh: ContractionSettings(degenerate_rows=name)),
    "shape": (SHAPES, lambda name, mesh: make(name)),
}


@pytest.mark.parametrize("what", ASKED)
def test_an_unknown_name_is_answered_with_all_that_exist(what, tetrahedron):
    table, ask = ASKED[what]
    with pytest.raises(UnknownChoice) as caught:
        ask("nosuch", tetrahedron)
    assert "'nosuch'" in str(caught.value)
    assert str(caught.value).endswith(", ".join(table))


@pytest.mark.parametrize(("read", "table"), [(read_mesh, MESH_READERS), (read_skeleton, FORMATS)])
def test_an_unknown_format_is_answered_with_all_that_exist(read, table, tmp_path):
    with pytest.raises(FormatError) as caught:
        read(tmp_path / "a.nosuch")
    assert str(caught.value).endswith(", ".join(table))
