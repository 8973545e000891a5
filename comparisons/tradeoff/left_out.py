"""What a scene's models may leave out, and what that costs or saves: pairs of runs.

Each row holds two models that differ in one thing against the scene's reference: one that has
it, one that leaves it out. Where neither engine can have it, errors are those of the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np

from ...models.hula_hoop import mjcf as hoop
from ...models.rotor_pendulum import mjcf as rotors
from ...reference import get_scene
from ...reference.scene import Array, Case
from ...reference.solve.single import solve
from ..checks.kinds.elements import engine_modes, exact, of_continuum
from ..checks.truth import permitted_horizon, roundoff_reference
from ..engines.adapter import Adapter
from ..engines.equations import scene_equations
from ..engines.registry import get_engine
from ..engines.run import run
from ..engines.setup import Setup, power_of_two
from ..engines.variants.catalogue import exudyn, mujoco
from .series import TARGETS

REPEATS = 7
"""Pairs of runs whose wall times are compared."""

EQUAL = 0.03
"""Costs that differ by less than this share are told apart no further."""


@dataclass(frozen=True)
class LeftOut:
    """One thing that may be left out of a model.

    Attributes
    ----------
    scene, engine : str
    left_out : str
        What it is.
    compared : str
        The two models, the one that has it first.
    case : str
    error_with : float or None
        Against the reference of the whole scene, over the sizes of its observables; None where
        it cannot be had.
    error_without : float
    cost_ratio : float or None
        Cost with it over cost without: above 1 leaving it out saves.
    lowest, highest : float or None
        Quartiles of the ratio over repeated pairs.
    cost_of : str
        What was compared: ``wall time``, ``steps`` or ``right-hand sides``.
    required : mapping of str to bool or None
        By target: whether it has to be there; None where the model that has it misses too.
    verdict : str
    """

    scene: str
    engine: str
    left_out: str
    compared: str
    case: str
    error_with: float | None
    error_without: float
    cost_ratio: float | None
    lowest: float | None
    highest: float | None
    cost_of: str
    required: Mapping[str, bool | None] = field(default_factory=dict)
    verdict: str = ""


def unjudged(
    scene: str,
    engine: str,
    left_out: str,
    compared: str,
    case: str,
    errors: tuple[float | None, float],
    ratios: Sequence[float],
    cost_of: str,
) -> LeftOut:
    """Return the row of a pair, its numbers without what they mean."""
    low, ratio, high = np.quantile(ratios, (0.25, 0.5, 0.75)).tolist() if ratios else (None,) * 3
    return LeftOut(scene, engine, left_out, compared, case, *errors, ratio, low, high, cost_of)


def judged(row: LeftOut, targets: Sequence[float]) -> LeftOut:
    """Return a row with what it means for these targets."""
    has, lacks = row.error_with, row.error_without
    required: dict[str, bool | None] = {}
    for target in targets:
        if lacks <= target:
            required[f"{target:g}"] = False
        else:
            required[f"{target:g}"] = True if (has or 0.0) <= target else None
    ratio = row.lowest, row.cost_ratio, row.highest
    said = verdict(has, lacks, ratio, row.cost_of, required)
    return replace(row, required=required, verdict=said)


def verdict(
    has: float | None,
    lacks: float,
    ratio: tuple[float | None, float | None, float | None],
    cost_of: str,
    required: Mapping[str, bool | None],
) -> str:
    """Say what the numbers mean."""
    needed = [float(name) for name, value in required.items() if value]
    spared = [float(name) for name, value in required.items() if value is False]
    said = [f"required for {percent(max(needed))} and finer"] if needed else []
    said += [f"not required for {percent(min(spared))}"] if spared else []
    said = said or ["not what limits the error here"]
    errors = f"{lacks:.2g} without it" + ("" if has is None else f", {has:.2g} with it")
    first = f"{', '.join(said)}: {errors}"
    low, middle, high = ratio
    if low is None or middle is None or high is None:
        return first
    if low <= 1 <= high or abs(middle - 1) < EQUAL:
        return f"{first}; no difference in {cost_of} above the scatter"
    change = (
        f"saves a factor of {middle:.2g}" if middle > 1 else f"costs a factor of {1 / middle:.2g}"
    )
    return f"{first}; leaving it out {change} in {cost_of}"


def percent(target: float) -> str:
    """Return a relative error in percent."""
    return f"{100 * target:g} %"


# Pairs of runs ------------------------------------------------------------------------------


def setup_of(engine: Adapter, case: Case, model: str, method: str, step: float) -> Setup:
    """Return a setup with a method of this name."""
    methods = {item.name: item for item in engine.methods}
    return Setup(engine, case, model, methods[method], step)


def samples(case: Case, spacing: float, span: float) -> Array:
    """Return evenly spaced times [s] over a span."""
    numbers = np.arange(1, int(span / spacing * (1 + 1e-12)) + 1)
    return np.asarray(case.start_time + spacing * numbers, dtype=np.float64)


def pair(left_out: str, compared: str, has: Setup, lacks: Setup, span: float) -> LeftOut:
    """Run both over a span [s], in turns, and compare errors and wall times."""
    case, names = has.case, get_scene(has.case.scene).observables
    spacing = max(has.step_size, lacks.step_size, power_of_two(span / 64))
    times = samples(case, spacing, span)
    right = roundoff_reference(scene_equations(case), case, times, names)
    made = [(run(has, times), run(lacks, times)) for _ in range(REPEATS)]
    errors = [
        float(np.max(np.abs(one.matrix(names) - right.values) / right.size[:, None]))
        for one in made[0]
    ]
    return unjudged(
        case.scene, has.engine.name, left_out, compared, case.name, (errors[0], errors[1]),
        [one.seconds / other.seconds for one, other in made], "wall time",
    )  # fmt: skip


STEP = 2.0**-11
"""Of the pairs [s], but where a model bears less: 10 to 160 steps in the fastest motion."""


def redundant(
    scene: str, case_name: str, model: str, span: float, method: str = "GeneralizedAlpha"
) -> LeftOut:
    """Compare Exudyn's absolute coordinates with joints and its minimal ones.

    With the same method, and with an explicit one, which joints do not permit.
    """
    engine, case = get_engine("exudyn"), get_scene(scene).case(case_name)
    return pair(
        "redundant coordinates",
        f"redundant by GeneralizedAlpha, {model} by {method}, the same step",
        setup_of(engine, case, "redundant", "GeneralizedAlpha", STEP),
        setup_of(engine, case, model, method, STEP),
        span,
    )


def bare(scene: str, case_name: str, span: float) -> LeftOut:
    """Compare MuJoCo with its machinery for constraints and with the flag that disables it."""
    case = get_scene(scene).case(case_name)
    setups = [
        setup_of(one, case, "tree", "RK4", STEP) for one in (mujoco().make(), mujoco("Bare").make())
    ]
    return pair(
        "solver of constraints, of a tree without any",
        "tree, tree with the flag constraint off: RK4",
        setups[0],
        setups[1],
        span,
    )


def floor_of_hoop() -> LeftOut:
    """Tell what the least inertia that MuJoCo takes changes, by its equations."""
    engine, case = get_engine("mujoco"), get_scene("hula_hoop").case("spinning_3hz_60n")
    names = get_scene(case.scene).observables
    times = samples(case, 2.0**-7, case.horizon)
    own = Setup(engine, case, "tree").equations
    right, found = (
        roundoff_reference(one, case, times, names) for one in (scene_equations(case), own)
    )
    off = float(np.max(np.abs(found.values - right.values) / right.size[:, None]))
    compared = f"none, the floor of {hoop.INERTIA_FLOOR:g} kg m^2: their equations"
    return floor(case, compared, off)


def floor_of_rotors() -> LeftOut:
    """Bound the same of the rotors, whose equations have no such inertia."""
    case = get_scene("rotor_pendulum").case("case_2_startup")
    p = case.parameters
    share = rotors.INERTIA_FLOOR / (p.rotor_mass * p.eccentricity**2)
    off = share * max(1.0, permitted_horizon(case)[1])
    least = f"none, the floor of {rotors.INERTIA_FLOOR:g} kg m^2"
    return floor(case, f"{least}: a bound, its share times growth", off)


def floor(case: Case, compared: str, off: float) -> LeftOut:
    """Return the row of a floor that MuJoCo cannot be without."""
    return unjudged(
        case.scene,
        "mujoco",
        "point masses without inertia",
        compared,
        case.name,
        (None, off),
        (),
        "",
    )


def inertia_in_exudyn() -> LeftOut:
    """Run Exudyn, which takes a point mass, with no inertia and with MuJoCo's floor."""
    engine, case = get_engine("exudyn"), get_scene("hula_hoop").case("spinning_3hz_60n")
    p = case.parameters
    ratio = hoop.INERTIA_FLOOR / (p.free_mass * p.rod_length**2)
    floored = replace(case, parameters=p.replace(inertia_ratio=ratio))
    setups = [setup_of(engine, one, "kinematic_tree", "RK67", STEP) for one in (case, floored)]
    return pair(
        "point masses without inertia", "none, MuJoCo's floor: RK67", setups[0], setups[1], 0.5
    )


