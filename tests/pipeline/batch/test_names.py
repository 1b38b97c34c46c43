"""Names of the files of a batch."""

from pathlib import Path

from lbskel.pipeline.batch.names import skeleton_names


def test_names_and_those_of_pictures_and_reports_are_unique():
    def names(files, suffixes=()):
        return skeleton_names([Path("/x", file) for file in files], "json", suffixes)

    assert names(["a.off", "a.ply", "a.off.obj"]) == ["a.off.json", "a.ply.json", "a.off.obj.json"]
    assert names(["a.off", "a.report.off"]) == ["a.json", "a.report.json"]
    assert names(["a.off", "a.report.off"], [".report.json"]) == ["a.off.json", "a.report.off.json"]
