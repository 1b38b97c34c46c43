"""Pictures (PNG) and interactive pages (HTML) of meshes, point clouds and skeletons."""

from lbskel.visualization.html import Table
from lbskel.visualization.interactive import page, page_content
from lbskel.visualization.panel import Panel
from lbskel.visualization.rendering import draw, picture, render
from lbskel.visualization.scene import Scene

__all__ = ["Panel", "Scene", "Table", "draw", "page", "page_content", "picture", "render"]
