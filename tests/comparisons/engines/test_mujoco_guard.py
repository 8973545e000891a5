"""The guard, on failures that MuJoCo really has."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.engines.mujoco.library import integrate, quiet
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup, guard, run
from mbcheck.comparisons.faults.mujoco import Edited, MujocoAdapter
from mbcheck.reference.errors import EngineError
from mbcheck.reference.hula_hoop.equations import (
    SPINNING,
    HulaHoop,
)
from mbcheck.reference.scene import Case

ENGINE = MujocoAdapter()


METHODS = {method.name: method for method in ENGINE.methods}


RK4 = METHODS["RK4"]


def case_of(
    parameters: HulaHoop | None = None, state: Mapping[str, float] | None = None, start: float = 0.0
) -> Case:
    return Case("hula_hoop", "test", parameters or HulaHoop(), state or {}, 0.5, (), start)


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
