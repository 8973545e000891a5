"""Mistakes of engines that others plug in: schemes, orders, joints and forces in time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.diagnosis import ANOTHER_MODEL, order_of
from mbcheck.comparisons.checks.suite import plan, quick, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.comparisons.reports.run.located import located
from mbcheck.models.system import System
from mbcheck.reference import get_scene
from mbcheck.tests.support.example import all_checks, bad, results

pytest.importorskip("mujoco")

from mbcheck.examples.mujoco_engine import MujocoPlugin

HULA = "point_mass_3hz_60n"
KUTTA = ((), (1 / 2,), (0, 1 / 2), (0, 0, 1)), (1 / 6, 1 / 3, 1 / 3, 1 / 6)


class Explicit(MujocoPlugin):
    """Runge-Kutta methods of its own, on MuJoCo's accelerations."""

    name = "explicit"
    methods: Any = (mbcheck.Method("RK4", 4, "RK44"),)
    tableau: ClassVar[Any] = KUTTA

    def begin(self, start: float, number: int, step: float) -> float:
        """Return the time at which a step with this number takes the drive to begin."""
        return start + number * step

    def time(self, begin: float, share: float, step: float) -> float:
        """Return the time of a stage."""
        return begin + share * step

    def stepped(self, system: Any, begin: float, x: Any, step: float) -> Any:
        """Return the state (2, n) after a step by the tableau."""
        slopes: list[Any] = []
        a, b = self.tableau
        for row in a:
            q, v = x + step * sum(w * k for w, k in zip(row, slopes, strict=True))
            at = self.time(begin, sum(row), step)
            slopes.append(np.array([v, self.accelerations(system, at, q, v)]))
        return x + step * sum(w * k for w, k in zip(b, slopes, strict=True))

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
        """Integrate from sample to sample, by a clock of its own."""
        x, steps, rows = np.array([system.positions, system.velocities]), 0, []
        for time in times:
            while system.start_time + (steps + 0.5) * step < time:
                begin = self.begin(system.start_time, steps, step)
                x, steps = self.stepped(system, begin, x, step), steps + 1
            rows.append(x)
        q, v = np.array(rows).swapaxes(0, 1)
        return mbcheck.Motion(q, v, steps=steps)


def explicit(tableau: Any, *methods: mbcheck.Method) -> Any:
    return type("Own", (Explicit,), {"tableau": tableau, "methods": methods or Explicit.methods})()


EULER = ((),), (1,)
DECLARED = "its steps are not those of RK44: its coefficients differ"
OTHERS = {
    "weights off by 0.01": ((KUTTA[0], (1 / 6, 1 / 3 + 0.01, 1 / 3 - 0.01, 1 / 6)), 2),
    "weights of the 3/8 rule": ((KUTTA[0], (1 / 8, 3 / 8, 3 / 8, 1 / 8)), 2),
    "the 3/8 rule": ((((), (1 / 3,), (-1 / 3, 1), (1, -1, 1)), (1 / 8, 3 / 8, 3 / 8, 1 / 8)), 4),
}
"""Tableau, and of what order it is."""


@pytest.mark.parametrize("name", OTHERS)
def test_another_tableau_than_the_declared_one_is_named(name: str) -> None:
    tableau, order = OTHERS[name]
    found = results(explicit(tableau), "hula_hoop", ("parts", "algebra", "step"), HULA)
    first, *more = located(found)
    assert first == "explicit: a single step from a right state is wrong, parts and algebra right"
    end = (
        f"and it is of order {order}, where 4 is declared"
        if order < 4
        else "though it is of order 4"
    )
    assert more == [f"  {DECLARED}, {end} (hula_hoop)"]


def test_the_declared_tableau_passes() -> None:
    assert not bad(results(explicit(KUTTA), "hula_hoop", ("step",), HULA))


class Divided(Explicit):
    """Several shorter steps in the place of each one."""

    parts = 2

    def stepped(self, system: Any, begin: float, x: Any, step: float) -> Any:
        """Return the state (2, n) after all of them."""
        short = step / self.parts
        for part in range(self.parts):
            x = super().stepped(system, begin + part * short, x, short)
        return x


SCHEMES = {
    "RK44": (4, KUTTA),
    "RK33": (3, (((), (1 / 3,), (0, 2 / 3)), (1 / 4, 0, 3 / 4))),
    "ExplicitMidpoint": (2, (((), (1 / 2,)), (0, 1))),
}


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(("parts", "words"), [(2, "two of half"), (3, "three of a third of")])
def test_steps_that_are_divided_are_named(scheme: str, parts: int, words: str) -> None:
    order, tableau = SCHEMES[scheme]
    methods = (mbcheck.Method(scheme, order, scheme),)
    engine = type("Own", (Divided,), {"tableau": tableau, "parts": parts, "methods": methods})()
    found = results(engine, "hula_hoop", ("step",), HULA)
    assert causes(found) == {f"each step is made of {words} the size"}


def test_steps_that_are_divided_are_not_named_where_others_explain_them_as_well() -> None:
    found = results(type("Own", (Divided,), {"parts": 7})(), "hula_hoop", ("step",), HULA)
    assert causes(found)
    assert not any("each step is made" in words for words in causes(found))


def test_a_tableau_is_not_blamed_for_forces_that_are_wrong() -> None:
    class Weak(Explicit):
        def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
            return 1.001 * super().accelerations(system, time, q, v)

    found = bad(results(Weak(), "hula_hoop", ("step",), HULA))
    assert {item.cause for item in found} == {ANOTHER_MODEL}
    assert located(found)[0] == f"explicit: {ANOTHER_MODEL}"


