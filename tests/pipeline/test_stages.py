"""The whole way: what comes back for shapes that are known, for the same shape elsewhere, and for bad input."""

import json
import warnings
from dataclasses import fields, replace
from itertools import product

import numpy as np
import pytest
from helpers import is_whole, joined, moved
from scipy.spatial.transform import Rotation

import lbskel
from lbskel import (
    OPERATORS,
    PRESETS,
    ContractionSettings,
    FormatError,
    Mesh,
    MeshError,
    UnknownChoice,
    ground_truth_distances,
    skeletonize,
    write_mesh,
)
from lbskel.contraction.energies import ENERGIES
from lbskel.contraction.flow import Step
from lbskel.operators.cotangent import cotangent
from lbskel.pipeline import stages
from lbskel.pipeline.assembly import MISSING
from lbskel.shapes import chain_of_tori, coil, cylinder, flat_grid, make, sphere, torus, tube, voxel_surface
from lbskel.solvers import ALL_SOLVERS

T = np.linspace(0, 6, 40)
SHAPES = {
    "ring": (None, 1, 0),
    "rod": (None, 0, 2),
    "two_rings": (None, 2, 0),
    "tripod": (None, 0, 3),
    "helix": (lambda: tube(np.stack([np.cos(T), np.sin(T), 0.3 * T], axis=1), 0.2, sides=10), 0, 2),
    "knot": (lambda: make("knot", n_vertices=1500).mesh, 1, 0),
    "sphere": (lambda: sphere(2), 0, 2),
}


@pytest.fixture(scope="module")
def shape(request):
    """The mesh of a name in SHAPES, made once."""
    made = {}

    def get(name):
        if name not in made:
            make_it = SHAPES[name][0]
            made[name] = make_it() if make_it else request.getfixturevalue(name)
        return made[name]

    return get


@pytest.fixture(scope="module")
def skeleton_of(shape):
    """The skeleton of the mesh of a name in SHAPES, made once."""
    made = {}

    def get(name):
        if name not in made:
            made[name] = skeletonize(shape(name))
        return made[name]

    return get


def graph(skeleton):
    """What two skeletons have in common where they are the same graph."""
    return skeleton.edges.tolist(), skeleton.node_of_vertex.tolist()


def everything(skeleton):
    """All numbers of a skeleton, to the last bit."""
    arrays = skeleton.nodes, skeleton.edges, skeleton.radii, skeleton.node_of_vertex
    return [array.tobytes() for array in arrays]


# --- shapes that are known


@pytest.mark.parametrize("name", SHAPES)
def test_topology_tips_and_checks(name, shape, skeleton_of):
    _, genus, n_tips = SHAPES[name]
    skeleton = skeleton_of(name)
    assert (skeleton.n_components, skeleton.cycle_rank, len(skeleton.tips)) == (1, genus, n_tips)
    assert skeleton.report["passed"] is True
    [part] = skeleton.report["components"]
    assert part["genus"] == genus
    measures = skeleton.report["score"]["measures"]
    assert (measures["inside_fraction"], measures["extra_cycles"], measures["extra_components"]) == (1.0, 0, 0)
    assert part["handles_certified"]
    assert is_whole(skeleton, shape(name))


def test_the_nodes_of_a_ring_are_on_its_circle(skeleton_of):
    """The torus has 16 sections, and their centers a polygon for an axis."""
    x, y, z = skeleton_of("ring").nodes.T
    sagitta = 1 - np.cos(np.pi / 16)
    assert np.abs(np.hypot(x, y) - 1).max() < 2 * sagitta  # half of it is the polygon's, the rest that of oblique cuts
    assert np.abs(z).max() < 1e-3
    assert skeleton_of("ring").length == pytest.approx(2 * np.pi, rel=0.03)
    # inscribed in sections that are octagons; between two of them the outer wall is nearer by its sagitta
    inscribed = 0.25 * np.cos(np.pi / 8)
    radii = skeleton_of("ring").radii
    assert (radii <= inscribed + 2 * sagitta).all()
    assert (radii >= inscribed - 1.25 * sagitta).all()


def test_the_nodes_of_a_rod_are_on_its_axis_up_to_the_centers_of_its_caps(skeleton_of):
    x, y, z = skeleton_of("rod").nodes.T
    assert np.hypot(x, y).max() < 0.01 * 0.4
    # the rod ends 1.9 from the middle and is 0.4 thick: each tip is about a radius inside
    assert z.max() == pytest.approx(1.5, abs=0.1)
    assert z.min() == pytest.approx(-1.5, abs=0.1)


def test_vertices_belong_to_nodes_nearby(shape, skeleton_of):
    """A vertex of a ring is a radius from the axis; its node is no further along than two spacings of half a radius."""
    skeleton, mesh = skeleton_of("ring"), shape("ring")
    apart = np.linalg.norm(mesh.vertices - skeleton.nodes[skeleton.node_of_vertex], axis=1)
    assert apart.max() < np.hypot(0.25, 0.25) + 2 * (1 - np.cos(np.pi / 16))


# --- the same shape elsewhere

SIMILAR = {
    "turned by quarters, scaled, moved": (np.eye(3)[[1, 2, 0]], 3.7, [3, -1, 2]),
    "smaller": (np.eye(3), 1e-6, [0, 0, 0]),
    "larger": (np.eye(3), 1e6, [0, 0, 0]),
}
TURNED = {
    f"turned any way {seed}": (Rotation.random(random_state=seed).as_matrix(), 10.0 ** (seed - 1), [1, -2, seed])
    for seed in range(2)
}
WITHOUT_SYMMETRY = ["tripod", "two_rings", "helix"]


