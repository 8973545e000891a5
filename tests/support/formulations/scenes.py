"""What the scenes are made of: bodies, joints and loads, as papers and textbooks draw them.

Each function builds the mechanism in one state, from parameters as decimals and the time. Sources
are those of the scenes: the papers, and the sketches of `docs/scenes.md`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal
from itertools import pairwise
from typing import Any

import numpy as np

from mbcheck.tests.support.formulations.newton_euler import (
    PI,
    UNIT,
    ZERO,
    Mechanism,
    about,
    cos_sin,
    norm,
    of_quaternion,
    rates_of,
)

X, Y, Z = UNIT
GROUND = 0

Builder = Callable[[Mechanism, Any, Any], None]


def planar_gravity(p: Any) -> Any:
    """Return gravity in the plane of a scene."""
    return p.gravity_x * X + p.gravity_y * Y


def gravity(p: Any) -> Any:
    """Return gravity in the world."""
    return planar_gravity(p) + p.gravity_z * Z


def sprung_mass(m: Mechanism, p: Any, t: Any, damping: Any) -> int:
    """Build the main mass on its slide along y, with spring, damper and harmonic force."""
    main = m.slide("y", 1, p.main_mass)
    phase = 2 * PI * p.force_frequency * t
    cos = cos_sin(phase)[0]
    m.load(main, m.spring(p.stiffness, m.q["y"]) * Y)
    m.load(main, -damping * m.v["y"] * Y, name="damper")
    m.load(main, p.force_amplitude * cos * Y, name="force", size=1 + abs(phase / cos))
    return main


def hula_hoop(m: Mechanism, p: Any, t: Any) -> None:
    """Build the main mass, and the free mass on its rod."""
    both, square = p.main_mass + p.free_mass, p.free_mass * p.rod_length**2
    omega_n = (p.stiffness / both).sqrt()
    main = sprung_mass(m, p, t, 2 * p.damping_ratio * both * omega_n)
    tensor = p.inertia_ratio * square * UNIT
    rod = m.hinge("theta", main, p.free_mass, tensor=tensor, arm=p.rod_length * X)
    m.twist(main, rod, -p.hinge_damping_ratio * square * omega_n * m.v["theta"], "hinge")
    m.weigh(planar_gravity(p))


def rotor_pendulum(m: Mechanism, p: Any, t: Any) -> None:
    """Build platform, first rotor (clockwise from -x), rod, and the second on the rod's end."""
    platform = m.slide("x", 0, p.platform_mass)
    r, flipped = p.eccentricity * X, UNIT * [1, -1, -1]
    first = m.hinge("phi_1", platform, p.rotor_mass, arm=-r, frame=flipped)
    beta = about(Z, p.installation_angle)
    rod = m.hinge("phi_3", platform, p.rod_mass, arm=p.rod_length * X, frame=beta)
    second = m.attach(
        rod,
        p.rotor_mass,
        {5: "phi_2 against the rod"},
        arm=r,
        turn=about(Z, m.q["phi_2"] - m.q["phi_3"] - p.installation_angle),
        spin=(m.v["phi_2"] - m.v["phi_3"]) * Z,
    )
    m.read["phi_2"] = [(second, [*ZERO, *Z])], Decimal(0)
    m.load(platform, m.spring(p.platform_stiffness, m.q["x"]) * X)
    m.load(platform, -p.platform_damping * m.v["x"] * X, name="platform")
    m.twist(platform, rod, m.spring(p.rod_stiffness, m.q["phi_3"]))
    m.twist(platform, rod, -p.rod_damping * m.v["phi_3"], "rod")
    relative = p.motor_placement == "relative"
    for number, rotor, bearer, rate in (
        (1, first, platform, m.v["phi_1"]),
        (2, second, rod if relative else GROUND, m.v["phi_2"] - relative * m.v["phi_3"]),
    ):
        m.twist(bearer, rotor, p.motor_slope * p.synchronous_speed, f"motor_{number}")
        m.twist(bearer, rotor, -p.motor_slope * rate, f"motor_{number}")
        m.twist(bearer, rotor, -p.friction * rate, f"friction_{number}")
    m.weigh(planar_gravity(p))