def third_dimension() -> LeftOut:
    """Compare plane bodies of Exudyn with those in space; the plate, since a body needs inertia."""
    case = replace(
        get_scene("hula_hoop").case("semicircle_3hz_60n"),
        name="semicircle_3hz_60n, spinning",
        state=get_scene("hula_hoop").case("spinning_3hz_60n").state,
    )
    spatial = setup_of(exudyn("Spatial").make(), case, "spatial", "GeneralizedAlpha", STEP)
    plane = setup_of(get_engine("exudyn"), case, "redundant", "GeneralizedAlpha", STEP)
    return pair(
        "third dimension", "bodies in space, plane bodies: GeneralizedAlpha", spatial, plane, 0.5
    )


def masses_of_the_loop() -> LeftOut:
    """Compare the closed loop with MuJoCo's transmission, which has neither rod nor slider."""
    engine, case = get_engine("mujoco"), get_scene("speed_regulator").case("rotation")
    light = replace(case, parameters=case.parameters.replace(rod_mass=0.0, slider_mass=0.0))
    return pair(
        "masses of rod and slider",
        "connect_hard, transmission: RK4",
        setup_of(engine, case, "connect_hard", "RK4", STEP),
        setup_of(engine, light, "transmission", "RK4", STEP),
        case.horizon,
    )


