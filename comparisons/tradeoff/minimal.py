"""The least that meets a target: elements of a beam, hardness of a loop, and what may be left out.

Every number is computed when it is asked for. What lies beyond the largest model that is run is
extrapolated by the declared order and says so; what no number of elements can meet says why.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from itertools import chain, pairwise
from time import perf_counter
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.amplification import largest_stable_step, vibrations
from ...reference.errors import MbcheckError
from ...reference.rotating_beam.chain import chain_frequencies
from ...reference.rotating_beam.parameters import RotatingBeam
from ...reference.rotating_beam.scene import beam_scene
from ...reference.rotating_beam.shapes import cantilever_modes, polynomials
from ...reference.scene import Array, Case
from ...reference.solve.single import solve
from ..checks.free_vibrations import stable_step
from ..checks.kinds.elements import engine_modes, of_continuum
from ..checks.kinds.elements import exact as exact_frequencies
from ..checks.suite import best_method
from ..checks.truth import roundoff_reference, truth
from ..engines.adapter import Adapter
from ..engines.equations import scene_equations
from ..engines.protocol import Method
from ..engines.registry import get_engine
from ..engines.run import Trajectory, run
from ..engines.setup import Setup, power_of_two
from ..engines.variants.catalogue import mujoco
from .left_out import ROWS, rows_of
from .left_out import LeftOut as LeftOut
from .series import TARGETS, Cost
from .sweep import cost

CLOSED = 1e-6
"""Target of a loop beside those that are asked for."""

BEAM, LOOP = "rotating_beam", "speed_regulator"

STEADY = ("steady_at_rest", "steady_4", "steady_12")
"""Cases whose first frequency is looked at."""

SPIN_UP = "spin_up_quick"
"""Case whose tip is looked at."""

TIP, OMEGA = "tip_deflection", "omega_1"

SPACING = 2.0**-4
"""Of the samples of the tip [s]; no step is longer."""

FINE = 2.0**-9
"""Longest step [s] with which elements are told apart: the lowest modes' error of time is then
1e-6 of the range, which `Fewest.integration` shows."""

REPEATS = 3
"""Runs of which the wall time is the median."""

MOST_LEVELS = 10
"""Times that a step is halved to meet a target."""


# Elements of the beam -----------------------------------------------------------------------


@dataclass(frozen=True)
class Kind:
    """A way to make a beam of parts.

    Attributes
    ----------
    name : str
    part : str
        What is counted.
    choices : mapping of str to str
        Parameters that choose it.
    counts : tuple of int
        Tried, in rising order, of frequencies; and of the tip, which costs more.
    tip_counts : tuple of int
    """

    name: str
    part: str
    choices: Mapping[str, str]
    counts: tuple[int, ...]
    tip_counts: tuple[int, ...]


RODS = (2, 4, 8, 16, 32, 64, 128), (2, 4, 8, 16, 32, 48)
FINITE = (2, 4, 8, 16, 32), (2, 4, 8, 16, 32)
MODES = tuple(range(1, 9)), tuple(range(1, 7))

KINDS: dict[str, tuple[Kind, ...]] = {
    "mujoco": (
        Kind("chain A", "rods", {"scheme": "A"}, *RODS),
        Kind("chain B", "rods", {"scheme": "B"}, *RODS),
    ),
    "exudyn": (
        Kind("ancf", "elements", {"element": "ancf"}, *FINITE),
        Kind("geometrically_exact", "elements", {"element": "geometrically_exact"}, *FINITE),
    ),
    "reference": (
        Kind("polynomials", "modes", {}, *MODES),
        Kind("cantilever_modes", "modes", {}, *MODES),
    ),
}
"""By engine."""

SHAPES = {"polynomials": polynomials, "cantilever_modes": cantilever_modes}


@dataclass(frozen=True)
class Curve:
    """How an error falls with the number of parts.

    Attributes
    ----------
    engine, kind, part, case, quantity : str
    order : int
        Declared; 0 where none is.
    counts : tuple of int
    errors : tuple of float
        Of a frequency relative to it, of the tip the largest over its range.
    limit, doubt : float
        Error extrapolated to parts of no length, and how far the extrapolation moved last.
    """

    engine: str
    kind: str
    part: str
    case: str
    quantity: str
    order: int
    counts: tuple[int, ...]
    errors: tuple[float, ...]
    limit: float
    doubt: float


@dataclass(frozen=True)
class Fewest:
    """The fewest parts that meet a target.

    Attributes
    ----------
    engine, kind, part, case, quantity : str
    target : float
    count : int or None
        None where no number meets the target, or none that was tried and no order is known.
    error, fewer : float or None
        Measured with so many, and with one less, which misses the target; ``fewer`` is None
        where fewer are not to be had.
    extrapolated : bool
        The count follows from the declared order, and was not run.
    limit : float
        What no number of parts removes.
    integration : float or None
        What halving the step changes, over the same size.
    stable_step : float or None
        Longest that theory grants [s]; None where there is no limit.
    step : float or None
        Longest power of two [s] with which a run meets the target.
    cost : Cost or None
        With that step.
    reason : str
    """

    engine: str
    kind: str
    part: str
    case: str
    quantity: str
    target: float
    count: int | None
    error: float | None
    fewer: float | None
    extrapolated: bool
    limit: float
    integration: float | None = None
    stable_step: float | None = None
    step: float | None = None
    cost: Cost | None = None
    reason: str = ""


@dataclass
class Measured:
    """A quantity by the number of parts, measured once for each.

    Attributes
    ----------
    measure : callable ``(n) -> array``
    truth : array
    size : float
    order : int
    known : dict of int to array
    fastest : dict of int to float
        Highest frequency [rad/s], where frequencies are measured.
    """

    measure: Callable[[int], Array]
    truth: Array
    size: float
    order: int
    known: dict[int, Array] = field(default_factory=dict)
    fastest: dict[int, float] = field(default_factory=dict)

    def values(self, count: int) -> Array:
        """Return the quantity with so many parts."""
        if count not in self.known:
            self.known[count] = self.measure(count)
        return self.known[count]

    def off(self, values: Array) -> float:
        """Return the error of values."""
        return float(np.max(np.abs(values - self.truth))) / self.size

    def error(self, count: int) -> float:
        """Return the error with so many parts."""
        return self.off(self.values(count))

    def limit(self, counts: Sequence[int]) -> tuple[float, float]:
        """Return the error extrapolated from the last counts, and how far it moved."""
        gains = [(b / a) ** self.order - 1 for a, b in pairwise(counts)]
        limits = [
            self.values(b) + ((self.values(b) - self.values(a)) / gain if gain else 0.0)
            for (a, b), gain in zip(pairwise(counts), gains, strict=True)
        ]
        before = limits[-2] if len(limits) > 1 else self.values(counts[-1])
        doubt = float(np.max(np.abs(limits[-1] - before))) / self.size
        return self.off(limits[-1]), doubt


def climbed(measured: Measured, counts: Sequence[int], target: float) -> list[int]:
    """Return the counts up to where two in a row meet the target; one may do so by chance."""
    tried: list[int] = []
    for count in counts:
        tried.append(count)
        if len(tried) > 1 and all(measured.error(n) <= target for n in tried[-2:]):
            break
    return tried


def fewest(measured: Measured, tried: Sequence[int], target: float) -> tuple[int | None, bool]:
    """Return the fewest parts that meet a target, and whether they are extrapolated.

    Beyond the count all that were tried meet it too: an error that passes through zero on its
    way to another limit does not count.
    """
    limit, doubt = measured.limit(tried)
    errors = [measured.error(n) for n in tried]
    if limit - doubt > target:
        return None, False
    if errors[-1] > target:
        if not measured.order or limit > target / 2:
            return None, False
        certain = max(0.0, limit - doubt)
        factor = (errors[-1] - certain) / (target - certain)
        return int(np.ceil(tried[-1] * factor ** (1 / measured.order))), True
    missed = [i for i, error in enumerate(errors) if error > target]
    if not missed:
        return tried[0], False
    low, high = tried[missed[-1]], tried[missed[-1] + 1]
    while high - low > 1:
        middle = between(measured, low, high, target)
        if measured.error(middle) <= target:
            high = middle
        else:
            low = middle
    return high, False


def between(measured: Measured, low: int, high: int, target: float) -> int:
    """Return a count between two: where a power law through both errors meets the target.

    Half of the way is the least that is gained where it lies beside one of them.
    """
    errors = np.log([measured.error(low), measured.error(high)])
    share = (errors[0] - np.log(target)) / max(errors[0] - errors[1], 1e-12)
    guess = round(float(np.exp(np.log(low) + share * np.log(high / low))))
    return int(np.clip(guess, low + 1, high - 1)) if high - low < 32 else (low + high) // 2


def beam(engine: str, kind: Kind, case: str, targets: Sequence[float] = TARGETS) -> Minimal:
    """Return how many parts one kind of an engine's beams needs in one case, and what they cost."""
    return beam_of(get_engine(engine), kind, case, targets)


