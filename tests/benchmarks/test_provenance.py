"""Records of results: what a benchmark imports, and which changes count."""

import hashlib
import json
import shutil

import pytest

from benchmarks import provenance
from benchmarks.harness import save_json
from benchmarks.provenance import ROOT, code_digests, imported_modules, mesh_files, run, stale

RESULTS = ROOT / "benchmarks" / "results"


@pytest.fixture
def clone(tmp_path):
    """A repository with two packages, of which the benchmark ``one`` uses the first through the public names."""
    for name, text in {
        "lbskel/__init__.py": "if True:\n    from lbskel.first.sums import add\n",
        "lbskel/first/__init__.py": "",
        "lbskel/first/sums.py": '"""Sums."""\n\nimport lbskel.errors\n\n\ndef add(a, b):\n    return a + b\n',
        "lbskel/second/products.py": "def multiply(a, b):\n    return a * b\n",
        "lbskel/errors.py": "class LbskelError(Exception):\n    pass\n",
        "benchmarks/one.py": "import lbskel\n\n\ndef run(quick, results):\n    lbskel.add(1, 2)\n",
        "benchmarks/all.py": "def run(quick, results):\n    pass\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def copied(clone, name, old, new):
    """The same repository with a text replaced in one file, in another folder: what is read is kept by folder."""
    copy = clone.parent / f"{clone.name}-{hashlib.sha256(new.encode()).hexdigest()[:6]}"
    shutil.copytree(clone, copy)
    (copy / name).write_text((copy / name).read_text().replace(old, new))
    return copy


def test_what_is_imported_through_others_and_through_public_names_counts(clone):
    assert imported_modules("benchmarks.one", clone) == {"benchmarks.one", "lbskel.first.sums", "lbskel.errors"}
    assert set(code_digests("one", clone)) == {"benchmarks.one", "lbskel.first", "lbskel.errors"}


def test_a_benchmark_that_imports_nothing_depends_on_everything(clone):
    assert {"lbskel.first", "lbskel.second", "lbskel.errors"} < set(code_digests("all", clone))


@pytest.mark.parametrize(
    ("name", "old", "new", "changed"),
    [
        ("lbskel/first/sums.py", "a + b", "a - b", ["lbskel.first"]),
        ("lbskel/first/sums.py", '"""Sums."""', '"""Sums of two numbers."""\n# which may be negative\n', []),
        ("lbskel/second/products.py", "a * b", "b * a", []),
        ("benchmarks/one.py", "add(1, 2)", "add(3, 4)", ["benchmarks.one"]),
    ],
)
def test_packages_whose_code_has_changed_are_named(clone, name, old, new, changed):
    assert stale("one", code_digests("one", clone), copied(clone, name, old, new)) == changed


def test_meshes_are_known_by_their_content_and_have_a_source(tmp_path, monkeypatch):
    digest = "0855c353c8a126265186a268bbc57583247a8d131a7e602f0e48ac6105a09c48"
    (tmp_path / "a.off").write_bytes(b"OFF\n")
    assert mesh_files([tmp_path / "a.off"]) == [{"name": "a.off", "sha256": digest, "source": "not known"}]
    (tmp_path / "sources.json").write_text(json.dumps({digest: "a shop"}))
    monkeypatch.setattr(provenance, "SOURCES", tmp_path / "sources.json")
    assert [each["source"] for each in mesh_files([tmp_path / "a.off", ROOT / "meshes" / "knot.off"])] == [
        "a shop",
        "lbskel.shapes, as meshes/README.md says",
    ]


def test_sources_are_of_files_by_their_digest():
    sources = json.loads(provenance.SOURCES.read_text(encoding="utf-8"))
    assert all(len(digest) == 64 and source for digest, source in sources.items())


def test_a_result_is_up_to_date_when_it_is_written_and_changes_since_are_named(tmp_path, capsys):
    save_json(tmp_path / "topology.json", {"rows": []}, meshes=[ROOT / "meshes" / "knot.off"])
    run(False, tmp_path)
    assert capsys.readouterr().out == "topology: up to date\n"
    document = json.loads((tmp_path / "topology.json").read_text())
    assert document["machine"]["commit"]
    assert [mesh["name"] for mesh in document["machine"]["meshes"]] == ["knot.off"]
    document["machine"]["code"]["lbskel.contraction"] = "0"
    (tmp_path / "topology.json").write_text(json.dumps(document))
    (tmp_path / "speed.json").write_text("{}")
    run(False, tmp_path)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "speed: no record of the code"
    assert lines[1].endswith("; changed since: lbskel.contraction")


def test_every_committed_result_is_named_for_its_benchmark():
    assert [path.stem for path in RESULTS.glob("*.json") if not (RESULTS.parent / f"{path.stem}.py").exists()] == []


def test_rows_of_other_commits_are_named(tmp_path, capsys):
    rows = [{"commit": "abc", "seconds": 1.0}, {"commit": "def with changes"}]
    save_json(tmp_path / "topology.json", {"rows": rows, "parts": {"quick": "old", "weights": "012"}})
    document = json.loads((tmp_path / "topology.json").read_text())
    document["rows"].append({"commit": document["machine"]["commit"]})
    (tmp_path / "topology.json").write_text(json.dumps(document))
    run(False, tmp_path)
    assert capsys.readouterr().out == "topology: up to date; rows of other commits: 012, abc, def with changes\n"