# The beam -----------------------------------------------------------------------------------

TIP = "tip_deflection"


def beam_case() -> Case:
    """Return the case whose tip is looked at."""
    return get_scene("rotating_beam").case("spin_up_quick")


@lru_cache(maxsize=8)
def solved(theory: str) -> tuple[Array, int]:
    """Return the tip's deflection [m] by a theory of the reference, and its right-hand sides."""
    case, scene = beam_case(), get_scene("rotating_beam")
    own = scene.variants.get(theory, scene)
    times = samples(case, 2.0**-4, case.horizon)
    found = solve(own, case.parameters, own.state({}), times)
    return own.observe(found.states, case.parameters)[TIP], found.rhs_evaluations


def theories(left_out: str, truth: str, has: str, lacks: str) -> LeftOut:
    """Compare two theories of the beam by the tip, over its range, with a third as the truth."""
    right = solved(truth)[0]
    errors = [float(np.max(np.abs(solved(one)[0] - right)) / np.ptp(right)) for one in (has, lacks)]
    return unjudged(
        "rotating_beam", "reference", left_out, f"{has}, {lacks}", beam_case().name,
        (errors[0], errors[1]), [solved(has)[1] / solved(lacks)[1]], "right-hand sides",
    )  # fmt: skip


def stretch_in_chains(case_name: str) -> LeftOut:
    """Tell what rods that do not stretch leave out of the first frequency, and save in steps.

    An explicit method's step goes with the highest frequency: elements that stretch have waves
    along the beam.
    """
    case = get_scene("rotating_beam").case(case_name)
    chain_of, elements = get_engine("mujoco"), get_engine("exudyn")
    model = elements.models("rotating_beam")[0]
    off = abs(of_continuum(Setup(elements, case, model))[0] / exact(case)[0] - 1)
    fastest = [
        max(
            mode.omega
            for mode in engine_modes(Setup(engine, case, engine.models("rotating_beam")[0]))
        )
        for engine in (elements, chain_of)
    ]
    return unjudged(
        case.scene, "mujoco", "stretch along the beam",
        f"{case.parameters.segments:g} ANCF elements, as many rods: first and highest frequency",
        case_name, (0.0, float(off)), [fastest[0] / fastest[1]], "steps of an explicit method",
    )  # fmt: skip


