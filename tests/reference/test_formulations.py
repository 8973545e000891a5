"""The equations of motion against second formulations, and each of their terms changed in turn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from decimal import localcontext
from itertools import combinations_with_replacement
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
    outputs = one.scene.outputs(sample.q, sample.v, stated(one.scene, sample)[0])
    for name, (value, error) in known.items():
        if name in found:
            function, arguments = found[name]
            outputs[name] = function(*arguments)
        off = np.abs(full(outputs[name], value) - value)
        assert np.all(off <= UNITS * error), (name, np.max(off / (error + (off == 0))))


FEWER = {
    "chain A": 20,
    "chain A, prescribed": 20,
    "chain B": 20,
    "rotating_beam": 8,
    "extensible": 10,
}
"""Points of rows whose scene has another row with 50."""


@pytest.mark.parametrize("name", ROWS)
def test_both_formulations_agree_to_round_off(name: str) -> None:
    assert_agreement(ROWS[name], FEWER.get(name, 50))


@pytest.mark.campaign
@pytest.mark.parametrize("name", ROWS)
def test_both_formulations_agree_at_many_points(name: str) -> None:
    assert_agreement(ROWS[name], 20 * FEWER.get(name, 50))


@pytest.mark.parametrize("name", ROWS)
def test_power_is_the_rate_of_energy(name: str) -> None:
    scene, sample = ROWS[name].scene, sample_of(ROWS[name], 20)
    (c, u), (q, v), h = stated(scene, sample), (sample.q, sample.v), 1e-30
    a, forces = (np.array(f(u, q, v, c)) for f in (scene.accelerations, scene.forces))
    rate = scene.energy(q + 1j * h * v, v + 1j * h * a, c).imag / h
    powers = scene.powers(u, q, v, c).values()
    size = np.sum(np.abs(v * forces), axis=0) + sum(map(abs, powers)) + np.abs(rate)
    assert np.all(np.abs(rate - sum(powers)) < 1e-10 * size)


DAMPERS = {
    "hula_hoop": ("damper", "hinge"),
    "rotor_pendulum": ("platform", "rod"),
    "floating_platform": ("damper",),
    "floating_beam": ("dampers",),
}
"""Powers of joint damping, where its matrix does not depend on the state."""


@pytest.mark.parametrize("name", DAMPERS)
def test_the_damping_matrix_takes_the_power_of_the_dampers(name: str) -> None:
    scene, sample = ROWS[name].scene, sample_of(ROWS[name], 20)
    known = witness(scene, sample, ROWS[name].formulation)
    taken = -np.sum([known[f"power {damper}"].value for damper in DAMPERS[name]], axis=0)
    for k, v in enumerate(sample.v.T):
        matrix = scene.damping_matrix(scene.coefficients(sample.parameters.at(k)))
        assert v @ matrix @ v == pytest.approx(taken[k], rel=1e-13)


# Each term changed in turn ------------------------------------------------------------------------

HALF = 6
"""Points of any length of the quaternions, and as many of the length 1 that MuJoCo takes."""


def with_unit_quaternions(scene: EquationsOfMotion, sample: Sample) -> Sample:
    """Return a sample whose last points have quaternions of the length 1, which they keep."""
    states = np.concatenate([sample.q, sample.v])
    states[:, HALF:] = scene.on_unit_quaternions(states[:, HALF:].T).T
    q, v = np.split(states, 2)
    return Sample(sample.parameters, q, v, sample.times)


def by_mujoco(one: Row, sample: Sample, known: Array, first: int) -> Array:
    """Return accelerations (n, k) of the model in MuJoCo from some point on."""
    engine, columns = get_engine("mujoco"), []
    for k in range(first, len(sample.times)):
        case = Case(one.scene.name, "drawn", sample.parameters.at(k))
        state = np.concatenate([sample.q[:, k], sample.v[:, k]])[None]
        if one.model == "connect":
            columns.append(on_the_loop(engine, case, sample, k, known[:, k]))
        else:
            time = sample.times[k : k + 1]
            columns.append(engine.bind(case, one.model).accelerations(time, state)[0])
    return np.array(columns).T


def on_the_loop(engine: Any, case: Case, sample: Sample, k: int, known: Array) -> Array:
    """Return the acceleration (1,) of the regulator's crank by MuJoCo's tree.

    Along the motion that keeps the loop closed the forces of its closure do no work: what the tree
    takes for known accelerations corrects these.
    """
    with localcontext(prec=DIGITS):
        p, q, v, t = numbers_at(sample, k)
        m = Mechanism({"phi": q[0]}, {"phi": v[0]})
        scenes.speed_regulator(m, p, t)
        read, _, _ = m.move()
    state = np.concatenate([sample.q[:, k], sample.v[:, k]])[None]
    bound = engine.bind(case, "connect")
    system, (place, rate) = bound.origin, bound.joint_states(sample.times[k : k + 1], state)
    moving = {"phi": read["phi"], "pin_angle": read["rod"], "y": read["y"]}
    moving_all = np.array([float(moving[name]) for name in system.joints])
    tangent = rate[0] / sample.v[0, k]
    force = engine.inner.inverse_dynamics(system, 0.0, place[0], rate[0], moving_all)
    inertia = tangent @ engine.inner.mass_matrix(system, place[0]) @ tangent
    return known - tangent @ force / inertia


def accelerations_of(name: str, values: Array, others: Mapping[str, Array]) -> Array:
    """Return the accelerations that changed values of a function lead to; none of an energy."""
    if name not in ("mass_matrix", "forces"):
        return values if name == "accelerations" else np.empty((0, values.shape[-1]))
    both = {**others, name: values}
    columns = np.moveaxis(both["forces"], -1, 0)[..., None]
    try:
        return np.linalg.solve(np.moveaxis(both["mass_matrix"], -1, 0), columns)[..., 0].T
    except np.linalg.LinAlgError:
        return np.full_like(both["forces"], np.nan)


LARGE = {"rigid_body": 5, "ball_hoop": 9, "floating_platform": 40, "floating_beam": 120}
"""Scenes with hundreds of terms, of which one in so many is changed."""


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("name", list(ROWS)[:8])
def test_each_term_is_caught_by_both_formulation_and_mujoco(name: str) -> None:
    """MuJoCo sees what changes accelerations; energy and powers are seen by the formulation."""
    one, step = ROWS[name], LARGE.get(name, 1)
    sample = with_unit_quaternions(one.scene, sample_of(one, 2 * HALF))
    known = witness(one.scene, sample, one.formulation)
    a, error = (x[:, HALF:] for x in known["accelerations"])
    mujoco = by_mujoco(one, sample, known["accelerations"].value, HALF)
    assert np.all(np.abs(mujoco - a) <= UNITS_OF_MUJOCO * error)
    values = {x: known[x].value for x in ("mass_matrix", "forces")}
    for part, (function, arguments) in functions(one.scene, sample).items():
        value, room = known[part]
        right, count = evaluate(function, arguments)
        total = {}
        for word, factor in FACTORS.items():
            seen = seen_by_mujoco = 0
            for number in range(1, count + 1, step):
                wrong = evaluate(function, arguments, number, factor)[0]
                if np.all(np.abs(wrong - right) <= room):
                    continue  # what it is added to is not used, or cancels
                assert not np.all(np.abs(wrong - value) <= UNITS * room), (part, number, word)
                moved = accelerations_of(part, wrong, values)[:, HALF:]
                if moved.size and not np.all(np.abs(moved - a) <= UNITS * error):
                    off = np.abs(moved - mujoco) <= UNITS_OF_MUJOCO * error
                    assert not np.all(off), (part, number, word)
                    seen_by_mujoco += 1
                seen += 1
            print(f"{name:24} {part:16} {word:12} {count:5} {seen:5} {seen_by_mujoco:5}")
            total[word] = seen
        assert total["dropped"] == total["off by 1e-6"]  # none is too small to be seen


COEFFICIENTS = {"hub_ratio", "hub", "beam", "point", "bending", "gravity_x", "gravity_y"}
"""Those of all beams that are factors of terms; others are units, choices, and the drive's."""


