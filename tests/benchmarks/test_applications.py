"""The benchmark of applications: every part is found by its name and can be run alone."""

import inspect
from importlib import import_module

import pytest

from benchmarks import applications
from benchmarks.__main__ import names


@pytest.mark.parametrize("name", applications.parts())
def test_every_part_is_a_benchmark_of_its_own(name):
    assert name in names()
    parameters = list(inspect.signature(import_module(f"benchmarks.{name}").run).parameters)
    assert parameters in (["quick", "results", "peers"], ["quick", "results", "peers", "meshes"])


def test_every_part_is_run_with_the_same_arguments(monkeypatch, tmp_path):
    calls = []

    class Part:
        @staticmethod
        def run(quick, results, peers):
            calls.append((quick, results, peers))

    monkeypatch.setattr(applications, "parts", lambda: ["applications_one", "applications_two"])
    monkeypatch.setattr(applications, "import_module", lambda name: Part)
    applications.run(True, tmp_path, peers=True)
    assert calls == [(True, tmp_path, True)] * 2


def test_meshes_go_to_the_parts_that_take_them(monkeypatch, tmp_path):
    calls = []

    class Part:
        @staticmethod
        def run(quick, results, peers, meshes=None):
            calls.append(meshes)

    monkeypatch.setattr(applications, "parts", lambda: ["applications_one"])
    monkeypatch.setattr(applications, "import_module", lambda name: Part)
    applications.run(True, tmp_path, meshes=[tmp_path])
    assert calls == [[tmp_path]]
