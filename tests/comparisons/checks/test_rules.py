"""Each rule: a run that it warns of, which really goes wrong, and one beside it that does not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks import suite
from mbcheck.comparisons.checks.rules.cautions import RULES, Rule, cautions, frequency_error
from mbcheck.comparisons.checks.rules.conditions import Statement
from mbcheck.comparisons.checks.rules.run import RunConditions
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.exudyn.engine import Exudyn
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup, run
from mbcheck.comparisons.faults.runs import Altered
from mbcheck.comparisons.queries.simulate import simulate
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import EngineError
from mbcheck.reference.hula_hoop.equations import CONSERVATIVE, UNFORCED, HulaHoop
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve.single import solve

LINE = {"y": 0.01, "theta": np.pi / 2}
"""On the invariant line, where y vibrates alone: y'' = -k / (M + m) y."""
OMEGA = float(CONSERVATIVE.omega_n)
VIBRATION = Case("hula_hoop", "vibration", CONSERVATIVE, LINE)


def method_of(engine: Adapter, name: str) -> Method:
    return next(method for method in engine.methods if method.name == name)


def rules(
    engine: str | Adapter, case: Case, method: str, step: float, horizon: float, model: str = ""
) -> set[str]:
    """Return the names of the rules that speak."""
    engine = get_engine(engine) if isinstance(engine, str) else engine
    model = model or engine.models(case.scene)[0]
    found = cautions(Setup(engine, case, model, method_of(engine, method), step), horizon)
    assert all(item.message for item in found)
    assert {item.rule for item in found} <= set(RULES)
    return {item.rule for item in found}


def values(
    engine: str | Adapter, case: Case, method: str, step: float, horizon: float, model: str = ""
) -> dict[str, Array]:
    """Return a run's observables at every step."""
    engine = get_engine(engine) if isinstance(engine, str) else engine
    model = model or engine.models(case.scene)[0]
    times: Array = np.arange(1.0, round(horizon / step) + 1) * float(step)
    found = run(Setup(engine, case, model, method_of(engine, method), step), times).values
    return {"t": times, **found}


@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_step_limit(method: str) -> None:
    free = replace(VIBRATION, state={"y": 1e-6})  # across: the spring sees M alone
    omega = np.sqrt(CONSERVATIVE.stiffness / CONSERVATIVE.main_mass)
    limit = {"Euler": 2.0, "RK4": 2.0 * np.sqrt(2)}[method] / omega
    horizon = 200 * 2 * np.pi / omega
    assert "step_limit" in rules("mujoco", free, method, 1.02 * limit, horizon)
    assert "step_limit" not in rules("mujoco", free, method, 0.98 * limit, horizon)
    with pytest.raises(EngineError):
        values("mujoco", free, method, 1.02 * limit, horizon)
    bounded = values("mujoco", free, method, 0.98 * limit, 20 * 2 * np.pi / omega)
    assert np.max(np.abs(bounded["y"])) < 1e-5


def test_step_limit_names_the_mode_and_the_step() -> None:
    engine = get_engine("mujoco")
    case = get_scene("speed_regulator").case("rotation")
    found = cautions(Setup(engine, case, "connect_hard", method_of(engine, "Euler"), 2e-3), 1.0)
    message = {item.rule: item.message for item in found}["step_limit"]
    assert "pin_angle" in message
    assert "1000 rad/s" in message
    assert "0.00166 s" in message


@pytest.mark.parametrize(("method", "step"), [("RK4", 2.0**-6), ("Euler", 2.0**-5)])
def test_coarse_step(method: str, step: float) -> None:
    horizon = 8.0
    assert "coarse_step" in rules("mujoco", VIBRATION, method, step, horizon)
    assert "coarse_step" not in rules("mujoco", VIBRATION, "RK4", step / 16, horizon)
    found = values("mujoco", VIBRATION, method, step, horizon)
    last = slice(-8, None)
    exact = 0.01 * np.cos(OMEGA * found["t"][last])
    assert np.max(np.abs(found["y"])) < 0.02
    assert np.max(np.abs(found["y"][last] - exact)) > 0.1 * 0.01


