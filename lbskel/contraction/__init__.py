"""Contraction of a surface to its curve skeleton: energies, weights, steps, and the collapse to a graph."""

from lbskel.contraction.collapsed_graph import CollapsedGraph
from lbskel.contraction.flow import contract
from lbskel.contraction.result import Contraction, Status, Step
from lbskel.contraction.settings import DEGENERACY_STRATEGIES, PRESETS, ContractionSettings
from lbskel.contraction.surgery import collapse, collapse_mesh
from lbskel.contraction.weights import WEIGHTS

__all__ = [
    "DEGENERACY_STRATEGIES",
    "PRESETS",
    "WEIGHTS",
    "CollapsedGraph",
    "Contraction",
    "ContractionSettings",
    "Status",
    "Step",
    "collapse",
    "collapse_mesh",
    "contract",
]
