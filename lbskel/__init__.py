"""lbskel: discrete Laplace-Beltrami operators and curve skeletons by Laplacian contraction."""

from lbskel.errors import (
    FormatError,
    LbskelError,
    MeshError,
    MissingDependency,
    SolveError,
    UnknownChoice,
)
from lbskel.mesh import Mesh, PointCloud
from lbskel.operators import OPERATORS, Laplacian, laplacian
from lbskel.skeleton import Skeleton
from lbskel.solvers import SOLVERS, factorize

__version__ = "0.1.0"

__all__ = [
    "OPERATORS",
    "SOLVERS",
    "FormatError",
    "Laplacian",
    "LbskelError",
    "Mesh",
    "MeshError",
    "MissingDependency",
    "PointCloud",
    "Skeleton",
    "SolveError",
    "UnknownChoice",
    "factorize",
    "laplacian",
]
