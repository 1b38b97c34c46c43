"""Steps of preprocessing by name, one after the other, as text, as TOML or in Python.

As text: ``merge_close,remesh_isotropic:edge=0.3:of=thickness``. As TOML, a table ``[[step]]`` for each, with its name
and its options::

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
from inspect import signature
from pathlib import Path
from typing import Any, TypeAlias

from lbskel.errors import FormatError, UnknownChoice, choose
from lbskel.geometry.mesh import Mesh
from lbskel.preprocess.cleaning import keep_components, merge_close, remove_duplicates
from lbskel.preprocess.degenerate_faces import remove_degenerate
from lbskel.preprocess.holes import close_holes
from lbskel.preprocess.orientation import fix_orientation, split_nonmanifold
from lbskel.preprocess.remeshing import remesh_isotropic, smooth_noise
from lbskel.preprocess.result import PreprocessResult, distance_between, identity_result
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

_KINDS: dict[str, tuple[type, ...]] = {"float": (float, int), "int": (int,), "str": (str,)}


@dataclass(frozen=True, eq=False)
class Pipeline:
    """An ordered list of steps; call it with a mesh.

    Parameters
    ----------
    steps : iterable
        Names in STEPS, or pairs of a name and a mapping of its options.

    Raises
    ------
    UnknownChoice
        If there is no such step or option, or a value is of another type.

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
        pairs = [(step, {}) if isinstance(step, str) else step for step in steps]
        object.__setattr__(self, "steps", tuple((name, _checked(name, options)) for name, options in pairs))

    def __str__(self) -> str:
        return ",".join(
            ":".join([name, *(f"{option}={value}" for option, value in options.items())])
            for name, options in self.steps
        )

    def __call__(self, mesh: Mesh) -> PreprocessResult:
        """The mesh after all steps; the report has each of them, and how far the surface is from the first."""
        result = identity_result(mesh)
        for name, options in self.steps:
            result = result.compose(lambda given, step=STEPS[name], options=options: step(given, **options))  # type: ignore[misc]
        report = {"pipeline": str(self), **result.report, "distance": distance_between(mesh, result.mesh)}
        return replace(result, report=report)

    @classmethod
    def parse(cls, text: str) -> Pipeline:
        """A pipeline from its text, ``name:option=value:option=value,name``; of PIPELINES by name; or of a TOML file.

        Raises
        ------
        FormatError
            If it ends in ``.toml`` and :meth:`read` refuses that file.
        UnknownChoice
            If it names no steps, or no pipeline.
        """
        if text in PIPELINES:
            return PIPELINES[text]
        if text.lower().endswith(".toml"):
            return cls.read(text)
        steps = []
        for part in text.split(","):
            name, *options = part.strip().split(":")
            if name not in STEPS and "," not in text and not options:
                choose({**PIPELINES, **STEPS}, name, "pipeline or step")
            pairs = [option.partition("=") for option in options]
            steps.append((name, {key.strip(): _value(value.strip()) for key, _, value in pairs}))
        return cls(steps)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Pipeline:
        """A pipeline from a TOML file.

        Raises
        ------
        FormatError
            If there is no such file, or it is no TOML with tables ``[[step]]``.
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
        except ValueError as error:  # no UTF-8 too
            raise FormatError(f"{path}: no TOML: {error}") from None
        steps = tables.get("step")
        if set(tables) != {"step"} or not isinstance(steps, list) or not all(isinstance(s, dict) for s in steps):
            raise FormatError(f"{path}: must hold a table [[step]] with a name for each step, and nothing else")
        for step in steps:
            if not isinstance(step.get("name"), str):
                raise FormatError(f"{path}: a table [[step]] has no name; choose one of: {', '.join(STEPS)}")
        return cls((step["name"], {key: value for key, value in step.items() if key != "name"}) for step in steps)


def _checked(name: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """The options of a step, refused where it has none of that name or type."""
    known = dict(list(signature(choose(STEPS, name, "step")).parameters.items())[1:])
    for option, value in options.items():
        if option not in known:
            raise UnknownChoice(f"{name} has no option {option!r}; it has: {', '.join(known) or 'none'}")
        kind = str(known[option].annotation).removesuffix(" | None")
        if not isinstance(value, _KINDS[kind]) or isinstance(value, bool):
            raise UnknownChoice(f"option {option} of {name} must be of type {kind}, not {value!r}")
    return dict(options)


def _value(text: str) -> int | float | str:
    """A value as it is written: a number where it is one."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


_SOUND: list[str | Step] = ["merge_close", "remove_duplicates", "fix_orientation"]

_APART = ("split_nonmanifold", "remove_degenerate")  # after holes are closed, whose rims often touch themselves

PIPELINES: dict[str, Pipeline] = {
    # crumbs, holes, and noise of the sensor
    "scan": Pipeline(
        [*_SOUND, "keep_components", ("close_holes", {"largest": 1.0}), *_APART, "refine", "smooth_noise"]
    ),
    # long triangles on flat parts, seams between patches, sharp edges that stay
    "cad": Pipeline([*_SOUND, "close_holes", *_APART, ("remesh_isotropic", {"edge": 0.4, "of": "thickness"})]),
    # few large triangles, vertices split for textures, open parts
    "game": Pipeline(
        [
            ("merge_close", {"tolerance": 1e-5}),
            *_SOUND[1:],
            ("close_holes", {"largest": 1.0}),
            *_APART,
            "refine",
        ]
    ),
    # dense and smooth: fewer triangles do
    "organic": Pipeline([*_SOUND, "close_holes", *_APART, ("simplify", {"error": 0.002})]),
}
