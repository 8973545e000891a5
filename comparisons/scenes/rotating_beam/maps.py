"""Maps of `rotating_beam`: natural frequencies, and stability, in steady rotation.

Both are of the straight beam on a hub that keeps its speed, whatever drives it in the scene.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from ....reference.errors import MbcheckError
from ....reference.linear import Mode, linearise, modes
from ....reference.rotating_beam import EXTENSIBLE, SCENE, SECOND_ORDER, ZERO_ORDER
from ....reference.rotating_beam.frequencies.assumed_modes import assumed_modes
from ....reference.rotating_beam.frequencies.numbers import numbers, time_unit
from ....reference.rotating_beam.frequencies.stretching import frequencies
from ....reference.rotating_beam.parameters import FIRST, RotatingBeam, period, rotation
from ....reference.scene import Array, Case, EquationsOfMotion
from ...checks import elements
from ...engines.registry import REFERENCE
from ...engines.run import call_engine
from ...engines.setup import Setup
from ...queries.query import choose_engine, known_name
from ..quantity import AxisName, Points, Quantity, QuantityValues, Variable

COUNT = 3
"""Chordwise frequencies of a map."""

PAPER_MODES = 2
"""Assumed modes of the paper's figure 3."""

Values = dict[str, float]


# Frequencies --------------------------------------------------------------------------------


def continuum(p: RotatingBeam, kind: str) -> Values:
    """Return the frequencies [rad/s] of a continuum, and bounds on their errors."""
    chordwise = frequencies(p, "chordwise", COUNT, kind)
    flapwise = frequencies(p, "flapwise", 1, kind)
    bounds = {f"bound_{i}": float(bound) for i, bound in enumerate(chordwise.bound, start=1)}
    bounds["flapwise_bound_1"] = float(flapwise.bound[0])
    return by_name(p, chordwise.omega, flapwise.omega[0]) | bounds


def two_assumed_modes(p: RotatingBeam) -> Values:
    """Return the frequencies by (17) with the paper's two modes."""
    n, unit = numbers(p), time_unit(p)
    chordwise, flapwise = (
        assumed_modes(n, PAPER_MODES, plane, PAPER_MODES) / unit
        for plane in ("chordwise", "flapwise")
    )
    return by_name(p, chordwise, flapwise[0])


def without_foreshortening(p: RotatingBeam) -> Values:
    """Return ``sqrt(omega_rest^2 - Omega^2)``: what (17) gives without D; NaN where unstable."""
    rest = frequencies(p.replace(angular_speed=0.0), "flapwise", COUNT).omega
    with np.errstate(invalid="ignore"):
        chordwise = np.sqrt(rest**2 - p.angular_speed**2)
    return by_name(p, chordwise, rest[0])


def engine_frequencies(p: RotatingBeam, engine: str, model: str) -> Values:
    """Return the frequencies of an engine's matrices, in the plane of rotation."""
    return by_name(p, np.array([mode.omega for mode in engine_modes(p, engine, model)]))


def by_name(p: RotatingBeam, chordwise: Array, flapwise: float = np.nan) -> Values:
    """Return frequencies [rad/s] as variables of a map."""
    return {
        **{f"frequency_{i}": float(omega) for i, omega in enumerate(chordwise[:COUNT], start=1)},
        "flapwise_1": float(flapwise),
        "nondimensional_1": float(chordwise[0]) * time_unit(p),
    }


FREQUENCY: Mapping[str, Callable[[RotatingBeam], Values]] = {
    "exact": partial(continuum, kind="inextensible"),
    "extensible": partial(continuum, kind="extensible"),
    "paper": two_assumed_modes,
    "zero_order": without_foreshortening,
}

FREQUENCY_VARIABLES = {
    **{
        f"frequency_{i}": Variable("rad/s", f"chordwise frequency {i} (in the plane of rotation)")
        for i in range(1, COUNT + 1)
    },
    "flapwise_1": Variable("rad/s", "first flapwise frequency; of the reference only"),
    "nondimensional_1": Variable("1", "frequency_1 times sqrt(rho A L^4 / (E I)), as in (19)"),
    **{
        f"{name}bound_{i}": Variable(
            "rad/s", f"bound on the error of {name or 'frequency_'}{i}; of the exact models only"
        )
        for name, count in (("", COUNT), ("flapwise_", 1))
        for i in range(1, count + 1)
    },
}


# Stability ----------------------------------------------------------------------------------

GROWING = 1e-9
"""Share of the highest frequency above which a growth rate is not rounding (1e-15 of it)."""

PERTURBATION = 1e-4
"""Relative change of the speed that leaves a robust class as it is."""


def growth_rate(all_modes: list[Mode]) -> float:
    """Return the largest growth rate [1/s], 0 where none grows."""
    rate, top = max(mode.re for mode in all_modes), max(mode.omega for mode in all_modes)
    return rate if rate > GROWING * top else 0.0


def model_growth(p: RotatingBeam, scene: EquationsOfMotion) -> float:
    """Return the growth rate [1/s] of departures from steady rotation, by a scene's equations."""
    steady = p.replace(drive="prescribed", ramp_time=0.0)
    return growth_rate(
        modes(*linearise(scene, steady, scene.state(rotation(steady))), steady=[0])[1:]
    )


