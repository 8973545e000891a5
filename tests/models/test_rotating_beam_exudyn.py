"""rotating_beam as finite elements in Exudyn: its nodes, and runs that fail."""

from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.exudyn.engine import EXPLICIT, IMPLICIT
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.models.rotating_beam.exudyn_model import MODELS, stations
from mbcheck.reference.errors import EngineError
from mbcheck.reference.rotating_beam import EXTENSIBLE
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.scene import Array, Case

DEFAULT = RotatingBeam()
BEAM = DEFAULT.density * DEFAULT.area * DEFAULT.length
"""Its mass."""

TIP = DEFAULT.replace(hub_radius=0.8, mass=0.5 * BEAM)
INNER = TIP.replace(mass_position=0.6)
GENERALIZED_ALPHA, TRAPEZOIDAL = IMPLICIT

SOFT = DEFAULT.replace(
    length=4.0,
    hub_radius=0.5,
    mass=0.1,
    youngs_modulus=DEFAULT.youngs_modulus / 300,
    second_moment=DEFAULT.second_moment * 300,
    segments=8,
    ramp_time=1.0,
    angular_speed=2.0,
)
"""It stretches 300 times as much as the paper's beam with L = 4 m, and bends alike."""

ENGINE = ExudynAdapter()


def case(p: RotatingBeam) -> Case:
    return Case("rotating_beam", "test", p, {})


def simulated(p: RotatingBeam, method: Any, step: float, times: Array) -> Trajectory:
    return ENGINE.bind(case(p), "elements").simulate(case(p), method, step, times)


def test_a_node_carries_the_mass() -> None:
    assert stations(INNER.replace(segments=7)) == pytest.approx(
        [*np.linspace(0, 4.8, 5), *np.linspace(4.8, 8, 4)[1:]]
    )
    assert stations(INNER.replace(mass_position=1e-3, segments=4))[1] == pytest.approx(8e-3)
    assert stations(INNER.replace(mass=0.0, segments=5)) == pytest.approx(np.linspace(0, 8, 6))


def test_the_torque_ends_with_its_period() -> None:
    p = SOFT.replace(drive="torque", torque_amplitude=20.0, torque_period=0.75, hub_inertia=3.0)
    times = np.array([0.1, 0.3, 0.75, 0.9])
    found = ENGINE.bind(case(p), "elements").accelerations(times, np.zeros((4, 2)))[:, 0]
    shape = np.sin(2 * np.pi * times / p.torque_period)
    assert found[:2] / found[0] == pytest.approx(shape[:2] / shape[0], rel=1e-10)
    assert np.max(np.abs(found[2:])) < 1e-12 * abs(found[0])


def test_the_elements_claim_the_beam_that_stretches() -> None:
    assert MODELS["elements"].equations is not None
    assert ENGINE.bind(case(TIP), "elements").own_equations == (EXTENSIBLE, TIP)


def test_no_steady_shape_where_the_beam_is_torn_apart() -> None:
    torn = case(SOFT.replace(angular_speed=3000.0))
    with pytest.raises(EngineError, match="no steady shape"):
        ENGINE.bind(torn, "elements").linearise(np.array([0.0, 3000.0]))


def test_explicit_solvers_are_refused_and_would_refuse() -> None:
    reason = ENGINE.bind(case(SOFT), "elements").unsupported_reason(case(SOFT), EXPLICIT[3])
    assert reason is not None
    assert "algebraic constraints" in reason
    with pytest.raises(Exception, match="constraints"):
        simulated(SOFT, EXPLICIT[3], 2.0**-14, np.array([2.0**-10]))


def test_a_step_too_large_is_an_error_where_newton_fails() -> None:
    p = DEFAULT.replace(segments=8, ramp_time=2.0)
    with pytest.raises(EngineError) as raised:
        simulated(p, GENERALIZED_ALPHA, 0.25, np.array([8.0]))
    assert raised.value.kind == "solver"


def test_a_step_too_large_may_also_pass_for_a_solution() -> None:
    """Finite, in as many steps as asked for: only half the step, or the reference, tells."""
    p = DEFAULT.replace(segments=8, drive="torque", torque_amplitude=20.0, torque_period=4.0)
    times = np.array([4.0, 8.0])
    fine = simulated(p, GENERALIZED_ALPHA, 2.0**-6, times).values
    run = simulated(p, GENERALIZED_ALPHA, 1.0, times)
    assert (run.steps, run.changed_inputs, run.warnings) == (8, (), {"rejected_steps": 0})
    assert all(np.all(np.isfinite(value)) for value in run.values.values())
    assert abs(run.values["theta"][-1] / fine["theta"][-1] - 1) > 0.2
    # a step as long as the ramp sees the hub's acceleration at its zeros alone
    p = DEFAULT.replace(segments=8, ramp_time=1.0)
    assert np.all(simulated(p, GENERALIZED_ALPHA, 1.0, times).values["theta"] == 0)
