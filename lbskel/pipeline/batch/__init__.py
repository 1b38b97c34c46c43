"""Many meshes at once: each in a process of its own, on this machine or on a Dask cluster."""

__all__ = ["BatchStatus", "Record", "skeletonize_many"]

from lbskel.pipeline.batch.records import BatchStatus, Record
from lbskel.pipeline.batch.run import skeletonize_many
