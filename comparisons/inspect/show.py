"""An inspection on the console."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rich.console import Console
from rich.text import Text

from ..reports.console import STYLES, print_line, print_wrapped
from ..reports.table import print_table
from .findings.rules import ALL
from .mujoco.mujoco_closures import Closure
from .mujoco.mujoco_facts import Body, Facts
from .report import REST, Inspection
from .subject import Severity, View

MOST_BODIES = 24
"""A longer tree is shown by its beginning and end; JSON has all of it."""

MOST_MODES = 12
"""Modes of a state that are shown: the slowest, and the fastest of all."""

MOST_CLOSURES = 6
DEEPEST = 5
"""Levels of a tree that are indented."""

MOST_ALIKE = 3
"""Findings of one rule that are shown one by one."""

COLOURS: dict[Severity, str] = {
    "error": STYLES["error"],
    "warning": STYLES["known"],
    "note": "cyan",
}


def print_inspection(console: Console, found: Inspection) -> None:
    """Print what was found: tree, states, steps, closures, findings, and one line of summary."""
    print_facts(console, found)
    print_bodies(console, found.facts)
    for view in found.views:
        print_view(console, found, view)
    print_steps(console, found)
    print_closures(console, found)
    print_findings(console, found)


def print_facts(console: Console, found: Inspection) -> None:
    """Print what the model is and how it is simulated."""
    facts, options = found.facts, found.facts.options
    more = f" and {len(found.files) - 1} included" if len(found.files) > 1 else ""
    name = f"{facts.name}: " if facts.name else ""
    print_line(console, f"{name}{found.file}{more}, MuJoCo {found.versions['mujoco']}")
    counts = ", ".join(
        f"{count} {singular(name) if count == 1 else name}"
        for name, count in facts.counts.items()
        if count and name not in ("nq", "nv")
    )
    dofs = f"{facts.counts['nv']} degrees of freedom ({facts.counts['nq']} positions)"
    print_wrapped(console, f"{dofs}, {counts or 'no bodies'}; mass {facts.mass:.6g} kg")
    solver = f"{options.solver} ({options.iterations} iterations, tolerance {options.tolerance:g})"
    gravity = " ".join(f"{value:g}" for value in options.gravity) if any(options.gravity) else "off"
    print_wrapped(
        console,
        f"{options.integrator}, timestep {options.timestep:.10g} s; solver {solver}; gravity "
        f"{gravity}; contact {on(options.contact)}, energy {on(options.energy)}, auto-reset "
        f"{on(options.autoreset)}",
    )


def on(flag: bool) -> str:
    """Return the word for a flag."""
    return "on" if flag else "off"


def singular(name: str) -> str:
    """Return the name of one of the things that a count is of."""
    special = {"bodies": "body", "equalities": "equality", "meshes": "mesh", "flexes": "flex"}
    return special.get(name, name.removesuffix("s"))


def print_bodies(console: Console, facts: Facts) -> None:
    """Print the tree of bodies: its beginning and end, if it is long."""
    bodies: Sequence[Body | None] = facts.bodies
    if len(bodies) > MOST_BODIES:
        half = MOST_BODIES // 2
        bodies = [*facts.bodies[:half], None, *facts.bodies[-half // 2 :]]
    hidden = len(facts.bodies) - len(bodies) + 1
    rows = [
        row
        for body in bodies
        for row in ([[f"... {hidden} more", "", None, ""]] if body is None else body_rows(body))
    ]
    if rows:
        print_table(console, ["body", "joints", "mass [kg]", "inertia [kg m^2]"], rows, digits=5)


def body_rows(body: Body) -> Iterator[list[object]]:
    """Yield the rows of a body: one, and one more for each further joint."""
    indent = "  " * min(body.depth, DEEPEST) + ("> " if body.depth > DEEPEST else "")
    equal = len(set(body.inertia)) == 1
    inertia = " ".join(f"{value:.4g}" for value in (body.inertia[:1] if equal else body.inertia))
    joints = [joint_words(joint) for joint in body.joints] or ["(welded)"]
    yield [f"{indent}{body.name}", joints[0], body.mass, inertia]
    for words in joints[1:]:
        yield ["", words, None, ""]


def joint_words(joint: object) -> str:
    """Return a joint in a line."""
    values = vars(joint)
    axis = "" if values["axis"] is None else " " + "".join(axis_word(values["axis"]))
    parts = [
        f"{symbol} {values[name]:.4g}"
        for name, symbol in (("stiffness", "k"), ("damping", "c"), ("armature", "armature"))
        if values[name]
    ]
    if values["range"] is not None:
        parts.append("{:.4g} to {:.4g}".format(*values["range"]))
    return f"{values['name']}: {values['kind']}{axis}" + (f", {', '.join(parts)}" if parts else "")


def axis_word(axis: Sequence[float]) -> str:
    """Return an axis by its letter if it is one of the frame's, else by its numbers."""
    for letter, value, rest in zip(
        "xyz", axis, (axis[1:], (axis[0], axis[2]), axis[:2]), strict=True
    ):
        if abs(abs(value) - 1) < 1e-9 and not any(abs(other) > 1e-9 for other in rest):
            return letter if value > 0 else f"-{letter}"
    return "(" + " ".join(f"{value:.3g}" for value in axis) + ")"


