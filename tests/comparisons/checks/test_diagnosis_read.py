"""What readers of MJCF add to a model or lose of it is named where nothing else explains it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.reports.run.located import located
from mbcheck.models.mechanism import Body, Joint, Term
from mbcheck.tests.support.engines.reading import Reader, Unweighed
from mbcheck.tests.support.example import results

HOOP = "point_mass_3hz_60n"


def terms(change: Callable[[Term], Term | None]) -> Callable[[Any], Any]:
    """Return what changes, or drops, terms of a system."""
    return lambda system: replace(
        system, terms=tuple(one for one in map(change, system.terms) if one)
    )


def bodies(change: Callable[[Body], Body]) -> Callable[[Any], Any]:
    """Return what changes bodies of a mechanism."""
    return lambda whole: replace(whole, bodies=tuple(map(change, whole.bodies)))


def joints(change: Callable[[Joint], Joint]) -> Callable[[Any], Any]:
    """Return what changes joints of a mechanism."""
    return lambda whole: replace(whole, joints=tuple(map(change, whole.joints)))


def without(kinds: tuple[str, ...], **numbers: Any) -> Callable[[Any], Any]:
    """Return what gives terms of some kinds other numbers, or drops them."""
    return terms(
        lambda one: one if one.kind not in kinds else replace(one, **numbers) if numbers else None
    )


def about_origin(body: Body) -> Body:
    """Return a body whose tensor is taken for that about its origin."""
    own = body.centre
    moved = body.mass * (own @ own * np.eye(3) - np.outer(own, own))
    return replace(body, inertia=body.inertia - moved)


def unrotated(body: Body) -> Body:
    """Return a body whose principal axes are taken for those of its frame."""
    return replace(body, inertia=np.diag(np.linalg.eigvalsh(body.inertia)))


def exchanged(body: Body) -> Body:
    """Return a body whose products of inertia are read in another order."""
    (xx, xy, xz), (_, yy, yz), (*_, zz) = body.inertia
    return replace(body, inertia=np.array([[xx, yz, xy], [yz, yy, xz], [xy, xz, zz]]))


def second(force: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    """Return a force on the second joint alone."""
    return lambda time, q, v: force(q, v) * (np.arange(len(v)) == 1)


NOT_IN_FILE = "which the file does not have"
SPRINGS = ("spring", "tendon_spring")
READERS: dict[str, tuple[Reader, str, list[str]]] = {
    "right": (Reader(), "speed_regulator", []),
    "right in space": (Reader(), "rigid_body", []),
    "springref": (
        Reader(system=without(SPRINGS, constant=0.0)),
        "speed_regulator",
        ["rest length of spring of y: dropped"],
    ),
    "another rest length": (
        Reader(
            system=terms(
                lambda one: (
                    replace(one, constant=-0.06 * one.per_length) if one.name == "foot" else one
                )
            )
        ),
        "hula_hoop",
        ["rest length of spring of foot is 0.06, where the file has 0"],
    ),
    "armature": (
        Reader(joints(lambda one: replace(one, armature=one.armature + 1.0))),
        "hula_hoop",
        [f"an armature of 1 (SI units) on every joint, {NOT_IN_FILE}"],
    ),
    "damper": (
        Reader(push=lambda time, q, v: -0.3 * v),
        "speed_regulator",
        [f"a damper of 0.3 (SI units) on every joint, {NOT_IN_FILE}"],
    ),
    "damper of a ball": (
        Reader(push=lambda time, q, v: -0.3 * v),
        "rigid_body",
        [f"a damper of 0.3 N m s/rad on q, {NOT_IN_FILE}"],
    ),
    "dry friction": (
        Reader(push=second(lambda q, v: -0.3 * np.sign(v))),
        "rotor_pendulum",
        [f"dry friction of 0.3 N m on phi_1, {NOT_IN_FILE}"],
    ),
    "ref": (
        Reader(joints(lambda one: replace(one, ref=0.0))),
        "speed_regulator",
        ["ref of joints is ignored"],
    ),
    "floor of inertia": (
        Reader(bodies(lambda one: replace(one, inertia=np.maximum(one.inertia, 1e-6 * np.eye(3))))),
        "hula_hoop",
        [
            "inertia of rod is 1e-06 kg m^2, where the file has 2e-15, "
            f"or an armature of 1e-06 kg m^2 on theta, {NOT_IN_FILE}"
        ],
    ),
    "constant part of motors": (
        Reader(system=without(("actuator",), constant=0.0)),
        "rotor_pendulum",
        [
            "constant part of actuator of motor_1: dropped; "
            "constant part of actuator of motor_2: dropped"
        ],
    ),
    "rate gain of motors": (
        Reader(system=without(("actuator",), per_rate=0.0)),
        "rotor_pendulum",
        ["rate gain of actuator of motor_1: dropped; rate gain of actuator of motor_2: dropped"],
    ),
    "no springs, more armature": (
        Reader(joints(lambda one: replace(one, armature=one.armature + 0.1)), without(SPRINGS)),
        "rotor_pendulum",
        [
            f"an armature of 0.1 (SI units) on every joint, {NOT_IN_FILE}",
            "spring of x: dropped",
            "spring of phi_3: dropped",
        ],
    ),
    "a mass by 1e-6": (
        Reader(bodies(lambda one: replace(one, mass=(1 + 1e-6 * (one.name == "rod")) * one.mass))),
        "rotor_pendulum",
        ["mass of rod: counted 1.000001 times"],
    ),
    "a force that is no part, beside a damper": (
        Reader(
            push=second(lambda q, v: -300 * q**3),
            system=terms(
                lambda one: (
                    replace(one, per_rate=0.99 * one.per_rate) if one.name == "theta" else one
                )
            ),
        ),
        "hula_hoop",
        [
            "damper of theta: counted 0.99 times",
            "the force on y is not the sum of its parts in any shares",
        ],
    ),
    "tensor not rotated": (
        Reader(bodies(unrotated)),
        "rigid_body",
        ["inertia tensor of body: the orientation of its principal axes is ignored"],
    ),
    "tensor not rotated, and no mass matrix": (
        Unweighed(bodies(unrotated)),
        "rigid_body",
        ["inertia tensor of body: the orientation of its principal axes is ignored"],
    ),
    "products exchanged": (
        Reader(bodies(exchanged)),
        "rigid_body",
        ["inertia tensor of body: its entries are exchanged"],
    ),
    "tensors about other points": (
        Reader(bodies(about_origin)),
        "floating_platform",
        [
            "; ".join(
                f"inertia tensor of {name} is about its origin, not its centre of mass"
                for name in ("body", "rotor", "rod")
            )
        ],
    ),
}
"""Engine, scene, and what is said of it."""


@pytest.mark.parametrize("name", READERS)
def test_what_a_reader_makes_of_a_file_is_named(name: str) -> None:
    engine, scene, said = READERS[name]
    found = results(engine, scene, ("parts",), HOOP if scene == "hula_hoop" else None, False)
    lines = [line for line in located(found)[1:] if "closure of" not in line]
    assert lines == [f"  {one} ({scene})" for one in said]
    shares = [one.value or 0.0 for one in found if one.verdict == "pass" and one.reference == 1.0]
    assert shares
    np.testing.assert_allclose(shares, 1.0, atol=1e-12)


def test_a_tensor_about_another_point_is_the_same_as_no_mass_in_a_mass_matrix() -> None:
    found = located(results(Reader(bodies(about_origin)), "rigid_body", ("parts",), explain=False))
    assert found[1].startswith("  mass of body: dropped, or inertia tensor of body is about")
