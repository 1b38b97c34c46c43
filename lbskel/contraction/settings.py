"""Parameters of a contraction: what each means, what goes together, and named choices of them all."""

from __future__ import annotations

__all__ = ["PRESETS", "STRATEGIES", "ContractionSettings"]

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lbskel.contraction.degenerate_rows import DEGENERATE
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.weights import HOLDS, STARTS, WEIGHTS
from lbskel.errors import UnknownChoice, choose
from lbskel.operators import Operator, operator_named
from lbskel.solvers import ALL_SOLVERS


@dataclass(frozen=True)
class ContractionSettings:
    """Parameters of a contraction; none has a unit.

    Parameters
    ----------
    operator : str, callable or None
        A name in OPERATORS or a function. None takes ``intrinsic_delaunay`` on a closed edge-manifold mesh and
        ``robust`` on any other.
    energy : str
        A name in ENERGIES.
    initial_weight_rule : str
        What ``initial_weight`` is a multiple of, a name in STARTS: ``reach``, a fraction of the mesh's extent that the
        first step reaches, or a published formula for W_L. WEIGHTS has those that were published together.
    initial_weight : float
    contraction_growth : float
        Factor on tau, or on W_L, after each step.
    attraction : str
        Which areas tell how much thinner a vertex's surroundings have become, a name in HOLDS.
    max_contraction_weight, max_attraction : float, optional
        Beyond which W_L and W_H do not grow.
    degenerate_rows : str
        What becomes of the rows of L at vertices of triangles with an angle under ``degenerate_angle``, for
        ``least_squares``, a name in DEGENERATE: ``none`` leaves them; ``identity`` puts an identity row with the
        right-hand side that holds the vertex; ``identity_zero`` the one with right-hand side zero, which pulls it to
        the origin; ``row_sums`` scales down every row whose weights sum to more than 10,000.
    degenerate_angle : float
        In radians.
    rollback : bool
        Whether steps are solved for the displacement and refined, and one after which the area or the bounding box has
        grown is undone and ends the contraction. Without it they are as published: solved once for the positions, with
        no look at the residual, and kept whatever they did, which ``Step.fault`` tells.
    collapse_length : float
        Between steps, edges shorter than this fraction of the square root of the area that each end had round it at
        the start are collapsed, so that later steps cost less. Only on closed manifolds, for ``curvature_flow`` with
        ``ring_areas`` and the guard.
    volume_ratio, area_ratio : float
        The contraction is done when the volume of a closed mesh, or the area of an open one, has fallen to this
        fraction.
    max_steps : int
    solver : str
        A name in SOLVERS, or, for study, in CLASSICAL_ITERATIONS.
    """

    operator: str | Operator | None = None
    energy: str = "curvature_flow"
    initial_weight_rule: str = "reach"
    initial_weight: float = 0.02
    contraction_growth: float = 2.0
    attraction: str = "ring_areas"
    max_contraction_weight: float | None = None
    max_attraction: float | None = None
    degenerate_rows: str = "none"
    degenerate_angle: float = 1e-3
    rollback: bool = True
    collapse_length: float = 0.45
    volume_ratio: float = 1e-4
    area_ratio: float = 5e-3
    max_steps: int = 30
    solver: str = "cholmod"

    def __post_init__(self) -> None:
        choose(ENERGIES, self.energy, "energy")
        choose(ALL_SOLVERS, self.solver, "solver")
        choose(STARTS, self.initial_weight_rule, "start of the weights")
        choose(HOLDS, self.attraction, "attraction")
        choose(DEGENERATE, self.degenerate_rows, "treatment of degenerate triangles")
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
            if value is not None and not value > 0:
                raise UnknownChoice(f"{name} must be positive, not {value}")


STRATEGIES: dict[str, Mapping[str, Any]] = {  # against degenerate triangles; the first four belong to least squares
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

PRESETS: dict[str, ContractionSettings] = {
    "flow": ContractionSettings(),
    "au2008": ContractionSettings(
        operator="clamped_cotangent", energy="least_squares", degenerate_rows="identity", volume_ratio=1e-6
    ),
    "au_program": ContractionSettings(
        operator="cotangent",
        energy="least_squares",
        degenerate_rows="row_sums",
        volume_ratio=1e-5,
        **WEIGHTS["program"],
    ),
    "cao2010": ContractionSettings(
        operator="cotangent", energy="least_squares", degenerate_rows="row_sums", **WEIGHTS["cao"]
    ),
}