@pytest.mark.parametrize(
    ("engine", "method", "step", "horizon"),
    [("exudyn", "GeneralizedAlpha", 2.0**-5, 16.0), ("mujoco", "discrete", 2.0**-12, 2.0)],
)
def test_numerical_damping(engine: str, method: str, step: float, horizon: float) -> None:
    assert "numerical_damping" in rules(engine, VIBRATION, method, step, horizon)
    assert "numerical_damping" not in rules(engine, VIBRATION, method, step / 16, horizon)
    found = values(engine, VIBRATION, method, step, horizon)["y"]
    lost = 1 - np.max(np.abs(found[-round(0.2 / step) :])) / 0.01
    assert lost > 0.08


def test_what_the_motion_damps_anyway_is_no_numerical_damping() -> None:
    damped = replace(VIBRATION, parameters=UNFORCED)
    assert "numerical_damping" in rules("mujoco", VIBRATION, "discrete", 2.0**-13, 2.0)
    assert "numerical_damping" not in rules("mujoco", damped, "discrete", 2.0**-13, 2.0)


def test_inertia_floor() -> None:
    light = HulaHoop(rod_length=1e-4, free_mass=1e-6)
    case = Case("hula_hoop", "light", light, {})
    assert "inertia_floor" in rules("mujoco", case, "RK4", 1e-3, 1.0)
    assert "inertia_floor" not in rules("exudyn", case, "RK44", 1e-3, 1.0)
    found = get_engine("mujoco").bind(case, "tree").mass_matrices(np.zeros((1, 4)))[0, 1, 1]
    assert found / (light.free_mass * light.rod_length**2) - 1 > 0.1
    lighter = replace(case, parameters=light.replace(free_mass=5e-16))
    assert "inertia_floor" in rules("mujoco", lighter, "RK4", 1e-3, 1.0)
    with pytest.raises(EngineError, match=r"mass|inertia"):
        values("mujoco", lighter, "RK4", 1e-3, 0.01)


def test_newton_tolerance() -> None:
    case = replace(get_scene("hula_hoop").case("free_undamped"), horizon=0.5)
    engine = get_engine("exudyn")
    loose: Any = engine.with_option("newton_tolerance", 1e-1)
    assert "newton_tolerance" in rules(loose, case, "GeneralizedAlpha", 2.0**-7, 0.5)
    assert "newton_tolerance" not in rules(engine, case, "GeneralizedAlpha", 2.0**-7, 0.5)
    wrong = values(loose, case, "GeneralizedAlpha", 2.0**-7, 0.5)["y"]
    right = values(engine, case, "GeneralizedAlpha", 2.0**-7, 0.5)["y"]
    assert np.max(np.abs(wrong - right)) > 1e-6 * np.max(np.abs(right))


def test_closure_softness() -> None:
    case = get_scene("speed_regulator").case("startup")
    step, horizon = 2.0**-10, 2.0
    assert "closure_softness" in rules("mujoco", case, "RK4", step, horizon, "connect")
    assert "closure_softness" not in rules("mujoco", case, "RK4", step, horizon, "connect_hard")
    opened = values("mujoco", case, "RK4", step, horizon, "connect")["position_violation"]
    assert np.max(opened) > 1e-3 * case.parameters.crank_radius


