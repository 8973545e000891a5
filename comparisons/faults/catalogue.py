"""The catalogue of faults: wrong engines by scene, each with the claims of the right one.

A fault is data: how a wrong engine of each name is made. Nothing here knows of checks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...models import exudyn_mjcf, exudyn_system
from ...models.mjcf import Binding
from ...models.speed_regulator import exudyn_model as slider_crank
from ...models.speed_regulator.exudyn_model import inertias
from ...reference.hula_hoop.equations import HulaHoop
from ...reference.rotor_pendulum import equations as rotors
from ...reference.rotor_pendulum.equations import RotorPendulum
from ...reference.speed_regulator import equations as regulator
from ...reference.speed_regulator.equations import SpeedRegulator
from . import exudyn, mujoco
from .reference import Impostor
from .runs import LateForce
from .variants import EXUDYN, MUJOCO, Law, Misread

ENGINES: Mapping[str, Callable[[], Any]] = {
    MUJOCO: mujoco.MujocoAdapter,
    EXUDYN: exudyn.ExudynAdapter,
}


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


def wrapped(how: Callable[..., Any], *rest: Any) -> Fault:
    """Return the fault of engines with something around them."""

    def made(make: Callable[[], Any]) -> Callable[[], Any]:
        return lambda: how(make(), *rest)

    return Fault({name: made(make) for name, make in ENGINES.items()})


def misread(change: Callable[[Any], Any]) -> Fault:
    """Return the fault of a model with other parameters."""
    return wrapped(Misread, change)


def scaled(name: str, factor: float = 1.001) -> Fault:
    """Return the fault of one wrong parameter, by 0.1 % by default."""
    return misread(lambda p: p.replace(**{name: factor * getattr(p, name)}))


def without(name: str) -> Fault:
    """Return the fault of one forgotten parameter."""
    return misread(lambda p: p.replace(**{name: 0.0}))


def pushed(law: Law) -> Fault:
    """Return the fault of a term too many or too few in the first equation."""
    return Fault(
        {
            MUJOCO: lambda: mujoco.MujocoAdapter(mujoco.PushedMujoco(law)),
            EXUDYN: lambda: exudyn.ExudynAdapter(exudyn.PushedExudyn(law)),
        }
    )


def rebound(bindings: Mapping[tuple[str, str], Binding], *built: Any, **changes: Any) -> Fault:
    """Return the fault of other values in the MJCF, or in a module of Exudyn models."""
    return Fault(
        {
            MUJOCO: lambda: mujoco.Rebound(bindings),
            EXUDYN: lambda: exudyn.ExudynAdapter(exudyn.ReboundExudyn(bindings, *built, **changes)),
        }
    )


def other_items(**kinds: Any) -> Callable[[], Any]:
    """Return the maker of an Exudyn whose models are built with other items of some kinds."""
    items = exudyn.OtherItems(**kinds)
    return lambda: exudyn.ExudynAdapter(exudyn.Rebuilt(exudyn_mjcf, items=items))


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
    """The missing force where J' has lost its factor 2."""
    c = regulator.coefficients(p)
    return float(regulator.inertia_slope(regulator.position(q[0], c), c) * v[0] ** 2 / 4)


def thick_inertias(p: SpeedRegulator) -> tuple[float, ...]:
    """Masses and moments of inertia of `one_dof` with the rod's times four."""
    *bodies, rod, across, along = inertias(p)
    return (*bodies, 4 * rod, across, along)


PIN = 1e4, 1e2
"""Stiffness [N/m] and damping [N s/m] of a spring in the place of a pin."""


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
        "gravity_along_the_slide": rebound({("option", "gravity"): lambda p: (0, -9.81, 0)}),
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
        "rod_inertia_about_its_end": rebound(
            {("body:rod/inertial", "diaginertia"): third}, slider_crank, inertias=thick_inertias
        ),
        "spring_rest_of_the_averages": misread(
            lambda p: p.replace(spring_rest=-p.crank_radius - p.rod_length)
        ),
        "soft_joint_passed_off_as_exact": Fault(
            {
                MUJOCO: mujoco.WithoutEquations,
                EXUDYN: other_items(ObjectJointRevolute2D=soft_pin),
            },
            models=("connect", "redundant"),
        ),
    },
}
"""Faults by scene and name."""


FLIPPED: Mapping[str, Callable[[], Any]] = {
    "connect": mujoco.FlippedMujoco,
    "redundant": lambda: exudyn.ExudynAdapter(exudyn.FlippedExudyn()),
}
"""Slider-cranks on the other assembly branch, by model."""
