"""The engine models of speed_regulator, and the equations that a soft closure really has."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.equations import ModelEquations
from mbcheck.comparisons.engines.exudyn.engine import (
    IMPLICIT,
    ExudynEngine,
    integrate,
    place_initial,
    quiet,
)
from mbcheck.comparisons.engines.exudyn.probe import Probe
from mbcheck.comparisons.engines.mujoco.engine import MujocoEngine, joint_force
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Delegating
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.models.mjcf import Mjcf, export
from mbcheck.models.speed_regulator import exudyn_model, mjcf
from mbcheck.models.speed_regulator.mjcf import HARD_SOLIMP, HARD_SOLREF, MODELS, closed_by
from mbcheck.reference.errors import EngineError, NoOrbitError, UnknownNameError
from mbcheck.reference.scene import Array, Case, EquationsOfMotion
from mbcheck.reference.soft_constraint import SOLIMP, SOLREF, impedance
from mbcheck.reference.solve.schemes import TABLEAUS, ScalarEquations, explicit_runge_kutta
from mbcheck.reference.solve.single import solve
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.equations import coefficients as exact_coefficients
from mbcheck.reference.speed_regulator.scene import SCENE
from mbcheck.reference.speed_regulator.soft import (
    COORDINATES,
    coefficients,
    embedding,
    open_forces,
    soft_scene,
)

DEFAULT = SpeedRegulator()
OTHER = SpeedRegulator(
    crank_radius=0.4,
    rod_length=0.5,
    flywheel_inertia=0.7,
    rod_mass=0.9,
    slider_mass=0.4,
    stiffness=50.0,
    damping=1.5,
    torque=1.1,
    spring_rest=-0.45,
)
MASSLESS = OTHER.replace(rod_mass=0.0, slider_mass=0.0)
CLOSURES = ("connect", "connect_hard")
ROTATING = {"phi": 0.0, "phi_dot": 5.07}
FINE = 2.0**-10


def compiled(model: Mjcf, p: SpeedRegulator) -> Any:
    return mujoco.MjModel.from_xml_string(export(model, p))


def claimed(name: str, p: SpeedRegulator = DEFAULT) -> EquationsOfMotion:
    claim = MODELS[name].equations
    assert claim is not None
    scene, parameters = claim(p)
    assert parameters is p
    return scene


def closed_state(p: SpeedRegulator, state: Mapping[str, float]) -> Array:
    return np.array([embedding(p, state)[name] for name in soft_scene().state_names], dtype=float)


def samples(p: SpeedRegulator, opened: float = 0.0, count: int = 40) -> Array:
    """Return random states (k, 6) of the tree, its loop open by about so much."""
    draw = np.random.default_rng(3)
    speeds = draw.normal(size=(count, 2)) * [3.0, 5.0]
    closed = [closed_state(p, {"phi": phi, "phi_dot": speed}) for phi, speed in speeds]
    return np.array(closed) + opened * draw.normal(size=(count, 6))


def accelerations(model: Any, states: Array) -> Array:
    data = mujoco.MjData(model)
    found = []
    for state in states:
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(model, data)
        found.append(data.qacc.copy())
    return np.array(found)


def predicted(scene: EquationsOfMotion, p: SpeedRegulator, states: Array) -> Array:
    q, v = np.split(states.T, 2)
    found: Array = np.array(scene.accelerations(0.0, q, v, scene.coefficients(p))).T
    return found


def acceleration_error(
    model: Any, scene: EquationsOfMotion, p: SpeedRegulator, states: Array
) -> float:
    truth = predicted(scene, p, states)
    return float(np.max(np.abs(accelerations(model, states) - truth)) / np.max(np.abs(truth)))


def final(model: Any, state: Array, step: float, span: float, integrator: str = "RK4") -> Array:
    """Return the final state, in the order of the model's joints."""
    config = mujoco.MjLogConfig.get()
    silent = mujoco.MjLogConfig.get()
    silent.logto_console = silent.logto_file = False
    silent.set()
    try:
        model.opt.timestep = step
        model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_step(model, data, round(span / step))
    finally:
        config.set()
    return np.concatenate([data.qpos, data.qvel])


@lru_cache
def truth(
    scene: EquationsOfMotion, p: SpeedRegulator, state: tuple[float, ...], span: float
) -> Array:
    return solve(scene, p, np.array(state), [span]).states[:, -1]


def exact_final(p: SpeedRegulator, span: float) -> Array:
    phi, speed = truth(SCENE, p, (ROTATING["phi"], ROTATING["phi_dot"]), span)
    return closed_state(p, {"phi": phi, "phi_dot": speed})


