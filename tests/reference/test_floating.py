"""What floating_platform and floating_beam conserve, and where they rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.reference import floating_beam, floating_platform, get_scene
from mbcheck.reference.body.floating_scene import LINEAR
from mbcheck.reference.body.rotation import MOMENTUM
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.floating_platform import FloatingPlatform
from mbcheck.reference.orbits import find_orbit
from mbcheck.reference.solve.single import solve

PLATFORM, BEAM = get_scene("floating_platform"), get_scene("floating_beam")
WEIGHED = {"gravity_x": 3.0, "gravity_y": -5.0, "gravity_z": -7.0}
STARTS = {"floating_platform": floating_platform.TUMBLING, "floating_beam": floating_beam.TUMBLING}
FALLING = {"floating_platform": {"falling"}, "floating_beam": {"tumbling", "falling"}}


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(
            case,
            marks=[pytest.mark.slow] * (scene is BEAM and case.name != "tumbling"),
            id=f"{scene.name}-{case.name}",
        )
        for scene in (PLATFORM, BEAM)
        for case in scene.cases
    ],
)
def test_momenta_are_conserved_to_rounding(case: Any) -> None:
    scene, p = get_scene(case.scene), case.parameters
    known, c = scene.invariants(p), scene.coefficients(p)  # type: ignore[misc]
    linear = set() if case.name in FALLING[case.scene] else set(LINEAR)
    energy = {"energy"} if case.name in ("conservative", "falling") else set()
    assert set(known) == {*MOMENTUM, *linear, *energy}
    times, room = ((0.25, 2e-13), (0.0625, 1e-12))[scene is BEAM]
    states = solve(scene, p, scene.state(STARTS[case.scene]), np.linspace(0, times, 5)[1:]).states
    q, v = np.split(states, 2)
    series = {name: invariant(q, v, c) for name, invariant in known.items()}
    for name, values in series.items():
        family = [one for other, one in series.items() if other[:-1] == name[:-1]]
        assert np.ptp(values) < room * np.max(np.abs(family)), name
        assert np.max(np.abs(values)) > 1e-2 * np.max(np.abs(family))


@pytest.mark.parametrize("scene", [PLATFORM, BEAM], ids=lambda scene: scene.name)
def test_it_rests_anywhere_unless_it_falls_and_has_no_orbit(scene: Any) -> None:
    p = scene.unforced(scene.parameters())
    state = scene.state(scene.equilibria["afloat"](p))
    assert not np.any(scene.right_hand_side(p)(0.0, state))
    with pytest.raises(NoOrbitError, match="falls"):
        scene.equilibria["afloat"](p.replace(**WEIGHED))
    with pytest.raises(NoOrbitError):
        find_orbit(scene, p)


def test_heavy_arms_keep_their_digits() -> None:
    p = FloatingPlatform(mass=1e-2, rotor_mass=10.0, rod_mass=30.0, **WEIGHED)
    c, (q, v) = PLATFORM.coefficients(p), np.random.default_rng(20).normal(size=(2, 9))
    right = np.linalg.solve(np.array(PLATFORM.mass_matrix(q, c)), PLATFORM.forces(0.0, q, v, c))
    assert PLATFORM.accelerations(0.0, q, v, c) == pytest.approx(right, rel=1e-8)
