"""Wrong engines that others plug in: what is said of them, and where."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.reports.run.located import located
from mbcheck.models.mechanism import Term
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError, EngineUnavailableError
from mbcheck.tests.support import example
from mbcheck.tests.support.example import bad, results

pytest.importorskip("mujoco", reason="the example takes inertias from MuJoCo")

PAGE = Path(__file__).resolve().parents[3] / "docs" / "engines.md"
blocks = partial(example.blocks, PAGE)
toy_class = partial(example.toy_class, PAGE)


# Faults, and where they are found


def with_terms(change: Callable[[Term], Term | None]) -> Callable[[Any], Any]:
    """Return a fault that changes, or drops, terms of the forces."""

    def altered(system: Any) -> Any:
        terms = (change(term) for term in system.terms)
        return replace(system, terms=tuple(term for term in terms if term))

    def broken(toy: Any) -> Any:
        class Broken(toy):
            def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
                return super().accelerations(altered(system), time, q, v)

        return Broken

    return broken


def with_text(pattern: str, replacement: str) -> Callable[[Any], Any]:
    """Return a fault of the reader: it takes the file for another one."""

    def broken(toy: Any) -> Any:
        class Broken(toy):
            def load(self, system: Any) -> Any:
                text, count = re.subn(pattern, replacement, system.mjcf)
                assert count
                return super().load(replace(system, mjcf=text))

        return Broken

    return broken


def with_answer(**changes: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a fault that changes what functions return."""

    def broken(toy: Any) -> Any:
        def changed(name: str, change: Callable[[Any], Any]) -> Any:
            def function(self: Any, *arguments: Any) -> Any:
                return change(getattr(toy, name)(self, *arguments))

            return function

        functions = {name: changed(name, change) for name, change in changes.items()}
        return type("Broken", (toy,), functions)

    return broken


def late(toy: Any) -> Any:
    """Take the forces of the step's begin for those of its middle."""

    class Broken(toy):
        def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
            self.step = step
            return super().simulate(system, method, step, times)

        def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
            return super().accelerations(system, time, q, v) * (1 + 1e-3 * getattr(self, "step", 0))

    return Broken


def dropped(kind: str) -> Callable[[Any], Any]:
    return with_terms(lambda term: None if term.kind == kind else term)


FAULTS: dict[str, tuple[Callable[[Any], Any], str, list[str]]] = {
    "no dampers": (
        dropped("damper"),
        "hula_hoop",
        ["damper of y: dropped (hula_hoop)", "damper of theta: dropped (hula_hoop)"],
    ),
    "no tendons": (
        dropped("tendon_spring"),
        "hula_hoop",
        ["tendon spring of spring: dropped (hula_hoop)"],
    ),
    "motors backwards": (
        with_terms(
            lambda t: (
                replace(t, constant=-t.constant, per_rate=-t.per_rate) if t.name == "motor_1" else t
            )
        ),
        "rotor_pendulum",
        ["actuator of motor_1: its sign is reversed (rotor_pendulum)"],
    ),
    "a spring by 0.1 %": (
        with_terms(
            lambda t: replace(t, per_length=1.001 * t.per_length) if t.kind == "spring" else t
        ),
        "rotor_pendulum",
        [
            "spring of x: counted 1.001 times (rotor_pendulum)",
            "spring of phi_3: counted 1.001 times (rotor_pendulum)",
        ],
    ),
    "no armature": (
        with_text(r' armature="[^"]*"', ""),
        "hula_hoop",
        ["armature of foot: dropped (hula_hoop)"],
    ),
    "a mass by 0.1 %": (
        with_text(r'mass="0.045"', 'mass="0.045045"'),
        "hula_hoop",
        ["mass of rod: counted 1.001 times (hula_hoop)"],
    ),
    "gravity of its own": (
        with_text('gravity="0 0 0"', 'gravity="0 -9.81 0"'),
        "hula_hoop",
        ["gravity of 9.81 m/s^2, where the file has none (hula_hoop)"],
    ),
    "gravity of its own, beside motors": (
        with_text('gravity="0 0 0"', 'gravity="0 -9.81 0"'),
        "rotor_pendulum",
        ["gravity of 9.81 m/s^2, where the file has none (rotor_pendulum)"],
    ),
    "a flag that nothing depends on": (
        with_text('<flag contact="disable"', '<flag contact="disable" gravity="disable"'),
        "hula_hoop",
        [],
    ),
}
"""Fault -> what is broken, in which scene, and what is said of the first level that is wrong."""


