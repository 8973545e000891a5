"""Mistakes in what couples a slide and a ball joint, by the words for them."""

from __future__ import annotations

from typing import Any

from ..body.rotation import BodyAccelerations, Moment, inner, sum_of, times
from ..quaternions import cross
from .equations import TURN, braked_by, centripetal, joined, slide_axis, slide_force


def coupled_by(axis_in_body: bool, inertia: float, pull: float, transport: float) -> Any:
    """Return `body_accelerations` with the factors 1, 1 and 0 changed, or another axis."""

    def accelerate(u: Any, motion: Any, c: Any, moment: Moment, xp: Any) -> list[Any]:
        q, v, omega = motion
        axis = [0.0, 1.0, 0.0] if axis_in_body else slide_axis(q)
        push = slide_force(u, q, v, c) - pull * inner(axis, centripetal(omega, c))
        lever = [inertia * part for part in cross(c[0:3], axis)]
        turning = braked_by(moment)(q[TURN], omega, times(c[3:9], omega), c)
        convected = cross(axis, cross(omega, c[0:3]))
        return joined(push, lever, sum_of(turning, convected, transport * v[0]), c)

    return accelerate


COUPLINGS: dict[str, BodyAccelerations] = {
    "the inertia that couples slide and ball joint is lost": coupled_by(False, 0.0, 1.0, 0.0),
    "the turning body does not pull at the slide": coupled_by(False, 1.0, 0.0, 0.0),
    "the slide's direction is taken in the frame of the body": coupled_by(True, 1.0, 1.0, 0.0),
    "the moment about the moving joint lacks v x p": coupled_by(False, 1.0, 1.0, 1.0),
}
