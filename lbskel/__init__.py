"""lbskel: discrete Laplace-Beltrami operators and curve skeletons by Laplacian contraction."""

from lbskel.applications import eigenpairs
from lbskel.contraction import (
    DEGENERACY_STRATEGIES,
    PRESETS,
    WEIGHTS,
    CollapsedGraph,
    Contraction,
    ContractionSettings,
    Status,
    Step,
    collapse,
    collapse_mesh,
    contract,
)
from lbskel.errors import (
    FormatError,
    LbskelError,
    MeshError,
    MissingDependency,
    OperatorError,
    SolveError,
    UnknownChoice,
)
from lbskel.evaluation import (
    MEASURES,
    GroundTruthDistances,
    LaplacianDiagnostics,
    Score,
    ground_truth_distances,
    laplacian_diagnostics,
)
from lbskel.geometry import Mesh, PointCloud, VertexMap, as_mesh
from lbskel.io import read_mesh, read_points, read_skeleton, write_mesh, write_skeleton
from lbskel.operators import OPERATORS, Laplacian, laplacian
from lbskel.pipeline import (
    Body,
    PreparedMesh,
    assemble,
    prepare,
    refine,
    score,
    skeletonize,
    skeletonize_many,
    to_skeleton,
)
from lbskel.preprocess import PIPELINES, MeshReport, Pipeline, PreprocessResult, check
from lbskel.skeleton import Skeleton, join_components, merge_junctions, prune, resample, simplify_branches, to_tree
from lbskel.solvers import SOLVERS, factorize
from lbskel.solvers.least_squares import LEAST_SQUARES, lstsq

__version__ = "0.1.0"

__all__ = [
    "DEGENERACY_STRATEGIES",
    "LEAST_SQUARES",
    "MEASURES",
    "OPERATORS",
    "PIPELINES",
    "PRESETS",
    "SOLVERS",
    "WEIGHTS",
    "Body",
    "CollapsedGraph",
    "Contraction",
    "ContractionSettings",
    "FormatError",
    "GroundTruthDistances",
    "Laplacian",
    "LaplacianDiagnostics",
    "LbskelError",
    "Mesh",
    "MeshError",
    "MeshReport",
    "MissingDependency",
    "OperatorError",
    "Pipeline",
    "PointCloud",
    "PreparedMesh",
    "PreprocessResult",
    "Score",
    "Skeleton",
    "SolveError",
    "Status",
    "Step",
    "UnknownChoice",
    "VertexMap",
    "as_mesh",
    "assemble",
    "check",
    "collapse",
    "collapse_mesh",
    "contract",
    "eigenpairs",
    "factorize",
    "ground_truth_distances",
    "join_components",
    "laplacian",
    "laplacian_diagnostics",
    "lstsq",
    "merge_junctions",
    "prepare",
    "prune",
    "read_mesh",
    "read_points",
    "read_skeleton",
    "refine",
    "resample",
    "score",
    "simplify_branches",
    "skeletonize",
    "skeletonize_many",
    "to_skeleton",
    "to_tree",
    "write_mesh",
    "write_skeleton",
]
