"""Engines that are more accurate than their method and step allow, with and without a scheme."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbcheck
from mbcheck.comparisons.checks import elements
from mbcheck.comparisons.checks.kinds import one_step, order
from mbcheck.comparisons.checks.verdict import Finding, judge
from mbcheck.comparisons.engines.adapter import BoundModel, adapt
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.comparisons.faults.variants import Wrapped
from mbcheck.reference import get_scene
from mbcheck.tests.support.engines.floating import Floating
from mbcheck.tests.support.engines.sliding import Sliding
from mbcheck.tests.support.engines.solved import STAGES, Solved
from mbcheck.tests.support.engines.turning import Turning
from mbcheck.tests.support.example import all_checks, bad, results

KINDS = ("step", "order")
CASES = {
    "hula_hoop": "spinning_3hz_60n",
    "rotor_pendulum": "case_2_startup",
    "speed_regulator": "rotation",
}


def own(scheme: str, order: int, substeps: int = 1, told: int | None = None) -> Solved:
    """Return an engine whose method names no scheme, with equal substeps."""
    method = mbcheck.Method(scheme, order, evaluations_per_step=told)
    return Solved(method, scheme, substeps=substeps)


class Exact(Solved):
    """What returns the reference, whatever the step."""

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        """Return the reference's states."""
        derivative = get_scene(system.case.scene).right_hand_side(system.case.parameters)
        start, n = np.concatenate([system.positions, system.velocities]), len(system.joints)
        span = system.start_time, times[-1]
        found = solve_ivp(derivative, span, start, "DOP853", times, rtol=3e-14, atol=1e-15).y.T
        return mbcheck.Motion(found[:, :n], found[:, n:])


def judged(engine: Solved, scene: str, kinds: tuple[str, ...] = KINDS) -> Any:
    """Return the results of an engine."""
    return results(engine, scene, kinds, CASES[scene], explain=False)


@pytest.mark.parametrize("order", [1, 2, 4])
@pytest.mark.parametrize("scene", CASES)
def test_the_reference_does_not_pass_for_a_method(scene: str, order: int) -> None:
    found = judged(Exact(mbcheck.Method("RK44", order)), scene)
    seen = {item.kind for item in bad(found) if item.quantity == "least_error"}
    assert seen == set(KINDS)
    assert all("with a smaller error it sub-steps" in item.reason for item in bad(found))


@pytest.mark.parametrize(
    ("base", "scene", "case"),
    [
        (Turning, "rigid_body", "heavy_tumbling"),
        pytest.param(Sliding, "ball_hoop", "weighed", marks=pytest.mark.slow),
        pytest.param(Floating, "floating_platform", "tumbling", marks=pytest.mark.slow),
    ],
)
def test_bodies_in_space_do_not_move_as_if_by_no_method(base: Any, scene: str, case: str) -> None:
    """64 steps of order 4 in each are the reference but for 1e-9 of what order 2 leaves."""

    class Fine(base):
        methods = (mbcheck.Method("own", 2),)

        def step(self, system: Any, time: float, q: Any, v: Any, h: float) -> Any:
            for k in range(64):
                q, v = super().step(system, time + k * h / 64, q, v, h / 64)
            return q, v

    for engine, verdict in ((base(), "pass"), (Fine(), "deviation")):
        plugged, one = adapt("own", engine), get_scene(scene).case(case)
        check = next(
            check for check in all_checks("step", one, plugged) if not check.unsupported_reason
        )
        least = one_step.error_from_below(check.setup(plugged))
        assert isinstance(least, Finding)
        assert judge(least, 1.0)[0] == verdict
        assert "with a smaller error it sub-steps" in least.reason


class Continuum(Wrapped):
    """Elements that have the first frequency of the continuum, however few they are."""

    def compute(self, model: BoundModel, name: str, *arguments: Any) -> Any:
        """Return the engine's matrices, stiffer or softer by as much as they are off."""
        if name != "linearise":
            return super().compute(model, name, *arguments)
        mass, damping, stiffness = model.linearise(*arguments)
        setup = Setup(self.engine, model.case, model.name)
        own, right = elements.of_engine(setup)[0], elements.of_continuum(setup)[0]
        return mass, damping, stiffness * (right / own) ** 2


def test_the_continuum_does_not_pass_for_elements() -> None:
    case = get_scene("rotating_beam").case("steady_at_rest")
    for engine, verdict in ((ExudynAdapter(), "pass"), (Continuum(ExudynAdapter()), "deviation")):
        findings = order.measure(Setup(engine, case, "elements")).findings
        (least,) = (item for item in findings if item.quantity == "least_error")
        assert isinstance(least, Finding)
        assert judge(least, 1.0)[0] == verdict


@pytest.mark.parametrize("scheme", STAGES)
@pytest.mark.parametrize("scene", CASES)
def test_methods_without_a_scheme_pass(scene: str, scheme: str) -> None:
    order = {"semi_implicit_euler": 1, "ExplicitMidpoint": 2, "RK33": 3, "RK44": 4, "DOPRI5": 5}
    found = judged(own(scheme, order[scheme], told=STAGES[scheme]), scene)
    assert not bad(found)
    assert any(item.verdict == "pass" and item.quantity == "least_error" for item in found)


def test_a_sharper_method_may_claim_a_lower_order() -> None:
    assert not bad(judged(own("RK44", 2), "hula_hoop"))


@pytest.mark.parametrize("substeps", [2, 10])
def test_substeps_are_seen_by_the_work_that_is_told(substeps: int) -> None:
    found = judged(own("ExplicitMidpoint", 2, substeps, told=2), "hula_hoop", ("order",))
    assert {item.verdict for item in found} <= {"error", "skipped"}
    assert {item.reason.split(":")[0] for item in bad(found)} == {"work_count"}


def test_substeps_that_no_work_tells_are_a_method_of_their_own() -> None:
    assert not bad(judged(own("ExplicitMidpoint", 2, 2), "hula_hoop"))
