"""A real notebook: its cells run in a kernel, as Jupyter runs them, and what they display is looked at."""

import base64
import html
import io
import os
from importlib.util import find_spec

import pytest
from helpers import unpacked
from PIL import Image

PACKAGES = ("nbclient", "nbformat", "ipykernel", "ipywidgets")
ABSENT = [name for name in PACKAGES if find_spec(name) is None]
pytestmark = pytest.mark.skipif(
    bool(ABSENT) and not os.environ.get("CI"), reason=f"no notebook runs without: pip install {' '.join(ABSENT)}"
)

SETUP = """
import lbskel
import tqdm.notebook
from lbskel.shapes import torus
mesh = torus(1.0, 0.3, n=24, m=10)
with lbskel.StageBar("ring") as bar:
    skeleton = lbskel.skeletonize(mesh, on_stage=bar.show)
"""
SHOWN = {
    "mesh": "mesh",
    "cloud": "lbskel.PointCloud(mesh.vertices)",
    "skeleton": "skeleton",
    "laplacian": "(laplacian := lbskel.laplacian(mesh))",
    "contraction": "(contraction := lbskel.contract(mesh))",
}
PLOTTED = {
    "mesh": "mesh.plot()",
    "skeleton": "skeleton.plot(mesh)",
    "laplacian": "laplacian.plot(mesh)",
    "contraction": "contraction.plot()",
}


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """Of each cell, by name, what it displayed."""
    import nbformat
    from nbclient import NotebookClient

    cells = {"setup": SETUP, "bar": "isinstance(bar._bar, tqdm.notebook.tqdm)"}
    cells |= {f"show {name}": code for name, code in SHOWN.items()}
    cells |= {f"plot {name}": code for name, code in PLOTTED.items()}
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(code) for code in cells.values()])
    folder = tmp_path_factory.mktemp("notebook")
    NotebookClient(notebook, timeout=None, resources={"metadata": {"path": str(folder)}}).execute()
    return {name: cell.outputs for name, cell in zip(cells, notebook.cells, strict=True)}


def displayed(outputs):
    """The one value that a cell shows, by media type."""
    [value] = [output.data for output in outputs if output.output_type == "execute_result"]
    return value


@pytest.mark.parametrize("name", SHOWN)
def test_a_value_at_the_end_of_a_cell_is_shown_as_a_picture(outputs, name):
    value = displayed(outputs[f"show {name}"])
    with Image.open(io.BytesIO(base64.b64decode(value["image/png"]))) as picture:
        assert min(picture.size) > 200
        assert len(picture.convert("L").getcolors()) > 2  # not blank
    assert value["text/plain"].startswith(("Mesh(", "PointCloud(", "Skeleton(", "Laplacian(", "Contraction"))


@pytest.mark.parametrize("name", PLOTTED)
def test_plot_shows_an_interactive_page(outputs, name):
    shown = displayed(outputs[f"plot {name}"])["text/html"]
    assert shown.startswith("<iframe srcdoc=")
    content = html.unescape(shown[len('<iframe srcdoc="') : shown.index('" title=')])
    assert "Plotly" in unpacked(content.encode())


def test_the_bar_is_that_of_notebooks_and_leaves_nothing(outputs):
    assert displayed(outputs["bar"])["text/plain"] == "True"
    kinds = {kind for output in outputs["setup"] for kind in output.get("data", {})}
    assert "application/vnd.jupyter.widget-view+json" in kinds
    assert not [output for output in outputs["setup"] if output.output_type in ("stream", "error")]
