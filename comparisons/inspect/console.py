"""Sections of the report on an MJCF file."""

from __future__ import annotations

import glob
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from rich.console import Console

from ..reports.item import Level, ReportItem
from ..reports.sections import Section, print_sections
from ..reports.words import number, plural
from .inspection import Inspection, ModelFinding
from .mujoco.facts import BodyFacts
from .mujoco.model import ENGINE
from .rules.table import RULES
from .tuning import EFFORT, NUMERICS, THRESHOLDS
from .views import View

UNSTABLE = (
    "an unstable mode here is no finding if contacts, limits or constant forces keep the state, if "
    f"it grows by less than {THRESHOLDS.min_growth:g} 1/s, or if a run of {NUMERICS.run_steps} "
    "steps does not show the growth"
)
"""Remark on unstable modes that no finding mentions."""

AT_REST = 1e-6
"""Acceleration [rad/s^2, m/s^2] below which a state is called a state of rest."""

SINGULAR = {"bodies": "body", "equalities": "equality", "meshes": "mesh", "flexes": "flex"}

VERDICTS: Mapping[Level, str] = {"error": "error", "warning": "known", "note": ""}
"""Severity -> verdict whose style it is printed in."""


def inspection_sections(
    inspection: Inspection, items: Sequence[ReportItem], full: bool
) -> Iterator[Section]:
    """Yield facts, findings, modes and steps and, if it is short or ``full``, the bodies."""
    yield facts_section(inspection)
    yield from finding_sections(items, full)
    if full and inspection.unwaived:
        title = "to waive a finding, with your reason: in mbcheck-inspect.toml beside the model"
        yield Section(title, verbatim=list(waiver_lines(inspection.unwaived)))
    if inspection.untried is not None:
        yield Section(lines=[f"repeated_default: {inspection.untried}"])
    rows = [row for body in inspection.bodies for row in body_rows(body)]
    if rows and (full or len(rows) <= EFFORT.rows):
        heads = ["body", "joints", "mass [kg]", "inertia [kg m^2]"]
        yield Section("", heads, rows, digits=5)
    with_modes_first = sorted(inspection.views, key=lambda view: view.linear is None)
    views = inspection.views if full else with_modes_first[: EFFORT.states]
    yield from (view_section(inspection, view, full) for view in views)
    if more := len(inspection.views) - len(views):
        yield Section(lines=[f"... {more} more states, with --full"])
    yield from steps_section(inspection)
    yield from closures_section(inspection, full)
    if words := omissions(inspection.left_out):
        yield Section(lines=[words])


def omissions(left_out: Sequence[str]) -> str:
    """Return a sentence about the parts that were left out; empty if there are none."""
    rules = [part.removeprefix("rule ") for part in left_out if part.startswith("rule ")]
    others = [part for part in left_out if not part.startswith("rule ")]
    others += [f"the rules {', '.join(rules)}"] if rules else []
    return f"stopped before {'; '.join(others)}" if others else ""


def finding_sections(items: Sequence[ReportItem], full: bool) -> Iterator[Section]:
    """Yield the findings, errors first: all, or the first one of a few rules."""
    rules = dict[str, list[ReportItem]]()
    for item in items:
        if item.severity:
            rules.setdefault(item.rule, []).append(item)
    listed = list(rules) if full else list(rules)[: EFFORT.rules]
    for rule in listed:
        most = len(rules[rule]) if full else 1
        for item in rules[rule][:most]:
            title = f"{item.severity} {item.id} ({item.place})"
            verdict = VERDICTS[item.severity or "note"]
            yield Section(title, lines=[item.message, *item.details], verdict=verdict)
        if more := len(rules[rule]) - most:
            yield Section(lines=[f"... and {more} more of {rule}, with --full"])
    if left := list(rules)[len(listed) :]:
        yield Section(lines=[f"... and of {', '.join(left)}, with --full"])
    if rules:
        first = next(iter(rules))
        hint = "" if full else "; --full prints waivers"
        yield Section(lines=[f"mbcheck explain {first} says why it matters{hint}"])


def waiver_lines(findings: Iterable[ModelFinding]) -> Iterator[str]:
    """Yield the entries of a file of waivers for some findings, without their reasons."""
    for rule, element in dict.fromkeys((one.rule, one.element) for one in findings):
        if rule.startswith("waiver_"):
            continue  # what is wrong with a waiver is not waived
        pattern = json.dumps(glob.escape(element), ensure_ascii=False)
        yield from ("[[waive]]", f'rule = "{rule}"', f"element = {pattern}", 'reason = ""')


