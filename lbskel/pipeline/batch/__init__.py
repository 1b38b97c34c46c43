"""Many meshes at once: one process each, here or on a Dask cluster, none of which can stop the rest."""

__all__ = ["BatchStatus", "Record", "skeletonize_many"]

from lbskel.pipeline.batch.records import BatchStatus, Record
from lbskel.pipeline.batch.run import skeletonize_many
