"""What the scenes are made of: bodies, joints and loads, as the papers and textbooks draw them.

Each function builds the mechanism in one state, from parameters, coordinates and rates by name, as
decimals. The sources are those of the scenes: their docstrings, `docs/scenes.md`, the papers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal
from types import SimpleNamespace
from typing import Any

import numpy as np

from mbcheck.tests.support.formulations.newton_euler import (
    PI,
    UNIT,
    ZERO,
    Mechanism,
    about,
    cos_sin,
    decimals,
    norm,
    of_quaternion,
    rates_of,
)

GROUND = 0
X, Y, Z = UNIT
OMEGA = {3: "omega_x", 4: "omega_y", 5: "omega_z"}

Values = Mapping[str, Any]


def planar_gravity(p: Any) -> Any:
    """Return gravity in the plane of a scene."""
    return p.gravity_x * X + p.gravity_y * Y


def spring(m: Mechanism, stiffness: Any, *parts: Any) -> Any:
    """Return the force or torque of a spring stretched by the sum of parts; count its energy."""
    stretch, size = sum(parts), sum(abs(part) for part in parts)
    m.potentials.append((stiffness * stretch**2 / 2, stiffness * abs(stretch) * size))
    return -stiffness * stretch


def shake(m: Mechanism, main: int, p: Any, t: Any) -> None:
    """Let the harmonic force act along y."""
    phase = 2 * PI * p.force_frequency * t
    cos = cos_sin(phase)[0]
    m.load(main, p.force_amplitude * cos * Y, name="force", size=1 + abs(phase / cos))


def hula_hoop(m: Mechanism, p: Any, q: Values, v: Values, t: Any) -> None:
    """Build the main mass on its slide along y, and the free mass on its rod."""
    omega_n = (p.stiffness / (p.main_mass + p.free_mass)).sqrt()
    square = p.free_mass * p.rod_length**2
    main = m.attach(GROUND, p.main_mass, {1: "y"}, shift=q["y"] * Y, speed=v["y"] * Y)
    rod = m.attach(
        main,
        p.free_mass,
        {5: "theta"},
        tensor=p.inertia_ratio * square * UNIT,
        arm=p.rod_length * X,
        turn=about(2, q["theta"]),
        spin=v["theta"] * Z,
    )
    damping = 2 * p.damping_ratio * (p.main_mass + p.free_mass) * omega_n
    m.load(main, spring(m, p.stiffness, q["y"]) * Y)
    m.load(main, -damping * v["y"] * Y, name="damper")
    shake(m, main, p, t)
    m.twist(main, rod, -p.hinge_damping_ratio * square * omega_n * v["theta"], "hinge")
    m.weigh(planar_gravity(p))


def rotor_pendulum(m: Mechanism, p: Any, q: Values, v: Values, t: Any) -> None:
    """Build platform, first rotor (clockwise from -x), rod, and the second on the rod's end."""
    upside_down = UNIT * [1, -1, -1]
    platform = m.attach(GROUND, p.platform_mass, {0: "x"}, shift=q["x"] * X, speed=v["x"] * X)
    first = m.attach(
        platform,
        p.rotor_mass,
        {5: "phi_1"},
        frame=upside_down,
        arm=-p.eccentricity * X,
        turn=about(2, q["phi_1"]),
        spin=v["phi_1"] * Z,
    )
    rod = m.attach(
        platform,
        p.rod_mass,
        {5: "phi_3"},
        frame=about(2, p.installation_angle),
        arm=p.rod_length * X,
        turn=about(2, q["phi_3"]),
        spin=v["phi_3"] * Z,
    )
    second = m.attach(
        rod,
        p.rotor_mass,
        {5: "against the rod"},
        arm=p.eccentricity * X,
        turn=about(2, q["phi_2"] - q["phi_3"] - p.installation_angle),
        spin=(v["phi_2"] - v["phi_3"]) * Z,
    )
    m.read["phi_2"] = [(second, [*ZERO, *Z])], Decimal(0), Decimal(0)
    m.load(platform, spring(m, p.platform_stiffness, q["x"]) * X)
    m.load(platform, -p.platform_damping * v["x"] * X, name="platform")
    m.twist(platform, rod, spring(m, p.rod_stiffness, q["phi_3"]))
    m.twist(platform, rod, -p.rod_damping * v["phi_3"], "rod")
    relative = p.motor_placement == "relative"
    for number, rotor, bearer, rate in (
        (1, first, platform, v["phi_1"]),
        (2, second, rod if relative else GROUND, v["phi_2"] - relative * v["phi_3"]),
    ):
        m.twist(bearer, rotor, p.motor_slope * p.synchronous_speed, f"motor_{number}")
        m.twist(bearer, rotor, -p.motor_slope * rate, f"motor_{number}")
        m.twist(bearer, rotor, -p.friction * rate, f"friction_{number}")
    m.weigh(planar_gravity(p))


