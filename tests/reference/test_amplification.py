"""Amplification matrices against the schemes themselves, and against engines' single steps."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.free_vibrations import place, places
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.reference import get_scene
from mbcheck.reference.amplification import (
    AMPLIFICATION,
    Vibrations,
    amplification_factors,
    excess,
    largest_stable_step,
    numerical_modes,
    rates,
    vibrations,
)
from mbcheck.reference.equations import scene_equations
from mbcheck.reference.hula_hoop.equations import SCENE, HulaHoop
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve import schemes

SMALL = 1e-7


def one(omega: float, damping: float = 0.0) -> Vibrations:
    return vibrations(np.eye(1), np.array([[damping]]), np.array([[omega**2]]))


@pytest.mark.parametrize("scheme", sorted(schemes.SCHEMES))
@pytest.mark.parametrize("name", ["hula_hoop", "rotor_pendulum", "speed_regulator"])
def test_matrices_are_the_schemes_on_small_vibrations(name: str, scheme: str) -> None:
    scene = get_scene(name)
    p = scene.unforced(scene.parameters())
    if name == "speed_regulator":
        p = p.replace(torque=0.0)
    case = Case(name, "", p, {})
    which = next(iter(scene.equilibria))
    rest = scene.state(scene.equilibria[which](p))
    only_joints = scheme == "semi_implicit_euler"
    at = place(scene_equations(case), "rest", rest, False, only_joints)
    step = 0.3 / np.max(np.abs(rates(at.modes)))
    found = np.empty((len(rest), len(rest)))
    for column in range(len(rest)):
        ends = []
        for sign in (1, -1):
            start = rest.copy()
            start[column] += sign * SMALL
            samples = np.array([1])
            undriven = schemes.integrate(
                schemes.ScalarEquations(scene, p), scheme, start, step, samples
            )
            ends.append(undriven[:, 0])
        found[:, column] = (ends[0] - ends[1]) / (2 * SMALL)
    expected = AMPLIFICATION[scheme](at.matrices, step)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.max(np.abs(expected)))


STEPS_OF_ENGINES = [
    (scene, engine, model, method.name)
    for scene, engine, model in (
        ("hula_hoop", "mujoco", "tree"),
        ("rotor_pendulum", "mujoco", "tree"),
        ("rotor_pendulum", "exudyn", "kinematic_tree"),
        ("speed_regulator", "mujoco", "connect"),
    )
    for method in get_engine(engine).methods
    if (scene, method.name) != ("hula_hoop", "discrete")  # whose first step from y = 0 does nothing
    if engine == "mujoco" or method.name in ("RK44", "GeneralizedAlpha", "TrapezoidalIndex2")
]


def stepped(engine: Any, case: Case, model: str, method: Any, step: float, count: int) -> Array:
    """Return the scene's states (2 n,) after some steps."""
    times = np.array([count * step])
    found = engine.bind(case, model).simulate(case, method, step, times)
    return np.array([found.values[name][0] for name in get_scene(case.scene).public_states])


@pytest.mark.parametrize(("name", "engine_name", "model", "method_name"), STEPS_OF_ENGINES)
def test_matrices_are_what_engines_do(
    name: str, engine_name: str, model: str, method_name: str
) -> None:
    engine = get_engine(engine_name)
    method = next(m for m in engine.methods if m.name == method_name)
    scene = get_scene(name)
    p = scene.parameters()
    p = p.replace(force_amplitude=0.0) if name == "hula_hoop" else p
    p = p.replace(torque=0.0) if name == "speed_regulator" else p
    if name == "rotor_pendulum":  # the motors' dampers without their torque
        p = p.replace(synchronous_speed=1e-9)
    case = Case(name, "", p, {})
    scheme = Setup(engine, case, model, method).linear_scheme
    assert scheme is not None
    at = places(Setup(engine, case, model), scheme)[0]
    step, count = 0.3 / np.max(np.abs(at.rates)), 3
    n, width = len(scene.coordinates), len(at.coordinates)
    matrix = AMPLIFICATION[scheme](at.matrices, step)
    values = dict(zip(scene.state_names, at.state, strict=False))
    if name == "speed_regulator":
        values = {"phi": at.state[0], "phi_dot": 0.0}
    names = at.coordinates
    for row, moved in enumerate(scene.public_states):
        if name == "speed_regulator":
            break
        ends = []
        for sign in (1, -1):
            start = replace(case, state={**values, moved: values[moved] + sign * 1e-5})
            ends.append(stepped(engine, start, model, method, step, count))
        found = (ends[0] - ends[1]) / 2e-5
        x = np.zeros(len(matrix))
        x[row if row < n else row - n + width] = 1.0
        if len(matrix) > 2 * width:
            follows = -np.linalg.solve(
                at.matrices.mass, np.hstack([at.matrices.stiffness, at.matrices.damping])
            )
            x[2 * width :] = follows @ x[: 2 * width]
        x = np.linalg.matrix_power(matrix, count) @ x
        expected = np.concatenate([x[:n], x[width : width + n]])
        np.testing.assert_allclose(found, expected, atol=2e-5 * np.max(np.abs(expected)))
    if name == "speed_regulator":  # the closure is opened, the slider looked at
        offsets = []
        for sign in (1, -1):
            start = replace(case, state=values, inconsistency={"y": sign * 1e-6})
            end = (
                engine.bind(start, model)
                .simulate(start, method, step, np.array([count * step]))
                .values
            )
            offsets.append([end[one][0] for one in ("phi", "y", "phi_dot", "y_dot")])
        found = (np.array(offsets[0]) - offsets[1]) / 2e-6
        x = np.zeros(len(matrix))
        x[names.index("y")] = 1.0
        x = np.linalg.matrix_power(matrix, count) @ x
        expected = x[[0, 2, 3, 5]]
        # the closure's softness, which is none of a spring, is in the force that discrete finds
        loose = 1e-2 if method_name == "discrete" else 1e-3
        np.testing.assert_allclose(found, expected, atol=loose * np.max(np.abs(expected)))


