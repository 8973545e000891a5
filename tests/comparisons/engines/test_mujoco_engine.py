"""MuJoCo behind the engine protocol: the adapter, its models, and the guard around its runs."""

import dataclasses
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.engines.mujoco.library import integrate, quiet
from mbcheck.comparisons.engines.run import Trajectory, contained
from mbcheck.comparisons.engines.setup import Setup, guard, run
from mbcheck.comparisons.faults.mujoco import Edited, MujocoAdapter
from mbcheck.models.hula_hoop.mjcf import MODELS
from mbcheck.models.mjcf import bind, export, models, number
from mbcheck.reference.errors import EngineError, EngineUnavailableError, UnknownNameError
from mbcheck.reference.hula_hoop.equations import (
    SCENE,
    SPINNING,
    HulaHoop,
    coefficients,
)
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve.single import solve

ENGINE = MujocoAdapter()


METHODS = {method.name: method for method in ENGINE.methods}


RK4 = METHODS["RK4"]


TREE = MODELS["tree"]


OTHER = HulaHoop(
    main_mass=0.3,
    free_mass=0.08,
    rod_length=0.07,
    stiffness=700.0,
    damping_ratio=0.05,
    hinge_damping_ratio=0.02,
    inertia_ratio=0.4,
    force_amplitude=20.0,
    force_frequency=4.3,
)


def case_of(
    parameters: HulaHoop | None = None, state: Mapping[str, float] | None = None, start: float = 0.0
) -> Case:
    return Case("hula_hoop", "test", parameters or HulaHoop(), state or {}, 0.5, (), start)


def claimed(case: Case) -> HulaHoop:
    """Return the parameters that the model claims to have."""
    claim = ENGINE.bind(case, "tree").own_equations
    assert claim is not None
    assert claim[0] is SCENE
    assert isinstance(claim[1], HulaHoop)
    return claim[1]


def exact(parameters: HulaHoop, start: float, state: Array, span: float) -> Array:
    """Return the final state by the reference."""
    return solve(SCENE, parameters, state, [start + span], start).states[:, -1]


# --- models


def test_what_is_printed_is_kept_from_the_first_letter_on() -> None:
    with contained() as console:
        os.write(1, b"first\nsecond")
    assert console.text == "first\nsecond"


def test_models_of_scenes() -> None:
    assert ENGINE.models("hula_hoop") == ("tree", "forced")
    assert ENGINE.twins("hula_hoop") == ("forced",)
    assert ENGINE.distinct_models("hula_hoop") == ("tree",)
    assert models("no_such_scene") == {}
    with pytest.raises(UnknownNameError, match="did you mean 'tree'"):
        ENGINE.bind(case_of(), "tre").accelerations(np.zeros(1), np.zeros((1, 4)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<a><joint name='y' damping='0'/><joint name='y' damping='0'/></a>", "2 elements"),
        ("<a><joint name='x' damping='0'/></a>", "0 elements"),
        ("<a><joint name='y'/></a>", "no attribute"),
        ("<a><!-- <joint name='y' damping='0'/> --></a>", "0 elements"),
    ],
)
def test_binding_refuses_what_is_not_exactly_there(text: str, message: str) -> None:
    with pytest.raises(KeyError, match=message):
        bind(text, {("joint:y", "damping"): 1.0})


def test_binding_keeps_everything_else() -> None:
    text = (
        "<a>\n <!-- é > -->\n <body  name='b' note='x>y'><inertial\n pos='0'  mass='1'/></body></a>"
    )
    values: dict[tuple[str, str], Any] = {
        ("body:b/inertial", "mass"): 0.1,
        ("body:b/inertial", "pos"): (0.1, 1.0),
    }
    expected = text.replace("mass='1'", 'mass="0.1"').replace("pos='0'", 'pos="0.1 1"')
    assert bind(text, values) == expected


@pytest.mark.parametrize("value", [0.1 + 0.2, 1e300, 2.0**60, 5e-324, -0.0, 1000.0])
def test_numbers_survive_the_text(value: float) -> None:
    assert float(number(value)) == value


@pytest.mark.parametrize("parameters", [HulaHoop(), OTHER, HulaHoop(force_amplitude=0.0)])
def test_exported_file_moves_right_from_where_it_opens(
    tmp_path: Path, parameters: HulaHoop
) -> None:
    """As a viewer does it: load the file, step, nothing else."""
    path = tmp_path / "exported.xml"
    path.write_text(export(TREE, parameters), encoding="utf-8")
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=512)
    assert data.time == 0.5
    found = np.concatenate([data.qpos[1:], data.qvel[1:]])
    truth = exact(claimed(case_of(parameters)), 0.0, np.zeros(4), 0.5)
    assert np.allclose(found, truth, rtol=0, atol=2e-5)
    assert abs(truth).max() > 1 or parameters.force_amplitude == 0
    mujoco.mj_forward(model, data)
    assert np.array_equal(data.sensordata, found)
    assert [model.sensor(i).name for i in range(model.nsensor)] == list(SCENE.state_names)


