"""The equations of floating_beam against Lagrange's, Newton's, and those of rotating_beam."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference import get_scene, quaternions
from mbcheck.reference.body.floating_scene import LINEAR
from mbcheck.reference.body.rotation import MOMENTUM, central_inertia
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.floating_beam import ANGLES, IN_PLANE, PLANAR, RODS, TUMBLING, FloatingBeam
from mbcheck.reference.rotating_beam.chain import chain_scene
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.solve.single import solve
from mbcheck.tests.support.exact.tree import (
    AXES,
    Part,
    Torques,
    about,
    lagrange,
    momenta,
)

SCENE = get_scene("floating_beam")
WEIGHED = FloatingBeam(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
STATES = np.random.default_rng(20).normal(size=(3, 2, 7 + RODS))
BENT = slice(3, 3 + RODS)


def parts(p: FloatingBeam) -> list[Part]:
    """Return hub and rods, the last one with the point mass at its end."""
    h, mass = p.length / 3, p.beam_mass / 3
    across = mass * h**2 / 12 + p.polar_moment / 2
    tensor, middle = np.diag([p.polar_moment, across, across]), h / 2 * AXES[0]
    centre = (mass * middle + p.tip_mass * h * AXES[0]) / (mass + p.tip_mass)
    last = np.array(tensor)
    for weight, place in ((mass, middle), (p.tip_mass, h * AXES[0])):
        arm = place - centre
        last += weight * (arm @ arm * AXES - np.outer(arm, arm))
    twisted = about(AXES[0], p.twist)
    return [
        Part(-1, p.mass, p.centre, central_inertia(p)),
        Part(0, mass, middle, tensor, p.hub_radius * AXES[0]),
        Part(1, mass, middle, tensor, h * AXES[0], twisted),
        Part(2, mass + p.tip_mass, centre, last, h * AXES[0], twisted),
    ]


def torques(p: FloatingBeam) -> Torques:
    """Return what springs and dampers make of angles and rates."""
    springs = p.bending_stiffness / (p.length / 3) * np.array([2, 1, 1])
    return lambda angles, rates: -springs * angles - p.hinge_damping * rates


@pytest.mark.parametrize("p", [WEIGHED, FloatingBeam(twist=-1.8, hub_radius=-0.2, tip_mass=0.0)])
def test_they_are_lagranges(p: FloatingBeam) -> None:
    c = SCENE.coefficients(p)
    for q, v in STATES:
        mass, right, energy = lagrange(parts(p), q, v, p.gravity, np.trace(central_inertia(p)))
        right[BENT] += torques(p)(q[BENT], v[BENT])
        energy -= q[BENT] @ torques(p)(q[BENT], 0 * v[BENT]) / 2
        assert np.array(SCENE.mass_matrix(q, c)) == pytest.approx(mass, rel=1e-11, abs=1e-13)
        assert SCENE.forces(0.0, q, v, c) == pytest.approx(right, rel=1e-7, abs=1e-8)
        assert SCENE.energy(q, v, c) == pytest.approx(energy, rel=1e-12)
        a = np.linalg.solve(mass, SCENE.forces(0.0, q, v, c))
        assert SCENE.accelerations(0.0, q, v, c) == pytest.approx(a, rel=1e-10, abs=1e-10)
        values = SCENE.observe(np.concatenate([q, v]), p)
        turning, moving = momenta(parts(p), q, v)
        assert [values[name] for name in MOMENTUM] == pytest.approx(turning, rel=1e-10)
        assert [values[name] for name in LINEAR] == pytest.approx(moving, rel=1e-10)


def test_on_a_hub_that_hardly_moves_it_is_the_chain_of_rotating_beam() -> None:
    """Of a hub of 1e12 kg the point stays, and its moment of inertia is as it was."""
    p = PLANAR.replace(mass=1e12, centre_x=0.0, centre_y=0.0, hinge_damping=0.0, polar_moment=1e-18)
    beam = RotatingBeam(
        length=p.length, hub_radius=p.hub_radius, hub_inertia=p.moment_3, area=1e-4,
        second_moment=1e-9, density=p.beam_mass / (1e-4 * p.length),
        youngs_modulus=p.bending_stiffness / 1e-9, mass=p.tip_mass, drive="torque",
        torque_amplitude=0.0,
    )  # fmt: skip
    fixed = chain_scene(RODS, "A")
    n, c = len(fixed.coordinates), SCENE.coefficients(p)
    for state in np.random.default_rng(3).normal(size=(4, 2, n)):
        (turn, *bent), (spin, *rates) = state
        start = dict(zip(ANGLES, bent, strict=True)) | {"omega_z": spin}
        start |= {"q_w": np.cos(turn / 2), "q_z": np.sin(turn / 2)}
        start |= {f"{name}_dot": rate for name, rate in zip(ANGLES, rates, strict=True)}
        q, v = np.split(SCENE.state(start), 2)
        a = SCENE.accelerations(0.0, q, v, c)
        right = fixed.right_hand_side(beam)(0.0, state.ravel())[n:]
        found = [2 * quaternions.product(quaternions.conjugate(q[-4:]), a[-4:])[3], *a[BENT]]
        assert found == pytest.approx(right, rel=1e-10, abs=1e-10)


def test_in_the_plane_it_stays_there_and_a_moving_frame_sees_the_same() -> None:
    times, values = np.array([0.0625]), []
    drift = {"x_dot": 1.5, "y_dot": -0.7, "z_dot": 0.4}
    for moving in (0.0, 1.0):
        start = IN_PLANE | {n: IN_PLANE.get(n, 0.0) + moving * part for n, part in drift.items()}
        states = solve(SCENE, PLANAR, SCENE.state(start), times).states
        values.append(SCENE.observe(states, PLANAR))
    rest, seen = values
    for name in SCENE.observables:
        place, rate = drift.get(f"{name}_dot", 0.0), drift.get(name, 0.0)
        assert seen[name] == pytest.approx(rest[name] + place * times + rate, abs=1e-10), name
    for name in ("z", "R_xz", "R_yz", "omega_x", "omega_y"):
        assert np.max(np.abs(rest[name])) < 1e-12, name
    assert np.max(np.abs(rest["theta_3"])) > 0.05


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(one, marks=[pytest.mark.slow] * (one.name != "tumbling"), id=one.name)
        for one in SCENE.cases
    ],
)
def test_momenta_are_conserved_to_rounding(case: Any) -> None:
    p, c = case.parameters, SCENE.coefficients(case.parameters)
    known = SCENE.invariants(p)  # type: ignore[misc]
    linear = set() if case.name in ("tumbling", "falling") else set(LINEAR)
    energy = {"energy"} if case.name in ("conservative", "falling") else set()
    assert set(known) == {*MOMENTUM, *linear, *energy}
    states = solve(SCENE, p, SCENE.state(TUMBLING), np.linspace(0, 0.0625, 5)[1:]).states
    half = len(states) // 2
    series = {name: invariant(states[:half], states[half:], c) for name, invariant in known.items()}
    for name, values in series.items():
        family = [one for other, one in series.items() if other[:-1] == name[:-1]]
        assert np.ptp(values) < 1e-12 * np.max(np.abs(family)), name
        assert np.max(np.abs(values)) > 1e-2 * np.max(np.abs(family))


def test_powers_are_the_change_of_energy() -> None:
    c, step = SCENE.coefficients(WEIGHED), 1e-30
    for q, v in STATES:
        a = np.array(SCENE.accelerations(0.0, q, v, c))
        slope = SCENE.energy(q + 1j * step * v, v + 1j * step * a, c).imag / step
        assert slope == pytest.approx(sum(SCENE.powers(0.0, q, v, c).values()), rel=1e-10)


def test_it_rests_anywhere_unless_it_falls() -> None:
    state = SCENE.state(SCENE.equilibria["afloat"](FloatingBeam()))
    assert not np.any(SCENE.right_hand_side(FloatingBeam())(0.0, state))
    with pytest.raises(NoOrbitError, match="falls"):
        SCENE.equilibria["afloat"](WEIGHED)
