"""The chain of rods in MuJoCo against the independently assembled chain, and its drive."""

import dataclasses
from collections.abc import Mapping
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.comparisons.faults.mujoco import Edited, MujocoAdapter
from mbcheck.models.mjcf import export
from mbcheck.models.rotating_beam.mjcf import MODELS
from mbcheck.reference.errors import EngineError, UnknownNameError, UsageError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.rotating_beam.chain import chain_scene
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.scene import Array, Case
from mbcheck.tests.support.chain import scene_of

ENGINE = MujocoAdapter()
METHODS = {method.name: method for method in ENGINE.methods}
CHAIN = MODELS["chain"]
DEFAULT = RotatingBeam()
OUTPUTS = ("tip_deflection", "tip_deflection_dot", "tip_axial")

SHORT = DEFAULT.replace(segments=4, ramp_time=1.0, angular_speed=4.0)
PULSE = SHORT.replace(drive="torque", torque_period=1.0, torque_amplitude=100.0)
BENT = {"theta": 0.2, "theta_dot": 0.3, "joint_1": 0.02}


def case_of(p: RotatingBeam, state: Mapping[str, float] | None = None, start: float = 0.0) -> Case:
    return Case("rotating_beam", "test", p, state or {}, 1.5, (), start)


@lru_cache
def solved(p: RotatingBeam, state: tuple[float, ...], times: tuple[float, ...]) -> Array:
    """Return the chain's states from t = 0, by a solver that stops where the drive ends."""
    right, x, begin, found = scene_of(p).right_hand_side(p), np.array(state), 0.0, []
    stop = p.torque_period if p.drive == "torque" else p.ramp_time
    at = np.array(times)
    for end in (stop, times[-1]):
        grid = np.append(at[(at > begin) & (at < end)], end)
        leg = solve_ivp(
            right, (begin, end), x, "DOP853", grid, rtol=1e-12, atol=1e-12, max_step=0.01
        )
        found.append(leg.y)
        x, begin = leg.y[:, -1], end
    states: Array = np.hstack(found)
    return states


def run_errors(p: RotatingBeam, method: str, steps: list[float]) -> Array:
    """Return the largest error of states and outputs with each step, over their sizes."""
    scene, case = scene_of(p), case_of(p, BENT)
    times = np.arange(0.25, 1.75, 0.25)  # one of them is the drive's end
    names = (*scene.state_names, *OUTPUTS)
    states = solved(p, tuple(scene.state(BENT)), tuple(times))
    truth = scene.observe(states, p)
    wanted = np.array([truth[name] for name in names])
    size = np.max(np.abs(wanted), axis=1)
    found = [
        run(Setup(ENGINE, case, "chain", METHODS[method], h), times).matrix(names) for h in steps
    ]
    return np.array([np.max(np.max(np.abs(f - wanted), axis=1) / size) for f in found])


def free_run(p: RotatingBeam, method: str, step: float, count: int) -> Trajectory:
    case = case_of(p, {"joint_2": 1e-3})
    times = step * np.arange(count, 5 * count, count, dtype=float)
    return run(Setup(ENGINE, case, "chain", METHODS[method], step), times)


# --- The file


def test_the_file_has_as_many_rods_as_segments_and_grows_back(tmp_path: Path) -> None:
    small = export(CHAIN, DEFAULT.replace(segments=3))
    assert small.count('<body name="rod_') == 3
    assert small.count("<body ") == small.count("</body>") == 6
    other = dataclasses.replace(CHAIN, path=tmp_path / "small.xml")
    other.path.write_text(small, encoding="utf-8")
    assert export(other, DEFAULT) == export(CHAIN, DEFAULT)