def speed_regulator(m: Mechanism, p: Any, q: Values, v: Values, t: Any) -> None:
    """Build crank, rod and slider, and close their loop at B in the plane."""
    r, half = p.crank_radius, p.rod_length / 2
    cos, sin = cos_sin(q["phi"])
    sin_b = r * cos / p.rod_length
    cos_b = (1 - sin_b**2).sqrt()
    b_dot = -r * sin * v["phi"] / (p.rod_length * cos_b)
    y = r * sin - p.rod_length * cos_b
    y_dot = r * cos * v["phi"] + p.rod_length * sin_b * b_dot
    crank_axes = about(2, q["phi"])
    rod_axes = np.array([-sin_b * X - cos_b * Y, cos_b * X - sin_b * Y, Z]).T
    crank = m.attach(
        GROUND,
        Decimal(0),
        {5: "phi"},
        tensor=p.flywheel_inertia * UNIT,
        turn=crank_axes,
        spin=v["phi"] * Z,
    )
    rod = m.attach(
        crank,
        p.rod_mass,
        {5: "rod"},
        tensor=p.rod_mass * p.rod_length**2 / 12 * UNIT,
        at=r * X,
        arm=half * X,
        turn=crank_axes.T @ rod_axes,
        spin=(-b_dot - v["phi"]) * Z,
    )
    slider = m.attach(GROUND, p.slider_mass, {1: "y"}, shift=y * Y, speed=y_dot * Y)
    m.held += m.joint(slider, rod, ZERO, rod_axes @ (half * X), UNIT, UNIT)[:2]
    m.twist(GROUND, crank, p.torque, "motor")
    m.load(slider, spring(m, p.stiffness, r * sin, -p.rod_length * cos_b, -p.spring_rest) * Y)
    m.load(slider, -p.damping * y_dot * Y, name="damper")
    m.weigh(planar_gravity(p))


def body(m: Mechanism, bearer: int, p: Any, q: Values, v: Values, **joint: Any) -> int:
    """Add a body with the parameters of one, whose quaternion turns it about its point."""
    vector = np.array([p.axes_x, p.axes_y, p.axes_z])
    angle = norm(vector)
    cos, sin = cos_sin(angle / 2)
    axes = of_quaternion(np.array([cos, *(sin / angle * vector)]))
    quaternion, rates = ([of[f"q_{axis}"] for axis in "wxyz"] for of in (q, v))
    turn = of_quaternion(np.array(quaternion))
    joint["free"] = {**joint.get("free", {}), **OMEGA}
    return m.attach(
        bearer,
        p.mass,
        tensor=axes * [p.moment_1, p.moment_2, p.moment_3] @ axes.T,
        arm=np.array([p.centre_x, p.centre_y, p.centre_z]),
        turn=turn,
        spin=turn @ rates_of(np.array(quaternion), np.array(rates)),
        **joint,
    )


def gravity(p: Any) -> Any:
    """Return gravity in the world."""
    return np.array([p.gravity_x, p.gravity_y, p.gravity_z])


def rigid_body(m: Mechanism, p: Any, q: Values, v: Values, t: Any) -> None:
    """Build the body on its ball joint."""
    body(m, GROUND, p, q, v)
    m.weigh(gravity(p))


def ball_hoop(m: Mechanism, p: Any, q: Values, v: Values, t: Any) -> None:
    """Build the main mass on its slide along y, and the body on a ball joint."""
    main = m.attach(GROUND, p.main_mass, {1: "y"}, shift=q["y"] * Y, speed=v["y"] * Y)
    turning = body(m, main, p, q, v)
    m.load(main, spring(m, p.stiffness, q["y"]) * Y)
    m.load(main, -p.damping * v["y"] * Y, name="damper")
    shake(m, main, p, t)
    m.load(turning, torque=-p.joint_damping * m.bodies[turning].spin, name="friction")
    m.weigh(gravity(p))


