"""lbskel: discrete Laplace-Beltrami operators and curve skeletons by Laplacian contraction."""

from lbskel.applications.spectrum import eigenpairs
from lbskel.batch import skeletonize_many
from lbskel.bones import simplify_branches
from lbskel.contraction import PRESETS, Contraction, ContractionSettings, Status, Step, contract
from lbskel.errors import (
    FormatError,
    LbskelError,
    MeshError,
    MissingDependency,
    SolveError,
    UnknownChoice,
)
from lbskel.files import as_mesh, read_mesh, read_points, read_skeleton, write_mesh, write_skeleton
from lbskel.health import Health, health
from lbskel.joining import join_components
from lbskel.judging import score
from lbskel.mesh import Mesh, PointCloud
from lbskel.operators import OPERATORS, Laplacian, laplacian
from lbskel.pipeline import skeletonize
from lbskel.preprocess import PIPELINES, MeshReport, Pipeline, Preprocessed, check
from lbskel.pruning import merge_junctions, prune
from lbskel.quality import Score, compare
from lbskel.resampling import resample
from lbskel.settings import STRATEGIES
from lbskel.skeleton import Skeleton
from lbskel.solvers import SOLVERS, factorize
from lbskel.solvers.least_squares import LEAST_SQUARES, lstsq
from lbskel.surgery import Collapsed, collapse
from lbskel.weights import WEIGHTS

__version__ = "0.1.0"

__all__ = [
    "LEAST_SQUARES",
    "OPERATORS",
    "PIPELINES",
    "PRESETS",
    "SOLVERS",
    "STRATEGIES",
    "WEIGHTS",
    "Collapsed",
    "Contraction",
    "ContractionSettings",
    "FormatError",
    "Health",
    "Laplacian",
    "LbskelError",
    "Mesh",
    "MeshError",
    "MeshReport",
    "MissingDependency",
    "Pipeline",
    "PointCloud",
    "Preprocessed",
    "Score",
    "Skeleton",
    "SolveError",
    "Status",
    "Step",
    "UnknownChoice",
    "as_mesh",
    "check",
    "collapse",
    "compare",
    "contract",
    "eigenpairs",
    "factorize",
    "health",
    "join_components",
    "laplacian",
    "lstsq",
    "merge_junctions",
    "prune",
    "read_mesh",
    "read_points",
    "read_skeleton",
    "resample",
    "score",
    "simplify_branches",
    "skeletonize",
    "skeletonize_many",
    "write_mesh",
    "write_skeleton",
]
