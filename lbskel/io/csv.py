"""CSV: the nodes of a skeleton in one file, ``id,x,y,z,radius``, its edges in a second file, ``source,target``.

The second file is named after the first: ``hand.csv`` and ``hand_edges.csv``. Ids are 0-based.
"""

from __future__ import annotations

__all__ = ["edges_path", "encode_csv", "read_csv"]

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.io.text import as_integers, read_text
from lbskel.skeleton.skeleton import Skeleton

NODE_COLUMNS, EDGE_COLUMNS = ("id", "x", "y", "z", "radius"), ("source", "target")


def edges_path(path: Path) -> Path:
    """Return the path of the file of edges that belongs to a file of nodes."""
    return path.with_name(f"{path.stem}_edges{path.suffix}")


def encode_csv(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """Encode a skeleton as two CSV files; the file of nodes is at ``path``."""
    numbers = np.column_stack([skeleton.nodes, skeleton.radii]).tolist()
    nodes = [",".join(map(repr, [index, *row])) for index, row in enumerate(numbers)]
    edges = [f"{start},{end}" for start, end in skeleton.edges.tolist()]
    return {
        path: "\n".join([",".join(NODE_COLUMNS), *nodes, ""]),
        edges_path(path): "\n".join([",".join(EDGE_COLUMNS), *edges, ""]),
    }


def read_csv(path: Path) -> Skeleton:
    """Read a skeleton from two CSV files; ids may be any distinct integers, other columns are ignored."""
    nodes, lines = _read_columns(read_text(path), NODE_COLUMNS)
    ids = as_integers(nodes[:, 0], "ids", lines)
    unique, first = np.unique(ids, return_index=True)
    for row in np.setdiff1d(np.arange(len(ids)), first)[:1]:
        raise FormatError(f"line {lines[row]}: the id {ids[row]} occurs twice")
    try:
        ends, lines = _read_columns(read_text(edges_path(path)), EDGE_COLUMNS)
        edges = as_integers(ends, "edges", lines)
        for row in np.flatnonzero(~np.isin(edges, ids).all(axis=1))[:1]:
            raise FormatError(f"line {lines[row]}: there is no node with the id {np.setdiff1d(edges[row], ids)[0]}")
    except FormatError as error:
        raise FormatError(f"its edges, {edges_path(path)}: {error}") from None
    return Skeleton(nodes[:, 1:4], first[np.searchsorted(unique, edges)], nodes[:, 4])


def _read_columns(text: str, names: tuple[str, ...]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Read the named columns, (n, len(names)), an empty radius as NaN, and the line number of each row."""
    reader = csv.DictReader(text.splitlines(), skipinitialspace=True)
    if not set(names) <= set(reader.fieldnames or ()):
        raise FormatError(f"line 1: must name the columns {','.join(names)}")
    rows, lines = [], []
    for row in reader:
        try:
            rows.append([float(row[name] or ("nan" if name == "radius" else "")) for name in names])
        except ValueError:
            raise FormatError(f"line {reader.line_num}: numbers expected for {','.join(names)}") from None
        lines.append(reader.line_num)
    return np.array(rows).reshape(-1, len(names)), np.array(lines, dtype=np.int64)