def model_stability(p: RotatingBeam, scene: EquationsOfMotion) -> Values:
    """Return the class by a scene's equations, again with more coordinates and nearby speeds."""
    assert scene.continuum.refined is not None
    nearby = [model_growth(one, scene) for one in at_speeds_nearby(p)]
    return stability_class(
        model_growth(p, scene), [*nearby, model_growth(p, scene.continuum.refined)]
    )


def engine_stability(p: RotatingBeam, engine: str, model: str) -> Values:
    """Return the class by an engine's matrices, again with twice the elements and nearby speeds."""
    others = *at_speeds_nearby(p), p.replace(segments=2 * p.segments)
    rate, *rates = (growth_rate(engine_modes(one, engine, model)) for one in (p, *others))
    return stability_class(rate, rates)


def at_speeds_nearby(p: RotatingBeam) -> list[RotatingBeam]:
    """Return the same at speeds nearby."""
    factors = (1 - PERTURBATION, 1 + PERTURBATION)
    return [p.replace(angular_speed=p.angular_speed * factor) for factor in factors]


def stability_class(rate: float, others: list[float]) -> Values:
    """Return class, growth rate, and whether the others are of the same class."""
    alike = all((other > 0) == (rate > 0) for other in others)
    return {"stable": float(rate == 0), "growth_rate": rate, "robust": float(alike)}


STABILITY: Mapping[str, Callable[[RotatingBeam], Values]] = {
    name: partial(model_stability, scene=scene)
    for name, scene in (
        ("exact", SCENE),
        ("extensible", EXTENSIBLE),
        ("second_order", SECOND_ORDER),
        ("zero_order", ZERO_ORDER),
    )
}

STABILITY_VARIABLES = {
    "stable": Variable("1", "steady rotation of the straight beam", ("unstable", "stable")),
    "growth_rate": Variable("1/s", "of what departs fastest from it; 0 where nothing grows"),
    "robust": Variable("1", "1 where nearby speeds and finer elements give the same class"),
}


# Point by point -----------------------------------------------------------------------------


def pointwise(
    points: Points,
    variables: Mapping[str, Variable],
    models: Mapping[str, Callable[[RotatingBeam], Values]],
    of_engine: Callable[..., Values],
) -> QuantityValues:
    """Return the values of each point; none, and the reason, where there are none.

    Raises
    ------
    UsageError
        If the reference or the engine has no such model.
    """
    if points.engine == REFERENCE:
        evaluate = models[known_name("model", points.model or None, tuple(models))]
    else:
        _, model = choose_engine(points.engine, case_of(points.one(0)), points.model or None)
        evaluate = partial(of_engine, engine=points.engine, model=model)
    columns: dict[str, Any] = {name: np.full(len(points), np.nan) for name in variables}
    problems = {}
    for i in range(len(points)):
        try:
            for name, value in evaluate(points.one(i)).items():
                columns[name][i] = value
        except MbcheckError as error:
            problems[i] = str(error)
    for name, about in variables.items():
        if about.classes or name == "robust":
            columns[name] = np.nan_to_num(columns[name]).astype(int)
    return QuantityValues.of(columns, problems)


def engine_modes(p: RotatingBeam, engine: str, model: str) -> list[Mode]:
    """Return the modes of an engine's model, with a fixed hub.

    Raises
    ------
    EngineError
        If the engine failed.
    """
    case = case_of(p)
    setup = Setup(choose_engine(engine, case, model)[0], case, model)
    return call_engine(lambda: elements.engine_modes(setup))


def case_of(p: RotatingBeam) -> Case:
    """Return the case of steady rotation."""
    steady = p.replace(drive="prescribed")
    return Case("rotating_beam", "point", steady, about=elements.ABOUT)


# Tables -------------------------------------------------------------------------------------

QUANTITIES: Mapping[str, Quantity] = {
    "frequency": Quantity(
        "natural frequencies about steady rotation (chordwise 1 to 3, flapwise 1)",
        FREQUENCY_VARIABLES,
        partial(
            pointwise,
            variables=FREQUENCY_VARIABLES,
            models=FREQUENCY,
            of_engine=engine_frequencies,
        ),
        models=tuple(FREQUENCY),
        block=64,
    ),
    "stability": Quantity(
        "whether steady rotation is stable; only zero_order, without foreshortening, loses it",
        STABILITY_VARIABLES,
        partial(
            pointwise, variables=STABILITY_VARIABLES, models=STABILITY, of_engine=engine_stability
        ),
        models=tuple(STABILITY),
        block=64,
        engine_block=8,
    ),
}


AXES: Mapping[str, AxisName] = {
    "nondimensional_speed": AxisName(
        "1",
        "gamma of (19): speed sqrt(rho A L^4 / (E I))",
        lambda p, gamma: p.replace(angular_speed=gamma * 2 * np.pi / (FIRST * period(p))),
    ),
    "mass_ratio": AxisName(
        "1",
        "alpha of (19): mass over that of the beam",
        lambda p, alpha: p.replace(mass=alpha * p.density * p.area * p.length),
    ),
    "hub_ratio": AxisName(
        "1",
        "delta of (19): hub_radius over length",
        lambda p, delta: p.replace(hub_radius=delta * p.length),
    ),
}
