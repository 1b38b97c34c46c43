"""Paragraphs of README.md from the results; that README.md has them is in ``tests/test_readme.py``."""

import json
import re

import pytest

from benchmarks.provenance import ROOT
from benchmarks.readme_paragraphs import PARAGRAPHS, WIDTH, paragraph

RESULTS = ROOT / "benchmarks" / "results"
TYPED = {
    "3.10 3.11 1.26 0.1.0 3.0": "versions, of the license too",
    "2008": "a paper",
    "0 1 2": "exit codes",
    "1 2 3 4 5": "numbers of a list",
    "12 60 16,000 20,000": "defaults of options and constants of the code",
    "4": "pi: a loop of radius 2 in units of its tube's radius",
    "8": "megabytes that every page stays below, in tests/visualization/test_interactive.py",
    "95": "a percentile",
    "3": "of PyGEL3D",
}


@pytest.mark.parametrize("name", PARAGRAPHS)
def test_every_figure_is_filled_in(name):
    text = paragraph(name, RESULTS)
    assert not {"{", "}"} & set(text)
    assert not {"nan", "None"} & set(text.replace(",", " ").split())
    assert max(map(len, text.splitlines())) <= WIDTH


def test_items_of_a_list_are_indented():
    lines = paragraph("limits", RESULTS).splitlines()
    assert {line[:2] for line in lines} == {"- ", "  "}


def doctored(tmp_path, name, table, where, change):
    """A folder of results, in one of which rows are changed."""
    for path in RESULTS.glob("*.json"):
        (tmp_path / path.name).symlink_to(path)
    document = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    rows = [row for row in document[table] if all(row.get(key) == value for key, value in where.items())]
    assert rows
    for row in rows:
        row |= change
    (tmp_path / f"{name}.json").unlink()
    (tmp_path / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "result", "table", "where", "change", "told"),
    [
        ("waits", "interrupts", "interrupts", {"what": "in Python"}, {"faces": 12_345}, "of 12,345 faces within"),
        ("page", "page", "loads", {}, {"on the screen": 7.0}, "on the screen after 7.00 s, or after 7.00 s"),
        ("rig", "rig", "cylinders", {"in radii": 2.0}, {"bone heat": 0.5}, "of two radii on a cylinder 50 %"),
        ("rig", "rig", "weights", {}, {"Blender: difference": 0.5}, "nearest, measured as there ([rigs]"),
        (
            "limits",
            "applications_geodesics",
            "several",
            {},
            {"lbskel, s": 3.0, "potpourri3d, s": 1.0},
            "up to 3.0 times",
        ),
        (
            "spectra",
            "applications_spectrum",
            "signatures",
            {"what": "heat kernel"},
            {"difference": 5e-12},
            "to 5.0e-12;",
        ),
    ],
)
def test_a_figure_is_that_of_the_result(tmp_path, name, result, table, where, change, told):
    folder = doctored(tmp_path, result, table, where, change)
    assert told in " ".join(paragraph(name, folder).split())


