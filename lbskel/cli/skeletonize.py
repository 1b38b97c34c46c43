"""``lbskel skeletonize INPUT... -o OUT``: the skeletons of meshes, with a report and a picture."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
import sys
import time
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.flow import PRESETS
from lbskel.errors import FormatError, LbskelError
from lbskel.io import FORMATS, MESH_READERS, read_mesh, write_safely, write_skeleton
from lbskel.operators import OPERATORS
from lbskel.pipeline.component import RESOLUTIONS, TIPS
from lbskel.pipeline.stages import skeletonize
from lbskel.preprocess import PREPARATIONS
from lbskel.skeleton.joining import join_components
from lbskel.skeleton.skeleton import Skeleton
from lbskel.solvers import SOLVERS


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser("skeletonize", help="make the curve skeleton of a mesh", description=__doc__)
    parser.add_argument("input", nargs="+", help=f"meshes: {', '.join(MESH_READERS)}")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help=f"skeleton to write ({', '.join(FORMATS)}); a folder gets a .swc for each input",
    )
    parser.add_argument("--preset", default="flow", choices=PRESETS, help="parameters of the contraction (%(default)s)")
    parser.add_argument("--operator", choices=OPERATORS, help="discrete Laplacian, instead of the preset's")
    parser.add_argument("--energy", choices=ENERGIES, help="what each step minimizes, instead of the preset's")
    parser.add_argument("--solver", choices=SOLVERS, help="of the linear systems, instead of the preset's")
    parser.add_argument(
        "--resolution", default="auto", choices=RESOLUTIONS, help="full: contract every vertex (%(default)s)"
    )
    parser.add_argument(
        "--prune", type=float, default=1.5, metavar="RADII", help="how far an end branch must stand out (%(default)s)"
    )
    parser.add_argument("--tips", default="inside", choices=TIPS, help="where branches end (%(default)s)")
    parser.add_argument("--nodes", type=int, metavar="N", help="number of nodes to have")
    parser.add_argument(
        "--root",
        type=_place,
        metavar="PLACE",
        help="first node, the root in swc: a vertex's index, or a point as X,Y,Z",
    )
    parser.add_argument(
        "--anchor", type=_place, action="append", default=[], metavar="PLACE", help="have a node there; may be repeated"
    )
    parser.add_argument(
        "--preprocess",
        default="auto",
        metavar="HOW",
        help=f"what is done to the mesh first: {', '.join(PREPARATIONS)}, steps, or a .toml file (%(default)s)",
    )
    parser.add_argument("--join", action="store_true", help="join the graphs of several components to one")
    parser.add_argument("--picture", metavar="PNG", help="draw mesh and skeleton; a folder, where inputs are several")
    parser.add_argument("--report", metavar="JSON", help="write the full report; a folder, where inputs are several")
    parser.add_argument("--time-limit", type=float, metavar="SECONDS", help="after which the best so far is taken")
    parser.add_argument("--profile", action="store_true", help="print the seconds and the memory of each stage")
    parser.add_argument("--json", action="store_true", help="print the full report as JSON, one line per input")
    parser.add_argument("--cut-cycles", action="store_true", help="let swc, which holds trees only, cut each cycle")
    parser.add_argument("--force", action="store_true", help="replace files that exist")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.set_defaults(run=run)


def _place(text: str) -> int | list[float]:
    """The index of a vertex, or a point."""
    return [float(part) for part in text.split(",")] if "," in text else int(text)


@dataclass(frozen=True)
class _Job:
    """One input and the files to be made of it."""

    mesh: Path
    skeleton: Path
    picture: Path | None
    report: Path | None

    def outputs(self) -> list[tuple[Path | None, Collection[str]]]:
        """Each file to write, where it is wanted, with the extensions that it may have."""
        return [(self.skeleton, FORMATS), (self.picture, ("png",)), (self.report, ("json",))]


def run(arguments: argparse.Namespace) -> int:
    """Every input in turn; one that fails does not stop the rest."""
    jobs = _jobs(arguments)
    codes = []
    for job in jobs:
        try:
            codes.append(_run(job, arguments))
        except LbskelError as error:
            where = "" if str(job.mesh) in str(error) else f"{job.mesh}: "
            print(f"lbskel: {where}{' '.join(str(error).splitlines())}", file=sys.stderr)
            codes.append(2)
    return max(codes)


def _jobs(arguments: argparse.Namespace) -> list[_Job]:
    """What to make of what, with all that would be overwritten refused before any work is done."""
    inputs = [Path(name) for name in arguments.input]
    are_several = len(inputs) > 1
    jobs = [
        _Job(
            mesh=mesh,
            skeleton=_output(arguments.output, mesh, ".swc", are_several),
            picture=_output(arguments.picture, mesh, ".png", are_several) if arguments.picture else None,
            report=_output(arguments.report, mesh, ".json", are_several) if arguments.report else None,
        )
        for mesh in inputs
    ]
    outputs = [(path, kinds) for job in jobs for path, kinds in job.outputs() if path is not None]
    if len({path for path, _ in outputs}) < len(outputs):
        raise FormatError("two outputs have the same name; give inputs of different names, or make them one by one")
    for path, kinds in outputs:
        if path.suffix.lower().lstrip(".") not in kinds:
            raise FormatError(f"{path}: the name must end in one of: {', '.join(kinds)}")
        if not path.parent.is_dir():
            raise FormatError(f"{path}: the folder {path.parent} does not exist")
        if path.exists() and not arguments.force:
            raise FormatError(f"{path} exists already; give --force to replace it")
    return jobs


def _output(given: str, mesh: Path, suffix: str, are_several: bool) -> Path:
    """The path asked for, or one in the folder asked for."""
    path = Path(given)
    if path.is_dir():
        return path / (mesh.stem + suffix)
    if are_several:
        raise FormatError(f"{path} is not a folder; several inputs need one")
    return path


def _run(job: _Job, arguments: argparse.Namespace) -> int:
    with _Bar(job.mesh.name, arguments.quiet or arguments.json) as bar:
        bar.show("read")
        began = time.perf_counter()
        mesh = read_mesh(job.mesh)
        reading = time.perf_counter() - began
        skeleton = skeletonize(
            mesh,
            preset=arguments.preset,
            operator=arguments.operator,
            energy=arguments.energy,
            solver=arguments.solver,
            resolution=arguments.resolution,
            preprocess=arguments.preprocess,
            prune=arguments.prune,
            tips=arguments.tips,
            anchors=arguments.anchor,
            root=arguments.root,
            n_nodes=arguments.nodes,
            on_stage=bar.show,
            time_limit=arguments.time_limit,
            profile=arguments.profile,
        )
    if arguments.join:
        skeleton = join_components(skeleton)
    write_skeleton(job.skeleton, skeleton, force=arguments.force, cut_cycles=arguments.cut_cycles)
    if job.picture is not None:
        from lbskel.visualization import picture

        picture(mesh, skeleton, job.picture, force=arguments.force)
    skeleton.report["seconds"]["read"] = reading
    report = {"mesh": str(job.mesh), **skeleton.report}
    if job.report is not None:
        write_safely(job.report, json.dumps(report, indent=1) + "\n", force=arguments.force)
    if arguments.json:
        print(json.dumps(report), flush=True)
    elif not arguments.quiet:
        print(_summary(job, skeleton), flush=True)
    return 0 if skeleton.report["passed"] else 1


def _summary(job: _Job, skeleton: Skeleton) -> str:
    """The report in a few lines that a person reads."""
    report = skeleton.report
    parts = report["components"]
    size = report["input"]
    lines = [
        f"{job.mesh}: {size['vertices']:,} vertices, {size['faces']:,} faces, {size['components']} component(s)",
        *(f"  note      {note}" for note in report["notes"]),
        f"  skeleton  {len(skeleton.nodes)} nodes, {len(skeleton.tips)} tips, {len(skeleton.junctions)} junctions, "
        f"{skeleton.cycle_rank} cycles, {skeleton.radius_kind} radii",
    ]
    for part in parts:
        genus = "open, topology not checked" if part["genus"] is None else f"genus {part['genus']}"
        lines.append(
            f"  component {part['faces']:,} faces, {genus}: {part['cycle_rank']} cycles, "
            f"{100 * part['length_inside']:.1f} % inside; {len(part['steps'])} steps, {part['status']}"
        )
        lines.extend(f"  note      {note}" for note in part["notes"])
        lines.extend(f"  failed    {name}" for name, passed in part["checks"].items() if passed is False)
    scored = report["score"]
    faults = [
        f"{name} {scored['measures'][name]:.3g}" for name, v in scored["verdicts"].items() if v in ("warn", "fail")
    ]
    lines.append(f"  score     {scored['verdict']}{': ' if faults else ''}{', '.join(faults)}")
    for stage, seconds in report["seconds"].items() if "megabytes" in report else ():
        peak = report["megabytes"].get(stage)
        lines.append(f"  {stage:<14}{seconds:8.2f} s" + (f"{peak:8.0f} MB at most" if peak else ""))
    lines.append(f"  wrote     {job.skeleton} in {sum(report['seconds'].values()):.1f} s")
    return "\n".join(lines)


class _Bar:
    """A line on the terminal that tells the stage; nothing where there is no terminal."""

    def __init__(self, name: str, is_quiet: bool):
        self._name = name
        self._is_quiet = is_quiet or not sys.stderr.isatty()

    def __enter__(self) -> _Bar:
        from tqdm import tqdm

        self._bar = tqdm(desc=self._name, bar_format="{desc} {elapsed}", leave=False, disable=self._is_quiet)
        return self

    def show(self, stage: str) -> None:
        self._bar.set_description_str(f"{self._name}: {stage}")

    def __exit__(self, *_: object) -> None:
        self._bar.close()
