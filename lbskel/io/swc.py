"""SWC, the format of neuron tracings: a line per node with id, type, position, radius and the id of its parent.

Ids begin at 1, every parent precedes its children, each component has one root, with the parent -1, and no comment
follows a node. The type is 1 for a root in the soma: one node, whose ball stands for the soma. It is 0, undefined, for
all other nodes, since the shape does not tell dendrites from axons; so every section has one type, as MorphIO and
NeuroM require. An unknown radius is written as 0, which all readers accept, unlike NaN.

SWC stores trees: every cycle is cut at its thinnest edge, and the edges that were cut are comments ``# cut edge 7 12``,
which other programs ignore and from which :func:`read_swc` restores them. A file may be in other units than the mesh;
the factor is a comment too. Format: Cannon et al. 1998, https://doi.org/10.1016/S0165-0270(98)00091-0; the line
``# Meta`` is that of navis.
"""

from __future__ import annotations

__all__ = ["encode_swc", "read_swc"]

import json
import math
import re
from numbers import Integral
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import depth_first_order

from lbskel.errors import FormatError
from lbskel.geometry.graphs import weighted_graph
from lbskel.io.text import as_integers, content_lines, parse_columns, read_text
from lbskel.skeleton.root import find_roots, is_in_soma
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.spanning_tree import cycle_edges

SOMA, UNDEFINED = 1, 0  # values of the type column
NO_PARENT = -1  # value of the parent column of a root
CUT_EDGE = re.compile(r"#\s*cut edge (\d{1,15}) (\d{1,15})\s*")
RADIUS_KIND = re.compile(r"#\s*radius_kind (.+)")
SCALE = re.compile(r"#\s*positions and radii are multiplied by (\S+)")


def encode_swc(
    skeleton: Skeleton, path: Path, *, root: int | None = None, scale: float = 1.0, units: str | None = None
) -> dict[Path, str]:
    """Encode a skeleton as SWC text, with its cycles cut as :func:`lbskel.to_tree` cuts them.

    Parameters
    ----------
    skeleton : Skeleton
    path : Path
        The path that the file will have.
    root : int, optional
        The node that is the root of its component; by default the first node. The root of any other component is its
        thickest tip. The components are in the order of their roots.
    scale : float
        Factor of the positions and radii in the file, which :func:`read_swc` divides by.
    units : str, optional
        Name of the units of the positions and radii in the file.

    Raises
    ------
    FormatError
        If the root is not a node, the scale is not a positive number, or a scaled position or radius is not finite.
    """
    if not (scale > 0 and math.isfinite(scale)):
        raise FormatError(f"the scale must be a positive number, not {scale}")
    k = len(skeleton.nodes)
    if root is not None and (isinstance(root, bool) or not isinstance(root, Integral) or not 0 <= int(root) < k):
        raise FormatError(f"the root {root} is not a node; the nodes are 0 to {k - 1}")
    is_cut, root = cycle_edges(skeleton), root or 0
    order, parents = _depth_first(skeleton, skeleton.edges[~is_cut], root)
    ids = np.empty(k, dtype=np.int64)
    ids[order] = np.arange(1, k + 1)
    with np.errstate(over="ignore"):
        radii = np.where(np.isnan(skeleton.radii), 0.0, skeleton.radii) * scale
        positions = skeleton.nodes * scale
    for what, values in (("coordinates", positions), ("radii", radii)):
        if not np.isfinite(values).all():
            raise FormatError(f"a scale of {scale} gives infinite {what}; give a smaller one")
    root_kind = SOMA if is_in_soma(skeleton, root) else UNDEFINED
    lines = [f"# radius_kind {' '.join(skeleton.radius_kind.split())}"]
    if units is not None:
        lines.append(f"# Meta: {json.dumps({'units': units})}")
    if scale != 1:
        lines.append(f"# positions and radii are multiplied by {float(scale)!r}")
    if is_cut.any():
        lines.append("# cycles are cut at their thinnest edges, which lbskel restores:")
    lines += [f"# cut edge {start} {end}" for start, end in np.sort(ids[skeleton.edges[is_cut]], axis=1)]
    lines.append("# id type x y z radius parent")
    for node in order.tolist():
        x, y, z = positions[node].tolist()
        kind = root_kind if node == root else UNDEFINED
        parent = NO_PARENT if parents[node] < 0 else ids[parents[node]]
        lines.append(f"{ids[node]} {kind} {x!r} {y!r} {z!r} {radii[node].item()!r} {parent}")
    return {path: "\n".join(lines) + "\n"}