def beam_of(engine: Adapter, kind: Kind, name: str, targets: Sequence[float] = TARGETS) -> Minimal:
    """Return how many parts one kind needs in one case: for the tip, or the first frequency."""
    case = get_scene(BEAM).case(name)
    case = replace(case, parameters=case.parameters.replace(**kind.choices))
    of_tip = name == SPIN_UP
    measured = tip(engine, kind, case) if of_tip else frequency(engine, kind, case)
    counts = kind.tip_counts if of_tip else kind.counts
    tried = climbed(measured, counts, min(targets))
    limit, doubt = measured.limit(tried)
    quantity = TIP if of_tip else OMEGA
    labels = (engine.name, kind.name, kind.part, name, quantity)
    curve = Curve(
        *labels,
        measured.order,
        tuple(tried),
        tuple(measured.error(n) for n in tried),
        limit,
        doubt,
    )
    rows = []
    for target in targets:
        count, extrapolated = fewest(measured, tried, target)
        ran = count is not None and not extrapolated
        row = Fewest(
            *labels,
            target,
            count,
            measured.error(count) if ran and count is not None else None,
            measured.error(count - 1) if ran and count is not None and count > counts[0] else None,
            extrapolated,
            limit,
            reason=reason(engine, kind, case, curve, target, count, extrapolated),
        )
        if ran and kind.part != "modes":
            row = with_cost(engine, case, row, measured)
        elif ran and of_tip:
            row = replace(row, cost=solver_cost(kind, case, row.count or 0))
        rows.append(row)
    return Minimal(curves=(curve,), fewest=tuple(rows))


