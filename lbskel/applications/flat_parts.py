"""Parts that are patches of the surface, and no limbs: merged into the parts beside them.

Where limbs leave a body side by side, a junction between them may have no more than a patch of the surface around it. A
part with an end of the skeleton is a limb. Another is a patch if its area is less than twice the length of the sum of
its faces' area vectors, as that of anything flatter than a hemisphere; for a ring or a body between limbs, of which the
vectors cancel, it is not.
"""

from __future__ import annotations

__all__ = ["merge_flat_parts"]

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from lbskel.applications.face_graph import FaceGraph
from lbskel.geometry.mesh import Mesh

HEMISPHERE = 2.0  # area of a hemisphere over that of its base; derived, not tuned


def merge_flat_parts(
    labels: NDArray[np.int64], has_end: NDArray[np.bool_], graph: FaceGraph, mesh: Mesh
) -> NDArray[np.int64]:
    """(m,) part of each face; patches, the smallest first, have gone to the parts with the longest common boundary.

    Parameters
    ----------
    labels : (m,) array of int
        Part of each face.
    has_end : (p,) array of bool
        Whether each part has an end of the skeleton.
    graph : FaceGraph
    mesh : Mesh
        Consistently oriented.
    """
    n, (i, j) = len(has_end), graph.pairs.T
    vectors, current = mesh.face_normals * mesh.face_areas[:, None], labels
    lengths = np.maximum(graph.lengths, np.finfo(np.float64).tiny)
    while True:
        area = np.bincount(current, mesh.face_areas, minlength=n)
        total = np.stack([np.bincount(current, axis, minlength=n) for axis in vectors.T], axis=1)
        flat = np.flatnonzero(~has_end & (area < HEMISPHERE * np.linalg.norm(total, axis=1)))
        a, b = current[i], current[j]
        rim = a != b
        ends = np.concatenate([a[rim], b[rim]]), np.concatenate([b[rim], a[rim]])
        border = coo_array((np.tile(lengths[rim], 2), ends), shape=(n, n)).tocsr()
        target, is_used = np.arange(n), np.zeros(n, dtype=bool)
        for part in flat[np.argsort(area[flat], kind="stable")].tolist():
            row = border[[part]]
            if row.nnz and not is_used[[part, beside := int(row.indices[row.data.argmax()])]].any():
                target[part] = beside
                is_used[[part, beside]] = True
        if not is_used.any():
            return current
        current = target[current]