@pytest.mark.parametrize(
    ("scheme", "limit"),
    [
        ("semi_implicit_euler", 2.0),
        ("RK44", 2 * np.sqrt(2)),
        ("RK33", np.sqrt(3)),
        ("implicit_euler", np.inf),
        ("trapezoidal", np.inf),
        ("generalized_alpha", np.inf),
    ],
)
def test_limits_without_damping_are_those_of_the_books(scheme: str, limit: float) -> None:
    omega = 7.0
    found = largest_stable_step(scheme, one(omega), 1e4 / omega)
    assert found * omega == pytest.approx(limit, rel=2e-3) or found == limit == np.inf


def test_explicit_dampers_limit_the_step_and_late_ones_do_not() -> None:
    damped = one(1.0, 1e4)
    explicit = damped._replace(implicit_damping=0 * damped.damping)
    late = largest_stable_step("semi_implicit_euler", damped, 1.0)
    early = largest_stable_step("semi_implicit_euler", explicit, 1.0)
    kutta = largest_stable_step("RK44", damped, 1.0)
    assert late > 1.0
    assert early == pytest.approx(2e-4, rel=1e-2)
    assert kutta == pytest.approx(2.785e-4, rel=1e-2)


def test_growth_of_the_motion_itself_is_no_instability() -> None:
    of = one(1.0)._replace(stiffness=-np.ones((1, 1, 1)))
    assert excess("RK44", of, 0.01, 20.0) <= 0


def test_growth_of_one_mode_excuses_no_other() -> None:
    """Beside a mode of growth 5 1/s, one of decay 50 1/s sets the limit that it has alone."""
    unit, pair = np.ones((2, 1, 1)), np.array([-25.0, 0.0])[:, None, None]
    damping = np.array([0.0, 50.0])[:, None, None]
    of = Vibrations(unit, damping, pair, 0 * damping)
    assert largest_stable_step("RK44", of, 10.0) == pytest.approx(2.785 / 50, rel=1e-2)


def test_modes_that_fall_apart_have_the_same_factors() -> None:
    p = HulaHoop(hinge_damping_ratio=0.0, damping_ratio=0.0)
    at = place(scene_equations(Case("hula_hoop", "", p, {})), "", np.zeros(4), False, False)
    assert at.modes.mass.shape == (2, 1, 1)
    for scheme in AMPLIFICATION:
        whole = np.sort(np.abs(amplification_factors(scheme, at.matrices, 1e-3)))
        split = np.sort(np.abs(amplification_factors(scheme, at.modes, 1e-3)))
        np.testing.assert_allclose(whole, split, atol=1e-6)
    assert SCENE.name == "hula_hoop"


def test_modes_that_a_damper_couples_stay_together() -> None:
    mass, stiffness = np.eye(2), np.diag([1.0, 4.0])
    assert vibrations(mass, np.diag([0.1, 0.2]), stiffness).mass.shape == (2, 1, 1)
    coupled = np.array([[0.1, 0.05], [0.05, 0.2]])
    assert vibrations(mass, coupled, stiffness, 0 * mass).damping is coupled
    assert vibrations(mass, 0 * mass, stiffness, coupled).implicit_damping is coupled


def test_what_is_kept_of_a_mode_follows_from_the_order() -> None:
    h = 0.01
    (euler,) = numerical_modes("implicit_euler", one(1.0), h)
    assert (euler.numerical - euler.exact).real == pytest.approx(-h / 2, rel=1e-2)
    (leapfrog,) = numerical_modes("semi_implicit_euler", one(1.0), h)
    assert (leapfrog.numerical - leapfrog.exact).imag == pytest.approx(h**2 / 24, rel=1e-2)
    (kutta,) = numerical_modes("RK44", one(1.0), 0.1)
    assert (kutta.numerical - kutta.exact).imag == pytest.approx(-(0.1**4) / 120, rel=2e-2)