def afloat(m: Mechanism, p: Any, q: Values, v: Values) -> tuple[int, Any]:
    """Add a body on a free joint; return its number, and its point from its centre of mass."""
    place, speed = (np.array([of[axis] for axis in "xyz"]) for of in (q, v))
    free = {row: axis for row, axis in enumerate("xyz")}
    base = body(m, GROUND, p, q, v, shift=place, speed=speed, free=free)
    return base, -np.array([p.centre_x, p.centre_y, p.centre_z])


def floating_platform(m: Mechanism, p: Any, q: Values, v: Values, t: Any) -> None:
    """Build the platform, its rotor, and the pendulum on its torsion spring."""
    base, point = afloat(m, p, q, v)
    cross = p.polar_moment / 2 + p.depth_moment
    rotor = m.attach(
        base,
        p.rotor_mass,
        {5: "phi"},
        tensor=UNIT * [cross, cross, p.polar_moment],
        at=point + p.rotor_height * Z,
        arm=p.eccentricity * X,
        turn=about(2, q["phi"]),
        spin=v["phi"] * Z,
    )
    rod = m.attach(
        base,
        p.rod_mass,
        {5: "theta"},
        tensor=p.rod_moment * UNIT,
        at=point + p.rod_place * X,
        frame=about(0, p.tilt) @ about(2, p.installation_angle),
        arm=p.rod_length * X,
        turn=about(2, q["theta"]),
        spin=v["theta"] * Z,
    )
    m.twist(base, rotor, p.motor_slope * p.synchronous_speed, "motor")
    m.twist(base, rotor, -p.motor_slope * v["phi"], "motor")
    m.twist(base, rod, spring(m, p.rod_stiffness, q["theta"]))
    m.twist(base, rod, -p.rod_damping * v["theta"], "damper")
    m.weigh(gravity(p))


def floating_beam(m: Mechanism, p: Any, q: Values, v: Values, t: Any) -> None:
    """Build the hub and three rods, each hinge turned by the twist from the one before."""
    bearer, point = afloat(m, p, q, v)
    h, mass = p.length / 3, p.beam_mass / 3
    at, frame = point + p.hub_radius * X, UNIT
    for number in (1, 2, 3):
        tip = p.tip_mass * (number == 3)
        arm = (mass * h / 2 + tip * h) / (mass + tip)
        cross = p.polar_moment / 2 + mass * h**2 / 12 + mass * tip / (mass + tip) * h**2 / 4
        rod = m.attach(
            bearer,
            mass + tip,
            {5: f"theta_{number}"},
            tensor=UNIT * [p.polar_moment, cross, cross],
            at=at,
            frame=frame,
            arm=arm * X,
            turn=about(2, q[f"theta_{number}"]),
            spin=v[f"theta_{number}"] * Z,
        )
        stiffness = p.bending_stiffness / h * (2 if number == 1 else 1)
        m.twist(bearer, rod, spring(m, stiffness, q[f"theta_{number}"]))
        m.twist(bearer, rod, -p.hinge_damping * v[f"theta_{number}"], "dampers")
        bearer, at, frame = rod, (h - arm) * X, about(0, p.twist)
    m.weigh(gravity(p))


BUILDERS: Mapping[str, Callable[..., None]] = {
    "hula_hoop": hula_hoop,
    "rotor_pendulum": rotor_pendulum,
    "speed_regulator": speed_regulator,
    "ball_hoop": ball_hoop,
    "rigid_body": rigid_body,
    "floating_beam": floating_beam,
    "floating_platform": floating_platform,
}
"""By scene."""


def build(scene: str, parameters: Any, q: Values, v: Values, t: float) -> Mechanism:
    """Return the mechanism of a scene in one state at one time, all of plain numbers."""
    numbers = {
        name: value if isinstance(value, str) else Decimal(float(value))
        for name, value in parameters.as_dict().items()
    }
    m = Mechanism()
    exact = [{name: Decimal(float(x)) for name, x in of.items()} for of in (q, v)]
    BUILDERS[scene](m, SimpleNamespace(**numbers), *exact, Decimal(t))
    return m