def reason(
    engine: Adapter,
    kind: Kind,
    case: Case,
    curve: Curve,
    target: float,
    count: int | None,
    extrapolated: bool,
) -> str:
    """Say where a count comes from, or why there is none."""
    last = f"{curve.errors[-1]:.2g} with {curve.counts[-1]} {kind.part}"
    if extrapolated:
        return f"extrapolated by order {curve.order} from {last}"
    if count is not None:
        return "measured"
    if curve.limit - curve.doubt <= target:
        return f"not met: {last}"
    known = model_error(engine, kind, case)
    if known is None:
        why = "the model has another limit than the scene's beam"
    elif abs(known - curve.limit) > max(curve.doubt, known / 10, 1e-8):
        why = f"its claimed continuum explains only {known:.2g}: the model is not what it claims"
    else:
        why = (
            f"it converges to another beam, {Setup(engine, case, 'elements').equations.scene.title}"
        )
    return f"no number of {kind.part} meets it: {curve.limit:.2g} is left; {why}"


def model_error(engine: Adapter, kind: Kind, case: Case) -> float | None:
    """Return by how much the first frequency of the claimed continuum is off the scene's."""
    if kind.part == "modes" or case.name == SPIN_UP:
        return None
    model = engine.models(BEAM)[0]
    if not Setup(engine, case, model).approximates_continuum:
        return 0.0
    return float(abs(of_continuum(Setup(engine, case, model))[0] / exact_frequencies(case)[0] - 1))


