"""What a step costs in stability: by how much engines shift a point of a stability boundary.

``python -m mbcheck.tests.support.campaigns.boundaries`` prints the table of docs/boundaries.md.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mbcheck.comparisons.boundary.request import BoundaryRequest
from mbcheck.comparisons.checks.orbits import engine_tracer
from mbcheck.comparisons.engines.variants.catalogue import Misread
from mbcheck.comparisons.queries.axis import ParameterRange
from mbcheck.reference.continuation.bifurcations import DOUBLING
from mbcheck.reference.continuation.curve import correct
from mbcheck.reference.continuation.network import Network
from mbcheck.reference.continuation.points import CurvePoint
from mbcheck.reference.continuation.tracing import Tracer

WINDOW = (
    ParameterRange("force_frequency", 5.0, 6.0),
    ParameterRange("force_amplitude", 15.0, 35.0),
)
"""About the loss of symmetry of hula_hoop's rotation at 5 Hz and 28.3 N."""

METHODS = (
    ("mujoco", "RK4"),
    ("mujoco", "implicitfast"),
    ("mujoco", "Euler"),
    ("exudyn", "ExplicitMidpoint"),
    ("exudyn", "RK44"),
    ("exudyn", "GeneralizedAlpha"),
)

FAULTS = ("main_mass", "free_mass", "rod_length", "stiffness")
"""Parameters that a MuJoCo reads 0.1 % too large."""

STEPS = (40, 80, 160, 320, 640)
"""In a period of 0.2 s."""


def request(**changes: Any) -> BoundaryRequest:
    """Return what is asked for."""
    return BoundaryRequest("hula_hoop", *WINDOW, **changes)


def first_doubling(asked: BoundaryRequest) -> tuple[Tracer, CurvePoint]:
    """Return the reference, and where the orbit at the window's left edge loses its symmetry."""
    tracer = asked.tracer()
    network = Network(tracer, tracer, asked.places[:1], 1)
    network.scan(0, 0.0)
    return tracer, next(start.point for start in network.starts if start.kind == DOUBLING)


def engine_point(tracer: Tracer, at: CurvePoint, setup: Any, per_period: int) -> tuple[float, Any]:
    """Return the force amplitude [N] at which the same happens by an engine, and its unknowns.

    NaN where its orbits do not lose their symmetry near.
    """
    own, _ = engine_tracer(tracer, setup, per_period)
    row = np.eye(len(at.z))[-2]
    curve = own.curve(DOUBLING, 1)
    solution = correct(curve.equations, at.z, row, float(at.place[0]))
    if solution is None:
        return float("nan"), None
    low, high = WINDOW[1].low, WINDOW[1].high
    return low + (high - low) * float(solution.z[-1]), solution.z


def main() -> None:
    """Print a row for each method: shifts [N] over steps per period, and the last order."""
    tracer, point = first_doubling(request())
    low, high = WINDOW[1].low, WINDOW[1].high
    truth = low + (high - low) * point.place[1]
    print(f"reference: {truth:.10f} N, bound {point.bound[1] * (high - low):.1e} N")
    for engine, method in METHODS:
        setup = request(engine=engine, method=method).setup
        shifts = [engine_point(tracer, point, setup, count)[0] - truth for count in STEPS]
        order = np.log2(abs(shifts[-2] / shifts[-1]))
        print(f"| {engine} | {method} | {' | '.join(f'{s:.2g}' for s in shifts)} | {order:.2f} |")
    for name in FAULTS:
        setup = request(engine="mujoco", method="RK4").setup
        change = {name: 1.001 * getattr(setup.case.parameters, name)}
        wrong = replace(setup, engine=Misread(setup.engine, change))
        places = [engine_point(tracer, point, wrong, count)[0] - truth for count in STEPS]
        print(f"{name}: {', '.join(f'{place:.4g}' for place in places)} N")


if __name__ == "__main__":
    main()