@pytest.mark.parametrize(
    ("engine", "element", "few"), [("mujoco", "ancf", 4), ("exudyn", "geometrically_exact", 2)]
)
def test_discretisation(engine: str, element: str, few: int) -> None:
    case = get_scene("rotating_beam").case("steady_12")
    coarse = replace(case, parameters=case.parameters.replace(segments=few, element=element))
    fine = replace(case, parameters=case.parameters.replace(segments=48, element=element))
    method = {"mujoco": "RK4", "exudyn": "GeneralizedAlpha"}[engine]
    assert "discretisation" in rules(engine, coarse, method, 2.0**-12, 1.0)
    assert "discretisation" not in rules(engine, fine, method, 2.0**-12, 1.0)
    one = get_engine(engine)
    error = frequency_error(one, one.models(case.scene)[0], "rotating_beam", coarse.parameters)
    assert error is not None
    assert abs(error) > 1e-2


def test_dead_centre() -> None:
    regulator = get_scene("speed_regulator").case("rotation")
    near = regulator.parameters.replace(crank_radius=1.25 * (1 - 1e-6))
    case = replace(regulator, parameters=near)
    step = 2.0**-8
    assert "dead_centre" in rules("exudyn", case, "RK44", step, 1.0, "one_dof")
    assert "dead_centre" not in rules("exudyn", regulator, "RK44", step, 1.0, "one_dof")
    scene = get_scene("speed_regulator")
    right = solve(scene, near, scene.state(case.state), np.array([1.0])).states[0, 0]
    try:
        off = values("exudyn", case, "RK44", step, 1.0, "one_dof")["phi"][-1] - right
    except EngineError:
        off = np.inf
    assert abs(off) > 1e-2


def test_a_start_at_the_dead_centre_of_the_slider_loses_nothing() -> None:
    case = get_scene("speed_regulator").case("dead_centre")
    assert not rules("exudyn", case, "RK44", 2.0**-8, case.horizon, "one_dof")


def test_unstable_start() -> None:
    scene = get_scene("speed_regulator")
    p = scene.parameters().replace(torque=0.0, damping=0.0)
    case = Case("speed_regulator", "balanced", p, {"phi": np.pi / 2})
    step, horizon = 2.0**-6, 60.0
    assert "unstable_start" in rules("exudyn", case, "RK44", step, horizon, "one_dof")
    moved = replace(case, state={"phi": np.pi / 2 + 0.1})
    assert "unstable_start" not in rules("exudyn", moved, "RK44", step, horizon, "one_dof")
    ends = [
        values("exudyn", replace(case, state={"phi": np.pi / 2 + by}), "RK44", step, horizon,
               "one_dof")["phi"]
        for by in (1e-14, -1e-14)
    ]  # fmt: skip
    assert np.max(np.abs(ends[0] - ends[1])) > 1.0


def test_amplification() -> None:
    case = get_scene("hula_hoop").case("rod_aligned")
    assert "amplification" in rules("exudyn", case, "RK67", 2.0**-9, 1.0)
    assert "amplification" not in rules("exudyn", case, "RK67", 2.0**-9, 0.5)
    moved = replace(case, state={"theta": np.pi / 2 + 1e-9})
    ends = [values("exudyn", one, "RK67", 2.0**-9, 1.0)["theta"] for one in (case, moved)]
    assert np.max(np.abs(ends[0] - ends[1])) > 1e4 * 1e-9


def test_clock_rounding() -> None:
    step, horizon = 1e-3, 100.0
    rest = replace(VIBRATION, state={})
    assert "clock_rounding" in rules("mujoco", rest, "Euler", step, horizon)
    assert not rules("exudyn", rest, "RK44", step, horizon)
    assert "clock_rounding" not in rules("mujoco", rest, "Euler", 2.0**-10, horizon)
    engine = get_engine("mujoco")
    late = []
    for one in (step, 2.0**-10):
        times = one * np.array([round(horizon / one)])
        found = run(Setup(engine, rest, "tree", method_of(engine, "Euler"), one), times)
        late.append(abs(found.clock[0] - times[0]))
    assert late[0] * OMEGA > 1e-9
    assert late[1] == 0


