"""Names of the files of a batch: no two inputs write the same file, nor one that the batch writes for all."""

from __future__ import annotations

__all__ = ["files_of", "skeleton_names"]

import os
from collections import Counter
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from lbskel.errors import FormatError
from lbskel.io.csv import edges_path
from lbskel.pipeline.batch.records import MANIFEST, SUMMARY


def files_of(name: str, suffixes: Sequence[str]) -> list[str]:
    """Return the names of a skeleton, of its second file in csv, and of what is written beside it.

    Parameters
    ----------
    name : str
        Of the skeleton, relative to the output folder.
    suffixes : sequence of str
        That replace its own, such as ``.png``.
    """
    path = Path(name)
    edges = [edges_path(path)] if path.suffix == ".csv" else []
    return [file.as_posix() for file in (path, *edges, *(path.with_suffix(suffix) for suffix in suffixes))]


def skeleton_names(paths: Sequence[Path], extension: str, suffixes: Sequence[str] = ()) -> list[str]:
    """Name each skeleton relative to the common folder of the inputs.

    Those of which a file would have the name of another's, or of the manifest or the summary, keep the extension of the
    mesh.

    Parameters
    ----------
    paths : sequence of Path
    extension : str
        Of the skeletons.
    suffixes : sequence of str
        Of what is written beside each.

    Raises
    ------
    FormatError
        If a mesh is named twice.
    """
    absolute = [Path(os.path.abspath(path)) for path in paths]  # without .., which would lead out of the folder
    if len(set(absolute)) < len(absolute):
        twice = next(path for path, count in Counter(absolute).items() if count > 1)
        raise FormatError(f"{twice} is named twice; name each mesh once")
    below = Path(os.path.commonpath([path.parent for path in absolute]))
    names = [path.relative_to(below).with_suffix(f".{extension}").as_posix() for path in absolute]
    full = [f"{path.relative_to(below).as_posix()}.{extension}" for path in absolute]
    while True:  # a longer name may be that of yet another
        files = [files_of(name, suffixes) for name in names]
        count = Counter([MANIFEST, SUMMARY, *chain.from_iterable(files)])
        is_unique = [all(count[file] == 1 for file in group) for group in files]
        before, names = names, [a if unique else b for a, b, unique in zip(names, full, is_unique, strict=True)]
        if names == before:
            return names
