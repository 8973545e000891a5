"""Seeded faults of 0.1 %: engines that read another number than they were given, or step wrongly.

Half of them are built-in engines with other parameters, half are plugged in as an author would do
it. `python -m mbcheck.tests.support.campaigns.seeded FIRST COUNT [SCENE...]` prints what is said of
each; without scenes those of the plane.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

import mbcheck
from mbcheck.comparisons.checks.suite import Check, checks_of, kinds_of, run_check
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines import registry
from mbcheck.comparisons.engines.adapter import Adapter, adapt
from mbcheck.comparisons.faults.catalogue import ENGINES
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.comparisons.reports.run.located import located
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import MbcheckError
from mbcheck.reference.scene import Case
from mbcheck.tests.support.engines.solved import Solved

PLANE = sorted(name for name in SCENES if not get_scene(name).quaternions)
SPACE = sorted({*SCENES} - {*PLANE})
"""Faults of rotations are provoked by name as well (`support.engines.turning`)."""

OFF = 1e-3
BLIND = 1e-7
"""A number whose 0.1 % changes accelerations by less, relative to their size, does not count."""

NUMBERS = (
    "body_mass", "body_inertia", "body_ipos", "body_pos", "dof_damping", "dof_armature",
    "jnt_stiffness", "qpos_spring", "actuator_gear", "actuator_biasprm", "tendon_stiffness",
    "tendon_damping", "wrap_prm",
)  # fmt: skip
"""Numbers of a compiled model that a reader may get wrong."""

DRIVING = ("clock", "foot")
"""Joints of heavy bodies that drive a scene, which move as they do whatever happens."""

LOOKED_AT = ("parts", "algebra", "step", "trajectory")


class Plugged(MujocoPlugin):
    """MuJoCo, plugged in as its author would; ``spoil`` changes what it compiled."""

    name, closure = "plugged", "rigid"
    methods: Any = MujocoPlugin.methods[:1]

    def __init__(self, spoil: Callable[[Any], None] | None = None, way: str = "") -> None:
        self.spoil, self.way = spoil, way

    def at(self, system: Any, time: float, q: Any, v: Any) -> Any:
        """Return model and data at a time and a state."""
        if system.closures:
            raise mbcheck.Unsupported("its loops are soft")
        fresh = self.text != system.mjcf
        model, data = super().at(system, time, q, v)
        if fresh and self.spoil:
            self.spoil(model)
        return model, data

    def simulate(self, system: Any, method: Any, step: float, times: Any) -> Any:
        """Integrate with mj_step."""
        model, data = self.at(system, system.start_time, system.positions, system.velocities)
        model.opt.timestep = step * (1 + OFF if self.way == "longer step" else 1)
        order = mujoco.mjtIntegrator
        model.opt.integrator = (
            order.mjINT_EULER if self.way == "another method" else order.mjINT_RK4
        )
        if self.way == "start ignored":
            data.qvel[:] = 0
        steps, rows = 0, []
        before = data.qpos.copy(), data.qvel.copy()
        for time in times:
            while system.start_time + (steps + 0.5) * step < time:
                before = data.qpos.copy(), data.qvel.copy()
                now = system.start_time + steps * step
                self.call(mujoco.mj_step, system, now, *before)
                steps += 1
            q, v = before if self.way == "late samples" else (data.qpos.copy(), data.qvel.copy())
            rows.append((q[::-1] if self.way == "joints reversed" else q, v))
        q, v = (np.array(values) for values in zip(*rows, strict=True))
        return mbcheck.Motion(q, v, steps=steps)


WAYS = ("longer step", "another method", "late samples", "start ignored", "joints reversed")
"""Mistakes of a run."""


@dataclass(frozen=True)
class Seeded:
    """An engine that is wrong, what is, and the levels that name it."""

    case: Case
    engine: Adapter
    what: str
    levels: tuple[str, ...]
    like: str


def seeded(number: int, scenes: Sequence[str] = PLANE) -> Seeded:
    """Return the fault of this number, the same one at any time."""
    random = np.random.default_rng([16, number])
    scene = get_scene(scenes[number // 2 % len(scenes)])
    cases = [case for case in scene.cases if "trajectory" in case.kinds and not case.full_only]
    while True:
        case = cases[random.integers(len(cases))]
        factor = 1 + OFF * float(random.choice((-1, 1)))
        if number % 2 == 0:
            found = misread(case, random, factor)
        elif scene.name == "speed_regulator":
            found = misread(case, random, factor, plugged=True)
        elif number % 10 == 9:
            way = WAYS[number // 10 % len(WAYS)]
            engine = adapt("plugged", Plugged(way=way))
            found = Seeded(case, engine, way, ("step",), "plugged")
        else:
            found = spoilt(case, random, factor)
        if found:
            return found


def misread(
    case: Case, random: np.random.Generator, factor: float, plugged: bool = False
) -> Seeded | None:
    """Return an engine with one other parameter, if accelerations show it."""
    scene, p = get_scene(case.scene), case.parameters
    name = str(random.choice(p.names()))
    try:
        other = p.replace(**{name: getattr(p, name) * factor})
    except (TypeError, MbcheckError):  # a word, or not allowed
        return None
    states = random.uniform(-1, 1, (8, 2 * len(scene.coordinates)))
    times = random.uniform(0, 1, 8)
    both = [
        np.array([scene.right_hand_side(q)(t, x) for t, x in zip(times, states, strict=True)])
        for q in (p, other)
    ]
    if np.max(np.abs(both[1] - both[0])) < BLIND * np.max(np.abs(both[0])) or name == "segments":
        return None
    like = str(random.choice(list(ENGINES)))

    def change(value: Any) -> Any:
        return value.replace(**{name: getattr(value, name) * factor})

    engine: Adapter = Misread(ENGINES[like](), change)
    if plugged:
        engine = adapt("solved", Solved(mbcheck.Method("RK4", 4, "RK44"), change=change))
    like = engine.name if plugged else like
    return Seeded(case, engine, f"{like}: {name} x {factor}", ("parts", "algebra"), like)


def spoilt(case: Case, random: np.random.Generator, factor: float) -> Seeded | None:
    """Return a plugged-in engine with one other number, if accelerations show it."""
    name = str(random.choice(NUMBERS))
    share = float(random.random())

    def spoil(model: Any) -> None:
        values = getattr(model, name).reshape(-1)
        places = np.flatnonzero(values)
        if len(places):
            values[places[int(share * len(places))]] *= factor

    engine = adapt("plugged", Plugged(spoil))
    for model in engine.models(case.scene):
        if (
            engine.bind(case, model).unsupported_reason(case, engine.methods[0])
            or engine.bind(case, model).has_constraints
        ):
            continue
        system = engine.bind(case, model).system(case)
        layout = system.layout
        change, v = random.uniform(-1, 1, (2, layout.size[1]))
        driving = [i for i, joint in enumerate(system.joints) if joint in DRIVING]
        for own in (layout.velocities[i] for i in driving):
            change[own], v[own] = 0.0, system.velocities[own]
        q = layout.displaced(system.positions, change)
        right, wrong = (Plugged(one).accelerations(system, 0.0, q, v) for one in (None, spoil))
        if np.max(np.abs(wrong - right) / (np.abs(right) + np.median(np.abs(right)))) > BLIND:
            what = f"{name} x {factor} ({share:.2f})"
            return Seeded(case, engine, what, ("parts", "algebra"), "plugged")
    return None


def judged(fault: Seeded, explain: bool = False) -> list[Result]:
    """Return what the checks up to a free run say, by the best method of each model."""
    results: list[Result] = []
    others = [one for one in get_scene(fault.case.scene).cases if "algebra" in one.kinds]
    for case in dict.fromkeys(one.name for one in (*others, fault.case)):
        there = replace(fault, case=get_scene(fault.case.scene).case(case))
        for kind in kinds_of(there.case):
            if kind not in (LOOKED_AT if case == fault.case.name else LOOKED_AT[:2]):
                continue
            for check in checks(kind, there):
                if not (check.full_only or check.unsupported_reason):
                    results += run_check(check, engine=fault.engine, explain=explain)
    return results


def checks(kind: str, fault: Seeded) -> list[Check]:
    """Return the checks of a kind; a plugged-in engine is known by its name meanwhile."""
    if fault.like in ENGINES:
        return list(checks_of(kind, fault.case, fault.like))
    registry._named[fault.engine.name] = fault.engine
    try:
        return list(checks_of(kind, fault.case, fault.engine.name))
    finally:
        del registry._named[fault.engine.name]


def level_of(results: list[Result]) -> str:
    """Return the first level that is wrong, empty if none is."""
    wrong = {item.kind for item in results if item.verdict in ("deviation", "error")}
    return next((name for name in KINDS if name in wrong), "")


if __name__ == "__main__":
    for number in range(int(sys.argv[1]), int(sys.argv[1]) + int(sys.argv[2])):
        fault = seeded(number, sys.argv[3:] or PLANE)
        results = judged(fault, explain=True)
        level = level_of(results)
        word = "MISSED" if not level else "named" if level in fault.levels else "ELSEWHERE"
        print(f"{number} {fault.case.scene}/{fault.case.name} {fault.what}: {word} {level}")
        for line in located(results)[:4]:
            print(f"    {line}", flush=True)