def agrees_with_the_one_elsewhere(mesh, skeleton, R, scale, shift):
    """To 1e-6 of the diagonal, node to node: what rounding does to 16 digits on its way through ten linear systems."""
    other = skeletonize(Mesh(scale * mesh.vertices @ R.T + shift, mesh.faces))
    assert other.edges.tolist() == skeleton.edges.tolist()
    back = (other.nodes - shift) @ R / scale
    assert np.linalg.norm(back - skeleton.nodes, axis=1).max() < 1e-6 * mesh.diagonal
    assert np.abs(other.radii / scale - skeleton.radii).max() < 1e-6 * mesh.diagonal
    return other


@pytest.mark.parametrize("name", WITHOUT_SYMMETRY)
@pytest.mark.parametrize("how", SIMILAR)
def test_a_similar_shape_has_the_similar_skeleton(name, how, shape, skeleton_of):
    other = agrees_with_the_one_elsewhere(shape(name), skeleton_of(name), *SIMILAR[how])
    assert other.node_of_vertex.tolist() == skeleton_of(name).node_of_vertex.tolist()


@pytest.mark.parametrize("name", WITHOUT_SYMMETRY)
@pytest.mark.parametrize("how", TURNED)
def test_a_turned_shape_has_the_turned_skeleton(name, how, shape, skeleton_of):
    other = agrees_with_the_one_elsewhere(shape(name), skeleton_of(name), *TURNED[how])
    assert other.node_of_vertex.tolist() == skeleton_of(name).node_of_vertex.tolist()


def test_a_symmetric_shape_moved_has_the_moved_skeleton(shape, skeleton_of):
    """Vertices that are as near to one node as to another may go to either."""
    agrees_with_the_one_elsewhere(shape("sphere"), skeleton_of("sphere"), np.eye(3), 1.0, [-5.5, 3.3, 1.1])


@pytest.mark.parametrize("seed", [1, 2, 5])
def test_a_body_of_voxels_has_the_turned_skeleton_in_any_pose(seed):
    """Paths along its edges, which are alike, are equally long: no rounding error may choose between them."""
    rng = np.random.default_rng(seed)
    place, filled = np.array([3, 3, 3]), np.zeros((8, 8, 8), dtype=bool)
    for _ in range(61):  # a walk at random
        filled[tuple(place)] = True
        step = np.array(place)
        step[rng.integers(3)] += rng.choice([-1, 1])
        place = step if (step >= 1).all() and (step < 7).all() else place
    mesh = voxel_surface(np.kron(filled, np.ones((2, 2, 2), dtype=bool)))
    turn = Rotation.random(random_state=seed).as_matrix()
    own = skeletonize(mesh)
    turned = skeletonize(Mesh(mesh.vertices @ turn.T, mesh.faces))
    assert np.array_equal(turned.edges, own.edges)
    assert turned.nodes == pytest.approx(own.nodes @ turn.T, abs=1e-9 * mesh.diameter_bound)


@pytest.mark.parametrize("name", WITHOUT_SYMMETRY)
@pytest.mark.parametrize(("scale", "shift"), [(1.0, 1e6), (1e-6, 1.0)])
def test_the_origin_does_not_change_the_graph(name, scale, shift, shape, skeleton_of):
    mesh = shape(name)
    other = skeletonize(Mesh(scale * mesh.vertices + shift, mesh.faces))
    assert other.edges.tolist() == skeleton_of(name).edges.tolist()
    assert other.report["passed"] is True


@pytest.mark.parametrize("scale", [1e-60, 1e60])
def test_extreme_units_give_a_skeleton(scale, rod):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        skeleton = skeletonize(rod.with_vertices(scale * rod.vertices))
    assert (len(skeleton.tips), skeleton.report["passed"]) == (2, True)


# --- the same input again


@pytest.mark.parametrize("name", ["tripod", "ring", "sphere"])
def test_two_runs_give_the_same_bytes(name, shape, skeleton_of):
    assert everything(skeletonize(shape(name))) == everything(skeleton_of(name))


def test_a_run_leaves_the_input_alone(shape):
    V, F = np.array(shape("ring").vertices), np.array(shape("ring").faces)
    before = V.tobytes(), F.tobytes()
    skeletonize((V, F))
    assert (V.tobytes(), F.tobytes()) == before


def test_one_and_two_threads_give_the_same_graph(python, tmp_path, shape):
    write_mesh(tmp_path / "mesh.off", shape("two_rings"))
    code = """
import json, sys
import lbskel
skeleton = lbskel.skeletonize("mesh.off")
print(json.dumps([skeleton.edges.tolist(), skeleton.node_of_vertex.tolist(), skeleton.nodes.tolist()]))
"""
    one, two = (python("-c", code, cwd=tmp_path, OMP_NUM_THREADS=n, OPENBLAS_NUM_THREADS=n) for n in ("1", "2"))
    assert (one.stderr, two.stderr) == ("", "")
    (*first, nodes), (*second, other_nodes) = json.loads(one.stdout), json.loads(two.stdout)
    assert first == second
    # sums in another order, as in a similar shape
    assert np.abs(np.subtract(nodes, other_nodes)).max() < 1e-6 * shape("two_rings").diagonal


