"""``lbskel skeletonize MESH... -o OUT``: the skeletons of meshes, with a report and a picture."""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import json
import math
import os
import sys
import time
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any

from lbskel.cli.html_option import add_html_option, write_page
from lbskel.cli.options import (
    add_command,
    add_force_option,
    add_skeleton_options,
    add_swc_options,
    refuse_unwritable,
    skeleton_options,
)
from lbskel.cli.terminal import message_of, tell, with_options
from lbskel.errors import FormatError, counted, were
from lbskel.io import FORMATS, MESH_READERS, POINT_READERS, as_shape, write_safely, write_skeleton
from lbskel.io.csv import edges_path
from lbskel.io.skeleton_io import require_writable
from lbskel.pipeline.cycles import cut_cycles
from lbskel.pipeline.stages import skeletonize
from lbskel.skeleton.skeleton import Skeleton

SLASHES = tuple({"/", os.sep})  # at the end of the name of a folder
MAX_BODIES = 5  # bodies with a line of their own in the summary, the rest share one; a guess at what a person reads
# Share of the faces of all bodies below which a body has no line of its own in the summary. A guess.
MIN_BODY_SHARE = 0.01


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel skeletonize``."""
    parser = add_command(
        subparsers,
        "skeletonize",
        "make the curve skeleton of a mesh or a point cloud",
        details="Exit code 0 where the score is pass or warn, 1 where it is fail, 2 on bad input.",
        example="lbskel skeletonize meshes/dinosaur.ply -o dinosaur.swc --picture dinosaur.png",
        json="print the full report as JSON, one line per input",
    )
    parser.add_argument(
        "input", nargs="+", metavar="MESH", help=f"meshes or point clouds: {', '.join(MESH_READERS | POINT_READERS)}"
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help=f"skeleton to write ({', '.join(FORMATS)}); a folder gets a .swc for each input; NAME/ is made",
    )
    parser.add_argument("--picture", metavar="PNG", help="draw mesh and skeleton; a folder if there are several inputs")
    add_html_option(parser, "; a folder if there are several inputs")
    parser.add_argument("--report", metavar="JSON", help="write the full report; a folder if there are several inputs")
    parser.add_argument("--profile", action="store_true", help="print the seconds and the memory of each stage")
    add_force_option(parser)
    parser.add_argument(
        "--memory-limit", type=float, metavar="MB", help="refuse what takes more memory (what the machine has free)"
    )
    add_swc_options(parser)
    add_skeleton_options(parser)
    parser.set_defaults(run=run)


@dataclass(frozen=True)
class _Job:
    """One input and the files to write."""

    mesh: Path
    skeleton: Path
    picture: Path | None
    html: Path | None
    report: Path | None

    def outputs(self) -> list[tuple[Path | None, Collection[str]]]:
        """List the files to write, with the extensions that each may have."""
        edges = edges_path(self.skeleton) if _format(self.skeleton) == "csv" else None
        return [
            (self.skeleton, FORMATS),
            (edges, ("csv",)),
            (self.picture, ("png",)),
            (self.html, ("html",)),
            (self.report, ("json",)),
        ]


def run(arguments: argparse.Namespace) -> int:
    """Make the skeleton of every input in turn; an input that fails does not stop the rest."""
    jobs = _jobs(arguments)
    codes = []
    for job in jobs:
        try:
            codes.append(_run(job, arguments))
        except BrokenPipeError:
            raise
        except Exception as error:
            where = "" if str(job.mesh) in str(error) else f"{job.mesh}: "
            message = with_options(message_of(error), arguments)
            print(f"lbskel: {where}{' '.join(message.splitlines())}", file=sys.stderr)
            codes.append(2)
    return max(codes)


def _jobs(arguments: argparse.Namespace) -> list[_Job]:
    """List the files to write for each input, and refuse what cannot be written before any work is done."""
    inputs = [Path(name) for name in arguments.input]
    are_several = len(inputs) > 1
    jobs = [
        _Job(
            mesh=mesh,
            skeleton=_output(arguments.output, mesh, ".swc", are_several),
            picture=_output(arguments.picture, mesh, ".png", are_several) if arguments.picture else None,
            html=_output(arguments.html, mesh, ".html", are_several) if arguments.html else None,
            report=_output(arguments.report, mesh, ".json", are_several) if arguments.report else None,
        )
        for mesh in inputs
    ]
    outputs = [(path, kinds) for job in jobs for path, kinds in job.outputs() if path is not None]
    [(path, n_times)] = Counter(path for path, _ in outputs).most_common(1)
    if n_times > 1:
        way_out = "give inputs of different names, or run them one by one" if are_several else "give another name"
        raise FormatError(f"{path}: two outputs have the same name; {way_out}")
    for given in filter(None, (arguments.output, arguments.picture, arguments.html, arguments.report)):
        _make_folder(given)
    refuse_unwritable(outputs, arguments.force, inputs)
    for name in sorted({_format(job.skeleton) for job in jobs}):
        require_writable(name, scale=arguments.scale, units=arguments.units)
    if arguments.picture:
        from lbskel.visualization.rendering import require_matplotlib

        require_matplotlib()
    if arguments.html:
        from lbskel.visualization.interactive import require_plotly

        require_plotly()
    return jobs


def _make_folder(given: str) -> None:
    """Make the folder that a name with a slash at its end names, in a folder that exists."""
    if given.endswith(SLASHES):
        try:
            Path(given).mkdir(exist_ok=True)
        except OSError as error:
            raise FormatError(f"{given}: the folder cannot be made: {error.strerror}; name another") from None


def _format(path: Path) -> str:
    """Return the extension in lower case, without its dot."""
    return path.suffix.lower().removeprefix(".")


def _output(given: str, mesh: Path, suffix: str, are_several: bool) -> Path:
    """Return the path given, or the file in the folder given."""
    path = Path(given)
    if path.is_dir() or given.endswith(SLASHES):
        return path / (mesh.stem + suffix)
    if are_several:
        raise FormatError(f"{path} is not a folder; several inputs need one: make it first, or write {path}/")
    return path


def _run(job: _Job, arguments: argparse.Namespace) -> int:
    def show(stage: str) -> None:
        arguments.on_stage(f"{job.mesh.name}: {stage}")

    show("read")
    began = time.perf_counter()
    mesh = as_shape(job.mesh)
    reading = time.perf_counter() - began
    skeleton = skeletonize(
        mesh,
        **skeleton_options(arguments),
        on_stage=show,
        time_limit=arguments.time_limit,
        memory_limit=arguments.memory_limit,
        profile=arguments.profile,
    )
    skeleton, _ = cut_cycles(skeleton, tree=arguments.tree, extension=_format(job.skeleton))
    write_skeleton(job.skeleton, skeleton, force=arguments.force, scale=arguments.scale, units=arguments.units)
    seconds = {**skeleton.report["seconds"], "read": reading}
    report = {"mesh": str(job.mesh), **skeleton.report, "seconds": seconds}
    if job.report is not None:
        write_safely(job.report, json.dumps(report, indent=1) + "\n", force=arguments.force)
    if job.picture is not None:
        show("picture")
        from lbskel.visualization import picture

        picture(mesh, skeleton, job.picture, force=arguments.force)
    if job.html is not None:
        show("page")
        write_page(job.html, mesh, skeleton, arguments, title=job.mesh.name)
    tell(arguments, _summary(job, skeleton, report), report)
    return 0 if skeleton.report["passed"] else 1


def _summary(job: _Job, skeleton: Skeleton, report: dict[str, Any]) -> str:
    """Sum up the report in a few lines."""
    size = report["input"]
    n_vertices, n_faces = size["vertices"], size["faces"]
    given = f"{counted(n_vertices, 'vertex')}, {counted(n_faces, 'face')}" if n_faces else counted(n_vertices, "point")
    lines = [
        f"{job.mesh}: {given}, {counted(size['components'], 'component')}",
        *(f"  note      {note}" for note in (*report["notes"], *_edits(report))),
        f"  skeleton  {counted(len(skeleton.nodes), 'node')}, {counted(len(skeleton.tips), 'tip')}, "
        f"{counted(len(skeleton.junctions), 'junction')}, {counted(skeleton.cycle_rank, 'cycle')}, "
        f"{skeleton.radius_kind} radii",
    ]
    lines.extend(_bodies(report["components"]))
    scored = report["score"]
    faults = [
        f"{name} {scored['measures'][name]:.3g}" for name, v in scored["verdicts"].items() if v in ("warn", "fail")
    ]
    lines.append(f"  score     {scored['verdict']}{': ' if faults else ''}{', '.join(faults)}")
    if scored["verdict"] == "fail":
        has_map = "node_of_vertex" not in FORMATS[_format(job.skeleton)].loses
        mesh, made, page = (quote(str(path)) for path in (job.mesh, job.skeleton, job.skeleton.with_suffix(".html")))
        given, again = (f" --skeleton {made}", "") if has_map else ("", " with the same options")
        view = f"lbskel view {mesh}{given} -o {page}{again}"
        lines.append(f"  next      {view} shows where; lbskel check {mesh} tells whether the mesh is why")
    if scored["verdict"] in ("warn", "fail") and size["faces"] and _was_smoothed_by_auto(report["preprocess"]):
        lines.append("  next      the surface is rough: --preprocess scan refines and smooths it in another way")
    for stage, seconds in report["seconds"].items() if "megabytes" in report else ():
        peak = report["megabytes"].get(stage)
        lines.append(f"  {stage:<24}{seconds:8.2f} s" + (f"{peak:8.0f} MB at most" if peak else ""))
    lines.append(f"  wrote     {job.skeleton} in {sum(report['seconds'].values()):.1f} s")
    return "\n".join(lines)


def _edits(report: dict[str, Any]) -> list[str]:
    """Tell of the loops that were opened and the components that were joined, which no component has a line for."""
    notes = []
    if n_opened := report["loops_opened"]:
        notes.append(f"{were(n_opened, 'short loop')} opened; --min-loop 0 keeps them")
    if n_joined := report["pieces_joined"]:
        gaps = [math.dist(*ends) for ends in report.get("joining_edges", ())]
        longest = f", by edges of at most {max(gaps):.4g} in the units of the mesh" if len(gaps) == n_joined else ""
        notes.append(f"{were(n_joined, 'gap')} closed between components{longest}; --join none keeps them")
    return notes


def _was_smoothed_by_auto(preprocess: dict[str, Any]) -> bool:
    """Whether the automatic preprocessing found noise."""
    return preprocess.get("pipeline") == "auto" and any(step["step"] == "smooth_noise" for step in preprocess["steps"])


def _bodies(bodies: list[dict[str, Any]]) -> list[str]:
    """Write a line for each of the largest bodies and its notes, and one line for all others."""
    lines = []
    by_size = sorted(bodies, key=lambda body: -body["faces"])
    n_crumb = MIN_BODY_SHARE * sum(body["faces"] for body in bodies)
    n_shown = max(1, sum(body["faces"] >= n_crumb for body in by_size[:MAX_BODIES]))
    for body in by_size[:n_shown]:
        genus = "open or non-manifold, topology not checked" if body["genus"] is None else f"genus {body['genus']}"
        lines.append(
            f"  component {counted(body['faces'], 'face')}, {genus}: {counted(body['cycle_rank'], 'cycle')}; "
            f"{counted(len(body['steps']), 'step')}, {body['status']}"
        )
        lines.extend(f"  note      {note}" for note in body["notes"])
    if others := by_size[n_shown:]:
        n_faces = sum(body["faces"] for body in others)
        lines.append(f"  component {len(others)} more of {counted(n_faces, 'face')} together")
    return lines
