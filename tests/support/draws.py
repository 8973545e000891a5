"""Runs drawn at random: parameters over decades, states, models, methods and steps.

A draw is whole numbers, so that it can be repeated, and kept where it found something. Whatever
comes of it has to be right, or somebody else than the reference has to notice.
"""

from __future__ import annotations

import dataclasses
import math
import random
import re
import signal
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.pushed import QUANTITY
from mbcheck.comparisons.checks.suite import Check, run_check
from mbcheck.comparisons.checks.truth import MOST_AMPLIFICATION
from mbcheck.comparisons.checks.verdict import REFERENCE, Result, Subject
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import default_step, shortest_period
from mbcheck.reference import get_scene
from mbcheck.reference.errors import CannotJudgeError, EngineError, MbcheckError
from mbcheck.reference.scene import Case, Scene

GROWTH = re.compile(r"errors of the start grow by (\S+)")

GRID = 500
"""A number between minus and plus this stands for a place in a range; 0 for its middle."""

DECADES: Mapping[str, float] = {"rotating_beam": 1.0}
WIDE = 3.0
"""Parameters are drawn so many decades around their defaults, of other scenes `WIDE`: ratios go
over twice as many. The reference of a continuum is too dear farther out."""

PATIENCE = 4.0
"""Processor's time [s] in which a draw must be judged; one that takes longer is skipped."""

ZERO = 0.96
"""Beyond this part of the lower half of the range a parameter that may be 0 is 0."""

STEPS = (16, 256)
"""Fewest and most steps of a run."""

TURNS: Mapping[str, float] = {"rotating_beam": 1.0}
MOST_TURNS = 8.0
"""Most periods of the fastest motion in a run, of other scenes `MOST_TURNS`."""

FINEST, COARSEST = -2, 6
"""Powers of two on the method's default step."""

SLOWEST = 1e-9
"""Shortest step [s] that is tried: engines count time in doubles from 0."""


@dataclass(frozen=True)
class Draw:
    """What is drawn.

    Attributes
    ----------
    scene, engine : str
    choice : int
        Of model and method, among all pairs that the engine has for it.
    step : int
        Power of two on the default step.
    length : int
        Of the run, place in `STEPS`, 0 to `GRID`.
    parameters, state : tuple of int
        Places in the ranges, by the order of the scene's names.
    """

    scene: str
    engine: str
    choice: int
    step: int
    length: int
    parameters: tuple[int, ...]
    state: tuple[int, ...]


def shape(scene: str) -> tuple[int, int]:
    """Return how many parameters and how many states a draw of a scene has."""
    known = get_scene(scene)
    return len(drawn_fields(known)), len(known.public_states)


def drawn_fields(scene: Scene) -> list[dataclasses.Field[Any]]:
    """Return the parameters that are drawn: all but gravity, which the papers have not."""
    fields = dataclasses.fields(scene.parameters)
    return [item for item in fields if not item.name.startswith("gravity_")]


EDGE = 0.05
"""Share of places at either end of their range; twice as many are in its middle."""


def drawn(scene: str, engine: str, count: int) -> list[Draw]:
    """Return the first draws of an engine's motions of a scene, the same ones at any time."""
    parameters, states = shape(scene)
    rng = random.Random(f"{scene} {engine}")
    return [
        Draw(
            scene=scene,
            engine=engine,
            choice=rng.randrange(1000),
            step=rng.randint(FINEST, COARSEST),
            length=rng.randint(0, GRID),
            parameters=tuple(place(rng) for _ in range(parameters)),
            state=tuple(place(rng) for _ in range(states)),
        )
        for _ in range(count)
    ]


def place(rng: random.Random) -> int:
    """Return a place: uniform but for the ends and the middle, which come more often."""
    share = rng.random()
    special = [-GRID, GRID, 0, 0]
    return special[int(share / EDGE)] if share < 4 * EDGE else rng.randint(-GRID, GRID)


def parameters_at(scene: Scene, places: tuple[int, ...]) -> Any:
    """Return the parameters that stand at these places of their ranges."""
    values: dict[str, Any] = {}
    for item, place in zip(drawn_fields(scene), places, strict=True):
        decades = DECADES.get(scene.name, WIDE)
        values[item.name] = parameter_at(item, decades, place / GRID)
    if scene.name == "speed_regulator":  # the rod must be longer than the crank
        paper: Any = scene.parameters()
        longer = values["rod_length"] / paper.rod_length
        values["rod_length"] = values["crank_radius"] * (1 + 4 * longer)
        values["spring_rest"] *= values["rod_length"] / abs(paper.spring_rest)
    return scene.parameters(**with_moments_of_a_body(scene, values))