# --- MJCF files


@pytest.mark.parametrize("name", ["connect", "transmission"])
def test_committed_files_are_bound_to_the_defaults(name: str) -> None:
    assert export(MODELS[name], DEFAULT) == MODELS[name].path.read_text(encoding="utf-8")


def test_the_hard_closure_changes_only_the_closure() -> None:
    soft, hard = (export(MODELS[name], DEFAULT).splitlines() for name in CLOSURES)
    changed = [line for line, other in zip(soft, hard, strict=True) if line != other]
    assert len(changed) == 1
    assert "<connect" in changed[0]


@pytest.mark.parametrize("name", SpeedRegulator.names())
def test_every_parameter_changes_the_files(name: str) -> None:
    changed = DEFAULT.replace(**{name: 1.01 * getattr(DEFAULT, name)})
    assert export(MODELS["connect"], changed) != export(MODELS["connect"], DEFAULT)
    same = export(MODELS["transmission"], changed) == export(MODELS["transmission"], DEFAULT)
    assert same == (name in ("rod_mass", "slider_mass"))


@pytest.mark.parametrize("p", [DEFAULT, OTHER])
@pytest.mark.parametrize("name", CLOSURES)
def test_as_opened_the_loop_is_closed_and_joints_mean_what_they_say(
    name: str, p: SpeedRegulator
) -> None:
    model = compiled(MODELS[name], p)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.efc_pos, 0.0, atol=1e-15)
    motion = MODELS[name].joints(p, 0.0, {"phi": 0.0, "phi_dot": 0.0})
    assert [model.joint(i).name for i in range(model.njnt)] == list(motion) == list(COORDINATES)
    np.testing.assert_allclose(data.qpos, [q for q, _ in motion.values()], rtol=0, atol=1e-15)
    observed = SCENE.observe(np.zeros(2), p)
    assert data.sensor("y").data[0] == pytest.approx(observed["y"], rel=1e-14)


def test_joints_of_a_state_that_says_more_are_left_open() -> None:
    state = {"phi": 0.3, "y": -1.0, "phi_dot": 1.0, "y_dot": 0.5}
    motion = MODELS["connect"].joints(DEFAULT, 0.0, state)
    closed = embedding(DEFAULT, {"phi": 0.3, "phi_dot": 1.0})
    assert motion["y"] == (-1.0, 0.5)
    assert motion["pin_angle"] == (closed["pin_angle"], closed["pin_angle_dot"])


def test_models_say_what_they_cannot_stand_for() -> None:
    for name in CLOSURES:
        assert MODELS[name].why_not(DEFAULT) is None
        assert "rod_mass and slider_mass 0" in str(MODELS[name].why_not(MASSLESS))
    assert MODELS["transmission"].why_not(MASSLESS) is None
    assert "must be 0, not 0.5 and 1 kg" in str(MODELS["transmission"].why_not(DEFAULT))


# --- The equations of a soft closure


@pytest.mark.parametrize("p", [DEFAULT, OTHER])
def test_inverse_weights_are_mujocos(p: SpeedRegulator) -> None:
    model = compiled(MODELS["connect"], p)
    weights = sum(model.body(name).invweight0[0] for name in ("rod", "slider"))
    assert coefficients(p).inverse_weight == pytest.approx(weights, rel=1e-13)


@pytest.mark.parametrize("p", [DEFAULT, OTHER], ids=["default", "other"])
@pytest.mark.parametrize("opened", [0.0, 2e-4, 1e-2])
@pytest.mark.parametrize("name", CLOSURES)
def test_mujocos_accelerations_are_those_of_the_claim(
    name: str, opened: float, p: SpeedRegulator
) -> None:
    states = samples(p, opened)
    assert acceleration_error(compiled(MODELS[name], p), claimed(name, p), p, states) < 1e-10


@pytest.mark.parametrize(
    ("solref", "solimp"),
    [
        ((0.05, 0.7), (0.5, 0.99, 0.01, 0.3, 3.0)),
        ((-900.0, -40.0), (0.3, 0.8, 0.002, 0.6, 1.0)),
        ((0.02, 1.0), (0.0, 1.0, 0.001, 0.5, 2.0)),
    ],
)
def test_other_softness_is_understood(
    solref: tuple[float, float], solimp: tuple[float, ...]
) -> None:
    model = compiled(closed_by(solref, solimp), DEFAULT)
    scene = soft_scene(solref, solimp)
    assert acceleration_error(model, scene, DEFAULT, samples(DEFAULT, 1e-3)) < 1e-10


