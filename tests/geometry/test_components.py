"""Connected components: each as a mesh of its own, with the vertices of the whole."""

from unittest.mock import patch

import numpy as np
import pytest
from helpers import joined, moved

from lbskel import Mesh
from lbskel.geometry.components import (
    components,
    find_crumbs,
    find_inner,
    find_twigs,
    set_local_radii_of_components,
)
from lbskel.geometry.shape_diameter import local_radii
from lbskel.geometry.surface_queries import Surface
from lbskel.shapes import capsule, sphere


def test_a_connected_mesh_is_its_only_component(ring):
    [part] = components(ring)
    assert part.mesh is ring
    assert part.vertices.tolist() == list(range(len(ring.vertices)))


def test_components_keep_their_vertices_and_faces(ring, tetrahedron, rod):
    whole = joined(ring, moved(tetrahedron, 4), moved(rod, 8))
    parts = components(whole)
    assert [part.mesh.genus for part in parts] == [1, 0, 0]
    for part, alone in zip(parts, (ring, moved(tetrahedron, 4), moved(rod, 8)), strict=True):
        assert (part.mesh.vertices == alone.vertices).all()
        assert (part.mesh.faces == alone.faces).all()
        assert (whole.vertices[part.vertices] == part.mesh.vertices).all()
    assert np.concatenate([part.vertices for part in parts]).tolist() == list(range(len(whole.vertices)))


def test_the_numbering_of_vertices_does_not_matter(ring, tetrahedron):
    whole = joined(ring, moved(tetrahedron, 4))
    order = np.random.default_rng(0).permutation(len(whole.vertices))
    mixed = Mesh(whole.vertices[order], np.random.default_rng(1).permutation(np.argsort(order)[whole.faces]))
    parts = components(mixed)
    assert sorted((len(part.mesh.vertices), part.mesh.genus) for part in parts) == [(4, 0), (128, 1)]
    assert sum(part.mesh.area for part in parts) == pytest.approx(whole.area)
    assert all((mixed.vertices[part.vertices] == part.mesh.vertices).all() for part in parts)


def test_a_surface_is_inner_if_nearly_all_of_it_is_inside_another(rod):
    around, beside, through = sphere(3), moved(sphere(2), 1.9), rod.with_vertices(rod.vertices * [0.3, 0.3, 1.0])
    within = rod.with_vertices(0.3 * rod.vertices)
    assert find_inner([around, beside, through, within]).tolist() == [False, False, False, True]
    assert find_inner([within, Mesh(around.vertices, around.faces[1:])]).tolist() == [False, False]  # it is open


def test_surfaces_that_cross_are_not_tested_point_by_point(rod):
    """Else hundreds of branches that cross, as of a bush, would take minutes."""
    crossing = [rod.with_vertices(np.roll(rod.vertices, shift, axis=1)) for shift in range(3)]
    with patch.object(Surface, "contains", side_effect=AssertionError):
        assert not find_inner(crossing).any()


def test_unused_vertices_are_in_no_component(tetrahedron):
    V = np.concatenate([[[9, 9, 9]], tetrahedron.vertices, [[8, 8, 8]]])
    [part] = components(Mesh(V, tetrahedron.faces + 1))
    assert part.vertices.tolist() == [1, 2, 3, 4]
    assert part.mesh.genus == 0


def test_surfaces_that_share_one_vertex_are_one_component(tetrahedron):
    V = np.concatenate([tetrahedron.vertices, -tetrahedron.vertices[1:]])
    F = np.concatenate([tetrahedron.faces, np.array([0, 4, 5, 6])[tetrahedron.faces[:, ::-1]]])
    assert len(components(Mesh(V, F))) == 1