def print_view(console: Console, found: Inspection, view: View) -> None:
    """Print a state with its modes."""
    if view.linear is None:
        print_line(console, f"state {view.state.name}: no modes, {view.reason}")
        return
    linear = view.linear
    kinds = [mode.kind for mode in view.modes]
    words = [f"{len(kinds)} modes"]
    words += [f"{kinds.count(kind)} {kind}" for kind in ("rigid", "unstable") if kinds.count(kind)]
    if linear.closed:
        words.append(f"{linear.closed} directions closed by loops")
    for count, what in ((linear.contacts, "contacts"), (linear.limits, "limits")):
        if count:
            words.append(f"{count} {what} act, and are left out")
    rest = float(max(abs(linear.acceleration), default=0.0))
    if view.held is not None:
        words.append(f"{view.held} held at its speed")
    elif rest >= REST:
        words.append(f"does not rest here (accelerates by {rest:.3g})")
    else:
        words.append("at rest")
    print_wrapped(console, f"state {view.state.name}: {', '.join(words)}")
    shown = [mode for mode in view.modes if mode.kind != "rigid"]
    cut = len(shown) > MOST_MODES
    chosen = [*shown[: MOST_MODES - 1], shown[-1]] if cut else shown
    rows: list[list[object]] = [
        [
            mode.omega,
            mode.omega / (2 * math.pi),
            mode.damping_ratio,
            mode.rate.real,
            found.place(mode, linear),
            mode.kind if mode.kind == "unstable" else "",
        ]
        for mode in chosen
    ]
    if cut:
        rows.insert(-1, [None, None, None, None, f"... {len(shown) - MOST_MODES} more", ""])
    if rows:
        heads = ["omega [rad/s]", "[Hz]", "damping ratio", "re [1/s]", "most in", ""]
        print_table(console, heads, rows, digits=6)


def print_steps(console: Console, found: Inspection) -> None:
    """Print the largest stable step of each integrator."""
    if not found.steps:
        return
    step = found.facts.options.timestep
    rows = [
        [
            f"{one.integrator}{' (file)' if one.chosen else ''}",
            "any" if math.isinf(one.limit) else f"{one.limit:.4g}",
            "" if math.isinf(one.limit) or not one.limit else f"{step / one.limit:.2g}",
            "" if one.omega is None else f"{one.omega:.4g}",
            one.joint or "",
            "" if len(found.views) == 1 else (one.state or ""),
        ]
        for one in found.steps
    ]
    heads = [
        "integrator",
        "largest stable step [s]",
        "timestep / it",
        "set by [1/s]",
        "in",
        "state",
    ]
    print_table(
        console,
        heads if len(found.views) > 1 else heads[:-1],
        [r[: len(heads) - (len(found.views) == 1)] for r in rows],
    )
    if found.shortest_period is not None:
        per = found.shortest_period / step
        print_line(
            console, f"{per:.4g} steps in the shortest period, {found.shortest_period:.4g} s"
        )


def print_closures(console: Console, found: Inspection) -> None:
    """Print the closures where they open most, the stiffest first."""
    if not found.closures:
        return
    worst: dict[int, Closure] = {}
    for one in found.closures:
        if one.number not in worst or one.opening > worst[one.number].opening:
            worst[one.number] = one
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
        for one in list(worst.values())[:MOST_CLOSURES]
    ]
    heads = ["closure", "impedance", "omega [1/s]", "decays [1/s]", "load", "opens by", "open now"]
    print_table(console, heads, rows, digits=4)
    if len(worst) > MOST_CLOSURES:
        print_line(console, f"... {len(worst) - MOST_CLOSURES} more, in --json")


def print_findings(console: Console, found: Inspection) -> None:
    """Print the findings, errors first, and one line of summary."""
    unwaived = found.unwaived
    rules = list(dict.fromkeys(one.rule for one in unwaived))
    if rules:
        console.print()
    for rule in rules:
        same = [one for one in unwaived if one.rule == rule]
        for one in same[:MOST_ALIKE]:
            place = "" if one.line is None else f" ({one.file}:{one.line})"
            head = Text.assemble(
                (one.severity, COLOURS[one.severity]), f" {rule} {one.element}{place}"
            )
            console.print(head, soft_wrap=True)
            print_wrapped(console, one.message, indent="    ")
        if len(same) > MOST_ALIKE:
            print_line(console, f"    ... and {len(same) - MOST_ALIKE} more of {rule}")
        print_wrapped(console, f"fix: {same[0].fix}", indent="    ")
    if found.untried is not None:
        print_line(console, f"repeated_default: {found.untried}")
    counts = found.summary
    words = [
        f"{counts[name]} {name}{'' if counts[name] == 1 else 's'}"
        for name in ("error", "warning", "note")
    ]
    if counts["waived"]:
        words.append(f"{counts['waived']} waived in the file")
    worst: Severity = next((n for n in COLOURS if counts[n]), "note")
    style = COLOURS[worst] if any(counts[n] for n in COLOURS) else STYLES["pass"]
    if rules:
        print_line(console, f"mbcheck inspect --explain {rules[0]} tells why that matters")
    print_line(console, f"{'FAIL' if found.exit_code else 'OK'}: {', '.join(words)}", style)


def print_rule(console: Console, name: str) -> None:
    """Print what a rule is, why it matters, and what to do."""
    rule = ALL[name]
    print_line(console, f"{name} ({rule.severity}): {rule.meaning}")
    print_wrapped(console, rule.why, indent="    ")
    print_wrapped(console, f"fix: {rule.fix}", indent="    ")
    waiver = f"<!-- mbcheck: allow {name}, ELEMENT: REASON -->"
    print_wrapped(console, f"waive it in the file: {waiver}", indent="    ")


def print_rules(console: Console) -> None:
    """Print all rules."""
    rows = [[name, rule.severity, rule.meaning] for name, rule in ALL.items()]
    print_table(console, ["rule", "severity", "finds"], rows)