@pytest.mark.parametrize("name", FAULTS)
def test_parts_name_what_is_wrong(name: str) -> None:
    broken, scene, said = FAULTS[name]
    found = located(results(broken(toy_class()), scene, ("parts", "algebra")))
    expected = ["toy: its reading of the model is wrong", *(f"  {line}" for line in said)]
    assert found == (expected if said else [])


def test_a_step_that_is_wrong_is_not_blamed_on_the_model() -> None:
    found = located(results(late(toy_class()), "hula_hoop"))
    assert found[0] == "toy: a single step from a right state is wrong, parts and algebra right"


def test_degrees_are_seen_for_what_they_are() -> None:
    def in_degrees(motion: Any) -> Any:
        return replace(motion, positions=motion.positions * [1.0, 1.0, 180 / np.pi])

    found = bad(results(with_answer(simulate=in_degrees)(toy_class()), "hula_hoop"))
    (theta,) = (item for item in found if item.quantity == "theta")
    assert "theta fits if it is in degrees" in theta.reason


def test_joints_that_are_exchanged_are_named() -> None:
    def exchanged(motion: Any) -> Any:
        return replace(motion, positions=np.asarray(motion.positions)[:, [0, 2, 1]])

    found = located(results(with_answer(simulate=exchanged)(toy_class()), "hula_hoop"))
    assert found[1:] == ["  observables are exchanged: y is theta, theta is y (hula_hoop)"]


RETURNED: dict[str, tuple[dict[str, Callable[[Any], Any]], str]] = {
    "no Motion": ({"simulate": lambda m: vars(m)}, "simulate must return a Motion, not dict"),
    "transposed": (
        {"simulate": lambda m: replace(m, positions=m.positions.T)},
        "expected (1, 3); it is transposed",
    ),
    "one time too few": (
        {"simulate": lambda m: replace(m, velocities=m.velocities[:-1])},
        "Motion.velocities has shape (0, 3), expected (1, 3)",
    ),
    "an imaginary part": ({"accelerations": lambda a: a + 0.5j}, "accelerations must be real"),
    "nothing": ({"accelerations": lambda a: None}, "must be real numbers, not NoneType None"),
    "NaN in a joint that nobody observes": (
        {"simulate": lambda m: replace(m, positions=m.positions * [np.nan, 1.0, 1.0])},
        "non_finite: the joint foot is not finite",
    ),
    "steps in words": (
        {"simulate": lambda m: replace(m, steps="many")},
        "Motion.steps must be real",
    ),
    "warnings in a list": ({"simulate": lambda m: replace(m, warnings=["bad"])}, "counts by name"),
    "words": (
        {"simulate": lambda m: replace(m, positions="fast")},
        "must be real numbers, not str 'fast'",
    ),
    "NaN": ({"simulate": lambda m: replace(m, positions=np.nan * m.positions)}, "non_finite: "),
    "a clock that stands": (
        {"simulate": lambda m: replace(m, clock=0 * m.clock)},
        "clock: the engine's",
    ),
    "steps not taken": (
        {"simulate": lambda m: replace(m, steps=0)},
        "step_count: the engine took 0",
    ),
    "a warning": (
        {"simulate": lambda m: replace(m, warnings={"bad": 2})},
        "counter bad is 2",
    ),
    "NaN accelerations": (
        {"accelerations": lambda a: np.nan * a},
        "non_finite: accelerations holds nan",
    ),
    "too many accelerations": (
        {"accelerations": lambda a: [*a, 0]},
        "has shape (4,), expected (3,)",
    ),
}


