"""Mutation testing: the lists fit the code, and the runner finds what tests catch and what they miss."""

import json

import pytest

from benchmarks import mutations
from benchmarks.__main__ import main
from benchmarks.mutations import FOLDER, ROOT, Mutation, apply, caught_share, measure, read_mutations, tables

MODULE = "def area(a, b):\n    return a * b\n\n\ndef label():\n    return 'rectangle'\n"
TESTS = "from shapes import area\n\n\ndef test_area():\n    assert area(2, 3) == 6\n"
LIST = """
[[mutation]]
file = "shapes.py"
bug = "the area is the sum of the sides"
find = "a * b"
replace = "a + b"
tests = ["test_shapes.py"]

[[mutation]]
file = "shapes.py"
bug = "the label is of another shape"
find = "'rectangle'"
replace = "'disc'"
tests = ["test_shapes.py"]
"""


@pytest.fixture
def tree(tmp_path):
    """A repository of one module, its test, and two mutations, one of which no test notices."""
    root = tmp_path / "tree"
    root.mkdir()
    (root / "shapes.py").write_text(MODULE)
    (root / "test_shapes.py").write_text(TESTS)
    (tmp_path / "lists").mkdir()
    (tmp_path / "lists" / "shapes.toml").write_text(LIST)
    return root, tmp_path / "lists"


@pytest.fixture
def quick_tests(monkeypatch):
    """The test of MODULE without a process: the exit code of pytest by what is in the copy."""

    def outcome(copy, tests, time_limit=0.0):
        assert [(copy / test).exists() for test in tests] == [True]
        is_mutated = "return a + b" in (copy / "shapes.py").read_text()
        return int(is_mutated), ""

    monkeypatch.setattr(mutations, "_pytest", outcome)


@pytest.mark.parametrize("package", sorted(path.stem for path in FOLDER.glob("*.toml")))
def test_every_mutation_can_be_applied(package):
    found = read_mutations(FOLDER, package)
    assert found
    for mutation in found:
        assert apply(mutation, ROOT) != (ROOT / mutation.file).read_text(encoding="utf-8")


def test_the_runner_tells_a_caught_mutation_from_a_survivor_and_changes_nothing(tree):
    root, lists = tree
    rows = measure(read_mutations(lists), root, jobs=2)
    assert [row["outcome"] for row in rows] == ["caught", "survived"]
    assert caught_share(rows) == 0.5
    assert "| shapes | 2 | 1 | 1 | 0 | 50 % |" in tables(rows)["Summary"]
    assert "the label is of another shape" in tables(rows)["Survived"]
    assert "area" not in tables(rows)["Survived"]
    assert (root / "shapes.py").read_text() == MODULE


def test_a_survivor_with_a_reason_is_equivalent_and_leaves_the_share_alone(tree, quick_tests):
    root, lists = tree
    with (lists / "shapes.toml").open("a") as file:
        file.write("equivalent = 'no caller reads the label'\n")
    rows = measure(read_mutations(lists), root)
    assert [row["outcome"] for row in rows] == ["caught", "equivalent"]
    assert caught_share(rows) == 1
    assert "no caller reads the label" in tables(rows)["Equivalent"]


def test_each_mutation_starts_from_the_unchanged_tree(tree, quick_tests):
    root, _ = tree
    area = Mutation("shapes", "shapes.py", "the area is a sum", "a * b", "a + b", ("test_shapes.py",))
    label = Mutation("shapes", "shapes.py", "the label is another", "rectangle", "disc", ("test_shapes.py",))
    assert [row["outcome"] for row in measure([area, label, area], root)] == ["caught", "survived", "caught"]


