"""rotating_beam as finite elements in Exudyn: model, frequencies about rotation, runs."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import exudyn
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.comparisons.engines.exudyn.engine import EXPLICIT, IMPLICIT
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.models.exudyn_system import items
from mbcheck.models.rotating_beam import exudyn_model
from mbcheck.models.rotating_beam.exudyn_model import MODELS, stations
from mbcheck.reference.errors import EngineError
from mbcheck.reference.rotating_beam import EXTENSIBLE, SCENE
from mbcheck.reference.rotating_beam.elements import shear_stiffness
from mbcheck.reference.rotating_beam.frequencies.numbers import time_unit
from mbcheck.reference.rotating_beam.frequencies.stretching import frequencies
from mbcheck.reference.rotating_beam.parameters import RotatingBeam, coefficients, drive
from mbcheck.reference.scene import Array, Case

DEFAULT = RotatingBeam()
BEAM = DEFAULT.density * DEFAULT.area * DEFAULT.length
"""Its mass."""

TIP = DEFAULT.replace(hub_radius=0.8, mass=0.5 * BEAM)
INNER = TIP.replace(mass_position=0.6)
KINDS = ("ancf", "geometrically_exact")
GENERALIZED_ALPHA, TRAPEZOIDAL = IMPLICIT

# bends as the paper's beam with L = 4 m does, but stretches 300 times as much: that is seen,
# and leaves the reference no fast waves
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
PULSE = SOFT.replace(drive="torque", torque_amplitude=20.0, torque_period=0.75)
ENGINE = ExudynAdapter()


def case(p: RotatingBeam, state: Mapping[str, float] | None = None) -> Case:
    return Case("rotating_beam", "test", p, state or {})


def at_speed(p: RotatingBeam, gamma: float) -> RotatingBeam:
    """Return the beam at this nondimensional speed."""
    return p.replace(angular_speed=gamma / time_unit(p))


def natural(p: RotatingBeam, count: int = 2) -> Array:
    """Return the lowest frequencies [rad/s] from the engine's M, C, K."""
    mass, spin, stiffness = ENGINE.bind(case(p), "elements").linearise(
        np.array([0.0, p.angular_speed])
    )
    size = len(mass)
    of_rates = -np.linalg.solve(mass, np.hstack([stiffness, spin]))
    matrix = np.vstack([np.eye(size, 2 * size, size), of_rates])
    omega = np.linalg.eigvals(matrix).imag
    return np.sort(omega[omega > 0])[:count]


def errors(p: RotatingBeam, segments: tuple[int, ...], **continuum: Any) -> Array:
    """Return relative errors of the frequencies (k, 2) against those of a continuum."""
    truth = frequencies(p, **continuum).omega
    return np.array([natural(p.replace(segments=n)) / truth - 1 for n in segments])


def simulated(
    p: RotatingBeam,
    method: Any,
    step: float,
    times: Array,
    state: Mapping[str, float] | None = None,
) -> Trajectory:
    return ENGINE.bind(case(p, state), "elements").simulate(case(p, state), method, step, times)


# --- The model


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("how", ["prescribed", "torque"])
def test_moment_of_inertia_is_that_of_hub_beam_and_mass(kind: str, how: str) -> None:
    p = INNER.replace(element=kind, drive=how)
    states = np.array([[0.0, 0.0], [2.3, -1.7]])
    found = ENGINE.bind(case(p), "elements").mass_matrices(states)
    a, end, line = p.hub_radius, p.hub_radius + p.length, p.density * p.area
    wanted = p.hub_inertia + line * (end**3 - a**3) / 3 + p.mass * (a + 0.6 * p.length) ** 2
    if kind == "geometrically_exact":
        wanted += p.density * p.second_moment * p.length
    assert found.shape == (2, 1, 1)
    assert found.ravel() == pytest.approx(wanted, rel=1e-12)


def test_a_node_carries_the_mass() -> None:
    assert stations(INNER.replace(segments=7)) == pytest.approx(
        [*np.linspace(0, 4.8, 5), *np.linspace(4.8, 8, 4)[1:]]
    )
    assert stations(INNER.replace(mass_position=1e-3, segments=4))[1] == pytest.approx(8e-3)
    assert stations(INNER.replace(mass=0.0, segments=5)) == pytest.approx(np.linspace(0, 8, 6))


