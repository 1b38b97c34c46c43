"""Paragraphs of README.md on installation, waiting and pages."""

from __future__ import annotations

__all__ = ["PARAGRAPHS"]

from collections.abc import Callable
from pathlib import Path

from benchmarks.readme_figures import Figures, bound, claim, of, read, span, values

PYMESHLAB = """
`lbskel check` names the defects of a file and what happens to each by default; holes are closed without being asked.
Remeshing, which `--preprocess cad` has, needs pymeshlab, {megabytes:.0f} MB that the first command leaves out: `pip
install '.[preprocess]'`.
"""
PAGE = """
A picture of the first view is there {picture} s after the page is opened, and the view of {faces:,} faces, drawn by
software, is on the screen after {warm} s, or after {cold} s in a browser that has just been started; the page takes
{megabytes:.1f} MB ([seconds](benchmarks/results/page.md)).
"""
INSTALLATION = """
From a clone to the picture at the top takes {whole:.0f} s of processor time, {install:.0f} of them to install and
compile, and {run:.0f} for the skeleton and the picture. lbskel and all that it needs take {megabytes:.0f} MB
installed ({largest}); `[view]` adds {view:.0f} and `[preprocess]` {preprocess:.0f}. Without a compiler a wheel is
built in {zig:.0f} s in place of {compiler:.0f}, and the first command takes {by_zig:.2f} times as long; uncompiled, it
takes {uncompiled:.0f} s in place of {command:.1f}. The wheel takes {wheel} of the time of a build by each of
Python {pythons} on three sizes; of the {passed:,} tests of the source distribution with each of them, {failed} fail
([tests](benchmarks/results/installed_tests.md)). The wheel built on Debian 12 passes for manylinux2014.
"""
WAITS = """
Ctrl-C ends a skeleton of {faces:,} faces within {python} s in Python, and within {command} s on the command line
([waits](benchmarks/results/interrupts.md)).
"""


def _added(results: Path) -> dict[str, float]:
    """Megabytes that each extra adds."""
    packages = read(results, "installation", "packages")
    return {row["package"].split()[0]: row["megabytes"] for row in packages if row["package"].endswith(" adds")}


def _pymeshlab(results: Path) -> Figures:
    return {"megabytes": _added(results)["preprocess"]}


def _page(results: Path) -> Figures:
    loads = read(results, "page", "loads")
    smaller = of(loads, faces=min(row["faces"] for row in loads))
    return {
        "picture": span(values(loads, "first picture"), ".2f"),
        "faces": smaller[0]["faces"],
        "warm": span(values(of(smaller, load="warm"), "on the screen"), ".2f"),
        "cold": span(values(of(smaller, load="cold"), "on the screen"), ".2f"),
        "megabytes": smaller[0]["megabytes"],
    }


def _installation(results: Path) -> Figures:
    steps = {row["step"].split()[0]: row["processor seconds"] for row in read(results, "installation", "first_run")}
    sizes = [(row["package"], row["megabytes"]) for row in read(results, "installation", "packages")]
    added = _added(results)
    builds = values(read(results, "installation", "builds"), "seconds")
    command = read(results, "installation", "without_compiler")[0]
    claim(command["as Python"] > 2 * command["by the machine's compiler"], "uncompiled kernels are many times slower")
    pythons, tests = read(results, "installation", "pythons"), read(results, "installed_tests", "pythons")
    return {
        "whole": steps["in"],
        "install": steps["pip"],
        "run": steps["lbskel"],
        "megabytes": sizes[0][1],
        "largest": ", ".join(f"{name} {size:.0f}" for name, size in sizes[1:5]),
        "view": added["view"],
        "preprocess": added["preprocess"],
        "zig": builds[-1],
        "compiler": builds[-2],
        "by_zig": command["by zig"] / command["by the machine's compiler"],
        "command": command["by the machine's compiler"],
        "uncompiled": command["as Python"],
        "wheel": span(row[key] for row in pythons for key in row if key.endswith("wheel / source")),
        "pythons": ", ".join(row["Python"] for row in pythons),
        "passed": min(row["passed"] for row in tests),
        "failed": sum(row["failed"] for row in tests),
    }


def _waits(results: Path) -> Figures:
    python, command = read(results, "interrupts", "interrupts")
    waits = {"python": python, "command": command}
    return {"faces": python["faces"]} | {how: bound([row["longest wait"]], 2) for how, row in waits.items()}


PARAGRAPHS: dict[str, tuple[str, Callable[[Path], Figures]]] = {
    "pymeshlab": (PYMESHLAB, _pymeshlab),
    "page": (PAGE, _page),
    "installation": (INSTALLATION, _installation),
    "waits": (WAITS, _waits),
}
