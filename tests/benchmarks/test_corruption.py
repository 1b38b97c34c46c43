"""Broken meshes: each kind of damage gives a skeleton that stands for the shape, or an error that says why not."""

import numpy as np
import pytest
import trimesh
from helpers import joined, moved

from benchmarks.corruption import damage_sections, is_refusal, outcome_sections
from benchmarks.damage import DAMAGE, damaged
from lbskel import Mesh, Skeleton, read_mesh, score, skeletonize
from lbskel.errors import LbskelError, MeshError
from lbskel.shapes import capsule, chain_of_tori, torus

# Each kind on one of three shapes; all on all are in the benchmark
SHAPES = (torus(1.0, 0.3, 28, 14), capsule(3.0, 0.4, 16), chain_of_tori(2, step=0.2))
SLOW = {"50 shells"}  # has a test of its own


def attempt(broken, folder):
    """The skeleton, or the error of lbskel's."""
    if not broken.extension:
        return skeletonize((broken.vertices, broken.faces))
    path = folder / f"broken.{broken.extension}"
    path.write_bytes(broken.data)
    return skeletonize(path)


def passes(skeleton, reference):
    """Whether the score passes on the sound mesh; at unit size, since areas of tiny meshes vanish."""
    size = reference.diameter_bound
    alone = Skeleton(skeleton.nodes / size, skeleton.edges, skeleton.radii / size)
    return score(alone, reference.with_vertices(reference.vertices / size)).passed


@pytest.mark.parametrize("kind", [kind for kind in DAMAGE if kind not in SLOW])
def test_a_broken_mesh_gives_a_skeleton_that_passes_or_a_reason(kind, tmp_path):
    broken = damaged(kind, SHAPES[list(DAMAGE).index(kind) % 3])
    if broken.reference is None:
        with pytest.raises(LbskelError) as error:
            attempt(broken, tmp_path)
        assert len(str(error.value)) > 20
        return
    skeleton = attempt(broken, tmp_path)
    assert np.isfinite(skeleton.nodes).all()
    assert len(skeleton.edges) > 0
    assert passes(skeleton, broken.reference)
    assert len(skeleton.node_of_vertex) == len(broken.vertices)


@pytest.mark.parametrize("how", [None, "scan", "game", "organic"])
@pytest.mark.parametrize("kind", ["duplicate faces", "soup", "edge of three faces", "all on a line", "T-junctions"])
def test_no_way_of_preparing_breaks(kind, how):
    broken = damaged(kind, SHAPES[0])
    try:
        skeleton = skeletonize((broken.vertices, broken.faces), preprocess=how)
    except LbskelError:
        assert kind == "all on a line" or (kind, how) == ("soup", None)
    else:
        assert np.isfinite(skeleton.nodes).all()


def test_shells_are_graphs_of_their_own():
    """Crumbs of eight faces beside a rod; the rod's own skeleton is as it is alone."""
    octahedron = Mesh(
        0.05 * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]),
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
    )
    rod = capsule(3.0, 0.4, 16)
    crumbs = [moved(octahedron, 2 + 0.2 * number) for number in range(11)]
    whole = joined(rod, *crumbs)
    skeleton = skeletonize(whole, preprocess=None)  # which would refine each of them
    assert skeleton.n_components == 12
    assert np.isfinite(skeleton.nodes).all()
    label = skeleton.component_of_node[skeleton.node_of_vertex]
    assert len(np.unique(label[: len(rod.vertices)])) == 1
    kept = skeletonize(whole, preprocess="keep_components")
    assert (kept.n_components, len(kept.tips)) == (1, 2)


def test_crumbs_beside_a_fine_mesh_are_passed_over():
    """More vertices than an end is looked for at: some crumbs have none of those."""
    fine = torus(1.0, 0.3, 70, 40)
    crumbs = [Mesh(0.05 * np.eye(3) + [2.0 + 0.1 * number, 0, 0], [[0, 1, 2]]) for number in range(12)]
    skeleton = skeletonize(joined(fine, *crumbs), preprocess=None)
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, 1)


@pytest.mark.parametrize("size", [2.0**200, 2.0**-200])
def test_sizes_beyond_single_precision_pass_through_a_pipeline(size):
    given = capsule(3.0, 0.4, 16)
    skeleton = skeletonize((size * given.vertices, given.faces), preprocess="organic")
    assert skeleton.length == pytest.approx(size * skeletonize(given, preprocess="organic").length, rel=1e-6)


def test_a_hair_is_taken_and_what_is_thinner_is_named():
    given = capsule(3.0, 0.4, 12)
    hair = skeletonize(given.with_vertices(given.vertices * [0.01, 0.01, 1]))
    assert (len(hair.tips), hair.report["passed"]) == (2, True)
    with pytest.raises(MeshError, match=r"two sides only .* of its diameter apart"):
        skeletonize(given.with_vertices(given.vertices * [1e-6, 1e-6, 1]))


def test_outcomes_are_counted_by_name_and_by_damage():
    rows = [
        {"tool": "a", "damage": "x", "outcome": "pass"},
        {"tool": "a", "damage": "x", "outcome": "crash"},
        {"tool": "a", "damage": "y", "outcome": "pass"},
    ]
    first, each = outcome_sections("All", rows, "tool", {"pass": "is good", "crash": "is bad"}).values()
    assert "| pass | 2 |" in first
    assert "- *crash*: is bad" in first
    assert "| x | 1 pass, 1 crash |" in each
    assert "| y | pass |" in each


def test_undamaged_shapes_meshes_and_files_are_told_apart():
    rows = [
        {"tool": "a", "damage": kind, "of": of, "shape": shape, "outcome": "pass"}
        for kind, of in (("none", "none"), ("x", "mesh"), ("y", "mesh"), ("z", "file"))
        for shape in ("ring", "rod")
    ]
    sections = damage_sections(rows, "tool", {"pass": "is good"})
    assert list(sections) == [
        "Undamaged shapes",
        "Damage of meshes: 2 kinds on 2 shapes",
        "Damage of meshes, each kind",
        "Damage of files: 1 kinds on 2 shapes",
        "Damage of files, each kind",
    ]
    assert [text.count("| pass | 2 |") for text in sections.values()] == [1, 0, 0, 1, 0]


@pytest.mark.parametrize("reader", [read_mesh, trimesh.load])
def test_the_same_sentence_is_a_refusal_of_every_tool(reader, tmp_path):
    """Of a file that is not there both say so; an error out of numpy is no refusal, whoever calls it."""
    with pytest.raises(Exception, match="no_such_file") as error:
        reader(tmp_path / "no_such_file.off")
    assert is_refusal(error.value)
    with pytest.raises(ValueError, match="cannot reshape") as inner:
        np.zeros(3).reshape(2, 2)
    assert not is_refusal(inner.value)
