"""The project itself: style, types, packaging, and the direction of its imports."""

import ast
import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import mbcheck

PACKAGE = Path(__file__).resolve().parents[1]
"""The package that holds this file: a clone, or `mbcheck` in site-packages."""

LAYERS = {
    "reference": {"reference"},
    "models": {"reference", "models"},
    "comparisons": {"reference", "models", "comparisons"},
}
"""What each layer may import from mbcheck."""

ENGINES = {"mujoco": ("mujoco", "mjcf"), "exudyn": ("exudyn",)}
"""Engine -> the words one of which a module's path has if it may import that engine."""


@pytest.fixture
def clone() -> Path:
    if not (PACKAGE / "pyproject.toml").exists():
        pytest.skip("runs from an installed package: there is no clone to look at")
    return PACKAGE


@pytest.fixture
def odd_clone(clone: Path, tmp_path: Path) -> Path:
    """Copy the sources into a folder whose name is no Python identifier."""
    return copy_sources(clone, tmp_path / "my-clone-1")


def copy_sources(source: Path, target: Path) -> Path:
    def left_out(folder: str, names: list[str]) -> list[str]:
        return [
            name
            for name in names
            if name.startswith(".")
            or name in {"build", "dist", "__pycache__"}
            or name.endswith(".egg-info")
            or Path(folder, name, "pyvenv.cfg").exists()
        ]

    shutil.copytree(source, target, ignore=left_out)
    return target


def run(*command: object, cwd: Path, pythonpath: Path | None = None) -> str:
    """Run a command and return what it prints; fail with that text if it fails."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")}
    if pythonpath is not None:
        environment["PYTHONPATH"] = str(pythonpath)
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def installed_package(cwd: Path, pythonpath: Path | None = None) -> Path:
    """Return the folder of the package that a fresh interpreter imports from `cwd`."""
    where = "import mbcheck; print(mbcheck.__file__)"
    return Path(run(sys.executable, "-c", where, cwd=cwd, pythonpath=pythonpath).strip()).parent


def source_files(root: Path) -> set[str]:
    """Return the files, relative to `root`, that the package is to contain."""
    patterns = ["*.py", "py.typed", "tests/**/*.py", "models/*/*.xml", "comparisons/schemas/*.json"]
    patterns += ["examples/*.py", "comparisons/templates/*.html"]
    patterns += [f"{layer}/**/*.py" for layer in LAYERS]
    files = (path for pattern in patterns for path in root.glob(pattern))
    return {path.relative_to(root).as_posix() for path in files}


def imported_names(source: str, module: str) -> Iterator[str]:
    """Yield the absolute dotted name of all that a module imports.

    `module` is the module's own dotted name; that of a package ends in ``.__init__``.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = module.split(".")[: -node.level] if node.level else []
            base = [*parents, node.module] if node.module else parents
            yield from (".".join([*base, alias.name]) for alias in node.names)


def forbidden_imports(source: str, module: str) -> list[str]:
    """Return the imports of a module that point upwards or reach for an engine."""
    layer, path = module.split(".")[1], module.partition(".")[2]
    forbidden = []
    for name in imported_names(source, module):
        top, _, rest = name.partition(".")
        if (top == "mbcheck" and rest.split(".")[0] not in LAYERS[layer]) or (
            top in ENGINES
            and (layer == "reference" or not any(word in path for word in ENGINES[top]))
        ):
            forbidden.append(name)
    return forbidden


def test_ruff(clone: Path) -> None:
    run(sys.executable, "-m", "ruff", "check", "--no-cache", ".", cwd=clone)


def test_mypy(clone: Path, tmp_path: Path, pytestconfig: pytest.Config) -> None:
    if installed_package(tmp_path) == clone:
        copy_sources(clone, tmp_path / "mbcheck")  # mypy cannot follow an editable install
    cache = pytestconfig.rootpath / ".mypy_cache"
    options = ("--config-file", clone / "pyproject.toml", "--cache-dir", cache)
    run(sys.executable, "-m", "mypy", *options, "-p", "mbcheck", cwd=tmp_path)