MOMENTS = ("moment_1", "moment_2", "moment_3")


def with_moments_of_a_body(scene: Scene, values: dict[str, Any]) -> dict[str, Any]:
    """Return values whose moments of inertia are those of a body, where there are any.

    None is larger than the sum of the others if each is the sum of two integrals of a square: it is
    these that lie as far from their defaults as the values do.
    """
    if not set(MOMENTS) <= set(values):
        return values
    default = np.array([getattr(scene.parameters(), name) for name in MOMENTS])
    drawn = np.array([values[name] for name in MOMENTS])
    x, y, z = (np.sum(default) / 2 - default) * drawn / default
    return values | dict(zip(MOMENTS, map(float, (y + z, x + z, x + y)), strict=True))


def some_are_slow(values: Iterable[Any], every: int = 11) -> list[Any]:
    """Return values of a test's parameter, every eleventh marked slow, the others campaign."""
    marks = pytest.mark.slow, pytest.mark.campaign
    return [pytest.param(value, marks=marks[i % every > 0]) for i, value in enumerate(values)]


def case_near(case: Case, seed: int) -> Case:
    """Return the case with parameters within 30 %, half its state to one and a half of it.

    Of an odd seed under gravity.
    """
    rng = np.random.default_rng(seed)
    values = {name: x * rng.uniform(0.7, 1.3) for name, x in case.parameters.as_dict().items()}
    p = case.parameters.replace(**with_moments_of_a_body(get_scene(case.scene), values))
    pull = rng.normal(size=3) * (seed % 2)
    p = p.replace(**{f"gravity_{axis}": g for axis, g in zip("xyz", pull, strict=True)})
    state = {name: x * rng.uniform(0.5, 1.5) for name, x in case.state.items()}
    return dataclasses.replace(case, parameters=p, state=state)


def parameter_at(item: dataclasses.Field[Any], decades: float, place: float) -> Any:
    """Return the value of a parameter at a place from -1 to 1 of its range."""
    name, about = item.name, item.metadata
    default: Any = item.default
    if "options" in about:
        options = about["options"]
        return options[min(int((place + 1) / 2 * len(options)), len(options) - 1)]
    if name == "segments":
        return float(round(2 * 4 ** ((place + 1) / 2)))
    if name == "mass_position":
        return (place + 1) / 2 * 0.99 + 0.01
    if about["bound"] == "non-negative" and place < -ZERO:
        return 0.0
    if about["bound"] == "any" and name.endswith("angle"):
        return math.pi * place
    size = abs(default) or 1.0
    if about["bound"] == "any" and place < 0:
        return -size * 10 ** (decades * (-2 * place - 1))
    if about["bound"] == "any":
        return size * 10 ** (decades * (2 * place - 1))
    return size * 10 ** (decades * place)


MOST_TURNED = 1.01
"""Added to the first number of a quaternion whose numbers lie from -1 to 1: no less than 0.01."""


def state_at(scene: Scene, parameters: Any, places: tuple[int, ...]) -> dict[str, float]:
    """Return initial values: angles on the whole circle, the others over decades.

    Of quaternions any rotation but half a turn, and angular velocities.
    """
    omega = 2 * np.pi / float(scene.period(parameters))
    given = scene.constrained_initial_values(parameters)
    length = max(lengths(parameters), default=1.0)
    values: dict[str, float] = {}
    turning = {name: one for one in scene.quaternions for name in one.coordinates}
    for name, place in zip(scene.public_states, places, strict=True):
        share = place / GRID
        coordinate = name.removesuffix("_dot")
        if one := turning.get(coordinate):
            first, *others = one.coordinates
            if name == coordinate:
                values[name] = share + (MOST_TURNED if name == first else 0.0)
            elif coordinate != first:
                values[one.rates[others.index(coordinate)]] = omega * spread(share)
            continue
        angle = scene.units[coordinate] == "rad"
        if name == coordinate:
            values[name] = math.pi * share if angle else length * spread(share)
        else:
            values[name] = omega * (1.0 if angle else length) * spread(share)
    return {name: value for name, value in values.items() if name not in given} | given


