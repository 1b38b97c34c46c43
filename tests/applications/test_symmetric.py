"""What a spectrum and the heat equation refuse."""

import numpy as np
import pytest
from scipy.sparse import csc_array

from lbskel import Laplacian, MeshError, laplacian
from lbskel.applications.symmetric import is_symmetric, require_symmetric


def test_operators_that_are_not_symmetric_or_have_no_mass_are_refused(ring):
    L = laplacian(ring)
    require_symmetric(L)
    with pytest.raises(MeshError, match="'mean_value_symmetric'"):
        require_symmetric(laplacian(ring, operator="mean_value"))
    with pytest.raises(MeshError, match="no area"):
        require_symmetric(Laplacian(L.stiffness, csc_array(L.mass.shape)))
    S = L.stiffness.tolil()
    S[0, 1] *= 1 + 1e-9  # far above the rounding of a sum, far below any difference that a formula makes
    with pytest.raises(MeshError, match="not symmetric"):
        require_symmetric(Laplacian(csc_array(S), L.mass))
    assert np.isfinite(L.mass.sum())


def test_a_matrix_is_symmetric_up_to_rounding(ring):
    S = laplacian(ring).stiffness
    assert is_symmetric(S)
    assert not is_symmetric(csc_array([[1.0, 3.0], [-1.0, 1.0]]))