def with_parts(case: Case, count: int) -> Case:
    """Return the case with so many segments."""
    return replace(case, parameters=case.parameters.replace(segments=float(count)))


def frequency(engine: Adapter, kind: Kind, case: Case) -> Measured:
    """Return the first frequency [rad/s] about steady rotation."""
    right = exact_frequencies(case)[:1]
    if kind.part == "modes":
        of_modes = partial(modal_frequency, SHAPES[kind.name], case.parameters)
        return Measured(of_modes, right, float(right[0]), 0)
    model = engine.models(BEAM)[0]

    fastest: dict[int, float] = {}

    def measure(count: int) -> Array:
        omega = [mode.omega for mode in engine_modes(Setup(engine, with_parts(case, count), model))]
        fastest[count] = max(omega)
        return np.array(omega[:1])

    return Measured(
        measure, right, float(right[0]), Setup(engine, case, model).element_order, fastest=fastest
    )


def modal_frequency(shapes: Callable[..., Any], p: RotatingBeam, count: int) -> Array:
    """Return the first frequency (1,) [rad/s] of the exact beam with so many modes."""
    return chain_frequencies(p, 1, beam_scene("inextensible", count, 0, shapes))


def sample_times(case: Case) -> Array:
    """Return the times [s] at which the tip is compared."""
    return np.asarray(SPACING * np.arange(1, round(case.horizon / SPACING) + 1), dtype=np.float64)


def tip_truth(case: Case) -> Array:
    """Return the tip's deflection [m] by the reference."""
    return truth(scene_equations(case), case, sample_times(case), (TIP,)).values[0]


def tip(engine: Adapter, kind: Kind, case: Case) -> Measured:
    """Return the tip's deflection over the case, with steps that do not matter."""
    right = tip_truth(case)
    size = float(np.ptp(np.append(right, 0.0)))
    if kind.part == "modes":
        return Measured(partial(modal_tip, SHAPES[kind.name], case), right, size, 0)
    model = engine.models(BEAM)[0]
    method = method_of(engine, case, model)

    def measure(count: int) -> Array:
        sized = with_parts(case, count)
        step = min(FINE, longest_step(engine, sized, model, method))
        return tip_of(run(Setup(engine, sized, model, method, step), sample_times(case)))

    return Measured(measure, right, size, Setup(engine, case, model).element_order)


def tip_of(made: Trajectory) -> Array:
    """Return the tip's deflection of a run."""
    return np.asarray(made.values[TIP])


def modal_tip(shapes: Callable[..., Any], case: Case, count: int) -> Array:
    """Return the tip's deflection [m] of the exact beam with so many modes."""
    scene = beam_scene("inextensible", count, 0, shapes)
    found = solve(scene, case.parameters, scene.state({}), sample_times(case))
    return np.asarray(scene.observe(found.states, case.parameters)[TIP])


def method_of(engine: Adapter, case: Case, model: str) -> Method:
    """Return the method of highest order of a model.

    Raises
    ------
    MbcheckError
        If it has none.
    """
    found = best_method(Setup(engine, case, model))
    if found is None:
        raise MbcheckError(f"no method of {engine.name} can run {model} of {case.scene}")
    return found


def longest_step(engine: Adapter, case: Case, model: str, method: Method) -> float:
    """Return the longest power of two [s] that is stable by theory, up to `SPACING`."""
    limit = stable_step(Setup(engine, case, model, method), case.horizon)
    return power_of_two(min(limit.step, SPACING) if limit else SPACING)