CLAIMS = [  # what README.md says, and a result that says otherwise
    ("smoothing", "applications_smoothing", "rows", {"tool": "trimesh taubin"}, {"seconds": 0.0}, "less time than any"),
    ("smoothing", "applications_smoothing", "rows", {"tool": "MeshLab HC"}, {"error": 0.0}, "is as close as lbskel"),
    ("smoothing", "applications_smoothing", "rows", {"tool": "lbskel taubin"}, {"error": 0.0}, "closest to the clean"),
    ("smoothing", "applications_smoothing", "rows", {"tool": "lbskel taubin"}, {"seconds": 0.0}, "is the fastest"),
    ("editing", "applications_editing", "exactness", {"method": "arap"}, {"rotation by 120 degrees": 1e-3}, "is exact"),
    (
        "editing",
        "applications_editing",
        "operators",
        {"operator": "`cotangent`"},
        {"needles": 0.0},
        "throw a surface off",
    ),
    ("spectra", "applications_spectrum", "compression", {"functions": 400}, {"rms error": 1.0}, "a smaller error than"),
    ("parts", "parts", "boundaries", {"mesh": "hand"}, {"parts in pieces": 1}, "every part is connected"),
    ("rig", "rig", "programs", {"mesh": "hand"}, {"Blender: same bones": "no"}, "Blender finds the same bones"),
    ("rig", "rig", "programs", {"mesh": "hand"}, {"warnings": 1}, "no error and no warning"),
    ("rig", "rig", "weights", {"mesh": "hand"}, {"Blender: difference": "an error"}, "Blender finds none"),
    ("installation", "installation", "without_compiler", {}, {"as Python": 2.0}, "many times slower"),
    ("inside", "skeletons", "shapes", {"tool": "lbskel"}, {"inside_fraction": 0.99}, "inside the surface"),
    ("changes", "robustness", "rows", {"kind": "turn"}, {"moved, 95 %": 1e-9}, "moves no skeleton but for rounding"),
    ("laplacians", "operators_convergence", "rows", {"operator": "robust"}, {"order": 1.0}, "of second order"),
    ("laplacians", "operators_speed", "rows", {"call": "cotangent"}, {"ratio to libigl": 9.0}, "where the time counts"),
    ("limits", "neurons", "tubes", {"tool": "lbskel"}, {"sections": "9/8"}, "have fewer sections than the tracings"),
    ("limits", "neurons", "summary", {"tool": "lbskel"}, {"cpu seconds": 0.0}, "are faster on neurons"),
    ("limits", "speed", "ratios", {"reference": "lbskel"}, {"CGAL medial": 2.0}, "CGAL is faster on small meshes"),
    ("limits", "speed", "ratios", {"reference": "lbskel full"}, {"CGAL medial": 2.0}, "at full resolution"),
    ("limits", "vessels", "rows", {"tool": "lbskel"}, {"accuracy": 0.0}, "is nearer to the axes of coils"),
    ("limits", "rig", "rows", {"mesh": "cat"}, {"least": 1.0}, "keep more of their volume with Blender's weights"),
    (
        "limits",
        "stability",
        "rows",
        {"variant": "turned"},
        {"meshes with other tips": 1},
        "rotation and a reflection change no tips",
    ),
    ("limits", "applications_geodesics", "several", {}, {"lbskel, s": 0.0}, "are faster in potpourri3d and libigl"),
    ("limits", "applications_geodesics", "several", {}, {"lbskel, mean error": 1.0}, "have larger errors of geodesics"),
]


@pytest.mark.parametrize(("name", "result", "table", "where", "change", "told"), CLAIMS)
def test_a_sentence_that_the_results_do_not_bear_out_is_refused(tmp_path, name, result, table, where, change, told):
    with pytest.raises(ValueError, match=f"^README.md says: .*{re.escape(told)}"):
        paragraph(name, doctored(tmp_path, result, table, where, change))


def test_every_claim_has_a_result_that_says_otherwise():
    calls = [
        call
        for path in (ROOT / "benchmarks").glob("readme_*.py")
        if path.stem != "readme_figures"
        for call in re.findall(r"^ +claim\($|^ +claim\(.*$", path.read_text(encoding="utf-8"), re.M)
    ]
    assert len(calls) == len(CLAIMS)


def test_no_measured_figure_is_typed():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for left_out in (
        r"^```.*?^```$",  # code
        r"<!-- \w+ -->.*?<!-- end -->",  # what is written from the results
        r"`[^`]*`",
        r"!\[[^\]]*\]|\]\([^)]*\)|https?://\S+",  # captions of pictures, and addresses
    ):
        text = re.sub(left_out, "", text, flags=re.M | re.S)
    found = set(re.findall(r"\d[\d,.]*\d|\d", text))
    assert found == {figure for figures in TYPED for figure in figures.split()}
