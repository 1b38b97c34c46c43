"""The display of a value in a notebook: a picture, or an interactive page on request.

The package that draws is imported by its name when something is shown for the first time. So the classes of the values
do not depend on it, and importing them imports nothing that draws.
"""

from __future__ import annotations

__all__ = ["Displayed"]

from collections.abc import Sequence
from importlib import import_module
from typing import Any

from lbskel.errors import MissingDependency

DRAWING = "lbskel.visualization.notebook"


class Displayed:
    """A value with a picture in notebooks: IPython calls ``_repr_png_``."""

    def _drawings(self) -> Sequence[tuple[str, Any]]:
        """List the titles and the values that the picture shows."""
        return [("", self)]

    def _repr_png_(self) -> bytes | None:
        """Draw the picture; None, so that the text is shown, where matplotlib is not installed."""
        try:
            png: bytes = import_module(DRAWING).picture_of(self._drawings())
        except MissingDependency:
            return None
        return png

    def _plot(self, **scene: Any) -> Any:
        """Make the interactive page of a scene, given as the fields of :class:`lbskel.visualization.Scene`."""
        return import_module(DRAWING).InlinePage(**scene)
