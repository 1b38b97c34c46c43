"""The result of a step: composition of maps, fields brought back to the input, the report, the distance of surfaces."""

import numpy as np

from lbskel import Mesh
from lbskel.preprocess.cleaning import merge_close, remove_duplicates


def test_fields_and_labels_are_pulled_back_to_the_input(ring):
    soup = Mesh(ring.vertices[ring.faces].reshape(-1, 3), np.arange(3 * len(ring.faces)).reshape(-1, 3))
    more = Mesh([*soup.vertices, [9, 9, 9]], soup.faces)
    result = merge_close(more).compose(remove_duplicates)
    back = result.pull_back(np.array(result.mesh.vertices))
    assert np.array_equal(back[:-1], soup.vertices)
    assert np.isnan(back[-1]).all()
    labels = result.pull_back(np.arange(len(result.mesh.vertices)))
    assert np.array_equal(labels, result.vertex_map.indices)
