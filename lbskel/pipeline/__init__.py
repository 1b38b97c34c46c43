"""From any mesh to a checked skeleton: the stages in their order, and many meshes at once."""

from lbskel.pipeline.assembly import assemble
from lbskel.pipeline.batch import skeletonize_many
from lbskel.pipeline.bodies import to_skeleton
from lbskel.pipeline.evaluation import score
from lbskel.pipeline.options import DOMAINS
from lbskel.pipeline.passes import refine
from lbskel.pipeline.preparation import Body, PreparedMesh, prepare
from lbskel.pipeline.progress import StageBar
from lbskel.pipeline.stages import skeletonize
from lbskel.pipeline.viewing import view

__all__ = [
    "DOMAINS",
    "Body",
    "PreparedMesh",
    "StageBar",
    "assemble",
    "prepare",
    "refine",
    "score",
    "skeletonize",
    "skeletonize_many",
    "to_skeleton",
    "view",
]