# --- choices


OF_MESHES = [name for name in PRESETS if name != "cao2010"]  # that of points: test_point_contraction.py


@pytest.mark.parametrize("preset", OF_MESHES)
@pytest.mark.parametrize("operator", OPERATORS)
def test_every_preset_with_every_operator_gives_a_whole_skeleton(preset, operator, ring):
    if (preset, operator) == ("curvature_flow", "mean_value"):
        with pytest.raises(
            UnknownChoice, match="'mean_value' is not symmetric, which the energy 'curvature_flow' needs"
        ):
            skeletonize(ring, preset=preset, operator=operator)
        return
    skeleton = skeletonize(ring, preset=preset, operator=operator)
    assert is_whole(skeleton, ring)
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, 1)
    assert skeleton.report["settings"]["operator"] == operator


# every solver with one preset, and every preset with one solver
CHOICES = [*product(["au2008"], ENERGIES, ALL_SOLVERS), *product(OF_MESHES, ENERGIES, ["cholmod"])]


@pytest.mark.parametrize(("preset", "energy", "solver"), sorted(set(CHOICES)))
def test_presets_energies_and_solvers(preset, energy, solver, rod):
    skeleton = skeletonize(rod, preset=preset, energy=energy, solver=solver)
    assert is_whole(skeleton, rod)
    assert (skeleton.n_components, skeleton.cycle_rank, len(skeleton.tips)) == (1, 0, 2)
    settings = skeleton.report["settings"]
    assert (settings["energy"], settings["solver"]) == (energy, solver)


def test_solvers_agree(shape, skeleton_of):
    other = skeletonize(shape("tripod"), solver="superlu")
    assert graph(other) == graph(skeleton_of("tripod"))
    # two factorizations differ as two roundings do
    assert np.abs(other.nodes - skeleton_of("tripod").nodes).max() < 1e-6 * shape("tripod").diagonal


def test_names_replace_the_choices_of_the_preset(ring):
    settings = skeletonize(ring, operator="robust", energy="least_squares", solver="superlu").report["settings"]
    assert (settings["operator"], settings["energy"], settings["solver"]) == ("robust", "least_squares", "superlu")


def test_large_meshes_are_contracted_by_a_proxy_and_measured_themselves():
    """A torus of 24,000 faces: the contraction sees at most 16,000, map and score are of all vertices."""
    mesh = torus(1.0, 0.3, 200, 60)
    prepared = lbskel.prepare(mesh)
    [body] = prepared.bodies
    assert len(body.proxy.mesh.faces) <= 16_000 < len(mesh.faces)
    assert len(body.surface.mesh.faces) == len(prepared.surface.mesh.faces) == len(mesh.faces)
    skeleton = skeletonize(mesh)
    assert is_whole(skeleton, mesh)
    # a vertex is a radius from the axis, and at most half the spacing of the nodes along it from its node
    apart = np.linalg.norm(mesh.vertices - skeleton.nodes[skeleton.node_of_vertex], axis=1)
    assert apart.max() < 0.3 * np.hypot(1, 0.5)
    assert len(lbskel.prepare(mesh, simplify="none").bodies[0].proxy.mesh.faces) == len(mesh.faces)


def test_the_branches_of_a_large_mesh_are_centered_in_its_own_vertices():
    shape = make("limbs", n_vertices=9000)
    [body] = lbskel.prepare(shape.mesh).bodies
    assert len(body.proxy.mesh.faces) < len(shape.mesh.faces)
    assert lbskel.ground_truth_distances(skeletonize(shape.mesh), shape.truth).accuracy < 0.015  # the mean of tubes


def test_settings_and_callables_are_taken(ring):
    settings = ContractionSettings(operator="robust", initial_weight=0.05, max_steps=20)
    assert skeletonize(ring, preset=settings).report["settings"]["initial_weight"] == 0.05
    by_name, by_function = skeletonize(ring, operator="cotangent"), skeletonize(ring, operator=cotangent)
    assert everything(by_name) == everything(by_function)
    assert by_function.report["settings"]["operator"] == "cotangent"


def test_what_is_given_as_a_path_or_as_arrays_is_the_same(ring, tmp_path, skeleton_of):
    write_mesh(tmp_path / "ring.ply", ring)
    for given in (tmp_path / "ring.ply", str(tmp_path / "ring.ply"), (ring.vertices, ring.faces)):
        assert everything(skeletonize(given)) == everything(skeleton_of("ring"))


def test_stages_are_told_as_they_begin(ring):
    stages = []
    skeleton = skeletonize(ring, on_stage=stages.append)
    in_order = list(dict.fromkeys(stages))
    assert in_order == list(skeleton.report["seconds"])
    assert [stage for stage in in_order if stage in ("read", "contract", "collapse")] == [
        "read",
        "contract",
        "collapse",
    ]


# --- the report


