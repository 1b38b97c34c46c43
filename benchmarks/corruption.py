"""Behavior on damaged meshes: each kind of damage on three shapes, for lbskel, skeletor and PyGEL3D.

Every tool runs in a process of its own with a time limit, and gets the same arrays or the same file. The skeletons of
all tools are scored by :func:`lbskel.score` on the undamaged mesh. One rule tells a refusal from an accidental error,
for all tools and the readers of files that they use: a tool refuses if its own code, or that of its reader, raises the
error by a statement of its own, with a sentence as its message.
"""

from __future__ import annotations

__all__ = ["Worker", "damage_sections", "is_refusal", "outcome_sections", "run"]

import os
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import lbskel
from benchmarks.damage import DAMAGE, SHAPES, Broken, damaged, undamaged
from benchmarks.harness import markdown_table, save_json, save_markdown
from benchmarks.peers import PEERS, SKELETOR

TOOLS = ("lbskel", SKELETOR, "PyGEL3D")
PACKAGES = ("lbskel", "skeletor", "pygel3d", "trimesh")  # whose refusals count: the tools, and the reader of the others
SENTENCE = 3  # words from which on a message is a sentence; a guess
SECONDS = 60.0  # time limit for one mesh; a guess
QUICK = ("NaN coordinate", "negative index", "duplicate faces", "soup", "truncated stl")

UNDAMAGED = "none"
OF = {"none": "Undamaged shapes", "mesh": "Damage of meshes", "file": "Damage of files"}
OUTCOMES = {
    "good": "a skeleton that passes the score",
    "refused": "an error that the tool or its reader raises itself, in a sentence",
    "admitted": "a skeleton that fails the score, and the tool says so",
    "poor": "a skeleton that fails the score, and nothing is said",
    "nonsense": "a skeleton of what is no shape, and nothing is said",
    "nothing": "no edges, or numbers that are none, and nothing is said",
    "unexplained": "an error out of the inside of the program",
    "crash": "the process ended",
    "hang": f"over {SECONDS:.0f} s",
}


def run(quick: bool, results: Path) -> None:
    """Measure, and write corruption.json and corruption.md."""
    kinds = QUICK if quick else tuple(DAMAGE)
    shapes = {name: make() for name, make in list(SHAPES.items())[: 1 if quick else None]}
    rows = []
    for tool in TOOLS:
        with tempfile.TemporaryDirectory() as folder, Worker(partial(_skeleton, tool)) as worker:
            for shape, mesh in shapes.items():
                for kind in (UNDAMAGED, *kinds):
                    broken = undamaged(mesh) if kind == UNDAMAGED else damaged(kind, mesh)
                    answer = worker.ask(_given(broken, Path(folder)))
                    answer["error"] = answer.get("error", "").replace(f"{folder}{os.sep}", "")
                    of = "none" if kind == UNDAMAGED else "file" if broken.extension else "mesh"
                    row = {"tool": tool, "damage": kind, "of": of, "shape": shape, **_outcome(broken, answer)}
                    rows.append(row)
    save_json(results / "corruption.json", {"rows": rows}, packages=("skeletor", "PyGEL3D", "trimesh"))
    sections = damage_sections(rows, "tool", OUTCOMES)
    save_markdown(results / "corruption.md", "Broken meshes", sections)


def damage_sections(rows: list[dict[str, Any]], key: str, outcomes: Mapping[str, str]) -> dict[str, str]:
    """Tabulate outcomes as :func:`outcome_sections` does, apart for undamaged shapes, meshes and files."""
    sections: dict[str, str] = {}
    for of, what in OF.items():
        if own := [row for row in rows if row["of"] == of]:
            kinds, shapes = ({row[column] for row in own} for column in ("damage", "shape"))
            title = what if of == "none" else f"{what}: {len(kinds)} kinds on {len(shapes)} shapes"
            (summary, each) = outcome_sections(title, own, key, outcomes).items()
            sections |= {summary[0]: summary[1]} | ({} if of == "none" else {f"{what}, each kind": each[1]})
    return sections