@pytest.mark.parametrize("name", RETURNED)
def test_what_an_engine_returns_is_looked_at(name: str) -> None:
    changes, said = RETURNED[name]
    found = bad(results(with_answer(**changes)(toy_class()), "hula_hoop"))
    assert found
    assert {item.verdict for item in found} == {"error"}
    assert any(said in item.reason for item in found), found[0].reason


def test_a_mass_matrix_that_is_none_is_refused() -> None:
    case = get_scene("hula_hoop").cases[0]
    engine = adapt("toy_engine:Toy", with_answer(mass_matrix=np.diag)(toy_class()))
    with pytest.raises(EngineError, match=re.escape("mass_matrix has shape (3,), expected (3, 3)")):
        engine.bind(case, "tree").mass_matrices(np.zeros((1, 4)))


def test_what_an_engine_cannot_do_is_skipped_with_its_reason() -> None:
    found = results(toy_class(), "speed_regulator")
    assert {item.verdict for item in found} == {"skipped"}
    assert any(item.reason == "no loops" for item in found)


def test_an_engine_may_tell_no_more_than_runs() -> None:
    class Bare(mbcheck.Engine):
        name, version, methods = "bare", "1", toy_class().methods

        def simulate(self, *arguments: Any) -> Any:
            return toy_class()().simulate(*arguments)

    found = results(Bare, "hula_hoop")
    found += results(Bare, "hula_hoop", ("frequency",), "rest_rod_across")
    assert not bad(found)
    assert {item.kind for item in found if item.verdict == "pass"} == {"step"}
    assert {item.reason for item in found if item.verdict == "skipped"} == {
        "bare has no accelerations(...)"
    }


def test_an_engine_without_mass_matrix_is_still_told_which_inertia_is_wrong() -> None:
    class Blind(mbcheck.Engine):
        name, version, methods = "blind", "1", toy_class().methods

        def __init__(self) -> None:
            self.inner = with_text('mass="0.45"', 'mass="0.9"')(toy_class())()

        def simulate(self, *arguments: Any) -> Any:
            return self.inner.simulate(*arguments)

        def accelerations(self, *arguments: Any) -> Any:
            return self.inner.accelerations(*arguments)

    found = results(Blind, "hula_hoop", ("parts",))
    said = "mass of main_mass: counted 2 times, or an armature of 0.45 kg on y"
    assert f"  {said}, which the file does not have (hula_hoop)" in located(found)
    assert [r.reason for r in found if r.quantity == "mass_matrix"] == [
        "blind has no mass_matrix(...)"
    ]


