"""The command ``python -m lbskel.shapes FOLDER``, which writes the example meshes into a folder."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from lbskel.io import write_mesh
from lbskel.shapes.catalog import make

# File names, the stem being the name of the shape, and keyword arguments of make().
EXAMPLES: dict[str, dict[str, Any]] = {
    "dinosaur.ply": {"n_vertices": 3500},
    "hand.ply": {"n_vertices": 2500},
    "octopus.ply": {"n_vertices": 3000, "noise": 0.25},
    "knot.off": {"n_vertices": 2500},
    "ladder.obj": {"n_vertices": 2500},
    "tree.stl": {"n_vertices": 2500},
}


def main(folder: Path) -> None:
    """Write all of EXAMPLES into a folder, which is created if needed, and print a line for each."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, options in EXAMPLES.items():
        shape = make(Path(name).stem, **options)
        write_mesh(folder / name, shape.mesh, force=True)
        print(f"{folder / name}: {shape.mesh}, genus {shape.truth.genus}, {shape.truth.n_tips} tips")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m lbskel.shapes", description="Write the example meshes.")
    parser.add_argument("folder", type=Path)
    main(parser.parse_args().folder)