def test_engine_range() -> None:
    stiff = CONSERVATIVE.replace(stiffness=1e16)
    case = Case("hula_hoop", "stiff", stiff, {"y": 1e-5, "theta": np.pi / 2})
    step, horizon = 1e-10, 1e-9
    assert "engine_range" in rules("mujoco", case, "RK4", step, horizon)
    assert "engine_range" not in rules("exudyn", case, "RK44", step, horizon)
    with pytest.raises(EngineError, match="BADQACC"):
        values("mujoco", case, "RK4", step, horizon)
    healthy = values("exudyn", case, "RK44", step, horizon)
    exact = 1e-5 * np.cos(float(stiff.omega_n) * healthy["t"])
    np.testing.assert_allclose(healthy["y"], exact, rtol=1e-6)


def test_ill_conditioned() -> None:
    heavy = UNFORCED.replace(main_mass=1e-12, free_mass=1.0)
    case = Case("hula_hoop", "heavy", heavy, {"y": 1e-3})
    assert "ill_conditioned" in rules("mujoco", case, "RK4", 1e-9, 1e-8)
    light = replace(case, parameters=UNFORCED)
    assert "ill_conditioned" not in rules("mujoco", light, "RK4", 1e-3, 1e-2)
    scene = get_scene("hula_hoop")
    states = np.array([[1e-3, 0.1 * i, 0.0, 0.0] for i in (0, 1e-6, 1e-5)])
    found = get_engine("mujoco").bind(case, "tree").accelerations(np.zeros(3), states)
    right = np.array([scene.right_hand_side(heavy)(0.0, state)[2:] for state in states])
    assert np.max(np.abs(found - right)) > 1e-6 * np.max(np.abs(right))


TRUE_OF_DEFAULTS = {
    ("hula_hoop", "rod_aligned", "amplification"),  # its horizon is cut for it
    ("hula_hoop", "free_undamped", "numerical_damping"),  # 0.1 by explicit and implicit Euler
    *(("hula_hoop", case, "numerical_damping") for case in ("hanging", "swinging")),  # 0.06 so
    ("ball_hoop", "gravity_along", "numerical_damping"),  # by methods of order 1
    *(  # 0.06 to 0.07 by a method of order 1
        ("floating_platform", case, "numerical_damping")
        for case in ("afloat", "conservative", "falling", "planar")
    ),
    *(  # 0.06 and 0.09 by a method of order 1
        ("floating_beam", case, "numerical_damping") for case in ("afloat", "conservative")
    ),
    *(  # 0.05 to 0.1 by methods of order 1
        ("rotor_pendulum", case, "numerical_damping")
        for case in (
            "case_1_antiphase_settles", "case_1_startup", "case_1_synchronous", "modes_at_rest",
            "modes_at_speed",
        )
    ),
    ("speed_regulator", "opened_loop", "inconsistent_start"),
    ("rotating_beam", "spin_up", "discretisation"),  # 2.7 % with 16 rods at 10 rad/s
    ("rotating_beam", "above_critical", "discretisation"),  # 1.7 % with 8 rods
    *(  # MuJoCo's default closure opens by 0.25 mm and more
        ("speed_regulator", case, "closure_softness")
        for case in (
            "startup", "conservative", "long_crank", "limit_cycle_c4", "settles_to_rest",
            "settles_to_rotation", "heavy_rod", "stretched_spring", "rest_top",
            "weighed", "swinging",
        )
    ),
}  # fmt: skip
"""What rules say of the cases with default steps."""


def spoken(scene: str, full: bool) -> set[tuple[str, str, str]]:
    found = set()
    for case in get_scene(scene).cases:
        for name in ("mujoco", "exudyn"):
            engine = get_engine(name)
            for model in engine.models(scene):
                for method in (
                    engine.methods if full else (suite.best_method(Setup(engine, case, model)),)
                ):
                    if method is None or engine.bind(case, model).unsupported_reason(case, method):
                        continue
                    step = Setup(engine, case, model, method).default_step
                    for item in cautions(Setup(engine, case, model, method, step), case.horizon):
                        found.add((scene, case.name, item.rule))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_default_cases_trip_what_is_true_of_them(scene: str) -> None:
    assert spoken(scene, full=True) == {item for item in TRUE_OF_DEFAULTS if item[0] == scene}


