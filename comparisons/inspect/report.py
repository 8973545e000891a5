"""`inspect`: what is in an MJCF file, how it moves, and what it could do without."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...reference.errors import UsageError
from ..engines.mujoco import quiet
from ..queries.api import json_value, versions
from ..reports.report import SCHEMA
from .findings.findings import Finding, findings
from .mujoco.mujoco_closures import Closure, closures
from .mujoco.mujoco_facts import Facts, facts, integrator
from .mujoco.mujoco_linear import Linear, linearise, steady_rotation
from .mujoco.mujoco_model import Loaded, NotFiniteError, State, load
from .spectrum import SCHEMES, Motion, Shape, Step, longest_step, shapes
from .subject import StepLimit, Subject, View

MOST_DOFS = 120
"""With more degrees of freedom, modes are found only if asked for."""

MOST_STATES = 8
"""States whose modes are found."""

SETTLING = 1.0
"""Modes whose damping ratio is below this have a period to speak of."""

REST = 1e-6
"""Largest acceleration [rad/s^2, m/s^2] of what is called at rest."""


@dataclass(frozen=True)
class Inspection:
    """What was found about a file.

    Attributes
    ----------
    file : str
        As it was given.
    files : tuple of str
        It, and what it includes.
    facts : Facts
    views : tuple of View
        States with their modes.
    steps : tuple of StepLimit
        Of each integrator; empty without modes.
    shortest_period : float or None
        Of an oscillation as simulated [s].
    closures : tuple of Closure
        Stiffest first.
    findings : tuple of Finding
    untried : str or None
        Why some attributes were not tried for `repeated_default`, if any were not.
    versions : mapping of str to str
    """

    file: str
    files: tuple[str, ...]
    facts: Facts
    views: tuple[View, ...]
    steps: tuple[StepLimit, ...]
    shortest_period: float | None
    closures: tuple[Closure, ...]
    findings: tuple[Finding, ...]
    untried: str | None
    versions: Mapping[str, str]
    joints: tuple[str, ...]
    """Of each degree of freedom."""

    @property
    def unwaived(self) -> tuple[Finding, ...]:
        """Findings that the file does not waive."""
        return tuple(one for one in self.findings if one.waived is None)

    @property
    def summary(self) -> dict[str, int]:
        """Number of unwaived findings by severity, and of waived ones."""
        counts = {
            name: sum(one.severity == name for one in self.unwaived)
            for name in ("error", "warning", "note")
        }
        return {**counts, "waived": len(self.findings) - len(self.unwaived)}

    @property
    def exit_code(self) -> int:
        """1 if an error is not waived, else 0."""
        return 1 if self.summary["error"] else 0

    def place(self, mode: Shape, linear: Linear) -> str:
        """Return the joint that moves most in a mode."""
        return self.joints[mode.place(linear.mass)]

    def as_json(self) -> dict[str, Any]:
        """Return the ``inspect`` document of docs/json.md."""
        found: dict[str, Any] = json_value(
            {
                "schema": SCHEMA,
                "file": self.file,
                "files": self.files,
                "name": self.facts.name,
                "summary": self.summary,
                "options": vars(self.facts.options),
                "counts": self.facts.counts,
                "mass": self.facts.mass,
                "size": self.facts.size,
                "bodies": [
                    {**vars(body), "joints": [vars(joint) for joint in body.joints]}
                    for body in self.facts.bodies
                ],
                "states": [self.state_document(view) for view in self.views],
                "steps": [
                    {**vars(one), "ratio": ratio(self.facts.options.timestep, one.limit)}
                    for one in self.steps
                ],
                "shortest_period": self.shortest_period,
                "closures": [
                    {name: value for name, value in vars(one).items() if name != "number"}
                    for one in self.closures
                ],
                "findings": [vars(one) for one in self.findings],
                "untried": self.untried,
                "versions": self.versions,
            }
        )
        return found

    def state_document(self, view: View) -> dict[str, Any]:
        """Return a state with its modes, as JSON."""
        linear = view.linear
        return {
            "names": view.state.keys,
            "position": view.state.position,
            "velocity": view.state.velocity,
            "held": view.held,
            "reason": view.reason,
            "acceleration": None if linear is None else largest(linear.acceleration),
            "closed": None if linear is None else linear.closed,
            "contacts": None if linear is None else linear.contacts,
            "limits": None if linear is None else linear.limits,
            "modes": [] if linear is None else [self.mode(m, linear) for m in view.modes],
            "simulated": [] if linear is None else [self.mode(m, linear) for m in view.simulated],
        }

    def mode(self, mode: Shape, linear: Linear) -> dict[str, Any]:
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


def ratio(step: float, limit: float) -> float:
    """Return by what share of its limit a step is long; 0 if nothing limits it."""
    return step / limit if limit > 0 else math.inf


def largest(values: np.ndarray) -> float:
    """Return the largest modulus; 0 of none."""
    return float(np.max(np.abs(values), initial=0.0))


def inspect(
    path: str | Path,
    about_rotation: Mapping[str, float] | None = None,
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
        return inspected(loaded, str(path), about_rotation, modes)


def inspected(
    loaded: Loaded, file: str, about_rotation: Mapping[str, float] | None, modes: bool | None
) -> Inspection:
    """Return what is found about a model; see `inspect`."""
    views = [view(loaded, state, modes) for state in loaded.states[:MOST_STATES]]
    views += [
        View(state, reason=f"modes are found of the first {MOST_STATES} states")
        for state in loaded.states[MOST_STATES:]
    ]
    turning = rotation(loaded, about_rotation)
    if turning is not None:
        views.append(turning)
    limits = steps(loaded, views)
    subject = Subject(
        loaded=loaded,
        facts=facts(loaded),
        views=tuple(views),
        steps=limits,
        shortest_period=shortest_period(views),
        closures=all_closures(loaded),
    )
    found, untried = findings(subject)
    return Inspection(
        file=file,
        files=loaded.source.files,
        facts=subject.facts,
        views=subject.views,
        steps=limits,
        shortest_period=subject.shortest_period,
        closures=subject.closures,
        findings=found,
        untried=untried,
        versions={**versions(()), "mujoco": str(loaded.mujoco.__version__)},
        joints=tuple(loaded.dof_name(dof) for dof in range(loaded.model.nv)),
    )


def view(loaded: Loaded, state: State, wanted: bool | None) -> View:
    """Return a state with its modes, or why it has none."""
    nv = loaded.model.nv
    if nv == 0:
        return View(state, reason="nothing can move")
    if wanted is False or (wanted is None and nv > MOST_DOFS):
        reason = (
            "not asked for" if wanted is False else f"{nv} degrees of freedom (--modes finds them)"
        )
        return View(state, reason=reason)
    if loaded.model.nflex and nv > MOST_DOFS:
        return View(state, reason="a flex of that many degrees of freedom")
    if spinning(loaded, state):
        return View(state, reason="a ball or free joint turns: its small motions are not constant")
    try:
        linear = linearise(loaded, state)
    except NotFiniteError as error:
        return View(state, reason=str(error), failed=True)
    except np.linalg.LinAlgError as error:
        return View(state, reason=f"the mass matrix cannot be solved with ({error})", failed=True)
    if linear.closed and np.any(state.velocity):
        return View(state, reason="closed loops move: their small motions are not constant")
    return seen(state, linear, np.arange(nv))


def spinning(loaded: Loaded, state: State) -> bool:
    """Return whether a ball or free joint turns in a state."""
    lib, m = loaded.mujoco, loaded.model
    for joint in range(m.njnt):
        first, kind = int(m.jnt_dofadr[joint]), int(m.jnt_type[joint])
        skipped = 3 if kind == int(lib.mjtJoint.mjJNT_FREE) else 0
        if kind <= int(lib.mjtJoint.mjJNT_BALL) and np.any(
            state.velocity[first + skipped : first + skipped + 3]
        ):
            return True
    return False


def seen(state: State, linear: Linear, dofs: np.ndarray) -> View:
    """Return a state with its modes in some of the coordinates; the others are held."""
    free = linear.free if len(dofs) == len(linear.mass) else np.eye(len(linear.mass))[:, dofs]
    inner = [free.T @ m @ free for m in (linear.mass, linear.damping, linear.stiffness)]
    own = tuple(mode._replace(vector=free @ mode.vector) for mode in shapes(*inner))
    if not (linear.rows or linear.closed):
        return View(state, linear, own, own)
    kept = np.eye(len(linear.mass))[:, dofs]
    soft = (linear.mass, linear.simulated_damping, linear.simulated_stiffness)
    found = shapes(*(kept.T @ matrix @ kept for matrix in soft))
    simulated = tuple(mode._replace(vector=kept @ mode.vector) for mode in found)
    return View(state, linear, own, simulated)


def rotation(loaded: Loaded, asked: Mapping[str, float] | None) -> View | None:
    """Return the steady rotation that was asked for, with its modes.

    Raises
    ------
    UsageError
    """
    if not asked:
        return None
    if len(asked) > 1:
        raise UsageError("one hinge can turn steadily, not several")
    ((joint, speed),) = asked.items()
    state = steady_rotation(loaded, joint, float(speed))
    try:
        linear = linearise(loaded, state)
    except NotFiniteError as error:
        return View(state, reason=str(error), failed=True)
    held = int(np.flatnonzero(state.velocity)[0]) if np.any(state.velocity) else None
    dofs = np.arange(loaded.model.nv)
    found = seen(state, linear, dofs if held is None else np.delete(dofs, held))
    return replace(found, held=joint)


def steps(loaded: Loaded, views: Sequence[View]) -> tuple[StepLimit, ...]:
    """Return the largest stable step of each integrator, and where it is least."""
    looked = [one for one in views if one.linear is not None]
    known = dir(loaded.mujoco.mjtIntegrator)
    own, found = integrator(loaded), []
    known_steps: dict[tuple[object, ...], Step] = {}
    for name in looked[0].linear.late if looked and looked[0].linear else ():
        if f"mjINT_{name.upper()}" not in known:
            continue
        rows = []
        for one in looked:
            assert one.linear is not None
            motion = Motion(
                one.linear.mass,
                one.linear.simulated_damping,
                one.linear.simulated_stiffness,
                *one.linear.late[name],
            )
            key = (SCHEMES[name], id(one), *(part.tobytes() for part in one.linear.late[name]))
            if key not in known_steps:
                known_steps[key] = longest_step(name, motion, list(one.simulated))
            rows.append((known_steps[key], one))
        least, where = min(rows, key=lambda row: row[0].limit)
        found.append(
            StepLimit(
                integrator=name,
                limit=least.limit,
                state=where.state.name if math.isfinite(least.limit) else None,
                omega=least.omega,
                joint=None if least.place is None else loaded.dof_name(least.place),
                chosen=name == own,
            )
        )
    return tuple(found)


def shortest_period(views: Sequence[View]) -> float | None:
    """Return the shortest period of all modes as simulated [s]; None if nothing oscillates."""
    rates = [
        mode.rate.imag
        for one in views
        for mode in one.simulated
        if mode.rate.imag > 0 and (mode.damping_ratio or 0.0) < SETTLING
    ]
    return 2 * math.pi / max(rates) if rates else None


def all_closures(loaded: Loaded) -> tuple[Closure, ...]:
    """Return the closures in all states, stiffest first, those that open most before others."""
    found: list[Closure] = []
    for state in loaded.states[:MOST_STATES]:
        try:
            found += closures(loaded, state)
        except (NotFiniteError, np.linalg.LinAlgError):
            continue
    return tuple(sorted(found, key=lambda one: (-one.omega, -one.opening)))
