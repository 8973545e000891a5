"""Speed of the suite as ratios within one run; nothing here is an absolute claim.

1. `solve_many` against a loop of SciPy's ``solve_ivp(DOP853)`` over the same parameter
   points, at equal measured error. The loop is timed on a sample of the points, once with the
   suite's right-hand side and once with one of plain floats, the fastest that Python allows.
2. An engine through `mbcheck.comparisons.engines.protocol.run` (container, model building, guard,
   100 samples) against the engine's own step loop on a model that is built already.

Times are CPU times of this process. What is compared runs in turn, and each turn gives one
ratio; printed are the median and the range.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp

from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.exudyn.engine import EXPLICIT, place_initial, quiet
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.run import contained
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.reference.errors import EngineUnavailableError
from mbcheck.reference.hula_hoop.equations import SCENE, HulaHoop
from mbcheck.reference.scene import Case
from mbcheck.reference.solve.batched import solve_many

Array = NDArray[np.float64]
Run = Callable[[], Any]

START = np.array([0.01, 0.3, 0.0, 18.0])
PERIODS = 4
TOLERANCE, TRUTH = 1e-6, 1e-12
"""Tolerances of the reference that is timed, and of the run that measures errors."""

RTOLS = 10.0 ** -np.arange(9.0, 14.0)
"""Tolerances of the loop among which the one of equal error is interpolated."""

SAMPLES = 100
STEP = 2.0**-12
ENGINE_RUNS = (
    ("mujoco", "tree", "Euler"),
    ("mujoco", "tree", "RK4"),
    ("exudyn", "kinematic_tree", "RK44"),
    ("exudyn", "kinematic_tree", "RK67"),
    ("exudyn", "kinematic_tree", "GeneralizedAlpha"),
    ("exudyn", "redundant", "GeneralizedAlpha"),
)


def cpu_time(work: Run) -> float:
    """CPU time [s] of one call."""
    begin = process_time()
    work()
    return process_time() - begin


def interleaved(works: Mapping[str, Run], turns: int) -> dict[str, Array]:
    """CPU times (turns,) of each work, all of them once in every turn."""
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(turns):
        for name, work in works.items():
            times[name].append(cpu_time(work))
    return {name: np.array(values) for name, values in times.items()}


def spread(ratios: Array) -> str:
    """Median and range."""
    return f"{np.median(ratios):.3g} ({np.min(ratios):.3g} .. {np.max(ratios):.3g})"


# --- the reference


def points(count: int) -> tuple[Any, Array]:
    """Parameters over the plane of force and frequency, and their sample times (n_t, count)."""
    random = np.random.default_rng(0)
    parameters = HulaHoop().replace(
        force_amplitude=random.uniform(40.0, 80.0, count),
        force_frequency=random.uniform(2.5, 4.0, count),
    )
    return parameters, np.arange(1.0, PERIODS + 1)[:, None] * SCENE.period(parameters)


def at(parameters: Any, index: Any) -> Any:
    """Parameters of some of the points."""
    values = parameters.as_dict().items()
    return parameters.replace(**{name: v[index] if np.ndim(v) else v for name, v in values})


def plain_right_hand_side(parameters: Any) -> Callable[[float, Array], list[float]]:
    """The suite's equations on Python floats."""
    coefficients = SCENE.coefficients(parameters)
    c = type(coefficients)(*map(float, coefficients))
    drive, accelerations = SCENE.drive, SCENE.accelerations
    assert drive is not None

    def right_hand_side(t: float, x: Array) -> list[float]:
        y, theta, y_dot, theta_dot = x.tolist()
        u = drive(t, c, math)
        return [y_dot, theta_dot, *accelerations(u, (y, theta), (y_dot, theta_dot), c, math)]

    return right_hand_side


def loop(parameters: Any, times: Array, rtol: float, right_hand_side: Any) -> Array:
    """States (2 n, points, n_t) by one solve_ivp after the other."""
    size = np.array([0.05, 5.0, 1.0, 20.0])
    solutions = [
        solve_ivp(
            right_hand_side(at(parameters, i)),
            (0.0, times[-1, i]),
            START,
            "DOP853",
            times[:, i],
            rtol=rtol,
            atol=rtol * size,
        ).y
        for i in range(times.shape[1])
    ]
    return np.stack(solutions, axis=1)


def typical_error(states: Array, truth: Array) -> float:
    """Median over the points of the largest error, relative to each state's range."""
    error = np.max(np.abs(states - truth), axis=2) / np.max(np.abs(truth), axis=2)
    return float(np.median(np.max(error, axis=0)))


def rtol_of_error(parameters: Any, times: Array, truth: Array, wanted: float) -> float:
    """Tolerance at which the loop makes this error; its tightest if that is not enough."""
    errors = []
    for rtol in RTOLS:
        errors.append(typical_error(loop(parameters, times, rtol, plain_right_hand_side), truth))
        if errors[-1] < wanted:
            break
    tried = np.log(RTOLS[: len(errors)])
    return float(np.exp(np.interp(-np.log(wanted), -np.log(errors), tried)))