@pytest.mark.parametrize("kind", KINDS)
def test_the_straight_beam_is_placed_in_rigid_rotation(kind: str) -> None:
    probe = ENGINE.inner.probe(case(TIP.replace(element=kind)), "elements", bodies=True)
    placed = probe.system.place(np.array([40.7]), np.array([3.0]))
    violations = probe.violations(np.zeros(1), placed[0][None], placed[1][None])
    probe.place(0.0, *placed)
    forces = probe.forces()
    outputs = probe.system.outputs(placed[0][:, None], placed[1][:, None])
    shape = probe.system.turning.shape(placed[0])
    assert np.max(violations) < 1e-13
    assert np.max(np.abs(forces)) < 1e-6  # of EA = 5e6 N
    assert np.max(np.abs(shape)) < 1e-13
    assert all(abs(value[0]) < 1e-12 for value in outputs.values())


def test_the_prescribed_hub_accelerates_as_it_should_whatever_the_beam_does() -> None:
    p = TIP.replace(angular_speed=7.0, ramp_time=3.0)
    draw = np.random.default_rng(5)
    times = np.append(draw.uniform(0, 4, 20), [0.0, 3.0, 4.0])
    states = draw.normal(size=(len(times), 2)) * [10.0, 5.0]
    found = ENGINE.bind(case(p), "elements").accelerations(times, states)
    wanted = drive(times, coefficients(p))
    assert found[:, 0] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    assert np.max(np.abs(found[times >= 3.0])) < 1e-25


def test_the_torque_ends_with_its_period() -> None:
    p = PULSE.replace(hub_inertia=3.0)
    times = np.array([0.1, 0.3, 0.75, 0.9])
    found = ENGINE.bind(case(p), "elements").accelerations(times, np.zeros((4, 2)))[:, 0]
    shape = np.sin(2 * np.pi * times / p.torque_period)
    assert found[:2] / found[0] == pytest.approx(shape[:2] / shape[0], rel=1e-10)
    assert np.max(np.abs(found[2:])) < 1e-12 * abs(found[0])


def test_constant_speed_from_the_start() -> None:
    p = SOFT.replace(ramp_time=0.0)
    times = np.array([0.0625, 0.125, 0.25])
    run = simulated(p, GENERALIZED_ALPHA, 2.0**-8, times, {"theta": 0.5, "theta_dot": 2.0})
    assert run.values["theta"] == pytest.approx(0.5 + 2.0 * times, rel=1e-14)
    assert run.values["theta_dot"] == pytest.approx(2.0, rel=1e-13)
    # it stretches from its straight shape
    assert 0 < np.min(run.values["tip_axial"]) < np.max(run.values["tip_axial"]) < 1e-2


def test_states_that_stand_for_what_is_continuous_are_not_exchanged() -> None:
    assert SCENE.public == ("theta",)


def test_the_elements_claim_the_beam_that_stretches() -> None:
    assert MODELS["elements"].equations is not None
    assert ENGINE.bind(case(TIP), "elements").own_equations == (EXTENSIBLE, TIP)


# --- Frequencies


@pytest.mark.parametrize(
    ("p", "segments"),
    [(TIP.replace(mass=0.0), (4, 8, 16)), (TIP, (4, 8, 16)), (INNER, (5, 10, 20))],
    ids=["none", "tip", "inner"],
)
def test_ancf_converges_with_order_4_at_rest(p: RotatingBeam, segments: tuple[int, ...]) -> None:
    found = errors(at_speed(p, 0.0), segments, continuum="extensible")
    assert np.all(found > 0)
    assert np.log2(found[:-1] / found[1:]) == pytest.approx(4.0, abs=0.2)
    assert found[-1, 0] < 2e-7