@pytest.mark.parametrize(("factor", "verdict"), [(1.0, "pass"), (1.001, "deviation")])
def test_an_engine_may_tell_its_own_linearisation(factor: float, verdict: str) -> None:
    asked = []

    class Linear(toy_class()):  # type: ignore[misc]
        def accelerations(self, *arguments: Any) -> Any:
            raise mbcheck.Unsupported("none")

        def linearise(self, system: Any) -> Any:
            asked.append(system.case.name)
            mass = self.mass_matrix(system, system.positions)
            matrices = {"per_rate": np.zeros_like(mass), "per_length": np.zeros_like(mass)}
            for term in system.terms:
                along = np.array([term.joints.get(name, 0.0) for name in system.joints])
                for name, matrix in matrices.items():
                    matrix -= getattr(term, name) * np.outer(along, along)
            return mass, matrices["per_rate"], factor * matrices["per_length"]

    found = results(Linear, "hula_hoop", ("frequency",), "rest_rod_across")
    assert asked
    assert verdict in {item.verdict for item in found}
    assert {item.verdict for item in found} <= {verdict, "pass"}


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        (r' armature="[^"]*"', "armature of foot: dropped"),
        (r'name="theta" type="hinge" axis="0 0 1" damping="[^"]*"', "damper of theta: dropped"),
    ],
)
def test_a_dropped_part_is_named_without_a_mass_matrix(pattern: str, said: str) -> None:
    """Where other parts could stand for it only in shares that rounding hides."""

    class Blind(mbcheck.Engine):
        name, version, methods = "blind", "1", toy_class().methods
        reads = staticmethod(toy_class())

        def simulate(self, *arguments: Any) -> Any:
            return self.reads().simulate(*arguments)

        def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
            text = re.sub(pattern, lambda found: found[0].split(" armature")[0], system.mjcf)
            terms = system.terms
            if "damping" in pattern:
                terms = tuple(t for t in terms if (t.kind, t.name) != ("damper", "theta"))
            return self.reads().accelerations(replace(system, mjcf=text, terms=terms), time, q, v)

    found = located(results(Blind, "hula_hoop", ("parts",), "point_mass_3hz_60n"))
    assert found[1:] == [f"  {said} (hula_hoop)"]


def test_a_step_of_low_order_does_not_hide_a_wrong_model() -> None:
    class Euler(toy_class()):  # type: ignore[misc]
        methods = (mbcheck.Method("euler", 1),)

        def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
            terms = (
                replace(t, per_rate=1.05 * t.per_rate) if t.kind == "damper" else t
                for t in system.terms
            )
            return super().accelerations(replace(system, terms=tuple(terms)), time, q, v)

    found = bad(results(Euler, "hula_hoop", ("step",)))
    assert "extrapolated" in {item.quantity for item in found}


def test_an_engine_cannot_change_what_others_are_shown() -> None:
    system = (
        adapt("toy_engine:Toy", toy_class())
        .bind(get_scene("speed_regulator").cases[0], "connect")
        .system(get_scene("speed_regulator").cases[0])
    )
    with pytest.raises(TypeError):
        del system.terms[0].joints["y"]  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match="read-only"):
        system.closures[0].first.position[0] = 1.0


def test_an_engine_that_ends_the_process_ends_one_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    leaving = (
        "\n\nclass Leaving(Toy):\n    name = 'leaving'\n\n    def accelerations(self, *state):\n"
    )
    text = f"import os\n{blocks('python')[0]}{leaving}        os._exit(0)\n"
    (tmp_path / "leaving_engine.py").write_text(text, encoding="utf-8")
    (tmp_path / "exit_engine.py").write_text("raise SystemExit(0)\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    pattern = ["*/point_mass_3hz_60n/algebra/*"]
    found = mbcheck.check(engines=["leaving_engine:Leaving"], ids=pattern)
    assert found.exit_code == 1
    assert "exit code 0" in found.results[0].reason
    with pytest.raises(EngineUnavailableError, match="SystemExit: 0"):
        engines.get_engine("exit_engine:Engine")


def test_an_engine_that_reads_no_mjcf_speaks_the_scenes_coordinates() -> None:
    class Own(mbcheck.Engine):
        name, version = "own", "1"
        methods = (mbcheck.Method("midpoint", 2, "ExplicitMidpoint"),)
        reads_mjcf = False

        def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
            scene = get_scene(system.case.scene)
            state = np.concatenate([q, v])
            return scene.right_hand_side(system.case.parameters)(time, state)[len(q) :]

        simulate = toy_class().simulate

    found = results(Own, "rotor_pendulum")
    found += results(Own, "rotor_pendulum", name="modes_at_rest", kinds=("frequency",))
    assert not bad(found)
    assert {item.kind for item in found if item.verdict == "pass"} == {
        "algebra",
        "step",
        "frequency",
    }
    assert {item.verdict for item in results(Own, "rotating_beam")} == {"skipped"}