def _depth_first(
    skeleton: Skeleton, edges: NDArray[np.int64], root: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Order the nodes so that each follows its parent; return the order and the parents, -1 for roots."""
    k, label = len(skeleton.nodes), skeleton.component_of_node
    roots = np.append(np.delete(find_roots(skeleton), label[root]), root)
    # An additional node joined to all roots makes the forest one tree, so that one traversal orders it
    from_top = np.stack([np.full(len(roots), k), roots], axis=1)
    pairs = np.concatenate([edges, edges[:, ::-1], from_top])
    order, parents = depth_first_order(weighted_graph(pairs, np.ones(len(pairs)), k + 1), k)
    order = order[1:]
    order = order[np.argsort(label[order] != label[root], kind="stable")]  # the component of the chosen root first
    return order, np.where(parents[:k] == k, NO_PARENT, parents[:k])


def read_swc(path: Path) -> Skeleton:
    """Read a skeleton from SWC: nodes in the order of the lines, with the edges that are stored as comments.

    Where the file was written with a scale, positions and radii are divided by it: they are those of the skeleton that
    was written, up to rounding errors.
    """
    text = read_text(path)
    lines = content_lines(text)
    rows = parse_columns(lines, range(7), "id, type, x, y, z, radius and parent")
    ids, parents = (as_integers(rows[:, column], what, lines.numbers) for column, what in ((0, "ids"), (6, "parents")))
    unique, first = np.unique(ids, return_index=True)
    for row in np.setdiff1d(np.arange(len(ids)), first)[:1]:
        raise FormatError(f"line {lines.numbers[row]}: the id {ids[row]} occurs twice")
    children = np.flatnonzero(parents != NO_PARENT)
    pairs = np.stack([ids[children], parents[children]], axis=1)
    comments = [line.strip() for line in text.splitlines() if line.lstrip().startswith("#")]
    cuts = [[int(end) for end in match.groups()] for match in map(CUT_EDGE.fullmatch, comments) if match]
    sources = [f"line {lines.numbers[child]}: its parent" for child in children] + ["a cut edge: its node"] * len(cuts)
    pairs = np.concatenate([pairs, np.array(cuts, dtype=np.int64).reshape(-1, 2)])
    for row in np.flatnonzero(~np.isin(pairs, ids).all(axis=1))[:1]:
        raise FormatError(f"{sources[row]} {np.setdiff1d(pairs[row], ids)[0]} does not exist")
    kinds = [match.group(1) for match in map(RADIUS_KIND.fullmatch, comments) if match]
    scale = _scale(comments)
    return Skeleton(
        rows[:, 2:5] / scale,
        first[np.searchsorted(unique, pairs)],
        rows[:, 5] / scale,
        radius_kind=next(iter(kinds), Skeleton.radius_kind),
    )


def _scale(comments: list[str]) -> float:
    """Return the factor that a file was written with; 1 if it does not say."""
    for match in filter(None, map(SCALE.fullmatch, comments)):
        try:
            scale = float(match.group(1))
        except ValueError:
            scale = math.nan
        if not (scale > 0 and math.isfinite(scale)):
            raise FormatError(f"the scale must be a positive number, not {match.group(1)}")
        return scale
    return 1.0
