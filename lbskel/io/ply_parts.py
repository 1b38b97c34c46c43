"""A mesh divided into parts as PLY: each face has the number of its part and a color, which viewers show.

The element ``face`` has vertex_indices, ``part``, and red, green, blue. Hues are spread by the golden ratio, so that
parts with near numbers have very different hues.
"""

from __future__ import annotations

__all__ = ["encode_ply_parts", "part_colors"]

import colorsys

import numpy as np
from numpy.typing import NDArray

from lbskel.geometry.mesh import Mesh
from lbskel.io.ply import encode_ply_header

GOLDEN_RATIO = (5**0.5 - 1) / 2
SATURATION, BRIGHTNESS = (0.75, 0.45), (0.95, 0.7)  # of even and odd parts, of even and odd pairs; a choice of style


def part_colors(n_parts: int) -> NDArray[np.uint8]:
    """(p, 3) red, green and blue of each part, from 0 to 255.

    Parameters
    ----------
    n_parts : int
    """
    colors = [
        colorsys.hsv_to_rgb(part * GOLDEN_RATIO % 1, SATURATION[part % 2], BRIGHTNESS[part // 2 % 2])
        for part in range(n_parts)
    ]
    rounded: NDArray[np.uint8] = np.rint(255 * np.array(colors).reshape(-1, 3)).astype(np.uint8)
    return rounded


def encode_ply_parts(mesh: Mesh, part_of_face: NDArray[np.int64]) -> bytes:
    """Encode a mesh as binary PLY in double precision, with the part and a color of each face.

    Parameters
    ----------
    mesh : Mesh
    part_of_face : (m,) array of int
        Number of the part of each face, from 0 on.
    """
    m, colors = len(mesh.faces), part_colors(int(part_of_face.max()) + 1)
    rows = np.empty(m, dtype=[("size", "u1"), ("corners", "<i4", 3), ("part", "<i4"), ("color", "u1", 3)])
    rows["size"], rows["corners"], rows["part"], rows["color"] = 3, mesh.faces, part_of_face, colors[part_of_face]
    properties = ["list uchar int vertex_indices", "int part", "uchar red", "uchar green", "uchar blue"]
    vertex = (len(mesh.vertices), ["double x", "double y", "double z"])
    header = encode_ply_header("binary_little_endian", [], {"vertex": vertex, "face": (m, properties)})
    return header.encode() + mesh.vertices.astype("<f8").tobytes() + rows.tobytes()