@pytest.mark.parametrize("is_ci", [False, True])
def test_tests_that_fail_without_a_mutation_are_an_error(tree, is_ci, monkeypatch):
    monkeypatch.setenv("CI", "true") if is_ci else monkeypatch.delenv("CI", raising=False)
    root, lists = tree
    (root / "test_shapes.py").write_text(TESTS.replace("6", "7"))
    with pytest.raises(RuntimeError, match=r"tests fail without any mutation:\n(.*\n)*FAILED test_shapes\.py"):
        measure(read_mutations(lists), root)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"find": "a - b"}, "occurs 0 times in shapes.py"),
        ({"find": "return"}, "occurs 2 times in shapes.py"),
        ({"replace": "a * b"}, "the replacement equals"),
        ({"file": "forms.py"}, "no file forms.py"),
        ({"tests": ("test_forms.py::test_area",)}, "no file test_forms.py"),
    ],
)
def test_a_mutation_that_cannot_be_applied_is_named(tree, changes, says):
    values = {"package": "shapes", "file": "shapes.py", "bug": "the area is wrong", "find": "a * b", "replace": "a + b"}
    mutation = Mutation(**{**values, "tests": ("test_shapes.py",), **changes})
    with pytest.raises(ValueError, match=f"shapes.toml, 'the area is wrong': .*{says}"):
        apply(mutation, tree[0])


def test_a_mutated_kernel_must_run_uncompiled(tmp_path):
    (tmp_path / "_kernels").mkdir()
    (tmp_path / "_kernels" / "area.py").write_text(MODULE)
    (tmp_path / "_kernels" / "area.cpython-311.so").write_bytes(b"")
    (tmp_path / "test_area.py").write_text(
        "from pathlib import Path\n\n\ndef test_it():\n    assert not list(Path('_kernels').glob('*.so'))\n"
        "    assert 'a * b' in Path('_kernels/area.py').read_text()\n"
    )
    values = ("kernels", "_kernels/area.py", "the area is a sum", "a * b", "a + b", ("test_area.py",))
    with pytest.raises(ValueError, match="uncompiled = true"):
        apply(Mutation(*values), tmp_path)
    assert measure([Mutation(*values, uncompiled=True)], tmp_path)[0]["outcome"] == "caught"
    assert (tmp_path / "_kernels" / "area.cpython-311.so").exists()


def test_unknown_and_missing_keys_are_named(tmp_path):
    (tmp_path / "a.toml").write_text("[[mutation]]\nfile = 'x'\nbug = 'y'\nfind = 'z'\nreplace = ''\ntest = []\n")
    with pytest.raises(ValueError, match=r"a.toml, mutation 1: unknown or missing: test, tests"):
        read_mutations(tmp_path)
    with pytest.raises(ValueError, match="no mutations of 'b'; there are of: a"):
        read_mutations(tmp_path, "b")


def test_the_command_fails_below_nine_tenths_and_writes_the_table(tree, quick_tests, tmp_path, monkeypatch, capsys):
    root, lists = tree
    monkeypatch.setattr(mutations, "ROOT", root)
    monkeypatch.setattr(mutations, "FOLDER", lists)
    results = tmp_path / "results"
    assert main(["mutations", "--results", str(results), "--jobs", "2"]) == 1
    assert "shapes.py: the label is of another shape" in capsys.readouterr().out
    written = json.loads((results / "mutations.json").read_text())
    assert written["summary"][-1]["share caught"] == "50 %"
    assert "| shapes.py | the label is of another shape | survived |" in (results / "mutations.md").read_text()
    (lists / "shapes.toml").write_text(LIST[: LIST.index("[[mutation]]", 3)])
    written["mutations"].append({**written["mutations"][0], "package": "forms", "commit": "of long ago"})
    (results / "mutations.json").write_text(json.dumps(written))
    assert main(["mutations", "--results", str(results), "--package", "shapes"]) == 0
    rows = json.loads((results / "mutations.json").read_text())["mutations"]
    assert [row["package"] for row in rows] == ["forms", "shapes"]  # that of another package stays
    assert rows[0]["commit"] == "of long ago" != rows[1]["commit"]
