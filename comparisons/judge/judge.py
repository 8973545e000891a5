"""The verdict on a trajectory that was computed elsewhere."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from ...reference import SCENES, get_scene
from ...reference.errors import EngineError, UnknownNameError, UsageError
from ...reference.scene import Case
from ..checks.verdict import PROFILES, Finding, Result, Series, Subject
from ..documents import document
from ..documents.fields import OptionMark, documented, takes_fields_of
from ..queries.environment import versions
from ..queries.query import as_float, changed, initial_values
from ..reports.run.outcome import Report, with_lost_numbers
from ..reports.run.results import summary
from ..reports.words import with_unit
from .comparison import (
    METHOD_SPREAD,
    SCHEMES_OF,
    FileComparison,
    compare,
    likely_mistakes,
    refuse_outside,
)
from .recording import Recording, recording

FILE = "file"
"""Placeholder of the method in ids."""

DRAWN = 800
"""Samples of a trajectory that are kept for pictures."""


@dataclass(frozen=True)
class LargestError:
    """The largest error of one observable.

    Attributes
    ----------
    quantity : str
        observable
    unit : str
        of the numbers but `time` and `relative`
    time : float
        time of the largest error [s]
    value : float
        value of the file at that time
    reference : float
        true value at that time
    error : float
        largest error
    size : float
        largest value of the reference; 1 where that stays 0
    bound : float
        bound on the error of the reference
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
    @documented
    def relative(self) -> float:
        """`error` / `size` [1]."""
        return self.error / self.size


@dataclass(frozen=True)
class Judgement:
    """The verdict on a trajectory.

    Attributes
    ----------
    case : str
        its name; `user` if `--set` or `--state` change it
    file : str
        name of the file, without folder and ending
    state : mapping of str to float
        initial values that are not 0, at `start_time` [SI]
    start_time : float
        time at which the case begins [s]
    samples : int
        rows of the file
    judged : int
        rows, from the first, that could be judged
    until : float
        time of the last of these [s]
    growth : float
        growth factor of an initial error until then [1]
    tolerance : mapping of str to float
        basis of the tolerances: `relative`, the share of each observable's size [1], or `order` and
        `step` [s] of the method; empty if nothing was judged
    errors : tuple of LargestError
        one for each compared column with finite values
    notes : tuple of str
        columns that were not compared, and likely mistakes
    results : tuple of Result
        as in `check`, `model` being `file` and `engine` the file's name; none without a tolerance
    """

    scene: str
    case: str
    file: str
    parameters: Mapping[str, float | str]
    state: Mapping[str, float]
    start_time: float
    samples: int
    judged: int
    until: float
    growth: float
    tolerance: Mapping[str, float]
    errors: tuple[LargestError, ...]
    notes: tuple[str, ...]
    results: tuple[Result, ...]
    versions: Mapping[str, str]

    @property
    @documented
    def summary(self) -> dict[str, int]:
        """Number of results by verdict, and their `total`."""
        return summary(self.results)

    @property
    def exit_code(self) -> int:
        """0 if all is well or nothing was judged, 1 for any deviation or error."""
        return Report(self.results, self.versions).exit_code if self.tolerance else 0

    def as_json(self) -> dict[str, Any]:
        """Return the ``judge`` document of docs/json.md."""
        return document("judge", self, results=list(map(with_lost_numbers, self.results)))


@dataclass(frozen=True)
class JudgeRequest:
    """A trajectory, its case, and its tolerance.

    Attributes
    ----------
    trajectory : path of a file, or mapping of str to array (n_t,)
        CSV with the columns t [s] and observables; in Python also columns by name. Times need not
        lie on any grid.
    case : str
        Case of which it is a run.
    parameters : mapping of str to float or str
        Change a parameter from its default, SI units.
    state : mapping of str to float
        Initial value, otherwise that of the case, SI units.
    tolerance : float or None
        Largest error, as a share of an observable's largest value.
    order : int or None
        Order of the method, from which tolerances follow with --step: the error of a published
        scheme of that order on the exact equations, with a margin.
    step : float or None
        Fixed step [s].
    profile : {"strict", "default", "loose"}
        Scales every tolerance.
    """

    trajectory: Annotated[Any, OptionMark("FILE", flags=())]
    case: Annotated[str | None, OptionMark("SCENE/CASE")] = None
    parameters: Annotated[Mapping[str, Any] | None, OptionMark("NAME=VALUE", ("--set",))] = None
    state: Annotated[Mapping[str, float] | None, OptionMark("NAME=VALUE")] = None
    tolerance: Annotated[float | None, OptionMark("X")] = None
    order: Annotated[int | None, OptionMark("P")] = None
    step: Annotated[float | None, OptionMark("H")] = None
    profile: Annotated[str, OptionMark("strict|default|loose")] = "default"


