"""`inspect`: what is in an MJCF file, how it moves, and what it could do without."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..documents import document
from ..engines.mujoco.library import quiet
from ..queries.environment import versions
from .findings import ModelFinding, Selection, findings, hits_of
from .mujoco.closures import ClosedLoop, closures
from .mujoco.facts import facts
from .mujoco.linear import Linear
from .mujoco.model import ENGINE, Loaded, NotFiniteError, load
from .pace import Pace
from .rules.table import RULES
from .spectrum import Shape
from .subject import SEVERITIES, InspectedModel, View
from .views import MOST_STATES, shortest_period_of, state_views, step_limits


def all_closures(loaded: Loaded, pace: Pace) -> tuple[ClosedLoop, ...]:
    """Return the closures in all states, stiffest first, those that open most before others."""
    every: list[ClosedLoop] = []
    for state in loaded.states[:MOST_STATES] if loaded.model.neq else ():
        if not pace.begins(f"closures in the state {state.name}"):
            break
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
        return document(
            "inspect",
            self.facts,
            file=self.file,
            files=self.files,
            summary=self.summary,
            states=[self.state_document(view) for view in self.views],
            steps=self.steps,
            shortest_period=self.shortest_period,
            closures=self.closures,
            findings=self.findings,
            untried=self.untried,
            left_out=self.pace.left_out,
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
    strict: bool = False,
    selection: Selection | None = None,
    pace: Pace | None = None,
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
    strict : bool
        Whether to look for what is a matter of taste, too: the rules of the house.
    selection : Selection, optional
        Which rules are asked instead, and what is waived beside the file's own comments.
    pace : Pace, optional
        How long it may take; it tells afterwards what was left out.

    Raises
    ------
    UsageError
        If the file cannot be read, is no MJCF or does not compile, or if there is no such
        rotation.
    EngineUnavailableError
        If MuJoCo cannot be imported.
    """
    pace, selection = pace or Pace(), selection or Selection.of_profile(strict)
    pace.progress(0, 1, f"MuJoCo compiles {Path(path).name}")
    loaded = load(path)
    with quiet(loaded.mujoco):
        still = without_motion(loaded, strict, pace)
        quick = hits_of(still, selection)
        subject = with_motion(still, about_rotation, modes)
        return inspection_of(path, subject, *findings(subject, selection, quick=quick))


def inspection_of(
    path: str | Path,
    subject: InspectedModel,
    results: tuple[ModelFinding, ...],
    untried: str | None = None,
) -> Inspection:
    """Return the inspection of a file."""
    loaded = subject.loaded
    return Inspection(
        **{item.name: getattr(subject, item.name) for item in fields(subject)},
        file=str(path),
        files=loaded.source.files,
        findings=results,
        untried=untried,
        versions={**versions(()), ENGINE: str(loaded.mujoco.__version__)},
    )


def without_motion(loaded: Loaded, strict: bool, pace: Pace) -> InspectedModel:
    """Return a model with what costs no time: nothing of its states, of steps and of loops."""
    pace.total = len(loaded.states) + len(RULES)
    return InspectedModel(loaded, facts(loaded), (), (), None, (), strict, pace)


def with_motion(
    s: InspectedModel, about_rotation: Mapping[str, float | str] | None, modes: bool | None
) -> InspectedModel:
    """Return a model with its states, the steps that they allow, and its loops."""
    loaded, pace = s.loaded, s.pace
    views = state_views(loaded, about_rotation, modes, pace)
    return replace(
        s,
        views=views,
        steps=step_limits(loaded, views, pace),
        shortest_period=shortest_period_of(views),
        closures=all_closures(loaded, pace),
    )
