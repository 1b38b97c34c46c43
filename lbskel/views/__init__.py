"""Pictures and interactive pages of meshes, point clouds and skeletons; finished values in, files out."""

from lbskel.views.pages import page
from lbskel.views.panel import Panel
from lbskel.views.pictures import draw, picture, render

__all__ = ["Panel", "draw", "page", "picture", "render"]
