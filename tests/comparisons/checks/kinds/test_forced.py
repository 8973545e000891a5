"""Models whose drive is a force in time: engines that take it at another time, or not at all."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from mbcheck.comparisons.checks.suite import kinds_of, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Case
from mbcheck.tests.support.example import all_checks

mujoco = pytest.importorskip("mujoco")

HULA = get_scene("hula_hoop").case("point_mass_3hz_60n")
PULSE = get_scene("rotating_beam").case("pulse_quick")
BEGUN = replace(PULSE, horizon=0.5)
"""The first third of the pulse."""


class Driven(MujocoPlugin):
    """MuJoCo whose runs have the drive of another time; its accelerations are right."""

    methods: Any = MujocoPlugin.methods[:1]

    def __init__(self, shift: float = 0.0, holds: bool = False, ends: bool = True) -> None:
        self.shift, self.holds, self.ends = shift, holds, ends

    def call(self, function: Any, system: Any, *state: Any) -> None:
        """Call MuJoCo with the drive shifted by so many steps, held over a step, or without end."""
        if function is not mujoco.mj_step:
            super().call(function, system, *state)
            return
        model, data = self.at(system, *state)
        if not self.ends:
            model.opt.disableactuator = 0
            system = replace(system, terms=tuple(replace(t, until=None) for t in system.terms))
        late = self.shift * model.opt.timestep
        first = system.controls(data.time + late)

        def control(_: Any, now: Any) -> None:
            now.ctrl[:] = first if self.holds else system.controls(now.time + late)

        mujoco.set_mjcb_control(control)
        function(model, data)
        mujoco.set_mjcb_control(None)


class Undriven(MujocoPlugin):
    """MuJoCo as its viewer runs a file: no control."""

    def call(self, function: Any, system: Any, *state: Any) -> None:
        """Call MuJoCo with the file alone."""
        function(*self.at(system, *state))


class Cached(MujocoPlugin):
    """MuJoCo that keeps the terms of the first system of each file."""

    methods: Any = MujocoPlugin.methods[:1]

    def call(self, function: Any, system: Any, *state: Any) -> None:
        """Call MuJoCo with these."""
        kept = vars(self).setdefault("kept", {}).setdefault(system.mjcf, system.terms)
        super().call(function, replace(system, terms=kept), *state)


class CachedControls(MujocoPlugin):
    """MuJoCo that keeps the controls of each time of a file."""

    methods: Any = MujocoPlugin.methods[:1]

    def call(self, function: Any, system: Any, *state: Any) -> None:
        """Call MuJoCo with these."""
        kept = vars(self).setdefault("kept", {})

        def control(_: Any, now: Any) -> None:
            now.ctrl[:] = kept.setdefault((system.mjcf, now.time), system.controls(now.time))

        mujoco.set_mjcb_control(control)
        function(*self.at(system, *state))
        mujoco.set_mjcb_control(None)


def results(engine: Any, case: Case, kinds: tuple[str, ...]) -> list[Result]:
    """Return what some kinds of check say of an engine on the model that a force drives."""
    one = adapt("forced:Driven", engine)
    checks = [
        check
        for kind in kinds_of(case)
        if kind in kinds
        for check in all_checks(kind, case, one, twins=True)
        if not check.full_only
    ]
    assert checks
    return [item for check in checks for item in run_check(check, engine=one)]


WRONG = {
    "the force is one step late": Driven(-1.0),
    "the force is one step early": Driven(1.0),
    "the force is constant in each step, as at its start": Driven(holds=True),
    "the force is constant in each step, as in its middle": Driven(0.5, holds=True),
    "the force is constant in each step, as at its end": Driven(1.0, holds=True),
}


def test_a_force_at_its_own_time_passes() -> None:
    kinds = ("parts", "algebra", "step", "trajectory")
    found = results(Driven(), HULA, kinds)
    assert {item.verdict for item in found} == {"pass"}
    assert {item.kind for item in found} == set(kinds)


@pytest.mark.parametrize("said", WRONG)
@pytest.mark.parametrize("kind", ["step", "trajectory"])
def test_a_force_at_another_time_is_named(said: str, kind: str) -> None:
    assert {item.verdict for item in results(WRONG[said], HULA, ("algebra",))} == {"pass"}
    found = results(WRONG[said], HULA, (kind,))
    assert {item.verdict for item in found} == {"deviation"}
    assert {item.cause for item in found} == {said}


def test_a_force_that_is_a_little_weaker_is_named() -> None:
    class Weaker(Driven):
        """Counts a force 0.1 % less."""

        def call(self, function: Any, system: Any, *state: Any) -> None:
            """Call MuJoCo with it."""
            terms = (replace(t, amplitude=0.999 * t.amplitude) for t in system.terms)
            super().call(function, replace(system, terms=tuple(terms)), *state)

    (share,) = (
        item
        for item in results(Weaker(), HULA, ("parts",))
        if item.verdict == "deviation" and item.quantity != "unexplained"
    )
    assert share.quantity == "actuator.force"
    assert "counted 0.999 times" in share.reason


@pytest.mark.parametrize("kind", ["parts", "algebra", "step", "trajectory"])
def test_an_engine_that_takes_no_controls_is_not_accused(kind: str) -> None:
    found = results(Undriven(), HULA, (kind,))
    assert {item.verdict for item in found} == {"skipped"}
    assert all(item.reason.startswith("it moves as without the drive") for item in found)


@pytest.mark.parametrize(
    ("engine", "kind"),
    [
        *((Cached, kind) for kind in ("parts", "algebra", "step", "trajectory")),
        (CachedControls, "step"),
        (CachedControls, "trajectory"),
    ],
)
def test_the_drive_of_an_earlier_case_is_an_error(engine: Any, kind: str) -> None:
    found = results(engine(), HULA, (kind,))
    assert {item.verdict for item in found} == {"error"}
    assert all("the drive of an earlier case is still applied" in item.reason for item in found)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["step", "trajectory"])
def test_the_pulse_of_a_beam_is_late(kind: str) -> None:
    said = "the force is one step late"
    found = [item for item in results(WRONG[said], BEGUN, (kind,)) if item.verdict == "deviation"]
    assert found
    assert {item.cause for item in found} == {said}


@pytest.mark.slow
def test_the_pulse_of_a_beam_is_held_late_or_without_end() -> None:
    assert {item.verdict for item in results(Driven(), BEGUN, ("trajectory",))} == {"pass"}
    held = results(Driven(holds=True), BEGUN, ("step", "trajectory"))
    assert {item.kind for item in held if item.verdict == "deviation"} == {"step", "trajectory"}
    said = {item.cause for item in held if item.kind == "step"} - {None}
    assert said == {"the force is constant in each step, as at its start"}
    endless = results(Driven(ends=False), PULSE, ("trajectory",))
    causes = {item.cause for item in endless} - {None}
    assert causes == {"it is right until the drive ends at t = 1.5 s, and wrong after that"}
