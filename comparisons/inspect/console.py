"""An inspection on the console."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from rich.console import Console

from ..reports.item import LEVELS, Level, ReportItem
from ..reports.sections import Section, print_sections
from ..reports.text import STYLES, print_line, print_table, print_unbroken
from ..reports.words import number, plural
from .batch import Inspections, omissions
from .inspection import Inspection
from .mujoco.facts import BodyFacts, JointFacts
from .mujoco.model import ENGINE
from .mujoco.trial import MOST_STEPS
from .rules.stability import SLOWEST
from .rules.table import RULES
from .subject import View

FEW_CLOSURES, FEW_MODES, FEW_RULES, FEW_ROWS, FEW_STATES = 3, 4, 4, 5, 2
"""How many of these a short report has; rows are those of the tree of bodies."""

DEEPEST = 5
"""Levels of a tree that are indented."""

REST = 1e-6
"""Largest acceleration [rad/s^2, m/s^2] of a state that is called at rest."""

UNSTABLE = (
    "what is unstable here is no finding: contacts, limits or constant forces hold this state, it "
    f"grows by less than {SLOWEST:g} 1/s, or a run of {MOST_STEPS} steps does not show it"
)
"""What is said of modes that grow and that no rule speaks of."""

SINGULAR = {"bodies": "body", "equalities": "equality", "meshes": "mesh", "flexes": "flex"}

VERDICTS: Mapping[Level, str] = {"error": "error", "warning": "known", "note": ""}
"""The verdict in whose style a severity is printed."""


def print_inspection(
    console: Console, inspection: Inspection, full: bool = True, fail_on: str = "error"
) -> None:
    """Print findings, then how the model moves and, if it is short or ``full``, what is in it."""
    every = Inspections((inspection.as_json(),))
    sections = [facts_section(inspection), *finding_sections(every.items(fail_on), full)]
    if inspection.untried is not None:
        sections.append(Section(lines=[f"repeated_default: {inspection.untried}"]))
    rows = [row for body in inspection.facts.bodies for row in body_rows(body)]
    if rows and (full or len(rows) <= FEW_ROWS):
        heads = ["body", "joints", "mass [kg]", "inertia [kg m^2]"]
        sections.append(Section("", heads, rows, digits=5))
    with_modes_first = sorted(inspection.views, key=lambda view: view.linear is None)
    views = inspection.views if full else with_modes_first[:FEW_STATES]
    sections += [view_section(inspection, view, full) for view in views]
    if more := len(inspection.views) - len(views):
        sections.append(Section(lines=[f"... {more} states more, with --full"]))
    sections += [*steps_section(inspection), *closures_section(inspection, full)]
    if words := omissions(inspection.left_out):
        sections.append(Section(lines=[words]))
    print_sections(console, sections)
    print_verdict(console, every, fail_on)


def print_lines(console: Console, every: Inspections, fail_on: str) -> None:
    """Print a line for each finding of several files, and one that counts them."""
    for item in every.items(fail_on):
        if item.severity:
            print_unbroken(console, item.text)
    for one in every.models:
        if words := omissions(one["left_out"]):
            print_line(console, f"{one['file']}: {words}")
    print_verdict(console, every, fail_on)


def print_verdict(console: Console, every: Inspections, fail_on: str) -> None:
    """Print one line that counts findings."""
    worst = (STYLES.get(VERDICTS[name], "cyan") for name in LEVELS if every.summary[name])
    print_line(console, every.verdict(fail_on), next(worst, STYLES["pass"]))


def finding_sections(items: Sequence[ReportItem], full: bool) -> Iterator[Section]:
    """Yield the findings, errors first; the first ones of few rules, or all."""
    rules = dict[str, list[ReportItem]]()
    for item in items:
        if item.severity:
            rules.setdefault(item.rule, []).append(item)
    listed = list(rules) if full else list(rules)[:FEW_RULES]
    for rule in listed:
        most = len(rules[rule]) if full else 1
        for item in rules[rule][:most]:
            title = f"{item.severity} {item.id} ({item.place})"
            verdict = VERDICTS[item.severity or "note"]
            yield Section(title, lines=[item.message, *item.details], verdict=verdict)
        if more := len(rules[rule]) - most:
            yield Section(lines=[f"... and {more} more of {rule}"])
    if left := list(rules)[len(listed) :]:
        yield Section(lines=[f"... and of {', '.join(left)}, with --full"])
    if rules:
        first = next(iter(rules))
        yield Section(lines=[f"mbcheck inspect --explain {first} tells why that matters"])


def findings_table(items: Sequence[ReportItem]) -> Section:
    """Return the findings as a table."""
    heads = ("severity", "rule", "where", "what")
    rows = [
        (item.severity, item.rule, item.place, "; ".join((item.message, *item.details)))
        for item in items
        if item.severity
    ]
    return Section("", heads, rows)


def facts_section(inspection: Inspection) -> Section:
    """Return size, mass and options of the model."""
    facts, options = inspection.facts, inspection.facts.options
    included = len(inspection.files) - 1
    more = f" and {included} included" if included else ""
    name = f"{facts.name}: " if facts.name else ""
    counts = ", ".join(
        f"{count} {SINGULAR.get(name, name.removesuffix('s')) if count == 1 else name}"
        for name, count in facts.counts.items()
        if count and name not in ("nq", "nv")
    )
    positions = plural(facts.counts["nq"], "position")
    dofs = f"{plural(facts.counts['nv'], 'degree')} of freedom ({positions})"
    solver = (
        f"{options.solver} ({options.iterations} iterations, tolerance {number(options.tolerance)})"
    )
    gravity = " ".join(number(x, 6) for x in options.gravity) if any(options.gravity) else "off"
    flags = {"contact": options.contact, "energy": options.energy, "auto-reset": options.autoreset}
    switches = ", ".join(f"{name} {'on' if on else 'off'}" for name, on in flags.items())
    return Section(
        f"{name}{inspection.file}{more}, MuJoCo {inspection.versions[ENGINE]}",
        lines=[
            f"{dofs}, {counts or 'no bodies'}; mass {number(facts.mass, 6)} kg",
            f"{options.integrator}, timestep {number(options.timestep, 10)} s; solver {solver}; "
            f"gravity {gravity}; {switches}",
        ],
    )


def body_rows(body: BodyFacts) -> Iterator[list[object]]:
    """Yield the rows of a body: one, and one more for each further joint."""
    indent = "  " * min(body.depth, DEEPEST) + ("> " if body.depth > DEEPEST else "")
    values = body.inertia[:1] if len(set(body.inertia)) == 1 else body.inertia
    first, *others = [joint_words(joint) for joint in body.joints] or ["(welded)"]
    yield [f"{indent}{body.name}", first, body.mass, " ".join(number(value, 4) for value in values)]
    for words in others:
        yield ["", words, None, ""]


def joint_words(joint: JointFacts) -> str:
    """Return a joint in a line."""
    kind = joint.kind if joint.axis is None else f"{joint.kind} {axis_word(joint.axis)}"
    values = {"k": joint.stiffness, "c": joint.damping, "armature": joint.armature}
    parts = [kind, *(f"{symbol} {number(value, 4)}" for symbol, value in values.items() if value)]
    if joint.range is not None:
        parts.append(" to ".join(number(value, 4) for value in joint.range))
    return f"{joint.name}: {', '.join(parts)}"


def axis_word(axis: Sequence[float]) -> str:
    """Return an axis by its letter if it is one of the frame's, else by its numbers."""
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
    words += [f"{kinds.count(kind)} {kind}" for kind in ("rigid", "unstable") if kind in kinds]
    words += [f"{plural(linear.closed, 'direction')} closed by loops"] if linear.closed else []
    ignored = {"contact": linear.rows.contacts, "limit": linear.rows.limits}
    words += [f"{plural(count, noun)} left out" for noun, count in ignored.items() if count]
    rest = float(max(abs(linear.acceleration), default=0.0))
    fast = f"does not rest here (accelerates by {number(rest)}; held by constant forces)"
    if view.steady_hinge is not None:
        words.append(f"{view.steady_hinge} held at its speed")
    else:
        words.append(fast if rest >= REST else "at rest")
    rows: list[list[object]] = [
        [
            mode.omega,
            mode.omega / (2 * math.pi),
            mode.damping_ratio,
            mode.rate.real,
            inspection.place(mode, linear),
            mode.kind if mode.kind == "unstable" else "",
        ]
        for mode in sorted(view.modes, key=lambda mode: (mode.kind != "unstable", -mode.omega))
        if mode.kind != "rigid"
    ]
    if len(rows) > FEW_MODES and not full:
        more = f"... {len(rows) - FEW_MODES} more"
        rows[FEW_MODES - 1 : -1] = [[None, None, None, None, more, ""]]
    lines = [", ".join(words)]
    named = (repr(view.state.name) in one.message for one in inspection.findings)
    about_growth = (one.rule.startswith("unstable") for one in inspection.findings)
    if "unstable" in kinds and not (any(named) or any(about_growth)):
        lines.append(UNSTABLE)
    heads = ["omega [rad/s]", "[Hz]", "damping ratio", "re [1/s]", "most in", ""]
    return Section(f"state {view.state.name}", heads, rows, lines, digits=6)


