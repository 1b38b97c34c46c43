"""Run benchmarks by name: ``python -m benchmarks NAME [NAME ...]``.

Every benchmark writes its results as JSON and as Markdown tables.
"""

from __future__ import annotations

import argparse
import ast
import inspect
from importlib import import_module
from pathlib import Path

# A benchmark is a module of this package with ``run(quick, results)`` at its top level, so there is no list to keep.
# Further options go to those whose ``run`` has an argument of that name. ``run`` may return an exit code.
HERE = Path(__file__).parent


def names() -> list[str]:
    """The modules of this package that define ``run``; none is imported."""
    return sorted(path.stem for path in HERE.glob("*.py") if "\ndef run(" in path.read_text(encoding="utf-8"))


def _summary(name: str) -> str:
    """The first sentence of a benchmark's docstring."""
    text = ast.get_docstring(ast.parse((HERE / f"{name}.py").read_text(encoding="utf-8"))) or ""
    return text.split("\n\n")[0].replace("\n", " ").replace("``", "")


def _parser() -> argparse.ArgumentParser:
    width = max(map(len, names()))
    listed = "\n".join(f"  {name:{width}}  {_summary(name)}" for name in names())
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=(__doc__ or "").split("\n\n")[1],
        epilog=f"benchmarks:\n{listed}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("names", nargs="+", metavar="NAME", help="benchmarks to run, of those below")
    parser.add_argument("--quick", action="store_true", help="small sizes, for a trial run; the numbers mean nothing")
    parser.add_argument(
        "--results",
        type=Path,
        metavar="FOLDER",
        help="where results go (default: benchmarks/results, with --quick its folder quick)",
    )
    parser.add_argument(
        "--meshes", type=Path, metavar="FOLDER", help="further meshes or tracings, for benchmarks that take them"
    )
    parser.add_argument("--peers", action="store_true", help="measure other tools too, in benchmarks that have them")
    parser.add_argument(
        "--package",
        metavar="NAME",
        help="for mutations one package, for operators and solvers one part, for skeletons one tool; other rows stay",
    )
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="for mutations: so many at the same time")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmarks named on the command line; the largest of their exit codes."""
    parser = _parser()
    chosen = parser.parse_args(arguments)
    if unknown := [name for name in chosen.names if name not in names()]:
        parser.error(f"there is no benchmark {', '.join(unknown)}; there are: {', '.join(names())}")
    results = chosen.results or HERE / "results" / ("quick" if chosen.quick else "")
    results.mkdir(parents=True, exist_ok=True)
    options = {
        "meshes": sorted(chosen.meshes.iterdir()) if chosen.meshes else [],
        "peers": chosen.peers,
        "package": chosen.package,
        "jobs": chosen.jobs,
    }
    code = 0
    for name in chosen.names:
        run = import_module(f"benchmarks.{name}").run
        taken = inspect.signature(run).parameters
        code = max(code, run(chosen.quick, results, **{k: v for k, v in options.items() if k in taken}) or 0)
    return code


if __name__ == "__main__":
    raise SystemExit(main())
