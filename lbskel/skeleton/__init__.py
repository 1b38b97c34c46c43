"""The skeleton as a graph with radii and maps, and what edits it: pruning, resampling, simplification, joining."""

from lbskel.skeleton.joining import join_components
from lbskel.skeleton.pruning import merge_junctions, prune
from lbskel.skeleton.resampling import resample
from lbskel.skeleton.simplification import simplify_branches
from lbskel.skeleton.skeleton import Skeleton

__all__ = ["Skeleton", "join_components", "merge_junctions", "prune", "resample", "simplify_branches"]
