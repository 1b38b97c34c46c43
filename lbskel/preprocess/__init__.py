"""From the mesh that a user has to one that the algorithms can take; the only place that may import pymeshlab."""

__all__ = ["Preprocessed", "components", "simplify", "tidy"]

from lbskel.preprocess.simplification import simplify
from lbskel.preprocess.tidying import Preprocessed, components, tidy