def test_the_report_says_what_was_done_and_checked(shape, skeleton_of):
    report = skeleton_of("tripod").report
    assert set(report) >= {"input", "settings", "notes", "components", "passed", "seconds", "versions"}
    mesh = shape("tripod")
    assert report["input"] == {"vertices": len(mesh.vertices), "faces": len(mesh.faces), "components": 1}
    [part] = report["components"]
    assert (part["genus"], part["cycle_rank"], part["tips"]) == (0, 0, 3)
    assert part["junctions"] == len(skeleton_of("tripod").junctions)
    assert part["handles_certified"] is True
    assert "volume" in part["status"]
    assert all(seconds >= 0 for seconds in report["seconds"].values())
    assert set(report["versions"]) >= {"python", "lbskel", "numpy", "scipy", "libigl", "cvxopt"}
    assert all(version[0].isdigit() for version in report["versions"].values())


def test_the_report_has_every_step_whole(skeleton_of):
    steps = skeleton_of("tripod").report["components"][0]["steps"]
    assert [set(step) for step in steps] == [{field.name for field in fields(Step)}] * len(steps)
    areas = [1.0, *(step["area_ratio"] for step in steps)]
    assert (np.diff(areas) < 0).all()
    assert steps[-1]["volume_ratio"] <= PRESETS["curvature_flow"].volume_ratio


@pytest.mark.parametrize(("time_limit", "verdict"), [(None, "pass"), (1e-9, "fail")])
def test_passed_and_the_verdict_are_one_decision(shape, time_limit, verdict):
    report = skeletonize(shape("tripod"), time_limit=time_limit).report
    assert report["score"]["verdict"] == verdict
    assert report["passed"] is (verdict != "fail")


def test_the_report_has_the_score_of_the_finished_skeleton(shape, tmp_path):
    """Also with merged vertices, a proxy, another root, and after the skeleton was written and read."""
    mesh = shape("tripod")
    soup_of = mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3)
    fine = torus(1.0, 0.3, 200, 60)
    for given, options in (
        (mesh, {}),
        (soup_of, {}),
        (mesh, {"root": 0, "n_nodes": 30, "anchors": [3]}),
        (fine, {}),
        (fine, {"simplify": "none"}),
        (joined(mesh, moved(mesh, 5.0)), {}),
    ):
        skeleton = skeletonize(given, **options)
        assert lbskel.score(skeleton, given).report() == skeleton.report["score"]
    lbskel.write_skeleton(tmp_path / "a.json", skeleton)
    assert lbskel.score(lbskel.read_skeleton(tmp_path / "a.json"), given).report() == skeleton.report["score"]


def test_a_contraction_that_is_cut_short_says_so(ring):
    report = skeletonize(ring, preset=replace(PRESETS["curvature_flow"], max_steps=2)).report
    assert report["components"][0]["status"] == "the number of steps allowed was reached"


# --- input that is not one closed manifold


def soup(mesh):
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def test_a_soup_of_triangles_is_the_surface(ring, skeleton_of):
    given = soup(ring)
    skeleton = skeletonize(given)
    assert is_whole(skeleton, given)
    assert (skeleton.cycle_rank, skeleton.report["passed"]) == (1, True)
    # the three corners that were one vertex belong to one node
    _, place = np.unique(given.vertices, axis=0, return_inverse=True)
    node_of_place = np.full(place.max() + 1, -1)
    node_of_place[place.ravel()] = skeleton.node_of_vertex
    assert (node_of_place[place.ravel()] == skeleton.node_of_vertex).all()
    assert "merged" in skeleton.report["notes"][0]


def test_unreferenced_vertices_belong_to_the_nearest_node(rod, skeleton_of):
    lone = np.array([[0.0, 0, 5], [0, 0, -5], [3, 0, 0.1]])
    given = Mesh(np.concatenate([lone[:1], rod.vertices, lone[1:]]), rod.faces + 1)
    skeleton = skeletonize(given)
    assert is_whole(skeleton, given)
    ends = skeleton.node_of_vertex[[0, -2, -1]]
    apart = np.linalg.norm(skeleton.nodes[None] - lone[:, None], axis=2)
    assert ends.tolist() == apart.argmin(axis=1).tolist()
    assert skeleton.report["notes"] == ["3 vertices were removed for being in no face"]
    inner = skeleton.node_of_vertex[1:-2]
    assert (skeleton.edges.tolist(), inner.tolist()) == graph(skeleton_of("rod"))


def test_duplicate_and_flat_faces_change_nothing_but_the_notes(ring, skeleton_of):
    F = np.concatenate([ring.faces, ring.faces[:3], ring.faces[5:6, ::-1], [[0, 1, 1]]])
    skeleton = skeletonize((ring.vertices, F))
    assert graph(skeleton) == graph(skeleton_of("ring"))
    assert (skeleton.nodes == skeleton_of("ring").nodes).all()
    assert skeleton.report["notes"][:2] == [
        "1 face was removed for naming a vertex twice: 260",
        "4 duplicate faces were removed: 256, 257, 258, 259",
    ]


def test_zero_area_faces_within_the_surface_are_no_hindrance(rod):
    """One edge is split at a corner of it: two faces of no area in a closed manifold."""
    a, b, c = rod.faces[100]
    [other] = [face for face in rod.faces if {a, b} < set(face) and c not in face]
    d = (set(other) - {a, b}).pop()
    n = len(rod.vertices)
    kept = [face for face in rod.faces.tolist() if {a, b} - set(face)]
    given = Mesh([*rod.vertices, rod.vertices[a]], [*kept, [a, n, c], [n, b, c], [n, a, d], [b, n, d]])
    assert given.genus == 0
    assert (given.face_areas == 0).sum() == 2
    skeleton = skeletonize(given)
    assert is_whole(skeleton, given)
    assert (len(skeleton.tips), skeleton.cycle_rank, skeleton.report["passed"]) == (2, 0, True)


