"""Applications of operators and skeletons, one module each."""

from lbskel.applications.branches import BranchTable, branch_table
from lbskel.applications.smoothing import SMOOTHING_METHODS, smooth
from lbskel.applications.spectrum import eigenpairs

__all__ = [
    "SMOOTHING_METHODS",
    "BranchTable",
    "branch_table",
    "eigenpairs",
    "smooth",
]
