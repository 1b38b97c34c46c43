"""The options of a skeleton: the same for one mesh and for many, and each reaches skeletonize."""

import argparse
import inspect

import pytest

from lbskel import FormatError, MeshError, read_skeleton, skeletonize
from lbskel.cli.main import command_line_parser
from lbskel.cli.options import add_skeleton_options, read_surface, refuse_unwritable, skeleton_options
from lbskel.io import MESH_READERS
from lbskel.io.ply_mesh import read_ply

NOT_OPTIONS = {"mesh", "on_stage", "time_limit", "memory_limit", "profile"}  # given by the commands themselves


def parsed(*arguments):
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_skeleton_options(parser)
    return skeleton_options(parser.parse_args(arguments))


def test_every_parameter_of_skeletonize_has_an_option_with_its_default():
    parameters = inspect.signature(skeletonize).parameters
    assert set(parsed()) == set(parameters) - NOT_OPTIONS
    assert {**parsed(), "anchors": ()} == {name: parameters[name].default for name in parsed()}


def test_values_are_converted():
    options = parsed(
        "--anchor", "3", "--anchor", "1,2.5,-3", "--root", "0,0,1", "--nodes", "9", "--min-branch-ratio", "3"
    )
    assert options["anchors"] == [3, [1.0, 2.5, -3.0]]
    assert (options["root"], options["n_nodes"], options["min_branch_ratio"]) == ([0.0, 0.0, 1.0], 9, 3.0)


@pytest.mark.parametrize("place", ["-0.1,0,0", "-.1,-1e-2,0", "0,0,-1"])
def test_the_first_coordinate_of_a_point_may_be_negative(place, here):
    assert here("skeletonize", "rod.off", "-o", "a.swc", "--root", place, "--quiet") == (0, [], [])


@pytest.mark.parametrize("text", ["x", "1,2", "1,2,3,4", "1,b,3", "1.5"])
def test_what_is_no_vertex_and_no_point_is_refused_in_words(text, here):
    code, out, err = here("skeletonize", "rod.off", "-o", "a.swc", "--root", text)
    assert (code, out) == (2, [])
    assert f"argument --root: must be the index of a vertex or a point as X,Y,Z, not '{text}'" in err[0]


def test_batch_and_skeletonize_have_the_same_skeleton_options():
    commands = command_line_parser()._subparsers._group_actions[0].choices

    def options_of(name):
        return {option for action in commands[name]._actions for option in action.option_strings}

    shared = argparse.ArgumentParser(add_help=False)
    add_skeleton_options(shared)
    expected = {option for action in shared._actions for option in action.option_strings}
    assert expected <= options_of("skeletonize")
    assert options_of("skeletonize") - options_of("batch") == {"--html", "--profile"}  # of one mesh


@pytest.mark.parametrize("name", command_line_parser()._subparsers._group_actions[0].choices)
def test_every_command_has_an_example_and_no_markup_in_its_help(name, here):
    code, out, err = here(name, "--help")
    assert (code, err) == (0, [])
    assert "example:" in out
    assert out[out.index("example:") + 1].strip().startswith(f"lbskel {name} ")
    assert "`" not in "".join(out)


def test_the_ways_to_join_and_the_presets_by_domain():
    assert (parsed()["join"], parsed("--join")["join"], parsed("--join", "none")["join"]) == (None, "all", "none")
    options = parsed("--preset", "neuron", "--min-loop", "3.5")
    assert (options["preset"], options["min_loop"], options["join"]) == ("neuron", 3.5, None)
    assert (options["radius_kind"], parsed("--radius-kind", "mean")["radius_kind"]) == (None, "mean")


@pytest.mark.parametrize(
    "option", [("--join", "some"), ("--preset", "neurons"), ("--min-loop", "short"), ("--radius-kind", "max")]
)
def test_what_is_no_choice_is_refused_with_the_choices(option, here):
    code, out, err = here("skeletonize", "rod.off", "-o", "a.swc", *option)
    assert (code, out) == (2, [])
    assert option[1] in " ".join(err)


