"""`inspect`: what is in an MJCF file, how it moves, and what it could do without."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from ...reference.errors import UsageError
from ...reference.scene import Array
from ..documents import document
from ..engines.mujoco.library import quiet
from ..queries.environment import versions
from .findings import ModelFinding, findings
from .mujoco.closures import ClosedLoop, closures
from .mujoco.facts import facts, integrator
from .mujoco.linear import Linear, linearise
from .mujoco.model import ENGINE, Loaded, NotFiniteError, State, load
from .mujoco.steady import steady_rotation
from .spectrum import SCHEMES, Shape, Step, longest_step, shapes
from .subject import SEVERITIES, InspectedModel, StepLimit, View

MOST_DOFS = 120
"""With more degrees of freedom, modes are computed only if asked for."""

MOST_STATES = 8
"""States whose modes are computed."""

OSCILLATING = 1.0
"""Modes whose damping ratio is below this have a period to speak of."""


def state_views(
    loaded: Loaded, about_rotation: Mapping[str, float | str] | None, modes: bool | None
) -> tuple[View, ...]:
    """Return the states of a model with their modes; see `inspect`.

    Raises
    ------
    UsageError
        If there is no such rotation.
    """
    reasons = [why_no_modes(loaded, state, modes) for state in loaded.states[:MOST_STATES]]
    reasons += [f"modes are found of the first {MOST_STATES} states"] * len(loaded.states)
    views = [
        view(loaded, state) if reason is None else View(state, reason=reason)
        for state, reason in zip(loaded.states, reasons, strict=False)
    ]
    if about_rotation and len(about_rotation) > 1:
        raise UsageError("one hinge can turn steadily, not several")
    views += [
        view(loaded, steady_rotation(loaded, joint, speed), joint)
        for joint, speed in (about_rotation or {}).items()
    ]
    return tuple(views)


def view(loaded: Loaded, state: State, steady_hinge: str | None = None) -> View:
    """Return a state with its modes, or why it has none."""
    try:
        linear = linearise(loaded, state)
    except NotFiniteError as error:
        return View(state, reason=str(error), failed=True)
    except np.linalg.LinAlgError as error:
        return View(state, reason=f"the mass matrix cannot be solved with ({error})", failed=True)
    if linear.closed and np.any(state.velocity):
        return View(state, reason="closed loops move: their small motions are not constant")
    moves = (state.velocity == 0) | (steady_hinge is None)  # a steady hinge keeps its speed
    moving = np.eye(loaded.model.nv)[:, moves]
    free = linear.free if steady_hinge is None else moving
    modes = modes_within(free, linear.mass, linear.damping, linear.stiffness)
    mass, damping, stiffness, *_ = next(iter(linear.simulated.values()))
    soft = linear.rows or linear.closed
    simulated = modes_within(moving, mass, damping, stiffness) if soft else modes
    return View(state, linear, modes, simulated, steady_hinge=steady_hinge)


def why_no_modes(loaded: Loaded, state: State, wanted: bool | None) -> str | None:
    """Return why modes of a state are not computed, if they are not."""
    nv, ball = loaded.model.nv, loaded.of_kind("jnt_type", "free", "ball")
    if nv == 0:
        return "nothing can move"
    if wanted is False:
        return "not asked for"
    if wanted is None and nv > MOST_DOFS:
        return f"{nv} degrees of freedom (--modes finds them)"
    if loaded.model.nflex and nv > MOST_DOFS:
        return "a flex of that many degrees of freedom"
    ends = np.append(loaded.model.jnt_dofadr, nv)[1:][ball]
    if any(np.any(state.velocity[end - 3 : end]) for end in ends):
        return "a ball or free joint turns: its small motions are not constant"
    return None


def modes_within(
    directions: Array, mass: Array, damping: Array, stiffness: Array
) -> tuple[Shape, ...]:
    """Return the modes of motions that are sums of directions (n, k)."""
    inner = (directions.T @ matrix @ directions for matrix in (mass, damping, stiffness))
    return tuple(mode._replace(vector=directions @ mode.vector) for mode in shapes(*inner))


def step_limits(loaded: Loaded, views: Sequence[View]) -> tuple[StepLimit, ...]:
    """Return the largest stable step of each integrator, and where it is least."""
    states = [(one, one.linear) for one in views if one.linear is not None]
    limits, known = [], dict[tuple[object, ...], Step]()
    for name in states[0][1].simulated if states else ():
        if not hasattr(loaded.mujoco.mjtIntegrator, f"mjINT_{name.upper()}"):
            continue
        steps = []
        for one, linear in states:
            motion = linear.simulated[name]
            key = (SCHEMES[name], id(one), *(part.tobytes() for part in motion[3:]))
            if key not in known:
                known[key] = longest_step(name, motion, one.simulated)
            steps.append((known[key], one))
        least, where = min(steps, key=lambda item: item[0].limit)
        limits.append(
            StepLimit(
                integrator=name,
                limit=least.limit,
                state=where.state.name if math.isfinite(least.limit) else None,
                omega=least.omega,
                joint=None if least.place is None else loaded.joint_names[least.place],
                of_file=name == integrator(loaded),
            )
        )
    return tuple(limits)


def shortest_period(views: Sequence[View]) -> float | None:
    """Return the shortest period of all modes as simulated [s]; None if nothing oscillates."""
    rates = [
        mode.rate.imag
        for one in views
        for mode in one.simulated
        if mode.rate.imag > 0 and (mode.damping_ratio or 0.0) < OSCILLATING
    ]
    return 2 * math.pi / max(rates) if rates else None


def all_closures(loaded: Loaded) -> tuple[ClosedLoop, ...]:
    """Return the closures in all states, stiffest first, those that open most before others."""
    every: list[ClosedLoop] = []
    for state in loaded.states[:MOST_STATES]:
        with suppress(NotFiniteError, np.linalg.LinAlgError):
            every += closures(loaded, state)
    return tuple(sorted(every, key=lambda one: (-one.omega, -one.opening)))


@dataclass(frozen=True)
class Inspection(InspectedModel):
    """What is found about a file: all that rules look at, and what they say.

    Attributes
    ----------
    file : str
        As it was given.
    files : tuple of str
        It, and what it includes.
    findings : tuple of Finding
    untried : str or None
        Why some attributes were not tried for `repeated_default`, if any were not.
    versions : mapping of str to str
    """

    file: str
    files: tuple[str, ...]
    findings: tuple[ModelFinding, ...]
    untried: str | None
    versions: Mapping[str, str]

    @property
    def unwaived(self) -> tuple[ModelFinding, ...]:
        """Findings that the file does not waive."""
        return tuple(one for one in self.findings if one.waived is None)

    @property
    def summary(self) -> dict[str, int]:
        """Number of unwaived findings by severity, and of waived ones."""
        counts: dict[str, int] = {
            name: sum(one.severity == name for one in self.unwaived) for name in SEVERITIES
        }
        return counts | {"waived": len(self.findings) - len(self.unwaived)}

    @property
    def exit_code(self) -> int:
        """1 if an error is not waived, else 0."""
        return 1 if self.summary["error"] else 0

    def place(self, mode: Shape, linear: Linear) -> str:
        """Return the joint that moves most in a mode."""
        return self.loaded.joint_names[mode.place(linear.mass)]

    def as_json(self) -> dict[str, Any]:
        """Return the ``inspect`` document of docs/json.md."""
        facts, step = self.facts, self.facts.options.timestep
        return document(
            "inspect",
            facts,
            file=self.file,
            files=self.files,
            summary=self.summary,
            states=[self.state_document(view) for view in self.views],
            steps=[
                {**vars(one), "chosen": one.of_file, "ratio": one.share_of(step)}
                for one in self.steps
            ],
            shortest_period=self.shortest_period,
            closures=self.closures,
            findings=self.findings,
            untried=self.untried,
            versions=self.versions,
        )

    def state_document(self, view: View) -> dict[str, Any]:
        """Return a state with its modes, as JSON."""
        linear = view.linear
        return {
            "names": view.state.keys,
            "position": view.state.position,
            "velocity": view.state.velocity,
            "held": view.steady_hinge,
            "reason": view.reason,
            "acceleration": linear and float(np.max(np.abs(linear.acceleration), initial=0.0)),
            "closed": linear and linear.closed,
            "contacts": linear and linear.contacts,
            "limits": linear and linear.limits,
            "modes": [self.mode_document(mode, linear) for mode in view.modes if linear],
            "simulated": [self.mode_document(mode, linear) for mode in view.simulated if linear],
        }

    def mode_document(self, mode: Shape, linear: Linear) -> dict[str, Any]:
        """Return a mode, as JSON."""
        return {
            "kind": mode.kind,
            "re": mode.rate.real,
            "im": mode.rate.imag,
            "omega": mode.omega,
            "hertz": mode.omega / (2 * math.pi),
            "damping_ratio": mode.damping_ratio,
            "joint": self.place(mode, linear),
        }


def inspect(
    path: str | Path,
    about_rotation: Mapping[str, float | str] | None = None,
    modes: bool | None = None,
) -> Inspection:
    """Inspect an MJCF file.

    Parameters
    ----------
    path : str or Path
    about_rotation : mapping of str to float, optional
        One hinge and its speed [rad/s]: modes about the steady rotation, beside those of the
        file's states.
    modes : bool, optional
        Whether to find modes; by default up to `MOST_DOFS` degrees of freedom.

    Raises
    ------
    UsageError
        If the file cannot be read, is no MJCF or does not compile, or if there is no such
        rotation.
    EngineUnavailableError
        If MuJoCo cannot be imported.
    """
    loaded = load(path)
    with quiet(loaded.mujoco):
        subject = subject_of(loaded, about_rotation, modes)
        results, untried = findings(subject)
    return Inspection(
        **{item.name: getattr(subject, item.name) for item in fields(subject)},
        file=str(path),
        files=loaded.source.files,
        findings=results,
        untried=untried,
        versions={**versions(()), ENGINE: str(loaded.mujoco.__version__)},
    )


def subject_of(
    loaded: Loaded,
    about_rotation: Mapping[str, float | str] | None = None,
    modes: bool | None = None,
) -> InspectedModel:
    """Return a model with all that rules look at; see `inspect`."""
    views = state_views(loaded, about_rotation, modes)
    return InspectedModel(
        loaded=loaded,
        facts=facts(loaded),
        views=views,
        steps=step_limits(loaded, views),
        shortest_period=shortest_period(views),
        closures=all_closures(loaded),
    )