def lengths(parameters: Any) -> list[float]:
    """Return the lengths among parameters [m]."""
    return [
        float(getattr(parameters, item.name))
        for item in dataclasses.fields(parameters)
        if item.metadata["unit"] == "m" and getattr(parameters, item.name) > 0
    ]


def spread(share: float) -> float:
    """Return a number from -1 to 1, spread over three decades on both sides of 0."""
    return math.copysign(10 ** (3 * (abs(share) - 1)), share) if share else 0.0


def run_of(draw: Draw) -> tuple[Adapter, Case, str, Method, float, float]:
    """Return engine, case, model, method, step [s] and horizon [s] of a draw.

    Raises
    ------
    MbcheckError
        If the reference makes nothing of the parameters.
    """
    scene, engine = get_scene(draw.scene), get_engine(draw.engine)
    parameters = parameters_at(scene, draw.parameters)
    state = state_at(scene, parameters, draw.state)
    case = Case(draw.scene, "drawn", parameters, state)
    pairs = [(model, method) for model in engine.models(draw.scene) for method in engine.methods]
    fit = [
        (model, method)
        for model, method in pairs
        if engine.bind(case, model).unsupported_reason(case, method) is None
    ] or pairs
    model, method = fit[draw.choice % len(fit)]
    step = float(2.0**draw.step * default_step(case, method))
    ends = float(scene.drive_end_time(parameters))
    if ends > 0:  # on a step's boundary
        step = ends / math.ceil(ends / step)
    turns = TURNS.get(draw.scene, MOST_TURNS)
    count = round(STEPS[0] * (STEPS[1] / STEPS[0]) ** (draw.length / GRID))
    count = max(4, min(count, int(turns * fastest_period(case) / step)))
    return (
        engine,
        dataclasses.replace(case, horizon=count * step),
        model,
        method,
        step,
        count * step,
    )


def fastest_period(case: Case) -> float:
    """Return the shortest of the natural periods, and of the turns of start and drive [s]."""
    scene, p = get_scene(case.scene), case.parameters
    speeds = [
        abs(case.state.get(f"{name}_dot", 0.0)) for name in (*scene.rotations_per_period, "theta")
    ]
    speeds.append(abs(getattr(p, "angular_speed", 0.0)))
    return 2 * math.pi / max(2 * math.pi / shortest_period(case), *speeds)


def result_of_draw(draw: Draw, patience: float = PATIENCE) -> Result:
    """Run a draw and judge it; chaos is skipped with its factor.

    The check must be done within `patience` seconds of this process.
    """
    try:
        engine, case, model, method, step, horizon = run_of(draw)
    except (MbcheckError, ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        reason = f"the reference makes nothing of it: {type(error).__name__}: {error}"
        about = Subject("drawn", "verification", draw.engine, draw.scene)
        return about.result("-", "skipped", reason)
    check = Check(
        "parameters", dataclasses.replace(case, horizon=horizon), engine.name, model, method,
        (QUANTITY,), step=step,
        unsupported_reason=engine.bind(case, model).unsupported_reason(case, method),
    )  # fmt: skip
    if not (np.isfinite(step) and step >= SLOWEST):
        return check.skipped(f"it moves too fast: the step would be {step:.3g} s")[0]
    try:
        with within(patience):
            (result,) = run_check(check, engine=engine)
    except CannotJudgeError as error:
        return check.skipped(str(error))[0]
    match = GROWTH.search(result.reason)
    growth = float(match[1]) if match else 1.0
    if result.verdict == "deviation" and MOST_AMPLIFICATION < growth < math.inf:
        reason = f"chaotic: an error of the start grows by {growth:.3g}"
        return dataclasses.replace(result, verdict="skipped", reason=reason)
    return result


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Give up what Python computes after a time of the processor, where there is an alarm."""
    if not hasattr(signal, "SIGVTALRM"):
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise CannotJudgeError(f"the check takes more than {seconds:g} s")

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds, seconds)  # again, should a rule swallow it
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def silent(result: Result) -> bool:
    """Return whether a run is wrong and nobody but the reference notices, or nothing says why."""
    if result.verdict == "deviation":
        return set(result.noticed_by) <= {REFERENCE}
    return result.verdict != "pass" and not result.reason


def result_of_outcome(outcome: Result | EngineError) -> Result:
    """Return the result of a draw, also of one whose process died or hung."""
    if isinstance(outcome, Result):
        return outcome
    reason = f"{outcome.kind}: {outcome.message}"
    return Subject("drawn", "verification", "-").result("-", "error", reason)