def steps_section(inspection: Inspection) -> Iterator[Section]:
    """Yield the largest stable step of each integrator, and what limits it."""
    if not inspection.steps:
        return
    step, period = inspection.facts.options.timestep, inspection.shortest_period
    heads = ["integrator", "largest stable step [s]", "timestep / it", "set by [1/s]", "in"]
    heads += ["state"] if len(inspection.views) > 1 else []
    rows = [
        [
            f"{one.integrator}{' (file)' if one.of_file else ''}",
            "no limit" if math.isinf(one.limit) else number(one.limit, 4),
            "" if math.isinf(one.limit) or not one.limit else number(step / one.limit, 2),
            number(one.omega, 4, missing=""),
            one.place if one.joint else "",
            one.state or "",
        ][: len(heads)]
        for one in inspection.steps
    ]
    lines = list(conditions_of(inspection))
    softened = next((one.softened for one in inspection.steps if one.of_file), math.inf)
    if any(softened < one.limit for one in inspection.steps):
        words = f"steps above {number(softened, 4)} s soften constraints (refsafe)"
        lines.append(f"{words}: runs of another mechanism")
    if period is not None:
        per_period = number(period / step, 4)
        lines.append(f"{per_period} steps in the shortest period, {number(period, 4)} s")
    yield Section("", heads, rows, lines)


