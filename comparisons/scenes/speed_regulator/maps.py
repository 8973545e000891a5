"""Maps of `speed_regulator`: where it rests or rotates, and how fast.

Model `theory` solves the equation of motion over the crank angle (`limit_cycles`); model `direct`,
and engines, are simulated (`runs`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from ...engines.registry import REFERENCE
from ..bounds import with_bounds
from ..quantity import Points, Quantity, QuantityValues, Variable
from .limit_cycles import REGIMES, theory_regime, theory_speed
from .runs import simulated_regime, simulated_speed

Evaluation = Callable[[Points], QuantityValues]


def by_theory_or_runs(theory: Evaluation, runs: Evaluation, points: Points) -> QuantityValues:
    """Return the values by theory, or by runs of model `direct` and of engines.

    Raises
    ------
    ParameterError
        If there is gravity, which turns the crank as the spring does: neither knows of it.
    """
    points.parameters.refuse_gravity("maps of speed_regulator")
    by_theory = points.engine == REFERENCE and points.model != "direct"
    return theory(points) if by_theory else runs(points)


QUANTITIES: Mapping[str, Quantity] = {
    "regime": Quantity(
        about="which stable motions there are: rest, rotation, or both",
        variables={
            "regime": Variable("1", "stable motions", REGIMES),
            "robust": Variable(
                "1",
                "1 where another torque (theory), or a perturbed run with half the step, gives the "
                "same class",
            ),
        },
        evaluate=partial(by_theory_or_runs, theory_regime, simulated_regime),
        models=("theory", "direct"),
        block=1024,
        engine_block=16,
    ),
    "mean_speed": Quantity(
        about="mean speed of the rotation, and the error of formula (21)",
        variables=with_bounds(
            {
                "mean_speed": Variable("rad/s", "2 pi / period of the limit cycle"),
                "error_as_printed": Variable("1", "(21) as printed over the mean speed, less 1"),
                "error_exact": Variable("1", "(21) with its exact average over it, less 1"),
            },
            "mean_speed",
            "error_as_printed",
            "error_exact",
        ),
        evaluate=partial(by_theory_or_runs, theory_speed, simulated_speed),
        models=("theory", "direct"),
        block=1024,
        engine_block=16,
    ),
}