def with_cost(engine: Adapter, case: Case, row: Fewest, measured: Measured) -> Fewest:
    """Add the longest step that a count bears; of the tip also what it costs and time adds."""
    assert row.count is not None
    count = row.count
    sized, model = with_parts(case, count), engine.models(BEAM)[0]
    method = method_of(engine, case, model)
    if row.quantity != TIP:
        fastest = np.array([[measured.fastest[count] ** 2]])
        scheme = method.linear or method.scheme
        one, none = np.eye(1), np.zeros((1, 1))
        beam = vibrations(one, none, fastest)
        most = largest_stable_step(scheme, beam, case.horizon) if scheme else np.inf
        return replace(row, stable_step=most if np.isfinite(most) else None)
    limit = stable_step(Setup(engine, sized, model, method), case.horizon)
    row = replace(row, stable_step=limit and limit.step)
    longest = longest_step(engine, sized, model, method)
    fine = min(FINE, longest)
    times = sample_times(case)
    halved = tip_of(run(Setup(engine, sized, model, method, fine / 2), times))
    integration = float(np.max(np.abs(measured.values(count) - halved))) / measured.size
    step, made = first_that_meets(
        lambda one: run(Setup(engine, sized, model, method, one), times),
        lambda one: measured.off(tip_of(one)),
        longest,
        row.target,
    )
    if step is None:
        return replace(row, integration=integration, reason=f"{row.reason}; {no_step(longest)}")
    return replace(row, integration=integration, step=step, cost=cost(made, case.horizon))


def first_that_meets(
    make: Callable[[float], Trajectory],
    error: Callable[[Trajectory], float],
    longest: float,
    target: float,
) -> tuple[float | None, list[Trajectory]]:
    """Return the longest step that meets a target, a power of two times smaller, and its runs."""
    for level in range(MOST_LEVELS):
        step = longest / 2**level
        try:
            made = make(step)
        except MbcheckError:
            continue
        if error(made) <= target:
            return step, [made, *(make(step) for _ in range(REPEATS - 1))]
    return None, []


def no_step(longest: float) -> str:
    """Say that `first_that_meets` found none."""
    return f"no step from {longest:.2g} s down to {longest / 2 ** (MOST_LEVELS - 1):.2g} s meets it"


def solver_cost(kind: Kind, case: Case, count: int) -> Cost:
    """Return what the reference's solver takes with so many modes, its check included."""
    scene = beam_scene("inextensible", count, 0, SHAPES[kind.name])
    begin = perf_counter()
    found = solve(scene, case.parameters, scene.state({}), sample_times(case))
    seconds = (perf_counter() - begin) / case.horizon
    span = case.horizon
    return Cost(seconds, seconds, seconds, found.steps / span, found.rhs_evaluations / span, None)


# Closure of the loop ------------------------------------------------------------------------


@dataclass(frozen=True)
class Closure:
    """The softest closure of a loop that meets a target.

    Attributes
    ----------
    engine, model, method, case : str
    knob, unit : str
        What is turned; empty for a model that has none.
    target : float
    value : float or None
        The softest; None where none meets it.
    error : float or None
        What it leaves, whatever the step.
    softer, softer_error : float or None
        The next softer one, which misses the target; None where the softest tried meets it.
    claimed : bool
        Errors are those of the equations that the model claims; else the difference of runs to
        one with the hardest value.
    stable_step : float or None
        Longest that theory grants [s].
    step : float or None
        Longest power of two [s] with which a run meets the target.
    measured : float or None
        Error of that run.
    cost : Cost or None
        Of that run.
    reason : str
    """

    engine: str
    model: str
    method: str
    case: str
    knob: str
    unit: str
    target: float
    value: float | None
    error: float | None
    softer: float | None
    softer_error: float | None
    claimed: bool
    stable_step: float | None = None
    step: float | None = None
    measured: float | None = None
    cost: Cost | None = None
    reason: str = ""


CLOSURE_TIMES = tuple(2.0 ** (-k / 4) for k in range(-8, 41))
"""Of MuJoCo's hard closure [s], from soft to hard."""

SOFTNESSES = tuple(2.0 ** (-k / 2) for k in range(2, 27))
"""Of an impedance: 1 - d; MuJoCo's hardest is 1e-4."""

NEWTON_TOLERANCES = tuple(10.0**-k for k in range(12))

LOOP_SPACING = 2.0**-5
"""Of the samples [s]; no step is longer."""


