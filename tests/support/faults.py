"""Engines that are wrong on purpose: what the checks must catch.

A fault is data: how a wrong engine of each name is made. It has the claims of the right one:
what it says of its model is right, what it computes is not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType
from typing import Any
from unittest.mock import patch

import numpy as np

from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.mujoco.engine import MuJoCo
from mbcheck.comparisons.engines.protocol import Method, System
from mbcheck.comparisons.engines.reference import ReferenceEngine
from mbcheck.comparisons.engines.run import VIOLATIONS, Trajectory, grid_indices
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Misread, Wrapped
from mbcheck.comparisons.engines.variants.exudyn import ExudynAdapter
from mbcheck.comparisons.engines.variants.mujoco import MujocoAdapter, WithoutEquations
from mbcheck.models import exudyn_system, mjcf
from mbcheck.models.hula_hoop import exudyn_model as hoop
from mbcheck.models.speed_regulator import exudyn_model as slider_crank
from mbcheck.models.speed_regulator.exudyn_model import inertias
from mbcheck.reference import get_scene
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.rotor_pendulum import equations as rotors
from mbcheck.reference.rotor_pendulum.equations import RotorPendulum
from mbcheck.reference.scene import Array, Case, EquationsOfMotion
from mbcheck.reference.solve import schemes
from mbcheck.reference.speed_regulator import equations as regulator
from mbcheck.reference.speed_regulator.equations import SpeedRegulator

ENGINES: Mapping[str, Callable[[], Any]] = {"mujoco": MujocoAdapter, "exudyn": ExudynAdapter}


@dataclass(frozen=True)
class Fault:
    """How wrong engines are made.

    Attributes
    ----------
    make : mapping of engine name to ``() -> Engine``
    models : tuple of str
        Models that can have the fault; empty: all.
    """

    make: Mapping[str, Callable[[], Any]]
    models: tuple[str, ...] = ()


# Ways to be wrong ---------------------------------------------------------------------------


class LateForce(Wrapped):
    """An engine that evaluates the force one step late."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate with the force of a step before."""
        earlier = replace(case, start_time=case.start_time - step)
        found = self.engine.simulate(earlier, model, method, step, times - step)
        return replace(found, times=times, clock=times)


