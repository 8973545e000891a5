"""What the package holds, and that it is the installed one that is tested."""

from __future__ import annotations

import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import mbcheck
from mbcheck.tests.support.packaging import copy_sources, output


@pytest.fixture
def odd_clone(clone: Path, tmp_path: Path) -> Path:
    """Copy the sources into a folder whose name is no Python identifier."""
    return copy_sources(clone, tmp_path / "my-clone-1")


def installed_package(cwd: Path, pythonpath: Path | None = None) -> Path:
    """Return the folder of the package that a fresh interpreter imports from `cwd`."""
    where = "import mbcheck; print(mbcheck.__file__)"
    return Path(output(sys.executable, "-c", where, cwd=cwd, pythonpath=pythonpath).strip()).parent


def source_files(root: Path) -> set[str]:
    """Return the files, relative to `root`, that the package is to contain."""
    patterns = ["*.py", "py.typed", "models/*/*.xml", "examples/*.py"]
    patterns += ["comparisons/reports/templates/*", "comparisons/papers/*/claims.toml"]
    patterns += ["comparisons/cli/glossary.toml", "comparisons/documents/schemas/*.json"]
    patterns += [f"{layer}/**/*.py" for layer in ("reference", "models", "comparisons")]
    patterns += [f"tests/{folder}/**/*.py" for folder in ("support", "conformance")]
    files = (path for pattern in patterns for path in root.glob(pattern))
    return {path.relative_to(root).as_posix() for path in files}


def test_tests_import_the_installed_package(tmp_path: Path) -> None:
    assert mbcheck.__file__ is not None
    assert Path(mbcheck.__file__).parent == installed_package(tmp_path)


def test_every_package_is_listed(clone: Path) -> None:
    project = tomllib.loads((clone / "pyproject.toml").read_text())
    folders = {Path(name).parent for name in source_files(clone) if name.endswith(".py")}
    packages = {".".join(["mbcheck", *folder.parts]) for folder in folders}
    assert packages == set(project["tool"]["setuptools"]["packages"])


def test_tests_collect_in_a_clone_of_any_name(odd_clone: Path) -> None:
    collect = ("--collect-only", "-q", "-p", "no:cacheprovider", "tests/house")  # all: test_wheel
    report = output(sys.executable, "-m", "pytest", *collect, cwd=odd_clone)
    assert "tests/house/test_packaging.py::test_every_package_is_listed" in report


@pytest.mark.slow
def test_wheel(odd_clone: Path, tmp_path: Path) -> None:
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    build = ("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", tmp_path)
    output(*pip, *build, ".", cwd=odd_clone)
    (wheel,) = tmp_path.glob("*.whl")
    names = [name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name]
    assert {name.partition("/")[0] for name in names} == {"mbcheck"}
    assert {name.removeprefix("mbcheck/") for name in names} == source_files(odd_clone)

    site = tmp_path / "site"
    output(*pip, "install", "--no-deps", "--target", site, wheel, cwd=tmp_path)
    assert installed_package(odd_clone, pythonpath=site) == site / "mbcheck"
    python = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider")
    output(*python, "--collect-only", cwd=odd_clone, pythonpath=site)
    small = "tests/house/test_rules.py::test_a_class_has_a_name_of_its_own"
    assert "1 passed" in output(*python, small, cwd=odd_clone, pythonpath=site)

    selection = {"engine": "mujoco", "scene": "hula_hoop", "kind": "frequency"}
    checks = (f"--mbcheck-{option}={value}" for option, value in selection.items())
    conformance = (*python, "--pyargs", "mbcheck.tests.conformance", *checks)
    for folder in (odd_clone, tmp_path):  # with our settings of pytest, and with none
        assert "3 checks: 3 ran" in output(*conformance, cwd=folder, pythonpath=site)
