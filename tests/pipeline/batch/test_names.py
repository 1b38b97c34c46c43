"""Names of the files of a batch."""

from pathlib import Path

import pytest

from lbskel import FormatError
from lbskel.pipeline.batch.names import files_of, skeleton_names


def names(files, suffixes=(), extension="json"):
    return skeleton_names([Path("/x", file) for file in files], extension, suffixes)


def test_names_and_those_of_pictures_and_reports_are_unique():
    assert names(["a.off", "a.ply", "a.off.obj"]) == ["a.off.json", "a.ply.json", "a.off.obj.json"]
    assert names(["a.off", "a.report.off"]) == ["a.json", "a.report.json"]
    assert names(["a.off", "a.report.off"], [".report.json"]) == ["a.off.json", "a.report.off.json"]


def test_the_second_file_of_csv_and_the_summary_have_names_of_their_own():
    assert files_of("a/hand.csv", [".png"]) == ["a/hand.csv", "a/hand_edges.csv", "a/hand.png"]
    inputs = ["hand.ply", "hand_edges.ply", "hand.ply_edges.ply", "summary.ply"]
    found = names(inputs, extension="csv")
    assert found == ["hand.ply.csv", "hand_edges.ply.csv", "hand.ply_edges.ply.csv", "summary.ply.csv"]
    assert names(inputs[1:3], extension="csv") == ["hand_edges.csv", "hand.ply_edges.csv"]
    assert names(["a/summary.ply", "b.ply"], extension="csv") == ["a/summary.csv", "b.csv"]


def test_names_stay_in_the_folder_of_the_skeletons_where_inputs_lie_above_another():
    assert names(["b.off", "../y/a.off"]) == ["x/b.json", "y/a.json"]
    with pytest.raises(FormatError, match=r"/x/b\.off is named twice"):
        names(["b.off", "../x/b.off"])