@pytest.mark.parametrize("scene", ["hula_hoop", "speed_regulator"])
def test_best_methods_trip_nothing_that_is_their_own(scene: str) -> None:
    of_methods = {"step_limit", "coarse_step", "numerical_damping", "newton_tolerance"}
    found = spoken(scene, full=False)
    assert found <= TRUE_OF_DEFAULTS
    assert not {item for item in found if item[2] in of_methods}


def test_an_engine_that_fails_while_a_rule_asks_it_says_nothing() -> None:
    """What it fails in is told when it runs; the other rules speak."""

    class Failing(Exudyn):
        """An engine that cannot linearise."""

        def linearise(self, *_: Any) -> Any:
            raise RuntimeError("no matrices")

    case = get_scene("rotating_beam").case("steady_12")
    coarse = replace(case, parameters=case.parameters.replace(segments=2))
    setting = (coarse, "GeneralizedAlpha", 2.0**-3, 1e3)
    assert {"discretisation", "coarse_step"} <= rules("exudyn", *setting)
    assert "discretisation" not in rules(Adapter(Failing()), *setting)
    assert "coarse_step" in rules(Adapter(Failing()), *setting)


def test_a_rule_that_fails_is_not_hidden() -> None:
    def broken(run: RunConditions) -> Statement | None:
        raise ZeroDivisionError(f"a fault of our own, at {run.step_size} s")

    engine = get_engine("mujoco")
    setup = Setup(engine, VIBRATION, "tree", method_of(engine, "RK4"), 1e-3)
    assert not cautions(setup, 1.0, {})
    with pytest.raises(ZeroDivisionError, match="of our own"):
        cautions(setup, 1.0, {"broken": Rule("fails", broken)})


def test_a_mode_that_explodes_is_said_to() -> None:
    """Whatever its gain: one beyond floats too, on which nothing was said once."""
    free = replace(VIBRATION, state={"y": 1e-6})
    omega = np.sqrt(CONSERVATIVE.stiffness / CONSERVATIVE.main_mass)
    spoken = rules("mujoco", free, "RK4", 20 / omega, 1e4 / omega)
    assert {"step_limit", "numerical_damping"} <= spoken


def test_errors_of_a_motion_too_stiff_to_follow_are_not_called_growth() -> None:
    stiff = replace(VIBRATION, parameters=CONSERVATIVE.replace(damping_ratio=1e3))
    assert "amplification" not in rules("mujoco", stiff, "RK4", 2.0**-16, 2.0)


def test_simulate_tells_before_it_runs() -> None:
    times = [0.25, 0.5]
    with pytest.raises(EngineError, match="rule step_limit"):
        simulate(
            "hula_hoop", engine="mujoco", method="Euler", step=2.0**-2, times=np.arange(1, 200) / 4
        )
    long = {"crank_radius": 0.4}
    told = simulate("speed_regulator", engine="mujoco", method="RK4", parameters=long, times=times)
    document = told.as_json()["cautions"]
    assert [item["rule"] for item in document] == ["closure_softness"]
    assert not simulate("hula_hoop", times=times).cautions


def test_a_failed_check_names_its_rules() -> None:
    (check,) = suite.plan(ids=["verification/hula_hoop/rod_aligned/trajectory/mujoco/RK4/y"])

    def shifted(found: Trajectory, case: Case) -> Trajectory:
        return replace(found, values={**found.values, "y": found.values["y"] + 1.0})

    wrong = Altered(get_engine("mujoco"), shifted)
    reasons = [r.reason for r in suite.run_check(check, engine=wrong) if r.verdict != "pass"]
    assert reasons
    assert all("rule amplification" in reason for reason in reasons)
    assert all("rule" not in r.reason for r in suite.run_check(check))
