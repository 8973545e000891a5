"""The verdict on a trajectory that was computed elsewhere."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from rich.console import Console

from ...reference import SCENES, get_scene
from ...reference.errors import EngineError, UnknownNameError, UsageError
from ...reference.scene import Case, Scene
from ..checks.tolerances import rounding
from ..checks.verdict import PROFILES, Finding, Result, Series, Subject, Verdict, judge
from ..queries.api import Report, consistent, document, environment, number, versions
from ..reports import report
from ..reports.tables import assignments, show, table
from .comparison import Comparison, compared, refuse_outside
from .method_error import METHOD_SPREAD, SCHEMES_OF
from .recording import Recording, recording
from .slips import mistakes

FILE = "file"
"""What stands for the method in ids."""

DRAWN = 800
"""Samples of a trajectory that are kept for pictures."""

HARMLESS = 1e3
"""Growth up to which an error is not taken for that of a start."""

CHAOS = "what looks like a fault late in the run may be a small error that has grown."

MOST_ROUNDED = 1e-3
"""No rounding of printed numbers above this share of a quantity's size is granted."""


@dataclass(frozen=True)
class Error:
    """By how much one observable is off, where that is most.

    Attributes
    ----------
    quantity, unit : str
    time : float
        Where it is most [s].
    value, reference, error : float
        There.
    size : float
        Largest value of the reference over the run; 1 where it stays 0.
    bound : float
        On the error of the reference.
    """

    quantity: str
    unit: str
    time: float
    value: float
    reference: float
    error: float
    size: float
    bound: float

    @property
    def relative(self) -> float:
        """The error in the quantity's size."""
        return self.error / self.size

    def as_json(self) -> dict[str, Any]:
        """Return its fields, with ``relative``."""
        return {**vars(self), "relative": self.relative}


@dataclass(frozen=True)
class Judgement:
    """What a trajectory is worth.

    Attributes
    ----------
    scene, case : str
        ``user`` where parameters or the initial state are not the case's.
    file : str
    parameters, state : mapping
        All parameters; initial values that are not 0.
    start_time : float
        Of the case [s].
    samples, judged : int
        How many there are, and how many, from the first, could be judged.
    until : float
        Time of the last that was [s].
    growth : float
        Of an initial error until then.
    tolerance : mapping
        ``relative``, or ``order`` and ``step``; empty where none was given.
    errors : tuple of Error
    notes : tuple of str
        What was seen beside the numbers: columns left out, what looks like a slip of units, ...
    results : tuple of Result
        Verdicts; empty without a tolerance.
    versions : mapping of str to str
    """

    scene: str
    case: str
    file: str
    parameters: Mapping[str, Any]
    state: Mapping[str, float]
    start_time: float
    samples: int
    judged: int
    until: float
    growth: float
    tolerance: Mapping[str, float]
    errors: tuple[Error, ...]
    notes: tuple[str, ...]
    results: tuple[Result, ...]
    versions: Mapping[str, str]

    @property
    def summary(self) -> dict[str, int]:
        """Number of results by verdict, and their ``total``."""
        return report.summary(self.results)

    @property
    def exit_code(self) -> int:
        """0 if all is well or nothing was to be judged, 1 for any deviation or error."""
        return report.exit_code(self.results) if self.tolerance else 0

    def as_json(self) -> dict[str, Any]:
        """Return the ``judge`` document of docs/json.md."""
        results = [report.json_result(result) for result in self.results]
        errors = [error.as_json() for error in self.errors]
        return document(self, summary=self.summary, errors=errors, results=results)