FLAT = "no component of the mesh has an inside: component 0, .* is flat, its two sides only .* of its diameter apart"


def whole_or_refused(mesh, refusal):
    """Whether a skeleton has nothing missing, or where one is expected, that there is the error; no warnings."""
    if refusal is None:
        return is_whole(skeletonize(mesh), mesh)
    with pytest.raises(MeshError, match=refusal):
        skeletonize(mesh)
    return True


@pytest.mark.parametrize(
    ("name", "height"),
    [
        ("ring", 0.0),
        ("ring", 1e-9),
        ("ring", 1e-3),
        ("rod", 0.0),
        ("rod", 1e-9),
        ("rod", 1e-3),
        ("sphere", 0.0),
        ("sphere", 1e-9),
    ],
)
def test_flattened_shapes(name, height, shape):
    mesh = shape(name)
    refusal = None if height == 1e-3 else FLAT
    assert whole_or_refused(mesh.with_vertices(mesh.vertices * [1, 1, height]), refusal)


def test_vertices_on_a_coarse_grid():
    """Faces of no area, vertices in one place, and a surface that meets itself, in one closed manifold."""
    mesh = chain_of_tori(2, step=0.25)
    assert whole_or_refused(mesh.with_vertices(np.round(mesh.vertices)), FLAT)


def test_quads_are_cut_and_it_is_said(ring):
    quads = np.stack([ring.faces[::2, 0], ring.faces[::2, 1], ring.faces[::2, 2], ring.faces[1::2, 2]], axis=1)
    skeleton = skeletonize((ring.vertices, quads))
    assert skeleton.cycle_rank == 1
    assert skeleton.report["notes"][0] == "128 polygons were cut into triangles"


def test_components_are_one_graph(ring, rod, skeleton_of):
    given = joined(ring, moved(rod, 4))
    skeleton = skeletonize(given)
    assert is_whole(skeleton, given)
    assert (skeleton.n_components, skeleton.cycle_rank, len(skeleton.tips)) == (2, 1, 2)
    assert [part["genus"] for part in skeleton.report["components"]] == [1, 0]
    n = len(ring.vertices)
    label = skeleton.component_of_node[skeleton.node_of_vertex]
    assert len(set(label[:n])) == len(set(label[n:])) == 1
    assert label[0] != label[-1]
    assert len(skeleton.nodes) >= len(skeleton_of("ring").nodes) + 2


def test_components_that_enclose_nothing_are_said_and_mapped(rod):
    face = Mesh([[9, 0, 0], [9, 1, 0], [9, 0, 1]], [[0, 1, 2]])
    given = joined(face, rod)
    skeleton = skeletonize(given)
    assert is_whole(skeleton, given)
    assert skeleton.n_components == 1
    assert skeleton.report["notes"] == ["1 component was removed as too small for a skeleton"]
    nearest = np.linalg.norm(skeleton.nodes[None] - face.vertices[:, None], axis=2).argmin(axis=1)
    assert skeleton.node_of_vertex[:3].tolist() == nearest.tolist()


@pytest.mark.parametrize(("preprocess", "checked"), [(None, None), ("auto", True)])
def test_an_open_pipe(preprocess, checked):
    """Its ends are closed unless that is not wanted; then there is no inside to be checked."""
    mesh = cylinder(0.3, 3.0, 12, 16)
    skeleton = skeletonize(mesh, preprocess=preprocess)
    assert is_whole(skeleton, mesh)
    assert (skeleton.n_components, skeleton.cycle_rank, len(skeleton.tips)) == (1, 0, 2)
    [part] = skeleton.report["components"]
    assert part["genus"] == (None if checked is None else 0)
    assert skeleton.report["score"]["measures"]["inside_fraction"] > 0.99
    assert all((step["volume_ratio"] is None) is (checked is None) for step in part["steps"])
    off_axis = np.hypot(*skeleton.nodes.T[:2])
    assert off_axis[skeleton.degrees == 2].max() < 0.01 * 0.3
    assert off_axis.max() < 0.3
    assert np.ptp(skeleton.nodes[:, 2]) > 2.0


def test_a_flat_sheet_gives_no_more_nodes_than_it_has_vertices():
    mesh = flat_grid(6, 6)
    skeleton = skeletonize(mesh)
    assert is_whole(skeleton, mesh)
    assert len(skeleton.nodes) <= 36


def test_a_flipped_face_is_no_hindrance(rod):
    F = np.array(rod.faces)
    F[40] = F[40, ::-1]
    skeleton = skeletonize((rod.vertices, F))
    assert (len(skeleton.tips), skeleton.cycle_rank) == (2, 0)
    assert skeleton.report["score"]["measures"]["extra_cycles"] == 0
    assert "1 face was reversed" in skeleton.report["notes"]


def test_turned_inside_out_it_is_the_same(ring):
    skeleton = skeletonize((ring.vertices, ring.faces[:, ::-1]))
    assert (skeleton.cycle_rank, skeleton.report["passed"]) == (1, True)


