"""Parameters of a contraction, and named choices of them: presets, and strategies against degenerate triangles."""

from __future__ import annotations

__all__ = ["DEGENERACY_STRATEGIES", "PRESETS", "ContractionSettings"]

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lbskel.contraction.degenerate_rows import ROW_TREATMENTS
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.weights import ATTRACTIONS, INITIAL_WEIGHT_RULES, WEIGHTS
from lbskel.errors import UnknownChoice, choose
from lbskel.operators import Operator, operator_named
from lbskel.solvers import ALL_SOLVERS

STOP_RULES = ("areas", "rings")


# Upper bound on settings, which have no unit. It follows from the largest double, 1.8e308: squares are finite
LARGEST = 1e100


def _is_bounded(value: Any) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and bool(abs(float(value)) <= LARGEST)


@dataclass(frozen=True)
class ContractionSettings:
    """Parameters of a contraction; all are dimensionless.

    Parameters
    ----------
    operator : str, callable or None
        A name in OPERATORS or STAR_OPERATORS, or a function from a Mesh to a Laplacian. None chooses
        ``intrinsic_delaunay`` for a closed, orientable, edge-manifold mesh and ``robust`` for any other.
        :func:`lbskel.laplacian` has the textbook operator ``cotangent`` as its default instead: contraction makes
        triangles ever thinner, which the two operators here withstand, while plain cotangents of thin triangles make
        the least-squares energy diverge.
    energy : str
        A name in ENERGIES: what each step minimizes.
    initial_weight_rule : str
        A name in INITIAL_WEIGHT_RULES: how the contraction weight of the first step follows from ``initial_weight``.
        For ``local_radius`` it is the distance that the first step smooths over, as a fraction of the mean radius, or
        of four local radii where these are less; for ``diffusion_length`` that distance as a fraction of the mesh's
        diameter bound. The other rules are published formulas for W_L.
        WEIGHTS has the values published together.
    initial_weight : float
        The constant in that rule.
    contraction_growth : float
        Factor on the contraction weight after each step: on tau of ``curvature_flow``, on W_L of ``least_squares``.
    attraction : str
        A name in ATTRACTIONS: the areas, or squared edge lengths, whose ratio, start over now, is the attraction weight
        W_H^2 of a vertex.
    max_contraction_weight, max_attraction : float, optional
        Upper bounds on W_L and W_H; none by default.
    degenerate_rows : str
        A name in ROW_TREATMENTS: how ``least_squares`` changes the rows of L at the vertices of degenerate triangles.
        ``none`` keeps them; ``identity`` replaces them by identity rows that ask the vertex to stay; ``identity_zero``
        by identity rows with right-hand side zero, which pull the vertex to the origin; ``row_sums`` scales down every
        row whose weights sum to more than 10,000, at degenerate triangles or not.
    degenerate_angle : float
        A triangle with a smaller angle is degenerate, for ``degenerate_rows``; in radians.
    rollback : bool
        Whether a step after which the area or the bounding box has grown is undone and ends the contraction; steps are
        then solved for the displacement, with iterative refinement. Without it steps are as published: solved once for
        the positions, with no check of the residual, and kept whatever they did; ``Step.fault`` has what went wrong.
    collapse_length : float
        Between steps, edges are collapsed that are shorter than this fraction of the square root of the initial ring
        area of both their ends, or than a tenth of the local radius there, so that later steps cost less; 0 keeps all
        vertices. Applies to meshes whose vertices all belong to faces, with ``curvature_flow``, ``ring_areas`` and
        roll-back.
    volume_ratio, area_ratio : float
        The contraction is complete when the volume of a closed, consistently oriented mesh, or the area of another,
        has fallen to this fraction of its initial value, and the area of the former to a tenth.
    max_steps : int
        Upper bound on the number of steps.
    stop_rule : str
        A name in STOP_RULES: ``areas`` as the two ratios say; ``rings`` as Cao et al. 2010 contract points, before the
        step in which the shortest edges of all rings together lose less than a hundredth of their first length.
    solver : str
        A name in SOLVERS, or, for study, in CLASSICAL_ITERATIONS.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> settings = lbskel.ContractionSettings(operator="robust", max_steps=3)
    >>> lbskel.contract(torus(1.0, 0.2), settings).status.value
    'the number of steps allowed was reached'
    """

    operator: str | Operator | None = None
    energy: str = "curvature_flow"
    initial_weight_rule: str = "local_radius"
    initial_weight: float = 0.5
    contraction_growth: float = 2.0
    attraction: str = "ring_areas"
    max_contraction_weight: float | None = None
    max_attraction: float | None = None
    degenerate_rows: str = "none"
    degenerate_angle: float = 1e-3
    rollback: bool = True
    collapse_length: float = 0.45
    volume_ratio: float = 1e-4
    area_ratio: float = 0.1
    max_steps: int = 30
    stop_rule: str = "areas"
    solver: str = "cholmod"

    def __post_init__(self) -> None:
        choose(ENERGIES, self.energy, "energy")
        choose(ALL_SOLVERS, self.solver, "solver")
        choose(INITIAL_WEIGHT_RULES, self.initial_weight_rule, "rule for the initial weight")
        choose(ATTRACTIONS, self.attraction, "attraction")
        choose(dict.fromkeys(STOP_RULES), self.stop_rule, "stop rule")
        choose(ROW_TREATMENTS, self.degenerate_rows, "treatment of degenerate rows")
        if self.operator is not None:
            operator_named(self.operator)
        if self.degenerate_rows != "none" and self.energy != "least_squares":
            raise UnknownChoice(
                f"degenerate_rows={self.degenerate_rows!r} belongs to the energy 'least_squares'; "
                "'curvature_flow' has no rows to replace"
            )
        positive = (
            "initial_weight",
            "contraction_growth",
            "max_contraction_weight",
            "max_attraction",
            "volume_ratio",
            "area_ratio",
            "max_steps",
        )
        for name in positive:
            value = getattr(self, name)
            if value is not None and not (_is_bounded(value) and value > 0):
                hint = "; None is no bound" if name in ("max_contraction_weight", "max_attraction") else ""
                raise UnknownChoice(f"{name} must be positive and at most {LARGEST:g}, not {value!r}{hint}")
        if not isinstance(self.max_steps, int | np.integer):
            raise UnknownChoice(f"max_steps must be a whole number, not {self.max_steps!r}")
        for name in ("collapse_length", "degenerate_angle"):
            value = getattr(self, name)
            if not (_is_bounded(value) and value >= 0):
                raise UnknownChoice(f"{name} must be zero or positive, and at most {LARGEST:g}, not {value!r}")


