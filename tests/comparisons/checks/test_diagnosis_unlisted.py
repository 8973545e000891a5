"""Engines that a fresh eye made up: what they tell, when they look at the drive, how they begin."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.suite import run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.reference import get_scene
from mbcheck.reference.quaternions import conjugate
from mbcheck.tests.support.engines.solved import Solved
from mbcheck.tests.support.engines.turning import Turning
from mbcheck.tests.support.example import all_checks, bad, results

pytest.importorskip("mujoco")

from mbcheck.examples.mujoco_engine import MujocoPlugin

from .test_diagnosis_plugged_in import Explicit, causes

HOOP = "spinning_3hz_60n"


class Telling(Turning):
    """A body on a ball joint whose quaternion is told by another convention."""

    def __init__(self, convention: Any) -> None:
        self.convention = convention

    def shown(self, q: Any) -> Any:
        """Return the quaternion as it is told."""
        return self.convention(q)


CONVENTIONS = {
    "has its scalar part last: it is (w, x, y, z) here": lambda q: np.roll(q, -1),
    "is that of the opposite rotation": lambda q: np.array(conjugate(q)),
    "is that of the opposite rotation, its scalar part last": lambda q: np.roll(conjugate(q), -1),
}


first, *others = CONVENTIONS


@pytest.mark.parametrize(
    "words", [first, *(pytest.param(words, marks=pytest.mark.slow) for words in others)]
)
def test_another_convention_of_quaternions_is_named(words: str) -> None:
    found = results(Telling(CONVENTIONS[words]), "rigid_body", ("step",), "heavy_tumbling")
    assert causes(found) == {f"the quaternion q {words}"}


class Staggered(MujocoPlugin):
    """Velocities as a leapfrog has them, half a step before the positions."""

    methods: Any = MujocoPlugin.methods[:1]

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
        """Integrate, and go back half a step with each velocity."""
        found = super().simulate(system, method, step, times)
        q, v = map(np.asarray, (found.positions, found.velocities))
        back = [self.accelerations(system, *at).copy() for at in zip(times, q, v, strict=True)]
        return replace(found, velocities=v - step / 2 * np.array(back))


class HalfRates(Turning):
    """Half the angular velocity, as rates of quaternions have it."""

    def simulate(self, *asked: Any) -> Any:
        """Integrate, and halve."""
        found = super().simulate(*asked)
        return replace(found, velocities=np.asarray(found.velocities) / 2)


class Leapfrog(Solved):
    """A leapfrog that tells its velocities as they stand, half a step before the positions."""

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        """Integrate, begun by half a step."""
        q, steps, rows = system.positions, 0, []
        v = system.velocities
        v = v - step / 2 * self.accelerations(system, system.start_time, q, v)
        for time in times:
            while (now := system.start_time + steps * step) + step / 2 < time:
                middle = v + step / 2 * self.accelerations(system, now, q, v)
                v = v + step * self.accelerations(system, now, q, middle)
                q, steps = q + step * v, steps + 1
            rows.append((q, v))
        positions, velocities = (np.array(part) for part in zip(*rows, strict=True))
        return mbcheck.Motion(positions, velocities, steps=steps)


RATES_ALONE = "positions are right, and the rates returned with them are wrong"
HALF_A_STEP = "rates are half a step behind positions, as those of a leapfrog are"


@pytest.mark.parametrize(
    ("engine", "scene", "case", "said"),
    [
        (Staggered(), "hula_hoop", HOOP, HALF_A_STEP),
        (Leapfrog(mbcheck.Method("leapfrog", 2)), "hula_hoop", HOOP, HALF_A_STEP),
        (HalfRates(), "rigid_body", "heavy_tumbling", RATES_ALONE),
    ],
)
def test_rates_that_are_not_those_of_the_positions_are_named(
    engine: Any, scene: str, case: str, said: str
) -> None:
    """Before another order is."""
    assert causes(results(engine, scene, ("step",), case)) == {said}


class Kutta(Explicit):
    """The classical method on MuJoCo's accelerations."""

    methods: Any = MujocoPlugin.methods[:1]


class Decimated(Kutta):
    """A controller that looks at the time in every fourth step alone."""

    every = 4

    def begin(self, start: float, number: int, step: float) -> float:
        """Return the time of the last of these steps."""
        return start + number // self.every * self.every * step

    def time(self, begin: float, share: float, step: float) -> float:
        """Return the same time for all stages."""
        return begin


class Halved(Decimated):
    """One that looks in every second step."""

    every = 2