@pytest.mark.parametrize(("gamma", "order", "largest"), [(4.0, 3.9, 2e-6), (12.0, 3.6, 1e-4)])
def test_ancf_converges_with_order_4_about_rotation(
    gamma: float, order: float, largest: float
) -> None:
    found = errors(at_speed(TIP, gamma), (8, 16), continuum="extensible")
    assert np.all(np.log2(found[0] / found[1]) > order)
    assert found[1, 0] < largest


@pytest.mark.parametrize("gamma", [0.0, 4.0, 12.0])
def test_geometrically_exact_elements_converge_with_order_2_to_a_beam_that_shears(
    gamma: float,
) -> None:
    p = at_speed(TIP, gamma).replace(element="geometrically_exact")
    own: dict[str, Any] = {"shear_stiffness": shear_stiffness(p), "rotary_inertia": True}
    found = errors(p, (16, 32, 64), continuum="shear_flexible", **own)
    # the next term of the error is of order 4: what is left without the first is the continuum
    assert np.log2(found[1] / found[2]) == pytest.approx(2.0, abs=0.15)
    left = (4 * found[2] - found[1]) / 3
    assert np.all(np.abs(left) < 2e-6)
    gap = frequencies(p, continuum="shear_flexible", **own).omega
    gap = gap / frequencies(p, continuum="extensible").omega - 1
    assert np.all(np.abs(gap) > 4 * np.abs(left))  # so it is seen which of the two it is


def shifted(change: Mapping[str, Any], gamma: float = 4.0) -> float:
    """Return by how much the first frequency of a changed model is off its continuum's."""
    p = at_speed(TIP, gamma).replace(segments=16)
    truth = frequencies(p, continuum="extensible").omega[0]
    return float(natural(p.replace(**change))[0] / truth - 1)


@pytest.mark.parametrize(
    ("change", "shift"),
    [
        ({"second_moment": 1.001 * TIP.second_moment}, 2.0e-4),
        ({"mass_position": 0.99}, 1.5e-3),
        ({"hub_radius": 0.81}, 4e-4),
    ],
    ids=["bending", "mass_position", "hub_radius"],
)
def test_small_faults_are_far_above_the_elements_error(
    change: Mapping[str, Any], shift: float
) -> None:
    right, wrong = abs(shifted({})), abs(shifted(change))
    assert right < 3e-6
    assert wrong > max(shift, 50 * right)


def test_fixing_the_length_of_the_slope_at_the_clamp_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = shifted({}, 12.0)
    monkeypatch.setattr(exudyn_model, "clamp", all_coordinates(exudyn_model.clamp))
    assert abs(shifted({}, 0.0)) < 1e-7  # at rest, it is not
    assert abs(shifted({}, 12.0)) > 5 * abs(right)


def all_coordinates(clamp: Callable[[Any, int, int], None]) -> Callable[[Any, int, int], None]:
    """Return a clamp that also keeps the slope vector's length, near the angle 0."""

    def faulty(mbs: Any, rim: int, root: int) -> None:
        clamp(mbs, rim, root)
        ends = [
            mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
            for node, coordinate in (
                (mbs.AddNode(items.NodePointGround()), 0),
                (mbs.GetMarker(root)["nodeNumber"], 2),
            )
        ]
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=ends))

    return faulty


def test_exudyns_plain_eigenvalues_of_the_stretched_beam_are_the_flapwise_ones() -> None:
    p = at_speed(TIP, 4.0)
    probe = ENGINE.inner.probe(case(p), "elements", bodies=True)
    shape = probe.steady_shape(p.angular_speed)
    initial = exudyn.ConfigurationType.Initial
    with ENGINE.inner.opened(case(p), "elements") as system:  # the heavy hub holds the angle
        system.mbs.systemData.SetODE2Coordinates(shape, configuration=initial)
        values, _ = system.mbs.ComputeODE2Eigenvalues(ignoreAlgebraicEquations=False)
    plain = np.sqrt(np.sort(np.abs(values))[1])
    flapwise, chordwise = (
        frequencies(p, plane, continuum="extensible").omega[0]
        for plane in ("flapwise", "chordwise")
    )
    assert plain == pytest.approx(flapwise, rel=1e-5)
    assert natural(p)[0] == pytest.approx(chordwise, rel=1e-5)
    assert flapwise > 1.5 * chordwise


