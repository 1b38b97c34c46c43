"""JSON and NPZ with all that a skeleton holds, from its nodes to its report.

Both have an entry under each of these names; in NPZ the report is JSON text. What is not a finite number is null in
JSON, which has no other word for it.
"""

from __future__ import annotations

__all__ = ["read_json", "read_npz", "skeleton_json", "skeleton_npz"]

import io
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lbskel.errors import FormatError
from lbskel.io.text import array_of, as_integers, read_bytes, read_text
from lbskel.skeleton.skeleton import Skeleton

ZIP_MAGIC = b"PK"


def skeleton_json(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """A skeleton as JSON, a line per entry."""
    entries = {**_arrays(skeleton), "radius_kind": skeleton.radius_kind, "report": skeleton.report}
    lines = ",\n".join(f'"{name}": {_json(value, name)}' for name, value in entries.items())
    return {path: f"{{\n{lines}\n}}\n"}


def skeleton_npz(skeleton: Skeleton, path: Path) -> dict[Path, bytes]:
    """A skeleton as an archive of numpy arrays."""
    buffer = io.BytesIO()
    report = _json(skeleton.report, "report")
    entries = {**_arrays(skeleton), "radius_kind": np.array(skeleton.radius_kind), "report": np.array(report)}
    np.savez_compressed(buffer, **entries)
    return {path: buffer.getvalue()}


def read_json(path: Path) -> Skeleton:
    """The skeleton in a JSON file."""
    try:
        entries = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise FormatError(f"line {error.lineno}: not JSON: {error.msg}") from None
    return _skeleton_of(entries)


def read_npz(path: Path) -> Skeleton:
    """The skeleton in an archive of numpy arrays."""
    data = read_bytes(path)
    if not data.startswith(ZIP_MAGIC):
        raise FormatError("not an archive of numpy arrays")
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        entries: dict[str, Any] = dict(archive)
    if "report" in entries:
        entries["report"] = json.loads(str(entries["report"]))
    if "radius_kind" in entries:
        entries["radius_kind"] = str(entries["radius_kind"])
    return _skeleton_of(entries)


def _arrays(skeleton: Skeleton) -> dict[str, Any]:
    """The arrays of a skeleton by name."""
    names = ("nodes", "edges", "radii", "node_of_vertex", "mean_radii", "anchors")
    return {name: getattr(skeleton, name) for name in names}


def _skeleton_of(entries: Any) -> Skeleton:
    """The skeleton of the entries, of which nodes and edges must be there."""
    if not isinstance(entries, Mapping) or not {"nodes", "edges"} <= entries.keys():
        raise FormatError("not a skeleton: no entries named nodes and edges")
    nodes = array_of(entries["nodes"], "nodes", 3)
    return Skeleton(
        nodes,
        as_integers(array_of(entries["edges"], "edges", 2), "edges"),
        array_of(entries["radii"], "radii") if "radii" in entries else np.full(len(nodes), np.nan),
        as_integers(array_of(entries.get("node_of_vertex", []), "node_of_vertex"), "node_of_vertex"),
        _typed(entries, "radius_kind", str),
        array_of(entries.get("mean_radii", []), "mean_radii"),
        as_integers(array_of(entries.get("anchors", []), "anchors"), "anchors"),
        _typed(entries, "report", dict),
    )


def _typed(entries: Mapping[str, Any], name: str, kind: type) -> Any:
    """The entry, or what a Skeleton has without; a FormatError if it is not of that type."""
    value = entries.get(name, Skeleton.radius_kind if kind is str else {})
    if not isinstance(value, kind):
        raise FormatError(f"{name}: must be a {kind.__name__}, not {type(value).__name__}")
    return value


def _json(value: Any, name: str) -> str:
    """The value as JSON, or a FormatError if it holds what has no place there."""
    try:
        return json.dumps(_plain(value), allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(f"the {name} of the skeleton is not ready for JSON: {error}") from None


def _plain(value: Any) -> Any:
    """The value with numpy's numbers and arrays as Python's, and None for what is not finite."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