def judge_trajectory(
    trajectory: Any,
    case: str,
    parameters: Mapping[str, Any] | None = None,
    state: Mapping[str, float] | None = None,
    tolerance: float | None = None,
    order: int | None = None,
    step: float | None = None,
    profile: str = "default",
) -> Judgement:
    """Judge a trajectory that was computed elsewhere against the reference of its case.

    Parameters
    ----------
    trajectory : path of a file, or mapping of str to array (n_t,)
        Columns by name, ``t`` [s] among them, see `recording.from_file`. Times need not lie on
        any grid.
    case : str
        ``scene/case``.
    parameters, state : mapping, optional
        What differs from the case.
    tolerance : float, optional
        Largest error that passes, in the largest value of each observable's reference.
    order : int, optional
        In place of it: that of the method, with its ``step`` [s]. Granted is what a published
        scheme of that order makes on the exact equations, times `METHOD_SPREAD`.
    profile : {"strict", "default", "loose"}
        Scales every tolerance.

    Raises
    ------
    UsageError
        For a trajectory that cannot be read or does not belong to the case, unknown names, or
        a tolerance that cannot be.
    EngineError
        If values are not finite and no tolerance makes that a verdict.
    """
    asked = wanted_tolerance(tolerance, order, step)
    if profile not in PROFILES:
        raise UnknownNameError("profile", profile, PROFILES)
    chosen = case_of(case, parameters or {}, state or {})
    found = recording(trajectory)
    names, notes = comparable(found, chosen)
    refuse_outside(found.times, chosen)
    comparison = compared(found, chosen, names, asked)
    lost = [lost_at(comparison, row) for row in range(len(names))]
    if any(lost) and not asked:
        raise EngineError("non_finite", next(filter(None, lost)))
    errors = tuple(
        worst_error(comparison, row, name) for row, name in enumerate(names) if not lost[row]
    )
    notes = [*notes, *comparison.notes, *mistakes(comparison)]
    results = verdicts(comparison, found, errors, notes, asked, profile) if asked else []
    return Judgement(
        scene=chosen.scene,
        case=chosen.name,
        file=found.name,
        parameters=chosen.parameters.as_dict(),
        state=dict(chosen.state),
        start_time=chosen.start_time,
        samples=len(found.times),
        judged=comparison.seen,
        until=float(found.times[comparison.seen - 1]),
        growth=comparison.growth,
        tolerance=asked,
        errors=errors,
        notes=tuple(notes),
        results=tuple(results),
        versions=versions([]),
    )


# What was asked for, made sure of


def wanted_tolerance(
    tolerance: float | None, order: int | None, step: float | None
) -> dict[str, float]:
    """Return what tolerances are to follow from; empty if nothing is to be judged.

    Raises
    ------
    UsageError
        If they contradict each other, one is missing, or one cannot be.
    """
    if tolerance is not None:
        if order is not None or step is not None:
            raise UsageError("give a tolerance, or the method's order and step, not both")
        value = number("tolerance", tolerance)
        if not 0 < value < 1:
            raise UsageError(
                f"the tolerance must lie between 0 and 1, not {value:g}: it is a share of each "
                "observable's largest value"
            )
        return {"relative": value}
    if order is None and step is None:
        return {}
    if order is None or step is None:
        raise UsageError("an order needs the step of the run, and a step the method's order")
    if order not in SCHEMES_OF:
        raise UsageError(
            f"errors are predicted of methods of order {min(SCHEMES_OF)} to {max(SCHEMES_OF)}, "
            f"not {order}; give a tolerance instead"
        )
    value = number("step", step)
    if not (math.isfinite(value) and value > 0):
        raise UsageError(f"the step must be finite and greater than 0, not {value:g}")
    return {"order": order, "step": value}


def case_of(name: str, parameters: Mapping[str, Any], state: Mapping[str, float]) -> Case:
    """Return the case ``scene/case`` with other parameters and initial values.

    Raises
    ------
    UsageError
        For unknown names or impossible values.
    """
    where, slash, which = name.strip().partition("/")
    if where not in SCENES or not slash:
        known = [f"{scene}/{case.name}" for scene in SCENES for case in get_scene(scene).cases]
        if where in SCENES:
            names = ", ".join(case.name for case in get_scene(where).cases)
            raise UsageError(f"a case is named {where}/CASE, CASE being one of {names}")
        raise UnknownNameError("case", name, known)
    scene = get_scene(where)
    case = scene.case(which)
    if not (parameters or state):
        return case
    words = scene.parameters.choices()
    changes = {
        key: value if key in words else number(key, value) for key, value in parameters.items()
    }
    changed = case.parameters.replace(**changes)
    values = {key: number(key, value) for key, value in state.items()}
    started = consistent(scene, changed, {**case.state, **values})
    return replace(case, name="user", parameters=changed, state=started)