def conditions_of(inspection: Inspection) -> Iterator[str]:
    """Yield the limits of validity of the largest stable steps, what they leave out first."""
    loaded, model = inspection.loaded, inspection.loaded.model
    left_out = [f"the state {one.state.name}" for one in inspection.views if one.linear is None]
    joints = [name for one in inspection.views for name in loaded.at_limits(one.state)]
    if first := list(dict.fromkeys(joints)):
        more = f" and {plural(len(first) - 1, 'more joint')}" if len(first) > 1 else ""
        left_out.append(f"limits at which joints stand ({first[0]}{more})")
    left_out += ["what plugins keep"] if model.nplugin else []
    for kind, words in (("muscle", "activations of muscles"), ("user", "activations of a user's")):
        left_out += [words] if any(loaded.of_kind("actuator_dyntype", kind)) else []
    if left_out:
        yield f"left out of these limits: {', '.join(left_out)}"
    apart = [
        one.state.name for one in inspection.views if one.linear and not one.linear.rows.contacts
    ]
    if apart and any(inspection.can_touch):
        yield (
            f"no contact is active in the state {', '.join(apart)}: what touches later may need "
            "shorter steps"
        )
    dry = any(model.dof_frictionloss) or any(model.tendon_frictionloss)
    if dry and not (loaded.disabled("frictionloss") or loaded.disabled("constraint")):
        yield "dry friction makes these limits conservative: it may hold a run beyond them"


def closures_section(inspection: Inspection, full: bool) -> Iterator[Section]:
    """Yield the closures where they open most, the stiffest first; few of them or all."""
    worst = {one.number: one for one in sorted(inspection.closures, key=lambda one: one.opening)}
    names = ("impedance", "omega", "decay", "force", "opening", "now")
    rows = [
        [f"{one.name} ({one.kind})", *(getattr(one, name) for name in names)]
        for one in inspection.closures
        if one is worst[one.number]
    ]
    most = len(rows) if full else FEW_CLOSURES
    heads = ["closure", "impedance", "omega [1/s]", "decays [1/s]", "load", "opens by", "open now"]
    more = [f"... {len(rows) - most} more, with --full"] if len(rows) > most else []
    if rows:
        yield Section("", heads, rows[:most], more, digits=4)


def print_rule(console: Console, name: str) -> None:
    """Print the meaning of a rule, why it matters, and what to do."""
    rule = RULES[name]
    lines = [rule.why, f"fix: {rule.fix}"]
    lines += ["a rule of the house: looked for with --strict, or --select"] * rule.house
    lines.append(f"waive it in the file: <!-- mbcheck: allow {name}, ELEMENT: REASON -->")
    print_sections(console, [Section(f"{name} ({rule.severity}): {rule.meaning}", lines=lines)])


def print_rules(console: Console) -> None:
    """Print all rules."""
    rows = [
        [name, rule.severity, "strict" if rule.house else "default", rule.meaning]
        for name, rule in RULES.items()
    ]
    print_table(console, ["rule", "severity", "profile", "finds"], rows)
