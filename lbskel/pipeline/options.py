"""Options of :func:`lbskel.skeletonize`: their choices, their defaults, and presets of them by domain.

A preset by domain is a few options of the same pipeline that suit a kind of shape; all others are as for any mesh.
"""

from __future__ import annotations

__all__ = [
    "DOMAINS",
    "JOIN",
    "PAGE_OPTIONS",
    "RADIUS_KINDS",
    "TIP_POSITIONS",
    "require_refinement_options",
    "resolve_options",
    "resolve_settings",
]

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from lbskel.contraction.settings import PRESETS, ContractionSettings
from lbskel.errors import UnknownChoice, choose
from lbskel.operators import Operator
from lbskel.skeleton.pruning import MIN_BRANCH_RATIO

TIP_POSITIONS = ("inside", "surface")
JOIN = ("pieces", "all", "none")
RADIUS_KINDS = ("inscribed", "mean")
PAGE_OPTIONS = ("preprocess", "simplify")  # with which a page repeats the contraction of a skeleton that is given

DOMAINS: dict[str, Mapping[str, Any]] = {
    "neuron": {"min_loop": 60.0, "join": "all", "radius_kind": "mean"},
    "vessel": {"min_loop": 12.0},
    "plant": {"min_loop": 12.0},
    "character": {"min_loop": 12.0},
    "cad": {"tip_position": "surface"},
}
"""Options by domain.

- ``neuron``: one graph for each cell, whose pieces are joined whatever the gap, and no loops shorter than 60 radii:
  touching neurites leave loops, and a cell has none. Of the 29 and 40 loops of two hemibrain neurons 17 and 25 are
  longer; opening the others lowers the F-score of the cable by 0.002. These numbers are not in a committed table.
  Radii are mean ones, those of round tubes; benchmarks/results/neurons.md has the errors of both kinds.
- ``vessel``, ``plant``, ``character``: no loops shorter than 12 radii, such as those where limbs touch or noise has
  made a handle. The ring around a tunnel as wide as its tube is thick has a length of 4 pi radii.
- ``cad``: branches that end on the surface, since the length of the part is measured.
"""


def resolve_options(preset: str | ContractionSettings, given: dict[str, Any]) -> dict[str, Any]:
    """Return each option as given, or else that of the domain, or else the default.

    Raises
    ------
    UnknownChoice
        If a name is in no table or a number is negative or NaN.
    """
    options: dict[str, Any] = {
        "min_branch_ratio": MIN_BRANCH_RATIO,
        "tip_position": TIP_POSITIONS[0],
        "join": JOIN[0],
        "min_loop": 0.0,
        "radius_kind": RADIUS_KINDS[0],
    }
    if isinstance(preset, str):
        options |= DOMAINS.get(preset, {})
    options |= {name: value for name, value in given.items() if value is not None}
    require_refinement_options(options["min_branch_ratio"], options["tip_position"])
    choose(dict.fromkeys(JOIN), options["join"], "way to join")
    choose(dict.fromkeys(RADIUS_KINDS), options["radius_kind"], "kind of radius")
    if not options["min_loop"] >= 0:
        raise UnknownChoice(f"min_loop must be a number of local radii, 0 or more, not {options['min_loop']}")
    return options


def resolve_settings(
    preset: str | ContractionSettings, operator: str | Operator | None, energy: str | None, solver: str | None
) -> ContractionSettings:
    """Return the preset with the operator, energy and solver that were asked for.

    Raises
    ------
    UnknownChoice
        If a name is in no table.
    """
    if isinstance(preset, ContractionSettings):
        settings = preset
    else:
        choose(dict.fromkeys([*PRESETS, *DOMAINS]), preset, "preset")
        settings = PRESETS["curvature_flow" if preset in DOMAINS else preset]
    changes: dict[str, Any] = {"operator": operator, "energy": energy, "solver": solver}
    if energy is not None and energy != settings.energy:
        changes["degenerate_rows"] = "none"
    return replace(settings, **{name: value for name, value in changes.items() if value is not None})


def require_refinement_options(min_branch_ratio: float, tip_position: str) -> None:
    """Raise UnknownChoice for options without meaning, before any work is done."""
    choose(dict.fromkeys(TIP_POSITIONS), tip_position, "tip position")
    if not min_branch_ratio >= 0:
        raise UnknownChoice(f"min_branch_ratio must be a number of local radii, 0 or more, not {min_branch_ratio}")
