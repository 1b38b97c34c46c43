"""The measures of a skeleton's score: what each is, its thresholds, and the verdict that follows."""

from __future__ import annotations

__all__ = ["MEASURES", "NOT_SCORED", "Measure", "Score"]

from dataclasses import asdict, dataclass, fields
from typing import Any, NamedTuple

import numpy as np


class Measure(NamedTuple):
    """The description of a measure and the thresholds of its verdict.

    Parameters
    ----------
    text : str
        What is measured, in a phrase.
    passes, fails : float
        Absolute values up to which the measure passes and from which on it fails; between them it warns. They are
        chosen so that the skeletons of the shapes of the catalog, 13 in three variants, pass or warn, and that
        skeletons with one fault put in fail. Where ``passes`` is the larger one, larger values are better.
    """

    text: str
    passes: float
    fails: float

    def verdict(self, value: float | None) -> str:
        """Judge a value: ``pass``, ``warn`` or ``fail``, as for NaN; ``not measured`` for None."""
        if value is None:
            return NOT_MEASURED
        sign = 1 if self.passes < self.fails else -1
        if sign * (abs(value) - self.passes) <= 0:
            return "pass"
        return "warn" if sign * (abs(value) - self.fails) < 0 else "fail"


MEASURES = {
    "nodes_inside_fraction": Measure("share of the nodes inside the surface or on it", 0.995, 0.97),
    "inside_fraction": Measure("share of the length inside the surface", 0.995, 0.97),
    "centeredness_error": Measure(
        "mean distance of nodes from the centroid of their cross-section, in local radii", 0.1, 0.25
    ),
    "centeredness_error_worst_branch": Measure(
        "median of that distance over the worst branch, in local radii", 0.2, 0.4
    ),
    "medial_accuracy_95": Measure(
        "95th percentile, by length, of the distance to the nearest medial point, in local radii", 0.2, 1.0
    ),
    "medial_coverage_98": Measure(
        "98th percentile, by area, of the distance of medial points from the skeleton, in local radii", 0.35, np.inf
    ),
    "uncovered_parts": Measure(
        "parts of limbs whose medial points are farther than a radius from the skeleton", 0, np.inf
    ),
    "near_surface_fraction": Measure(
        "share of the length nearer to the surface than a fifth of the local or mean radius", 0.05, 0.25
    ),
    "coverage": Measure(
        "share of the surface area within two local radii, or two widths of its region, of its node", 0.9, 0.3
    ),
    "extremities_missed": Measure("extremities of the shape that no tip reaches", 0, np.inf),
    "missed_limb_fraction": Measure("share of the limbs longer than 5.3 radii whose extremity no tip reaches", 0, 0.1),
    "rms_curvature": Measure("root mean square curvature, in radians per local radius", 1.0, 5.0),
    "extra_components": Measure("components of the skeleton minus components of the surface", 0, 1),
    "extra_cycles": Measure("cycles of the skeleton minus handles of the surface", 0, 1),
    "tunnels_missed": Measure(
        "tunnels that no cycle of the skeleton goes around; of a cloud, limbs at which it is cut", 0, 1
    ),
    "connected_regions": Measure(
        "share of the vertices in the largest connected part of their node's region", 0.98, 0.6
    ),
    "adjacent_regions": Measure(
        "share of the skeleton edges whose two regions are adjacent, or as near as the mesh's edges are long", 0.9, 0.6
    ),
    "shortcut_edges": Measure(
        "skeleton edges longer than their regions are wide that neither touch nor have a neighbor's between", 0, 1
    ),
    "spurs": Measure("end branches that stay within 1.2 times the ball of their junction", 0, 6),
}


NOT_MEASURED = "not measured"  # the verdict on a measure that could not be taken
# Why not, on a surface
_CAUSES = dict.fromkeys(("connected_regions", "adjacent_regions"), ", since the skeleton has no vertex map") | {
    "extra_cycles": ", since edges of the mesh have more than two faces",
    "tunnels_missed": ", since the mesh, or the skeleton, is in pieces, open, non-manifold or intersects itself",
}


