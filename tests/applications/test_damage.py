"""Every application on every kind of damage: a finite result or an error of lbskel, and no warning."""

import warnings

import numpy as np
import pytest

import lbskel
from benchmarks.damage import DAMAGE, damaged
from lbskel.applications.deformation_methods import EDITING_METHODS
from lbskel.applications.smoothing import SMOOTHING_METHODS
from lbskel.shapes import torus

APPLICATIONS = {
    **{
        f"smooth {method}": lambda mesh, method=method: lbskel.smooth(mesh, method=method).vertices
        for method in SMOOTHING_METHODS
    },
    **{
        f"edit {method}": lambda mesh, method=method: (
            lbskel.edit(mesh, [[0, 1], [2]], [np.eye(4), lbskel.rigid_motion(angle_deg=20)], method=method).vertices
        )
        for method in EDITING_METHODS
    },
    "reconstruct": lambda mesh: lbskel.reconstruct(mesh, lbskel.delta_coordinates(mesh), [0]).vertices,
    "reconstruct, soft": lambda mesh: (
        lbskel.reconstruct(mesh, lbskel.delta_coordinates(mesh), [0], anchor_weight=1.0).vertices
    ),
    "least_squares_mesh": lambda mesh: lbskel.least_squares_mesh(mesh, 20)[0].vertices,
    "quantize_deltas": lambda mesh: lbskel.quantize_deltas(mesh).mesh.vertices,
    "smooth, volume kept": lambda mesh: lbskel.smooth(mesh, keep_volume=True).vertices,
}
MAKES_FILES = ("truncated", "malformed", "3 GB")  # what a file is damaged by is read_mesh's business


@pytest.mark.parametrize("kind", [kind for kind in DAMAGE if not kind.startswith(MAKES_FILES)])
@pytest.mark.parametrize("name", APPLICATIONS)
def test_a_damaged_mesh_gives_finite_values_or_an_error_of_lbskel(name, kind):
    broken = damaged(kind, torus(1.0, 0.3, 18, 9))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            values = APPLICATIONS[name]((broken.vertices, broken.faces))
        except lbskel.LbskelError:
            return
    assert np.isfinite(values).all()
