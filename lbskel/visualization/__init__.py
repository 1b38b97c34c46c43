"""Pictures (PNG) and interactive pages (HTML) of meshes, point clouds and skeletons."""

from lbskel.visualization.html import page
from lbskel.visualization.panel import Panel
from lbskel.visualization.rendering import draw, picture, render

__all__ = ["Panel", "draw", "page", "picture", "render"]