@pytest.mark.slow
def test_an_order_that_is_not_delivered_is_told_once_with_its_count() -> None:
    engine = explicit(EULER, mbcheck.Method("mid", 2))
    found = results(engine, "hula_hoop", ("parts", "algebra", "step", "order"), "free_undamped")
    found += results(engine, "hula_hoop", ("step",), HULA)
    (said,) = located(found)[1:]
    count = len({item.check_id for item in bad(found)})
    assert count > 1
    assert said == f"  mid is of order 1, where 2 is declared (hula_hoop; {count} checks)"


def test_orders_are_told_only_where_they_are_clear() -> None:
    halves = 0.5 ** np.arange(4)
    assert order_of(list(1e-3 * halves**2)) == 2
    assert order_of(list(1e-3 + 1e-3 * halves**2)) == 0  # another limit
    assert order_of(list(1e-12 * halves)) == 0  # rounding
    assert order_of([1e-3, 4e-4, 3e-4, 5e-5]) == 0


class Other(MujocoPlugin):
    """Joints in another order: throughout, or in what a run returns alone."""

    name = "other"

    def __init__(self, first: str, second: str, inputs_too: bool = True) -> None:
        self.pair, self.inputs_too = (first, second), inputs_too

    def order(self, system: System) -> list[int]:
        """Return the joints in the other order."""
        first, second = (system.joints.index(name) for name in self.pair)
        places = list(range(len(system.joints)))
        places[first], places[second] = second, first
        return places

    def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
        """Return accelerations in this order."""
        p = self.order(system) if self.inputs_too else slice(None)
        return super().accelerations(system, time, q[p], v[p])[p]

    def mass_matrix(self, system: Any, q: Any) -> Any:
        """Return the mass matrix in this order."""
        p = self.order(system) if self.inputs_too else list(range(len(q)))
        return super().mass_matrix(system, q[p])[np.ix_(p, p)]

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
        """Integrate, all in this order."""
        p = self.order(system)
        q, v = system.positions, system.velocities
        start = replace(system, positions=q[p], velocities=v[p]) if self.inputs_too else system
        motion = super().simulate(start, method, step, times)
        return replace(motion, positions=motion.positions[:, p], velocities=motion.velocities[:, p])


def causes(found: list[Result]) -> set[str]:
    return {item.cause or "" for item in bad(found)}


@pytest.mark.slow
@pytest.mark.parametrize("pair", [("y", "theta"), ("foot", "theta")])
def test_joints_in_another_order_are_named_by_each_level(pair: tuple[str, str]) -> None:
    found = results(Other(*pair), "hula_hoop", ("parts", "algebra", "step"), HULA)
    assert causes(found) == {f"joints {pair[0]} and {pair[1]} are exchanged"}
    assert {item.kind for item in bad(found)} == {"parts", "algebra", "step"}


@pytest.mark.slow
def test_joints_that_are_returned_in_another_order_are_named() -> None:
    """One of them is no observable."""
    wrong = Other("foot", "theta", inputs_too=False)
    found = results(wrong, "hula_hoop", ("algebra", "step", "trajectory"), HULA)
    assert causes(found) == {"joints foot and theta are exchanged in its results"}
    assert {item.kind for item in bad(found)} == {"step", "trajectory"}


@pytest.mark.slow
def test_of_four_joints_the_pair_is_named() -> None:
    wrong = Other("phi_3", "theta_2")
    found = results(wrong, "rotor_pendulum", ("parts", "algebra"), "case_1_startup")
    assert causes(found) == {"joints phi_3 and theta_2 are exchanged"}


class Late(MujocoPlugin):
    """A control one step late, held over the step or not; that of the start in the first one."""

    name, held, begin = "late", False, 0.0

    def call(self, function: Any, system: Any, *state: Any) -> None:
        """Call MuJoCo, and know when its step begins."""
        self.begin = state[0]
        super().call(function, system, *state)

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
        """Integrate with controls of the step before."""

        def late(time: float) -> Any:
            at = self.begin if self.held else time
            return system.controls(max(at - step, system.start_time))

        told = type("Told", (), {"__getattr__": lambda _, name: getattr(system, name)})()
        told.controls = late
        return super().simulate(told, method, step, times)


class HeldAndLate(Late):
    """The same, held."""

    held = True


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "words"),
    [
        (Late, "the force is one step late"),
        (
            HeldAndLate,
            "the force is constant in each step, as at the start of the step before",
        ),
    ],
)
def test_a_force_that_is_late_is_named_alike_by_steps_and_runs(engine: Any, words: str) -> None:
    plugged, case = adapt("late", engine()), get_scene("hula_hoop").case(HULA)
    for kind in ("step", "trajectory"):
        checks = [one for one in all_checks(kind, case, plugged, twins=True) if not one.full_only]
        found = [item for one in checks for item in run_check(one, engine=plugged)]
        assert causes(found) == {words}, kind


@pytest.mark.slow
def test_a_quick_answer_asks_for_a_force_in_time() -> None:
    chosen = [check for check in quick(plan(["hula_hoop"], ["mujoco"])) if check.kind == "step"]
    assert [check.model for check in chosen] == ["tree", "forced"]
    beam = quick(plan(["rotating_beam"], ["mujoco"]))  # whose reference takes long
    assert {check.model for check in beam} == {"chain"}