@pytest.mark.parametrize("name", SpeedRegulator.names())
def test_a_wrong_parameter_shows(name: str) -> None:
    wrong = DEFAULT.replace(**{name: 1.001 * getattr(DEFAULT, name)})
    states, scene = samples(DEFAULT), claimed("connect")
    assert acceleration_error(compiled(MODELS["connect"], wrong), scene, DEFAULT, states) > 1e-6


def test_the_claim_is_one_scene() -> None:
    assert claimed("connect") is claimed("connect", OTHER) is soft_scene(SOLREF, SOLIMP)
    assert claimed("connect_hard") is soft_scene(HARD_SOLREF, HARD_SOLIMP)


def test_impedance_runs_between_its_ends() -> None:
    residual = np.array([0.0, 2.5e-4, 5e-4, 7.5e-4, 1e-3, 1.0])
    shares = np.array([0.0, 0.125, 0.5, 0.875, 1.0, 1.0])  # two parabolas
    found = impedance(residual**2, SOLIMP)
    np.testing.assert_allclose(found, 0.9 + 0.05 * shares, rtol=1e-15)


@pytest.mark.parametrize("name", CLOSURES)
def test_the_claim_is_consistent(name: str) -> None:
    """Forces through the mass matrix are accelerations, powers add up to the energy's rate."""
    scene, c = claimed(name, OTHER), coefficients(OTHER)
    probe = 1e-40
    for state in samples(OTHER, 3e-4, 10):
        q, v = np.split(state, 2)
        a = predicted(scene, OTHER, state[None])[0]
        solved = np.linalg.solve(scene.mass_matrix(q, c), scene.forces(0.0, q, v, c))
        np.testing.assert_allclose(solved, a, rtol=1e-11, atol=1e-10)
        rate = scene.energy(q + 1j * probe * v, v + 1j * probe * a, c).imag / probe
        powers = scene.powers(0.0, q, v, c)
        scale = sum(abs(power) for power in powers.values())
        assert rate == pytest.approx(sum(powers.values()), abs=1e-11 * scale)


def test_outputs_of_a_hard_closure_are_the_exact_ones() -> None:
    scene = claimed("connect_hard", OTHER)
    for state in samples(OTHER, count=10):
        exact = SCENE.observe(state[[0, 3]], OTHER)
        found = scene.observe(state, OTHER)
        for key, value in exact.items():
            scale = 1e-3 if key.startswith("reaction") else 1e-12  # of accelerations of 1/K
            assert found[key] == pytest.approx(value, rel=scale, abs=10 * scale)


def test_violations_are_told() -> None:
    state = closed_state(DEFAULT, ROTATING) + np.array([0, 0, 3e-3, 0, 0, -2e-2])
    found = soft_scene().observe(state, DEFAULT)
    assert found["position_violation"] == pytest.approx(3e-3, rel=1e-12)
    assert found["velocity_violation"] == pytest.approx(2e-2, rel=1e-12)


@pytest.mark.parametrize("name", CLOSURES)
def test_equilibria_of_the_claim_are_at_rest_in_mujoco(name: str) -> None:
    scene, model = claimed(name), compiled(MODELS[name], DEFAULT)
    for about, equilibrium in scene.equilibria.items():
        values = equilibrium(DEFAULT)
        state = np.array([values[key] for key in COORDINATES] + [0.0] * 3)
        assert np.max(np.abs(accelerations(model, state[None]))) < 1e-8
        assert values["phi"] == pytest.approx(SCENE.equilibria[about](DEFAULT)["phi"], abs=1e-3)
    with pytest.raises(NoOrbitError):
        scene.equilibria["right"](DEFAULT.replace(torque=100.0))


# --- Reactions of the joints

REACTIONS = ("reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y")


def reactions(scene: EquationsOfMotion, p: SpeedRegulator, states: Array) -> Array:
    """Return the reactions (k, 4) that a scene has."""
    observed = scene.observe(states.T, p)
    return np.array([observed[name] for name in REACTIONS]).T


@pytest.mark.parametrize("name", CLOSURES)
def test_reactions_of_the_claim_move_crank_and_slider(name: str) -> None:
    """Both bodies by themselves: the claim finds them from the closure and the rod."""
    scene, p = claimed(name, OTHER), OTHER
    states = samples(p, 1e-3)
    (phi, _, y), (_, _, y_dot) = np.split(states.T, 2)
    phi_ddot, _, y_ddot = predicted(scene, p, states).T
    a_x, a_y, _, b_y = reactions(scene, p, states).T
    lever = p.crank_radius * (np.cos(phi) * a_y - np.sin(phi) * a_x)
    torque = p.flywheel_inertia * phi_ddot - lever
    assert torque == pytest.approx(np.full(len(states), p.torque), abs=1e-11 * np.ptp(lever))
    spring = -p.stiffness * (y - p.spring_rest) - p.damping * y_dot
    assert p.slider_mass * y_ddot == pytest.approx(spring - b_y, abs=1e-11 * np.ptp(b_y))


