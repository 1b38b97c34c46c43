"""Rigs of known shapes: bones, symmetry, weights, and what is left of a bent limb."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import triangle_soup, with_reversed_faces
from scipy.spatial.transform import Rotation

from lbskel import Mesh, MeshError, UnknownChoice, rig, skeletonize
from lbskel.applications.mirror import find_mirror_plane
from lbskel.shapes import capsule, make


@pytest.fixture(scope="module")
def dinosaur():
    """A body with neck, tail and four legs; the plane y = 0 is one of symmetry, but not of its triangles."""
    mesh = make("dinosaur", n_vertices=1000).mesh
    return rig(mesh, skeletonize(mesh))


def test_a_dinosaur_has_a_spine_and_pairs_of_legs(dinosaur):
    names = dinosaur.names
    assert names[0] == "root"
    assert len(names) <= 30
    left = [name for name in names if "_left_" in name]
    assert len({name.split("_left")[0] for name in left}) == 2  # hind legs and fore legs
    assert sorted(name.replace("_left", "_right") for name in left) == sorted(n for n in names if "_right_" in n)
    assert sum(name.startswith("spine") for name in names) >= 4
    plane = find_mirror_plane(dinosaur.mesh)
    for name in left:
        here, there = names.index(name), names.index(name.replace("_left", "_right"))
        assert plane.heights(dinosaur.heads[[here]])[0] > 0
        assert plane.mirrored(dinosaur.heads[[here]]) == pytest.approx(dinosaur.heads[[there]])
        assert plane.mirrored(dinosaur.tails[[here]]) == pytest.approx(dinosaur.tails[[there]])


def test_the_limbs_without_a_bone_are_told(dinosaur):
    mesh = dinosaur.mesh
    assert dinosaur.notes == ()
    few = rig(mesh, skeletonize(mesh), max_bones=4)
    assert few.heads[0] == pytest.approx(dinosaur.heads[0])
    assert "got no bone, with max_bones 4: with the ends (" in few.notes[0]
    assert len(few.names) <= 4


def test_weights_are_smooth_shares_of_at_most_four_bones(dinosaur):
    weights, edges = dinosaur.weights, dinosaur.mesh.edges
    assert weights.sum(axis=1) == pytest.approx(1)
    assert (weights > 0).sum(axis=1).max() <= 4
    assert np.abs(weights[edges[:, 0]] - weights[edges[:, 1]]).max() < 0.5


def test_weights_of_a_symmetric_mesh_are_mirrored(dinosaur):
    twins = mirrored_dinosaurs(dinosaur.mesh)
    plane = find_mirror_plane(twins)
    n = len(twins.vertices)
    assert plane.twins.tolist() == np.roll(np.arange(n), -n // 2).tolist()
    found = rig(twins, skeletonize(twins))
    names = list(found.names)
    pair = [names.index(n.replace("_left_", "_right_")) if "_left_" in n else -1 for n in names]
    assert sum(there >= 0 for there in pair) >= 8
    for here, there in enumerate(pair):
        if there >= 0:
            assert found.weights[:, here] == pytest.approx(found.weights[plane.twins, there], abs=0.01)


@pytest.mark.parametrize("radius", [0.3, 0.5])
def test_a_bent_limb_keeps_most_of_its_volume(radius):
    mesh = capsule(8.0, radius, 32)
    found = rig(mesh, skeletonize(mesh))
    bent = found.posed({found.names[-1]: Rotation.from_euler("y", 90, degrees=True).as_matrix()})
    assert 0.8 < bent.volume / mesh.volume < 1.05
    assert np.ptp(bent.vertices[:, 0]) > 2


def test_scale_and_place_do_not_matter(dinosaur):
    mesh = dinosaur.mesh.with_vertices(1e3 * dinosaur.mesh.vertices + 7)
    there = rig(mesh, skeletonize(mesh))
    assert there.names == dinosaur.names
    assert (there.heads - 7) / 1e3 == pytest.approx(dinosaur.heads, abs=1e-5)
    assert there.weights == pytest.approx(dinosaur.weights, abs=1e-3)


@pytest.mark.parametrize("every", [1, 2])
def test_the_orientation_of_the_faces_does_not_matter(dinosaur, every):
    mesh = with_reversed_faces(dinosaur.mesh, np.arange(0, len(dinosaur.mesh.faces), every))
    found = rig(mesh, skeletonize(mesh))
    assert found.mesh is mesh
    assert found.weights == pytest.approx(dinosaur.weights, abs=1e-9)


def test_vertices_at_one_place_have_the_same_weights(rod):
    soup = triangle_soup(rod)
    found, expected = (rig(mesh, skeletonize(mesh)) for mesh in (soup, rod))
    assert found.heads == pytest.approx(expected.heads)
    assert found.weights == pytest.approx(expected.weights[rod.faces.ravel()], abs=1e-9)


def mirrored_dinosaurs(half):
    """A mesh and its mirror image."""
    V = np.concatenate([half.vertices + [0, 1.2, 0], half.vertices * [1, -1, 1] - [0, 1.2, 0]])
    return Mesh(V, np.concatenate([half.faces, half.faces[:, ::-1] + len(half.vertices)]))


def test_vertices_at_one_place_of_a_symmetric_mesh_have_the_same_weights(dinosaur):
    mesh = mirrored_dinosaurs(dinosaur.mesh)
    skeleton = skeletonize(mesh)
    expected = rig(mesh, skeleton)
    corners = mesh.faces.ravel()
    found = rig(triangle_soup(mesh), replace(skeleton, node_of_vertex=skeleton.node_of_vertex[corners]))
    assert found.names == expected.names
    assert found.weights == pytest.approx(expected.weights[corners], abs=1e-9)


@pytest.mark.parametrize("name", ["dinosaur", "octopus"])
def test_the_direction_of_the_axes_does_not_change_the_weights(name):
    mesh = make(name, n_vertices=1000).mesh
    skeleton = skeletonize(mesh)
    upright = rig(mesh, skeleton)
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # y up to z up
    turned = rig(mesh.with_vertices(mesh.vertices @ turn.T), replace(skeleton, nodes=skeleton.nodes @ turn.T))
    assert turned.heads == pytest.approx(upright.heads @ turn.T, abs=1e-9)
    assert turned.weights == pytest.approx(upright.weights, abs=1e-9)


def test_wrong_input_is_an_error(rod):
    skeleton = skeletonize(rod)
    with pytest.raises(MeshError, match="give the mesh that the skeleton was made from"):
        rig(capsule(3.0, 0.4, 12), skeleton)
    unknown = replace(skeleton, radii=np.full(len(skeleton.nodes), np.nan))
    with pytest.raises(MeshError, match="the radius of node 0 is not known"):
        rig(rod, unknown)
    with np.errstate(all="ignore"):
        for size, message in ((0.0, "no size: all its vertices are at one point"), (1e160, "too large for its area")):
            with pytest.raises(MeshError, match=message):
                rig(rod.with_vertices(size * rod.vertices), skeleton)
    for name in ("max_influences", "max_bones"):
        for number in (0, 1.5):
            with pytest.raises(UnknownChoice, match=f"{name} must be a whole number from 1 on, not {number}"):
                rig(rod, skeleton, **{name: number})
    assert rig(rod, skeleton, max_bones=1).names == ("root",)