def comparable(found: Recording, case: Case) -> tuple[tuple[str, ...], list[str]]:
    """Return which columns can be compared, and notes on those that cannot.

    Raises
    ------
    UsageError
        If none can, or one is in another unit.
    """
    scene = get_scene(case.scene)
    known = tuple(name for name in scene.units if name not in internal(scene))
    names = tuple(name for name in known if name in found.columns)
    extra = [name for name in found.columns if name not in names]
    if not names:
        listed = ", ".join(map(repr, extra)) or "only t"
        raise UsageError(
            f"no column is an observable of {case.scene}: found {listed}; known: {', '.join(known)}"
        )
    for name in names:
        told = found.units.get(name, "")
        if told and same_unit(told) != same_unit(scene.units[name]):
            raise UsageError(f"{name} is in {told}: convert it to {scene.units[name]}")
    return names, [f"not compared: {', '.join(extra)}"] if extra else []


def internal(scene: Scene) -> tuple[str, ...]:
    """Return the states that are the reference's own."""
    return (*scene.internal, *(f"{name}_dot" for name in scene.internal))


def same_unit(unit: str) -> str:
    """Return a unit as it is compared with others."""
    return re.sub(r"[\s*·.^]", "", unit).replace("sec", "s")


def lost_at(found: Comparison, row: int) -> str:
    """Return where an observable is not finite, in words; empty if it is."""
    lost = np.flatnonzero(~np.isfinite(found.values[row]))
    if not lost.size:
        return ""
    value, time = found.values[row, lost[0]], found.times[lost[0]]
    return f"{found.names[row]} is {value} at t = {time:.6g} s: the run is unstable there"


def worst_error(found: Comparison, row: int, name: str) -> Error:
    """Return where an observable is off most."""
    values, reference = found.values[row], found.reference[row]
    worst = int(np.argmax(np.abs(values - reference)))
    return Error(
        quantity=name,
        unit=get_scene(found.case.scene).units[name],
        time=float(found.times[worst]),
        value=float(values[worst]),
        reference=float(reference[worst]),
        error=abs(float(values[worst] - reference[worst])),
        size=float(found.size[row]),
        bound=float(found.bound[row]),
    )


# Verdicts


def verdicts(
    found: Comparison,
    file: Recording,
    errors: Iterable[Error],
    notes: Iterable[str],
    asked: Mapping[str, float],
    profile: str,
) -> list[Result]:
    """Return a result for every observable of the scene, and other columns that it knows."""
    scene = get_scene(found.case.scene)
    by_name = {error.quantity: error for error in errors}
    results = []
    for name in dict.fromkeys((*scene.observables, *found.names)):
        if name not in found.names:
            near = difflib.get_close_matches(name, file.columns, n=1, cutoff=0.6)
            hint = f"; is it its column {near[0]!r}?" if near else ""
            reason = f"the file has no column {name}{hint}"
            results.append(named(found.case, file, name, scene.units[name], "skipped", reason))
            continue
        row = found.names.index(name)
        if name not in by_name:
            reason = f"non_finite: {lost_at(found, row)}"
            results.append(named(found.case, file, name, scene.units[name], "error", reason))
            continue
        finding = finding_of(found, file, row, by_name[name], asked)
        verdict, reason = judge(finding, PROFILES[profile])
        if verdict == "deviation":
            reason = "; ".join([reason, *notes])
        result = named(found.case, file, name, finding.unit, verdict, reason)
        results.append(
            replace(
                result,
                value=finding.value,
                reference=finding.reference,
                error=finding.error,
                tolerance=PROFILES[profile] * finding.tolerance,
                series=finding.series,
            )
        )
    return results