@pytest.mark.parametrize("p", [DEFAULT, OTHER], ids=["default", "other"])
@pytest.mark.parametrize("opened", [0.0, 2e-4, 1e-2])
@pytest.mark.parametrize("name", CLOSURES)
def test_mujocos_reactions_are_those_of_the_claim(
    name: str, opened: float, p: SpeedRegulator
) -> None:
    model, states = compiled(MODELS[name], p), samples(p, opened)
    data = mujoco.MjData(model)
    found = []
    for state in states:
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        places = MODELS[name].reactions
        assert tuple(places) == REACTIONS
        found.append([joint_force(mujoco, model, data, at)[axis] for at, axis in places.values()])
    truths = reactions(claimed(name, p), p, states)
    np.testing.assert_allclose(found, truths, rtol=0, atol=1e-10 * np.max(np.abs(truths)))


@pytest.mark.parametrize("p", [DEFAULT, OTHER, MASSLESS], ids=["default", "other", "massless"])
def test_exudyns_reactions_are_right(p: SpeedRegulator) -> None:
    states = samples(p)[:, [0, 3]]
    case = Case(SCENE.name, "some_motion", p)
    found = ENGINE.reactions(case, "redundant", np.zeros(len(states)), states)
    assert tuple(found) == ENGINE.reaction_names(case, "redundant") == REACTIONS
    truths = reactions(SCENE, p, states)
    scale = np.max(np.abs(truths))
    np.testing.assert_allclose(np.array(list(found.values())).T, truths, rtol=0, atol=1e-11 * scale)


def test_models_without_joints_tell_no_reactions() -> None:
    for engine, name in (("mujoco", "transmission"), ("exudyn", "one_dof")):
        found: Any = get_engine(engine)
        assert found.reaction_names(SCENE.case("rotation"), name) == ()


HOMOGENEOUS = DEFAULT.rod_mass * DEFAULT.rod_length**2 / 12


class WrongMujoco(MujocoEngine):
    """MuJoCo with other numbers of the rod in its file."""

    def __init__(self, mass: float, inertia: float) -> None:
        super().__init__()
        self.numbers = {'mass="0.5"': f'mass="{mass!r}"', repr(HOMOGENEOUS): repr(inertia)}

    def text(self, case: Case, model: str) -> str:
        found = super().text(case, model)
        for number, wrong in self.numbers.items():
            assert number in found
            found = found.replace(number, wrong)
        return found


class WrongExudyn(ExudynEngine):
    """Exudyn with other numbers of the rod."""

    def __init__(self, mass: float, inertia: float) -> None:
        super().__init__()
        self.numbers = {"mass": mass, "inertia": inertia}

    def system(self, case: Case, model: str) -> Any:
        system = super().system(case, model)
        for name, number in self.numbers.items():
            system.mbs.SetObjectParameter(1, name, number)
        return system


class PushedBack(Delegating):
    """An engine that tells the force in A on the other body."""

    def __init__(self, engine: Any) -> None:
        self.engine = engine

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def reactions(self, *where: Any) -> dict[str, Array]:
        found = self.engine.reactions(*where)
        return {name: -value if "_a_" in name else value for name, value in found.items()}


WRONG: Mapping[str, type[Any]] = {"mujoco": WrongMujoco, "exudyn": WrongExudyn}


def verdicts(engine: str, case: Case, wrong: Adapter | None = None) -> dict[str, set[str]]:
    """Return, by quantity, the verdicts of the check kind that a case feeds first."""
    found: dict[str, set[str]] = {}
    for check in checks_of(case.kinds[0], case, engine):
        for item in [] if check.why_not else run_check(check, "loose", wrong):
            found.setdefault(item.quantity, set()).add(item.verdict)
    return found


@pytest.mark.parametrize("engine", WRONG)
def test_the_check_of_reactions_catches_faults(engine: str) -> None:
    case = SCENE.case("rotation")
    right = verdicts(engine, case)
    assert set(REACTIONS) < set(right)
    assert set.union(*right.values()) == {"pass"}
    same = verdicts(engine, case, WRONG[engine](DEFAULT.rod_mass, HOMOGENEOUS))
    assert {name: same[name] for name in REACTIONS} == {name: {"pass"} for name in REACTIONS}
    for mass, inertia in ((1.001 * DEFAULT.rod_mass, HOMOGENEOUS), (0.5, 4 * HOMOGENEOUS)):
        wrong = verdicts(engine, case, WRONG[engine](mass, inertia))
        assert all("deviation" in wrong[name] for name in REACTIONS)
    flipped = verdicts(engine, case, PushedBack(get_engine(engine)))
    missed = {name for name in REACTIONS if flipped[name] == {"pass"}}
    assert missed == {"reaction_b_x", "reaction_b_y"}
    assert flipped["accelerations"] == {"pass"}


