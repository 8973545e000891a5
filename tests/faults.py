"""Engines that are wrong on purpose: what the checks must catch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from mbcheck.comparisons.engine import Engine, Method, Trajectory
from mbcheck.comparisons.exudyn_engine import ExudynEngine
from mbcheck.comparisons.mujoco_engine import MujocoEngine
from mbcheck.reference.hula_hoop import HulaHoop
from mbcheck.reference.scene import Array, Case


class Misread:
    """An engine whose model has other parameters than the case."""

    def __init__(self, engine: Engine, change: Callable[[HulaHoop], HulaHoop]) -> None:
        self.engine = engine
        self.change = change

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def _wrong(self, case: Case) -> Case:
        return replace(case, parameters=self.change(case.parameters))

    def simulate(self, case: Case, *rest: Any) -> Trajectory:
        return self.engine.simulate(self._wrong(case), *rest)

    def accelerations(self, case: Case, *rest: Any) -> Array:
        return self.engine.accelerations(self._wrong(case), *rest)

    def mass_matrices(self, case: Case, *rest: Any) -> Array:
        return self.engine.mass_matrices(self._wrong(case), *rest)

    def linearise(self, case: Case, *rest: Any) -> tuple[Array, Array, Array]:
        return self.engine.linearise(self._wrong(case), *rest)


class LateForce:
    """An engine that evaluates the force one step late."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        earlier = replace(case, start_time=case.start_time - step)
        found = self.engine.simulate(earlier, model, method, step, times - step)
        return replace(found, times=times, clock=times)


class HeavyMujoco(MujocoEngine):
    """MuJoCo with gravity along the slide."""

    def text(self, case: Case, model: str) -> str:
        return super().text(case, model).replace('gravity="0 0 0"', 'gravity="0 -9.81 0"')


class HeavyExudyn(ExudynEngine):
    """Exudyn's kinematic tree with gravity along the slide."""

    def system(self, case: Case, model: str) -> Any:
        system = super().system(case, model)
        system.mbs.SetObjectParameter(0, "gravity", [0, -9.81, 0])
        return system


def stiffer(p: HulaHoop) -> HulaHoop:
    """Spring +0.1 %, the dampers as they were."""
    ratio = 1.001**0.5
    return p.replace(
        stiffness=1.001 * p.stiffness,
        damping_ratio=p.damping_ratio / ratio,
        hinge_damping_ratio=p.hinge_damping_ratio / ratio,
    )


MISREAD: Mapping[str, Callable[[HulaHoop], HulaHoop]] = {
    "free_mass_0.1_percent": lambda p: p.replace(free_mass=1.001 * p.free_mass),
    "rod_length_0.1_percent": lambda p: p.replace(rod_length=1.001 * p.rod_length),
    "spring_0.1_percent": stiffer,
    "no_hinge_damping": lambda p: p.replace(hinge_damping_ratio=0.0),
}

ENGINES: Mapping[str, type[Any]] = {"mujoco": MujocoEngine, "exudyn": ExudynEngine}
HEAVY: Mapping[str, type[Any]] = {"mujoco": HeavyMujoco, "exudyn": HeavyExudyn}
FAULTS = (*MISREAD, "force_late_by_one_step", "gravity_along_the_slide")


def faulty(engine: str, fault: str) -> Any:
    """Return the engine of this name with one of the `FAULTS`."""
    if fault in MISREAD:
        return Misread(ENGINES[engine](), MISREAD[fault])
    if fault == "force_late_by_one_step":
        return LateForce(ENGINES[engine]())
    return HEAVY[engine]()
