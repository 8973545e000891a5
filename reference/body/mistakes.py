"""A body that turns with a mistake that engines have been seen to make, by the words for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..quaternions import conjugate, cross, matrix, product, square
from ..scene import Array, Scene
from .rotation import (
    AXES,
    COORDINATES,
    QUATERNION,
    RATES,
    ROTATION,
    BodyAccelerations,
    Moment,
    accelerations_by,
    inner,
    into_body,
    sum_of,
    times,
    torque,
    without_products,
    world_rates,
)


def without_gyroscopic(q: Any, omega: Any, momentum: Any, c: Any) -> list[Any]:
    """Return the torque alone."""
    return torque(q, c)


def reversed_gyroscopic(q: Any, omega: Any, momentum: Any, c: Any) -> list[Any]:
    """Return torque and gyroscopic term with its sign reversed."""
    return sum_of(torque(q, c), cross(omega, momentum))


def standing_tensor(q: Any, omega: Any, momentum: Any, c: Any) -> list[Any]:
    """Return J omega' of a tensor that stands still in the world: R^T J^-1 R s x R^T g, times J."""
    outside = [inner(row, torque(q, c)) for row in matrix(q)]
    return times(c[3:9], into_body(q, times(c[9:15], outside)))


def gravity_of_body(q: Any, omega: Any, momentum: Any, c: Any) -> list[Any]:
    """Return torque and gyroscopic term of a gravity that turns with the body."""
    return sum_of(cross(c[0:3], c[15:18]), cross(omega, momentum), -1.0)


MOMENTS: Mapping[str, Moment] = {
    "the gyroscopic term omega x (J omega) is lost": without_gyroscopic,
    "the gyroscopic term omega x (J omega) has the wrong sign": reversed_gyroscopic,
    "the inertia tensor does not turn with the body": standing_tensor,
    "gravity turns with the body": gravity_of_body,
}

# Rates of the world's frame: other coordinates, whose rates are another thing

OTHERS = ("p_w", "p_x", "p_y", "p_z")


def spun_outside(p: Any, state: Mapping[str, float]) -> dict[str, float]:
    """Return the state whose angular velocity in the world is that in the body's frame."""
    names = (*COORDINATES, *(f"{name}_dot" for name in COORDINATES))
    q, v = [state[name] for name in names[:4]], [state[name] for name in names[4:]]
    half = product(conjugate(q), v)
    rates = product([part / square(q) for part in half], q)
    renamed = zip((*OTHERS, *(f"{name}_dot" for name in OTHERS)), [*q, *rates], strict=True)
    return {name: value for name, value in state.items() if name not in names} | dict(renamed)


def told_outside(q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
    """Return attitude, and the angular velocity in the world in place of that in the body."""
    _, omega = world_rates(q[-4:], v[-4:])
    rotation = dict(zip(ROTATION, (e for row in matrix(q[-4:]) for e in row), strict=True))
    return rotation | dict(zip(RATES, omega, strict=True))


def with_mistakes(
    scene: Scene,
    accelerate: BodyAccelerations,
    coefficients_of: Callable[[Any, Array], Any],
) -> dict[str, Any]:
    """Return a scene with each mistake.

    Parameters
    ----------
    scene : Scene
    accelerate : BodyAccelerations
        What its accelerations come of.
    coefficients_of : callable ``(parameters, inertia tensor) -> c``
    """

    def dropped(p: Any) -> Any:
        """Return the coefficients of a body whose central products of inertia are 0."""
        return coefficients_of(p, without_products(p))

    def reversed_gravity(p: Any) -> Any:
        """Return the coefficients of the opposite gravity."""
        opposite = {f"gravity_{axis}": -getattr(p, f"gravity_{axis}") for axis in AXES}
        return scene.coefficients(p.replace(**opposite))

    first = len(scene.coordinates) - 4
    units = dict(scene.units) | {
        f"{name}{dot}": f"1{'/s' if dot else ''}" for name in OTHERS for dot in ("", "_dot")
    }
    world = replace(
        scene,
        coordinates=(*scene.coordinates[:first], *OTHERS),
        quaternions=(),
        units=units,
        embedding=spun_outside,
        outputs=told_outside,
        cases=(),
    )
    return {
        **{
            words: replace(
                scene, accelerations=accelerations_by(accelerate, first, moment), cases=()
            )
            for words, moment in MOMENTS.items()
        },
        "gravity has the wrong sign": replace(scene, coefficients=reversed_gravity, cases=()),
        "products of inertia are dropped": replace(scene, coefficients=dropped, cases=()),
        f"the quaternion {QUATERNION.name} is turned by rates of the world's frame": replace(
            world, accelerations=accelerations_by(accelerate, first, outside=True)
        ),
        "rates are those of the world's frame": replace(
            world, accelerations=accelerations_by(accelerate, first)
        ),
        "rates are those of the world's frame, in its results": replace(
            scene, outputs=told_outside, cases=()
        ),
    }