# --- A loop that starts open, as declared

OPENED = SCENE.case("opened_loop")


@pytest.mark.parametrize("name", CLOSURES)
def test_an_opened_loop_closes_in_mujoco(name: str) -> None:
    engine = MujocoEngine()
    rk4 = next(item for item in engine.methods if item.name == "RK4")
    times = np.array([0.0, 0.25, 0.5])
    found = engine.simulate(OPENED, name, rk4, 2.0**-11, times).values
    gap = OPENED.inconsistency["y"]
    start = SCENE.observe(SCENE.state(OPENED.state), DEFAULT)
    assert found["y"][0] - start["y"] == pytest.approx(gap, rel=1e-12)
    assert found["position_violation"][0] == pytest.approx(gap, rel=1e-12)
    assert found["phi"][0] == 0.0
    own = Setup(engine, OPENED, name).equations
    left = solve(own.scene, own.parameters, own.start(OPENED), times[1:]).states
    violation = own.scene.observe(left, own.parameters)["position_violation"]
    assert np.max(violation) < 0.25 * gap  # what the load leaves open
    assert found["position_violation"][1:] == pytest.approx(violation, abs=1e-6 * gap)


class Assembling(MujocoEngine):
    """MuJoCo that is started with the loop closed, whatever the case says."""

    def simulate(self, case: Case, *rest: Any) -> Any:
        return super().simulate(replace(case, inconsistency={}), *rest)


def test_the_check_of_an_opened_loop_sees_that_it_was_open() -> None:
    assert set.union(*verdicts("mujoco", OPENED).values()) == {"pass"}
    closed = verdicts("mujoco", OPENED, Assembling())
    assert closed["scheme_residual"] == closed["model_error"] == {"deviation"}


def test_models_that_cannot_start_open_say_so() -> None:
    for name in EXUDYN:
        assert "only an assembled mechanism" in str(ENGINE.why_not(OPENED, name, None))
    mujoco_engine = MujocoEngine()
    reason = mujoco_engine.why_not(replace(OPENED, parameters=MASSLESS), "transmission", None)
    assert "none can start open" in str(reason)
    assert all(mujoco_engine.why_not(OPENED, name, None) is None for name in CLOSURES)


def test_only_what_is_declared_may_be_inconsistent() -> None:
    with pytest.raises(UnknownNameError):
        SCENE.state({"phi": 0.0, "y": 1.0})
    own = ModelEquations(soft_scene(), DEFAULT)
    shift = own.start(OPENED) - own.start(replace(OPENED, inconsistency={}))
    np.testing.assert_allclose(shift, [0, 0, 1e-3, 0, 0, 0], rtol=1e-12, atol=0)
    with pytest.raises(UnknownNameError):
        own.start(replace(OPENED, inconsistency={"why": 1e-3}))


# --- MuJoCo's integrators on it


def runge_kutta(
    scene: EquationsOfMotion, p: SpeedRegulator, state: Array, step: float, span: float
) -> Array:
    equations = ScalarEquations(scene, p, clock=False)
    advance = explicit_runge_kutta(equations, TABLEAUS["RK44"])
    x = equations.start(state, 0.0)
    for _ in range(round(span / step)):
        x = advance(0.0, x, step)
    return np.array(x)


@pytest.mark.parametrize("p", [DEFAULT, OTHER], ids=["default", "other"])
@pytest.mark.parametrize("name", CLOSURES)
def test_rk4_is_the_classical_scheme_on_the_claim(name: str, p: SpeedRegulator) -> None:
    start = closed_state(p, ROTATING)
    found = final(compiled(MODELS[name], p), start, FINE, 0.5)
    expected = runge_kutta(claimed(name, p), p, start, FINE, 0.5)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def semi_implicit(
    scene: EquationsOfMotion,
    p: SpeedRegulator,
    state: Array,
    step: float,
    damping: Callable[..., Array],
) -> Array:
    c = scene.coefficients(p)
    q, v = np.split(state, 2)
    for _ in range(round(0.25 / step)):
        mass = np.array(scene.mass_matrix(q, c)) + step * damping(q, v, c)
        v = v + step * np.linalg.solve(mass, scene.forces(0.0, q, v, c))
        q = q + step * v
    return np.concatenate([q, v])