class Resetting(Wrapped):
    """An engine that sets itself to zero half-way without a word, and stays there."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate the first half."""
        before = max(1, len(times) // 2)
        found = self.engine.simulate(case, model, method, step, times[:before])
        scene = get_scene(case.scene)
        zero = scene.observe(np.zeros(len(scene.state_names)), case.parameters)
        values = {
            name: np.append(rows, np.full(len(times) - before, zero.get(name, 0.0)))
            for name, rows in found.values.items()
        }
        steps = round((times[-1] - case.start_time) / step)
        return replace(found, times=times, values=values, clock=times, steps=steps)


class Impostor(ReferenceEngine):
    """Equations of motion that pass for an engine, integrated as its methods would.

    With the scene's own equations it passes every check.
    """

    def __init__(
        self, engine: Adapter, change: Callable[[EquationsOfMotion], EquationsOfMotion]
    ) -> None:
        super().__init__()
        self.engine = engine
        self.change = change

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def equations(self, case: Case, model: str) -> EquationsOfMotion:
        """Return the equations that are solved."""
        return self.change(get_scene(case.scene))

    def model_equations(self, case: Case, model: str) -> None:
        """Return that it claims the scene's own equations."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate with the method's scheme, or without error where it has none."""
        scheme = Setup(self.engine, case, model, method).scheme
        if scheme:
            scene, p = self.equations(case, model), case.parameters
            numbers = grid_indices(times, case.start_time, step)
            start = scene.state(case.state)
            states = schemes.integrate(
                schemes.ScalarEquations(scene, p), scheme, start, step, numbers, case.start_time
            )
            found = Trajectory(times, scene.observe(states, p), times, int(numbers[-1]))
        else:
            found = super().simulate(case, model, method, step, times)
        closed = dict.fromkeys(VIOLATIONS, np.zeros(len(times)))
        return replace(found, values={**found.values, **closed})


Law = Callable[[Any, Any, Any], float]
"""(q, v, parameters) -> generalised force on the scene's first coordinate."""


class PushedMujoco(MuJoCo):
    """MuJoCo with one more force on the first coordinate, which is its first joint.

    The force hangs on MuJoCo's hook for passive forces, which is one for all models and must see
    none being compiled.
    """

    def __init__(self, law: Law) -> None:
        super().__init__()
        self.law = law

    def load(self, system: System) -> Any:
        """Return the compiled model of a system."""
        hook = self.mujoco.get_mjcb_passive()
        self.mujoco.set_mjcb_passive(None)
        try:
            return super().load(system)
        finally:
            self.mujoco.set_mjcb_passive(hook)

    @contextmanager
    def opened(self, system: System) -> Iterator[None]:
        """Let the force act meanwhile."""
        source = mjcf.models(system.case.scene)[system.model]
        coordinates = get_scene(system.case.scene).coordinates
        sums = [source.readout.get(name, {name: 1.0}) for name in coordinates]

        def push(compiled: Any, data: Any) -> None:
            q, v = (
                [sum(f * getattr(data.joint(j), what)[0] for j, f in s.items()) for s in sums]
                for what in ("qpos", "qvel")
            )
            data.qfrc_passive[0] += self.law(q, v, system.case.parameters)

        with super().opened(system):
            self.mujoco.set_mjcb_passive(push)
            try:
                yield
            finally:
                self.mujoco.set_mjcb_passive(None)


class PushedExudyn(ExudynAdapter):
    """Exudyn with one more load on the first coordinate, which is its first too."""

    def __init__(self, law: Law) -> None:
        super().__init__()
        self.law = law

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case, with the load."""
        system = super().system(case, model)
        mbs, items = system.mbs, exudyn_system.items

        def push(mbs: Any, time: float, load: float) -> float:
            data = mbs.systemData
            q, v = (
                system.readout @ np.array(values)
                for values in (data.GetODE2Coordinates(), data.GetODE2Coordinates_t())
            )
            return float(self.law(q, v, case.parameters))

        first = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=0, coordinate=0))
        mbs.AddLoad(items.LoadCoordinate(markerNumber=first, load=1.0, loadUserFunction=push))
        mbs.Assemble()
        return system


class ReboundMujoco(MujocoAdapter):
    """MuJoCo with other values in the MJCF."""

    def __init__(self, bindings: Mapping[tuple[str, str], mjcf.Binding]) -> None:
        super().__init__()
        self.bindings = bindings

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the model with those values."""
        found = super().source(case, model)
        return replace(found, bindings={**found.bindings, **self.bindings})


class Edited(MujocoAdapter):
    """MuJoCo with a model that was tampered with."""

    def __init__(self, old: str, new: str) -> None:
        super().__init__()
        self.edit = old, new

    def text(self, case: Case, model: str) -> str:
        """Return the MJCF with a text that stands there once replaced."""
        text = super().text(case, model)
        assert text.count(self.edit[0]) == 1
        return text.replace(*self.edit)


class RebuiltExudyn(ExudynAdapter):
    """Exudyn with other functions or other items in a scene's ``exudyn_model`` module."""

    def __init__(self, module: ModuleType, **changes: Any) -> None:
        super().__init__()
        self.patched = partial(patch.multiple, module, **changes)

    def system(self, case: Case, model: str) -> Any:
        """Return the system that is built with them."""
        with self.patched():
            return super().system(case, model)


class OtherItems:
    """Exudyn's items, some of them exchanged."""

    def __init__(self, **items: Any) -> None:
        self.__dict__.update(items)

    def __getattr__(self, name: str) -> Any:
        return getattr(exudyn_system.items, name)


class FlippedMujoco(MujocoAdapter):
    """MuJoCo with the slider-crank put together the other way round, the slider on top."""

    def motion(self, case: Case, model: str, time: float, state: Array) -> mjcf.Motion:
        """Return the motion of the joints with the rod mirrored at the height of the pin."""
        found = dict(super().motion(case, model, time, state))
        if not case.name:  # as the file opens, which is right
            return found
        (phi, speed), (pin, turn), (y, rate) = (found[n] for n in ("phi", "pin_angle", "y"))
        r = case.parameters.crank_radius
        found["pin_angle"] = np.pi - pin - 2 * phi, -turn - 2 * speed
        found["y"] = 2 * r * np.sin(phi) - y, 2 * r * np.cos(phi) * speed - rate
        return found


class FlippedExudyn(ExudynAdapter):
    """The same of Exudyn's bodies."""

    def system(self, case: Case, model: str) -> Any:
        """Return a system that is placed so."""
        system = super().system(case, model)
        r = case.parameters.crank_radius

        def place(q: Array, v: Array) -> tuple[Array, Array]:
            places, rates = (np.array(values) for values in system.place(q, v))
            pin, climb = r * np.sin(q[0]), r * np.cos(q[0]) * v[0]
            places[[2, 3, 5]] = 2 * pin - places[2], np.pi - places[3], 2 * pin - places[5]
            rates[[2, 3, 5]] = 2 * climb - rates[2], -rates[3], 2 * climb - rates[5]
            return places, rates

        return replace(system, place=place)


# The faults ---------------------------------------------------------------------------------


def wrapped(how: Callable[..., Any], *rest: Any) -> Fault:
    """Return the fault of engines with something around them."""

    def made(make: Callable[[], Any]) -> Callable[[], Any]:
        return lambda: how(make(), *rest)

    return Fault({name: made(make) for name, make in ENGINES.items()})


def misread(change: Callable[[Any], Any]) -> Fault:
    """Return the fault of a model with other parameters."""
    return wrapped(Misread, change)


def scaled(name: str, factor: float = 1.001) -> Fault:
    """Return the fault of one parameter that is off, by 0.1 % unless told."""
    return misread(lambda p: p.replace(**{name: factor * getattr(p, name)}))


def without(name: str) -> Fault:
    """Return the fault of one parameter that is forgotten."""
    return misread(lambda p: p.replace(**{name: 0.0}))


def pushed(law: Law) -> Fault:
    """Return the fault of a term too many or too few in the first equation."""
    return Fault(
        {"mujoco": lambda: MujocoAdapter(PushedMujoco(law)), "exudyn": lambda: PushedExudyn(law)}
    )


def stiffer(p: HulaHoop) -> HulaHoop:
    """Spring +0.1 %, the dampers as they were."""
    ratio = 1.001**0.5
    return p.replace(
        stiffness=1.001 * p.stiffness,
        damping_ratio=p.damping_ratio / ratio,
        hinge_damping_ratio=p.hinge_damping_ratio / ratio,
    )


def other_motor(p: RotorPendulum) -> RotorPendulum:
    """Motor 2 on its angle to the rod in place of the absolute one, or the other way round."""
    first, second = rotors.PLACEMENTS
    return p.replace(motor_placement=second if p.motor_placement == first else first)


def centrifugal(q: Any, v: Any, p: RotorPendulum) -> float:
    """The rod's centrifugal force along x, with its sign turned."""
    end = (p.rotor_mass + p.rod_mass) * p.rod_length
    return float(-end * np.cos(p.installation_angle + q[3]) * v[3] ** 2)


def half_slope(q: Any, v: Any, p: SpeedRegulator) -> float:
    """What is missing where J' has lost its factor 2."""
    c = regulator.coefficients(p)
    return float(regulator.inertia_slope(regulator.position(q[0], c), c) * v[0] ** 2 / 4)


def heavy_tree(**settings: Any) -> Any:
    """Return a kinematic tree with gravity along y."""
    return exudyn_system.items.ObjectKinematicTree(**settings | {"gravity": [0, -9.81, 0]})


def thick_rod(mass: float, inertia: float, nodeNumber: Any) -> Any:
    """Return a plane body of four times the moment of inertia."""
    return exudyn_system.items.ObjectRigidBody2D(
        mass=mass, inertia=4 * inertia, nodeNumber=nodeNumber
    )


def thick_inertias(p: SpeedRegulator) -> tuple[float, ...]:
    """Masses and moments of inertia of `one_dof` with the rod's times four."""
    *bodies, rod, across, along = inertias(p)
    return (*bodies, 4 * rod, across, along)


PIN = 1e4, 1e2
"""Stiffness [N/m] and damping [N s/m] of a pin that is no joint."""


def soft_pin(markerNumbers: Any) -> Any:
    """Return a stiff spring and damper for a joint."""
    (stiffness, damping) = PIN
    return exudyn_system.items.ObjectConnectorCartesianSpringDamper(
        markerNumbers=markerNumbers, stiffness=[stiffness] * 2 + [0], damping=[damping] * 2 + [0]
    )


def third(p: SpeedRegulator) -> tuple[float, float, float]:
    """Return m_b l^2 / 3, the rod's moment of inertia about its end."""
    return (p.rod_mass * p.rod_length**2 / 3,) * 3


FAULTS: Mapping[str, Mapping[str, Fault]] = {
    "hula_hoop": {
        "free_mass_0.1_percent": scaled("free_mass"),
        "rod_length_0.1_percent": scaled("rod_length"),
        "spring_0.1_percent": misread(stiffer),
        "no_hinge_damping": without("hinge_damping_ratio"),
        "force_late_by_one_step": wrapped(LateForce),
        "gravity_along_the_slide": Fault(
            {
                "mujoco": lambda: ReboundMujoco({("option", "gravity"): lambda p: (0, -9.81, 0)}),
                "exudyn": lambda: RebuiltExudyn(
                    hoop, items=OtherItems(ObjectKinematicTree=heavy_tree)
                ),
            }
        ),
    },
    "rotor_pendulum": {
        "rotor_mass_0.1_percent": scaled("rotor_mass"),
        "eccentricity_0.1_percent": scaled("eccentricity"),
        "rod_length_0.1_percent": scaled("rod_length"),
        "platform_stiffness_0.1_percent": scaled("platform_stiffness"),
        "no_rod_damping": without("rod_damping"),
        "no_friction": without("friction"),
        "motor_on_the_other_angle": misread(other_motor),
        "reduced_equations": wrapped(Impostor, lambda scene: scene.variants["reduced"]),
        "no_centrifugal_force_of_the_rod": pushed(centrifugal),
    },
    "speed_regulator": {
        "rod_mass_0.1_percent": scaled("rod_mass"),
        "crank_radius_0.1_percent": scaled("crank_radius"),
        "rod_length_0.1_percent": scaled("rod_length"),
        "stiffness_0.1_percent": scaled("stiffness"),
        "no_damping": without("damping"),
        "factor_2_lost_in_the_slope_of_inertia": pushed(half_slope),
        "rod_inertia_about_its_end": Fault(
            {
                "mujoco": lambda: ReboundMujoco({("body:rod/inertial", "diaginertia"): third}),
                "exudyn": lambda: RebuiltExudyn(
                    slider_crank,
                    items=OtherItems(ObjectRigidBody2D=thick_rod),
                    inertias=thick_inertias,
                ),
            }
        ),
        "spring_rest_of_the_averages": misread(
            lambda p: p.replace(spring_rest=-p.crank_radius - p.rod_length)
        ),
        "soft_joint_passed_off_as_exact": Fault(
            {
                "mujoco": WithoutEquations,
                "exudyn": lambda: RebuiltExudyn(
                    slider_crank, items=OtherItems(ObjectJointRevolute2D=soft_pin)
                ),
            },
            models=("connect", "redundant"),
        ),
    },
}
"""By scene and name."""

FLIPPED: Mapping[str, Callable[[], Any]] = {
    "connect": FlippedMujoco,
    "redundant": FlippedExudyn,
}
"""Slider-cranks put together the other way round, by model."""
