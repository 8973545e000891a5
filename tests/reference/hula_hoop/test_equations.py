"""Linear response, modes, rest and schemes of hula_hoop."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.errors import NoOrbitError, ParameterError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.hula_hoop.theory import nondimensional
from mbcheck.reference.linear import linearise, modes

SCENE = get_scene("hula_hoop")


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
