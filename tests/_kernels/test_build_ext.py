"""The build commands: what is compiled, how, and where the build writes."""

import ast
import importlib.util
import sys
import sysconfig
import tarfile
from pathlib import Path

import pytest
from setuptools import Distribution, Extension

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


def distribution():
    """A project of one kernel."""
    return Distribution({"name": "a", "ext_modules": [Extension("lbskel._kernels.bvh", ["lbskel/_kernels/bvh.py"])]})


def test_every_kernel_is_compiled():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extensions = {each["name"]: each["sources"] for each in project["tool"]["setuptools"]["ext-modules"]}
    names = [path.stem for path in FOLDER.glob("*.py") if imports_cython(path)]
    assert extensions == {f"lbskel._kernels.{name}": [f"lbskel/_kernels/{name}.py"] for name in names}


def test_kernels_are_compiled_without_checks_of_indices(build_ext, monkeypatch):
    monkeypatch.delenv(build_ext.CHECKS, raising=False)
    command = build_ext.BuildKernels(distribution())
    command.ensure_finalized()
    assert command.cython_directives == build_ext.DIRECTIVES
    assert not any(build_ext.DIRECTIVES[name] for name in ("boundscheck", "wraparound", "initializedcheck"))


def test_checks_are_switched_on_by_name(build_ext, monkeypatch):
    monkeypatch.setenv(build_ext.CHECKS, "boundscheck wraparound")
    command = build_ext.BuildKernels(distribution())
    command.ensure_finalized()
    assert command.cython_directives == {**build_ext.DIRECTIVES, "boundscheck": True, "wraparound": True}
    monkeypatch.setenv(build_ext.CHECKS, "boundcheck")
    with pytest.raises(ValueError, match="unknown boundcheck; known: boundscheck, wraparound"):
        build_ext.BuildKernels(distribution()).ensure_finalized()


def test_cythons_own_code_is_compiled_once_and_a_failure_stops_no_installation(build_ext):
    command = build_ext.BuildKernels(distribution())
    command.ensure_finalized()
    assert [extension.name for extension in command.extensions] == ["lbskel._kernels.bvh", build_ext.SHARED]
    assert all(extension.optional for extension in command.extensions)


def test_a_wheel_is_for_all_later_pythons(build_ext):
    command = build_ext.BuildWheel(distribution())
    command.ensure_finalized()
    is_limited = sys.version_info >= (3, 11) and not sysconfig.get_config_var("Py_GIL_DISABLED")
    assert (command.get_tag()[:2] == ("cp311", "abi3")) == is_limited


def test_a_source_distribution_has_what_the_tests_need(build_ext, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    needed = {"tests/conftest.py", "meshes/a.ply", "benchmarks/a.md"}
    for name in (*needed, "tests/__pycache__/a.pyc", "note.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    project = Distribution({"name": "a", "script_name": "setup.py"})
    project.cmdclass = {"egg_info": build_ext.EggInfo, "sdist": build_ext.SourceDistribution}
    command = project.get_command_obj("sdist")
    command.formats, command.dist_dir = ["gztar"], str(tmp_path / "dist")
    project.run_command("sdist")
    (archive,) = (tmp_path / "dist").iterdir()
    with tarfile.open(archive) as file:
        names = {name.partition("/")[2] for name in file.getnames() if "." in Path(name).name}
    assert needed <= names
    assert not any(name.endswith((".pyc", ".txt")) for name in names if "egg-info" not in name)


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


def test_links_of_the_readme_work_on_a_package_page(build_ext, monkeypatch):
    project = Distribution({"name": "a", "version": "1.2", "script_name": "setup.py"})
    project.metadata.long_description = "![b](c/d.png) [e](f.md) [g](https://example.org) [h](#i)"
    command = build_ext.EggInfo(project)
    command.ensure_finalized()
    assert project.metadata.long_description.startswith("![b](c/d.png)")  # the repository is not known
    monkeypatch.setenv(build_ext.REPOSITORY, "https://example.org/a")
    command = build_ext.EggInfo(project)
    command.ensure_finalized()
    assert project.metadata.long_description == (
        "![b](https://example.org/a/raw/v1.2/c/d.png) [e](https://example.org/a/blob/v1.2/f.md) "
        "[g](https://example.org) [h](#i)"
    )
    assert project.metadata.project_urls["Source"] == "https://example.org/a"
