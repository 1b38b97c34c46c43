"""The command of the benchmarks: help, unknown names, and what is passed on to each benchmark."""

import pytest

from benchmarks.__main__ import main, names


def test_the_command_knows_every_benchmark_and_refuses_others(capsys):
    assert {"operators", "mutations", "skeletons"} <= set(names())
    assert not {"harness", "operators_speed"} & set(names())
    with pytest.raises(SystemExit) as ended:
        main(["operator"])
    assert ended.value.code == 2
    assert "there is no benchmark operator; there are: " in capsys.readouterr().err


def test_the_help_has_a_line_for_each_benchmark(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    lines = capsys.readouterr().out.splitlines()
    for name in names():
        line = next(line for line in lines if line.startswith(f"  {name} "))
        assert len(line.split()) > 4, name


def test_options_go_to_the_benchmarks_that_take_them(tmp_path, monkeypatch):
    (tmp_path / "b.off").touch()
    (tmp_path / "a.off").touch()
    passed = []
    monkeypatch.setattr("benchmarks.influence.run", lambda quick, results, meshes=(): passed.append(meshes))
    monkeypatch.setattr("benchmarks.solvers.run", lambda quick, results: passed.append(None))
    assert main(["influence", "solvers", "--results", str(tmp_path / "results"), "--meshes", str(tmp_path)]) == 0
    assert [path.name for path in passed[0]][:2] == ["a.off", "b.off"]
    assert passed[1] is None


def test_the_exit_code_is_the_largest_of_the_benchmarks(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.influence.run", lambda quick, results: 1)
    monkeypatch.setattr("benchmarks.solvers.run", lambda quick, results: None)
    assert main(["influence", "solvers", "--results", str(tmp_path)]) == 1
    assert main(["solvers", "--results", str(tmp_path)]) == 0
