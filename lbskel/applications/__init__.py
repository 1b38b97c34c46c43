"""Applications of the operators other than skeletons."""

from lbskel.applications.spectrum import eigenpairs

__all__ = ["eigenpairs"]
