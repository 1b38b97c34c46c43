"""Applications of operators and skeletons, one module each."""

from lbskel.applications.anchor_selection import least_squares_mesh
from lbskel.applications.branches import BranchTable, branch_table
from lbskel.applications.deformation_methods import EDITING_METHODS
from lbskel.applications.differential_coordinates import delta_coordinates, reconstruct
from lbskel.applications.editing import Editor, edit, rigid_motion
from lbskel.applications.quantization import QuantizedDeltas, quantize_deltas
from lbskel.applications.segmentation import Segmentation, segment
from lbskel.applications.smoothing import SMOOTHING_METHODS, smooth
from lbskel.applications.spectrum import eigenpairs

__all__ = [
    "EDITING_METHODS",
    "SMOOTHING_METHODS",
    "BranchTable",
    "Editor",
    "QuantizedDeltas",
    "Segmentation",
    "branch_table",
    "delta_coordinates",
    "edit",
    "eigenpairs",
    "least_squares_mesh",
    "quantize_deltas",
    "reconstruct",
    "rigid_motion",
    "segment",
    "smooth",
]
