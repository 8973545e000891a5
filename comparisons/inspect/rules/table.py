"""The rules of inspection, a row each: mistake, reason, remedy, function and required input.

A rule finds mistakes, or redundant parts. An *error* makes results wrong, or makes a run fail, a
*warning* may do so, a *note* is a part that the model does not need, or a fact that a reader of
results should know.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from ...checks.rules.conditions import MEANINGS
from ..subject import ModelRule
from ..tuning import THRESHOLDS
from . import drives, motion, parts, text

RULES: Mapping[str, ModelRule] = {
    # motion
    "step_limit": ModelRule(
        "error",
        MEANINGS["step_limit"],
        "Above its largest stable step an integrator amplifies the fastest mode in every step: "
        "the run diverges, or stays finite and is wrong. The limit follows from the eigenvalues "
        "of small motions about the file's states, and from the scheme of the integrator.",
        "shorten the timestep, choose an integrator with a larger limit, or soften the part "
        "that sets it",
        motion.step_limit,
        needs="modes",
    ),
    "near_step_limit": ModelRule(
        "warning",
        "the timestep is close to the largest stable step",
        "The limit holds for small motions about the file's states. Elsewhere, and with "
        "contacts, the model may be stiffer.",
        "shorten the timestep, or choose an integrator with a larger limit",
        motion.near_step_limit,
        needs="modes",
    ),
    "coarse_step": ModelRule(
        "note",
        MEANINGS["coarse_step"],
        "A mode resolved by a few steps in its period is stable at best: its phase, and "
        "with most integrators its amplitude, are wrong.",
        "shorten the timestep if that motion matters; waive the finding if it does not",
        motion.coarse_step,
        needs="modes",
        house=True,
    ),
    "unstable_mode": ModelRule(
        "error",
        "a motion that grows because an actuator or a negative damper feeds it",
        "It grows from any disturbance, with every integrator and step: positive feedback, or a "
        "servo whose stiffness has a skew part, as servos on the three axes of a ball joint "
        "have away from their reference. A run of the model has shown the growth.",
        "add damping, reverse the sign of the gain, or move the state to the reference of the "
        "servo",
        motion.unstable_mode,
        needs="modes",
    ),
    "unstable_equilibrium": ModelRule(
        "note",
        "a state of rest away from a minimum of the potential",
        "An inverted pendulum rests there until something disturbs it.",
        "waive it if a controller is to stabilise it",
        motion.unstable_equilibrium,
        needs="modes",
    ),
    "run_fails": ModelRule(
        "error",
        "a run from a state of the file diverges",
        "Runs last five seconds, or 20,000 steps, with the constant controls of the state. Fast "
        "rotation, contacts and joint limits are no part of small motions, and may be too much "
        "for the step.",
        "choose another integrator, or a shorter timestep",
        motion.run_fails,
        needs="runs",
    ),
    "not_finite": ModelRule(
        "error",
        "forces are not finite in a state of the file",
        "A run from there fails in its first step, or is silently reset.",
        "look for values that are zero, huge or missing: inertias, lengths, stiffnesses",
        motion.not_finite,
        needs="states",
    ),
    "closure_softness": ModelRule(
        "warning",
        MEANINGS["closure_softness"],
        "MuJoCo's constraints are soft. A loop that needs the force f stays open by R f / (d "
        "k), whatever the step, with R = (1 - d) / d times the bodies' inverse inertia: the "
        "mechanism that moves is not the one of the file.",
        "close it harder, with a higher impedance or a shorter time constant, as far as the "
        "largest stable step allows",
        motion.closure_softness,
        needs="states",
    ),
    "closure_open": ModelRule(
        "warning",
        "a loop is open in a state of the file",
        "The run starts with a jolt that closes it, and with energy from nowhere.",
        "move the bodies, or change the keyframe, so that the loop is closed",
        motion.closure_open,
        needs="states",
    ),
    "solref_raised": ModelRule(
        "warning",
        "MuJoCo softens a constraint because of the timestep",
        "MuJoCo silently raises a positive time constant below two timesteps to that value "
        "(refsafe): results then depend on the timestep in a way that no integrator explains.",
        "shorten the timestep to half of the time constant, or write the time constant that "
        "MuJoCo uses",
        motion.solref_raised,
    ),
    "solimp_clamped": ModelRule(
        "warning",
        "an impedance above the largest that MuJoCo uses",
        "MuJoCo silently limits impedances to 0.9999, so the constraint is softer than the file "
        "says.",
        "write the value that MuJoCo uses",
        motion.solimp_clamped,
    ),
    "contact_depth": ModelRule(
        "warning",
        "bodies overlap in a state of the file",
        "The run starts with a push that separates them.",
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
        "no keyframe defines an initial state",
        "Whoever opens the file guesses how a run is to start.",
        "add a keyframe, <key name='start'/> if it is the state as opened",
        motion.no_keyframe,
        house=True,
    ),
    "auto_reset": ModelRule(
        "warning",
        "a run that diverges is reset to its start",
        "MuJoCo resets a model that diverges, goes on, and sets its controls to zero: a crashed "
        "run looks like one that came to rest. The counter of warnings stays at 1.",
        'write <option><flag autoreset="disable"/></option>',
        motion.auto_reset,
        house=True,
    ),
    "clock_rounding": ModelRule(
        "note",
        MEANINGS["clock_rounding"],
        "The time of the model is a sum of steps. Unless the step is a power of two, it drifts: "
        "by 4e-11 s in 1e5 steps, which limits a comparison with a reference to nine digits.",
        "choose the nearest power of two",
        motion.clock_rounding,
        house=True,
    ),
    "energy_off": ModelRule(
        "note",
        "a conservative model does not record its energy",
        "Without sources and losses, the drift of the energy is the error of the integration, "
        "at no cost.",
        'write <option><flag energy="enable"/></option>',
        motion.energy_off,
        house=True,
    ),
    "ill_conditioned": ModelRule(
        "warning",
        MEANINGS["ill_conditioned"],
        "Accelerations lose as many digits as the condition number of the mass matrix has. The "
        "matrix is scaled by its diagonal, so that light and heavy parts next to each other do "
        "not count.",
        "look for chains of very unequal masses, and for joints that nearly do the same",
        motion.ill_conditioned,
        needs="modes",
    ),
    "idle_gravity": ModelRule(
        "note",
        "gravity moves nothing",
        "No joint moves under gravity in any configuration that was tried.",
        'write gravity="0 0 0"',
        motion.idle_gravity,
        house=True,
    ),
    # parts
    "welded_body": ModelRule(
        "note",
        "a body without joint at the end of a branch",
        "It is a part of its parent, and MuJoCo treats it so; as a separate body it costs a "
        "frame, and conceals where the mass is.",
        "move its geoms and its mass to its parent",
        parts.welded_body,
        house=True,
    ),
    "empty_body": ModelRule(
        "note",
        "a body without mass, geoms, sites and children",
        "It has no effect.",
        "remove it",
        parts.empty_body,
        house=True,
    ),
    "locked_joint": ModelRule(
        "warning",
        "a joint that cannot move",
        "It costs a degree of freedom and a constraint, and yields softly where a rigid "
        "connection would not.",
        "remove the joint and the equality or range that fixes it",
        parts.locked_joint,
    ),
    "idle_joint": ModelRule(
        "warning",
        "a joint that nothing moves",
        "In random states of the rest of the model, nothing accelerates it from rest: no "
        "spring, gravity, actuator or coupling acts on it.",
        "remove it, or add the missing force",
        parts.idle_joint,
    ),
    "contact_unused": ModelRule(
        "warning",
        "contact is on, and nothing can touch",
        "Collision detection runs in every step without effect; whoever adds a geom gets "
        "unintended contacts.",
        'write <option><flag contact="disable"/></option>',
        parts.contact_unused,
        house=True,
    ),
    "geom_never_touches": ModelRule(
        "note",
        "a geom for contact without a partner",
        "Its contype and conaffinity allow contact, but match no other geom.",
        'write contype="0" conaffinity="0", or the intended bits',
        parts.geom_never_touches,
        house=True,
    ),
    "contact_leftovers": ModelRule(
        "note",
        "a pair or an exclusion without effect",
        "It concerns a contact that cannot occur.",
        "remove it",
        parts.contact_leftovers,
        house=True,
    ),
    "geom_mass": ModelRule(
        "note",
        "a mass or density of a geom next to an explicit inertial",
        "A body with an <inertial> ignores the masses of its geoms; a reader expects them to "
        "count.",
        "remove the attribute, or the <inertial>",
        parts.geom_mass,
        house=True,
    ),
    "inertia_floor": ModelRule(
        "warning",
        MEANINGS["inertia_floor"],
        "MuJoCo refuses inertias of 1e-15 and less, so that a point mass needs one. The motion "
        "of a joint with almost no inertia is round-off.",
        "check that its drive is heavier by many orders of magnitude, and waive it; else give "
        "it inertia",
        parts.inertia_floor,
        needs="modes",
    ),
    "inertia_raised": ModelRule(
        "warning",
        "the compiler changes masses or inertias",
        "The simulated masses or inertias are not those of the file.",
        "write the intended inertias, and remove the setting",
        parts.inertia_raised,
    ),
    "merged_centre": ModelRule(
        "warning",
        "MuJoCo moves a centre of mass",
        "MuJoCo silently moves a centre of mass within 1e-6 m of the body's frame to its "
        "origin, whatever the size of the model.",
        "choose a larger unit of length, or put it at 0",
        parts.merged_centre,
    ),
    "huge_armature": ModelRule(
        "warning",
        "an armature that dominates the inertia that its joint moves",
        "Armature is added to the inertia of a joint, not of a body. It does not damp motion "
        "but slows it down: loads on the link hardly move the joint. It often takes the place "
        "of a shorter step.",
        "use the rotor's inertia times the gear ratio squared; waive the finding if it is that",
        parts.huge_armature,
        needs="modes",
        house=True,
    ),
    "negative_damping": ModelRule(
        "warning",
        "a damper that adds energy",
        "It lets motions grow.",
        "reverse its sign, or waive it if a source of energy is intended",
        parts.negative_damping,
    ),
    "range_ignored": ModelRule(
        "warning",
        "a range without effect",
        "A range counts only if its lower end is below its upper one, and limits are not "
        "switched off; MuJoCo does not report it otherwise.",
        'give a range from low to high, and remove limited="false"',
        parts.range_ignored,
    ),
    "idle_actuator": ModelRule(
        "warning",
        "an actuator whose force is always 0",
        "It has neither a gain nor a bias, or no gear.",
        "give it a gain or a bias, or remove it",
        parts.idle_actuator,
    ),
    "idle_tendon": ModelRule(
        "note",
        "a tendon without effect",
        "It is evaluated in every step, and exerts no force.",
        "remove it",
        parts.idle_tendon,
        house=True,
    ),
    "duplicate_sensor": ModelRule(
        "note",
        "two sensors that measure the same",
        "Both give the same numbers.",
        "remove one",
        parts.duplicate_sensor,
        house=True,
    ),
    "unused_asset": ModelRule(
        "note",
        "an asset that nothing uses",
        "It is loaded with the file, and not used.",
        "remove it",
        parts.unused_asset,
        house=True,
    ),
    "unused_site": ModelRule(
        "note",
        "a site that nothing refers to",
        "Sites serve sensors, tendons, actuators and closures.",
        "remove it, or waive it if a program uses it",
        parts.unused_site,
        house=True,
    ),
    "inactive_equality": ModelRule(
        "note",
        "an inactive equality",
        "It has no effect until a program activates it.",
        "remove it, or waive it if a program activates it",
        parts.inactive_equality,
        house=True,
    ),
    "switched_off": ModelRule(
        "warning",
        "a flag switches off parts of the model",
        "The file has parts that do not act.",
        "remove the flag, or the parts",
        parts.switched_off,
    ),
    "compiler_warning": ModelRule(
        "warning",
        "MuJoCo warned as it read the file",
        "MuJoCo continues, and the model may not be the intended one.",
        "follow the warning",
        parts.compiler_warning,
    ),
    # masses and drives
    "odd_inertia": ModelRule(
        "warning",
        "an inertia that no body of this mass and size has",
        "The radius of gyration, sqrt(I / m), lies within a body. If it is larger, or almost "
        "zero, inertia and mass have different units, for example after an export in g mm^2.",
        "convert the inertia to kg m^2 and the mass to kg",
        parts.odd_inertia,
    ),
    "far_centre": ModelRule(
        "warning",
        "a centre of mass far from the body's geoms",
        "It is given in the frame of the body; a value in another frame, or in millimetres, is "
        "far from the body.",
        "give it in the body's frame, in metres",
        parts.far_centre,
    ),
    "odd_density": ModelRule(
        "warning",
        "a body denser than any material, or lighter than air",
        "The mass belongs to another size, or has another unit.",
        "give the mass in kg, and the geoms in metres",
        parts.odd_density,
    ),
    "uneven_masses": ModelRule(
        "note",
        "a light body that carries a very heavy one",
        f"If its mass is more than {THRESHOLDS.max_carried_mass:,.0f} times that of the light "
        "body, whose joints have no armature, forces on it turn the light body by far more than "
        "any step resolves, and contact solvers converge slowly.",
        "give the light body its mass, or its joint armature",
        parts.uneven_masses,
    ),
    "always_touching": ModelRule(
        "warning",
        "geoms of one mechanism that overlap in all positions of its joints",
        "A contact that never ends blocks the joint between them, or makes it vibrate.",
        "exclude the pair of bodies from contact, or make the geoms smaller",
        partial(parts.overlapping, always=True),
        needs="states",
    ),
    "self_collision": ModelRule(
        "note",
        "geoms of one mechanism that touch within the ranges of its joints",
        "Ranges of joints in which parts touch are wider than the mechanism allows: a "
        "controller that relies on them runs into contact. Random positions show it; others "
        "may, too.",
        "narrow the ranges, or waive it if the controller takes it into account",
        partial(parts.overlapping, always=False),
        needs="states",
        house=True,
    ),
    "light_joint": ModelRule(
        "warning",
        "a joint too light for the force that drives it",
        "In one step of full force it turns by more than half a turn, or slides by more than "
        "the size of the model: no integrator resolves that.",
        "give it armature (the rotor's inertia times the gear ratio squared), or a smaller "
        "forcerange",
        drives.light_joint,
    ),
    "unlimited_joint": ModelRule(
        "note",
        "a joint without a limit that a servo moves within a range",
        "The range of a control limits the command, not the position to which a load moves the "
        "joint.",
        "give the joint the range of the mechanism",
        drives.unlimited_joint,
    ),
    "control_in_degrees": ModelRule(
        "warning",
        "a range of control in degrees",
        "The compiler converts angles of joints, not controls: these are in radians.",
        "write the range in radians",
        drives.control_in_degrees,
    ),
    "control_beyond_range": ModelRule(
        "warning",
        "a servo whose commands exceed the range of its hinge",
        "It pushes into the joint's limit with all its force, and the soft limit yields.",
        'write the range of the joint, times the gear, or inheritrange="1" in its place',
        drives.control_beyond_range,
    ),
    "positive_feedback": ModelRule(
        "warning",
        "a servo that amplifies the motion that it should resist",
        "Its bias has the wrong sign: it increases every deviation.",
        "reverse the sign of kp or kv, of biasprm for a general actuator",
        drives.positive_feedback,
    ),
    "undamped_servo": ModelRule(
        "warning",
        "a servo with almost no damping",
        "All that acts on the joint damps it by less than 2 % of critical damping, and nothing "
        "has friction: each command starts an oscillation of tens of periods.",
        'write dampratio="1" on the position actuator, or damping on the joint',
        drives.undamped_servo,
    ),
    "two_servos": ModelRule(
        "warning",
        "two actuators that position, or drive, the same joint",
        "Two servos pull it each to its own control, and a program that sets one leaves the "
        "other at 0. The forces of two motors add.",
        "remove one",
        drives.two_servos,
    ),
    "saturated_actuator": ModelRule(
        "warning",
        "an actuator whose load in a state of rest exceeds its largest force",
        "Whatever its control, its joint sags.",
        "raise forcerange, or ctrlrange of a motor, or choose a state that needs less force",
        drives.saturated_actuator,
        needs="states",
    ),
    "control_not_holding": ModelRule(
        "warning",
        "a state of rest that its controls do not keep",
        "A run from there starts with a jump: the control commands another position, or the "
        "gain is too low for the load.",
        "give the keyframe the ctrl that keeps it: its joint positions, plus the effect of the "
        "load; or raise the gain",
        drives.control_not_holding,
        needs="states",
    ),
    "spring_beyond_range": ModelRule(
        "note",
        "a spring that rests beyond the joint's limits",
        "It presses the joint against its limit; springref counts from the joint's 0, in the "
        "compiler's unit.",
        "put springref within the range; waive it if the preload is intended",
        drives.spring_beyond_range,
    ),
    "zero_quaternion": ModelRule(
        "warning",
        "a keyframe with a quaternion whose norm is not 1",
        "The body silently starts with another orientation than the numbers say.",
        "write 1 0 0 0 for no rotation",
        drives.zero_quaternion,
    ),
    # text
    "unused_class": ModelRule(
        "note",
        "a class of defaults that no element has",
        "It has no effect, and a reader searches for its elements.",
        "remove it",
        text.unused_class,
        house=True,
    ),
    "unused_option": ModelRule(
        "note",
        "an option without effect",
        "It suggests that something depends on it.",
        "remove it",
        text.unused_option,
        house=True,
    ),
    "unused_setting": ModelRule(
        "note",
        "an attribute without effect on its element",
        "It suggests that something depends on it.",
        "remove it, or give the element the part to which it belongs",
        text.unused_setting,
        house=True,
    ),
    "implicit_degrees": ModelRule(
        "note",
        "angles without a unit",
        "MJCF angles are in degrees by default, while MuJoCo's API, sensors and keyframes use "
        "radians.",
        'write <compiler angle="radian"/>, or angle="degree" to confirm degrees',
        text.implicit_degrees,
        house=True,
    ),
    "angle_unit": ModelRule(
        "warning",
        "angles that are probably in the other unit",
        "A range of more than two turns, or of less than four degrees, is mostly a mistake of "
        "the unit.",
        "convert the range, or change the compiler's angle",
        text.angle_unit,
    ),
    # rules that need all findings
    "repeated_default": ModelRule(
        "note",
        "an attribute that changes nothing",
        "Without it the file compiles to the same bytes: it repeats a default, or is not used. "
        "A reader has to compare repeated values.",
        "remove it; waive it if a program replaces the value",
        needs="findings",
        house=True,
    ),
    "waiver_reason": ModelRule(
        "error",
        "a waiver that cannot be read, or has no reason",
        "A waiver without its reason conceals the mistake.",
        "write <!-- mbcheck: allow RULE, element: reason -->",
        needs="findings",
    ),
    "waiver_unknown": ModelRule(
        "error",
        "a waiver of an unknown rule",
        "It allows nothing; the rule may have another name.",
        "use the id of a rule, as findings show it",
        needs="findings",
    ),
    "waiver_unused": ModelRule(
        "warning",
        "a waiver that waives nothing",
        "The mistake is mended, or the waiver names another element.",
        "remove it",
        needs="findings",
    ),
}
"""Rules by id, in the order of reports."""
