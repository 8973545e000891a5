"""Runs that the picture of the README shows: of the reference, and of methods of engines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from mbcheck.comparisons.checks import elements
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.reference import get_scene
from mbcheck.reference.errors import UsageError
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve.single import solve


class Curve(NamedTuple):
    """How a method is drawn, on the first model that it can run unless one is named."""

    engine: str
    method: str
    colour: str
    line: Any = "solid"
    model: str | None = None

    @property
    def label(self) -> str:
        """Return the name in the legend."""
        return f"{ {'mujoco': 'MuJoCo', 'exudyn': 'Exudyn'}[self.engine] } {self.method}"


def reference(case: Case, times: Array, variant: str | None = None) -> Mapping[str, Array]:
    """Return the observables of the reference, or of another of its models."""
    whole = get_scene(case.scene)
    scene = whole.variants[variant] if variant else whole
    truth = solve(scene, case.parameters, scene.state(case.state), times, case.start_time)
    return scene.observe(truth.states, case.parameters)


def simulate(case: Case, curve: Curve, step: float, times: Array) -> Mapping[str, Array]:
    """Return the observables of a method, by default on the first model that it can run."""
    engine = get_engine(curve.engine)
    method = next(item for item in engine.methods if item.name == curve.method)
    model = model_of(case, curve)
    if model is None:
        raise UsageError(f"no model of {case.scene} can be run by {curve.label}")
    return run(Setup(engine, case, model, method, step), times).values


def model_of(case: Case, curve: Curve) -> str | None:
    """Return the first model that a method can run, unless one is named; None without any."""
    engine = get_engine(curve.engine)
    method = next(item for item in engine.methods if item.name == curve.method)
    return curve.model or next(
        (
            name
            for name in engine.models(case.scene)
            if engine.bind(case, name).unsupported_reason(case, method) is None
        ),
        None,
    )


def frequency_errors(engine: str, case: Case, counts: Array) -> Array:
    """Return relative errors of the first frequency against the continuum that is approached."""
    tool = get_engine(engine)
    model = tool.models(case.scene)[0]
    setups = [
        Setup(tool, replace(case, parameters=case.parameters.replace(segments=float(count))), model)
        for count in counts
    ]
    return np.array(
        [
            abs(elements.of_engine(setup)[0] / elements.of_continuum(setup)[0] - 1)
            for setup in setups
        ]
    )
