"""rotating_beam as MJCF: a chain of hinged rods, and the clock that drives its hub."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path
from typing import NamedTuple

from ...reference.rotating_beam.chain import chain_scene
from ...reference.rotating_beam.parameters import RotatingBeam
from ..mjcf import Binding, Elements, Mjcf, Motion, Value, Wave, bind, coordinates_alone

HUB_ARMATURE = 2.0**60
"""Armature of a hub with prescribed motion [kg m^2]; the file tells why."""

GEAR = 2.0**-60
"""Gear of the clock's spring to the hub."""

HUB_MASS = 1e-3
"""Mass of a hub without a half rod [kg]; at its axle it does not act."""

INERTIA_FLOOR = 2e-15
"""Moment of inertia of a hub without one [kg m^2]: MuJoCo refuses less than 1e-15."""


class RodBody(NamedTuple):
    """One rod of the chain."""

    hinge: float
    """Its place from the clamp [m]"""
    length: float
    stiffness: float


class Drive(NamedTuple):
    """The drive u of `reference.rotating_beam`: ``constant + wave(omega t)`` until ``end``."""

    heaviness: float
    """Torque on the hub per unit of u"""
    constant: float
    amplitude: float
    """Amplitude of the clock, whose acceleration is the wave"""
    omega: float
    end: float


def drive(p: RotatingBeam) -> Drive:
    """Return the drive of the hub: u is its acceleration by (22), or the torque (23) on it."""
    if p.drive == "torque":
        omega = 2 * pi / p.torque_period
        return Drive(1.0, 0.0, -p.torque_amplitude / omega**2, omega, p.torque_period)
    if p.ramp_time == 0:
        return Drive(HUB_ARMATURE, 0.0, 0.0, 0.0, 0.0)
    omega = 2 * pi / p.ramp_time
    mean = p.angular_speed / p.ramp_time
    return Drive(HUB_ARMATURE, mean, mean / omega**2, omega, p.ramp_time)


def clock(p: RotatingBeam, time: float) -> tuple[float, float]:
    """Angle and speed of the clock: a sine that starts the torque, a cosine for the ramp."""
    of = drive(p)
    phase = of.omega * min(time, of.end)
    if p.drive == "torque":
        return of.amplitude * sin(phase), of.amplitude * of.omega * cos(phase)
    return of.amplitude * cos(phase), 0.0 - of.amplitude * of.omega * sin(phase)


