"""The build commands: what is compiled, how, and where the build writes."""

import ast
import importlib.util
from pathlib import Path

import pytest
from setuptools import Distribution

from lbskel import _kernels

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib

ROOT = Path(__file__).parent.parent.parent
FOLDER = Path(_kernels.__file__).parent


@pytest.fixture(scope="module")
def build_ext():
    """The module as setuptools loads it: on its own."""
    spec = importlib.util.spec_from_file_location("build_ext_alone", FOLDER / "build_ext.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def imports_cython(path):
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return any(isinstance(node, ast.Import) and "cython" in {alias.name for alias in node.names} for node in nodes)


def test_every_kernel_is_compiled():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extensions = {each["name"]: each["sources"] for each in project["tool"]["setuptools"]["ext-modules"]}
    names = [path.stem for path in FOLDER.glob("*.py") if imports_cython(path)]
    assert extensions == {f"lbskel._kernels.{name}": [f"lbskel/_kernels/{name}.py"] for name in names}


def test_kernels_are_compiled_without_checks_of_indices(build_ext, monkeypatch):
    monkeypatch.delenv(build_ext.CHECKS, raising=False)
    command = build_ext.BuildKernels(Distribution({"name": "a"}))
    command.ensure_finalized()
    assert command.cython_c_in_temp
    assert command.cython_directives == build_ext.DIRECTIVES
    assert not any(build_ext.DIRECTIVES[name] for name in ("boundscheck", "wraparound", "initializedcheck"))


def test_checks_are_switched_on_by_name(build_ext, monkeypatch):
    monkeypatch.setenv(build_ext.CHECKS, "boundscheck wraparound")
    command = build_ext.BuildKernels(Distribution({"name": "a"}))
    command.ensure_finalized()
    assert command.cython_directives == {**build_ext.DIRECTIVES, "boundscheck": True, "wraparound": True}
    monkeypatch.setenv(build_ext.CHECKS, "boundcheck")
    with pytest.raises(ValueError, match="unknown boundcheck; known: boundscheck, wraparound"):
        build_ext.BuildKernels(Distribution({"name": "a"})).ensure_finalized()


def test_a_build_writes_to_a_temporary_folder(build_ext, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    distribution = Distribution({"name": "a", "script_name": "setup.py"})
    distribution.cmdclass = {"build": build_ext.Build, "egg_info": build_ext.EggInfo}
    distribution.run_command("egg_info")
    for name, folder in (("build", "build_lib"), ("build", "build_temp"), ("egg_info", "egg_info")):
        command = distribution.get_command_obj(name)
        command.ensure_finalized()
        written = Path(getattr(command, folder)).absolute()
        assert Path(build_ext.TEMPORARY) in written.parents
    assert list(tmp_path.iterdir()) == []
