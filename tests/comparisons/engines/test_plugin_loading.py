"""Engines that others plug in: how they are loaded, and what a system tells them."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.suite import kinds_of
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.models import mjcf
from mbcheck.models.kinematics import gaps
from mbcheck.models.mechanism import mechanism
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineUnavailableError, UsageError
from mbcheck.tests.support import example

pytest.importorskip("mujoco", reason="the example takes inertias from MuJoCo")

PAGE = Path(__file__).resolve().parents[3] / "docs" / "engines.md"
toy_class = partial(example.toy_class, PAGE)

# Loading


def with_attributes(**changes: Any) -> Any:
    return type("Wrong", (toy_class(),), changes)


def failing() -> None:
    raise RuntimeError("no licence")


LOADED: dict[str, tuple[Callable[[], Any], str]] = {
    "no name": (lambda: type("Nothing", (mbcheck.Engine,), {}), "has no name; see docs/engines.md"),
    "a path for a name": (lambda: with_attributes(name="a/b"), "calls itself 'a/b'"),
    "a name that turns the line round": (
        lambda: with_attributes(name="\u202eenigne"),
        "calls itself '\\u202eenigne'",
    ),
    "a name that fills a table": (lambda: with_attributes(name="x" * 64), "at most 63"),
    "a version that turns it round": (
        lambda: with_attributes(version="1\u202e"),
        "version must be text",
    ),
    "no methods": (lambda: with_attributes(methods=()), "methods must be a tuple"),
    "a word for a method": (
        lambda: with_attributes(methods=("RK4",)),
        "str 'RK4' is no mbcheck.Method",
    ),
    "a method with a slash": (
        lambda: with_attributes(methods=(mbcheck.Method("RK 4/5", 4),)),
        "calls a method 'RK 4/5'; a name has",
    ),
    "order 0": (
        lambda: with_attributes(methods=(mbcheck.Method("a", 0),)),
        "order must be 1 or more",
    ),
    "an unknown scheme": (
        lambda: with_attributes(methods=(mbcheck.Method("a", 4, "RK4"),)),
        "did you mean 'RK44'?",
    ),
    "an unknown linear scheme": (
        lambda: with_attributes(methods=(mbcheck.Method("a", 2, linear_scheme="trapezoid"),)),
        "unknown linear scheme of toy_engine:Toy a 'trapezoid'; did you mean 'trapezoidal'?",
    ),
    "a scheme that is no name": (
        lambda: with_attributes(methods=(mbcheck.Method("a", 4, ["RK44"]),)),  # type: ignore[arg-type]
        "did you mean 'RK44'?",
    ),
    "a word for yes or no": (
        lambda: with_attributes(methods=(mbcheck.Method("a", 1, scheme_with_loops="no"),)),  # type: ignore[arg-type]
        "scheme_with_loops must be True or False, not str 'no'",
    ),
    "two of a name": (
        lambda: with_attributes(methods=(mbcheck.Method("a", 1),) * 2),
        "same name: a, a",
    ),
    "too few arguments": (
        lambda: with_attributes(accelerations=lambda self, q, v: q),
        "accelerations(q, v) cannot be called with the 4 arguments",
    ),
    "no function": (lambda: with_attributes(mass_matrix=3), "mass_matrix must be a function"),
    "a helper under a name that is taken": (
        lambda: with_attributes(reactions=lambda self: []),
        "cannot be called with the 4 arguments of the protocol (too many positional arguments); "
        "see docs/engines.md, and rename it if it is a helper of yours",
    ),
    "options as a table": (
        lambda: with_attributes(options=(mbcheck.Option("a", "1", 1.0, (1.0,), "a"),)),
        "options must be a function, not tuple",
    ),
    "a reason as text": (
        lambda: with_attributes(unsupported_reason="no loops"),
        "unsupported_reason must be a function, not str 'no loops'; rename it",
    ),
    "models as text": (
        lambda: with_attributes(reads_mjcf=False, models=("a", "b")),
        "models must be a function, not tuple",
    ),
    "a model of its own beside the file": (
        lambda: with_attributes(describe_model=lambda self, system: mbcheck.ModelDescription()),
        'compliant_joints = True, or closure = "soft"',
    ),
    "a word for what it reads": (
        lambda: with_attributes(reads_mjcf="no"),
        "reads_mjcf must be True or False, not str 'no'",
    ),
    "a number for its clock": (
        lambda: with_attributes(accumulates_clock=1),
        "accumulates_clock must be True or False, not int 1",
    ),
    "raises": (lambda: failing, "RuntimeError on creation: no licence"),
}


@pytest.mark.parametrize("name", LOADED)
def test_what_does_not_follow_the_protocol_is_refused(name: str) -> None:
    make, said = LOADED[name]
    found = make()
    raising = {"__init__": lambda self: found()}
    wrong = found if isinstance(found, type) else type("Raising", (), raising)
    with pytest.raises(UsageError, match=re.escape(said)):
        adapt("toy_engine:Toy", wrong)


def test_places_that_are_none_are_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "half_engine.py").write_text(
        "import mbcheck\nclass Half: pass\nclass Taken(mbcheck.Engine):\n name='mujoco'\n"
    )
    (tmp_path / "torn_engine.py").write_text("import nothing_of_this_name\n")
    with pytest.raises(EngineUnavailableError, match="in the folder of no_such_module, or"):
        engines.get_engine("no_such_module:Engine")
    with pytest.raises(EngineUnavailableError, match="provides nothing_of_this_name"):
        engines.get_engine("torn_engine:Engine")
    with pytest.raises(UsageError, match="unknown class of half_engine 'Hal'; did you mean 'Half'"):
        engines.get_engine("half_engine:Hal")
    with pytest.raises(UsageError, match="has no version"):
        engines.get_engine("half_engine:Taken")
    with pytest.raises(UsageError, match="with a colon"):
        engines.get_engine("half_engine.Half")


# What the file holds


def test_a_system_has_the_state_and_the_switch_of_its_case() -> None:
    case = get_scene("rotating_beam").case("pulse_quick")
    engine = adapt("toy_engine:Toy", toy_class())
    system = engine.bind(case, "chain").system(case)
    stop = mjcf.models("rotating_beam")["chain"].stop(case.parameters)
    assert stop is not None
    on, off = (
        system.force(time, system.positions + 1.0, system.velocities) for time in (0.5 * stop, stop)
    )
    assert system.joints[:2] == ("clock", "theta")
    assert on[1] != 0 == off[1]


def test_loops_of_a_system_are_closed_where_the_case_starts() -> None:
    case = get_scene("speed_regulator").cases[0]
    system = adapt("toy_engine:Toy", toy_class()).bind(case, "connect").system(case)
    assert np.max(np.abs(gaps(mechanism(system.mjcf), system.positions))) < 1e-15
    assert [one.name for one in system.closures] == ["closure"]


def test_every_kind_has_quantities_for_a_plugged_engine() -> None:
    engine = adapt("toy_engine:Toy", toy_class())
    case = get_scene("hula_hoop").case("point_mass_3hz_60n")
    for kind in set(kinds_of(case)):
        method = engine.methods[0] if KINDS[kind].integrates else None
        assert KINDS[kind].quantities(Setup(engine, case, "tree", method))