def loop_times(case: Case) -> Array:
    """Return the times [s] at which a run of the loop is compared."""
    return np.asarray(
        LOOP_SPACING * np.arange(1, round(case.horizon / LOOP_SPACING) + 1), dtype=np.float64
    )


def loop(engine: str, targets: Sequence[float] = (*TARGETS, CLOSED)) -> Minimal:
    """Return how softly an engine may close the loop, and what a harder closure costs."""
    if engine == "mujoco":
        hard: Callable[[float], Adapter] = partial(get_engine(engine).with_option, "closure_time")
        soft: Callable[[float], Adapter] = partial(
            mujoco("Softened").make().with_option, "softness"
        )
        knobs: list[tuple[str, str, str, Sequence[float], Callable[[float], Adapter]]] = [
            ("connect_hard", "closure_time", "s", CLOSURE_TIMES, hard),
            ("connect", "softness", "1", SOFTNESSES, soft),
        ]
        rows = [softest(*knob, target) for knob in knobs for target in targets]
        rows += [as_it_is(get_engine(engine), "connect", target) for target in targets]
        return Minimal(closures=tuple(rows))
    if engine == "exudyn":
        return Minimal(closures=tuple(loosest(get_engine(engine), t) for t in targets))
    return Minimal()


def loop_case() -> Case:
    """Return the case on which closures are compared."""
    return get_scene(LOOP).case("rotation")


def left_open(engine: Adapter, model: str) -> float:
    """Return how far the claimed equations are off the exact ones, over the states' sizes."""
    case = loop_case()
    names, times = get_scene(LOOP).observables, loop_times(case)
    right = roundoff_reference(scene_equations(case), case, times, names)
    own = roundoff_reference(Setup(engine, case, model).equations, case, times, names)
    return float(np.max(np.abs(own.values - right.values) / right.size[:, None]))


def softest(
    model: str,
    knob: str,
    unit: str,
    values: Sequence[float],
    made: Callable[[float], Adapter],
    target: float,
) -> Closure:
    """Return the softest of some values, the softest first, that meets a target."""

    def error(i: int) -> float:
        return left_open(made(values[i]), model)

    low, high = 0, len(values) - 1
    method = method_of(made(values[0]), loop_case(), model)
    row = Closure(
        made(values[0]).name, model, method.name, loop_case().name, knob, unit, target,
        *(None,) * 4, claimed=True,
    )  # fmt: skip
    if error(low) <= target:
        return priced(
            made(values[0]),
            replace(row, value=values[0], error=error(0), reason="the softest tried"),
        )
    if error(high) > target:
        return replace(row, reason=f"the hardest tried leaves {error(high):.2g}")
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if error(middle) <= target else (middle, high)
    return priced(
        made(values[high]),
        replace(
            row,
            value=values[high],
            error=error(high),
            softer=values[low],
            softer_error=error(low),
            reason="found between it and the next softer one",
        ),
    )


def as_it_is(engine: Adapter, model: str, target: float) -> Closure:
    """Return whether a model's own closure meets a target."""
    method = method_of(engine, loop_case(), model)
    error = left_open(engine, model)
    row = Closure(
        engine.name, model, method.name, loop_case().name, "", "", target,
        None, error, None, None, claimed=True,
    )  # fmt: skip
    if error > target:
        return replace(row, reason=f"as the engine closes loops by default, {error:.2g} is left")
    return priced(engine, replace(row, reason="as the engine closes loops by default"))


def loop_error(made: Trajectory) -> float:
    """Return the error of a run of the loop, over the states' sizes."""
    case = loop_case()
    names = get_scene(LOOP).observables
    right = roundoff_reference(scene_equations(case), case, loop_times(case), names)
    return float(np.max(np.abs(made.matrix(names) - right.values) / right.size[:, None]))