def test_surfaces_that_share_a_vertex(rod):
    """Two rods tip to tip are two bodies, taken apart where they touch unless that is not wanted."""
    top = int(np.argmax(rod.vertices[:, 2]))
    n = len(rod.vertices)
    mirrored = rod.vertices * [1, 1, -1] + [0, 0, 2 * rod.vertices[top, 2]]
    F = np.concatenate([rod.faces, np.where(rod.faces == top, top, rod.faces + n)[:, ::-1]])
    both = np.concatenate([rod.vertices, mirrored])
    for preprocess, n_components in (("auto", 2), (None, 1)):
        skeleton = skeletonize((both, F), preprocess=preprocess)
        assert (skeleton.n_components, skeleton.cycle_rank) == (n_components, 0)
        assert len(skeleton.node_of_vertex) == 2 * n


@pytest.mark.parametrize("seed", range(5))
def test_random_triangles_give_a_skeleton_or_an_error_of_lbskel(seed):
    rng = np.random.default_rng(seed)
    mesh = Mesh(rng.normal(size=(30, 3)), rng.integers(0, 30, (60, 3)))
    assert is_whole(skeletonize(mesh), mesh)


# --- input that is no mesh


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (
            ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
            r"no component .* 4 faces and an area, of 1 face in all",
        ),
        ((np.zeros((4, 3)), [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]), "all vertices of the mesh lie at one point"),
        ((np.outer(range(5), [1, 0, 0]), [[0, 1, 2], [1, 2, 3], [2, 3, 4], [0, 3, 4]]), "no component .* and an area"),
        (([[0, 0, 0], [1, 0, 0]], [[0, 1, 1], [0, 0, 1], [1, 1, 0], [0, 1, 0]]), "no component .* and an area"),
        (([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]]), "add a column of zeros"),
        (([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]]), "vertices 2 have NaN"),
        (([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]]), "faces 0 use a vertex index outside"),
        (([], []), "the mesh is empty"),
        (([[0, 0, 0]], []), "it has no faces"),
        (42, "cannot take a mesh from int"),
    ],
)
def test_what_is_no_mesh_is_named(mesh, message):
    with pytest.raises(MeshError, match=message):
        skeletonize(mesh)


def test_files_that_are_no_mesh_are_named(tmp_path):
    (tmp_path / "a.obj").write_text("no mesh")
    for name in ("a.obj", "nosuch.obj", "a.txt"):
        with pytest.raises(FormatError, match=name):
            skeletonize(tmp_path / name)


def test_identity_rows_need_their_energy():
    with pytest.raises(UnknownChoice, match="degenerate_rows='identity' belongs to the energy 'least_squares'"):
        ContractionSettings(degenerate_rows="identity")


def test_a_finished_skeleton_has_both_radii(skeleton_of):
    rod = skeleton_of("rod")
    assert rod.radius_kind == "inscribed"
    assert len(rod.mean_radii) == len(rod.nodes)
    # on average over a section the surface is no nearer than at its nearest
    assert (rod.mean_radii > 0.9 * rod.radii)[rod.degrees == 2].all()


def test_radii_of_the_kind_that_is_asked_for(rod):
    inscribed, mean = (skeletonize(rod, radius_kind=kind) for kind in ("inscribed", "mean"))
    assert (inscribed.radius_kind, mean.radius_kind) == ("inscribed", "mean")
    assert np.array_equal(mean.radii, inscribed.mean_radii)
    assert not np.array_equal(mean.radii, inscribed.radii)
    assert np.array_equal(mean.nodes, inscribed.nodes)
    assert mean.report["score"] == inscribed.report["score"]
    assert skeletonize(rod, preset="neuron").radius_kind == "mean"


def test_in_a_flat_limb_mean_radii_are_larger_than_inscribed_ones(rod):
    skeleton = skeletonize(rod.with_vertices(rod.vertices * [3, 1, 1]))
    inner = skeleton.degrees == 2
    # the mean distance to an ellipse with half axes 1 and 3 from its center is about twice the smaller one
    assert np.median(skeleton.mean_radii[inner] / skeleton.radii[inner]) > 1.4


@pytest.mark.parametrize("name", ["rod", "tripod"])
def test_tips_can_go_to_the_surface(name, shape, skeleton_of):
    inside, at = skeleton_of(name), skeletonize(shape(name), tip_position="surface")
    assert graph_size(at) == graph_size(inside)
    # the ray to the surface is exact to single precision
    assert at.radii[at.tips] == pytest.approx(0, abs=1e-6 * shape(name).diagonal)
    apart = np.linalg.norm(at.nodes[at.tips][:, None] - inside.nodes[inside.tips], axis=2).min(axis=1)
    assert (apart > 0.5 * np.median(inside.radii)).all()


def graph_size(skeleton):
    return len(skeleton.tips), len(skeleton.junctions), skeleton.cycle_rank, skeleton.n_components


def test_a_small_ratio_keeps_branches_that_a_large_one_cuts(shape):
    few, usual = skeletonize(shape("tripod"), min_branch_ratio=12.0), skeletonize(shape("tripod"))
    assert (len(few.tips), len(usual.tips)) == (2, 3)


def test_an_asked_for_number_of_nodes(shape, skeleton_of):
    usual, few = skeleton_of("two_rings"), skeletonize(shape("two_rings"), n_nodes=14)
    assert len(few.nodes) == 14
    assert graph_size(few) == graph_size(usual)
    with pytest.raises(UnknownChoice, match="n_nodes must be at least"):
        skeletonize(shape("two_rings"), n_nodes=2)


