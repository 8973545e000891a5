"""What ball_hoop conserves, and where it rests."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.ball_hoop import BallHoop
from mbcheck.reference.body.rotation import body_inertia
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.orbits import find_orbit
from mbcheck.reference.solve.single import solve

SCENE = get_scene("ball_hoop")
GENERAL = BallHoop(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
STATES = np.random.default_rng(20).normal(size=(4, 2, 5))
START = {"y": 0.02, "y_dot": -0.3, "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1,
         "omega_x": 5.0, "omega_y": -4.0, "omega_z": 8.0}  # fmt: skip


@pytest.mark.parametrize("case", SCENE.cases, ids=lambda case: case.name)
def test_what_it_conserves(case: Any) -> None:
    p, c = case.parameters, SCENE.coefficients(case.parameters)
    known = SCENE.invariants(p)  # type: ignore[misc]
    assert set(known) == {
        "driven": {"momentum"}, "weighed": set(), "conservative": {"energy"}, "hanging": set(),
        "gravity_along": {"energy", "momentum"}, "planar": set(),
    }[case.name]  # fmt: skip
    states = solve(SCENE, p, SCENE.state(START), np.linspace(0, 0.5, 5)[1:]).states
    for name, invariant in known.items():
        values = invariant(states[:5], states[5:], c)
        assert np.ptp(values) < 1e-11 * np.max(np.abs(values)), name


@pytest.mark.parametrize("name", ["hanging", "inverted", "weightless"])
def test_at_rest_nothing_accelerates(name: str) -> None:
    p, other = (GENERAL, BallHoop()) if name != "weightless" else (BallHoop(), GENERAL)
    p = p.replace(force_amplitude=0.0)
    state = SCENE.state(SCENE.equilibria[name](p))
    assert np.max(np.abs(SCENE.right_hand_side(p)(0.0, state))) < 1e-11
    with pytest.raises(NoOrbitError):
        SCENE.equilibria[name](other)


def test_a_body_on_its_centre_of_mass_hangs_in_any_attitude() -> None:
    p = BallHoop(centre_x=0.0, centre_y=0.0, centre_z=0.0, gravity_y=-9.81, force_amplitude=0.0)
    state = SCENE.state(SCENE.equilibria["weightless"](p))
    assert np.max(np.abs(SCENE.right_hand_side(p)(0.0, state))) < 1e-11
    with pytest.raises(NoOrbitError, match="ask for weightless"):
        SCENE.equilibria["hanging"](p)


def test_it_is_not_said_that_nothing_drives_it() -> None:
    with pytest.raises(NoOrbitError, match="none is sought of this scene"):
        find_orbit(SCENE, BallHoop())


def test_a_light_slide_keeps_its_digits() -> None:
    """The body's share of the slide's inertia comes of a difference of about equal numbers."""
    p = GENERAL.replace(main_mass=1e-3, mass=10.0)
    c, (q, v) = SCENE.coefficients(p), STATES[1]
    right = np.linalg.solve(np.array(SCENE.mass_matrix(q, c)), SCENE.forces(0.0, q, v, c))
    assert SCENE.accelerations(0.0, q, v, c) == pytest.approx(right, rel=1e-8)
    assert np.linalg.cond(body_inertia(p)) < 100
