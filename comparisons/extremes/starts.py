"""Starts that ask for trouble: at a dead centre, at rest on an unstable root, with an open loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import pi
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.rotor_pendulum.cases import CASE_2
from ...reference.rotor_pendulum.equations import operating_speed
from ...reference.rotor_pendulum.phase import coupling_harmonics
from ...reference.scene import Case
from ...reference.speed_regulator.cases import DEFAULT
from ...reference.speed_regulator.rest import equilibrium
from ..engines.registry import get_engine
from .judge import judge
from .parameters import MOST_STEPS, adapted_step, methods_of
from .row import Row
from .task import Task

SECTION = "starts"


@dataclass(frozen=True)
class Start:
    """One start of a case.

    Attributes
    ----------
    scene, name, case : str
    state : mapping of str to float
        Initial values in place of those of the case.
    horizon : float
        [s]
    changes : mapping
        Parameters that are changed.
    offset : mapping of str to float
        By how much the loop is open.
    models : tuple of str
        That are run where an engine has them, in place of its default.
    """

    scene: str
    name: str
    case: str
    state: Mapping[str, float]
    horizon: float
    changes: Mapping[str, Any] = field(default_factory=dict)
    offset: Mapping[str, float] = field(default_factory=dict)
    models: tuple[str, ...] = ()

    def started(self) -> Case:
        """Return the case with this start."""
        case = get_scene(self.scene).case(self.case)
        return replace(
            case,
            parameters=case.parameters.replace(**self.changes),
            state=self.state,
            inconsistency=self.offset,
        )


def unstable_phase() -> float:
    """Return the phase difference [rad] of the rotors that repels them, in case 2."""
    mean, first = coupling_harmonics(CASE_2)
    root = float(np.arccos(-mean / abs(first)))
    # where the coupling torque rises with the phase difference
    return float(-root - np.angle(first))


def rotors_at(phase: float) -> dict[str, float]:
    """Return rotors that turn together with a phase difference."""
    speed = float(operating_speed(CASE_2))
    return {"phi_1": phase, "phi_1_dot": speed, "phi_2_dot": speed}


LOOPS = ("connect", "connect_hard", "redundant")
hoop = partial(Start, "hula_hoop", case="point_mass_3hz_60n")
crank = partial(Start, "speed_regulator", case="rotation", models=("connect_hard", "redundant"))
opened = partial(Start, "speed_regulator", case="rotation", horizon=1.0, models=LOOPS)

STARTS = (
    hoop("rod_across_at_rest", state={}, horizon=1.0),
    hoop("rod_aligned_at_rest", state={"theta": pi / 2}, horizon=1.0),
    hoop("rod_aligned_at_rest_for_long", state={"theta": pi / 2}, horizon=6.0),
    hoop("rod_aligned_nudged", state={"theta": pi / 2 + 1e-6}, horizon=2.0),
    hoop("unforced_at_rest", state={}, horizon=1.0, changes={"force_amplitude": 0.0}),
    Start("rotor_pendulum", "at_rest", "case_2_startup", {}, 0.25),
    Start("rotor_pendulum", "unstable_phase", "case_2_startup", rotors_at(unstable_phase()), 0.5),
    crank("upper_dead_centre", state={"phi": pi / 2, "phi_dot": 5.07}, horizon=1.0),
    crank("lower_dead_centre", state={"phi": -pi / 2, "phi_dot": 5.07}, horizon=1.0),
    crank("upper_dead_centre_at_rest", state={"phi": pi / 2}, horizon=1.0),
    *(
        crank(f"rest_{name}", state=equilibrium(name, DEFAULT), horizon=4.0)
        for name in ("right", "top", "left", "bottom")
    ),
    crank("unstable_rest_for_long", state=equilibrium("top", DEFAULT), horizon=12.0),
    *(
        opened(f"open_by_{d:g}_m", state={"phi_dot": 5.07}, offset={"y": d})
        for d in (1e-6, 1e-3, 0.1)
    ),
    opened("open_by_a_rate", state={"phi_dot": 5.07}, offset={"y_dot": 0.1}),
    Start("hula_hoop", "open_by_0.001_m", "point_mass_3hz_60n", {}, 0.5, offset={"y": 1e-3}),
    Start("rotor_pendulum", "open_by_0.001_m", "case_2_startup", {}, 0.1, offset={"x": 1e-3}),
    Start("rotating_beam", "straight_in_rotation", "steady_4", {"theta_dot": 3.3}, 0.0625),
)


def begin(number: int, engine: str) -> list[Row]:
    """Return the rows of one of `STARTS` by one engine, by the best method of each model."""
    start, chosen = STARTS[number], get_engine(engine)
    case = start.started()
    known = chosen.models(start.scene)
    told = {**start.changes, **start.state, **{f"{k} off by": v for k, v in start.offset.items()}}
    rows = []
    for model in [m for m in start.models if m in known] or known[:1]:
        method = methods_of(chosen, case, model)[0]
        how = chosen, case, model, method
        if method is None:
            rows.append(judge(SECTION, start.name, *how, None, told))
            continue
        step = adapted_step(case, chosen, model, method)
        horizon = min(start.horizon, 4 * MOST_STEPS.get(method.order, 2048) * step)
        rows.append(judge(SECTION, start.name, *how, step, told, horizon=horizon))
    return rows


def tasks(scenes: tuple[str, ...], engines: tuple[str, ...], full: bool) -> list[Task]:
    """Return the tasks of this section."""
    return [
        Task(SECTION, start.scene, start.name, engine, partial(begin, number, engine))
        for number, start in enumerate(STARTS)
        for engine in engines
        if start.scene in scenes
    ]
