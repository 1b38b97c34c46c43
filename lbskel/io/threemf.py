"""3MF, the zip archive of XML of additive manufacturing, through trimesh, which needs lxml and networkx for it.

All objects that the file builds become one mesh, each where it is placed. How much an archive unpacks to is looked at
first. Format: https://3mf.io/spec/
"""

from __future__ import annotations

__all__ = ["read_3mf"]

import io
import zipfile
from importlib.util import find_spec
from pathlib import Path

from lbskel.errors import FormatError, MissingDependency
from lbskel.io.polygon_soup import Polygons
from lbskel.io.scenes import polygons_of_scene
from lbskel.io.text import read_bytes

MOST_BYTES = 2**31  # that an archive may unpack to
MOST_TIMES = 1000  # its own size: XML of numbers packs to a tenth


def read_3mf(path: Path) -> Polygons:
    """The triangles of all objects that a 3MF file builds."""
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
        raise FormatError("not a 3MF archive: it holds no model")
    if unpacked > min(MOST_BYTES, MOST_TIMES * len(data)):
        raise FormatError(f"unpacks to {unpacked:,} bytes from {len(data):,}, which no model does")
    scene = trimesh.load_scene(io.BytesIO(data), file_type="3mf", process=False, maintain_order=True)
    return polygons_of_scene(scene)
