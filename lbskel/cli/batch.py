"""``lbskel batch MESH... -o FOLDER``: the skeletons of many meshes, on this machine or on a Dask cluster.

Inputs whose content and options have not changed since the last batch are not done again.
"""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import glob
import json
import sys
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lbskel.cli.options import add_command, add_skeleton_options, add_swc_options, skeleton_options
from lbskel.cli.terminal import with_options
from lbskel.errors import FormatError, counted
from lbskel.io import FORMATS
from lbskel.pipeline.batch import BatchStatus, Record, skeletonize_many
from lbskel.pipeline.batch.records import MANIFEST, SUMMARY, written


def add_parser(subparsers: Any) -> None:
    """Add ``lbskel batch``."""
    parser = add_command(
        subparsers,
        "batch",
        "make the curve skeletons of many meshes",
        details="A mesh whose content and options have not changed since the last batch is not done again. "
        "Exit code 0 where every score is pass or warn, 1 where one is fail, 2 where a mesh has no skeleton.",
        example="lbskel batch 'data/**/*.ply' -o skeletons --format swc --picture",
        json="print the record of each input as JSON, one line each",
    )
    parser.add_argument("input", nargs="+", metavar="MESH", help="meshes, or patterns such as 'data/**/*.ply'")
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help=f"gets {MANIFEST} and {SUMMARY} too")
    parser.add_argument(
        "--format",
        default="json",
        choices=FORMATS,
        metavar="NAME",
        help=f"of skeletons: {', '.join(FORMATS)} (%(default)s)",
    )
    parser.add_argument("--picture", action="store_true", help="draw mesh and skeleton beside each skeleton")
    parser.add_argument("--report", action="store_true", help="write the full report beside each skeleton")
    parser.add_argument("--workers", type=int, metavar="N", help="number of processes (default: of processors)")
    parser.add_argument("--dask", metavar="ADDRESS", help="run on the Dask cluster of this scheduler, tcp://...")
    parser.add_argument(
        "--memory-limit", type=float, metavar="MB", help="memory of the process of each mesh; it is ended beyond"
    )
    parser.add_argument("--force", action="store_true", help="replace files that no batch has made")
    add_swc_options(parser)
    add_skeleton_options(parser, time_limit_help="end the process of a mesh that takes longer than SECONDS")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Make all skeletons; 0 if every score passes, 1 if one fails, 2 if an input has no skeleton."""
    paths = _paths(arguments.input, Path(arguments.output))
    with _Bar(len(paths), arguments.quiet) as bar:
        records = skeletonize_many(
            paths,
            arguments.output,
            extension=arguments.format,
            tree=arguments.tree,
            scale=arguments.scale,
            units=arguments.units,
            workers=arguments.workers,
            dask=arguments.dask,
            time_limit=arguments.time_limit,
            memory_limit=arguments.memory_limit,
            force=arguments.force,
            on_record=bar.show,
            pictures=arguments.picture,
            reports=arguments.report,
            **skeleton_options(arguments),
        )
        n_earlier = bar.n_earlier
    for record in records:
        if record.outcome not in (BatchStatus.PASSED, BatchStatus.FAILED_CHECKS):
            where = "" if record.input in record.message else f"{record.input}: "
            print(f"lbskel: {where}{with_options(record.message, arguments)}", file=sys.stderr)
    counts = Counter(record.outcome for record in records)
    if arguments.json:
        for record in records:
            print(json.dumps({**asdict(record), "outcome": record.outcome.value}))
    elif not arguments.quiet:
        by_status = ", ".join(f"{counts[each]} {each.value}" for each in BatchStatus if counts[each])
        print(f"{counted(len(records), 'input')}: {by_status}")
        print(f"  {n_earlier} from earlier batches; {Path(arguments.output) / SUMMARY} has a row for each")
    return (
        0
        if set(counts) == {BatchStatus.PASSED}
        else 1
        if set(counts) <= {BatchStatus.PASSED, BatchStatus.FAILED_CHECKS}
        else 2
    )


def _paths(given: list[str], output: Path) -> list[str]:
    """List the paths named, each once, with patterns replaced by the files that they match, in the order of names.

    What batches have written in the output folder matches no pattern.

    Raises
    ------
    FormatError
        If a pattern matches no file, or a folder is named.
    """
    paths = []
    own = {(output / file).resolve() for file in written(output)}
    for name in given:
        if Path(name).is_dir():
            raise FormatError(f"{name}: is a folder; name the meshes in it, such as by '{Path(name) / '*'}'")
        if not glob.has_magic(name) or Path(name).exists():
            paths.append(name)
        elif matches := sorted(path for path in glob.glob(name, recursive=True) if Path(path).is_file()):
            paths.extend(path for path in matches if Path(path).resolve() not in own)
        else:
            raise FormatError(f"{name}: no file matches this pattern; correct it, or leave it out")
    return list(dict.fromkeys(paths))


class _Bar:
    """A progress bar, on a terminal."""

    n_earlier = 0

    def __init__(self, n_inputs: int, is_quiet: bool):
        self._n_inputs = n_inputs
        self._is_quiet = is_quiet or not sys.stderr.isatty()

    def __enter__(self) -> _Bar:
        from tqdm import tqdm

        self._bar = tqdm(total=self._n_inputs, unit=" meshes", leave=False, disable=self._is_quiet)
        return self

    def show(self, record: Record, is_earlier: bool) -> None:
        self.n_earlier += is_earlier
        self._bar.update()

    def __exit__(self, *_: object) -> None:
        self._bar.close()