@dataclass(frozen=True)
class Score:
    """The measures of a skeleton on its mesh, which :data:`MEASURES` describes; None where one could not be taken.

    Parameters
    ----------
    nodes_inside_fraction, inside_fraction : float
    centeredness_error, centeredness_error_worst_branch : float or None
        None if no node, or no branch, has enough cross-sections of its own.
    medial_accuracy_95, medial_coverage_98 : float or None
        Of medial points, one local radius under each vertex; None on a cloud.
    uncovered_parts : int or None
        None on a cloud.
    near_surface_fraction : float or None
        None on a cloud.
    coverage : float
    extremities : int
        Number of ends of the shape, found on its surface.
    extremities_missed : int
    missed_limb_fraction : float
        Of the limbs, which must have a tip; shorter ends may have none.
    rms_curvature : float
    extra_components : int
    extra_cycles : int or None
        None if more than two faces meet at an edge of the mesh, and on a cloud.
    tunnels_missed : int or None
        None for skeletons and surfaces of several components, and surfaces that are open or intersect themselves. On
        a cloud, the limbs at which the skeleton is cut although another part of it joins the two sides.
    connected_regions, adjacent_regions : float or None
        None for a skeleton without a vertex map, and on a cloud.
    shortcut_edges : int or None
        None on a cloud.
    spurs : int

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> score = lbskel.score(lbskel.skeletonize(torus(1.0, 0.2)), torus(1.0, 0.2))
    >>> score.verdict, score.extra_cycles
    ('pass', 0)
    """

    nodes_inside_fraction: float
    inside_fraction: float
    centeredness_error: float | None
    centeredness_error_worst_branch: float | None
    medial_accuracy_95: float | None
    medial_coverage_98: float | None
    uncovered_parts: int | None
    near_surface_fraction: float | None
    coverage: float
    extremities: int
    extremities_missed: int
    missed_limb_fraction: float
    rms_curvature: float
    extra_components: int
    extra_cycles: int | None
    tunnels_missed: int | None
    connected_regions: float | None
    adjacent_regions: float | None
    shortcut_edges: int | None
    spurs: int

    @property
    def verdicts(self) -> dict[str, str]:
        """``pass``, ``warn``, ``fail`` or ``not measured`` for each measure."""
        values = asdict(self)
        return {name: measure.verdict(values[name]) for name, measure in MEASURES.items()}

    @property
    def verdict(self) -> str:
        """The worst of the verdicts."""
        found = self.verdicts.values()
        return next((verdict for verdict in ("fail", "warn") if verdict in found), "pass")

    @property
    def passed(self) -> bool:
        """Whether no measure fails; some may warn."""
        return self.verdict != "fail"

    @property
    def not_measured(self) -> tuple[str, ...]:
        """Names of the measures that could not be taken, such as those of the map of a skeleton without one."""
        return tuple(name for name, verdict in self.verdicts.items() if verdict == NOT_MEASURED)

    def __str__(self) -> str:
        """Tabulate the measures with their thresholds, and give the verdict."""
        values = asdict(self)
        rows = [("measure", "value", "verdict", "passes", "fails", "")]
        for name, measure in MEASURES.items():
            sign = ">=" if measure.passes > measure.fails else "<="
            fails = "never" if not np.isfinite(measure.fails) else f"{'<=' if sign == '>=' else '>='} {measure.fails:g}"
            value, verdict = values[name], measure.verdict(values[name])
            shown = "-" if value is None else f"{value:d}" if isinstance(value, int) else f"{value:.3f}"
            rows.append((name.replace("_", " "), shown, verdict, f"{sign} {measure.passes:g}", fails, measure.text))
        lines = [f"{a:33} {b:>7}  {c:12}  {d:>9}  {e:>9}  {f}".rstrip() for a, b, c, d, e, f in rows]
        missing: dict[str, list[str]] = {}
        for name in self.not_measured:
            cause = _CAUSES.get(name, "") if self.near_surface_fraction is not None else ", without a surface"
            missing.setdefault(cause, []).append(name.replace("_", " "))
        lines += [f"not measured{cause}: {', '.join(names)}" for cause, names in missing.items()]
        return "\n".join([*lines, f"verdict: {self.verdict}; the shape has {self.extremities} extremities"])

    def report(self) -> dict[str, Any]:
        """Return the verdict, the measures and their verdicts, ready for JSON."""
        return {"verdict": self.verdict, "measures": asdict(self), "verdicts": self.verdicts}


NOT_SCORED: dict[str, Any] = {
    "verdict": NOT_MEASURED,
    "measures": dict.fromkeys(each.name for each in fields(Score)),
    "verdicts": dict.fromkeys(MEASURES, NOT_MEASURED),
}
"""The report in place of that of a score for which there was no time."""