def test_tests_import_the_installed_package(tmp_path: Path) -> None:
    assert mbcheck.__file__ is not None
    assert Path(mbcheck.__file__).parent == installed_package(tmp_path)


def test_every_package_is_listed(clone: Path) -> None:
    project = tomllib.loads((clone / "pyproject.toml").read_text())
    listed = set(project["tool"]["setuptools"]["packages"])
    folders = {Path(name).parent for name in source_files(clone) if name.endswith(".py")}
    assert {".".join(["mbcheck", *folder.parts]) for folder in folders} <= listed


def test_tests_collect_in_a_clone_of_any_name(odd_clone: Path) -> None:
    collect = ("--collect-only", "-q", "-p", "no:cacheprovider")
    report = run(sys.executable, "-m", "pytest", *collect, cwd=odd_clone)
    assert "tests/test_project.py::test_ruff" in report


@pytest.mark.slow
def test_wheel(odd_clone: Path, tmp_path: Path) -> None:
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    build = ("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", tmp_path)
    run(*pip, *build, ".", cwd=odd_clone)
    (wheel,) = tmp_path.glob("*.whl")
    names = [name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name]
    assert {name.partition("/")[0] for name in names} == {"mbcheck"}
    assert {name.removeprefix("mbcheck/") for name in names} == source_files(odd_clone)

    site = tmp_path / "site"
    run(*pip, "install", "--no-deps", "--target", site, wheel, cwd=tmp_path)
    assert installed_package(odd_clone, pythonpath=site) == site / "mbcheck"
    python = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider")
    run(*python, "--collect-only", cwd=odd_clone, pythonpath=site)
    small = "tests/test_project.py::test_imports_point_one_way"
    assert "1 passed" in run(*python, small, cwd=odd_clone, pythonpath=site)

    chosen = {"engine": "mujoco", "scene": "hula_hoop", "kind": "frequency"}
    checks = (f"--mbcheck-{option}={value}" for option, value in chosen.items())
    conformance = (*python, "--pyargs", "mbcheck.tests.conformance", *checks)
    for folder in (odd_clone, tmp_path):  # with our settings of pytest, and with none
        assert "2 checks: 2 ran" in run(*conformance, cwd=folder, pythonpath=site)


def test_imports_point_one_way() -> None:
    found: dict[str, list[str]] = {}
    for layer in LAYERS:
        files = sorted((PACKAGE / layer).rglob("*.py"))
        assert files, f"{layer} holds no module"
        for path in files:
            relative = path.relative_to(PACKAGE)
            module = ".".join(["mbcheck", *relative.with_suffix("").parts])
            if forbidden := forbidden_imports(path.read_text(encoding="utf-8"), module):
                found[relative.as_posix()] = forbidden
    assert not found


@pytest.mark.parametrize(
    ("source", "module", "forbidden"),
    [
        ("from ..models import hula_hoop", "mbcheck.reference.a", ["mbcheck.models.hula_hoop"]),
        ("from .. import Case", "mbcheck.reference.a", ["mbcheck.Case"]),
        ("from . import b", "mbcheck.reference.__init__", []),
        ("import mujoco", "mbcheck.reference.mujoco", ["mujoco"]),
        ("def f(): from ...comparisons import c", "mbcheck.models.a.b", ["mbcheck.comparisons.c"]),
        ("from ...reference.errors import E", "mbcheck.models.a.__init__", []),
        ("import exudyn.utilities", "mbcheck.models.a.exudyn_model", []),
        ("from exudyn import utilities", "mbcheck.models.a.mjcf", ["exudyn.utilities"]),
        ("import mujoco", "mbcheck.models.mjcf", []),
        ("import mujoco", "mbcheck.comparisons.a.mujoco.b", []),
        ("from ..tests import t", "mbcheck.comparisons.a", ["mbcheck.tests.t"]),
        ("import scipy, mujoco", "mbcheck.comparisons.engines.registry", ["mujoco"]),
        ("from ... import __version__", "mbcheck.comparisons.cli.verbs", ["mbcheck.__version__"]),
    ],
)
def test_import_rules(source: str, module: str, forbidden: list[str]) -> None:
    assert forbidden_imports(source, module) == forbidden
