"""Cutting the cycles of a finished skeleton where a tree is asked for, or where the file format stores only trees."""

from __future__ import annotations

__all__ = ["cut_cycles"]

from dataclasses import replace

from lbskel.errors import counted, first_few
from lbskel.io import FORMATS
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.spanning_tree import cycle_edges, to_tree


def cut_cycles(skeleton: Skeleton, *, tree: bool, extension: str) -> tuple[Skeleton, str]:
    """Return the skeleton to write, and a note on the cycles that are cut, also in its report, or ``""`` if none are.

    Parameters
    ----------
    skeleton : Skeleton
        From :func:`lbskel.skeletonize`.
    tree : bool
        Whether the skeleton is to be a tree. If not, it keeps its cycles, also in a format of trees, which stores the
        edges that are cut as comments.
    extension : str
        The format of the file, in FORMATS.
    """
    if not skeleton.cycle_rank or not (tree or FORMATS[extension].only_trees):
        return skeleton, ""
    radii = skeleton.radii[skeleton.edges[cycle_edges(skeleton)]].min(axis=1)
    cut = f"{counted(len(radii), 'cycle')} cut where the skeleton is thinnest "
    cut += f"(radius {first_few(f'{r:.3g}' for r in radii)}, in the units of the mesh)"
    why = (
        "since a tree is asked for; the score is that of the skeleton with its cycles"
        if tree
        else f"since {extension} is a format of trees; lbskel restores them on reading"
    )
    note = f"{cut}, {why}"
    written = to_tree(skeleton) if tree else skeleton
    return replace(written, report={**written.report, "notes": [*skeleton.report["notes"], note]}), note
