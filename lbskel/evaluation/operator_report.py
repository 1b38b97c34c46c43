"""The diagnostics of a discrete Laplacian as a value: measures, the properties they decide, and a table of them.

The properties are those of Wardetzky, Mathur, Kaelberer, Grinspun 2007, "Discrete Laplace operators: no free lunch",
https://doi.org/10.2312/SGP/SGP07/033-037, and two that a contraction needs: no row is changed at a degenerate triangle,
and the total mass is the area.
"""

from __future__ import annotations

__all__ = ["ROUNDING", "ZERO_EIGENVALUE", "LaplacianDiagnostics", "diagnostics_table"]

from collections.abc import Mapping
from dataclasses import dataclass

# Bounds up to which a property counts as kept; all relative, without a unit.
ROUNDING = 1e-12  # relative to the largest entry or the mean weight: the rounding of sums of a few dozen numbers
MAX_LINEAR_ERROR = 1e-8  # a guess: the tolerance for a plane, 1e-10, times the growth by the weights of needles
# Largest size of an eigenvalue that counts as zero. Those of D^-1 S lie in 0..2 for positive weights, and the first
# non-zero one is about 1 / n where triangles are even; where they are stretched, it is smaller.
ZERO_EIGENVALUE = 1e-10
MAX_OVERSHOOT = 1e-9  # for boundary values in 0..1: a guess at the error of the linear solve
MAX_AREA_ERROR = 1e-6  # relative to the area: edge lengths mollified with a slack of 1e-6 change areas by this much


@dataclass(frozen=True)
class LaplacianDiagnostics:
    """Measures of an operator on its mesh; None where one is not defined or could not be computed.

    ``print`` shows them as ``lbskel laplacian`` does.

    Parameters
    ----------
    asymmetry : float
        Largest |S - S^T| over largest |S|.
    nonlocal_fraction : float
        Fraction of the off-diagonal entries whose two vertices share no edge of the mesh.
    row_sum_error : float
        Largest |S 1| over largest |S|.
    linear_precision_error : float or None
        Largest |(S V)_i| over sum_j |w_ij| |e_ij|, over the inner vertices whose row couples them only to vertices of
        their own plane; None if there are none.
    n_negative_weights : int
        Pairs of vertices with a negative weight.
    negative_fraction : float
        Their fraction of all pairs with a weight.
    most_negative_weight : float
        The most negative weight, in units of the mean absolute weight.
    smallest_eigenvalue : float or None
        Of D^-1 (S + S^T) / 2 with D the magnitudes of the diagonal of S; 0 if none is negative beyond rounding.
    n_zero_eigenvalues : int or None
        Dimension of the null space; None if S is not symmetric, since it would be that of (S + S^T) / 2.
    n_components : int
        Connected components of the mesh; the dimension that the null space should have.
    overshoot : float or None
        How far solutions of Dirichlet problems leave the range of the boundary values, relative to that range.
    condition_number : float or None
        Largest over smallest non-zero eigenvalue of (S + S^T) / 2 on the largest component; None if it is indefinite.
    n_fallback_rows : int
        Vertices whose row differs from the formula because a triangle there is degenerate.
    area_ratio : float or None
        Total mass over the area of the mesh.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> mesh = torus(1.0, 0.2, 16, 8)
    >>> lbskel.laplacian_diagnostics(lbskel.laplacian(mesh), mesh).asymmetry
    0.0
    """

    asymmetry: float
    nonlocal_fraction: float
    row_sum_error: float
    linear_precision_error: float | None
    n_negative_weights: int
    negative_fraction: float
    most_negative_weight: float
    smallest_eigenvalue: float | None
    n_zero_eigenvalues: int | None
    n_components: int
    overshoot: float | None
    condition_number: float | None
    n_fallback_rows: int
    area_ratio: float | None

    def __str__(self) -> str:
        return diagnostics_table({"Laplacian": self})

    @property
    def passed(self) -> dict[str, bool | None]:
        """Each property by name: True if it holds up to rounding, False if not, None if it was not measured."""
        smallest, linear, overshoot = self.smallest_eigenvalue, self.linear_precision_error, self.overshoot
        return {
            "symmetric": self.asymmetry <= ROUNDING,
            "local": self.nonlocal_fraction == 0,
            "constants": self.row_sum_error <= ROUNDING,
            "linear": None if linear is None else linear <= MAX_LINEAR_ERROR,
            "positive": self.n_negative_weights == 0,
            "semidefinite": None if smallest is None else smallest >= -ZERO_EIGENVALUE,
            "null space": None if self.n_zero_eigenvalues is None else self.n_zero_eigenvalues == self.n_components,
            "maximum": None if overshoot is None else overshoot <= MAX_OVERSHOOT,
            "untreated": self.n_fallback_rows == 0,
            "area": None if self.area_ratio is None else abs(self.area_ratio - 1) <= MAX_AREA_ERROR,
        }


COLUMNS: dict[str, tuple[str, str]] = {  # heading: the measure, and the property that it decides
    "asymmetry": ("asymmetry", "symmetric"),
    "nonlocal": ("nonlocal_fraction", "local"),
    "row sums": ("row_sum_error", "constants"),
    "linear": ("linear_precision_error", "linear"),
    "negative": ("negative_fraction", "positive"),
    "lowest": ("most_negative_weight", "positive"),
    "eigenvalue": ("smallest_eigenvalue", "semidefinite"),
    "null space": ("n_zero_eigenvalues", "null space"),
    "overshoot": ("overshoot", "maximum"),
    "condition": ("condition_number", ""),
    "fallback": ("n_fallback_rows", "untreated"),
    "area": ("area_ratio", "area"),
}
PERCENTAGES = {"nonlocal_fraction", "negative_fraction"}
LEGEND = """\
!: the property does not hold. -: not defined on this mesh, or could not be computed.
asymmetry, row sums: relative to the largest entry. nonlocal: weights between vertices that share no edge. linear: error
on planar patches. negative: negative weights; lowest: the most negative one, in mean weights. eigenvalue: the smallest,
if negative. null space: its dimension, which should be {n_components}. overshoot: violation of the maximum principle.
fallback: vertices at degenerate triangles, with a changed row. area: total mass over the area of the mesh."""


def diagnostics_table(diagnostics: Mapping[str, LaplacianDiagnostics], refused: Mapping[str, str] | None = None) -> str:
    """Format the diagnostics of operators on one mesh as a table with a legend; failed properties are marked.

    Parameters
    ----------
    diagnostics : dict of str to LaplacianDiagnostics
        By the names of the operators, one row each.
    refused : dict of str to str, optional
        By the names of other operators, why they are not defined on the mesh; a line each.
    """
    rows = [["operator", *COLUMNS]]
    for name, measured in diagnostics.items():
        passed = measured.passed
        rows.append(
            [name, *(_cell(field, getattr(measured, field), passed.get(key)) for field, key in COLUMNS.values())]
        )
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip() for row in rows]
    lines += [f"{name}: {message}" for name, message in (refused or {}).items()]
    n_components = next((measured.n_components for measured in diagnostics.values()), 1)
    return "\n".join([*lines, "", LEGEND.format(n_components=n_components)])


def _cell(field: str, value: float | None, holds: bool | None) -> str:
    """Format a measure, marked if its property does not hold."""
    if value is None:
        return "- "
    number = str(value) if isinstance(value, int) else f"{value:.2g}"
    text = f"{100 * value:.3g}%" if field in PERCENTAGES else number
    return text + ("!" if holds is False else " ")
