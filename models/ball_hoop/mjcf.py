"""ball_hoop as MJCF: which parameter goes where, and how its clock starts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ...reference.ball_hoop import BallHoop, coefficients
from ...reference.body.rotation import QUATERNION
from ..body import BODY, ball_motion
from ..clock import foot_bindings, foot_motion
from ..mjcf import Mjcf, Motion


def joints(p: BallHoop, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the slide, of the ball joint and of the spring's foot."""
    return {
        "y": (state["y"], state["y_dot"]),
        QUATERNION.name: ball_motion(state),
        "foot": foot_motion(coefficients(p), time),
    }


MODELS = {
    "ball": Mjcf(
        path=Path(__file__).with_name("ball_hoop.xml"),
        bindings={
            **BODY,
            **foot_bindings(coefficients),
            ("body:main_mass/inertial", "mass"): lambda p: p.main_mass,
            ("joint:y", "damping"): lambda p: p.damping,
            ("joint:q", "damping"): lambda p: p.joint_damping,
        },
        joints=joints,
    ),
}
