"""The rigid body with a mistake that engines have been seen to make, by the words for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..quaternions import conjugate, cross, matrix, product, square
from ..scene import Scene
from .equations import (
    COORDINATES,
    QUATERNION,
    RATES,
    ROTATION,
    Coefficients,
    RigidBody,
    central_inertia,
    coefficients_of,
    inertia,
    moving,
    times,
    torque,
)

Moment = Callable[[Any, list[Any], list[Any], Coefficients], list[Any]]
"""From q, omega, J omega to what the angular velocity changes by: J omega'."""


def sum_of(a: Any, b: Any, factor: float = 1.0) -> list[Any]:
    """Return a + factor b."""
    return [x + factor * y for x, y in zip(a, b, strict=True)]


def without_gyroscopic(q: Any, omega: Any, momentum: Any, c: Coefficients) -> list[Any]:
    """Return the torque alone."""
    return torque(q, c)


def reversed_gyroscopic(q: Any, omega: Any, momentum: Any, c: Coefficients) -> list[Any]:
    """Return torque and gyroscopic term with its sign reversed."""
    return sum_of(torque(q, c), cross(omega, momentum))


def standing_tensor(q: Any, omega: Any, momentum: Any, c: Coefficients) -> list[Any]:
    """Return J omega' of a tensor that stands still in the world: R^T J^-1 R s x R^T g, times J."""
    rows, pull = matrix(q), torque(q, c)
    outside = [sum(row[i] * pull[i] for i in range(3)) for row in rows]
    faster = times(c[9:15], outside)
    return times(c[3:9], [sum(rows[j][i] * faster[j] for j in range(3)) for i in range(3)])


def gravity_of_body(q: Any, omega: Any, momentum: Any, c: Coefficients) -> list[Any]:
    """Return torque and gyroscopic term of a gravity that turns with the body."""
    return sum_of(cross(c[0:3], c[15:18]), cross(omega, momentum), -1.0)


def gravity_reversed(q: Any, omega: Any, momentum: Any, c: Coefficients) -> list[Any]:
    """Return torque and gyroscopic term of the opposite gravity."""
    return sum_of([-part for part in torque(q, c)], cross(omega, momentum), -1.0)


def accelerations_by(moment: Moment) -> Callable[..., list[Any]]:
    """Return the second derivatives of q by another J omega'."""

    def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
        rho, omega, momentum, _ = moving(q, v, c)
        faster = times(c[9:15], moment(q, omega, momentum, c))
        along = rho * rho - (omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2]) / 4
        return product(q, [along, *(rho * a + b / 2 for a, b in zip(omega, faster, strict=True))])

    return accelerations


def without_products(p: RigidBody) -> Coefficients:
    """Return the coefficients of a body whose central products of inertia are 0."""
    whole, central = inertia(p), central_inertia(p)
    off = central * (1 - np.eye(3)).reshape(3, 3, *(1,) * (central.ndim - 2))
    return coefficients_of(p, whole - off)


MOMENTS: Mapping[str, Moment] = {
    "the gyroscopic term omega x (J omega) is lost": without_gyroscopic,
    "the gyroscopic term omega x (J omega) has the wrong sign": reversed_gyroscopic,
    "the inertia tensor does not turn with the body": standing_tensor,
    "gravity turns with the body": gravity_of_body,
    "gravity has the wrong sign": gravity_reversed,
}

# Rates of the world's frame: other coordinates, whose rates are another thing

OTHERS = ("p_w", "p_x", "p_y", "p_z")


def spun_outside(p: RigidBody, state: Mapping[str, float]) -> dict[str, float]:
    """Return the state whose angular velocity in the world is that in the body's frame."""
    q = [state[name] for name in COORDINATES]
    v = [state[f"{name}_dot"] for name in COORDINATES]
    half = product(conjugate(q), v)
    rates = product([part / square(q) for part in half], q)
    return dict(zip((*OTHERS, *(f"{name}_dot" for name in OTHERS)), [*q, *rates], strict=True))


def outside(q: Any, v: Any) -> tuple[Any, list[Any]]:
    """Return rho and the angular velocity in the world."""
    half = [part / square(q) for part in product(v, conjugate(q))]
    return half[0], [2 * part for part in half[1:]]


def turned_outside(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Return q'' where q' = (0, omega) q / 2, and omega obeys (1) as if it were the body's."""
    rho, omega = outside(q, v)
    momentum = times(c[3:9], omega)
    faster = times(c[9:15], sum_of(torque(q, c), cross(omega, momentum), -1.0))
    along = rho * rho - (omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2]) / 4
    return product([along, *(rho * a + b / 2 for a, b in zip(omega, faster, strict=True))], q)


def moves_outside(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Return q'' by (1), (2): the motion is right, its angular velocity is told in the world."""
    return accelerations_by(
        lambda q, omega, momentum, c: sum_of(torque(q, c), cross(omega, momentum), -1.0)
    )(u, q, v, c, xp)


def told_outside(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
    """Return attitude, and the angular velocity in the world in place of that in the body."""
    _, omega = outside(q, v)
    rotation = dict(zip(ROTATION, (entry for row in matrix(q) for entry in row), strict=True))
    return rotation | dict(zip(RATES, omega, strict=True))


def with_mistakes(scene: Scene) -> Mapping[str, Any]:
    """Return the scene with each mistake."""
    units = dict(scene.units) | {
        f"{name}{dot}": f"1{'/s' if dot else ''}" for name in OTHERS for dot in ("", "_dot")
    }
    world = replace(
        scene,
        coordinates=OTHERS,
        quaternions=(),
        units=units,
        embedding=spun_outside,
        outputs=told_outside,
        cases=(),
    )
    return {
        **{
            words: replace(scene, accelerations=accelerations_by(moment), cases=())
            for words, moment in MOMENTS.items()
        },
        "products of inertia are dropped": replace(scene, coefficients=without_products, cases=()),
        f"the quaternion {QUATERNION.name} is turned by rates of the world's frame": replace(
            world, accelerations=turned_outside
        ),
        "rates are those of the world's frame": replace(world, accelerations=moves_outside),
    }
