"""``python -m benchmarks NAME [--quick] [--peers] [--results DIRECTORY] [--meshes FOLDER]``.

A benchmark is a module of this package with ``run(quick, results)`` at its top level: no list to keep. One that can
take further meshes has an argument ``meshes``, the paths of their files; one that can be run beside other tools, or
alone, has an argument ``peers``.
"""

from __future__ import annotations

import argparse
import inspect
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).parent


def names() -> list[str]:
    """The modules here that define ``run``; none is imported."""
    return sorted(path.stem for path in HERE.glob("*.py") if "\ndef run(" in path.read_text(encoding="utf-8"))


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmarks named on the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="+", choices=names(), metavar="NAME", help=", ".join(names()))
    parser.add_argument("--quick", action="store_true", help="small sizes, to see that it runs; numbers of no worth")
    parser.add_argument("--results", type=Path, help="default: benchmarks/results, with --quick its directory quick")
    parser.add_argument("--meshes", type=Path, help="a folder of further meshes, for benchmarks that take them")
    parser.add_argument("--peers", action="store_true", help="other tools beside lbskel, in benchmarks that have them")
    chosen = parser.parse_args(arguments)
    results = chosen.results or HERE / "results" / ("quick" if chosen.quick else "")
    results.mkdir(parents=True, exist_ok=True)
    for name in chosen.names:
        run = import_module(f"benchmarks.{name}").run
        meshes = sorted(chosen.meshes.iterdir()) if chosen.meshes else []
        taken = inspect.signature(run).parameters
        run(chosen.quick, results, **{k: v for k, v in {"meshes": meshes, "peers": chosen.peers}.items() if k in taken})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
