"""What the operators are good for besides contraction."""

from lbskel.applications.spectrum import eigenpairs

__all__ = ["eigenpairs"]
