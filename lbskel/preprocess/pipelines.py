"""Pipelines of named preprocessing steps, written in Python, as text or as TOML.

As text: ``merge_close,remesh_isotropic:edge_length=0.3:relative_to=thickness``. As TOML, one table ``[[step]]`` for
each step, with its name and options::

    [[step]]
    name = "merge_close"
    tolerance = 1e-6
"""

from __future__ import annotations

__all__ = ["PIPELINES", "STEPS", "Pipeline"]

import os
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from lbskel.errors import FormatError, UnknownChoice, choose
from lbskel.geometry.mesh import as_mesh
from lbskel.preprocess.cleaning import keep_components, merge_close, remove_duplicates
from lbskel.preprocess.degenerate_faces import remove_degenerate
from lbskel.preprocess.holes import close_holes
from lbskel.preprocess.orientation import fix_orientation, split_nonmanifold
from lbskel.preprocess.remeshing import check_reference_length, remesh_isotropic, smooth_noise
from lbskel.preprocess.result import PreprocessResult, hausdorff_distance, identity_result
from lbskel.preprocess.simplification import simplify
from lbskel.preprocess.subdivision import refine

Step: TypeAlias = tuple[str, Mapping[str, Any]]

STEPS: dict[str, Callable[..., PreprocessResult]] = {
    "merge_close": merge_close,
    "remove_duplicates": remove_duplicates,
    "fix_orientation": fix_orientation,
    "split_nonmanifold": split_nonmanifold,
    "close_holes": close_holes,
    "keep_components": keep_components,
    "remove_degenerate": remove_degenerate,
    "refine": refine,
    "smooth_noise": smooth_noise,
    "simplify": simplify,
    "remesh_isotropic": remesh_isotropic,
}

# Types of value that an option accepts, by its annotation
_ACCEPTED_TYPES: dict[str, tuple[type, ...]] = {"float": (float, int), "int": (int,), "str": (str,)}


@dataclass(frozen=True, eq=False)
class Pipeline:
    """A sequence of preprocessing steps; call it with a mesh.

    Parameters
    ----------
    steps : iterable
        Names in STEPS, or pairs of a name and a mapping of options.

    Raises
    ------
    UnknownChoice
        If there is no such step or option, or a value has the wrong type.

    Examples
    --------
    >>> from lbskel import Pipeline
    >>> from lbskel.shapes import torus
    >>> clean = Pipeline(["merge_close", ("simplify", {"target_faces": 500})])
    >>> str(clean)
    'merge_close,simplify:target_faces=500'
    >>> len(clean(torus(1.0, 0.3)).mesh.faces) <= 550
    True
    """

    steps: tuple[Step, ...]

    def __init__(self, steps: Iterable[str | Step]):
        try:
            pairs = [(name, dict(options)) for name, options in ((s, {}) if isinstance(s, str) else s for s in steps)]
        except (TypeError, ValueError):
            raise UnknownChoice(
                "steps must be a list of names, or of pairs of a name and a mapping of options; "
                "Pipeline.parse reads them from text"
            ) from None
        object.__setattr__(self, "steps", tuple((name, _validated(name, options)) for name, options in pairs))

    def __str__(self) -> str:
        return ",".join(
            ":".join([name, *(f"{option}={value}" for option, value in options.items())])
            for name, options in self.steps
        )

    def __call__(self, mesh: Any) -> PreprocessResult:
        """Apply all steps; the report lists them and the distance of the result from the input.

        Parameters
        ----------
        mesh : Mesh, (vertices, faces), path or mesh object
        """
        source = as_mesh(mesh)
        result = identity_result(source)
        for name, options in self.steps:
            result = result.compose(partial(STEPS[name], **options))
        report = {"pipeline": str(self), **result.report, "distance": hausdorff_distance(source, result.mesh)}
        return replace(result, report=report)

    @classmethod
    def parse(cls, text: str) -> Pipeline:
        """Make a pipeline from text as ``name:option=value:option=value,name``, a name in PIPELINES, or a TOML file.

        Parameters
        ----------
        text : str

        Raises
        ------
        FormatError
            If it ends in ``.toml`` and :meth:`read` rejects that file.
        UnknownChoice
            If it names no step and no pipeline.
        """
        if text in PIPELINES:
            return cls(PIPELINES[text].steps)  # of which the caller may change the options
        if text.lower().endswith(".toml"):
            return cls.read(text)
        steps = []
        for part in text.split(","):
            name, *options = part.strip().split(":")
            if name not in STEPS and "," not in text and not options:
                choose({**PIPELINES, **STEPS}, name, "pipeline or step")
            pairs = [option.partition("=") for option in options]
            steps.append((name, {key.strip(): _parse_value(value.strip()) for key, _, value in pairs}))
        return cls(steps)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Pipeline:
        """Read a pipeline from a TOML file.

        Parameters
        ----------
        path : path-like

        Raises
        ------
        FormatError
            If there is no such file, or it is not TOML with tables ``[[step]]``.
        UnknownChoice
            If it names a step or an option that does not exist.
        """
        if sys.version_info >= (3, 11):
            import tomllib
        else:
            import tomli as tomllib
        try:
            tables = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise FormatError(f"{path}: cannot be read: {error.strerror}") from None
        except ValueError as error:  # also for text that is not UTF-8
            raise FormatError(f"{path}: not TOML: {error}") from None
        steps = tables.get("step")
        if set(tables) != {"step"} or not isinstance(steps, list) or not all(isinstance(s, dict) for s in steps):
            raise FormatError(f"{path}: must hold a table [[step]] with a name for each step, and nothing else")
        for step in steps:
            if not isinstance(step.get("name"), str):
                raise FormatError(f"{path}: a table [[step]] has no name; choose one of: {', '.join(STEPS)}")
        return cls((step["name"], {key: value for key, value in step.items() if key != "name"}) for step in steps)


