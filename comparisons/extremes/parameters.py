"""Parameters at their extremes, each at a step that suits them and at the one that is usual.

An extreme is data: what it changes of a scene, and in which motion. It runs by the best method of
each engine's default model, and by some that are implicit where the best is not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import pi
from typing import Any

from ...reference import get_scene
from ...reference.rotating_beam.parameters import steady_speed
from ...reference.rotating_beam.scene import critical_speed
from ...reference.rotor_pendulum.cases import AT_SPEED
from ...reference.scene import Case
from ..checks.suite import best_method
from ..engines.adapter import Adapter
from ..engines.protocol import Method
from ..engines.registry import get_engine
from ..engines.setup import Setup, shortest_period
from .judge import judge
from .row import Row
from .task import Task

SECTION = "parameters"

PERIODS = 4
"""Shortest periods that a run lasts."""

MOST_STEPS = {1: 8192, 2: 4096}
"""Most steps of a run, by order of the method, 2048 without; those of order 1 need many."""

USUAL_STEPS = 100
"""Usual steps that a run with the usual step lasts at least."""

MODERATE = {"y": 0.0, "theta": 0.3, "theta_dot": 18.0}
"""Rotation of the hula hoop with its spring relaxed, which suits any stiffness and length."""

EXTRA: Mapping[str, tuple[str, ...]] = {
    "mujoco": ("Euler",),
    "exudyn": ("GeneralizedAlpha",),
}
"""Methods that run beside the best."""


@dataclass(frozen=True)
class Extreme:
    """One extreme of a scene.

    Attributes
    ----------
    scene, name : str
    case : str
        Of the scene; what it has and the rest does not change.
    changes : mapping of parameter to value
        (SI)
    state : mapping of str to float, or None
        Initial values in place of those of the case.
    models : tuple of str
        That are run where an engine has them, in place of its default.
    horizon : float or None
        [s], `PERIODS` without it.
    full : bool
        Left out of the default set.
    """

    scene: str
    name: str
    case: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    state: Mapping[str, float] | None = None
    models: tuple[str, ...] = ()
    horizon: float | None = None
    full: bool = False

    def usual(self) -> Case:
        """Return the case that it starts from."""
        return get_scene(self.scene).case(self.case)

    def extreme(self) -> Case:
        """Return the case at the extreme."""
        case = self.usual()
        state = case.state if self.state is None else self.state
        return replace(case, parameters=case.parameters.replace(**self.changes), state=state)

    def told(self) -> dict[str, float | str]:
        """Return what it changes, initial values too."""
        return {**self.changes, **(self.state or {})}


hoop = partial(Extreme, "hula_hoop", case="spinning_unforced", state=MODERATE)
driven = partial(Extreme, "hula_hoop", case="spinning_3hz_60n")
rotors = partial(
    Extreme, "rotor_pendulum", case="case_2_startup", state={"phi_1": 1.06, **AT_SPEED}
)
crank = partial(Extreme, "speed_regulator", case="rotation")
beam = partial(Extreme, "rotating_beam", case="pulse_quick", horizon=1.0)

HULA_OMEGA = (1000 / 0.495) ** 0.5
ROTOR_MASS = 114.0
"""All that moves with the platform [kg]."""

LINE = 2766.7 * 7.2968e-5
"""Mass of the beam per length [kg/m]."""

SLENDER = 7.2968e-5 / 8.2189e-9
"""EA/EI of the beam [1/m^2]."""


def slender(ratio: float) -> dict[str, float]:
    """Return the modulus and the second moment that make EA/EI this [1/m^2] and keep EI."""
    factor = ratio / SLENDER
    return {"youngs_modulus": 6.8952e10 * factor, "second_moment": 8.2189e-9 / factor}


EXTREMES = (
    *(hoop(f"mass_ratio_{r:.0e}", changes={"free_mass": 0.45 * r}) for r in (1e-6, 1e-3, 1e3, 1e6)),
    *(driven(f"stiffness_{k:.0e}", changes={"stiffness": k}) for k in (1e6, 1e9, 1e12)),
    *(
        hoop(f"damping_{c:.0e}", changes={"damping_ratio": c / (2 * 0.495 * HULA_OMEGA)})
        for c in (1e3, 1e6, 1e9)
    ),
    hoop("hinge_damping_1e9", changes={"hinge_damping_ratio": 1e9 / (0.045 * 0.0025 * HULA_OMEGA)}),
    *(hoop(f"rod_length_{r:.0e}", changes={"rod_length": r}) for r in (1e-3, 1e-6, 1e-9)),
    hoop("speed_1e4", state={"theta_dot": 1e4}),
    driven("force_at_resonance", changes={"force_frequency": HULA_OMEGA / 2 / pi}),
    driven(
        "force_at_resonance_undamped",
        changes={"force_frequency": HULA_OMEGA / 2 / pi, "damping_ratio": 0.0},
    ),
    driven("soft_spring_at_resonance", changes={"stiffness": 0.495 * (6 * pi) ** 2}),
    *(
        rotors(f"mass_ratio_{r:.0e}", changes={"rotor_mass": 100 * r})
        for r in (1e-6, 1e-3, 1e3, 1e6)
    ),
    *(
        rotors(f"{part}_stiffness_{k:.0e}", changes={f"{part}_stiffness": k})
        for part in ("platform", "rod")
        for k in (1e9, 1e12)
    ),
    *(rotors(f"{p}_damping_1e9", changes={f"{p}_damping": 1e9}) for p in ("platform", "rod")),
    *(rotors(f"rod_length_{r:.0e}", changes={"rod_length": r}) for r in (1e-3, 1e-6, 1e-9)),
    rotors(
        "speed_1e4",
        changes={"synchronous_speed": 1e4},
        state={"phi_1": 1.06, "phi_1_dot": 1e4, "phi_2_dot": 1e4},
    ),
    rotors("platform_at_resonance", changes={"platform_stiffness": ROTOR_MASS * 153.8**2}),
    *(
        crank(f"slider_mass_ratio_{r:.0e}", changes={"slider_mass": 0.5 * r})
        for r in (1e-6, 1e-3, 1e3, 1e6)
    ),
    crank("rod_mass_ratio_1e-06", changes={"rod_mass": 1e-6}),
    *(crank(f"stiffness_{k:.0e}", changes={"stiffness": k}) for k in (1e6, 1e9, 1e12)),
    *(crank(f"damping_{c:.0e}", changes={"damping": c}) for c in (1e3, 1e6, 1e9)),
    crank(
        "rod_length_1e-09",
        changes={"crank_radius": 2e-10, "rod_length": 1e-9, "spring_rest": -1e-9},
    ),
    crank(
        "massless_rod_and_slider",
        changes={"rod_mass": 0.0, "slider_mass": 0.0},
        models=("connect", "connect_hard", "transmission", "redundant", "one_dof"),
    ),
    *(
        crank(
            f"lambda_1-{gap:.0e}",
            changes={"crank_radius": 1.25 * (1 - gap)},
            state={"phi": 1.0, "phi_dot": 5.07},
            horizon=1.0,
            models=("connect", "connect_hard", "redundant", "one_dof"),
        )
        for gap in (1e-1, 1e-3, 1e-9)
    ),
    crank("flywheel_1e6", changes={"flywheel_inertia": 1e6}),
    crank("speed_1e4", state={"phi_dot": 1e4}),
    crank("spring_at_resonance", changes={"stiffness": 5.07**2}),
    *(beam(f"slenderness_{r:.0e}", changes=slender(r)) for r in (1e6, 1e9)),
    beam("tip_mass_ratio_1e3", changes={"mass": 1e3 * 8 * LINE}),
    beam("nondimensional_speed_50", state={"theta_dot": steady_speed(50)}),
    beam("hub_inertia_1e6", changes={"hub_inertia": 1e6, "torque_amplitude": 2e6}),
    beam("flexible_1e-6", changes={"youngs_modulus": 6.8952e4}, full=True),
)
"""Of *mass ratio* to the main mass, the platform or the rod."""


def usual_step(extreme: Extreme, engine: Adapter, model: str, method: Method) -> float:
    """Return the step of the default parameters: what a user leaves."""
    case = extreme.usual()
    return Setup(engine, case, model, method).default_step


def adapted_step(case: Case, engine: Adapter, model: str, method: Method) -> float:
    """Return the step of the extreme parameters."""
    return Setup(engine, case, model, method).default_step


def methods_of(engine: Adapter, case: Case, model: str) -> list[Method | None]:
    """Return the best method, and those of `EXTRA` that run; None if there is none."""
    first = best_method(Setup(engine, case, model))
    names = () if get_scene(case.scene).discretisation_coordinates else EXTRA.get(engine.name, ())
    others = [m for m in engine.methods if m.name in names and m != first]
    return [first, *(m for m in others if engine.why_not(case, model, m) is None)]


def provoke(number: int, engine: str) -> list[Row]:
    """Return the rows of one extreme by one engine.

    Parameters
    ----------
    number : int
        Of `EXTREMES`.
    engine : str
    """
    extreme, chosen = EXTREMES[number], get_engine(engine)
    case = extreme.extreme()
    known = chosen.models(extreme.scene)
    rows = []
    for model in [m for m in extreme.models if m in known] or known[:1]:
        say = partial(judge, SECTION, engine=chosen, case=case, model=model, changed=extreme.told())
        for method in methods_of(chosen, case, model):
            if method is None:
                rows.append(say(extreme.name, method=None, step=None))
                continue
            adapted = adapted_step(case, chosen, model, method)
            usual = usual_step(extreme, chosen, model, method)
            horizon = extreme.horizon or PERIODS * shortest_period(case)
            most = MOST_STEPS.get(method.order, 2048)
            for kind, step, fewest in (("adapted", adapted, 0), ("kept", usual, USUAL_STEPS)):
                if kind == "kept" and usual == adapted:
                    continue
                longest = max(min(horizon, most * step), fewest * step)
                rows.append(
                    say(f"{extreme.name}, {kind} step", method=method, step=step, horizon=longest)
                )
    return rows


def without_coupling() -> list[Row]:
    """Return the row of the beam without the second-order coupling, beside the exact one.

    No engine leaves it out, so the reference's own variant stands for one that does.
    """
    engine = get_engine("reference")
    case = get_scene("rotating_beam").case("above_critical")
    speed = case.parameters.angular_speed
    return [
        judge(
            SECTION,
            "no_second_order_coupling",
            engine,
            case,
            "zero_order",
            engine.methods[0],
            2.0**-6,
            {"angular_speed": speed, "critical_speed": critical_speed(case.parameters)},
            horizon=2.0,
        )
    ]


def tasks(scenes: tuple[str, ...], engines: tuple[str, ...], full: bool) -> list[Task]:
    """Return the tasks of this section."""
    found = [
        Task(SECTION, extreme.scene, extreme.name, engine, partial(provoke, number, engine))
        for number, extreme in enumerate(EXTREMES)
        for engine in engines
        if extreme.scene in scenes and (full or not extreme.full)
    ]
    if "rotating_beam" in scenes:
        name = "no_second_order_coupling"
        found.append(Task(SECTION, "rotating_beam", name, "reference", without_coupling))
    return found