def test_keyframe_is_the_initial_condition_of_the_paper() -> None:
    model = mujoco.MjModel.from_xml_path(str(TREE.path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("rest").id)
    assert np.array_equal(data.qpos, [0.06, 0, 0])
    assert np.array_equal(data.qpos, model.qpos0)
    assert not data.qvel.any()


def test_model_has_the_mass_of_the_mechanism() -> None:
    model = mujoco.MjModel.from_xml_path(str(TREE.path))
    assert model.body("main_mass").subtreemass[0] == pytest.approx(0.495, rel=1e-15)
    assert model.body(0).subtreemass[0] == pytest.approx(0.496, rel=1e-15)


@pytest.mark.parametrize("method", ["Euler", "implicit", "implicitfast"])
def test_clock_keeps_time_for_a_thousand_periods(method: str) -> None:
    """The foot moves as the method moves a free oscillator, whatever the mechanism does."""
    model = mujoco.MjModel.from_xml_path(str(TREE.path))
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{method.upper()}")
    data = mujoco.MjData(model)
    h, steps, omega = model.opt.timestep, 341_333, coefficients(HulaHoop()).omega
    mujoco.mj_step(model, data, nstep=steps)
    turn = 2 * np.arcsin(omega * h / 2)  # exact for the semi-implicit Euler method
    expected = 0.06 * np.cos((steps + 0.5) * turn) / np.cos(turn / 2)
    assert data.qpos[0] == pytest.approx(expected, abs=1e-12)


def test_the_claim_differs_only_where_mujoco_has_no_point_mass() -> None:
    assert claimed(case_of(OTHER)) == OTHER
    real = claimed(case_of())
    assert real == HulaHoop(inertia_ratio=real.inertia_ratio)
    assert real.inertia_ratio * 0.045 * 0.05**2 == pytest.approx(2e-15)


# --- trajectories


@pytest.mark.skipif("discrete" not in METHODS, reason="discrete came with MuJoCo 3.13")
def test_discrete_is_refused_where_it_would_damp_the_drive() -> None:
    discrete = METHODS["discrete"]
    assert "fade" in str(ENGINE.bind(case_of(), "tree").unsupported_reason(case_of(), discrete))
    assert (
        ENGINE.bind(case_of(HulaHoop(force_amplitude=0.0)), "tree").unsupported_reason(
            case_of(HulaHoop(force_amplitude=0.0)), discrete
        )
        is None
    )
    assert ENGINE.bind(case_of(), "tree").unsupported_reason(case_of(), RK4) is None


def test_times_may_be_uneven_and_do_not_change_the_run() -> None:
    case = case_of(None, SPINNING, 0.25)
    step = 2.0**-10
    dense = 0.25 + step * np.arange(401.0)
    some = dense[[0, 1, 7, 100, 400]]
    every = run(Setup(ENGINE, case, "tree", RK4, step), dense)
    few = run(Setup(ENGINE, case, "tree", RK4, step), some)
    assert every.steps == few.steps == 400
    for name in SCENE.state_names:
        assert np.array_equal(every.values[name][[0, 1, 7, 100, 400]], few.values[name])
    assert np.array_equal(few.matrix(SCENE.state_names)[:, 0], SCENE.state(SPINNING))


def test_extreme_parameters_move_right() -> None:
    heavy = HulaHoop(main_mass=1e3, free_mass=1e3, rod_length=5.0, stiffness=1e4)
    light = HulaHoop(main_mass=1e-3, free_mass=1e-4, rod_length=0.01, stiffness=1.0)
    scale = np.array([0.1, 1.0, 1.0, 20.0])
    for parameters in (heavy, light.replace(force_amplitude=0.05)):
        case = case_of(parameters, SPINNING, 0.125)
        found = run(Setup(ENGINE, case, "tree", RK4, 2.0**-12), np.array([0.625]))
        truth = exact(claimed(case), 0.125, SCENE.state(SPINNING), 0.5)
        off = abs(found.matrix(SCENE.state_names)[:, -1] - truth) / scale
        assert np.max(off) < 1e-6


# --- manners


@pytest.mark.skipif(not hasattr(mujoco, "MjLogConfig"), reason="before 4.0 MuJoCo always writes")
def test_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    before = mujoco.MjLogConfig.get()
    trajectory = ENGINE.bind(case_of(None, SPINNING), "tree").simulate(
        case_of(None, SPINNING), RK4, 1024.0, np.array([102400.0])
    )
    assert any(trajectory.warnings.values())
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")
    after = mujoco.MjLogConfig.get()
    assert (after.logto_console, after.logto_file) == (before.logto_console, before.logto_file)


@pytest.mark.parametrize("reason", ["halted", "cannot open shared object"])
def test_missing_mujoco_is_said_plainly(monkeypatch: pytest.MonkeyPatch, reason: str) -> None:
    def broken(name: str) -> Any:
        raise OSError("libmujoco: cannot open shared object file")

    if reason == "halted":
        monkeypatch.setitem(sys.modules, "mujoco", None)
    else:
        monkeypatch.setattr("importlib.import_module", broken)
    with pytest.raises(EngineUnavailableError, match=reason):
        MujocoAdapter()


@pytest.mark.parametrize(
    "change", [('ref="0.06"', 'ref="0.06003"'), ('name="y" type', 'name="y" ref="0.001" type')]
)
def test_a_model_that_opens_in_the_wrong_state_is_refused(change: tuple[str, str]) -> None:
    displaced = Edited(change).bind(case_of(None, {}), "tree")
    assert MujocoAdapter().bind(case_of(None, {}), "tree").text.count(change[0]) == 1
    with pytest.raises(EngineError, match="as opened"):
        assert displaced.origin


# --- the guard, on failures that MuJoCo really has

TINY = """<mujoco><option gravity="0 0 0"><flag autoreset="disable"/></option><worldbody><body>
<joint name="x" type="slide"/><geom size="0.1"/></body></worldbody>
<actuator><motor joint="x"/></actuator></mujoco>"""
UNSTABLE = 2.0**-3
"""A step [s] beyond the stability limit of Euler, 2 sqrt(M / k)."""


def trajectory_of(model: Any, data: Any, times: Any) -> Trajectory:
    motion = integrate(mujoco, model, data, times)
    assert motion.steps is not None
    return Trajectory(
        times,
        {"x": motion.positions[:, 0]},
        motion.clock,
        motion.steps,
        warnings=motion.warnings,
        changed_inputs=motion.changed_inputs,
    )


def guarded(trajectory: Trajectory, case: Case, step: float) -> str:
    with pytest.raises(EngineError) as caught:
        guard(trajectory, Setup(ENGINE, case, "tree", RK4, step), trajectory.times)
    return caught.value.kind


def without_warnings(trajectory: Trajectory) -> Trajectory:
    return dataclasses.replace(trajectory, warnings={})


@pytest.mark.parametrize("samples", ["dense", "end"])
def test_automatic_reset_is_caught(samples: str) -> None:
    engine = Edited(('<flag contact="disable" autoreset="disable"/>', '<flag contact="disable"/>'))
    times = UNSTABLE * np.arange(1.0, 201.0)
    case = case_of(None, SPINNING)
    chosen = times if samples == "dense" else times[-1:]
    trajectory = engine.bind(case, "tree").simulate(case, METHODS["Euler"], UNSTABLE, chosen)
    assert all(np.isfinite(values).all() for values in trajectory.values.values())
    assert guarded(trajectory, case, UNSTABLE) == "warning"
    expected = "clock_reversed" if samples == "dense" else "clock"
    assert guarded(without_warnings(trajectory), case, UNSTABLE) == expected
    on_time = dataclasses.replace(without_warnings(trajectory), clock=chosen)
    assert guarded(on_time, case, UNSTABLE) == "step_count"


def test_huge_step_is_caught() -> None:
    case, times = case_of(None, SPINNING), 1024.0 * np.arange(1.0, 101.0)
    trajectory = ENGINE.bind(case, "tree").simulate(case, RK4, 1024.0, times)
    assert guarded(trajectory, case, 1024.0) == "warning"
    assert any(trajectory.warnings[name] for name in ("BADQPOS", "BADQVEL", "BADQACC"))
    with pytest.raises(EngineError, match="warning counter"):
        run(Setup(ENGINE, case, "tree", RK4, 1024.0), times)


def test_state_that_is_not_finite_is_caught() -> None:
    case = case_of(None, {"theta_dot": 1e200})
    trajectory = ENGINE.bind(case, "tree").simulate(case, RK4, 0.125, np.array([0.125, 1.0]))
    assert guarded(trajectory, case, 0.125) == "warning"
    assert guarded(without_warnings(trajectory), case, 0.125) == "non_finite"


@pytest.mark.parametrize("control", [float("nan"), 1e11])
def test_control_that_mujoco_ignores_is_caught(control: float) -> None:
    model = mujoco.MjModel.from_xml_string(TINY)
    data = mujoco.MjData(model)
    data.ctrl[:] = control
    with quiet(mujoco):
        trajectory = trajectory_of(model, data, np.array([0.002, 0.01]))
    assert not trajectory.values["x"].any()  # looks like rest
    assert trajectory.warnings["BADCTRL"] == 5
    assert guarded(trajectory, case_of(), 0.002) == "warning"


@pytest.mark.parametrize("change", ["ctrl", "opt.timestep", "model"])
def test_input_that_changes_during_the_run_is_caught(change: str) -> None:
    """A callback stands for what an engine might do to its inputs."""
    model = mujoco.MjModel.from_xml_string(TINY)
    data = mujoco.MjData(model)

    def interfere(m: Any, d: Any) -> None:
        if change == "ctrl":
            d.ctrl[:] = 0.5
        elif change == "opt.timestep":
            m.opt.timestep = 0.004
        else:
            m.body_mass[1] = 3.0

    mujoco.set_mjcb_passive(interfere)
    try:
        trajectory = trajectory_of(model, data, np.array([0.002]))
    finally:
        mujoco.set_mjcb_passive(None)
    assert change in trajectory.changed_inputs
    on_time = dataclasses.replace(trajectory, clock=trajectory.times, steps=1)
    assert guarded(on_time, case_of(), 0.002) == "inputs_changed"