def test_an_asked_for_number_of_nodes_puts_none_between_joined_bodies(rod, ring):
    both = joined(rod, moved(ring, 4.0))
    for n_nodes in (14, 50):
        skeleton = skeletonize(both, join="all", n_nodes=n_nodes, anchors=[0])
        assert (len(skeleton.nodes), skeleton.n_components, len(skeleton.anchors)) == (n_nodes, 1, 1)
        assert skeleton.nodes[skeleton.anchors] == pytest.approx(both.vertices[:1])
        (added,) = np.sort(skeleton.report["joining_edges"], axis=1)
        assert (np.sort(skeleton.nodes[skeleton.edges], axis=1) == added).all(axis=(1, 2)).sum() == 1
        assert skeleton.report["score"]["measures"]["inside_fraction"] == 1


def test_the_root_comes_first_and_is_the_root_in_swc(tmp_path, shape, skeleton_of):
    mesh, usual = shape("rod"), skeleton_of("rod")
    for tip in usual.tips:
        reroot = skeletonize(mesh, root=usual.nodes[tip])
        assert np.array_equal(reroot.nodes[0], usual.nodes[tip])
        vertex = int(np.flatnonzero(usual.node_of_vertex == tip)[0])
        assert np.array_equal(skeletonize(mesh, root=vertex).nodes, reroot.nodes)
        assert is_whole(reroot, mesh)
        lbskel.write_skeleton(tmp_path / "a.swc", reroot, force=True)
        assert np.array_equal(lbskel.read_skeleton(tmp_path / "a.swc").nodes[0], usual.nodes[tip])


def test_anchors_are_nodes_and_survive_what_simplifies(shape, skeleton_of):
    mesh, usual = shape("tripod"), skeleton_of("tripod")
    vertex = int(np.argmax(mesh.vertices @ [1.0, 1.0, 0.5]))
    middle = usual.nodes[usual.branches[0]][2:4].mean(axis=0)
    skeleton = skeletonize(mesh, anchors=[vertex, middle])
    assert (skeleton.n_components, skeleton.cycle_rank) == (1, 0)
    assert is_whole(skeleton, mesh)
    for place in (mesh.vertices[vertex], middle):
        for each in (
            skeleton,
            lbskel.prune(skeleton, mesh, min_branch_ratio=50.0),
            lbskel.resample(skeleton, spacing=4.0),
        ):
            # the way to unit size and back costs a rounding
            assert np.linalg.norm(each.nodes[each.anchors] - place, axis=1).min() < 1e-12 * mesh.diagonal
    assert skeleton.report["score"]["measures"]["inside_fraction"] > 0.99


def test_a_wrong_anchor_is_refused(shape):
    mesh = shape("rod")
    for anchor, message in (
        (len(mesh.vertices), "there is no vertex"),
        (-1, "there is no vertex"),
        ([1.0, 2.0], "must be the index of a vertex or a point"),
        ([np.nan, 0.0, 0.0], "must be the index of a vertex or a point"),
        (10 * mesh.vertices[0], "anchor 0 lies outside"),
    ):
        with pytest.raises(MeshError, match=message):
            skeletonize(mesh, anchors=[anchor])
    with pytest.raises(MeshError, match=r"anchors must be a list of vertices or points, such as \[0\]"):
        skeletonize(mesh, anchors=0)


@pytest.mark.parametrize("as_cloud", [False, True])
@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"root": 10**9}, r"there is no (vertex|point) 1000000000"),
        ({"root": [1, [2]]}, "the root must be the index of a vertex or a point of three numbers"),
        ({"root": [1e9, 0, 0]}, "the root .* lies outside"),
        ({"n_nodes": 2.5}, r"n_nodes must be a whole number from 1 to 10,000,000, not 2\.5"),
        ({"n_nodes": 0}, "n_nodes must be a whole number from 1 to 10,000,000, not 0"),
        ({"n_nodes": 10_000_001}, "n_nodes must be a whole number from 1 to 10,000,000, not 10000001"),
    ],
)
def test_a_wrong_root_or_number_is_refused_before_the_contraction(monkeypatch, shape, wrong, message, as_cloud):
    monkeypatch.setattr(stages, "skeletonize_bodies", None)
    given = shape("rod").vertices if as_cloud else shape("rod")
    with pytest.raises((MeshError, UnknownChoice), match=message):
        skeletonize(given, **wrong)


def test_a_name_is_refused_before_the_file_is_read(tmp_path):
    with pytest.raises(UnknownChoice, match="unknown preset 'nosuch'; choose one of: curvature_flow, least_squares"):
        skeletonize(tmp_path / "nosuch.obj", preset="nosuch")


# --- time and memory


def test_a_time_limit_gives_the_best_so_far_and_says_so(ring):
    """No time at all is left after the first look at the clock: one step of none, and nothing refined."""
    skeleton = skeletonize(ring, time_limit=1e-6)
    assert is_whole(skeleton, ring)
    [part] = skeleton.report["components"]
    assert part["status"] == "the time limit was reached, the last good step was kept"
    assert part["steps"] == []
    skipped = ["canonical order", "contract", "merge junctions", "grow limbs", "recenter", "extend tips"]
    skipped += ["prune blunt ends", "mirror", "reroute inside", "fit tubes"]
    missing = "; ".join(f"{stage} ({MISSING[stage]})" for stage in skipped)
    assert skeleton.report["notes"][-1] == f"the time limit was reached, so these stages were left out: {missing}"
    assert everything(skeletonize(ring, time_limit=1e6)) == everything(skeletonize(ring))
    with pytest.raises(UnknownChoice, match="time_limit must be positive"):
        skeletonize(ring, time_limit=0)


