"""floating_beam as MJCF: which parameter goes where."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from ...reference.floating_beam import ANGLES, RODS, FloatingBeam
from ..body import BODY, free_motion
from ..mjcf import Binding, Mjcf


def diagonal(p: FloatingBeam, k: int) -> tuple[float, float, float]:
    """Return the moments of rod k about its centre of mass."""
    return p.polar_moment, p.rods[k][2], p.rods[k][2]


def rod(k: int) -> dict[tuple[str, str], Binding]:
    """Return the bindings of rod k."""
    body, joint = f"body:rod_{k + 1}", f"joint:{ANGLES[k]}"
    return {
        (body, "pos"): lambda p: (p.rod_length if k else p.hub_radius, 0, 0),
        **({(body, "euler"): lambda p: (p.twist, 0, 0)} if k else {}),
        (f"{body}/inertial", "pos"): lambda p: (p.rods[k][1], 0, 0),
        (f"{body}/inertial", "mass"): lambda p: p.rods[k][0],
        (f"{body}/inertial", "diaginertia"): lambda p: diagonal(p, k),
        (joint, "stiffness"): lambda p: p.springs[k],
        (joint, "damping"): lambda p: p.hinge_damping,
        (f"geom:rod_{k + 1}", "fromto"): lambda p: (0, 0, 0, p.rod_length, 0, 0),
    }


MODELS = {
    "free": Mjcf(
        path=Path(__file__).with_name("floating_beam.xml"),
        bindings={key: value for part in (BODY, *map(rod, range(RODS)))
                  for key, value in part.items()},
        joints=partial(free_motion, ANGLES),
    ),
}  # fmt: skip
