"""The finite elements of rotating_beam: their equations conserve, and converge to their beams."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.reference.linear import linearise_at, modes
from mbcheck.reference.rotating_beam import SCENE
from mbcheck.reference.rotating_beam.chain import chain_scene
from mbcheck.reference.rotating_beam.elements import NODAL, element_scene
from mbcheck.reference.rotating_beam.parameters import RotatingBeam, steady_speed
from mbcheck.reference.scene import Array

HUB = RotatingBeam(hub_radius=0.7, mass=0.4, mass_position=0.6)
WEIGHED = {"gravity_x": 3.0, "gravity_y": -9.0}
TINY = 1e-30


def bent(element: str, n: int = 4) -> tuple[Array, Array]:
    """Return a position and rates, drawn, of a beam that is bent, sheared and stretched."""
    size = len(element_scene(n, element).coordinates)
    q, v = 0.1 * np.random.default_rng(7).uniform(-1, 1, (2, size))
    return q, v


@pytest.mark.parametrize("drive", ["prescribed", "torque"])
@pytest.mark.parametrize("element", NODAL)
def test_accelerations_solve_the_equations_for_points_too(element: str, drive: str) -> None:
    scene, (q, v) = element_scene(4, element), bent(element)
    c = scene.coefficients(HUB.replace(drive=drive))
    mass = np.array(scene.mass_matrix(q, c))
    a = np.array(scene.accelerations(0.7, q, v, c))
    assert mass @ a == pytest.approx(scene.forces(0.7, q, v, c), rel=1e-9, abs=1e-6)
    assert mass == pytest.approx(mass.T)
    many = scene.accelerations(0.7, np.array([q, q]).T, np.array([0 * v, v]).T, c)
    assert np.array(many)[:, 1] == pytest.approx(a)
    arrays = c._replace(bending=np.array([1.0, 2.0]) * c.bending)
    points = scene.accelerations(0.7, np.array([q, q]).T, np.array([v, v]).T, arrays)
    assert np.array(points)[:, 0] == pytest.approx(a)


@pytest.mark.parametrize("weight", [{}, WEIGHED])
@pytest.mark.parametrize("element", NODAL)
def test_the_drive_gives_all_energy_and_momentum(element: str, weight: dict[str, float]) -> None:
    p = HUB.replace(drive="torque", **weight)
    scene, (q, v) = element_scene(4, element), bent(element)
    c, torque = scene.coefficients(p), 0.7
    a = np.array(scene.accelerations(torque, q, v, c))
    assert scene.invariants is not None
    gained = {
        name: invariant(q + 1j * TINY * v, v + 1j * TINY * a, c).imag / TINY
        for name, invariant in scene.invariants(p).items()
    }
    assert set(gained) == {"energy"} if weight else {"energy", "momentum"}
    assert gained.get("momentum", torque) == pytest.approx(torque, rel=1e-7)
    assert gained["energy"] == pytest.approx(torque * v[0], rel=1e-6)
    assert scene.powers(torque, q, v, c)["hub"] == pytest.approx(torque * v[0])


def test_a_straight_beam_has_one_weight_in_all_models() -> None:
    p = HUB.replace(drive="torque", **WEIGHED)
    models = [SCENE, *SCENE.variants.values(), *(element_scene(5, name) for name in NODAL)]
    models += [chain_scene(5, scheme) for scheme in "AB"]
    found = []
    for scene in models:
        q, v = np.split(scene.state({"theta": 0.4}), 2)
        assert scene.energy is not None
        found.append(scene.energy(q, v, scene.coefficients(p)))
    assert found == pytest.approx([found[0]] * len(models), rel=1e-12)


@pytest.mark.parametrize(("element", "order"), [("ancf", 4), ("geometrically_exact", 2)])
def test_frequencies_converge_to_those_of_the_beam(element: str, order: int) -> None:
    p = RotatingBeam(angular_speed=steady_speed(4), ramp_time=0.0, mass=1.6, hub_radius=1.0)
    errors = []
    for n in (8, 16):
        scene = element_scene(n, element)
        assert scene.continuum.spectrum is not None
        c, state = scene.coefficients(p), scene.state({"theta_dot": p.angular_speed})
        for _ in range(5):
            mass, damping, stiffness, forces = linearise_at(scene, c, state)
            state[1 : len(forces)] += np.linalg.solve(stiffness[1:, 1:], forces[1:])
        mass, damping, stiffness, forces = linearise_at(scene, c, state)
        assert np.max(np.abs(forces)) < 1e-6
        first = modes(mass, damping, stiffness, [0])[1].omega
        errors.append(first / scene.continuum.spectrum(p, "chordwise", 1)[0][0] - 1)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("element", NODAL)
def test_a_beam_that_starts_turning_under_its_weight_has_no_waves_along_it(element: str) -> None:
    """Unstretched it has 30 m/s^2 along it; the stretch is that of rho A (omega^2 x + g) on E A."""
    scene = element_scene(32, element)
    p = RotatingBeam(hub_radius=0.5, drive="torque", gravity_x=3.0, gravity_y=-9.0)
    values = {"theta": 0.4, "theta_dot": 2.0}
    along = np.array([name.endswith("_x") for name in scene.coordinates])
    rates = []
    for start in (values, scene.embedding(p, values)):
        q, v = np.split(scene.state(start), 2)
        rates.append(np.max(np.abs(scene.accelerations(0.0, q, v, scene.coefficients(p))[along])))
    assert rates[0] > 20
    assert rates[1] < 1e-9
    a, end = p.hub_radius, p.hub_radius + p.length
    pull = 4.0 * (end**3 / 3 - a**3 / 3 - a * (end**2 - a**2) / 2)
    pull += (3.0 * np.cos(0.4) - 9.0 * np.sin(0.4)) * p.length**2 / 2
    stretch = p.density / p.youngs_modulus * pull
    assert scene.embedding(p, values)["node_32_x"] == pytest.approx(stretch, rel=1e-3)
    assert not any(scene.embedding(p.replace(gravity_x=0.0, gravity_y=0.0), {}).values())