def outcome_sections(title: str, rows: list[dict[str, Any]], key: str, outcomes: Mapping[str, str]) -> dict[str, str]:
    """Tabulate how often each name of a key had each outcome, with their meaning, and the outcomes of each damage."""
    names, kinds = (dict.fromkeys(row[column] for row in rows) for column in (key, "damage"))
    found = Counter((row[key], row["damage"], row["outcome"]) for row in rows)
    summary = [
        {"outcome": what, **{name: sum(found[name, kind, what] for kind in kinds) for name in names}}
        for what in outcomes
    ]
    each = [
        {"damage": kind, **{name: _together({what: found[name, kind, what] for what in outcomes}) for name in names}}
        for kind in kinds
    ]
    meanings = "\n".join(f"- *{what}*: {text}" for what, text in outcomes.items())
    return {title: f"{markdown_table(summary)}\n{meanings}\n", "Each kind": markdown_table(each)}


def _together(counts: Mapping[str, int]) -> str:
    """Summarize the outcomes for one kind of damage over the shapes."""
    found = {what: count for what, count in counts.items() if count}
    return ", ".join(what if len(found) == 1 else f"{count} {what}" for what, count in found.items())


def _given(broken: Broken, folder: Path) -> Any:
    """Return the damaged mesh as a pair of arrays, or as the path of a file."""
    if not broken.extension:
        return broken.vertices, broken.faces
    path = folder / f"broken.{broken.extension}"
    path.write_bytes(broken.data)
    return str(path)


def _outcome(broken: Broken, answer: dict[str, Any]) -> dict[str, Any]:
    """Classify an answer as one of OUTCOMES, and keep the message."""
    row = {"seconds": answer["seconds"], "said": answer["error"]}
    if "outcome" in answer:
        return {"outcome": answer["outcome"], **row}
    nodes, edges, says_failed = answer["value"]
    if len(edges) == 0 or not np.isfinite(nodes).all():
        return {"outcome": "admitted" if says_failed else "nothing", **row}
    row["nodes"] = len(nodes)
    if broken.reference is None:
        return {"outcome": "admitted" if says_failed else "nonsense", **row}
    scale = broken.reference.diameter_bound
    reference = broken.reference.with_vertices(broken.reference.vertices / scale)
    verdict = lbskel.score(lbskel.Skeleton(nodes / scale, edges, np.zeros(len(nodes))), reference).verdict
    row["verdict"] = verdict
    return {"outcome": "good" if verdict != "fail" else "admitted" if says_failed else "poor", **row}


class Worker:
    """A process that calls a function, and is replaced when it crashes or takes too long."""

    def __init__(self, function: Callable[[Any], Any]):
        self.function = function
        self._start()

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()

    def _start(self) -> None:
        context = get_context("spawn")
        self.pipe, child = context.Pipe()
        self.process = context.Process(target=_serve, args=(child, self.function))
        self.process.start()
        child.close()

    def _stop(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()

    def ask(self, given: Any) -> dict[str, Any]:
        """Return the value of the function with the seconds it took, or how its process ended."""
        began = time.perf_counter()
        self.pipe.send(given)
        try:
            if self.pipe.poll(SECONDS):
                return self.pipe.recv()
            ended = {"outcome": "hang", "error": f"over {SECONDS:.0f} s"}
        except EOFError:
            self.process.join()
            ended = {"outcome": "crash", "error": f"the process ended with code {self.process.exitcode}"}
        self._stop()
        self._start()
        return {**ended, "seconds": time.perf_counter() - began}


def _serve(pipe: Any, function: Callable[[Any], Any]) -> None:
    """Call the function for one argument after the other, in the child process."""
    while True:
        given = pipe.recv()
        began = time.perf_counter()
        try:
            answer: dict[str, Any] = {"value": function(given)}
        except Exception as error:
            outcome = "refused" if is_refusal(error) else "unexplained"
            answer = {"outcome": outcome, "error": f"{type(error).__name__}: {error}"[:300]}
        pipe.send({**answer, "seconds": time.perf_counter() - began})


def is_refusal(error: Exception) -> bool:
    """Whether one of PACKAGES raised an error by a statement of its own, with a sentence."""
    where = traceback.extract_tb(error.__traceback__)[-1]
    is_own = any(package in Path(where.filename).parts for package in PACKAGES)
    return is_own and (where.line or "").startswith("raise") and len(str(error).split()) >= SENTENCE


def _skeleton(tool: str, given: Any) -> tuple[Any, Any, bool]:
    """Return nodes, edges, and whether the tool itself reports that they failed."""
    if tool == "lbskel":
        skeleton = lbskel.skeletonize(given)
        return skeleton.nodes, skeleton.edges, skeleton.report["score"]["verdict"] == "fail"
    if isinstance(given, str):  # both of the others read files by trimesh
        import trimesh

        mesh: Any = trimesh.load(given, force="mesh", process=False)
        given = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    return *PEERS[tool](*given), False
