"""Applications of operators and skeletons: the spectrum of a Laplacian, the branches of a skeleton as a table."""

from lbskel.applications.branches import BranchTable, branch_table
from lbskel.applications.spectrum import eigenpairs

__all__ = ["BranchTable", "branch_table", "eigenpairs"]
