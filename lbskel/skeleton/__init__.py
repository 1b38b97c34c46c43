"""The skeleton as a graph with radii and maps, its edits (pruning, resampling, joining, cutting cycles), and rigs."""

from lbskel.skeleton.armature import Rig
from lbskel.skeleton.joining import join_components
from lbskel.skeleton.pruning import merge_junctions, prune
from lbskel.skeleton.resampling import resample
from lbskel.skeleton.short_loops import open_short_loops
from lbskel.skeleton.simplification import simplify_branches
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.spanning_tree import to_tree

__all__ = [
    "Rig",
    "Skeleton",
    "join_components",
    "merge_junctions",
    "open_short_loops",
    "prune",
    "resample",
    "simplify_branches",
    "to_tree",
]