def shear() -> LeftOut:
    """Compare elements that shear with those that only stretch, as many."""
    engine, case = get_engine("exudyn"), beam_case()
    model = engine.models(case.scene)[0]
    setups = [
        setup_of(
            engine,
            replace(case, parameters=case.parameters.replace(element=element)),
            model,
            "GeneralizedAlpha",
            2.0**-8,
        )
        for element in ("geometrically_exact", "ancf")
    ]
    return pair(
        "shear and rotary inertia of cross sections",
        f"geometrically_exact, ancf: {case.parameters.segments:g} elements, GeneralizedAlpha",
        setups[0],
        setups[1],
        case.horizon,
    )


# Rows ---------------------------------------------------------------------------------------

ROWS: Mapping[tuple[str, str], tuple[Callable[[], LeftOut], ...]] = {
    ("hula_hoop", "mujoco"): (
        floor_of_hoop,
        partial(bare, "hula_hoop", "spinning_3hz_60n", 0.5),
    ),
    ("hula_hoop", "exudyn"): (
        inertia_in_exudyn,
        partial(redundant, "hula_hoop", "spinning_3hz_60n", "kinematic_tree", 0.5),
        partial(redundant, "hula_hoop", "spinning_3hz_60n", "kinematic_tree", 0.5, "RK44"),
        third_dimension,
    ),
    ("rotor_pendulum", "mujoco"): (
        floor_of_rotors,
        partial(bare, "rotor_pendulum", "case_2_startup", 0.5),
    ),
    ("rotor_pendulum", "exudyn"): (
        partial(redundant, "rotor_pendulum", "case_2_startup", "kinematic_tree", 0.5),
        partial(redundant, "rotor_pendulum", "case_2_startup", "kinematic_tree", 0.5, "RK44"),
    ),
    ("speed_regulator", "mujoco"): (masses_of_the_loop,),
    ("speed_regulator", "exudyn"): (
        partial(redundant, "speed_regulator", "rotation", "one_dof", 1.0),
        partial(redundant, "speed_regulator", "rotation", "one_dof", 1.0, "RK44"),
    ),
    ("rotating_beam", "reference"): (
        partial(theories, "stretch along the beam", "extensible", "extensible", "exact"),
        partial(theories, "large deflections", "exact", "exact", "second_order"),
        partial(theories, "foreshortening", "second_order", "second_order", "zero_order"),
    ),
    ("rotating_beam", "mujoco"): (
        partial(stretch_in_chains, "steady_4"),
        partial(stretch_in_chains, "steady_12"),
    ),
    ("rotating_beam", "exudyn"): (shear,),
}
"""Scene and engine -> what makes each row."""


def rows_of(scene: str, engine: str, targets: Sequence[float] = TARGETS) -> list[LeftOut]:
    """Return what may be left out of an engine's models of a scene."""
    return [judged(make(), targets) for make in ROWS.get((scene, engine), ())]