def facts_section(inspection: Inspection) -> Section:
    """Return size, mass and options of the model."""
    options = inspection.options
    included = len(inspection.files) - 1
    more = f" and {included} included" if included else ""
    name = f"{inspection.name}: " if inspection.name else ""
    counts = ", ".join(
        f"{count} {SINGULAR.get(name, name.removesuffix('s')) if count == 1 else name}"
        for name, count in inspection.counts.items()
        if count and name not in ("nq", "nv")
    )
    positions = plural(inspection.counts["nq"], "position")
    dofs = f"{plural(inspection.counts['nv'], 'degree')} of freedom ({positions})"
    solver = (
        f"{options.solver} ({options.iterations} iterations, tolerance {number(options.tolerance)})"
    )
    gravity = " ".join(number(x, 6) for x in options.gravity) if any(options.gravity) else "off"
    flags = {"contact": options.contact, "energy": options.energy, "auto-reset": options.autoreset}
    switches = ", ".join(f"{name} {'on' if on else 'off'}" for name, on in flags.items())
    return Section(
        f"{name}{inspection.file}{more}, MuJoCo {inspection.versions[ENGINE]}",
        lines=[
            f"{dofs}, {counts or 'no bodies'}; mass {number(inspection.mass, 6)} kg",
            f"{options.integrator}, timestep {number(options.timestep, 10)} s; solver {solver}; "
            f"gravity {gravity}; {switches}",
        ],
    )


def body_rows(body: BodyFacts) -> Iterator[list[object]]:
    """Yield the rows of a body: one, and another for each further joint."""
    deepest = EFFORT.indented_levels
    indent = "  " * min(body.depth, deepest) + ("> " if body.depth > deepest else "")
    values = body.inertia[:1] if len(set(body.inertia)) == 1 else body.inertia
    joints = []
    for joint in body.joints:
        words = [joint.kind if joint.axis is None else f"{joint.kind} {axis_word(joint.axis)}"]
        parts = {"k": joint.stiffness, "c": joint.damping, "armature": joint.armature}
        words += [f"{symbol} {number(value, 4)}" for symbol, value in parts.items() if value]
        words += [" to ".join(number(x, 4) for x in joint.range)] if joint.range else []
        joints.append(f"{joint.name}: {', '.join(words)}")
    first, *others = joints or ["(welded)"]
    yield [f"{indent}{body.name}", first, body.mass, " ".join(number(value, 4) for value in values)]
    for joint_text in others:
        yield ["", joint_text, None, ""]


def axis_word(axis: Sequence[float]) -> str:
    """Return the letter of an axis of the frame, or the numbers of another one."""
    small = [abs(value) <= 1e-9 for value in axis]
    for letter, value in zip("xyz", axis, strict=True):
        if abs(abs(value) - 1) < 1e-9 and sum(small) == 2:
            return letter if value > 0 else f"-{letter}"
    return "(" + " ".join(map(number, axis)) + ")"


def view_section(inspection: Inspection, view: View, full: bool) -> Section:
    """Return a state with its modes, unstable ones first, then the fastest; few of them or all."""
    linear = view.linear
    if linear is None:
        return Section(lines=[f"state {view.state.name}: no modes, {view.reason}"])
    kinds = [mode.kind for mode in view.modes]
    words = [plural(len(kinds), "mode")]
    named = ("rigid", "decaying", "unstable")
    words += [f"{kinds.count(kind)} {kind}" for kind in named if kind in kinds]
    words += [f"{plural(linear.closed, 'direction')} blocked by loops"] if linear.closed else []
    ignored = {"contact": linear.rows.contacts, "limit": linear.rows.limits}
    words += [f"{plural(count, noun)} left out" for noun, count in ignored.items() if count]
    rest = float(max(abs(linear.acceleration), default=0.0))
    if view.steady_hinge is not None:
        words.append(f"{view.steady_hinge} turns at a fixed speed")
    elif rest < AT_REST:
        words.append("at rest")
    else:
        words.append(f"not at rest (acceleration {number(rest)}, balanced by constant forces)")
    rows: list[list[object]] = [
        [
            mode.omega,
            mode.omega / (2 * math.pi) if mode.rate.imag else None,
            mode.damping_ratio,
            mode.rate.real,
            inspection.loaded.joint_names[mode.dof],
            mode.kind if mode.kind in named else "",
        ]
        for mode in sorted(view.modes, key=lambda mode: (mode.kind != "unstable", -mode.omega))
        if mode.kind != "rigid"
    ]
    if len(rows) > EFFORT.modes + 1 and not full:
        more = f"... {len(rows) - EFFORT.modes} more"
        rows[EFFORT.modes - 1 : -1] = [[None, None, None, None, more, ""]]
    lines = [", ".join(words)]
    named_here = (repr(view.state.name) in one.message for one in inspection.findings)
    about_growth = (one.rule.startswith("unstable") for one in inspection.findings)
    if "unstable" in kinds and not (any(named_here) or any(about_growth)):
        lines.append(UNSTABLE)
    heads = ["omega [rad/s]", "[Hz]", "damping ratio", "re [1/s]", "mainly in", ""]
    return Section(f"state {view.state.name}", heads, rows, lines, digits=6)