DEGENERACY_STRATEGIES: dict[str, Mapping[str, Any]] = {
    "identity row, right-hand side zero": {"operator": "cotangent", "degenerate_rows": "identity_zero"},
    "identity row, held": {"operator": "cotangent", "degenerate_rows": "identity"},
    "clamped row sums": {"operator": "cotangent", "degenerate_rows": "row_sums"},
    "mean value": {"operator": "mean_value"},
    "none": {"operator": "cotangent"},
    "clamped cotangents": {"operator": "clamped_cotangent"},
    "mean value, symmetric": {"operator": "mean_value_symmetric"},
    "mollified": {"operator": "mollified"},
    "intrinsic Delaunay": {"operator": "intrinsic_delaunay"},
    "robust": {"operator": "robust"},
}
"""Changes to the settings that have been tried against degenerate triangles.

The first four need the least-squares energy: three of them change rows of L, and ``mean_value`` is not symmetric.
"""

PRESETS: dict[str, ContractionSettings] = {
    "curvature_flow": ContractionSettings(),
    "least_squares": ContractionSettings(
        operator="clamped_cotangent",
        energy="least_squares",
        degenerate_rows="identity",
        volume_ratio=1e-6,
        **WEIGHTS["diffusion_length"],
    ),
    "au2008": ContractionSettings(
        operator="cotangent", energy="least_squares", volume_ratio=1e-6, max_steps=40, **WEIGHTS["au2008"]
    ),
    "au2008_demo": ContractionSettings(
        operator="cotangent",
        energy="least_squares",
        degenerate_rows="row_sums",
        volume_ratio=1e-5,
        **WEIGHTS["au2008_demo"],
    ),
    "cao2010": ContractionSettings(
        operator="local_delaunay",
        energy="least_squares",
        degenerate_rows="row_sums",
        max_steps=20,
        stop_rule="rings",
        **WEIGHTS["cao2010"],
    ),
    "cao2010_meshes": ContractionSettings(
        operator="cotangent", energy="least_squares", degenerate_rows="row_sums", **WEIGHTS["cao2010_meshes"]
    ),
}
"""Named settings of a contraction.

- ``curvature_flow``: the default; implicit curvature flow with the intrinsic Delaunay or the robust operator.
- ``least_squares``: the energy of Au et al. 2008 with clamped cotangents, identity rows at degenerate triangles and
  lbskel's initial weight.
- ``au2008``: the values printed by Au et al. 2008: plain cotangents and W_L = 1e-3 sqrt(mean face area) at first; the
  roll-back is lbskel's.
- ``au2008_demo``: the values in the demo program of Au et al., with its bounds on weights and row sums.
- ``cao2010``: Cao et al. 2010, with the values in their program: contracts points by the cotangents of their stars, and
  of a mesh the vertices. :mod:`lbskel.contraction.point_graph` says which faults of the program are corrected.
- ``cao2010_meshes``: the weights of that program for meshes, with the row sums bounded as there.
"""
