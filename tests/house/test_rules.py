"""The house keeps its rules, and every rule sees what breaks it."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcheck.tests.support.house.allowed import ALLOWED, PENDING
from mbcheck.tests.support.house.module import Module, modules
from mbcheck.tests.support.house.rules import DOWN, RULES


@pytest.fixture(scope="module")
def house(clone: Path) -> list[Module]:
    return modules(clone)


@pytest.mark.parametrize("rule", RULES)
def test_rule_is_kept(rule: str, house: list[Module]) -> None:
    breaches, allowed = set(RULES[rule](house)), set(ALLOWED.get(rule, ()))
    assert len(breaches - allowed) <= PENDING.get(rule, 0), sorted(breaches - allowed)
    assert not allowed - breaches, "no longer needed"


def test_layers_are_those_that_there_are(clone: Path) -> None:
    folders = {path.name for path in (clone / "comparisons").iterdir() if path.is_dir()}
    assert set(DOWN) - {""} <= folders


# A snippet for every rule ---------------------------------------------------------------------

HERE = "comparisons/checks/a.py"
KIND = "comparisons/checks/kinds/a.py"
TEST = "tests/comparisons/b/test_a.py"
MUJOCO = "comparisons/engines/mujoco_run.py"
BROKEN: list[tuple[str, str, str, str]] = [
    ("loose_modules", "comparisons/a.py", "", "comparisons/a.py"),
    ("scenes_by_name", HERE, "NAME = 'hula_hoop'", HERE),
    ("scenes_by_name", HERE, "NAME = f'{x} of rotating_beam'", HERE),
    ("scenes_by_name", HERE, "from ..scenes.hula_hoop import steps", HERE),
    ("engines_by_name", HERE, "NAME = 'mujoco'", f"{HERE}::mujoco"),
    ("engines_by_name", MUJOCO, "NAME = 'exudyn'", f"{MUJOCO}::exudyn"),
    ("asked_engines", HERE, "def f(engine): return getattr(engine, 'batch', None)", f"{HERE}::f"),
    ("asked_engines", HERE, "def f(s): return hasattr(s.engine, 'batch')", f"{HERE}::f"),
    ("sibling_kinds", KIND, "from . import c", f"{KIND}: mbcheck.comparisons.checks.kinds.c"),
    ("sibling_kinds", KIND, "from ..table import c", f"{KIND}: mbcheck.comparisons.checks.table.c"),
    ("broad_excepts", HERE, "def f():\n    try: g()\n    except Exception: pass", f"{HERE}::f"),
    ("broad_excepts", HERE, "def f():\n    try: g()\n    except: pass", f"{HERE}::f"),
    (
        "broad_excepts",
        HERE,
        "def f():\n    try: g()\n    except (A, Exception): x",
        f"{HERE}::f",
    ),
    ("module_caches", HERE, "C: dict = {}\ndef f(x): C[x] = 1", f"{HERE}::C"),
    ("module_caches", HERE, "C = []\ndef f(x): C.append(x)", f"{HERE}::C"),
    ("module_caches", HERE, "C = dict()\ndef f(x): del C[x]", f"{HERE}::C"),
    ("module_caches", HERE, "C = None\ndef f(x):\n    global C\n    C = x", f"{HERE}::C"),
    ("patched_constants", TEST, "monkeypatch.setattr(judge, 'STEPS', 3)", f"{TEST}::STEPS"),
    ("patched_constants", TEST, "monkeypatch.setattr('mbcheck.a.STEPS', 3)", f"{TEST}::STEPS"),
    ("tests_without_a_place", TEST, "", TEST),
    ("private_words", HERE, "class Knob: ...", f"{HERE}::Knob"),
    ("private_words", HERE, "def stands_for(x): ...", f"{HERE}::stands_for"),
    ("private_words", HERE, "def f(told): ...", f"{HERE}::told"),
    ("private_words", HERE, "found = 1", f"{HERE}::found"),
    ("private_words", HERE, "class A:\n    priced: float", f"{HERE}::priced"),
    ("private_words", HERE, "def f(x): x.shown = 1", f"{HERE}::shown"),
    ("private_words", HERE, "def f(x): return [1 for first_kept in x]", f"{HERE}::first_kept"),
    ("private_words", HERE, "class NotJudged: ...", f"{HERE}::NotJudged"),
]


@pytest.mark.parametrize(("rule", "path", "source", "breach"), BROKEN)
def test_rule_sees_what_breaks_it(rule: str, path: str, source: str, breach: str) -> None:
    assert set(RULES[rule]([Module(path, source)])) == {breach}


@pytest.mark.parametrize(
    ("rule", "path", "source"),
    [
        ("scenes_by_name", HERE, "def f():\n    'Return that of hula_hoop.'"),
        ("scenes_by_name", HERE, "HELP = 'mbcheck check rotating_beam'"),
        ("scenes_by_name", "comparisons/scenes/hula_hoop/a.py", "NAME = 'hula_hoop'"),
        ("engines_by_name", HERE, "TEXT = 'MuJoCo'"),
        ("engines_by_name", "comparisons/faults/a.py", "NAME = 'mujoco'"),
        ("sibling_kinds", KIND, "from ..comparison import c"),
        ("sibling_kinds", "comparisons/checks/diagnosis.py", "from ..kinds import c"),
        ("asked_engines", HERE, "def f(engine): return engine.batch"),
        ("broad_excepts", HERE, "def f():\n    try: g()\n    except EngineError: pass"),
        ("broad_excepts", HERE, "def f():\n    try: g()\n    except Exception:\n        raise"),
        ("module_caches", HERE, "C = {}\ndef f(x):\n    D = {}\n    D[x] = C[x]"),
        ("patched_constants", TEST, "monkeypatch.setattr(judge, 'simulate', 3)"),
        ("tests_without_a_place", "tests/house/test_a.py", ""),
        ("private_words", HERE, "def foundation(x): ..."),
        ("private_words", HERE, "last_trusted_sample = 1"),
        ("private_words", "tests/a.py", "found = 1"),
    ],
)
def test_rule_lets_pass_what_does_not_break_it(rule: str, path: str, source: str) -> None:
    assert not list(RULES[rule]([Module(path, source)]))


@pytest.mark.parametrize(
    ("path", "source", "forbidden"),
    [
        ("reference/a.py", "from ..models import hula_hoop", "mbcheck.models.hula_hoop"),
        ("reference/a.py", "from .. import Case", "mbcheck.Case"),
        ("reference/__init__.py", "from . import b", None),
        ("reference/mujoco.py", "import mujoco", "mujoco"),
        ("models/a/b.py", "def f(): from ...comparisons import c", "mbcheck.comparisons.c"),
        ("models/a/__init__.py", "from ...reference.errors import E", None),
        ("models/a/exudyn_model.py", "import exudyn.utilities", None),
        ("models/a/mjcf.py", "from exudyn import utilities", "exudyn.utilities"),
        ("models/mjcf.py", "import mujoco", None),
        ("comparisons/engines/registry.py", "import scipy, mujoco", "mujoco"),
        ("comparisons/checks/a.py", "from ...tests import t", "mbcheck.tests.t"),
        ("comparisons/checks/a.py", "from .. import queries", "mbcheck.comparisons.queries"),
        ("comparisons/checks/kinds/a.py", "from ...engines import c", None),
        ("comparisons/checks/kinds/a.py", "from ..suite import c", None),
        ("comparisons/cli/verbs.py", "from ... import __version__", "mbcheck.__version__"),
        ("comparisons/cli/a.py", "from ..maps.b import c", None),
        ("comparisons/engines/a.py", "from ..checks.b import c", "mbcheck.comparisons.checks.b.c"),
        ("comparisons/maps/a.py", "from ..cli import c", "mbcheck.comparisons.cli.c"),
        ("comparisons/maps/a.py", "from ..papers import c", "mbcheck.comparisons.papers.c"),
        ("comparisons/maps/a.py", "from ..terminal import c", None),
        ("comparisons/papers/a.py", "from ..maps import c", None),
        ("comparisons/reports/a.py", "from ..maps import c", "mbcheck.comparisons.maps.c"),
        ("comparisons/scenes/a.py", "from ..reports import c", "mbcheck.comparisons.reports.c"),
    ],
)
def test_imports_point_down(path: str, source: str, forbidden: str | None) -> None:
    seen = list(RULES["upward_imports"]([Module(path, source)]))
    assert seen == ([f"{path}: {forbidden}"] if forbidden else [])


def test_a_class_has_a_name_of_its_own() -> None:
    first, second = Module(HERE, "class A: ..."), Module("comparisons/maps/b.py", "class A: ...")
    assert list(RULES["shared_names"]([first, second])) == ["A"]
    assert not list(RULES["shared_names"]([first]))


def test_a_function_that_others_import_has_a_name_of_its_own() -> None:
    house = [Module(f"comparisons/{name}/a.py", "def f(): ...") for name in ("checks", "maps")]
    assert not list(RULES["shared_names"](house))
    house.append(Module("comparisons/cli/a.py", "from ..maps.a import f"))
    assert not list(RULES["shared_names"](house))
    house.append(Module("comparisons/cli/b.py", "from ..checks.a import f"))
    assert list(RULES["shared_names"](house)) == ["f"]


def test_a_name_may_stand_once_for_each_scene() -> None:
    scenes = ("hula_hoop", "rotating_beam")
    house = [Module(f"models/{scene}/a.py", "class A: ...") for scene in scenes]
    assert not list(RULES["shared_names"](house))
