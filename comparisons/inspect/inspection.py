"""`inspect`: what is in an MJCF file, how it moves, and what it could do without."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from ..documents import document
from ..documents.fields import takes_fields_of
from ..engines.mujoco.library import quiet
from ..queries.environment import versions
from .mujoco.closures import ClosedLoop, closures
from .mujoco.facts import BodyFacts, Options, facts
from .mujoco.linear import Linear
from .mujoco.model import ENGINE, Loaded, NotFiniteError, load
from .mujoco.source import Element, Waiver
from .request import InspectRequest
from .rules.table import RULES
from .rules.text import repeated_default
from .selection import Baseline, Selection, selection_of
from .spectrum import Shape
from .subject import SEVERITIES, Hit, InspectedModel, Severity, StepLimit, View
from .views import MOST_STATES, state_views, step_limits

BEFORE = "in the baseline"
"""Why a finding is waived that was there before."""

WORSE = 1.1
"""Times as bad as in the baseline from which on a finding counts again."""

MODES, STEPS, LOOPS = "modes", "largest stable steps", "loads of closures"
"""Parts of an inspection that take time, beside its rules."""

NEEDS = ("model", "states", "modes", "runs")
"""What rules need, in the order in which they are asked."""


@dataclass(frozen=True)
class ModelFinding:
    """What a rule says of a model.

    Attributes
    ----------
    rule : str
        its id; `mbcheck inspect --explain` tells about it
    severity : {"error", "warning", "note"}
        how bad it is
    element : str
        where: tag:name, tag:name/tag or tag
    file : str or None
        file; null if it does not stand in the text
    line : int or None
        line; null likewise
    message : str
        what was found, with its numbers
    fix : str
        what to do
    waived : str or None
        the reason that the file gives for it; null if it does not waive it
    attribute : str or None
        the attribute that is meant; null if it is not one
    measure : float or None
        how bad it is, the larger the worse; null where no number tells
    """

    rule: str
    severity: Severity
    element: str
    file: str | None
    line: int | None
    message: str
    fix: str
    waived: str | None = None
    attribute: str | None = None
    measure: float | None = None


@dataclass(frozen=True)
class ModelMode:
    """A mode of small motions.

    Attributes
    ----------
    kind : {"rigid", "oscillating", "decaying", "unstable"}
        what it does
    re : float
        real part of its eigenvalue [1/s]
    im : float
        imaginary part [1/s]
    omega : float
        modulus [rad/s]
    hertz : float
        omega / (2 pi) [Hz]
    damping_ratio : float or None
        -re / omega [1]; null for a rigid mode
    joint : str
        joint that moves most in it, by kinetic energy
    """

    kind: str
    re: float
    im: float
    omega: float
    hertz: float
    damping_ratio: float | None
    joint: str


@dataclass(frozen=True)
class ModelState:
    """A state of the file, and small motions about it.

    Attributes
    ----------
    names : tuple of str
        keyframes that hold it; 'as opened' is qpos0
    position : tuple of float
        qpos [m, rad]
    velocity : tuple of float
        qvel [m/s, rad/s]
    held : str or None
        hinge that turns steadily, held at its speed; null in the file's states
    reason : str or None
        why there are no modes; null if there are
    acceleration : float or None
        largest, closed loops exact [m/s^2, rad/s^2]; null without modes
    closed : int or None
        directions that closed loops take away; null without modes
    contacts : int or None
        contacts that act; null without modes
    limits : int or None
        limits that act; null without modes
    modes : tuple of ModelMode
        loops closed exactly, contacts and limits left out; ascending in omega
    simulated : tuple of ModelMode
        all constraints as soft as MuJoCo has them; ascending in omega
    """

    names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    held: str | None
    reason: str | None
    acceleration: float | None
    closed: int | None
    contacts: int | None
    limits: int | None
    modes: tuple[ModelMode, ...]
    simulated: tuple[ModelMode, ...]


@dataclass(frozen=True)
class Unreadable:
    """A file that could not be inspected.

    Attributes
    ----------
    file : str
        as it was given
    reason : str
        why it could not be inspected
    """

    file: str
    reason: str


@dataclass(frozen=True)
class InspectDocument:
    """What is in an MJCF file, and what it could do without.

    Attributes
    ----------
    file : str
        the file, as it was given
    files : tuple of str
        it, and what it includes
    name : str
        of the model; empty if the file gives none
    summary : mapping of str to int
        number of findings by severity, waived ones apart; any `error` is exit code 1
    options : Options
        how the file is simulated
    counts : mapping of str to int
        number of positions nq, degrees of freedom nv, bodies, joints, geoms, ...
    mass : float
        of all bodies [kg]
    size : float
        MuJoCo's extent [m]
    bodies : tuple of BodyFacts
        in the order of the tree, without the world
    states : tuple of ModelState
        states of the file, then the steady rotation that was asked for
    steps : tuple of StepLimit
        largest stable step of each integrator; empty without modes
    shortest_period : float or None
        of all that oscillates as simulated [s]; null if nothing does
    closures : tuple of ClosedLoop
        closures of loops in each state, the stiffest first
    findings : tuple of ModelFinding
        unwaived ones first, errors first
    untried : str or None
        why some attributes were not tried for repeated_default; null if all were
    left_out : tuple of str
        modes, steps and rules that were not begun before it was stopped
    """

    file: str
    files: tuple[str, ...]
    name: str
    summary: Mapping[str, int]
    options: Options
    counts: Mapping[str, int]
    mass: float
    size: float
    bodies: tuple[BodyFacts, ...]
    states: tuple[ModelState, ...]
    steps: tuple[StepLimit, ...]
    shortest_period: float | None
    closures: tuple[ClosedLoop, ...]
    findings: tuple[ModelFinding, ...]
    untried: str | None
    left_out: tuple[str, ...]
    versions: Mapping[str, str]


@dataclass(frozen=True)
class InspectionsDocument:
    """What is found in several MJCF files.

    Attributes
    ----------
    summary : mapping of str to int
        number of findings of all files
    unreadable : tuple of Unreadable
        files that could not be inspected
    models : tuple of InspectDocument
        the others, each as `inspect` describes it
    """

    summary: Mapping[str, int]
    unreadable: tuple[Unreadable, ...]
    models: tuple[InspectDocument, ...]


@dataclass(frozen=True, kw_only=True)
class Inspection(InspectedModel):
    """What is found about a file: all that rules look at, and what they say.

    Attributes
    ----------
    file : str
        As it was given.
    files : tuple of str
        It, and what it includes.
    findings : tuple of ModelFinding
    untried : str or None
        Why some attributes were not tried for `repeated_default`, if any were not.
    left_out : tuple of str
        Parts that were not begun, the next first: empty at the end.
    versions : mapping of str to str
    """

    file: str
    files: tuple[str, ...]
    findings: tuple[ModelFinding, ...]
    untried: str | None
    left_out: tuple[str, ...]
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
            self,
            **vars(self.facts),
            states=[self.state_document(view) for view in self.views],
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
            "contacts": linear and linear.rows.contacts,
            "limits": linear and linear.rows.limits,
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


@takes_fields_of(InspectRequest)
def inspect(asked: InspectRequest) -> Inspection:
    """Inspect an MJCF file; takes the fields of `InspectRequest`.

    Raises
    ------
    UsageError
        If the file cannot be read, is no MJCF or does not compile, or if there is no such
        rotation or rule.
    EngineUnavailableError
        If MuJoCo cannot be imported.
    """
    return whole_inspection(asked)


def whole_inspection(asked: InspectRequest) -> Inspection:
    """Return the whole inspection of a file, see `inspect`."""
    *_, (_, report) = inspect_in_parts(asked)
    return report()


def inspect_in_parts(
    asked: InspectRequest,
) -> Iterator[tuple[tuple[str, ...], Callable[[], Inspection]]]:
    """Inspect a file in parts; rules that look at the model alone come before what takes time.

    Yields before each part, and at the end, the parts that are to come, and what returns the
    inspection so far. See `inspect`.
    """
    path, selection = asked.path, selection_of(asked)
    loaded, hits, untried = load(path), list[tuple[str, Hit]](), None
    rules = {f"rule {name}": RULES[name] for name in RULES if name in selection.rules}
    repeated = [part for part in rules if part == "rule repeated_default"]
    quick, *slow = ([p for p, rule in rules.items() if rule.needs == need] for need in NEEDS)
    parts = [*quick, MODES, STEPS, LOOPS, *chain(*slow), *repeated]
    s = InspectedModel(loaded, facts(loaded), asked.strict)
    with quiet(loaded.mujoco), np.errstate(all="ignore"):
        for number, part in enumerate(parts):
            left = tuple(parts[number:])
            yield left, partial(report_of, path, s, selection, hits, left)
            if part == MODES:
                s = replace(s, views=state_views(loaded, asked.about_rotation, asked.modes))
            elif part == STEPS:
                s = replace(s, steps=step_limits(loaded, s.views))
            elif part == LOOPS:
                s = replace(s, closures=all_closures(loaded))
            elif part in repeated:  # what no other rule has found
                repeated_hits, untried = repeated_default(s, [hit for _, hit in hits])
                hits += [("repeated_default", hit) for hit in repeated_hits]
            else:
                hits += [(part.removeprefix("rule "), hit) for hit in rules[part].find(s)]
        yield (), partial(report_of, path, s, selection, hits, (), untried)


def all_closures(loaded: Loaded) -> tuple[ClosedLoop, ...]:
    """Return the closures in all states, stiffest first, those that open most before others."""
    every: list[ClosedLoop] = []
    for state in loaded.states[:MOST_STATES] if loaded.model.neq else ():
        with suppress(NotFiniteError, np.linalg.LinAlgError):
            every += closures(loaded, state)
    return tuple(sorted(every, key=lambda one: (-one.omega, -one.opening)))


def report_of(
    path: str | Path,
    s: InspectedModel,
    selection: Selection,
    hits: Sequence[tuple[str, Hit]],
    left_out: tuple[str, ...],
    untried: str | None = None,
) -> Inspection:
    """Return a model with its findings: errors first, and those that are waived last.

    A waiver of what was not looked for, or of a rule that was not tried on all, may be of use
    another time; others that waive nothing, and are about this model alone, are findings.
    """
    waivers = (*s.loaded.source.waivers, *selection.waivers)
    results, used = list[ModelFinding](), set[int]()
    for rule, hit in sorted(hits, key=lambda one: list(RULES).index(one[0])):
        number = next((i for i, one in enumerate(waivers) if one.covers(rule, hit.name)), None)
        if number is not None:
            used.add(number)
            results.append(finding(rule, hit, waivers[number].reason))
        else:
            results.append(compared(selection.baseline, rule, hit))
    skipped = {name for name in RULES if name not in selection.rules or f"rule {name}" in left_out}
    if untried:
        skipped.add("repeated_default")
    if not any(view.linear for view in s.views):
        skipped |= {name for name, rule in RULES.items() if rule.needs == "modes"}
    for i, waiver in enumerate(waivers):
        idle = i not in used and not (waiver.rule in skipped and waiver.reason)
        if idle and waiver.required:
            rule, hit = complaint(waiver)
            results += [finding(rule, hit)] if rule in selection.rules else []
    results.sort(key=lambda one: (one.waived is not None, SEVERITIES.index(one.severity)))
    return Inspection(
        **{item.name: getattr(s, item.name) for item in fields(s)},
        file=str(path),
        files=s.loaded.source.files,
        findings=tuple(results),
        untried=untried,
        left_out=left_out,
        versions={**versions(()), ENGINE: str(s.loaded.mujoco.__version__)},
    )


def compared(baseline: Baseline, rule: str, hit: Hit) -> ModelFinding:
    """Return a finding: waived if it is in the baseline, unless it has become worse."""
    old = baseline.get((rule, hit.name))
    if old is not None and hit.measure is not None and hit.measure > WORSE * abs(old):
        worse = f"; in the baseline it was {old:.3g} where now it is {hit.measure:.3g}"
        return finding(rule, hit._replace(message=hit.message + worse))
    return finding(rule, hit, BEFORE if (rule, hit.name) in baseline else None)


def finding(rule: str, hit: Hit, waived: str | None = None) -> ModelFinding:
    """Return what a rule found, with what the rule itself says, and why the file waives it."""
    return ModelFinding(
        rule=rule,
        severity=RULES[rule].severity,
        element=hit.name,
        file=hit.element.file if hit.element else None,
        line=hit.element.line if hit.element else None,
        message=hit.message,
        fix=hit.fix or RULES[rule].fix,
        waived=waived,
        attribute=hit.attribute,
        measure=hit.measure,
    )


def complaint(waiver: Waiver) -> tuple[str, Hit]:
    """Return the rule about a waiver that waives nothing, and what is wrong with it."""
    words = " ".join(waiver.text.split())
    quoted = repr(words if len(words) < 60 else f"{words[:57]}...")
    about = "" if waiver.pattern is None else f" for {waiver.pattern}"
    if not waiver.rule:
        rule, message = "waiver_reason", f"{quoted} is not a waiver"
    elif waiver.rule not in RULES:
        rule, message = "waiver_unknown", f"there is no rule {waiver.rule!r}"
    elif not waiver.reason:
        rule, message = "waiver_reason", f"{quoted} gives no reason"
    else:
        rule, message = "waiver_unused", f"nothing is found by {waiver.rule}{about}"
    return rule, Hit(Element("comment", {}, waiver.file, waiver.line), "comment", message)
