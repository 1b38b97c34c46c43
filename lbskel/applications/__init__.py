"""Applications of operators and skeletons, one module each."""

from lbskel.applications.anchor_selection import least_squares_mesh
from lbskel.applications.basis import SpectralBasis, spectral_basis
from lbskel.applications.branches import BranchTable, branch_table
from lbskel.applications.compression import BASES, CompressedMesh, compress
from lbskel.applications.deformation_methods import EDITING_METHODS
from lbskel.applications.differential_coordinates import delta_coordinates, reconstruct
from lbskel.applications.editing import Editor, edit
from lbskel.applications.geodesics import extend_values, geodesic_distance
from lbskel.applications.heat_method import HeatMethod
from lbskel.applications.quantization import QuantizedDeltas, quantize_deltas
from lbskel.applications.rigging import rig
from lbskel.applications.rigid_motions import rigid_motion
from lbskel.applications.segmentation import Segmentation, segment
from lbskel.applications.shape_dna import shape_dna_distance
from lbskel.applications.signatures import heat_kernel_signature, wave_kernel_signature
from lbskel.applications.smoothing import SMOOTHING_METHODS, smooth
from lbskel.applications.spectrum import eigenpairs

__all__ = [
    "BASES",
    "EDITING_METHODS",
    "SMOOTHING_METHODS",
    "BranchTable",
    "CompressedMesh",
    "Editor",
    "HeatMethod",
    "QuantizedDeltas",
    "Segmentation",
    "SpectralBasis",
    "branch_table",
    "compress",
    "delta_coordinates",
    "edit",
    "eigenpairs",
    "extend_values",
    "geodesic_distance",
    "heat_kernel_signature",
    "least_squares_mesh",
    "quantize_deltas",
    "reconstruct",
    "rig",
    "rigid_motion",
    "segment",
    "shape_dna_distance",
    "smooth",
    "spectral_basis",
    "wave_kernel_signature",
]