def test_a_profile_has_the_memory_of_each_stage(ring):
    report = skeletonize(ring, profile=True).report
    assert "megabytes" not in skeletonize(ring).report
    if report["megabytes"]:  # where the system tells
        assert set(report["megabytes"]) == set(report["seconds"])
        assert all(10 < peak < 10_000 for peak in report["megabytes"].values())


# --- pieces of one body


def open_tube(start, end, aside=0.0):
    """A tube of radius 0.3 along z without its ends."""
    pipe = cylinder(0.3, end - start, 16, 26)
    return pipe.with_vertices(pipe.vertices + [aside, 0, (start + end) / 2])


def test_the_pieces_of_a_broken_tube_have_one_graph():
    """A gap of a third of the reach of ten times the sum of the radii."""
    broken = joined(open_tube(5, 8), open_tube(0, 3))
    whole, apart = skeletonize(broken), skeletonize(broken, join="none")
    assert (whole.n_components, len(whole.tips), whole.report["pieces_joined"]) == (1, 2, 1)
    assert (apart.n_components, len(apart.tips), apart.report["pieces_joined"]) == (2, 4, 0)
    assert whole.length == pytest.approx(8.0)
    assert apart.length == pytest.approx(6.0)
    for skeleton in (whole, apart):
        measures = skeleton.report["score"]["measures"]
        assert (measures["extra_components"], measures["inside_fraction"], measures["shortcut_edges"]) == (0, 1.0, 0)
        assert skeleton.report["passed"] is True
    assert lbskel.score(replace(whole, report={}), broken).extra_components == 0


def test_pieces_that_overlap_are_scored_without_their_joint_alone():
    """A node inside both of them is nearer to vertices of the thinner one, whichever it belongs to."""
    inner = cylinder(0.2, 4.0, 16, 34)
    whole = skeletonize(joined(open_tube(0, 6), inner.with_vertices(inner.vertices + [0.05, 0, 7])))
    assert (whole.n_components, whole.report["pieces_joined"]) == (1, 1)
    assert whole.report["score"]["measures"]["extra_components"] == 0


def test_each_piece_ends_at_its_own_cuts():
    """The gap is two radii wide, so that the other cut is within reach of a tip too."""
    for parts in ((open_tube(0, 3), open_tube(3.6, 6)), (open_tube(3.6, 6), open_tube(0, 3))):
        skeleton = skeletonize(joined(*parts), join="none")
        assert sorted(skeleton.nodes[skeleton.tips, 2]) == pytest.approx([0, 3, 3.6, 6])


@pytest.mark.parametrize(
    "other", [pytest.param((0, 3, 1.5), id="beside"), pytest.param((10, 13, 0.0), id="beyond reach")]
)
def test_open_tubes_that_do_not_continue_each_other_stay_apart(other):
    skeleton = skeletonize(joined(open_tube(0, 3), open_tube(*other)))
    assert (skeleton.n_components, skeleton.report["pieces_joined"]) == (2, 0)


@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)])
def test_pieces_are_joined_alike_in_every_mirror_image(signs):
    """The unit frame may be a mirror image of the mesh, and the cuts were found in it."""
    x = np.linspace(0, 40, 121)
    whole = tube(np.stack([x, 3 * np.sin(x / 6), 0 * x], axis=1), 1.0, sides=12, rounded=True)
    faces = whole.faces[np.abs(whole.vertices[whole.faces].mean(axis=1)[:, 0] - 20) > 0.5]
    skeleton = skeletonize((whole.vertices * signs, faces[:, :: int(np.prod(signs))]))
    assert (skeleton.n_components, len(skeleton.tips)) == (1, 2)


def test_closed_bodies_in_line_stay_apart_unless_all_are_joined(rod):
    pair = joined(rod, rod.with_vertices(rod.vertices + [0, 0, 4.6]))
    assert skeletonize(pair).n_components == 2
    whole = skeletonize(pair, join="all")
    assert (whole.n_components, whole.report["pieces_joined"]) == (1, 1)
    assert whole.report["passed"] is True  # what was asked for is no fault
    assert lbskel.score(replace(whole, report={}), pair).extra_components == -1


@pytest.mark.parametrize("n_turns", [1, 12])
def test_the_skeleton_of_a_coil_is_its_axis_however_long_it_is(n_turns):
    """Its length is 50 or 600 radii: what follows the local radius does not depend on the extent."""
    shape = coil(n_turns)
    skeleton = skeletonize(shape.mesh)
    found = ground_truth_distances(skeleton, shape.truth)
    assert (found.is_topology_right, found.n_tips) == (True, 2)
    # mesh and axis are straight between rings a radius apart: an arc of 8 radii through the rings is off by up to 1/64,
    # by 2/3 of that on average; the tips end at the last ball, a radius before the end of the cap
    assert max(found.accuracy, found.coverage) < 0.012
    assert max(found.accuracy_95, found.coverage_95) < 0.03
    assert skeleton.length == pytest.approx(shape.truth.length, rel=1 / 50)
    assert skeleton.report["score"]["measures"]["coverage"] == 1
    assert skeleton.report["passed"]
