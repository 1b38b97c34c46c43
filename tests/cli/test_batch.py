"""``lbskel batch``: the options reach every skeleton, and pictures and reports lie beside it."""

import csv
import json

from helpers import file_names

from lbskel import read_skeleton, skeletonize


def test_every_option_reaches_the_skeletons(here, folder, rod):
    options = (
        "--min-branch-ratio",
        "2",
        "--tip-position",
        "surface",
        "--nodes",
        "9",
        "--root",
        "0",
        "--anchor",
        "0,0,0.5",
        "--join",
        "none",
        "--min-loop",
        "3",
    )
    code, _, err = here("batch", "rod.off", "-o", "out", "--workers", "1", "--picture", "--report", *options)
    assert (code, err) == (0, [])
    assert file_names(folder / "out") == ["manifest.jsonl", "rod.json", "rod.png", "rod.report.json", "summary.csv"]
    expected = skeletonize(
        rod,
        min_branch_ratio=2.0,
        tip_position="surface",
        n_nodes=9,
        root=0,
        anchors=[[0, 0, 0.5]],
        join="none",
        min_loop=3.0,
    )
    found = read_skeleton(folder / "out" / "rod.json")
    assert (found.nodes == expected.nodes).all()
    report = json.loads((folder / "out" / "rod.report.json").read_text())
    assert report["score"] == expected.report["score"]
    with open(folder / "out" / "summary.csv") as table:
        [row] = csv.DictReader(table)
    assert (row["outcome"], row["nodes"]) == ("passed", "9")


def test_other_options_are_another_batch(here, folder):
    assert here("batch", "rod.off", "-o", "out", "--workers", "1")[0] == 0
    _, again, _ = here("batch", "rod.off", "-o", "out", "--workers", "1")
    assert "  1 from earlier batches" in again[-1]
    _, other, _ = here("batch", "rod.off", "-o", "out", "--workers", "1", "--preprocess", "none")
    assert "  0 from earlier batches" in other[-1]


def test_what_a_batch_has_written_matches_no_pattern_of_the_next(here, folder):
    """Else skeletons would be taken for clouds, and the manifest for a mesh."""
    (folder / "pipe.ply").unlink()
    for n_earlier in (0, 2):
        code, out, err = here("batch", "*", "-o", ".", "--format", "ply", "--workers", "1")
        assert (code, err, out[0]) == (0, [], "2 inputs: 2 passed")
        assert out[1].startswith(f"  {n_earlier} from earlier batches")


def test_exit_codes(here, folder):
    (folder / "bad.off").write_text("OFF\n1 0 0\n0 0 0\n")
    assert here("batch", "rod.off", "bad.off", "-o", "out", "--workers", "1", "--quiet")[0] == 2


def test_a_file_of_the_name_of_a_pattern_is_that_file_and_a_pattern_needs_a_match(here, folder):
    (folder / "rod[1].off").write_bytes((folder / "rod.off").read_bytes())
    (folder / "rod1.off").write_bytes((folder / "rod.off").read_bytes())
    _, out, _ = here("batch", "rod[1].off", "-o", "out", "--workers", "1")
    assert out[0] == "1 input: 1 passed"
    assert (folder / "out" / "rod[1].json").exists()
    code, _, err = here("batch", "rod.off", "none*.off", "-o", "out", "--workers", "1")
    assert (code, err) == (2, ["lbskel: none*.off: no file matches this pattern; correct it, or leave it out"])
    code, _, err = here("batch", "out", "-o", "out", "--workers", "1")
    assert (code, err) == (2, ["lbskel: out: is a folder; name the meshes in it, such as by 'out/*'"])
