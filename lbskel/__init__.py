"""lbskel: discrete Laplace-Beltrami operators and curve skeletons by Laplacian contraction.

.. include:: ../README.md
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

__all__ = [
    "BASES",
    "DEGENERACY_STRATEGIES",
    "DOMAINS",
    "EDITING_METHODS",
    "LEAST_SQUARES",
    "MEASURES",
    "OPERATORS",
    "PIPELINES",
    "PRESETS",
    "SMOOTHING_METHODS",
    "SOLVERS",
    "WEIGHTS",
    "Body",
    "BranchTable",
    "CollapsedGraph",
    "CompressedMesh",
    "Contraction",
    "ContractionSettings",
    "Editor",
    "FormatError",
    "GroundTruthDistances",
    "HeatMethod",
    "Laplacian",
    "LaplacianDiagnostics",
    "LbskelError",
    "MemoryLimitError",
    "Mesh",
    "MeshError",
    "MeshReport",
    "MissingDependency",
    "OperatorError",
    "Pipeline",
    "PointCloud",
    "PreparedMesh",
    "PreprocessResult",
    "QuantizedDeltas",
    "Rig",
    "Score",
    "Segmentation",
    "Skeleton",
    "SolveError",
    "SpectralBasis",
    "StageBar",
    "Status",
    "Step",
    "UnknownChoice",
    "VertexMap",
    "as_mesh",
    "assemble",
    "branch_table",
    "check",
    "collapse",
    "collapse_mesh",
    "compress",
    "contract",
    "delta_coordinates",
    "edit",
    "eigenpairs",
    "extend_values",
    "factorize",
    "geodesic_distance",
    "ground_truth_distances",
    "heat_kernel_signature",
    "join_components",
    "laplacian",
    "laplacian_diagnostics",
    "least_squares_mesh",
    "lstsq",
    "merge_junctions",
    "open_short_loops",
    "prepare",
    "prune",
    "quantize_deltas",
    "read_mesh",
    "read_points",
    "read_skeleton",
    "reconstruct",
    "reconstruct_surface",
    "refine",
    "resample",
    "rig",
    "rigid_motion",
    "score",
    "segment",
    "shape_dna_distance",
    "simplify_branches",
    "skeletonize",
    "skeletonize_many",
    "smooth",
    "spectral_basis",
    "to_skeleton",
    "to_tree",
    "view",
    "wave_kernel_signature",
    "write_mesh",
    "write_rig",
    "write_skeleton",
]

if TYPE_CHECKING:
    from lbskel.applications import (
        BASES,
        EDITING_METHODS,
        SMOOTHING_METHODS,
        BranchTable,
        CompressedMesh,
        Editor,
        HeatMethod,
        QuantizedDeltas,
        Segmentation,
        SpectralBasis,
        branch_table,
        compress,
        delta_coordinates,
        edit,
        eigenpairs,
        extend_values,
        geodesic_distance,
        heat_kernel_signature,
        least_squares_mesh,
        quantize_deltas,
        reconstruct,
        rig,
        rigid_motion,
        segment,
        shape_dna_distance,
        smooth,
        spectral_basis,
        wave_kernel_signature,
    )
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
        MemoryLimitError,
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
    from lbskel.io import read_mesh, read_points, read_skeleton, write_mesh, write_rig, write_skeleton
    from lbskel.operators import OPERATORS, Laplacian, laplacian
    from lbskel.pipeline import (
        DOMAINS,
        Body,
        PreparedMesh,
        StageBar,
        assemble,
        prepare,
        refine,
        score,
        skeletonize,
        skeletonize_many,
        to_skeleton,
        view,
    )
    from lbskel.preprocess import PIPELINES, MeshReport, Pipeline, PreprocessResult, check, reconstruct_surface
    from lbskel.skeleton import (
        Rig,
        Skeleton,
        join_components,
        merge_junctions,
        open_short_loops,
        prune,
        resample,
        simplify_branches,
        to_tree,
    )
    from lbskel.solvers import SOLVERS, factorize
    from lbskel.solvers.least_squares import LEAST_SQUARES, lstsq
else:
    # packages in which a public name is looked for when it is first used (PEP 562), from the bottom of the architecture
    # up; "import lbskel" alone imports none of them
    _PACKAGES = (
        "errors",
        "geometry",
        "skeleton",
        "io",
        "solvers",
        "solvers.least_squares",
        "operators",
        "applications",
        "contraction",
        "preprocess",
        "evaluation",
        "pipeline",
        "shapes",
        "visualization",
    )

    def __getattr__(name: str) -> object:
        """Import a package of lbskel, or the one that exports a public name."""
        if name in _PACKAGES:
            return import_module(f"lbskel.{name}")
        if name in __all__:
            for package in _PACKAGES:
                module = import_module(f"lbskel.{package}")
                if name in module.__all__:
                    globals()[name] = getattr(module, name)
                    return globals()[name]
        raise AttributeError(f"module 'lbskel' has no attribute {name!r}")

    def __dir__() -> list[str]:
        """List the public names, whether they have been used or not."""
        return sorted({*globals(), *__all__})
