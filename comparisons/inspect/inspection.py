"""Inspection of an MJCF file: its content, its small motions, and the findings of rules."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from fnmatch import fnmatchcase
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...reference.errors import UnknownNameError, UsageError
from ..documents import document
from ..documents.fields import documented, takes_fields_of
from ..documents.reading import read_document
from ..documents.waivers import Waiver, waivers_of
from ..engines.mujoco.library import quiet
from ..queries.environment import versions
from .mujoco.closures import ClosedLoop, closures
from .mujoco.facts import facts
from .mujoco.model import ENGINE, Loaded, NotFiniteError, load
from .mujoco.source import Element
from .request import InspectRequest
from .rules.table import RULES
from .rules.text import repeated_default
from .subject import SEVERITIES, Hit, InspectedModel, Severity
from .tuning import EFFORT, THRESHOLDS
from .views import Shape, state_views, step_limits

MODES, STEPS, LOOPS = "modes", "largest stable steps", "loads of closures"
"""Parts of an inspection that take time, besides its rules."""

NEEDS = ("model", "states", "modes", "runs")
"""Inputs of rules, in the order in which rules are evaluated."""


@dataclass(frozen=True)
class ModelFinding:
    """Finding of a rule.

    Attributes
    ----------
    rule : str
        id of the rule, which `mbcheck explain` explains
    severity : {"error", "warning", "note"}
        severity of the rule
    element : str
        element: tag:name, tag:name/tag or tag
    file : str or None
        file; null if the element is not in the text
    line : int or None
        line; null if the element is not in the text
    message : str
        mistake, with its numbers
    fix : str
        remedy
    waived : str or None
        reason for which it is waived; null if it is not
    attribute : str or None
        wrong attribute; null if it is not one
    measure : float or None
        size of the mistake, the larger the worse; null where no number measures it
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
    """Mode of small motions.

    Attributes
    ----------
    kind : {"rigid", "oscillating", "decaying", "unstable"}
        kind of motion
    re : float
        real part of the eigenvalue [1/s]
    im : float
        imaginary part of the eigenvalue [1/s]
    omega : float
        modulus of the eigenvalue [rad/s]
    hertz : float
        omega / (2 pi) [Hz]
    damping_ratio : float or None
        -re / omega [1]; null for a rigid mode
    joint : str
        joint with most of the kinetic energy
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
    """State of the file, and small motions about it.

    Attributes
    ----------
    names : tuple of str
        keyframes that define the state; 'as opened' is qpos0
    position : tuple of float
        qpos [m, rad]
    velocity : tuple of float
        qvel [m/s, rad/s]
    held : str or None
        hinge that turns steadily at a fixed speed; null in the states of the file
    reason : str or None
        reason why there are no modes; null if there are
    acceleration : float or None
        largest acceleration, closed loops exact [m/s^2, rad/s^2]; null without modes
    closed : int or None
        number of directions that closed loops block; null without modes
    contacts : int or None
        number of active contacts; null without modes
    limits : int or None
        number of active limits; null without modes
    modes : tuple of ModelMode
        modes with loops closed exactly, without contacts and limits; ascending in omega
    simulated : tuple of ModelMode
        modes with all constraints as soft as MuJoCo has them; ascending in omega
    """

    names: Sequence[str]
    position: Sequence[float]
    velocity: Sequence[float]
    held: str | None
    reason: str | None
    acceleration: float | None
    closed: int | None
    contacts: int | None
    limits: int | None
    modes: Sequence[ModelMode]
    simulated: Sequence[ModelMode]


@dataclass(frozen=True, kw_only=True)
class Inspection(InspectedModel):
    """Content of an MJCF file, its small motions, and the findings of rules.

    Attributes
    ----------
    findings : tuple of ModelFinding
        findings: those that are not waived first, errors first
    untried : str or None
        reason why some attributes were not tried for repeated_default; null if all were
    left_out : tuple of str
        modes, steps and rules that were not begun before the inspection was stopped
    """

    findings: tuple[ModelFinding, ...]
    untried: str | None
    left_out: tuple[str, ...]
    versions: Mapping[str, str]

    @property
    def unwaived(self) -> tuple[ModelFinding, ...]:
        """Findings that are not waived."""
        return tuple(one for one in self.findings if one.waived is None)

    @property
    @documented
    def summary(self) -> Mapping[str, int]:
        """Number of findings by severity, waived ones apart; any `error` is exit code 1."""
        counts: dict[str, int] = {
            name: sum(one.severity == name for one in self.unwaived) for name in SEVERITIES
        }
        return counts | {"waived": len(self.findings) - len(self.unwaived)}

    @property
    def exit_code(self) -> int:
        """1 if an error is not waived, else 0."""
        return 1 if self.summary["error"] else 0

    @property
    @documented
    def states(self) -> Sequence[ModelState]:
        """States of the file, then the steady rotation of --about-rotation."""
        return [
            ModelState(
                names=view.state.keys,
                position=view.state.position.tolist(),
                velocity=view.state.velocity.tolist(),
                held=view.steady_hinge,
                reason=view.reason,
                acceleration=linear and float(np.max(np.abs(linear.acceleration), initial=0.0)),
                closed=linear and linear.closed,
                contacts=linear and linear.rows.contacts,
                limits=linear and linear.rows.limits,
                modes=list(map(self.as_mode, view.modes)),
                simulated=list(map(self.as_mode, view.simulated)),
            )
            for view in self.views
            for linear in [view.linear]
        ]

    def as_mode(self, mode: Shape) -> ModelMode:
        """Return a mode as documents have it."""
        return ModelMode(
            kind=mode.kind,
            re=mode.rate.real,
            im=mode.rate.imag,
            omega=mode.omega,
            hertz=mode.omega / (2 * math.pi),
            damping_ratio=mode.damping_ratio,
            joint=self.loaded.joint_names[mode.dof],
        )

    def as_json(self) -> dict[str, Any]:
        """Return the ``inspect`` document of docs/json.md."""
        return document("inspect", self)


@takes_fields_of(InspectRequest)
def inspect(request: InspectRequest) -> Inspection:
    """Inspect an MJCF file; takes the fields of `InspectRequest`.

    Raises
    ------
    UsageError
        If the file cannot be read, is not MJCF or does not compile, or if there is no such
        rotation or rule.
    EngineUnavailableError
        If MuJoCo cannot be imported.
    """
    return whole_inspection(request)


def whole_inspection(request: InspectRequest) -> Inspection:
    """Return the whole inspection of a file, see `inspect`."""
    *_, (_, report) = inspect_in_parts(request)
    return report()


def inspect_in_parts(
    request: InspectRequest,
) -> Iterator[tuple[tuple[str, ...], Callable[[], Inspection]]]:
    """Inspect a file in parts; rules that need the model alone come before expensive parts.

    Yields before each part, and at the end, the remaining parts, and a function that returns the
    inspection so far. See `inspect`.
    """
    selection = selection_of(request)
    loaded, hits, untried = load(request.path), list[tuple[str, Hit]](), None
    rules = {f"rule {name}": RULES[name] for name in RULES if name in selection.rules}
    repeated = [part for part in rules if part == "rule repeated_default"]
    quick, *slow = ([p for p, rule in rules.items() if rule.needs == need] for need in NEEDS)
    parts = [*quick, MODES, STEPS, LOOPS, *chain(*slow), *repeated]
    content = vars(facts(loaded, str(request.path)))
    s = InspectedModel(**content, loaded=loaded, strict=request.strict)
    with quiet(loaded.mujoco), np.errstate(all="ignore"):
        for number, part in enumerate(parts):
            left = tuple(parts[number:])
            yield left, partial(report_of, s, selection, hits, left)
            if part == MODES:
                s = replace(s, views=state_views(loaded, request.about_rotation, request.modes))
            elif part == STEPS:
                s = replace(s, steps=step_limits(loaded, s.views))
            elif part == LOOPS:
                s = replace(s, closures=all_closures(loaded))
            elif part in repeated:  # attributes that no other rule has found
                repeated_hits, untried = repeated_default(s, [hit for _, hit in hits])
                hits += [("repeated_default", hit) for hit in repeated_hits]
            else:
                hits += [(part.removeprefix("rule "), hit) for hit in rules[part].find(s)]
        yield (), partial(report_of, s, selection, hits, (), untried)


def all_closures(loaded: Loaded) -> tuple[ClosedLoop, ...]:
    """Return the closures in all states, the stiffest first, then those that open most."""
    every: list[ClosedLoop] = []
    for state in loaded.states[: EFFORT.max_states] if loaded.model.neq else ():
        with suppress(NotFiniteError, np.linalg.LinAlgError):
            every += closures(loaded, state)
    return tuple(sorted(every, key=lambda one: (-one.omega, -one.opening)))


def report_of(
    s: InspectedModel,
    selection: Selection,
    hits: Sequence[tuple[str, Hit]],
    left_out: tuple[str, ...],
    untried: str | None = None,
) -> Inspection:
    """Return a model with its findings: errors first, waived ones last.

    A waiver of a rule that was left out, or not tried on all attributes, may be needed another
    time; others that waive nothing, and concern this model alone, are findings.
    """
    waivers = (*s.loaded.source.waivers, *selection.waivers)
    results, used = list[ModelFinding](), set[int]()
    stated = {cause for _, hit in hits for cause in hit.causes}
    for rule, hit in sorted(hits, key=lambda one: list(RULES).index(one[0])):
        own = hit.name.partition("/")[0].partition(":")[2] or hit.name
        names = hit.name, own, " ".join(filter(None, (hit.name, hit.attribute)))  # as printed
        number = next((i for i, one in enumerate(waivers) if one.covers(rule, *names)), None)
        if number is not None:
            used.add(number)
        if (rule, hit.name) in stated:
            continue
        results.append(
            compared(selection.baseline, rule, hit)
            if number is None
            else finding(rule, hit, waivers[number].reason)
        )
    skipped = {name for name in RULES if name not in selection.rules or f"rule {name}" in left_out}
    if untried:
        skipped.add("repeated_default")
    if not s.linear_views:
        skipped |= {name for name, rule in RULES.items() if rule.needs == "modes"}
    for i, waiver in enumerate(waivers):
        idle = i not in used and not (waiver.rule in skipped and waiver.reason)
        if idle and waiver.required:
            rule, hit = complaint(waiver)
            results += [finding(rule, hit)] if rule in selection.rules else []
    results.sort(key=lambda one: (one.waived is not None, SEVERITIES.index(one.severity)))
    return Inspection(
        **{item.name: getattr(s, item.name) for item in fields(s)},
        findings=tuple(results),
        untried=untried,
        left_out=left_out,
        versions={**versions(()), ENGINE: str(s.loaded.mujoco.__version__)},
    )


def compared(baseline: Baseline, rule: str, hit: Hit) -> ModelFinding:
    """Return a finding: waived if it is in the baseline, unless it has become worse."""
    old, worse = baseline.get((rule, hit.name)), THRESHOLDS.worse_than_baseline
    if old is not None and hit.measure is not None and hit.measure > worse * abs(old):
        words = f"; worse than the baseline's {old:.3g}: now {hit.measure:.3g}"
        return finding(rule, hit._replace(message=hit.message + words))
    return finding(rule, hit, "in the baseline" if (rule, hit.name) in baseline else None)


def finding(rule: str, hit: Hit, waived: str | None = None) -> ModelFinding:
    """Return the finding of a rule, with the texts of the rule, and the reason of a waiver."""
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
    """Return the rule about a waiver that waives nothing, and its finding."""
    words = " ".join(waiver.text.split())
    quoted = repr(words if len(words) < 60 else f"{words[:57]}...")
    about = "" if waiver.pattern is None else f" for {waiver.pattern}"
    complaints = (
        (not waiver.rule, "waiver_reason", f"{quoted} is not a waiver"),
        (waiver.rule not in RULES, "waiver_unknown", f"there is no rule {waiver.rule!r}"),
        (not waiver.reason, "waiver_reason", f"{quoted} gives no reason"),
        (True, "waiver_unused", f"{waiver.rule} finds nothing{about}"),
    )
    _, rule, message = next(row for row in complaints if row[0])
    return rule, Hit(Element("comment", {}, waiver.file, waiver.line), "comment", message)


# Selected rules, waivers and baselines --------------------------------------------------------

BESIDE = "mbcheck-inspect.toml"
"""Name of the file of waivers in the folder of a model."""

Baseline = Mapping[tuple[str, str], float | None]
"""Rule and element of each known finding -> its measure, if it has one."""


class Selection(NamedTuple):
    """Selected rules, and waivers beside the comments of the file."""

    rules: frozenset[str]
    waivers: tuple[Waiver, ...]
    baseline: Baseline


def selection_of(request: InspectRequest) -> Selection:
    """Return the selected rules, the waivers and the baseline of a file, or of none.

    Raises
    ------
    UsageError
        If a pattern matches no rule, or the file of waivers, or the baseline, cannot be read.
    """
    file = str(request.path)
    beside = os.path.join(os.path.dirname(file), BESIDE)
    place = request.waivers or (beside if file and os.path.isfile(beside) else None)
    waivers = waivers_of(Path(place), file, RULES) if place else ()
    known = baseline_of(request.baseline) if request.baseline else {}
    return Selection(rules_of(request), waivers, known.get(Path(file).as_posix(), {}))


def rules_of(request: InspectRequest) -> frozenset[str]:
    """Return the selected rules.

    Raises
    ------
    UnknownNameError
        If a pattern matches none.
    """

    def matching(patterns: Sequence[str]) -> set[str]:
        return {name for name in RULES if any(fnmatchcase(name, pattern) for pattern in patterns)}

    for pattern in (*request.select, *request.ignore):
        if not matching([pattern]):
            raise UnknownNameError("rule", pattern, RULES)
    default = {name for name, rule in RULES.items() if request.strict or not rule.house}
    return frozenset((matching(request.select) or default) - matching(request.ignore))


def baseline_of(name: str) -> dict[str, dict[tuple[str, str], float | None]]:
    """Return the findings of a document: file -> rule and element -> measure, if any.

    Raises
    ------
    UsageError
        If it cannot be read, or is not a document of ``inspect``.
    """
    _, content = read_document(name, "JSON", json.loads, "--baseline: ")
    baselines: dict[str, dict[tuple[str, str], float | None]] = {}
    try:
        for model in content.get("models", [content]):
            known = baselines.setdefault(Path(model["file"]).as_posix(), {})
            for one in unwaived(model):
                key = one["rule"], one["element"]
                known[key] = max(known.get(key) or 0.0, one["measure"] or 0.0) or None
    except (KeyError, TypeError, AttributeError):
        raise UsageError(f"--baseline: {name} is not a document of inspect --json") from None
    return baselines


def unwaived(model: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the findings of an ``inspect`` document that are not waived."""
    return [one for one in model["findings"] if one["waived"] is None]