def steps_section(inspection: Inspection) -> Iterator[Section]:
    """Yield the largest stable step of each integrator, and the mode that limits it."""
    if not inspection.steps:
        return
    step, period, faults = inspection.timestep, inspection.shortest_period, inspection.rejected
    heads = ["integrator", "stable up to [s]", "timestep / limit", "mode [1/s]", "in"]
    heads += ["state"] if len(inspection.views) > 1 else []
    rows = [
        [
            f"{one.integrator}{' (file)' * one.of_file}{' *' * (one.integrator in faults)}",
            "no limit" if math.isinf(one.limit) else number(one.limit, 4),
            "" if math.isinf(one.limit) or not one.limit else number(step / one.limit, 2),
            number(one.omega, 4, missing=""),
            one.place if one.joint else "",
            one.state or "",
        ][: len(heads)]
        for one in inspection.steps
    ]
    lines = [f"* {name} is no remedy: {fault}" for name, fault in faults.items()]
    lines += conditions_of(inspection)
    softened = next((one.softened for one in inspection.steps if one.of_file), math.inf)
    if any(softened < one.limit for one in inspection.steps):
        words = f"steps above {number(softened, 4)} s soften constraints (refsafe)"
        lines.append(f"{words}: they simulate a softer mechanism")
    if period is not None:
        per_period = number(period / step, 4)
        lines.append(f"{per_period} steps in the shortest period, {number(period, 4)} s")
    yield Section("", heads, rows, lines)


def conditions_of(inspection: Inspection) -> Iterator[str]:
    """Yield the limits of validity of the largest stable steps, omissions first."""
    loaded, model = inspection.loaded, inspection.loaded.model
    left_out = [f"the state {one.state.name}" for one in inspection.views if one.linear is None]
    joints = [name for one in inspection.views for name in loaded.at_limits(one.state)]
    if first := list(dict.fromkeys(joints)):
        more = f" and {plural(len(first) - 1, 'more joint')}" if len(first) > 1 else ""
        left_out.append(f"limits of joints at the end of their range ({first[0]}{more})")
    left_out += ["states of plugins"] if model.nplugin else []
    for kind, words in (("muscle", "activations of muscles"), ("user", "user-defined activations")):
        left_out += [words] if any(loaded.of_kind("actuator_dyntype", kind)) else []
    if left_out:
        yield f"left out of these limits: {', '.join(left_out)}"
    apart = [
        one.state.name for one in inspection.views if one.linear and not one.linear.rows.contacts
    ]
    if apart and any(inspection.can_touch):
        yield (
            f"no contact is active in the state {', '.join(apart)}: later contacts may need "
            "shorter steps"
        )
    dry = any(model.dof_frictionloss) or any(model.tendon_frictionloss)
    if dry and not (loaded.disabled("frictionloss") or loaded.disabled("constraint")):
        yield "dry friction makes these limits conservative: it may keep a run bounded beyond them"


def closures_section(inspection: Inspection, full: bool) -> Iterator[Section]:
    """Yield each closure in the state where it opens most, the stiffest first: a few, or all."""
    worst = {one.number: one for one in sorted(inspection.closures, key=lambda one: one.opening)}
    names = ("impedance", "omega", "decay", "force", "opening", "now")
    rows = [
        [f"{one.name} ({one.kind})", *(getattr(one, name) for name in names)]
        for one in inspection.closures
        if one is worst[one.number]
    ]
    most = len(rows) if full else EFFORT.closures
    heads = ["closure", "impedance", "omega [1/s]", "decay [1/s]", "load", "opens by", "open now"]
    more = [f"... {len(rows) - most} more, with --full"] if len(rows) > most else []
    if rows:
        yield Section("", heads, rows[:most], more, digits=4)


def print_rule(console: Console, name: str) -> None:
    """Print the texts of a rule: meaning, reason, remedy, and how it is waived."""
    rule = RULES[name]
    lines = [rule.why, f"fix: {rule.fix}"]
    lines += ["a rule of the house: evaluated with --strict or --select"] * rule.house
    lines.append(f"waiver in the file: <!-- mbcheck: allow {name}, ELEMENT: REASON -->")
    print_sections(console, [Section(f"{name} ({rule.severity}): {rule.meaning}", lines=lines)])