def _validated(name: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a step, as numbers of Python, or raise UnknownChoice where a name or type is wrong."""
    known = dict(list(signature(choose(STEPS, name, "step")).parameters.items())[1:])
    values = {}
    for option, given in options.items():
        if option not in known:
            raise UnknownChoice(f"{name} has no option {option!r}; it has: {', '.join(known) or 'none'}")
        kind = str(known[option].annotation).removesuffix(" | None")
        value = given.item() if isinstance(given, np.generic) else given
        if kind == "int" and isinstance(value, float) and value.is_integer():  # as 1e3
            value = int(value)
        if not isinstance(value, _ACCEPTED_TYPES[kind]) or isinstance(value, bool):
            raise UnknownChoice(f"option {option} of {name} must have type {kind}, not {given!r}")
        if option == "relative_to":
            check_reference_length(str(value))
        values[option] = value
    return values


def _parse_value(text: str) -> int | float | str:
    """Convert text to a number where it is one."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


# The start of every pipeline: shared vertices, each face once, outward orientation
_CONNECT: list[str | Step] = ["merge_close", "remove_duplicates", "fix_orientation"]

# Only after holes are closed, since their boundary loops often touch themselves
_SPLIT = ("split_nonmanifold", "remove_degenerate")

PIPELINES: dict[str, Pipeline] = {
    # debris, holes, and noise of the sensor
    "scan": Pipeline(
        [*_CONNECT, "keep_components", ("close_holes", {"max_perimeter": 1.1}), *_SPLIT, "refine", "smooth_noise"]
    ),
    # long triangles on flat parts, seams between patches, sharp edges to keep
    "cad": Pipeline(
        [*_CONNECT, "close_holes", *_SPLIT, ("remesh_isotropic", {"edge_length": 0.4, "relative_to": "thickness"})]
    ),
    # few large triangles, vertices split for textures, open parts
    "game": Pipeline(
        [
            ("merge_close", {"tolerance": 1e-5}),
            *_CONNECT[1:],
            ("close_holes", {"max_perimeter": 1.1}),
            *_SPLIT,
            "refine",
        ]
    ),
    # dense and smooth surfaces, which fewer triangles represent as well
    "organic": Pipeline([*_CONNECT, "close_holes", *_SPLIT, ("simplify", {"error": 0.0022})]),
}
