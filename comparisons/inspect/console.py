"""An inspection on the console."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from rich.console import Console
from rich.text import Text

from ..reports.remarks import remark_lines
from ..reports.text import STYLES, encodable, print_line, print_table, print_wrapped
from ..reports.words import number, plural
from .batch import Inspections, omissions
from .difference import ModelDifference
from .inspection import Inspection
from .mujoco.facts import BodyFacts, Facts, JointFacts
from .mujoco.model import ENGINE
from .mujoco.trial import MOST_STEPS
from .rules.stability import SLOWEST
from .rules.table import RULES
from .subject import SEVERITIES, Severity, View

MOST_BODIES = 24
"""A longer tree is printed by its beginning and end; JSON has all of it."""

MOST_MODES = 12
"""Modes of a state that are printed: the fastest, and the slowest of all."""

MOST_CLOSURES = 6
FEW_CLOSURES, FEW_MODES, FEW_RULES, FEW_ROWS, FEW_STATES = 3, 4, 4, 5, 2
"""What a short report has of these; rows are those of the tree of bodies."""

DEEPEST = 5
"""Levels of a tree that are indented."""

MOST_ALIKE = 3
"""Findings of one rule that are printed one by one."""

REST = 1e-6
"""Largest acceleration [rad/s^2, m/s^2] of what is called at rest."""

UNSTABLE = (
    "what is unstable here is no finding: contacts, limits or constant forces hold this state, it "
    f"grows by less than {SLOWEST:g} 1/s, or a run of {MOST_STEPS} steps does not show it"
)
"""What is said of modes that grow and that no rule speaks of."""

SINGULAR = {"bodies": "body", "equalities": "equality", "meshes": "mesh", "flexes": "flex"}

COLOURS: Mapping[Severity, str] = {
    "error": STYLES["error"],
    "warning": STYLES["known"],
    "note": "cyan",
}


def print_inspection(
    console: Console, inspection: Inspection, full: bool = True, fail_on: str = "error"
) -> None:
    """Print findings, then how the model moves and, if it is short or ``full``, what is in it."""
    print_facts(console, inspection)
    print_findings(console, inspection, full)
    rows = sum(max(1, len(body.joints)) for body in inspection.facts.bodies)
    if full or rows <= FEW_ROWS:
        print_bodies(console, inspection.facts)
    views = inspection.views if full else calling_for_attention(inspection.views)
    for view in views:
        print_view(console, inspection, view, MOST_MODES if full else FEW_MODES)
    if len(inspection.views) > len(views):
        print_line(console, f"... {len(inspection.views) - len(views)} states more, with --full")
    print_steps(console, inspection)
    print_closures(console, inspection, MOST_CLOSURES if full else FEW_CLOSURES)
    if words := omissions(inspection.left_out):
        print_wrapped(console, words)
    print_verdict(console, Inspections((inspection.as_json(),)), fail_on)


def calling_for_attention(views: Sequence[View]) -> Sequence[View]:
    """Return few states: those that have modes, before the others."""
    return sorted(views, key=lambda view: view.linear is None)[:FEW_STATES]


def print_lines(console: Console, every: Inspections, fail_on: str) -> None:
    """Print a line for each finding of several files, and one that counts them."""
    for line in remark_lines(every.remarks()):
        print_line(console, line)
    for one in every.models:
        if words := omissions(one["left_out"]):
            print_line(console, f"{one['file']}: {words}")
    print_verdict(console, every, fail_on)


def print_verdict(console: Console, every: Inspections, fail_on: str) -> None:
    """Print one line that counts findings."""
    worst = (COLOURS[name] for name in SEVERITIES if every.summary[name])
    print_line(console, every.verdict(fail_on), next(worst, STYLES["pass"]))


def print_facts(console: Console, inspection: Inspection) -> None:
    """Print what the model is and how it is simulated."""
    facts, options = inspection.facts, inspection.facts.options
    included = len(inspection.files) - 1
    more = f" and {included} included" if included else ""
    name = f"{facts.name}: " if facts.name else ""
    print_line(console, f"{name}{inspection.file}{more}, MuJoCo {inspection.versions[ENGINE]}")
    counts = ", ".join(
        f"{count} {SINGULAR.get(name, name.removesuffix('s')) if count == 1 else name}"
        for name, count in facts.counts.items()
        if count and name not in ("nq", "nv")
    )
    positions = plural(facts.counts["nq"], "position")
    dofs = f"{plural(facts.counts['nv'], 'degree')} of freedom ({positions})"
    print_wrapped(console, f"{dofs}, {counts or 'no bodies'}; mass {number(facts.mass, 6)} kg")
    solver = (
        f"{options.solver} ({options.iterations} iterations, tolerance {number(options.tolerance)})"
    )
    gravity = " ".join(number(x, 6) for x in options.gravity) if any(options.gravity) else "off"
    flags = {"contact": options.contact, "energy": options.energy, "auto-reset": options.autoreset}
    switches = ", ".join(f"{name} {'on' if on else 'off'}" for name, on in flags.items())
    print_wrapped(
        console,
        f"{options.integrator}, timestep {number(options.timestep, 10)} s; solver {solver}; "
        f"gravity {gravity}; {switches}",
    )


def print_bodies(console: Console, facts: Facts) -> None:
    """Print the tree of bodies: its beginning and end, if it is long."""
    rows = [list(body_rows(body)) for body in facts.bodies]
    hidden = len(rows) - MOST_BODIES * 3 // 4
    if len(rows) > MOST_BODIES:
        rows[MOST_BODIES // 2 : -MOST_BODIES // 4] = [[[f"... {hidden} more", "", None, ""]]]
    if rows:
        heads = ["body", "joints", "mass [kg]", "inertia [kg m^2]"]
        print_table(console, heads, [row for each in rows for row in each], digits=5)


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


def print_view(
    console: Console, inspection: Inspection, view: View, most: int = MOST_MODES
) -> None:
    """Print a state with so many of its modes, the fastest first."""
    linear = view.linear
    if linear is None:
        print_line(console, f"state {view.state.name}: no modes, {view.reason}")
        return
    kinds = [mode.kind for mode in view.modes]
    counts = {
        "mode": len(kinds),
        "direction": linear.closed,
        "contact": linear.contacts,
        "limit": linear.limits,
    }
    said = {"direction": " closed by loops", "contact": " left out", "limit": " left out"}
    parts = {
        noun: f"{plural(count, noun)}{said.get(noun, '')}"
        for noun, count in counts.items()
        if count or noun == "mode"
    }
    words = [parts.pop("mode")]
    words += [f"{kinds.count(kind)} {kind}" for kind in ("rigid", "unstable") if kind in kinds]
    words += parts.values()
    rest = float(max(abs(linear.acceleration), default=0.0))
    if view.steady_hinge is not None:
        words.append(f"{view.steady_hinge} held at its speed")
    else:
        fast = f"does not rest here (accelerates by {number(rest)}; held by constant forces)"
        words.append(fast if rest >= REST else "at rest")
    print_wrapped(console, f"state {view.state.name}: {', '.join(words)}")
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
    if len(rows) > most:
        more = f"... {len(rows) - most} more"
        rows[most - 1 : -1] = [[None, None, None, None, more, ""]]
    if rows:
        heads = ["omega [rad/s]", "[Hz]", "damping ratio", "re [1/s]", "most in", ""]
        print_table(console, heads, rows, digits=6)
    if "unstable" in kinds and not speaks_of(inspection, view):
        print_wrapped(console, UNSTABLE)


def speaks_of(inspection: Inspection, view: View) -> bool:
    """Return whether a finding is about growth, or about a state."""
    return any(
        one.rule.startswith("unstable") or repr(view.state.name) in one.message
        for one in inspection.findings
    )


def print_steps(console: Console, inspection: Inspection) -> None:
    """Print the largest stable step of each integrator."""
    step, period = inspection.facts.options.timestep, inspection.shortest_period
    heads = ["integrator", "largest stable step [s]", "timestep / it", "set by [1/s]", "in"]
    rows: list[list[object]] = [
        [
            f"{one.integrator}{' (file)' if one.of_file else ''}",
            "no limit" if math.isinf(one.limit) else number(one.limit, 4),
            "" if math.isinf(one.limit) or not one.limit else number(step / one.limit, 2),
            number(one.omega, 4, missing=""),
            one.place if one.joint else "",
            one.state or "",
        ]
        for one in inspection.steps
    ]
    if len(inspection.views) > 1:
        heads.append("state")
    if rows:
        print_table(console, heads, [row[: len(heads)] for row in rows])
    left_out = [f"the state {one.state.name}" for one in inspection.views if one.linear is None]
    every = (name for one in inspection.views for name in inspection.loaded.at_limits(one.state))
    joints = list(dict.fromkeys(every))
    if joints:
        more = f" and {plural(len(joints) - 1, 'more joint')}" if len(joints) > 1 else ""
        left_out.append(f"limits at which joints stand ({joints[0]}{more})")
    left_out += ["what plugins keep"] if inspection.loaded.model.nplugin else []
    for kind, words in (("muscle", "activations of muscles"), ("user", "activations of a user's")):
        left_out += [words] if any(inspection.loaded.of_kind("actuator_dyntype", kind)) else []
    if rows and left_out:
        print_wrapped(console, f"left out of these limits: {', '.join(left_out)}")
    for words in conditions_of(inspection) if rows else ():
        print_wrapped(console, words)
    softened = next((one.softened for one in inspection.steps if one.of_file), math.inf)
    if any(softened < one.limit for one in inspection.steps) and softened < math.inf:
        words = f"steps above {number(softened, 4)} s soften constraints (refsafe)"
        print_wrapped(console, f"{words}: runs of another mechanism")
    if rows and period is not None:
        print_line(
            console,
            f"{number(period / step, 4)} steps in the shortest period, {number(period, 4)} s",
        )


def conditions_of(inspection: Inspection) -> Iterator[str]:
    """Yield the limits of validity of the largest stable steps: contacts and dry friction."""
    model, disabled = inspection.loaded.model, inspection.loaded.disabled
    apart = [one.state.name for one in inspection.views if one.linear and not one.linear.contacts]
    if apart and any(inspection.can_touch):
        yield (
            f"no contact is active in the state {', '.join(apart)}: what touches later may need "
            "shorter steps"
        )
    dry = any(model.dof_frictionloss) or any(model.tendon_frictionloss)
    if dry and not (disabled("frictionloss") or disabled("constraint")):
        yield "dry friction makes these limits conservative: it may hold a run beyond them"


def print_closures(console: Console, inspection: Inspection, most: int = MOST_CLOSURES) -> None:
    """Print the closures where they open most, the stiffest first."""
    worst = {one.number: one for one in sorted(inspection.closures, key=lambda one: one.opening)}
    rows = [
        [
            f"{one.name} ({one.kind})",
            one.impedance,
            one.omega,
            one.decay,
            one.force,
            one.opening,
            one.now,
        ]
        for one in inspection.closures
        if one is worst[one.number]
    ]
    heads = ["closure", "impedance", "omega [1/s]", "decays [1/s]", "load", "opens by", "open now"]
    if rows:
        print_table(console, heads, rows[:most], digits=4)
    if len(rows) > most:
        print_line(console, f"... {len(rows) - most} more, in --json")


def print_findings(console: Console, inspection: Inspection, full: bool) -> None:
    """Print the findings, errors first."""
    rules = list(dict.fromkeys(one.rule for one in inspection.unwaived))
    listed = rules if full else rules[:FEW_RULES]
    console.print()
    for rule in listed:
        same = [one for one in inspection.unwaived if one.rule == rule]
        most = MOST_ALIKE if full else 1
        for one in same[:most]:
            place = "" if one.line is None else f" ({one.file}:{one.line})"
            severity = (one.severity, COLOURS[one.severity])
            words = encodable(f" {rule} {one.element}{place}", console)
            console.print(Text.assemble(severity, words), soft_wrap=True)
            print_wrapped(console, one.message, indent="    ")
        if len(same) > most:
            print_line(console, f"    ... and {len(same) - most} more of {rule}")
        print_wrapped(console, f"fix: {same[0].fix}", indent="    ")
    if len(rules) > len(listed):
        print_line(console, f"... and of {', '.join(rules[len(listed) :])}, with --full")
    if inspection.untried is not None:
        print_line(console, f"repeated_default: {inspection.untried}")
    if rules:
        print_line(console, f"mbcheck inspect --explain {rules[0]} tells why that matters")
        console.print()


def print_difference(console: Console, result: ModelDifference) -> None:
    """Print what differs between two models."""
    if not result:
        print_line(console, "nothing differs", STYLES["pass"])
    if result.rows:
        print_table(console, ["what", "before", "now"], result.rows)
    for word, listed in (("new", result.new), ("gone", result.gone)):
        for one in listed:
            severity = (one.severity, COLOURS[one.severity])
            text = encodable(f" {one.rule} {one.element}: {one.message}", console)
            console.print(Text.assemble(f"{word}: ", severity, text), soft_wrap=True)


def print_rule(console: Console, name: str) -> None:
    """Print what a rule is, why it matters, and what to do."""
    rule = RULES[name]
    print_line(console, f"{name} ({rule.severity}): {rule.meaning}")
    if rule.house:
        print_line(console, "    a rule of the house: looked for with --strict, or --select")
    waiver = f"<!-- mbcheck: allow {name}, ELEMENT: REASON -->"
    for text in (rule.why, f"fix: {rule.fix}", f"waive it in the file: {waiver}"):
        print_wrapped(console, text, indent="    ")


def print_rules(console: Console) -> None:
    """Print all rules."""
    rows = [
        [name, rule.severity, "strict" if rule.house else "default", rule.meaning]
        for name, rule in RULES.items()
    ]
    print_table(console, ["rule", "severity", "profile", "finds"], rows)