def test_a_domain_on_the_command_line_is_that_of_the_function(here, folder, ring):
    assert here("skeletonize", "ring.obj", "-o", "a.json", "--preset", "neuron", "--quiet") == (0, [], [])
    assert read_skeleton("a.json").cycle_rank == 0
    assert here("skeletonize", "ring.obj", "-o", "b.json", "--min-loop", "1", "--quiet") == (0, [], [])
    assert read_skeleton("b.json").cycle_rank == 1


def test_files_that_exist_are_refused_before_anything_is_computed(tmp_path):
    there, missing = tmp_path / "there.ply", tmp_path / "missing.ply"
    there.touch()
    refuse_unwritable([(None, ("csv",)), (missing, ("ply",))], force=False)
    refuse_unwritable([(str(there), ("ply",))], force=True)
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(FormatError, match=r"folder\.ply: is a folder; give the name of a file in it"):
        refuse_unwritable([(tmp_path / "folder.ply", ("ply",))], force=True)
    (tmp_path / "link.ply").symlink_to(tmp_path / "no" / "a.ply")
    with pytest.raises(FormatError, match=r"link\.ply: the folder .*no does not exist; create it first"):
        refuse_unwritable([(tmp_path / "link.ply", ("ply",))], force=False)
    (tmp_path / "same.ply").symlink_to(missing)
    for other in (str(missing), tmp_path / "folder.ply" / ".." / "missing.ply", tmp_path / "same.ply"):
        with pytest.raises(FormatError, match=r"(missing|same)\.ply: is named for two outputs; give each"):
            refuse_unwritable([(missing, ("ply",)), (other, ("ply",))], force=True)
    with pytest.raises(FormatError, match=r"there\.ply exists already; give --force to replace it"):
        refuse_unwritable([(missing, ("ply",)), (str(there), ("ply",))], force=False)


def test_an_input_is_not_replaced_even_if_forced(tmp_path):
    (tmp_path / "a.ply").touch()
    (tmp_path / "link.ply").symlink_to("a.ply")
    for name in ("a.ply", "link.ply"):
        with pytest.raises(FormatError, match=rf"{name}: is an input, and would be lost; give the output another name"):
            refuse_unwritable([(tmp_path / name, ("ply",))], force=True, inputs=[None, str(tmp_path / "a.ply")])
    refuse_unwritable([(tmp_path / "b.ply", ("ply",))], force=True, inputs=[tmp_path / "a.ply"])


@pytest.mark.parametrize(
    ("arguments", "extension"),
    [
        (("geodesic", "--source", "0", "-o", "a.txt"), ".csv"),
        (("geodesic", "--source", "0", "--picture", "a.jpg"), ".png"),
        (("spectrum", "-o", "a.csv"), ".json"),
        (("laplacian", "--picture", "a"), ".png"),
        (("preprocess", "-o", "a.abc"), "one of: .obj, .off, .ply, .stl"),
        (("preprocess", "-o", "b.ply", "--map", "a.csv"), ".npy"),
        (("skeletonize", "-o", "b.swc", "--picture", "a.jpg"), ".png"),
        (("segment", "-o", "b.ply", "--table", "a.json"), ".csv"),
    ],
)
def test_a_name_with_another_extension_is_refused_before_anything_is_read(here, folder, arguments, extension):
    code, out, [line] = here(arguments[0], "none.off", *arguments[1:])
    assert (code, out) == (2, [])
    assert line == f"lbskel: {next(a for a in arguments if a.startswith('a'))}: the name must end in {extension}"


def test_a_surface_is_read_once(folder, monkeypatch):
    times = []
    monkeypatch.setitem(MESH_READERS, "ply", lambda path: times.append(path) or read_ply(path))
    assert len(read_surface("pipe.ply").faces)
    assert len(times) == 1


def test_the_command_that_makes_a_surface_can_be_copied_whatever_the_name_of_the_cloud(folder):
    (folder / "a cloud.xyz").write_text("0 0 0\n1 0 0\n")
    expected = r"lbskel preprocess 'a cloud\.xyz' -o 'a cloud_surface\.ply' writes"
    with pytest.raises(MeshError, match=expected):
        read_surface("a cloud.xyz")
