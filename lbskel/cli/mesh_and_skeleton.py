"""The input that commands on a mesh and its skeleton have in common: MESH, and its skeleton from a file or computed."""

from __future__ import annotations

__all__ = ["add_input", "mesh_and_skeleton", "skeleton_of"]

import argparse
import sys
from collections.abc import Collection
from pathlib import Path

from lbskel.cli.options import add_skeleton_options, read_surface, skeleton_options
from lbskel.errors import MeshError, UnknownChoice, counted
from lbskel.geometry.mesh import Mesh, PointCloud
from lbskel.io import FORMATS, MESH_READERS, read_skeleton
from lbskel.pipeline.options import PAGE_OPTIONS
from lbskel.pipeline.stages import skeletonize
from lbskel.skeleton.skeleton import Skeleton


def add_input(parser: argparse.ArgumentParser) -> None:
    """Add MESH, ``--skeleton``, and the options with which a skeleton is made."""
    parser.add_argument("mesh", metavar="MESH", help=f"mesh: {', '.join(MESH_READERS)}")
    stored = [name for name, entry in FORMATS.items() if "node_of_vertex" not in entry.loses]
    parser.add_argument(
        "--skeleton",
        metavar="FILE",
        help=f"skeleton of the mesh with its vertex map, by lbskel skeletonize ({', '.join(stored)}), in place of one "
        "made with the options below",
    )
    add_skeleton_options(parser)


def mesh_and_skeleton(arguments: argparse.Namespace) -> tuple[Mesh, Skeleton]:
    """Read the mesh, and read or make its skeleton.

    Raises
    ------
    MeshError
        If the skeleton has no map of the vertices of this mesh.
    UnknownChoice
        If a skeleton is given and an option with which one is made.
    """
    mesh = read_surface(arguments.mesh)
    skeleton = skeleton_of(mesh, arguments, is_shown=bool(getattr(arguments, "html", None)))
    if len(skeleton.node_of_vertex) != len(mesh.vertices):
        raise MeshError(
            f"{arguments.skeleton}: maps {counted(len(skeleton.node_of_vertex), 'vertex')} to its nodes, and "
            f"{arguments.mesh} has {len(mesh.vertices):,}; write the skeleton of this mesh as json, npz, ply or vtp, "
            "which store the map"
        )
    return mesh, skeleton


def skeleton_of(shape: Mesh | PointCloud, arguments: argparse.Namespace, *, is_shown: bool) -> Skeleton:
    """Read the skeleton, or make it with the options given, tell its stages, and warn of one that fails its score.

    Raises
    ------
    UnknownChoice
        If a skeleton is given and an option with which one is made, but for those that a page needs where it is shown.
    """
    if arguments.skeleton:
        _refuse_options_without_effect(arguments, PAGE_OPTIONS if is_shown else ())
        return read_skeleton(arguments.skeleton)
    name = Path(arguments.mesh).name
    skeleton = skeletonize(
        shape,
        **skeleton_options(arguments),
        on_stage=lambda stage: arguments.on_stage(f"{name}: {stage}"),
        time_limit=arguments.time_limit,
    )
    if not skeleton.report["passed"]:
        print(
            f"lbskel: warning: the skeleton of {name} fails its score; lbskel skeletonize tells which measures",
            file=sys.stderr,
        )
    return skeleton


def _refuse_options_without_effect(arguments: argparse.Namespace, used: Collection[str]) -> None:
    """Raise UnknownChoice for an option of a skeleton to be made that is given and not used."""
    parser = argparse.ArgumentParser()
    add_skeleton_options(parser)
    for name, default in vars(parser.parse_args([])).items():
        if getattr(arguments, name) != default and name not in used:
            option = "nodes" if name == "n_nodes" else name.replace("_", "-")
            raise UnknownChoice(
                f"--{option} has no effect on a skeleton that is made already; leave out --{option}, or --skeleton "
                f"{arguments.skeleton}"
            )
