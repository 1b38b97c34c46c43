"""``lbskel batch INPUT... -o FOLDER``: the skeletons of many meshes, here or on a Dask cluster.

What was done before, of the same content and with the same parameters, is not done again.
"""

from __future__ import annotations

__all__ = ["add_parser", "run"]

import argparse
import glob
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.flow import PRESETS
from lbskel.io import FORMATS
from lbskel.operators import OPERATORS
from lbskel.pipeline.batch import BatchStatus, Record, skeletonize_many
from lbskel.pipeline.batch.records import MANIFEST, SUMMARY
from lbskel.pipeline.component import RESOLUTIONS
from lbskel.solvers import SOLVERS


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser("batch", help="make the curve skeletons of many meshes", description=__doc__)
    parser.add_argument("input", nargs="+", help="meshes, or patterns such as 'data/**/*.ply'")
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help=f"gets {MANIFEST} and {SUMMARY} too")
    parser.add_argument("--format", default="json", choices=FORMATS, help="of the skeletons (%(default)s)")
    parser.add_argument("--cut-cycles", action="store_true", help="let swc, which holds trees only, cut each cycle")
    parser.add_argument("--workers", type=int, metavar="N", help="processes at a time (as many as processors)")
    parser.add_argument("--dask", metavar="ADDRESS", help="do it on the Dask cluster of this scheduler, tcp://...")
    parser.add_argument("--time-limit", type=float, metavar="SECONDS", help="for each input")
    parser.add_argument("--memory-limit", type=float, metavar="MB", help="for the process of each input")
    parser.add_argument("--preset", default="flow", choices=PRESETS, help="parameters of the contraction (%(default)s)")
    parser.add_argument("--operator", choices=OPERATORS, help="discrete Laplacian, instead of the preset's")
    parser.add_argument("--energy", choices=ENERGIES, help="what each step minimizes, instead of the preset's")
    parser.add_argument("--solver", choices=SOLVERS, help="of the linear systems, instead of the preset's")
    parser.add_argument(
        "--resolution", default="auto", choices=RESOLUTIONS, help="full: contract every vertex (%(default)s)"
    )
    parser.add_argument("--force", action="store_true", help="replace files that no batch has made")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """All inputs; 0 if every skeleton passed its checks, 1 if one did not, 2 if an input has none."""
    paths = _paths(arguments.input)
    with _Bar(len(paths), arguments.quiet) as bar:
        records = skeletonize_many(
            paths,
            arguments.output,
            extension=arguments.format,
            cut_cycles=arguments.cut_cycles,
            workers=arguments.workers,
            dask=arguments.dask,
            time_limit=arguments.time_limit,
            memory_limit=arguments.memory_limit,
            force=arguments.force,
            on_record=bar.show,
            preset=arguments.preset,
            operator=arguments.operator,
            energy=arguments.energy,
            solver=arguments.solver,
            resolution=arguments.resolution,
        )
        n_old = bar.n_old
    for record in records:
        if record.outcome not in (BatchStatus.PASSED, BatchStatus.FAILED_CHECKS):
            where = "" if record.input in record.message else f"{record.input}: "
            print(f"lbskel: {where}{record.message}", file=sys.stderr)
    counts = Counter(record.outcome for record in records)
    if not arguments.quiet:
        print(
            f"{len(records)} inputs: {', '.join(f'{counts[each]} {each.value}' for each in BatchStatus if counts[each])}"
        )
        print(f"  {n_old} of them were done before; {Path(arguments.output) / SUMMARY} has a row for each")
    return (
        0
        if set(counts) == {BatchStatus.PASSED}
        else 1
        if set(counts) <= {BatchStatus.PASSED, BatchStatus.FAILED_CHECKS}
        else 2
    )


def _paths(given: list[str]) -> list[str]:
    """What is named, each once; a pattern stands for the files it matches, by name."""
    paths = []
    for name in given:
        is_pattern = glob.has_magic(name) and not Path(name).exists()
        paths.extend(sorted(path for path in glob.glob(name, recursive=True) if Path(path).is_file()))
        if not is_pattern and name not in paths:
            paths.append(name)
    return list(dict.fromkeys(paths))


class _Bar:
    """How many are done, on a terminal."""

    n_old = 0

    def __init__(self, n_inputs: int, is_quiet: bool):
        self._n_inputs = n_inputs
        self._is_quiet = is_quiet or not sys.stderr.isatty()

    def __enter__(self) -> _Bar:
        from tqdm import tqdm

        self._bar = tqdm(total=self._n_inputs, unit=" meshes", leave=False, disable=self._is_quiet)
        return self

    def show(self, record: Record, is_old: bool) -> None:
        self.n_old += is_old
        self._bar.update()

    def __exit__(self, *_: object) -> None:
        self._bar.close()