def reference_table(counts: tuple[int, ...], sampled: int, turns: int) -> Table:
    """Run part 1."""
    table = Table(title=f"loop of solve_ivp / solve_many, equal error, {PERIODS} periods")
    for heading in ("points", "error", "of the loop", "suite's f", "f of floats"):
        table.add_column(heading, justify="right", no_wrap=True)
    for count in counts:
        parameters, times = points(count)
        chosen = np.linspace(0, count - 1, sampled).astype(int)
        few, few_times = at(parameters, chosen), times[:, chosen]
        truth = solve_many(SCENE, few, START, few_times, 0.0, TRUTH).states
        fast = partial(solve_many, SCENE, parameters, START, times, 0.0, TOLERANCE)
        error = typical_error(fast().states[:, chosen], truth)
        rtol = rtol_of_error(few, few_times, truth, error)
        slow = partial(loop, few, few_times, rtol)
        works: dict[str, Run] = {
            "fast": fast,
            "suite": partial(slow, SCENE.right_hand_side),
            "floats": partial(slow, plain_right_hand_side),
        }
        seconds = interleaved(works, turns)
        reached = typical_error(slow(plain_right_hand_side), truth)
        share = count / sampled
        ratios = (spread(share * seconds[n] / seconds["fast"]) for n in ("suite", "floats"))
        table.add_row(str(count), f"{error:.1e}", f"{reached:.1e}", *ratios)
    return table


# --- the engines


def bare_mujoco(engine: Any, case: Case, model: str, method: Method, steps: int) -> float:
    """CPU time [s] of ``mj_step`` on a loaded model."""
    mujoco, system = engine.inner.mujoco, engine.bind(case, model).system(case)
    compiled = engine.inner.compiled(system.mjcf, model, method.name, STEP)
    data = engine.inner.data(compiled, 0.0, system.positions, system.velocities)
    return cpu_time(lambda: mujoco.mj_step(compiled, data, steps))


def bare_exudyn(engine: Any, case: Case, model: str, method: Method, steps: int) -> float:
    """CPU time [s] of ``SolveDynamic`` on an assembled system."""
    exudyn = engine.inner.exudyn
    with ExitStack() as stack:
        stack.enter_context(contained())
        stack.enter_context(quiet(exudyn))
        system = stack.enter_context(engine.inner.opened(case, model))
        place_initial(exudyn, system, SCENE.state(case.state))
        settings = engine.inner.settings(method, 0.0, STEP)
        settings.timeIntegration.endTime = steps * STEP
        settings.timeIntegration.numberOfSteps = steps
        kind = getattr(exudyn.DynamicSolverType, method.name)
        keep = method not in EXPLICIT
        return cpu_time(
            lambda: system.mbs.SolveDynamic(settings, solverType=kind, updateInitialValues=keep)
        )


def through_suite(engine: Adapter, case: Case, model: str, method: Method, steps: int) -> float:
    """CPU time [s] of everything that a check does to get a trajectory."""
    times = STEP * np.rint(np.linspace(0, steps, SAMPLES + 1)[1:])
    return cpu_time(lambda: run(Setup(engine, case, model, method, STEP), times))


BARE = {"mujoco": bare_mujoco, "exudyn": bare_exudyn}


def engine_table(counts: tuple[int, ...], turns: int) -> Table:
    """Run part 2."""
    table = Table(title=f"throughput of the suite / of the bare engine, {SAMPLES} samples")
    for heading in ("engine", "model", "method", *(f"{count:.0e} steps" for count in counts)):
        table.add_column(heading, no_wrap=True)
    case = SCENE.case("spinning_3hz_60n")
    for name, model, method_name in ENGINE_RUNS:
        try:
            engine = get_engine(name)
        except EngineUnavailableError as error:
            table.add_row(name, model, method_name, str(error))
            continue
        method = next(item for item in engine.methods if item.name == method_name)
        cells = []
        for steps in counts:
            pairs = [
                (job(engine, case, model, method, steps), other(engine, case, model, method, steps))
                for job, other in [(BARE[name], through_suite)] * (turns + 1)
            ][1:]  # the first turn imports and warms up
            bare, suite = np.array(pairs).T
            cells.append(spread(bare / suite))
        table.add_row(name, model, method_name, *cells)
    return table


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="fewer points, steps and turns")
    quick = parser.parse_args().quick
    console = Console()
    if quick:
        console.print(reference_table((1024,), sampled=6, turns=2))
        console.print(engine_table((10_000,), turns=3))
    else:
        console.print(reference_table((1024, 4096), sampled=32, turns=5))
        console.print(engine_table((10_000, 100_000), turns=5))


if __name__ == "__main__":
    main()