def speed_regulator(m: Mechanism, p: Any, t: Any) -> None:
    """Build crank, rod and slider, and close their loop at B in the plane."""
    r, l, rate = p.crank_radius, p.rod_length, m.v["phi"]
    cos, sin = cos_sin(m.q["phi"])
    sin_b = r * cos / l
    cos_b = (1 - sin_b**2).sqrt()
    b_dot = -r * sin * rate / (l * cos_b)
    y, y_dot = r * sin - l * cos_b, r * cos * rate + l * sin_b * b_dot
    axes = np.array([-sin_b * X - cos_b * Y, cos_b * X - sin_b * Y, Z]).T
    crank = m.hinge("phi", GROUND, Decimal(0), tensor=p.flywheel_inertia * UNIT)
    m.told |= {f"reaction_a_{axis}": (len(m.held) + i, -1) for i, axis in enumerate("xy")}
    rod = m.attach(
        crank,
        p.rod_mass,
        {5: "rod"},
        tensor=p.rod_mass * l**2 / 12 * UNIT,
        at=r * X,
        frame=m.bodies[crank].axes.T,
        arm=l / 2 * X,
        turn=axes,
        spin=(-b_dot - rate) * Z,
    )
    slider = m.attach(GROUND, p.slider_mass, {1: "y"}, shift=y * Y, speed=y_dot * Y)
    m.told |= {f"reaction_b_{axis}": (len(m.held) + i, 1) for i, axis in enumerate("xy")}
    m.held += m.joint(slider, rod, ZERO, axes @ (l / 2 * X), UNIT, UNIT)[:2]
    m.twist(GROUND, crank, p.torque, "motor")
    m.load(slider, m.spring(p.stiffness, r * sin, -l * cos_b, -p.spring_rest) * Y)
    m.load(slider, -p.damping * y_dot * Y, name="damper")
    m.weigh(planar_gravity(p))


def body(m: Mechanism, bearer: int, p: Any, **joint: Any) -> int:
    """Build the body with the parameters of one, whose quaternion turns it about its point."""
    vector = np.array([p.axes_x, p.axes_y, p.axes_z])
    axes = about(vector / norm(vector), norm(vector))
    q, rates = (np.array([of[f"q_{axis}"] for axis in "wxyz"]) for of in (m.q, m.v))
    turn = of_quaternion(q)
    free = {**joint.pop("free", {}), 3: "omega_x", 4: "omega_y", 5: "omega_z"}
    return m.attach(
        bearer,
        p.mass,
        free,
        tensor=axes * [p.moment_1, p.moment_2, p.moment_3] @ axes.T,
        arm=p.centre_x * X + p.centre_y * Y + p.centre_z * Z,
        turn=turn,
        spin=turn @ rates_of(q, rates),
        **joint,
    )


def rigid_body(m: Mechanism, p: Any, t: Any) -> None:
    """Build the body on its ball joint."""
    body(m, GROUND, p)
    m.weigh(gravity(p))


def ball_hoop(m: Mechanism, p: Any, t: Any) -> None:
    """Build the main mass, and the body on a ball joint."""
    turning = body(m, sprung_mass(m, p, t, p.damping), p)
    m.load(turning, torque=-p.joint_damping * m.bodies[turning].spin, name="friction")
    m.weigh(gravity(p))


def afloat(m: Mechanism, p: Any) -> tuple[int, Any]:
    """Build the body on a free joint; return its number, and its point from its centre of mass."""
    place, speed = (np.array([of[axis] for axis in "xyz"]) for of in (m.q, m.v))
    base = body(m, GROUND, p, shift=place, speed=speed, free=dict(enumerate("xyz")))
    return base, -(p.centre_x * X + p.centre_y * Y + p.centre_z * Z)


def floating_platform(m: Mechanism, p: Any, t: Any) -> None:
    """Build the platform, its rotor, and the pendulum on its torsion spring."""
    base, point = afloat(m, p)
    cross = p.polar_moment / 2 + p.depth_moment
    rotor = m.hinge(
        "phi",
        base,
        p.rotor_mass,
        tensor=UNIT * [cross, cross, p.polar_moment],
        at=point + p.rotor_height * Z,
        arm=p.eccentricity * X,
    )
    rod = m.hinge(
        "theta",
        base,
        p.rod_mass,
        tensor=p.rod_moment * UNIT,
        at=point + p.rod_place * X,
        frame=about(X, p.tilt) @ about(Z, p.installation_angle),
        arm=p.rod_length * X,
    )
    m.twist(base, rotor, p.motor_slope * p.synchronous_speed, "motor")
    m.twist(base, rotor, -p.motor_slope * m.v["phi"], "motor")
    m.twist(base, rod, m.spring(p.rod_stiffness, m.q["theta"]))
    m.twist(base, rod, -p.rod_damping * m.v["theta"], "damper")
    m.weigh(gravity(p))