def test_no_steady_shape_where_the_beam_is_torn_apart() -> None:
    torn = SOFT.replace(angular_speed=3000.0)
    with pytest.raises(EngineError, match="no steady shape"):
        natural(torn)


# --- Runs

STEP = 2.0**-9
TIMES = np.array([0.375, 0.75, 1.0, 1.25])
SEEN = ("theta", "theta_dot", "tip_deflection", "tip_deflection_dot", "tip_axial")


@lru_cache
def expected(p: RotatingBeam) -> dict[str, Array]:
    """Return the observables, energy and momentum of the beam that stretches."""
    solution = solve_ivp(
        EXTENSIBLE.right_hand_side(p),
        (0, TIMES[-1]),
        EXTENSIBLE.state({}),
        method="DOP853",
        t_eval=TIMES,
        rtol=1e-7,
        atol=1e-9,
    )
    q, v = np.split(solution.y, 2)
    free = p.replace(drive="torque", torque_amplitude=0.0)
    assert EXTENSIBLE.invariants is not None
    conserved = EXTENSIBLE.invariants(free)
    own = coefficients(p)
    found = EXTENSIBLE.observe(solution.y, p)
    return found | {name: value(q, v, own) for name, value in conserved.items()}


def misses(p: RotatingBeam, wanted: Mapping[str, Array], method: Any) -> dict[str, float]:
    """Return errors over the largest value, the step's own taken out by its half."""
    coarse, fine = (simulated(p, method, step, TIMES).values for step in (STEP, STEP / 2))
    return {
        name: float(
            np.max(np.abs((4 * fine[name] - coarse[name]) / 3 - wanted[name]))
            / np.max(np.abs(wanted[name]))
        )
        for name in (*SEEN, "energy", "momentum")
    }


@pytest.mark.parametrize("method", IMPLICIT, ids=lambda method: method.name)
def test_spin_up_follows_the_beam_that_stretches(method: Any) -> None:
    found = misses(SOFT, expected(SOFT), method)
    assert max(found["theta"], found["theta_dot"]) < 1e-10
    assert max(found.values()) < 2e-5
    faulty = misses(SOFT.replace(second_moment=1.001 * SOFT.second_moment), expected(SOFT), method)
    assert faulty["tip_deflection"] > 5e-4


def test_pulse_follows_the_beam_that_stretches_through_its_end() -> None:
    wanted = expected(PULSE)
    found = misses(PULSE, wanted, GENERALIZED_ALPHA)
    rates = ("theta_dot", "tip_deflection_dot")
    assert max(value for name, value in found.items() if name not in rates) < 2e-4
    assert max(found[name] for name in rates) < 2e-3
    # nothing pushes once the pulse is over, and the torque has no mean
    run = simulated(PULSE, GENERALIZED_ALPHA, STEP, TIMES).values
    assert np.ptp(run["energy"][1:]) < 1e-3 * run["energy"][0]
    assert np.max(np.abs(run["momentum"][1:])) < 1e-3 * run["momentum"][0]


def test_energy_is_that_of_exudyns_own_forces() -> None:
    probe = ENGINE.inner.probe(case(TIP), "elements", bodies=True)
    size, still = probe.size, np.zeros(probe.size)
    shape = np.append(0, 1e-3 * np.random.default_rng(2).normal(size=size - 1))
    turned = probe.system.turning.rotated(0.7, shape)

    def energy(at: Array, rates: Array = still) -> float:
        return float(probe.turning_integrals(at[None], rates[None])["energy"][0])

    assert energy(turned) == pytest.approx(energy(shape), rel=1e-9)
    assert energy(probe.system.turning.rotated(0.7)) == pytest.approx(0.0, abs=1e-12)
    probe.place(0.0, shape, still)
    forces = probe.forces()
    for row in (1, 4, size - 1):
        nudge = 1e-6 * np.eye(size)[row]
        slope = (energy(shape + nudge) - energy(shape - nudge)) / 2e-6
        assert slope == pytest.approx(-forces[row], rel=1e-5, abs=1e-3)


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
