"""JSON and NPZ, the two formats that keep every field of a skeleton, its report included.

Both have one entry per field of Skeleton, of the same name; in NPZ the report is JSON text. JSON has no NaN and no
infinity, so both are written as null.
"""

from __future__ import annotations

__all__ = ["encode_json", "encode_npz", "read_json", "read_npz"]

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lbskel.errors import FormatError
from lbskel.geometry.arrays import to_builtin
from lbskel.io.text import as_floats, as_integers, read_bytes, read_text
from lbskel.skeleton.skeleton import Skeleton

ZIP_MAGIC = b"PK"


def encode_json(skeleton: Skeleton, path: Path) -> dict[Path, str]:
    """Encode a skeleton as JSON, one line per entry."""
    entries = {**_arrays(skeleton), "radius_kind": skeleton.radius_kind, "report": skeleton.report}
    lines = ",\n".join(f'"{name}": {_dump(value, name)}' for name, value in entries.items())
    return {path: f"{{\n{lines}\n}}\n"}


def encode_npz(skeleton: Skeleton, path: Path) -> dict[Path, bytes]:
    """Encode a skeleton as a compressed archive of numpy arrays."""
    buffer = io.BytesIO()
    report = _dump(skeleton.report, "report")
    entries: dict[str, Any] = {
        **_arrays(skeleton),
        "radius_kind": np.array(skeleton.radius_kind),
        "report": np.array(report),
    }
    np.savez_compressed(buffer, **entries)
    return {path: buffer.getvalue()}


def read_json(path: Path) -> Skeleton:
    """Read a skeleton from JSON."""
    try:
        entries = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise FormatError(f"line {error.lineno}: not JSON: {error.msg}") from None
    return _skeleton_from_entries(entries)


def read_npz(path: Path) -> Skeleton:
    """Read a skeleton from an archive of numpy arrays."""
    data = read_bytes(path)
    if not data.startswith(ZIP_MAGIC):
        raise FormatError("not an archive of numpy arrays")
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        entries: dict[str, Any] = dict(archive)
    if "report" in entries:
        entries["report"] = json.loads(str(entries["report"]))
    if "radius_kind" in entries:
        entries["radius_kind"] = str(entries["radius_kind"])
    return _skeleton_from_entries(entries)


def _arrays(skeleton: Skeleton) -> dict[str, NDArray[Any]]:
    """Return the array fields of a skeleton by name."""
    names = ("nodes", "edges", "radii", "node_of_vertex", "mean_radii", "anchors")
    return {name: getattr(skeleton, name) for name in names}


def _skeleton_from_entries(entries: Any) -> Skeleton:
    """Build a skeleton from the entries of a file, of which nodes and edges are required."""
    if not isinstance(entries, Mapping) or not {"nodes", "edges"} <= entries.keys():
        raise FormatError("not a skeleton: no entries named nodes and edges")
    nodes = as_floats(entries["nodes"], "nodes", 3)
    return Skeleton(
        nodes,
        as_integers(as_floats(entries["edges"], "edges", 2), "edges"),
        as_floats(entries["radii"], "radii") if "radii" in entries else np.full(len(nodes), np.nan),
        as_integers(as_floats(entries.get("node_of_vertex", []), "node_of_vertex"), "node_of_vertex"),
        _typed_entry(entries, "radius_kind", str),
        as_floats(entries.get("mean_radii", []), "mean_radii"),
        as_integers(as_floats(entries.get("anchors", []), "anchors"), "anchors"),
        _typed_entry(entries, "report", dict),
    )


def _typed_entry(entries: Mapping[str, Any], name: str, kind: type) -> Any:
    """Return an entry, or the default of Skeleton if it is missing; a FormatError if it has another type."""
    value = entries.get(name, Skeleton.radius_kind if kind is str else {})
    if not isinstance(value, kind):
        raise FormatError(f"{name}: must be a {kind.__name__}, not {type(value).__name__}")
    return value


def _dump(value: Any, name: str) -> str:
    """Convert a value to JSON text; a FormatError if it cannot be represented."""
    try:
        return json.dumps(to_builtin(value), allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(f"the {name} of the skeleton cannot be written as JSON: {error}") from None
