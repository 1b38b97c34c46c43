"""Many meshes at once: one process each, here or on a Dask cluster, none of which can stop the rest."""

__all__ = ["Outcome", "Record", "skeletonize_many"]

from lbskel.pipeline.batch.records import Outcome, Record
from lbskel.pipeline.batch.run import skeletonize_many