class Clamped(Kutta):
    """Speeds that stop at a round number."""

    def stepped(self, system: Any, begin: float, x: Any, step: float) -> Any:
        """Return the state (2, n) after a step."""
        x = super().stepped(system, begin, x, step)
        place = system.joints.index("theta")
        x[1, place] = np.clip(x[1, place], -12.0, 12.0)
        return x


class Longer(Kutta):
    """Steps that are longer than those that it counts, by 1e-6."""

    def stepped(self, system: Any, begin: float, x: Any, step: float) -> Any:
        """Return the state (2, n) after a step."""
        return super().stepped(system, begin, x, (1 + 1e-6) * step)


class Unsteady(Kutta):
    """Accelerations that differ from call to call."""

    def accelerations(self, *asked: Any) -> Any:
        """Return them off by up to 1e-6."""
        return super().accelerations(*asked) * np.random.default_rng().uniform(1 - 1e-6, 1 + 1e-6)


@pytest.mark.parametrize(
    ("engine", "said"),
    [
        (Clamped, "theta_dot never exceeds 12 rad/s: it is clamped there"),
        (Longer, "its steps are longer than the given one, by 1e-06 of it"),
        (Unsteady, "it does not repeat itself: two identical calls differ by "),
    ],
)
@pytest.mark.parametrize("kind", ["step", "trajectory"])
def test_what_a_run_does_with_a_right_model_is_named(engine: Any, said: str, kind: str) -> None:
    (cause,) = causes(results(engine(), "hula_hoop", (kind,), HOOP))
    assert cause.startswith(said)


class SingleClock(Kutta):
    """A clock of 32 bits beside states of 64."""

    def begin(self, start: float, number: int, step: float) -> float:
        """Return the time as 32 bits have it."""
        return float(np.float32(start) + np.float32(number * step))


def forced(engine: Any) -> list[Result]:
    """Return single steps of the model that a force in time drives."""
    plugged, case = adapt("unlisted", engine), get_scene("hula_hoop").case(HOOP)
    checks = all_checks("step", case, plugged, twins=True)
    return [item for one in checks for item in run_check(one, "strict", plugged)]


def test_a_clock_of_32_bits_is_seen_though_steps_are_powers_of_two() -> None:
    assert not bad(forced(Kutta()))
    assert bad(forced(SingleClock()))


@pytest.mark.parametrize("engine", [Decimated, Halved])
def test_a_force_that_is_held_over_several_steps_is_named(engine: Any) -> None:
    said = "the force is constant over several steps, as at the start of the first"
    assert causes(forced(engine())) == {said}


class Backward(Solved):
    """The backward differentiation formula of order 2, begun by implicit Euler's method."""

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        """Integrate by fixed points."""
        x, n = np.concatenate([system.positions, system.velocities]), len(system.joints)
        before, steps, rows = None, 0, []
        for time in times:
            while system.start_time + (steps + 0.5) * step < time:
                steps, later = steps + 1, system.start_time + (steps + 1) * step
                base, share = (x, 1.0) if before is None else ((4 * x - before) / 3, 2 / 3)
                before, last = x, np.full_like(x, np.inf)
                while np.max(np.abs(x - last)) > 1e-14 * np.max(np.abs(x)):
                    last, force = x, self.accelerations(system, later, x[:n], x[n:])
                    x = base + share * step * np.concatenate([x[n:], force])
            rows.append(x)
        states = np.array(rows)
        return mbcheck.Motion(states[:, :n], states[:, n:], steps=steps)


class Behind(Solved):
    """A method of order 1 whose speeds change by the accelerations of the step before."""

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> mbcheck.Motion:
        """Integrate, by the accelerations of the start at first."""
        q, v, steps, rows = system.positions, system.velocities, 0, []
        before = self.accelerations(system, system.start_time, q, v)
        for time in times:
            while (now := system.start_time + steps * step) + step / 2 < time:
                force = self.accelerations(system, now, q, v)
                q, v, before = q + step * v, v + step * before, force
                steps += 1
            rows.append((q, v))
        positions, velocities = (np.array(part) for part in zip(*rows, strict=True))
        return mbcheck.Motion(positions, velocities, steps=steps)


@pytest.mark.parametrize(("engine", "order"), [(Backward, 2), (Behind, 1)])
def test_a_method_of_several_steps_may_begin_with_another_one(engine: Any, order: int) -> None:
    """In 1, 2 and 4 parts of a step the first one's error does not shrink as declared."""
    assert not bad(results(engine(mbcheck.Method("own", order)), "hula_hoop", ("step",), HOOP))


def test_of_such_a_method_another_order_than_the_declared_one_is_named() -> None:
    found = results(Behind(mbcheck.Method("own", 2)), "hula_hoop", ("step",), HOOP)
    assert causes(found) == {"own is of order 1, where 2 is declared"}