def joint_damping(q: Array, v: Array, c: Any) -> Array:
    return soft_scene().damping_matrix(c)


def open_damping(q: Array, v: Array, c: Any) -> Array:
    """Return minus the derivatives of the open tree's forces by v."""
    probed = v[:, None] + 1e-40j * np.eye(3)
    found = np.broadcast_arrays(*open_forces(0.0, q[:, None], probed, c))
    return -np.array(found).imag / 1e-40


@pytest.mark.parametrize("name", CLOSURES)
@pytest.mark.parametrize(
    ("integrator", "damping"),
    [("Euler", joint_damping), ("implicitfast", joint_damping), ("implicit", open_damping)],
)
def test_euler_methods_take_the_closure_from_the_start_of_a_step(
    integrator: str, damping: Callable[..., Array], name: str
) -> None:
    start = closed_state(OTHER, ROTATING)
    found = final(compiled(MODELS[name], OTHER), start, FINE, 0.25, integrator)
    expected = semi_implicit(claimed(name, OTHER), OTHER, start, FINE, damping)
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11)


def test_a_positive_time_constant_is_silently_raised_to_two_steps() -> None:
    step, start = 2.0**-6, closed_state(DEFAULT, ROTATING)
    found = final(compiled(MODELS["connect"], DEFAULT), start, step, 0.5)
    raised = soft_scene((2 * step, 1.0), SOLIMP)
    expected = runge_kutta(raised, DEFAULT, start, step, 0.5)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert np.max(np.abs(found - runge_kutta(soft_scene(), DEFAULT, start, step, 0.5))) > 1e-4


def test_a_step_at_which_mujoco_softens_the_closure_is_refused() -> None:
    """By `refsafe`: a positive time constant of the closure must be two steps at least."""
    for model in (None, "connect"):
        with pytest.raises(EngineError, match="refsafe") as caught:
            simulate("speed_regulator", engine="mujoco", model=model, step=0.02, times=[0.2])
        assert caught.value.kind == "step"
    at_most = SOLREF[0] / 2
    simulate("speed_regulator", engine="mujoco", step=at_most, times=[0.2])
    # a closure that is given by stiffness and damping stays what it is
    hard = MODELS["connect_hard"]
    assert hard.longest_step == MODELS["transmission"].longest_step == np.inf
    step, start = 2.0**-10, closed_state(DEFAULT, ROTATING)
    found = final(compiled(hard, DEFAULT), start, step, 0.125)
    expected = runge_kutta(claimed("connect_hard"), DEFAULT, start, step, 0.125)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)


def test_checks_take_shorter_steps_than_that() -> None:
    engine = MujocoEngine()
    for case in SCENE.cases:
        for model in CLOSURES:
            for method in engine.methods:
                if engine.why_not(case, model, method) is None:
                    step = Setup(engine, case, model, method).default_step
                    assert step <= SOLREF[0] / 2


# --- Model error and integration error


def test_the_default_closure_errs_by_the_same_at_any_step() -> None:
    start, exact = closed_state(DEFAULT, ROTATING), exact_final(DEFAULT, 1.0)
    model_error = truth(claimed("connect"), DEFAULT, tuple(start), 1.0) - exact
    assert abs(model_error[0]) == pytest.approx(2.0e-4, rel=0.05)
    model = compiled(MODELS["connect"], DEFAULT)
    integration_errors = []
    for step in (2.0**-8, 2.0**-9, 2.0**-10):
        error = final(model, start, step, 1.0) - exact
        integration_errors.append(np.max(np.abs(error - model_error)))
        np.testing.assert_allclose(error, model_error, atol=1e-2 * np.max(np.abs(model_error)))
    assert np.log2(integration_errors[0] / integration_errors[-1]) / 2 == pytest.approx(4, abs=0.3)


def speed_error(solref: tuple[float, float], step: float) -> float:
    """Return the error of phi_dot after 1 s, RK4, against the closed loop."""
    model = compiled(closed_by(solref, HARD_SOLIMP), DEFAULT)
    error = final(model, closed_state(DEFAULT, ROTATING), step, 1.0) - exact_final(DEFAULT, 1.0)
    return float(abs(error[3]))


def test_the_hard_closure_is_five_orders_better() -> None:
    start, exact = closed_state(DEFAULT, ROTATING), exact_final(DEFAULT, 1.0)
    found = final(compiled(MODELS["connect_hard"], DEFAULT), start, 2.0**-13, 1.0)
    error = np.abs(found - exact)
    assert 5e-10 < error[0] < 5e-9
    assert np.max(error[[0, 2, 3]]) < 5e-9