def finding_of(
    found: Comparison, file: Recording, row: int, error: Error, asked: Mapping[str, float]
) -> Finding:
    """Return the error of an observable with its tolerance, and where that comes from."""
    if found.predicted is None:
        granted = asked["relative"] * error.size
        source = f"tolerance {asked['relative']:.3g} x {error.size:.3g} {error.unit}"
    else:
        printed = file.rounding(file.columns[error.quantity])
        printed += float(found.slope[row]) * file.rounding(file.times)
        granted = float(found.predicted[row]) + rounding(found.seen, found.growth) * error.size
        granted += min(printed, MOST_ROUNDED * error.size)
        order, step = int(asked["order"]), asked["step"]
        published = " and ".join(SCHEMES_OF[order])
        source = (
            f"{METHOD_SPREAD[order]:g} x the error of {published} with h = {step:.3g} s "
            "on the exact equations, or of a turn in Cartesian coordinates"
            + (f", {printed:.2g} for the file's digits" if printed else "")
        )
    span = found.times[-1] - found.case.start_time
    return Finding(
        quantity=error.quantity,
        unit=error.unit,
        value=error.value,
        reference=error.reference,
        error=error.error,
        tolerance=granted + error.bound,
        reason=(
            f"worst at t = {error.time:.4g} s; {found.seen} samples over {span:.4g} s, in which "
            f"errors grow by {found.growth:.3g}; relative error {error.relative:.2g}; {source}"
        ),
        series=series_of(found, row),
    )


def series_of(found: Comparison, row: int) -> Series:
    """Return an observable beside its reference, thinned, its worst sample kept."""
    worst = int(np.argmax(np.abs(found.values[row] - found.reference[row])))
    kept = np.unique([*np.linspace(0, found.seen - 1, DRAWN).astype(int), worst])
    return Series("time", found.times[kept], found.values[row, kept], found.reference[row, kept])


def named(
    case: Case, file: Recording, name: str, unit: str, verdict: Verdict, reason: str
) -> Result:
    """Return a result with its id; the file stands for an engine without models and methods."""
    who = re.sub(r"[^A-Za-z0-9_.+-]", "_", file.name) or "_"
    prefix = f"verification/{case.scene}/{case.name}/trajectory/{who}/{FILE}"
    about = Subject(prefix, "verification", who, case.scene, case.name, "trajectory", FILE)
    return Result(about, name, verdict, reason, unit)


def as_report(found: Judgement) -> Report:
    """Return a judgement as the report of one check."""
    chosen = {"scenes": (found.scene,), "ids": (f"{found.scene}/{found.case}",)}
    run = report.Run(planned=1, selection=chosen, environment=environment())
    return Report(found.results, found.versions, run)


# Console


def print_judgement(console: Console, found: Judgement, quiet: bool = False) -> None:
    """Print errors, what they are held against, and what was noticed; or the last line alone."""
    if not quiet:
        print_errors(console, found)
    if found.tolerance:
        report.print_line(
            console,
            report.summary_line(found.results),
            style=report.STYLES[report.worst(found.results)],
        )
    else:
        show(console, "nothing is judged without --tolerance, or --order and --step")


def print_errors(console: Console, found: Judgement) -> None:
    """Print errors, what they are held against, and what was noticed."""
    changed = {**found.state} if found.case == "user" else {}
    start = f", from {assignments(changed)}" if changed else ""
    show(console, f"{found.file} against {found.scene}/{found.case}{start}")
    judged = {result.quantity: result for result in found.results}
    heads = ["", "largest error", "relative", "at t [s]"]
    lines: list[list[object]] = []
    for error in found.errors:
        line: list[object] = [f"{error.quantity} [{error.unit}]", error.error, error.relative]
        line.append(error.time)
        if found.tolerance:
            result = judged[error.quantity]
            line = [result.verdict, *line[:2], result.tolerance, *line[2:]]
        else:
            line += [error.value, error.reference]
        lines.append(line)
    if found.tolerance:
        heads = ["verdict", *heads[:2], "tolerance", *heads[2:]]
    else:
        heads += ["value", "reference"]
    table(console, heads, lines, digits=4, narrow=True)
    report.print_wrapped(
        console,
        f"{found.judged} of {found.samples} samples judged, to t = {found.until:.6g} s; an initial "
        f"error grows by {found.growth:.3g} until then: "
        + ("errors are the method's or the model's." if found.growth <= HARMLESS else CHAOS),
    )
    for note in found.notes:
        report.print_wrapped(console, f"Note: {note}")
    for result in found.results:
        if result.verdict in ("error", "skipped"):
            report.print_wrapped(console, f"{result.verdict}: {result.quantity}: {result.reason}")
