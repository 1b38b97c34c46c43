"""Pictures in notebooks: IPython finds them, and values without a drawing package are text."""

import pytest

import lbskel
from lbskel.errors import MissingDependency


@pytest.mark.parametrize(
    "value_of",
    [
        lambda mesh: mesh,
        lambda mesh: lbskel.PointCloud(mesh.vertices),
        lbskel.skeletonize,
        lbskel.contract,
        lbskel.laplacian,
    ],
    ids=["mesh", "cloud", "skeleton", "contraction", "laplacian"],
)
def test_values_have_a_picture(rod, value_of):
    png = value_of(rod)._repr_png_()
    assert png[1:4] == b"PNG"
    assert png == value_of(rod)._repr_png_()


def test_without_matplotlib_there_is_text(rod, monkeypatch):
    def missing(_):
        raise MissingDependency("matplotlib", "view", "drawing pictures")

    monkeypatch.setattr("lbskel.visualization.notebook.picture_of", missing)
    assert rod._repr_png_() is None


def test_values_know_no_drawing_package_until_they_are_shown(python):
    code = "import sys, lbskel; from lbskel.geometry import Mesh; print('lbskel.visualization' in sys.modules)"
    assert python("-c", code).stdout == "False\n"