@takes_fields_of(JudgeRequest)
def judge_trajectory(asked: JudgeRequest) -> Judgement:
    """Judge a trajectory that was computed elsewhere against the reference of its case.

    Takes the fields of `JudgeRequest`.

    Raises
    ------
    UsageError
        For a trajectory that cannot be read or does not belong to the case, unknown names, or
        a tolerance that cannot be.
    EngineError
        If values are not finite and no tolerance makes that a verdict.
    """
    if asked.case is None:
        raise UsageError("judge needs --case SCENE/CASE; `mbcheck list SCENE` shows them")
    basis, profile = wanted_tolerance(asked.tolerance, asked.order, asked.step), asked.profile
    if profile not in PROFILES:
        raise UnknownNameError("profile", profile, PROFILES)
    reference_case = case_of(asked.case, asked.parameters or {}, asked.state or {})
    file = recording(asked.trajectory)
    names, notes = comparable(file, reference_case)
    refuse_outside(file.times, reference_case)
    comparison = compare(file, reference_case, names, basis)
    not_finite = {name: first_not_finite(comparison, row) for row, name in enumerate(names)}
    if any(not_finite.values()) and not basis:
        raise EngineError("non_finite", next(filter(None, not_finite.values())))
    findings = {
        item.quantity: item
        for item in findings_of(comparison, basis)
        if not not_finite[item.quantity]
    }
    errors = tuple(
        largest_error(findings[name], *numbers)
        for name, *numbers in zip(names, comparison.right.size, comparison.right.bound, strict=True)
        if name in findings
    )
    notes = [*notes, *comparison.notes, *likely_mistakes(comparison)]
    results = verdicts(comparison, file, findings, not_finite, notes, profile) if basis else []
    return Judgement(
        scene=reference_case.scene,
        case=reference_case.name,
        file=file.name,
        parameters=reference_case.parameters.as_dict(),
        state=dict(reference_case.state),
        start_time=reference_case.start_time,
        samples=len(file.times),
        judged=comparison.seen,
        until=float(file.times[comparison.seen - 1]),
        growth=comparison.growth,
        tolerance=basis,
        errors=errors,
        notes=tuple(notes),
        results=tuple(results),
        versions=versions([]),
    )


# What was asked for, made sure of


def wanted_tolerance(
    tolerance: float | None, order: int | None, step: float | None
) -> dict[str, float]:
    """Return the basis of tolerances; empty if nothing is judged.

    Raises
    ------
    UsageError
        If they contradict each other, one is missing, or one cannot be.
    """
    if tolerance is not None:
        if order is not None or step is not None:
            raise UsageError("give a tolerance, or the method's order and step, not both")
        value = as_float("tolerance", tolerance)
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
    value = as_float("step", step)
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
    values = changed(case.parameters, parameters)
    start = initial_values(scene, values, {**case.state, **state})
    return replace(case, name="user", parameters=values, state=start)


def comparable(file: Recording, case: Case) -> tuple[tuple[str, ...], list[str]]:
    """Return the columns that can be compared, and notes on the others.

    Raises
    ------
    UsageError
        If none can, or one is in another unit.
    """
    scene = get_scene(case.scene)
    own = scene.discretisation_coordinates  # states that are the reference's own
    internal = {*own, *(f"{name}_dot" for name in own)}
    known = tuple(name for name in scene.units if name not in internal)
    names = tuple(name for name in known if name in file.columns)
    extra = [name for name in file.columns if name not in names]
    if not names:
        others = ", ".join(map(repr, extra)) or "only t"
        raise UsageError(
            f"no column is an observable of {case.scene}: found {others}; known: {', '.join(known)}"
        )
    for name in names:
        unit = file.units.get(name, "")
        if unit and same_unit(unit) != same_unit(scene.units[name]):
            raise UsageError(f"{name} is in {unit}: convert it to {scene.units[name]}")
    return names, [f"not compared: {', '.join(extra)}"] if extra else []


