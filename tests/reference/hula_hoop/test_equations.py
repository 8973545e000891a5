"""Linear response, modes, rest and schemes of hula_hoop."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.errors import NoOrbitError, ParameterError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.hula_hoop.theory import nondimensional
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.solve.batched import solve_many
from mbcheck.reference.solve.schemes import SCHEMES, ScalarEquations, integrate
from mbcheck.reference.solve.single import solve

SCENE = get_scene("hula_hoop")


def test_the_linear_response_on_the_invariant_line_is_within_the_bound() -> None:
    p = HulaHoop()
    c = SCENE.coefficients(p)
    times = np.linspace(0, 0.25, 21)  # beyond, rounding leaves the line: it is unstable
    solution = solve(SCENE, p, SCENE.state({"theta": np.pi / 2}), times)
    omega_n, decay = float(p.omega_n), float(p.omega_n) * p.damping_ratio
    forced = c.force / (c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega)
    damped = np.sqrt(omega_n**2 - decay**2)
    start = -forced.real, -(1j * c.omega * forced).real
    free = np.exp(-decay * times) * (
        start[0] * np.cos(damped * times)
        + (start[1] + decay * start[0]) / damped * np.sin(damped * times)
    )
    exact = (forced * np.exp(1j * c.omega * times)).real + free
    error = np.max(np.abs(solution.states[0] - exact))
    assert error <= solution.error_bound[0]
    assert solution.error_bound[0] < 1e-10 * np.max(np.abs(exact))


@pytest.mark.slow
def test_the_bound_of_many_points_is_honest() -> None:
    p = HulaHoop(
        force_amplitude=np.linspace(5, 150, 24),  # type: ignore[arg-type]
        force_frequency=np.linspace(1, 10, 24)[::-1],  # type: ignore[arg-type]
    )
    times = np.array([0.2, 0.5])
    rough = solve_many(SCENE, p, SCENE.state({}), times, tolerance=1e-6)
    fine = solve_many(SCENE, p, SCENE.state({}), times, tolerance=1e-13)
    error = np.max(np.abs(rough.states - fine.states), axis=-1)
    assert np.all(error <= rough.error_bound + fine.error_bound)
    assert np.max(error) > 1e-12  # the rough run was rough


def test_undamped_modes_are_the_analytic_ones() -> None:
    p = HulaHoop(inertia_ratio=0.5)
    c = SCENE.coefficients(p)
    across = c.stiffness * c.inertia / (c.mass * c.inertia - c.coupling**2)
    for theta, square in ((0.0, across), (np.pi / 2, c.stiffness / c.mass)):
        mass, _, stiffness = linearise(SCENE, p, SCENE.state({"theta": theta}))
        found = modes(mass, 0 * mass, stiffness)
        np.testing.assert_allclose(
            [mode.omega for mode in found], [0, np.sqrt(square)], rtol=1e-12, atol=1e-9
        )


@pytest.mark.parametrize("clock", [False, True])
@pytest.mark.parametrize("name", SCHEMES)
def test_schemes_have_their_order(name: str, clock: bool) -> None:
    order = {"ExplicitMidpoint": 2, "RK33": 3, "RK44": 4, "DOPRI5": 5, "RK67": 6}.get(name, 1)
    start = SCENE.state({"theta": 0.3, "theta_dot": 18.0})
    end = 1 / 32
    truth = solve(SCENE, HulaHoop(), start, [end]).states
    errors = [
        float(np.max(np.abs(found - truth)))
        for steps in {5: (48, 96), 6: (8, 16)}.get(order, (128, 256))
        for found in [
            integrate(
                ScalarEquations(SCENE, HulaHoop(), clock),
                name,
                start,
                end / steps,
                np.array([steps]),
            )
        ]
    ]
    assert np.log2(errors[0] / errors[1]) > order - 0.4


def test_a_rod_that_hangs_along_the_slide_is_a_pendulum() -> None:
    p = HulaHoop(force_amplitude=0.0, inertia_ratio=0.5, gravity_y=-9.81)
    hanging, inverted = (SCENE.equilibria[name](p) for name in ("hanging", "inverted"))
    assert hanging["theta"] == pytest.approx(-np.pi / 2)
    assert inverted["theta"] == pytest.approx(np.pi / 2)
    assert hanging["y"] == pytest.approx(-0.495 * 9.81 / 1000)
    mass, _, stiffness = linearise(SCENE, p, SCENE.state(hanging))
    omega = sorted(mode.omega for mode in modes(mass, 0 * mass, stiffness))
    assert omega[0] == pytest.approx(np.sqrt(9.81 / (p.rod_length * 1.5)), rel=1e-12)
    assert SCENE.equilibria["rod_aligned"](p) == inverted
    with pytest.raises(NoOrbitError, match="gravity turns the rod"):
        SCENE.equilibria["rod_across"](p)
    with pytest.raises(NoOrbitError, match="hangs nowhere"):
        SCENE.equilibria["hanging"](HulaHoop())


def test_formulas_without_gravity_refuse_it() -> None:
    with pytest.raises(ParameterError, match="gravity"):
        nondimensional(HulaHoop(gravity_x=1.0))
