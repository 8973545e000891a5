"""The equations of motion against second formulations, and each of their terms changed in turn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import localcontext
from typing import Any, NamedTuple

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.reference import get_scene
from mbcheck.reference.rotating_beam.chain import chain_scene
from mbcheck.reference.scene import Array, Case, EquationsOfMotion
from mbcheck.tests.support.formulations import scenes
from mbcheck.tests.support.formulations.beam import by_particles
from mbcheck.tests.support.formulations.newton_euler import DIGITS, Mechanism
from mbcheck.tests.support.formulations.terms import FACTORS, evaluate
from mbcheck.tests.support.formulations.witness import (
    Formulation,
    Sample,
    by_newton_and_euler,
    draw,
    numbers_at,
    stated,
    witness,
)

UNITS = 8
"""Units of round-off that are granted, each of which is one ulp of every number added."""

UNITS_OF_MUJOCO = 64
"""Those granted to MuJoCo, whose tree has more additions."""

BEAM = {"segments": 4.0, "drive": "torque"}


class Row(NamedTuple):
    """A scene or variant, its second formulation, the parameters in words, and MuJoCo's model."""

    scene: EquationsOfMotion
    formulation: Formulation
    chosen: Mapping[str, Any] = {}
    model: str = ""


def row(name: str, model: str, **chosen: Any) -> Row:
    """Return the row of a scene of bodies."""
    return Row(get_scene(name), by_newton_and_euler(scenes.BUILDERS[name]), chosen, model)


def chain(scheme: str, **chosen: Any) -> Row:
    """Return the row of a chain."""
    chosen = BEAM | {"scheme": scheme} | chosen
    return Row(chain_scene(4, scheme), by_newton_and_euler(scenes.chain), chosen, "chain")


INEXTENSIBLE = get_scene("rotating_beam")
EXTENSIBLE = INEXTENSIBLE.variants["extensible"]

ROWS = {
    "hula_hoop": row("hula_hoop", "tree"),
    "rotor_pendulum": row("rotor_pendulum", "tree", motor_placement="absolute"),
    "rotor_pendulum, relative": row("rotor_pendulum", "tree", motor_placement="relative"),
    "speed_regulator": row("speed_regulator", "connect"),
    "rigid_body": row("rigid_body", "ball"),
    "ball_hoop": row("ball_hoop", "ball"),
    "floating_platform": row("floating_platform", "free"),
    "floating_beam": row("floating_beam", "free"),
    "chain A": chain("A", mass_position=1.0),
    "chain A, prescribed": chain("A", mass_position=0.6, drive="prescribed"),
    "chain B": chain("B", mass_position=0.1),
    "rotating_beam": Row(INEXTENSIBLE, by_particles, BEAM | {"mass_position": 0.6}),
    "rotating_beam, prescribed": Row(
        INEXTENSIBLE, by_particles, BEAM | {"mass_position": 1.0, "drive": "prescribed"}
    ),
    "extensible": Row(EXTENSIBLE, by_particles, BEAM | {"mass_position": 1.0}),
}


def sample_of(one: Row, count: int, seed: int = 1) -> Sample:
    """Draw points; a continuous beam is bent so far that it does not wind up."""
    sample = draw(one.scene, count, seed, **one.chosen)
    if one.formulation is by_particles:
        for i, name in enumerate(one.scene.coordinates[1:], 1):
            sample.q[i] /= 30 if name.startswith("e_") else 3
            sample.v[i] /= 30 if name.startswith("e_") else 3
    return sample


def functions(scene: EquationsOfMotion, sample: Sample) -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """Return the functions of the reference, with their arguments."""
    c, u = stated(scene, sample)
    q, v = sample.q, sample.v
    return {
        "mass_matrix": (scene.mass_matrix, (q, c)),
        "forces": (scene.forces, (u, q, v, c)),
        "accelerations": (scene.accelerations, (u, q, v, c)),
        "energy": (scene.energy, (q, v, c)),
    } | {
        f"power {key}": (lambda u, q, v, c, key=key: scene.powers(u, q, v, c)[key], (u, q, v, c))
        for key in scene.powers(u, q, v, c)
    }


def full(values: Any, like: Array) -> Array:
    """Return nested lists of arrays over points as one array."""
    if isinstance(values, list):
        return np.array([full(one, like[0]) for one in values])
    return np.broadcast_to(values, like.shape)


def assert_agreement(one: Row, count: int) -> None:
    sample = sample_of(one, count)
    known = witness(one.scene, sample, one.formulation)
    found = functions(one.scene, sample)
    assert {*known} <= {*found}
    for name, (value, error) in known.items():
        function, arguments = found[name]
        off = np.abs(full(function(*arguments), value) - value)
        assert np.all(off <= UNITS * error), (name, np.max(off / (error + (off == 0))))


@pytest.mark.parametrize("name", ROWS)
def test_both_formulations_agree_to_round_off(name: str) -> None:
    assert_agreement(ROWS[name], 50 if ROWS[name].formulation is not by_particles else 8)


@pytest.mark.slow
@pytest.mark.parametrize("name", ROWS)
def test_both_formulations_agree_at_many_points(name: str) -> None:
    assert_agreement(ROWS[name], 1000 if ROWS[name].formulation is not by_particles else 100)