@pytest.mark.parametrize("p", [SHORT, PULSE, SHORT.replace(ramp_time=0.0)])
def test_as_opened_with_its_keyframe_it_moves_right(p: RotatingBeam) -> None:
    """As a viewer does it: load, choose the keyframe, step."""
    model = mujoco.MjModel.from_xml_string(export(CHAIN, p))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    assert np.array_equal(data.qpos, model.qpos0)
    mujoco.mj_step(model, data, nstep=512)
    scene, constant = scene_of(p), p.drive == "prescribed" and p.ramp_time == 0
    start = scene.state({"theta_dot": p.angular_speed if constant else 0.0})
    right = scene.right_hand_side(p)
    final = solve_ivp(right, (0, 0.5), start, "DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    found = np.concatenate([data.qpos[1:], data.qvel[1:]])
    np.testing.assert_allclose(found, final, rtol=0, atol=1e-6 * np.max(np.abs(final)))
    mujoco.mj_forward(model, data)
    outputs = scene.observe(final, p)
    for name in ("theta", "theta_dot", *OUTPUTS):
        assert data.sensor(name).data[0] == pytest.approx(outputs[name], abs=1e-6), name


def test_a_model_that_opens_elsewhere_is_refused() -> None:
    engine = Edited(('ref="3.799544386587667"', 'ref="0"'))
    with pytest.raises(EngineError, match=r"starts with clock at 0, not 3\.79954"):
        engine.bind(case_of(DEFAULT), "chain").system(case_of(DEFAULT))
    assert len(ENGINE.bind(case_of(DEFAULT), "chain").system(case_of(DEFAULT)).joints) == 18


def test_models_say_what_they_cannot_stand_for() -> None:
    free = PULSE.replace(hub_inertia=0.0)
    assert "choose scheme B" in str(CHAIN.unsupported_reason(free))
    for p in (free.replace(scheme="B"), free.replace(hub_radius=0.1), SHORT, PULSE):
        assert CHAIN.unsupported_reason(p) is None
    discrete = METHODS["discrete"]
    assert "would fade" in str(
        ENGINE.bind(case_of(SHORT), "chain").unsupported_reason(case_of(SHORT), discrete)
    )
    assert "would fade" in str(
        ENGINE.bind(case_of(PULSE), "chain").unsupported_reason(case_of(PULSE), discrete)
    )
    for p in (SHORT.replace(ramp_time=0.0), PULSE.replace(torque_amplitude=0.0)):
        assert ENGINE.bind(case_of(p), "chain").unsupported_reason(case_of(p), discrete) is None


# --- Coordinates


def test_states_have_the_chains_coordinates_and_no_scheme_predicts_them() -> None:
    case = case_of(SHORT)
    expected = ("theta", "joint_1", "joint_2", "joint_3", "joint_4")
    assert ENGINE.bind(case, "chain").coordinates == expected
    assert ENGINE.bind(case, "chain").own_equations == (chain_scene(4, "A"), SHORT)
    assert {ENGINE.bind(case, "chain").scheme(method) for method in ENGINE.methods} == {None}
    hoop = Case("hula_hoop", "test", HulaHoop(), {})
    assert ENGINE.bind(hoop, "tree").coordinates == ("y", "theta")
    assert ENGINE.bind(hoop, "tree").scheme(METHODS["RK4"]) == "RK44"


def test_initial_states_may_name_hinges_but_nothing_else() -> None:
    found = ENGINE.bind(case_of(SHORT, BENT), "chain").start(case_of(SHORT, BENT))
    assert found == pytest.approx([0.2, 0.02, 0, 0, 0, 0.3, 0, 0, 0, 0], abs=0)
    with pytest.raises(UnknownNameError, match="joint_5"):
        ENGINE.bind(case_of(SHORT, {"joint_5": 0.1}), "chain").start(
            case_of(SHORT, {"joint_5": 0.1})
        )


# --- Algebra


# --- Motion


@pytest.mark.parametrize("p", [SHORT, PULSE, PULSE.replace(scheme="B", mass=1.0, hub_radius=0.5)])
def test_runs_keep_their_order_through_the_end_of_the_drive(p: RotatingBeam) -> None:
    fine = run_errors(p, "RK4", [2.0**-k for k in (10, 11, 12)])
    assert fine[-1] < 1e-6
    assert [a / b for a, b in pairwise(fine)] == pytest.approx([16, 16], rel=0.2)
    coarse = run_errors(p, "Euler", [2.0**-12, 2.0**-13])
    assert 1e-4 < coarse[1] < 5e-3
    assert coarse[0] / coarse[1] == pytest.approx(2, rel=0.4)


@pytest.mark.parametrize("p", [SHORT, PULSE])
@pytest.mark.parametrize("start", [0.25, 1.0, 1.25])
def test_runs_may_start_within_the_drive_and_after_it(p: RotatingBeam, start: float) -> None:
    whole = run(
        Setup(ENGINE, case_of(p, BENT), "chain", METHODS["RK4"], 2.0**-12), np.array([start, 1.5])
    )
    state = {name: whole.values[name][0] for name in scene_of(p).state_names}
    part = run(
        Setup(ENGINE, case_of(p, state, start), "chain", METHODS["RK4"], 2.0**-12), np.array([1.5])
    )
    for name in state:
        scale = max(1.0, abs(whole.values[name][1]))
        assert part.values[name][0] == pytest.approx(whole.values[name][1], abs=1e-9 * scale), name


def test_the_drive_must_end_on_the_grid_of_steps() -> None:
    p, rk4 = SHORT.replace(ramp_time=0.3), METHODS["RK4"]
    with pytest.raises(UsageError, match=r"drive ends between two steps: time 0\.3 s is not on"):
        run(Setup(ENGINE, case_of(p), "chain", rk4, 2.0**-10), np.array([0.5]))
    run(Setup(ENGINE, case_of(p), "chain", rk4, 2.0**-10), np.array([0.25]))  # before it ends
    assert run(Setup(ENGINE, case_of(p), "chain", rk4, 1e-3), np.array([0.5])).values["theta_dot"][
        0
    ] == pytest.approx(4.0, abs=1e-7)


# --- Frequencies


# --- Stability


@pytest.mark.parametrize(("method", "limit"), [("RK4", 2.83), ("Euler", 2.0)])
def test_steps_above_the_limit_are_noticed(method: str, limit: float) -> None:
    p = DEFAULT.replace(segments=8, ramp_time=0.0, angular_speed=0.0)
    scene = scene_of(p)
    top = modes(*linearise(scene, p, scene.state({})), steady=[0])[-1].omega
    free_run(p, method, 0.97 * limit / top, 1000)
    with pytest.raises(EngineError) as caught:
        free_run(p, method, 1.5 * limit / top, 1000)
    assert caught.value.kind == "warning"