def changed_blocks(one: Row, sample: Sample, factor: float) -> Iterator[tuple[str, Any, Any]]:
    """Yield names, mass matrices and forces of a beam with one term changed, if that changes them.

    Terms are the blocks of the mass matrix, the products of rates of the hub, of angles and of
    stretches, and what goes with each coefficient.
    """
    scene, (c, u) = one.scene, stated(one.scene, sample)
    names, q, v = scene.coordinates, sample.q, sample.v
    kinds = {"hub": ("theta",), "angles": ("b_", "joint_"), "stretches": ("e_",)}
    places = {kind: [x.startswith(start) for x in names] for kind, start in kinds.items()}
    groups = {kind: np.array(here)[:, None] for kind, here in places.items() if any(here)}
    mass, force = np.array(scene.mass_matrix(q, c)), np.array(scene.forces(u, q, v, c))

    def inertial(*moving: Any) -> Any:
        rates = v * np.any(moving, axis=0)
        return np.array(scene.forces(u, q, rates, c)) - scene.forces(u, q, 0 * v, c)

    for (a, one_kind), (b, other) in combinations_with_replacement(groups.items(), 2):
        block = (one_kind & other.T) | (other & one_kind.T)
        yield f"inertia of {a}, {b}", np.where(block[..., None], factor * mass, mass), force
        term = inertial(one_kind) if a == b else inertial(one_kind, other)
        term = term if a == b else term - inertial(one_kind) - inertial(other)
        if (a, b) != ("stretches", "stretches"):  # they have no such term
            yield f"rates of {a}, {b}", mass, force + (factor - 1) * term
    yield "drive", mass, np.array(scene.forces(factor * u, q, v, c))
    for field in COEFFICIENTS | ({"axial"} if "stretches" in groups else set()):
        value = getattr(c, field)
        wrong = c._replace(**{field: factor * value})
        yield field, np.array(scene.mass_matrix(q, wrong)), np.array(scene.forces(u, q, v, wrong))


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("name", ["rotating_beam", "extensible", "chain A", "chain B"])
def test_each_term_of_a_beam_is_caught(name: str) -> None:
    one = ROWS[name]
    sample = sample_of(one, HALF)
    known = witness(one.scene, sample, one.formulation)
    a, error = known["accelerations"]
    room = UNITS_OF_MUJOCO * error
    if one.model:
        mujoco = by_mujoco(one, sample, a, 0)
        assert np.all(np.abs(mujoco - a) <= room)
    for word, factor in FACTORS.items():
        for term, mass, force in changed_blocks(one, sample, factor):
            parts = [(mass, known["mass_matrix"]), (force, known["forces"])]
            off = [np.abs(x - y.value) <= UNITS * y.error for x, y in parts]
            assert not all(map(np.all, off)), (term, word)
            if one.model:
                moved = accelerations_of("forces", force, {"mass_matrix": mass})
                assert not np.all(np.abs(moved - mujoco) <= room), (term, word)