def test_a_harder_closure_loses_more_than_it_gains() -> None:
    harder = (4 * HARD_SOLREF[0], 2 * HARD_SOLREF[1])
    for step in (2.0**-10, 2.0**-11):
        assert speed_error(harder, step) > 4 * speed_error(HARD_SOLREF, step)


def test_the_hard_closure_is_the_hardest_for_all_integrators() -> None:
    start = closed_state(DEFAULT, ROTATING)
    harder = closed_by((4 * HARD_SOLREF[0], 2 * HARD_SOLREF[1]), HARD_SOLIMP)
    for integrator in ("Euler", "implicit", "implicitfast"):
        sound = final(compiled(MODELS["connect_hard"], DEFAULT), start, FINE, 1.0, integrator)
        np.testing.assert_allclose(sound, exact_final(DEFAULT, 1.0), atol=1e-2)
        wild = final(compiled(harder, DEFAULT), start, FINE, 1.0, integrator)
        assert not np.all(np.isfinite(wild))


def test_the_loop_stays_on_its_branch() -> None:
    p = OTHER  # cos b down to 0.6
    for name in CLOSURES:
        state = closed_state(p, ROTATING)
        model = compiled(MODELS[name], p)
        for _ in range(8):
            state = final(model, state, FINE, 0.25)
            values = dict(zip(soft_scene().state_names, state, strict=True))
            assert SCENE.assembled is not None
            assert SCENE.assembled(values, p)
            exact = SCENE.observe(state[[0, 3]], p)
            assert values["y"] == pytest.approx(exact["y"], abs=1e-2)


# --- The transmission


def test_the_transmission_is_exact() -> None:
    model = compiled(MODELS["transmission"], MASSLESS)
    data = mujoco.MjData(model)
    for state in samples(MASSLESS)[:, [0, 3]]:
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(model, data)
        expected = SCENE.observe(state, MASSLESS)
        acceleration = predicted(SCENE, MASSLESS, state[None])[0]
        np.testing.assert_allclose(data.qacc, acceleration, rtol=1e-12, atol=1e-12)
        for name in ("phi", "phi_dot", "y", "y_dot"):
            assert data.sensor(name).data[0] == pytest.approx(expected[name], rel=1e-13, abs=1e-13)


def test_the_transmission_keeps_the_order_of_rk4() -> None:
    p, start = DEFAULT.replace(rod_mass=0.0, slider_mass=0.0), (0.0, 5.07)
    model = compiled(MODELS["transmission"], p)
    coarse, fine = (
        np.max(np.abs(final(model, np.array(start), h, 1.0) - truth(SCENE, p, start, 1.0)))
        for h in (2.0**-5, 2.0**-6)
    )
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.3)


# --- Exudyn


ENGINE = ExudynEngine()
EXUDYN = exudyn_model.MODELS


def test_exudyn_models_are_the_loop_first() -> None:
    assert {name: model.constrained for name, model in EXUDYN.items()} == {
        "redundant": True,
        "one_dof": False,
    }
    assert next(iter(EXUDYN)) == "redundant"


def exudyn_accelerations(name: str, p: SpeedRegulator, states: Array) -> Array:
    with quiet(ENGINE.exudyn):
        system = EXUDYN[name].build(p)
        probe = Probe(ENGINE.exudyn, system, ENGINE.settings(IMPLICIT[0], 0.0, 1.0))
        found = np.array([system.readout @ probe.motion(0.0, state)[0] for state in states])
        system.container.Reset()
    return found


@pytest.mark.parametrize("p", [DEFAULT, OTHER, MASSLESS], ids=["default", "other", "massless"])
@pytest.mark.parametrize("name", EXUDYN)
def test_exudyns_accelerations_are_right(name: str, p: SpeedRegulator) -> None:
    states = samples(p)[:, [0, 3]]
    truths = predicted(SCENE, p, states)
    found = exudyn_accelerations(name, p, states)
    np.testing.assert_allclose(found, truths, rtol=1e-10, atol=1e-11 * np.max(np.abs(truths)))


@pytest.mark.parametrize("wrong", SpeedRegulator.names())
@pytest.mark.parametrize("name", EXUDYN)
def test_a_wrong_parameter_shows_in_exudyn(name: str, wrong: str) -> None:
    states = samples(DEFAULT, count=5)[:, [0, 3]]
    p = DEFAULT.replace(**{wrong: 1.001 * getattr(DEFAULT, wrong)})
    truths = predicted(SCENE, DEFAULT, states)
    error = np.max(np.abs(exudyn_accelerations(name, p, states) - truths))
    assert error > 1e-6 * np.max(np.abs(truths))


