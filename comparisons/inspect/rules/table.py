"""The rules of inspection, a row each: what it finds, why that matters, what to do, what it needs.

A rule says what is wrong, or what the model could do without; it needs no run of the user's. An
*error* makes results wrong or fails, a *warning* may, a *note* is what the scene does not require,
or what a reader of results should know.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from ...checks.rules.conditions import MEANINGS
from ..subject import ModelRule
from . import bodies, drives, motion, parts, stability, text

RULES: Mapping[str, ModelRule] = {
    # how it moves
    "step_limit": ModelRule(
        "error",
        MEANINGS["step_limit"],
        "Above its largest stable step an integrator feeds the fastest mode in every step: the "
        "run blows up, or stays finite and is wrong. The limit follows from the eigenvalues of "
        "small motions about the file's states, and from what the integrator makes of them.",
        "shorten the timestep, choose an integrator with a larger limit, or soften what sets it",
        motion.step_limit,
        needs="modes",
    ),
    "near_step_limit": ModelRule(
        "warning",
        "the timestep is close to the integrator's stability limit",
        "The limit is that of small motions about the file's states. Elsewhere, and with contacts, "
        "the model may be stiffer.",
        "shorten the timestep, or choose an integrator with a larger limit",
        motion.near_step_limit,
        needs="modes",
    ),
    "coarse_step": ModelRule(
        "note",
        MEANINGS["coarse_step"],
        "A mode that is seen by a few steps in its period is stable at best: its phase, and with "
        "most integrators its amplitude, are lost.",
        "shorten the timestep if that motion matters; waive it if it does not",
        motion.coarse_step,
        needs="modes",
        house=True,
    ),
    "unstable_mode": ModelRule(
        "error",
        "a motion that an actuator or a negative damper feeds",
        "It grows from any disturbance, with every integrator and step: positive feedback, or a "
        "servo whose stiffness has a rotational part, as of servos on the three axes of a ball "
        "joint away from its reference. A run of the model has shown the growth.",
        "add damping, turn the sign of the gain, or move the state to the servo's reference",
        stability.unstable_mode,
        needs="modes",
    ),
    "unstable_equilibrium": ModelRule(
        "note",
        "a state of rest that is no minimum of the potential",
        "An inverted pendulum rests there until something disturbs it.",
        "waive it if a controller is to hold it",
        stability.unstable_equilibrium,
        needs="modes",
    ),
    "run_fails": ModelRule(
        "error",
        "a run from a state of the file fails",
        "Five seconds from there, or 20,000 steps, with the controls of the state held: what turns "
        "fast, touches, or reaches a limit is in no small motion, and may be too much for a step.",
        "another integrator, or a shorter timestep",
        stability.run_fails,
        needs="runs",
    ),
    "not_finite": ModelRule(
        "error",
        "forces are not finite in a state of the file",
        "A run from there fails in its first step, or is reset without a word.",
        "look for values that are zero, huge or missing: inertias, lengths, stiffnesses",
        motion.not_finite,
        needs="states",
    ),
    "closure_softness": ModelRule(
        "warning",
        MEANINGS["closure_softness"],
        "MuJoCo's constraints are soft. A loop that needs the force f stays open by R f / (d k), "
        "whatever the step, with R = (1 - d) / d times the bodies' inverse inertia: the file moves "
        "as another mechanism than the one it shows.",
        "close it harder, with a higher impedance or a shorter time constant, as far as the "
        "largest stable step allows",
        motion.closure_softness,
        needs="states",
    ),
    "closure_open": ModelRule(
        "warning",
        "a loop is open as the file has it",
        "The run starts with a kick that closes it, and energy that nothing explains.",
        "place the bodies, or the keyframe, so that the loop is closed",
        motion.closure_open,
        needs="states",
    ),
    "solref_raised": ModelRule(
        "warning",
        "MuJoCo softens a constraint because of the timestep",
        "A positive time constant below two timesteps is raised to that (refsafe), silently: "
        "results then depend on the timestep in a way that no integrator explains.",
        "shorten the timestep to half of the time constant, or write the one that is taken",
        motion.solref_raised,
    ),
    "solimp_clamped": ModelRule(
        "warning",
        "an impedance beyond MuJoCo's largest",
        "Impedances are silently kept at 0.9999 or below, so the constraint is softer than the "
        "file says.",
        "write the value that is taken",
        motion.solimp_clamped,
    ),
    "contact_depth": ModelRule(
        "warning",
        "bodies lie in each other as the file has them",
        "The run starts with a push that parts them.",
        "move them apart, or exclude the pair",
        motion.contact_depth,
        needs="states",
    ),
    "keyframe_outside_range": ModelRule(
        "warning",
        "a state of the file is beyond a joint's limits",
        "The run starts with a push back into the range.",
        "change the state or the range",
        motion.keyframe_outside_range,
        needs="states",
    ),
    "no_keyframe": ModelRule(
        "note",
        "no initial condition is told",
        "Whoever opens the file guesses how a run is to start.",
        "add a keyframe, <key name='start'/> if it is the state as opened",
        motion.no_keyframe,
        house=True,
    ),
    "auto_reset": ModelRule(
        "warning",
        "a run that fails starts anew",
        "MuJoCo sets a model that diverges back to its start and goes on, and zeroes its controls: "
        "a crashed run looks like one that came to rest. The counter of warnings stays at 1.",
        '<option><flag autoreset="disable"/></option>',
        motion.auto_reset,
        house=True,
    ),
    "clock_rounding": ModelRule(
        "note",
        MEANINGS["clock_rounding"],
        "The time of the model is a sum of steps. Unless the step is a power of two, it drifts: "
        "4e-11 s in 1e5 steps, which limits what is compared with a truth to nine digits.",
        "choose the power of two that is next to it",
        motion.clock_rounding,
        house=True,
    ),
    "energy_off": ModelRule(
        "note",
        "a conservative model does not keep its energy's books",
        "Where nothing feeds or takes energy, its drift is the error of the integration, for free.",
        '<option><flag energy="enable"/></option>',
        motion.energy_off,
        house=True,
    ),
    "ill_conditioned": ModelRule(
        "warning",
        MEANINGS["ill_conditioned"],
        "Digits are lost as the logarithm of the mass matrix' condition number, here in units of "
        "its own diagonal, so that light and heavy parts side by side do not count.",
        "look for chains of very unequal masses, and joints that nearly do the same",
        motion.ill_conditioned,
        needs="modes",
    ),
    "idle_gravity": ModelRule(
        "note",
        "gravity moves nothing",
        "No joint gives way to it in any configuration that was tried.",
        'gravity="0 0 0"',
        motion.idle_gravity,
        house=True,
    ),
    # what it consists of
    "welded_body": ModelRule(
        "note",
        "a body without joint at the end of a branch",
        "It is a part of its parent, and MuJoCo treats it so; as a body of its own it costs a "
        "frame, and hides where the mass is.",
        "move its geoms and its mass to its parent",
        parts.welded_body,
        house=True,
    ),
    "empty_body": ModelRule(
        "note",
        "a body that holds nothing",
        "It has no effect on anything.",
        "remove it",
        parts.empty_body,
        house=True,
    ),
    "locked_joint": ModelRule(
        "warning",
        "a joint that is held where it is",
        "A joint that cannot move costs a degree of freedom and a constraint, and gives way softly "
        "where a rigid connection would not.",
        "remove the joint and what holds it",
        parts.locked_joint,
    ),
    "idle_joint": ModelRule(
        "warning",
        "a joint that nothing moves",
        "In random states of the rest of the model, nothing accelerates it from rest: no spring, "
        "gravity, actuator or coupling reaches it.",
        "remove it, or add the force that is missing",
        parts.idle_joint,
    ),
    "contact_unused": ModelRule(
        "warning",
        "contact is on, and nothing can touch",
        "Collision detection runs in every step in vain; whoever adds a geom gets contacts that no "
        "one asked for.",
        '<option><flag contact="disable"/></option>',
        parts.contact_unused,
        house=True,
    ),
    "geom_never_touches": ModelRule(
        "note",
        "a geom for contact without a partner",
        "contype and conaffinity say that it collides, and no other geom answers.",
        'contype="0" conaffinity="0", or the bits that were meant',
        parts.geom_never_touches,
        house=True,
    ),
    "contact_leftovers": ModelRule(
        "note",
        "a pair or an exclusion without effect",
        "It speaks of a contact that cannot be.",
        "remove it",
        parts.contact_leftovers,
        house=True,
    ),
    "geom_mass": ModelRule(
        "note",
        "mass of a geom beside an explicit inertial",
        "A body with an <inertial> takes no mass from its geoms; a reader takes it for granted.",
        "remove the attribute, or the <inertial>",
        parts.geom_mass,
        house=True,
    ),
    "inertia_floor": ModelRule(
        "warning",
        MEANINGS["inertia_floor"],
        "MuJoCo refuses inertias of 1e-15 and less, so that a point mass has to have one. What a "
        "joint with next to no inertia does is rounding.",
        "check that what moves it is heavier by many orders, and waive it; else give it inertia",
        parts.inertia_floor,
        needs="modes",
    ),
    "inertia_raised": ModelRule(
        "warning",
        "the compiler changes masses or inertias",
        "What is simulated is not what the file says.",
        "write the inertias that are meant, and remove the setting",
        parts.inertia_raised,
    ),
    "merged_centre": ModelRule(
        "warning",
        "MuJoCo moves a centre of mass",
        "Below 1e-6 m it is taken for the body's frame, without a word, whatever the size of the "
        "model.",
        "choose a larger unit of length, or put it at 0",
        parts.merged_centre,
    ),
    "huge_armature": ModelRule(
        "warning",
        "an armature that hides what its joint moves",
        "Armature is added to the inertia of a joint, not of a body. It damps no motion but slows "
        "it down: loads on the link hardly move the joint, and it often stands in for a shorter "
        "step.",
        "use the rotor's inertia times the gear squared; waive it if that is what it is",
        parts.huge_armature,
        needs="modes",
        house=True,
    ),
    "negative_damping": ModelRule(
        "warning",
        "a damper that feeds energy",
        "It lets motions grow.",
        "turn its sign, or waive it if a source is meant",
        parts.negative_damping,
    ),
    "range_ignored": ModelRule(
        "warning",
        "a range that limits nothing",
        "A range counts if its lower end is below its upper one, and limits are not switched off: "
        "MuJoCo says nothing if not.",
        'give a range from low to high, and remove limited="false"',
        parts.range_ignored,
    ),
    "idle_actuator": ModelRule(
        "warning",
        "an actuator whose force is always 0",
        "Neither its gain nor its bias lets anything through.",
        "give it a gain or a bias, or remove it",
        parts.idle_actuator,
    ),
    "idle_tendon": ModelRule(
        "note",
        "a tendon that does nothing",
        "It is measured in every step, and pulls nothing.",
        "remove it",
        parts.idle_tendon,
        house=True,
    ),
    "duplicate_sensor": ModelRule(
        "note",
        "two sensors of the same",
        "Both show the same numbers.",
        "remove one",
        parts.duplicate_sensor,
        house=True,
    ),
    "unused_asset": ModelRule(
        "note",
        "an asset that nothing shows",
        "It is loaded with the file, and not used.",
        "remove it",
        parts.unused_asset,
        house=True,
    ),
    "unused_site": ModelRule(
        "note",
        "a site that nothing refers to",
        "A site is a place for sensors, tendons, actuators and closures.",
        "remove it, or waive it if a program asks for it",
        parts.unused_site,
        house=True,
    ),
    "inactive_equality": ModelRule(
        "note",
        "an equality that is off",
        "It holds nothing until a program says so.",
        "remove it, or waive it if a program does",
        parts.inactive_equality,
        house=True,
    ),
    "switched_off": ModelRule(
        "warning",
        "a flag switches off what the model has",
        "The file shows parts that do not act.",
        "remove the flag, or the parts",
        parts.switched_off,
    ),
    "compiler_warning": ModelRule(
        "warning",
        "MuJoCo warned as it read the file",
        "It goes on, and the model may not be the one that was meant.",
        "do what it says",
        parts.compiler_warning,
    ),
    # what it weighs, and what drives it
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
        partial(bodies.overlapping, always=True),
        needs="states",
    ),
    "self_collision": ModelRule(
        "note",
        "geoms of one mechanism that meet within the ranges of its joints",
        "Ranges of joints that let parts meet are wider than the mechanism: a controller that "
        "trusts them runs into contact. Random positions show it; other ones may, too.",
        "narrow the ranges, or waive it where a controller knows of it",
        partial(bodies.overlapping, always=False),
        needs="states",
        house=True,
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
        needs="states",
    ),
    "control_not_holding": ModelRule(
        "warning",
        "a keyframe that its own controls leave",
        "A run from there starts with a jump: the control asks for another place, or the gain is "
        "too low for the load.",
        "give the keyframe the ctrl that holds it: its joint positions, and what the load adds",
        drives.control_not_holding,
        needs="states",
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
    # its text
    "unused_class": ModelRule(
        "note",
        "a class of defaults that nothing has",
        "It changes nothing, and a reader looks for what has it.",
        "remove it",
        text.unused_class,
        house=True,
    ),
    "unused_option": ModelRule(
        "note",
        "an option that nothing uses",
        "It suggests that something depends on it.",
        "remove it",
        text.unused_option,
        house=True,
    ),
    "unused_setting": ModelRule(
        "note",
        "an attribute that its element has no use for",
        "It suggests that something depends on it.",
        "remove it, or give the element what it is a setting of",
        text.unused_setting,
        house=True,
    ),
    "implicit_degrees": ModelRule(
        "note",
        "angles whose unit the file does not tell",
        "MJCF counts in degrees unless told, while MuJoCo's API, sensors and keyframes count in "
        "radians.",
        '<compiler angle="radian"/>, or angle="degree" to say that degrees are meant',
        text.implicit_degrees,
        house=True,
    ),
    "angle_unit": ModelRule(
        "warning",
        "angles that look as if they were in the other unit",
        "A range of more than two turns, or of less than four degrees, is mostly a slip of the "
        "unit.",
        "convert the range, or change the compiler's angle",
        text.angle_unit,
    ),
    # what needs all findings
    "repeated_default": ModelRule(
        "note",
        "an attribute that changes nothing",
        "Without it the file compiles to the same bytes: it repeats a default, or is not used. "
        "What a file says twice, a reader has to compare.",
        "remove it; waive it where a program replaces the value",
        needs="findings",
        house=True,
    ),
    "waiver_reason": ModelRule(
        "error",
        "a waiver that cannot be read, or gives no reason",
        "A waiver without its reason hides what it allows.",
        "<!-- mbcheck: allow RULE, element: reason -->",
        needs="findings",
    ),
    "waiver_unknown": ModelRule(
        "error",
        "a waiver of a rule that there is not",
        "It allows nothing; a rule may have another name than was thought.",
        "use the id of a rule, as findings show it",
        needs="findings",
    ),
    "waiver_unused": ModelRule(
        "warning",
        "a waiver that waives nothing",
        "What it allowed is mended, or it names another element.",
        "remove it",
        needs="findings",
    ),
}
"""By id, in the order of reports."""