def joints(p: RotatingBeam, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the hub, of the rods that the state names, and of the clock."""
    return {**coordinates_alone(p, time, state), "clock": clock(p, time)}


def rods(p: RotatingBeam) -> list[RodBody]:
    """Return the rods from clamp to tip."""
    n, whole = int(p.segments), p.length / p.segments
    bending = p.youngs_modulus * p.second_moment / whole
    if p.scheme == "A":
        return [RodBody(i * whole, whole, bending * (2 if i == 0 else 1)) for i in range(n)]
    return [
        RodBody((i + 0.5) * whole, whole if i < n - 1 else whole / 2, bending) for i in range(n)
    ]


def carrier(p: RotatingBeam) -> int:
    """Return the number of the rod that the mass is part of, 0 for the hub."""
    return sum(rod.hinge < p.mass_position * p.length for rod in rods(p))


def expand(text: str, p: RotatingBeam) -> str:
    """Return the file with as many rods as segments, the mass behind the rod that carries it."""
    lines = text.splitlines(keepends=True)
    places = [i for i, line in enumerate(lines) if re.match(r' *<body name="(rod_\d+|mass)"', line)]
    first, mass = (
        next(lines[i] for i in places if f'"{name}"' in lines[i]) for name in ("rod_1", "mass")
    )
    count = int(p.segments)
    chain = [first.replace('_1"', f'_{i}"') for i in range(1, count + 1)]
    chain.insert(carrier(p), mass)
    closed = re.sub(r"(</body>){2,}", "</body>" * count, "".join(lines[places[-1] + 1 :]), count=1)
    whole = "".join([*lines[: places[0]], *chain, closed])
    return bind(whole, chain_values(p))


def chain_values(p: RotatingBeam) -> dict[tuple[str, str], Value]:
    """Return the numbers of rods, mass and tip; each is in the frame of its rod."""
    chain = rods(p)
    line = p.density * p.area
    hinges = [-p.hub_radius, *(rod.hinge for rod in chain)]  # the first is the hub's axis
    values: dict[tuple[str, str], Value] = {}
    for i, rod in enumerate(chain, start=1):
        inertia = line * rod.length**3 / 12
        values |= {
            (f"body:rod_{i}", "pos"): (rod.hinge - hinges[i - 1], 0, 0),
            (f"body:rod_{i}/inertial", "pos"): (rod.length / 2, 0, 0),
            (f"body:rod_{i}/inertial", "mass"): line * rod.length,
            (f"body:rod_{i}/inertial", "diaginertia"): (inertia, inertia, inertia),
            (f"joint:joint_{i}", "stiffness"): rod.stiffness,
            (f"geom:rod_{i}", "fromto"): (0, 0, 0, rod.length, 0, 0),
        }
    values["body:mass", "pos"] = (p.mass_position * p.length - hinges[carrier(p)], 0, 0)
    values["site:tip", "pos"] = (chain[-1].length, 0, 0)
    return values


class HalfRod(NamedTuple):
    """The half rod that scheme B fixes on the hub; scheme A has none."""

    mass: float
    centre: float
    """Distance from the axis [m]"""
    inertia: float
    """About its centre"""


def half_rod(p: RotatingBeam) -> HalfRod:
    """Return the part of the beam up to its first hinge."""
    length = rods(p)[0].hinge
    mass = p.density * p.area * length
    return HalfRod(mass, p.hub_radius + length / 2 if length else 0.0, mass * length**2 / 12)


def hub_inertia(p: RotatingBeam) -> tuple[float, float, float]:
    """Moment of inertia of hub and half rod about their centre of mass; only z counts."""
    return (max(p.hub_inertia + half_rod(p).inertia, INERTIA_FLOOR),) * 3


def hub_lacks_inertia(p: RotatingBeam) -> str | None:
    """Return the reason why a chain cannot model these parameters, or None."""
    hub = p.hub_inertia + p.hub_radius + rods(p)[0].hinge
    if p.drive == "prescribed" or hub > 0:
        return None
    return (
        "hub_inertia and hub_radius 0: nothing resists the torque but the spring at the clamp; "
        "choose scheme B, whose hub has half a rod"
    )


def hub_moves_freely(p: RotatingBeam) -> str | None:
    """Return the reason why a chain with a torque cannot model these parameters, or None."""
    if p.drive == "prescribed":
        return "a torque drives this model: its hub has no prescribed motion"
    return hub_lacks_inertia(p)


def side(p: RotatingBeam) -> int:
    """Scheme A has its first frequency below that of the continuum, B above; see the chain."""
    known = p.mass == 0 or p.mass_position == 1
    return {"A": -1, "B": 1}[p.scheme] if known else 0


def start_speeds(p: RotatingBeam) -> tuple[float, ...]:
    """Speeds at t = 0: of the clock, of a hub without a ramp, of the rods."""
    steady = p.drive == "prescribed" and p.ramp_time == 0
    return (clock(p, 0.0)[1], p.angular_speed if steady else 0.0, *[0.0] * int(p.segments))


MECHANISM: Mapping[tuple[str, str], Binding] = {
    ("option", "gravity"): lambda p: (p.gravity_x, p.gravity_y, 0),
    ("body:hub/inertial", "pos"): lambda p: (half_rod(p).centre, 0, 0),
    ("body:hub/inertial", "mass"): lambda p: half_rod(p).mass or HUB_MASS,
    ("body:hub/inertial", "diaginertia"): hub_inertia,
    ("geom:hub", "size"): lambda p: (max(p.hub_radius + rods(p)[0].hinge, p.length / 40), 0.1),
    ("site:along", "pos"): lambda p: (p.hub_radius + p.length, 0, 0),
    ("site:across", "pos"): lambda p: (p.hub_radius + p.length, 0, 0),
    ("body:mass/inertial", "mass"): lambda p: p.mass,
}
"""Attribute of the MJCF -> its value, of both files; those of the chain are in `chain_values`."""

CLOCK: Mapping[tuple[str, str], Binding] = {
    ("joint:clock", "ref"): lambda p: clock(p, 0.0)[0],
    ("joint:clock", "armature"): lambda p: drive(p).heaviness / GEAR,
    ("general:wave", "biasprm"): lambda p: (
        0,
        -drive(p).heaviness / GEAR * drive(p).omega ** 2,
        0,
    ),
    ("general:sweep", "biasprm"): lambda p: (drive(p).heaviness * drive(p).constant, 0, 0),
    ("joint:theta", "armature"): lambda p: HUB_ARMATURE if p.drive == "prescribed" else 0.0,
    ("key:start", "qvel"): start_speeds,
}

CHAIN = Mjcf(
    path=Path(__file__).with_name("chain.xml"),
    bindings={**MECHANISM, **CLOCK},
    joints=joints,
    equations=lambda p: (chain_scene(int(p.segments), p.scheme), p),
    unsupported_reason=hub_lacks_inertia,
    expand=expand,
    stop=lambda p: drive(p).end or None,
    prescribed=lambda p: ("theta",) if p.drive == "prescribed" else (),
    elements=Elements(2, side),
)

MODELS = {
    "chain": CHAIN,
    "forced": replace(
        CHAIN,
        path=Path(__file__).with_name("forced.xml"),
        bindings=MECHANISM,
        joints=coordinates_alone,
        unsupported_reason=hub_moves_freely,
        controls=lambda p: {"torque": Wave(p.torque_amplitude, drive(p).omega, -pi / 2)},  # (23)
    ),
}