def priced(engine: Adapter, row: Closure) -> Closure:
    """Add the longest step with which a run meets the target, and what it costs."""
    case = loop_case()
    method = next(item for item in engine.methods if item.name == row.method)
    limit = stable_step(Setup(engine, case, row.model, method), case.horizon)
    longest = power_of_two(min(limit.step, LOOP_SPACING) if limit else LOOP_SPACING)
    step, made = first_that_meets(
        lambda one: run(Setup(engine, case, row.model, method, one), loop_times(case)),
        loop_error,
        longest,
        row.target,
    )
    row = replace(row, stable_step=limit and limit.step)
    if step is None:
        return replace(row, reason=f"{row.reason}; {no_step(longest)}")
    return replace(row, step=step, measured=loop_error(made[0]), cost=cost(made, case.horizon))


def loosest(engine: Adapter, target: float) -> Closure:
    """Return the loosest Newton tolerance of joints that are closed scene_equations."""
    case, model = loop_case(), engine.models(LOOP)[0]
    method, times = method_of(engine, case, model), loop_times(case)
    names = get_scene(LOOP).observables
    size = roundoff_reference(scene_equations(case), case, times, names).size[:, None]

    def make(tolerance: float, step: float) -> Trajectory:
        turned = engine.with_option("newton_tolerance", tolerance)
        return run(Setup(turned, case, model, method, step), times)

    row = Closure(
        engine.name, model, method.name, case.name, "newton_tolerance", "m, rad", target,
        *(None,) * 4, claimed=False,
    )  # fmt: skip
    tightest = NEWTON_TOLERANCES[-1]
    step, made = first_that_meets(partial(make, tightest), loop_error, LOOP_SPACING, target)
    if step is None:
        return replace(row, reason=no_step(LOOP_SPACING))
    right = made[0].matrix(names)
    missed: tuple[float | None, float | None] = None, None
    exact = "joints are closed scene_equations; only the solver may stop early"
    for tolerance in NEWTON_TOLERANCES:
        runs = [make(tolerance, step) for _ in range(REPEATS)]
        off = float(np.max(np.abs(runs[0].matrix(names) - right) / size))
        if loop_error(runs[0]) <= target and off <= target:
            return replace(
                row,
                value=tolerance,
                error=off,
                softer=missed[0],
                softer_error=missed[1],
                step=step,
                measured=loop_error(runs[0]),
                cost=cost(runs, case.horizon),
                reason=exact if missed[0] else f"{exact}: the loosest that was tried meets it",
            )
        missed = tolerance, off
    return replace(row, reason="no tolerance meets it")


# All of it ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Minimal:
    """The least that meets targets, and what may be left out."""

    curves: tuple[Curve, ...] = ()
    fewest: tuple[Fewest, ...] = ()
    closures: tuple[Closure, ...] = ()
    left_out: tuple[LeftOut, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return asdict(self)


def joined(parts: Sequence[Minimal]) -> Minimal:
    """Return all parts as one."""
    return Minimal(
        *(
            tuple(chain.from_iterable(getattr(part, name) for part in parts))
            for name in ("curves", "fewest", "closures", "left_out")
        )
    )


def left_out(scene: str, engine: str, targets: Sequence[float] = TARGETS) -> Minimal:
    """Return what may be left out of an engine's models of a scene."""
    return Minimal(left_out=tuple(rows_of(scene, engine, targets)))


def tasks(
    scenes: Sequence[str], engines: Sequence[str], targets: Sequence[float] = TARGETS
) -> list[tuple[str, Callable[[], Minimal]]]:
    """Return the pieces with their names, each ready for a process of its own."""
    found: list[tuple[str, Callable[[], Minimal]]] = []
    for engine in (*engines, "reference"):
        if BEAM in scenes:
            found += [
                (f"{BEAM} {engine} {kind.name}, {case}", partial(beam, engine, kind, case, targets))
                for kind in KINDS.get(engine, ())
                for case in (*STEADY, SPIN_UP)
            ]
        if LOOP in scenes and engine != "reference":
            all_targets = tuple(dict.fromkeys((*targets, CLOSED)))
            found.append((f"{LOOP} {engine} closure", partial(loop, engine, all_targets)))
        found += [
            (f"{scene} {engine} left out", partial(left_out, scene, engine, targets))
            for scene in scenes
            if (scene, engine) in ROWS
        ]
    return found
