"""Names of the files of a batch: no two inputs write the same file."""

from __future__ import annotations

__all__ = ["files_of", "skeleton_names"]

import os
from collections import Counter
from collections.abc import Sequence
from itertools import chain
from pathlib import Path, PurePosixPath

from lbskel.errors import FormatError


def files_of(name: str, suffixes: Sequence[str]) -> list[str]:
    """Return the names of a skeleton and of what is written beside it.

    Parameters
    ----------
    name : str
        Of the skeleton, relative to the output folder.
    suffixes : sequence of str
        That replace its own, such as ``.png``.
    """
    return [name, *(PurePosixPath(name).with_suffix(suffix).as_posix() for suffix in suffixes)]


def skeleton_names(paths: Sequence[Path], extension: str, suffixes: Sequence[str] = ()) -> list[str]:
    """Name each skeleton relative to the common folder of the inputs.

    Those of which a file would have the name of another's keep the extension of the mesh.

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
    absolute = [path.absolute() for path in paths]
    if len(set(absolute)) < len(absolute):
        twice = next(path for path, count in Counter(absolute).items() if count > 1)
        raise FormatError(f"{twice} is named twice; name each mesh once")
    below = Path(os.path.commonpath([path.parent for path in absolute]))
    names = [path.relative_to(below).with_suffix(f".{extension}").as_posix() for path in absolute]
    full = [f"{path.relative_to(below).as_posix()}.{extension}" for path in absolute]
    while True:  # a longer name may be that of yet another
        files = [files_of(name, suffixes) for name in names]
        count = Counter(chain.from_iterable(files))
        is_unique = [all(count[file] == 1 for file in group) for group in files]
        before, names = names, [a if unique else b for a, b, unique in zip(names, full, is_unique, strict=True)]
        if names == before:
            return names