def same_unit(unit: str) -> str:
    """Return a unit as it is compared with others."""
    return re.sub(r"[\s*·.^]", "", unit).replace("sec", "s")


def first_not_finite(comparison: FileComparison, row: int) -> str:
    """Return the first time at which an observable is not finite, in words; empty if none."""
    places = np.flatnonzero(~np.isfinite(comparison.values[row]))
    if not places.size:
        return ""
    value, time = comparison.values[row, places[0]], comparison.right.times[places[0]]
    return f"{comparison.names[row]} is {value} at t = {time:.6g} s: the run is unstable there"


def largest_error(finding: Finding, size: float, bound: float) -> LargestError:
    """Return the largest error of an observable from the finding on it."""
    series = finding.series
    assert series is not None
    return LargestError(
        quantity=finding.quantity,
        unit=finding.unit,
        time=float(series.x[np.argmax(np.abs(series.value - series.reference))]),
        value=finding.value,
        reference=finding.reference,
        error=finding.error,
        size=float(size),
        bound=float(bound),
    )


# Verdicts


def findings_of(comparison: FileComparison, basis: Mapping[str, float]) -> Sequence[Finding]:
    """Return the error of each observable with its tolerance, and the basis of that."""
    right, room = comparison.right, ""
    if "order" in basis:
        published = " and ".join(SCHEMES_OF[int(basis["order"])])
        room = (
            f"{METHOD_SPREAD[int(basis['order'])]:g} x the error of {published} with "
            f"h = {basis['step']:.3g} s on the exact equations, or of a turn in Cartesian "
            "coordinates"
        )

    def describe(row: int, worst: int) -> str:
        error = abs(comparison.values[row, worst] - right.values[row, worst])
        size, digits = float(right.size[row]), comparison.printed[row]
        words = room + (f", {digits:.2g} for the file's digits" if digits else "")
        if not room:
            unit = comparison.unit(comparison.names[row])
            words = f"tolerance {basis.get('relative', 1.0):.3g} x {with_unit(size, unit)}"
        return (
            f"worst at t = {right.times[worst]:.4g} s; {comparison.seen} samples over "
            f"{comparison.span:.4g} s, errors grow by a factor of {comparison.growth:.3g} in it; "
            f"relative error {error / size:.2g}; {words}"
        )

    findings = comparison.observables(describe, over_time=True)
    return [item for item in findings if isinstance(item, Finding)]


def verdicts(
    comparison: FileComparison,
    file: Recording,
    findings: Mapping[str, Finding],
    not_finite: Mapping[str, str],
    notes: Iterable[str],
    profile: str,
) -> list[Result]:
    """Return a result for every observable of the scene, and other columns that it knows."""
    case = comparison.case
    scene = get_scene(case.scene)
    # the file stands for an engine without models and methods
    who = re.sub(r"[^A-Za-z0-9_.+-]", "_", file.name) or "_"
    prefix = f"verification/{case.scene}/{case.name}/trajectory/{who}/{FILE}"
    about = Subject(prefix, "verification", who, case.scene, case.name, "trajectory", FILE)
    results = []
    for name in dict.fromkeys((*scene.observables, *comparison.names)):
        unit = scene.units[name]
        if name not in comparison.names:
            near = difflib.get_close_matches(name, file.columns, n=1, cutoff=0.6)
            hint = f"; is it its column {near[0]!r}?" if near else ""
            reason = f"the file has no column {name}{hint}"
            results.append(about.result(name, "skipped", reason, unit=unit))
        elif not_finite[name]:
            reason = f"non_finite: {not_finite[name]}"
            results.append(about.result(name, "error", reason, unit=unit))
        else:
            finding = findings[name]
            drawn = replace(finding, series=drawn_series(finding))
            result = about.with_verdict(drawn, PROFILES[profile])
            if result.verdict == "deviation":
                result = replace(result, reason="; ".join([result.reason, *notes]))
            results.append(result)
    return results


def drawn_series(finding: Finding) -> Series | None:
    """Return so many samples of a finding's series as pictures need, the worst among them."""
    series = finding.series
    if series is None:
        return None
    worst = int(np.argmax(np.abs(series.value - series.reference)))
    some = np.unique([*np.linspace(0, len(series.x) - 1, DRAWN).astype(int), worst])
    return Series("time", series.x[some], series.value[some], series.reference[some])