def test_crumbs_have_few_faces_and_little_area_or_cannot_enclose_a_volume(ring, tetrahedron):
    """Beside a sphere of 20,480 faces: of 0.2 %, that is 41 faces, and of 0.2 % of its area."""
    ball, small = sphere(5), sphere(0)
    assert len(small.faces) == 20
    parts = {
        "the largest": (ball, False),
        "few faces, little area": (small.with_vertices(0.02 * small.vertices), True),
        "few faces, a large area": (small.with_vertices(0.2 * small.vertices), False),
        "many faces, little area": (ring.with_vertices(0.02 * ring.vertices), False),
        "three faces": (Mesh(3 * tetrahedron.vertices, tetrahedron.faces[1:]), True),
        "no area": (ring.with_vertices(0 * ring.vertices), True),
    }
    whole = joined(*(moved(mesh, 4 * k) for k, (mesh, _) in enumerate(parts.values())))
    assert find_crumbs(whole).tolist() == [is_crumb for _, is_crumb in parts.values()]


def test_no_component_of_equal_ones_is_a_crumb(tetrahedron):
    assert find_crumbs(joined(*(moved(tetrahedron, 2 * k) for k in range(9)))).tolist() == [False] * 9


def test_a_twig_is_long_against_its_width_and_as_thick_as_what_it_was_cut_off(tetrahedron):
    """Beside a rod of radius 0.5; the prism of three sides has 18 faces, and the twig is a capsule without an end."""
    rod, twig = capsule(12.0, 0.5, 16), capsule(3.0, 0.4, 10)
    whole = twig.vertices[twig.faces].mean(axis=1)[:, 2] < twig.vertices[:, 2].max() - 0.3
    ball, prism = sphere(1), tetrahedron.with_vertices(tetrahedron.vertices * [1, 1, 8])
    parts = {
        "cut off": (Mesh(twig.vertices, twig.faces[whole]), True),
        "inside out": (Mesh(twig.vertices, twig.faces[:, ::-1]), True),
        "too short": (ball.with_vertices(0.5 * ball.vertices), False),
        "too thin": (twig.with_vertices(twig.vertices * [0.3, 0.3, 1]), False),
        "too few faces": (prism, False),
    }
    for name, (part, is_twig) in parts.items():
        beside = part.with_vertices(part.vertices + [0, 0, 13])
        for given in (joined(rod, beside), joined(Mesh(rod.vertices, rod.faces[:, ::-1]), beside)):
            assert find_twigs(given, np.array([False, True])).tolist() == [False, is_twig], name
            assert find_twigs(given, np.array([True, True])).tolist() == [False, False]


def test_a_twig_of_a_large_shape_is_no_crumb():
    large, twig = capsule(300.0, 0.5, 40), capsule(3.0, 0.5, 4)
    both = joined(large, twig.with_vertices(twig.vertices + [0, 0, 153]))
    assert len(twig.faces) < 0.002 * len(large.faces)
    thin = twig.with_vertices(twig.vertices * [0.2, 0.2, 0.2] + [0, 0, 153])
    assert find_crumbs(both).tolist() == [False, twig.area > 0.02 * large.area]
    assert find_crumbs(joined(large, thin)).tolist() == [False, True]


def test_local_radii_of_components_do_not_see_the_others(tetrahedron):
    """A ball within another one halves the thickness of that; a crumb has radii, too."""
    outer = sphere(4)
    inner = Mesh(outer.vertices * 0.5, outer.faces)
    whole = joined(outer, inner, moved(Mesh(0.02 * tetrahedron.vertices, tetrahedron.faces), 4))
    n = len(outer.vertices)
    apart = Mesh(whole.vertices, whole.faces)
    set_local_radii_of_components(apart)
    assert find_crumbs(apart).tolist() == [False, False, True]
    assert local_radii(whole)[:n].max() < 0.3
    assert local_radii(apart)[:n].tolist() == local_radii(outer).tolist()
    assert local_radii(apart)[n : 2 * n].tolist() == local_radii(inner).tolist()
    assert (local_radii(apart)[2 * n :] > 0).all()
