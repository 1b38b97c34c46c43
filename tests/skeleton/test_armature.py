"""Rigs: what they check, and linear blend skinning by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lbskel import Mesh, MeshError, Rig

TURN = Rotation.from_euler("z", 90, degrees=True).as_matrix()


def arm(weights=((1, 0), (1, 0), (0.5, 0.5), (0, 1))):
    """Vertices at x = 0, 1, 2, 3 and two bones, from 0 to 2 and from 2 to 4."""
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 0, 0]], [[0, 1, 2], [1, 3, 2]])
    return Rig(mesh, ("upper", "lower"), [[0, 0, 0], [2, 0, 0]], [[2, 0, 0], [4, 0, 0]], [-1, 0], weights)


def test_a_bone_takes_its_children_along_and_shared_vertices_halfway():
    assert arm().posed({}).vertices == pytest.approx(arm().mesh.vertices)
    bent = arm().posed({"lower": TURN}).vertices
    assert bent == pytest.approx(np.array([[0, 0, 0], [1, 0, 0], [1.5, 0.5, 0], [2, 1, 0]]))
    both = arm().posed({"lower": TURN, "upper": TURN}).vertices
    assert both == pytest.approx(bent @ TURN.T)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"names": ("a", "a")}, "names must be different"),
        ({"heads": [[0, 0, 0]]}, r"heads of a rig must have shape \(2, 3\)"),
        ({"weights": np.ones((3, 2))}, r"weights of a rig must have shape \(4, 2\)"),
        ({"parents": [1, -1]}, "must come before it"),
        ({"parents": [-1, -0.5]}, "parents of a rig must be whole numbers"),
        ({"heads": [[0, 0, np.nan], [2, 0, 0]]}, "heads of a rig must be finite"),
        ({"tails": "abc"}, "tails of a rig must be an array of numbers"),
        ({"weights": -np.ones((4, 2))}, "weights of a rig must not be negative"),
    ],
)
def test_what_does_not_fit_is_an_error(changed, message):
    from dataclasses import replace

    with pytest.raises(MeshError, match=message):
        replace(arm(), **changed)


def test_fields_become_constant_arrays_and_a_tuple():
    from dataclasses import replace

    rig = replace(arm(), names=["a", "b"])
    assert (rig.names, rig.parents.dtype) == (("a", "b"), np.int64)
    assert not any(values.flags.writeable for values in (rig.heads, rig.tails, rig.parents, rig.weights))


@pytest.mark.parametrize("turn", [[0, 0, 0.5], np.eye(4)])
def test_a_rotation_must_be_a_matrix(turn):
    with pytest.raises(MeshError, match=r"the rotation of lower must have shape \(3, 3\)"):
        arm().posed({"lower": turn})


def test_an_unknown_bone_is_named():
    with pytest.raises(MeshError, match="has no bone hand; it has upper, lower"):
        arm().posed({"hand": TURN})