def rod(
    m: Mechanism, name: str, bearer: int, mass: Any, length: Any, point: Any, place: Any, **on: Any
) -> tuple[int, Any]:
    """Build a rod with a point mass on it; return its number, and its end from its centre."""
    arm = (mass * length / 2 + point * place) / (mass + point)
    cross = mass * (length**2 / 12 + (length / 2 - arm) ** 2) + point * (place - arm) ** 2
    polar = on.pop("polar", Decimal(0))
    tensor = UNIT * [polar, polar / 2 + cross, polar / 2 + cross]
    number = m.hinge(name, bearer, mass + point, tensor=tensor, arm=arm * X, **on)
    return number, (length - arm) * X


def floating_beam(m: Mechanism, p: Any, t: Any) -> None:
    """Build the hub and three rods, each hinge turned by the twist from the one before."""
    bearer, at = afloat(m, p)
    at, frame, h = at + p.hub_radius * X, UNIT, p.length / 3
    for number in (1, 2, 3):
        name, tip = f"theta_{number}", p.tip_mass * (number == 3)
        on = {"at": at, "frame": frame, "polar": p.polar_moment}
        link, at = rod(m, name, bearer, p.beam_mass / 3, h, tip, h, **on)
        stiffness = p.bending_stiffness / h * (2 if number == 1 else 1)
        m.twist(bearer, link, m.spring(stiffness, m.q[name]))
        m.twist(bearer, link, -p.hinge_damping * m.v[name], "dampers")
        bearer, frame = link, about(X, p.twist)
    m.weigh(gravity(p))


def hub_drive(p: Any, t: Any) -> tuple[Any, Any]:
    """Return the hub's acceleration (22) or the torque (23) on it, and its size."""
    end = p.torque_period if p.drive == "torque" else p.ramp_time
    amplitude = p.torque_amplitude if p.drive == "torque" else p.angular_speed / p.ramp_time
    cos, sin = cos_sin(2 * PI * t / end)
    on = amplitude * (t < end)
    return on * (sin if p.drive == "torque" else 1 - cos), abs(on) * (1 + 2 * PI * t / end)


def chain(m: Mechanism, p: Any, t: Any) -> None:
    """Build the hub of `rotating_beam`, and its beam as rods with springs in their hinges."""
    h, line = p.length / int(p.segments), p.density * p.area
    on_hub, place = h / 2 * (p.scheme == "B"), p.mass_position * p.length
    hub = m.hinge("theta", GROUND, Decimal(0), tensor=p.hub_inertia * UNIT)
    drive, size = hub_drive(p, t)
    if p.drive == "torque":
        m.load(hub, torque=drive * Z, name="hub", size=size / abs(drive))
    else:
        m.given["theta"] = len(m.held), size
        m.held.append((m.read["theta"][0], -drive))
    stiffness = p.youngs_modulus * p.second_moment / h
    ends = [on_hub + h * i for i in range(int(p.segments))] + [p.length]
    bearer, at = hub, (p.hub_radius + on_hub) * X
    if on_hub:
        part = p.mass * (place <= on_hub)
        m.attach(
            hub, line * on_hub, {}, tensor=line * on_hub**3 / 12 * UNIT, at=at - on_hub / 2 * X
        )
        m.attach(hub, part, {}, at=(p.hub_radius + place) * X)
    for number, (start, end) in enumerate(pairwise(ends), 1):
        name, point = f"joint_{number}", p.mass * (start < place <= end)
        length = end - start
        link, at = rod(m, name, bearer, line * length, length, point, place - start, at=at)
        m.twist(bearer, link, m.spring(stiffness * (1 if start else 2), m.q[name]))
        bearer = link
    m.weigh(planar_gravity(p))


BUILDERS: Mapping[str, Builder] = {
    "hula_hoop": hula_hoop,
    "rotor_pendulum": rotor_pendulum,
    "speed_regulator": speed_regulator,
    "ball_hoop": ball_hoop,
    "rigid_body": rigid_body,
    "floating_beam": floating_beam,
    "floating_platform": floating_platform,
}
"""By scene, but for the continuum of `rotating_beam`."""