def exudyn_run(name: str, p: SpeedRegulator, method: str, step: float, times: Array) -> Array:
    """Return phi, phi_dot, y, y_dot (4, k), and check that the joints are closed."""
    chosen = next(item for item in ENGINE.methods if item.name == method)
    with quiet(ENGINE.exudyn):
        system = EXUDYN[name].build(p)
        place_initial(ENGINE.exudyn, system, np.array([0.0, 5.07]))
        settings, solver = ENGINE.settings(chosen, 0.0, step), ENGINE.solver(chosen)
        solver.InitializeSolver(system.mbs, settings)
        solver.it.maxStepSize = step
        try:
            coordinates, rates, _, _ = integrate(system.mbs, solver, settings, step, times)
        finally:
            solver.FinalizeSolver(system.mbs, settings)
        outputs = system.outputs(coordinates.T, rates.T)
        states = [system.readout @ coordinates.T, system.readout @ rates.T]
        system.container.Reset()
    return np.vstack([*states, outputs["y"], outputs["y_dot"]])


@pytest.mark.parametrize("p", [DEFAULT, OTHER], ids=["default", "other"])
@pytest.mark.parametrize(
    ("name", "method", "order", "step"),
    [
        ("redundant", "GeneralizedAlpha", 2, 2.0**-8),
        ("redundant", "TrapezoidalIndex2", 2, 2.0**-8),
        ("one_dof", "TrapezoidalIndex2", 2, 2.0**-8),
        ("one_dof", "RK44", 4, 2.0**-6),
    ],
)
def test_exudyns_errors_shrink_at_the_declared_order_on_the_right_branch(
    name: str, method: str, order: int, step: float, p: SpeedRegulator
) -> None:
    times = np.array([0.5, 1.0])
    states = solve(SCENE, p, np.array([0.0, 5.07]), times).states
    observed = SCENE.observe(states, p)
    exact = np.array([observed[key] for key in ("phi", "phi_dot", "y", "y_dot")])
    coarse, fine = (
        np.max(np.abs(exudyn_run(name, p, method, h, times) - exact)) for h in (step, step / 2)
    )
    assert fine < 1e-3
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.4)


def test_exudyn_places_the_loop_closed_and_tells_where_it_opens() -> None:
    system = EXUDYN["redundant"].build(OTHER)
    for phi, speed in samples(OTHER, count=10)[:, [0, 3]]:
        coordinates, rates = system.place(np.array([phi]), np.array([speed]))
        coordinates, rates = coordinates[:, None], rates[:, None]
        outputs = system.outputs(coordinates, rates)
        exact = SCENE.observe(np.array([phi, speed]), OTHER)
        assert outputs["y"][0] == pytest.approx(exact["y"], rel=1e-13)
        assert outputs["y_dot"][0] == pytest.approx(exact["y_dot"], rel=1e-12)
        engine = ExudynEngine()
        probe = Probe(engine.exudyn, system, engine.settings(engine.methods[-1], 0.0, 1.0))
        closed = probe.violations(np.zeros(1), coordinates.T, rates.T)
        assert closed["position_violation"][0] < 1e-15
        assert closed["velocity_violation"][0] < 1e-14
        moved = coordinates + 1e-3 * np.eye(6)[:, 5:]
        opened = probe.violations(np.zeros(1), moved.T, rates.T)
        assert opened["position_violation"][0] == pytest.approx(1e-3)
    system.container.Reset()


def test_mass_of_one_dof_is_the_scenes() -> None:
    with quiet(ENGINE.exudyn):
        system = EXUDYN["one_dof"].build(OTHER)
        probe = Probe(ENGINE.exudyn, system, ENGINE.settings(IMPLICIT[0], 0.0, 1.0))
        for phi in (0.0, 0.7, 2.5):
            probe.place(0.0, np.array([phi]), np.zeros(1))
            expected = SCENE.mass_matrix([phi], exact_coefficients(OTHER))
            np.testing.assert_allclose(probe.mass(), expected, rtol=1e-13)
        system.container.Reset()


def test_hard_softness_is_what_the_file_says() -> None:
    text = mjcf.MODELS["connect"].path.read_text(encoding="utf-8")
    numbers = " ".join(f"{value:g}" for value in HARD_SOLIMP)
    assert f'solref="{HARD_SOLREF[0]:.0f} {HARD_SOLREF[1]:.0f}" solimp="{numbers}"' in text
