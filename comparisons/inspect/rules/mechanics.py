"""The rules about what a model weighs and what drives it, as a table; see `table`."""

from __future__ import annotations

from collections.abc import Mapping

from ..subject import ModelRule
from . import bodies, drives

MECHANICS: Mapping[str, ModelRule] = {
    "odd_inertia": ModelRule(
        "warning",
        "an inertia that no body of this mass and size has",
        "The radius of gyration, sqrt(I / m), lies within a body. Beyond it, or as good as a "
        "point, inertia and mass have different units: an export that forgot to convert g mm^2.",
        "convert the inertia to kg m^2 and the mass to kg",
        bodies.odd_inertia,
    ),
    "far_centre": ModelRule(
        "warning",
        "a centre of mass far off the body's geoms",
        "It is given in the frame of the body; in another frame, or in millimetres, it pulls where "
        "nothing is.",
        "give it in the body's frame, in metres",
        bodies.far_centre,
    ),
    "odd_density": ModelRule(
        "warning",
        "a body denser than any material, or lighter than air",
        "The mass belongs to another size, or has another unit.",
        "give the mass in kg, and the geoms in metres",
        bodies.odd_density,
    ),
    "uneven_masses": ModelRule(
        "note",
        "a light body that carries a very heavy one",
        f"From {bodies.UNEVEN:,.0f} times its own mass on, if its joints have no armature: forces "
        "that the heavy part feels turn the light one by far more than any step resolves, and "
        "solvers of contact converge slowly.",
        "give the light body its mass, or its joint armature",
        bodies.uneven_masses,
    ),
    "always_touching": ModelRule(
        "warning",
        "geoms of one mechanism that lie in each other wherever its joints are",
        "A contact that never ends holds the joint between them, or shakes it.",
        "exclude the pair of bodies from contact, or make the geoms smaller",
        bodies.always_touching,
    ),
    "self_collision": ModelRule(
        "note",
        "geoms of one mechanism that meet within the ranges of its joints",
        "Ranges of joints that let parts meet are wider than the mechanism: a controller that "
        "trusts them runs into contact. Random positions show it; other ones may, too.",
        "narrow the ranges, or waive it where a controller knows of it",
        bodies.self_collision,
    ),
    "light_joint": ModelRule(
        "warning",
        "a joint too light for the force that drives it",
        "In one step of full force it turns by more than half a turn, or slides by more than the "
        "size of the model: no integrator follows it.",
        "give it armature (the rotor's inertia times the gear squared), or a smaller forcerange",
        drives.light_joint,
    ),
    "unlimited_joint": ModelRule(
        "note",
        "a joint without a limit that a servo moves within a range",
        "The range of a control limits what is asked, not where a load carries the joint.",
        "give the joint the range that it has",
        drives.unlimited_joint,
    ),
    "control_in_degrees": ModelRule(
        "warning",
        "a range of control that is in degrees",
        "The compiler converts angles of joints, not controls: they are radians.",
        'write the range in radians, or inheritrange="1"',
        drives.control_in_degrees,
    ),
    "control_beyond_range": ModelRule(
        "warning",
        "a servo that may be asked for what its joint cannot reach",
        "It pushes into the joint's limit with all its force, and the soft limit gives way.",
        'limit what is asked to the range of the joint, or write inheritrange="1"',
        drives.control_beyond_range,
    ),
    "positive_feedback": ModelRule(
        "warning",
        "a servo that pushes on what it shall hold back",
        "Its bias has the wrong sign: what departs is driven further.",
        "turn the sign of kp or kv, of biasprm of a general actuator",
        drives.positive_feedback,
    ),
    "undamped_servo": ModelRule(
        "warning",
        "a servo that nothing damps",
        "Nothing that acts in the joint has damping or friction: each command starts an "
        "oscillation that only the integrator's error ends.",
        'dampratio="1" on the position actuator, or damping on the joint',
        drives.undamped_servo,
    ),
    "two_servos": ModelRule(
        "warning",
        "two actuators that hold, or drive, one joint alike",
        "Two servos pull it each to its own control, and a program that sets one leaves the other "
        "at 0. Two motors add up.",
        "remove one",
        drives.two_servos,
    ),
    "saturated_actuator": ModelRule(
        "warning",
        "an actuator whose load in a keyframe is beyond its largest force",
        "Whatever its control is, its joint sags.",
        "raise forcerange, of a motor ctrlrange, or choose a state that needs less",
        drives.saturated_actuator,
    ),
    "control_not_holding": ModelRule(
        "warning",
        "a keyframe that its own controls leave",
        "A run from there starts with a jump: the control asks for another place, or the gain is "
        "too low for the load.",
        "give the keyframe the ctrl that holds it: its joint positions, and what the load adds",
        drives.control_not_holding,
    ),
    "spring_beyond_range": ModelRule(
        "note",
        "a spring that rests beyond the joint's limits",
        "It presses the joint against its limit; springref counts from the joint's 0, in the "
        "compiler's unit.",
        "put springref within the range; waive it if the joint is to be preloaded",
        drives.spring_beyond_range,
    ),
    "zero_quaternion": ModelRule(
        "warning",
        "a keyframe with a quaternion that is none",
        "The body starts with another orientation than the numbers say, without a word.",
        "write 1 0 0 0 for no rotation",
        drives.zero_quaternion,
    ),
}
"""By id, in the order of reports."""
