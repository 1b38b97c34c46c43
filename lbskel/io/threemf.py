"""3MF, the zip archive of XML of additive manufacturing, read through trimesh, which needs lxml and networkx for it.

All objects of the build are joined into one mesh with their transforms applied. The unpacked size of the archive is
checked before it is unpacked.
Format: https://3mf.io/spec/
"""

from __future__ import annotations

__all__ = ["read_3mf"]

import io
import zipfile
from importlib.util import find_spec
from pathlib import Path

from lbskel.errors import FormatError, MissingDependency
from lbskel.io.polygon_soup import PolygonSoup
from lbskel.io.scenes import polygons_from_scene
from lbskel.io.text import read_bytes

MAX_UNPACKED_BYTES = 2**31  # upper bound on the unpacked size of an archive, in bytes; a guess
# Upper bound on the unpacked size divided by the size of the archive; a guess, 100 times the ratio of XML of numbers
MAX_COMPRESSION_RATIO = 1000


def read_3mf(path: Path) -> PolygonSoup:
    """Read the triangles of all objects that a 3MF file builds."""
    for package in ("lxml", "networkx"):
        if find_spec(package) is None:
            raise MissingDependency(package, "3mf", "reading 3mf")
    import trimesh

    data = read_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
            models = [name for name in archive.namelist() if name.lower().endswith(".model")]
    except zipfile.BadZipFile as error:
        raise FormatError(f"not a 3MF archive: {error}; is the file truncated?") from None
    if not models:
        raise FormatError("not a 3MF archive: it has no model")
    limit = min(MAX_UNPACKED_BYTES, MAX_COMPRESSION_RATIO * len(data))
    if unpacked > limit:
        raise FormatError(f"would unpack from {len(data):,} to {unpacked:,} bytes, more than the limit of {limit:,}")
    scene = trimesh.load_scene(io.BytesIO(data), file_type="3mf", process=False, maintain_order=True)
    return polygons_from_scene(scene)
