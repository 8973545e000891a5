"""A pendulum in MJCF, and edits that make the mistake of each rule of inspection."""

from __future__ import annotations

from pathlib import Path

BASE = """<mujoco model="pendulum">
  <compiler angle="radian"/>
  <option timestep="0.0009765625" integrator="RK4">
    <flag contact="disable" autoreset="disable"/>
  </option>
  <worldbody>
    <body name="rod" pos="0 0 1">
      <inertial pos="0 0 -0.5" mass="1" diaginertia="0.1 0.1 0.01"/>
      <joint name="swing" axis="0 1 0" stiffness="5" damping="0.1"/>
      <geom name="rod" type="capsule" size="0.02" fromto="0 0 0 0 0 -1"/>
    </body>
  </worldbody>
  <keyframe>
    <key name="hanging"/>
  </keyframe>
</mujoco>
"""

OPTION = '<option timestep="0.0009765625" integrator="RK4">'
FLAG = '<flag contact="disable" autoreset="disable"/>'
ON = '<flag autoreset="disable"/>'
JOINT = '<joint name="swing" axis="0 1 0" stiffness="5" damping="0.1"/>'
GEOM = '<geom name="rod" type="capsule" size="0.02" fromto="0 0 0 0 0 -1"/>'
INERTIAL = '<inertial pos="0 0 -0.5" mass="1" diaginertia="0.1 0.1 0.01"/>'
WORLD, END = "  <worldbody>", "  </worldbody>"
KEY = '<key name="hanging"/>'
COMPILER = '<compiler angle="radian"/>'
SECOND = (
    '<body name="second" pos="1 0 1">' + INERTIAL + JOINT.replace("swing", "other") + "{}</body>"
)
LOOP = (
    '<body name="arm" pos="0.5 0 0.5"><inertial pos="0 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>'
    '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide"/>'
    '<site name="end" pos="-0.5 0 -0.5"/></body>'
)
TIP = (
    '<body name="tip" pos="0 0 -1"><joint name="tip" axis="0 1 0" stiffness="1" damping="1"/>'
    '<inertial pos="0 0 {}" mass="1" diaginertia="0.1 0.1 0.1"/></body>'
)
TENDON = '<tendon><fixed name="t"{}><joint joint="swing" coef="1"/></fixed></tendon>'
SENSORS = '<sensor><jointpos name="a" joint="swing"/><{} name="b" joint="swing"/></sensor>'
ASSETS = (
    '<asset><material name="blue" rgba="0 0 1 1"/>'
    '<mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
)
TILTED = '<geom name="rod" type="capsule" size="0.02 0.5" euler="9 0 0"/>'
SERVO = (
    '<actuator><general name="servo" joint="swing" gainprm="2" biastype="affine" '
    'biasprm="0 {} 0"/></actuator>'
)
SOLREF = 'solref="-250000 -1000" solimp="0.9999 0.9999 0.001"'


def closed(how: str = SOLREF) -> tuple[tuple[str, str], ...]:
    """Return what closes a loop of the base."""
    connect = f'<connect name="pin" site1="tip" site2="end" {how}/>'
    return (
        (GEOM, GEOM + '<site name="tip" pos="0 0 -1"/>'),
        (END, f"{LOOP}{END}<equality>{connect}</equality>"),
    )


def option(attributes: str) -> tuple[str, str]:
    """Return an option more."""
    return OPTION, OPTION[:-1] + f" {attributes}>"


def joint(attributes: str) -> tuple[str, str]:
    """Return attributes more of the joint."""
    return JOINT, JOINT[:-2] + f" {attributes}/>"


def after(place: str, text: str) -> tuple[str, str]:
    """Return a text more behind a place."""
    return place, place + text


def turned(damping: str) -> tuple[tuple[str, str], ...]:
    """Return servos on the axes of a ball joint, away from their reference."""
    servo = '<position name="{}" joint="swing" kp="200"{}/>'
    servos = servo.format("x", "") + "".join(
        servo.format(axis, f' gear="{gear}"') for axis, gear in (("y", "0 1 0"), ("z", "0 0 1"))
    )
    return (
        (JOINT, f'<joint name="swing" type="ball" damping="{damping}"/>'),
        (INERTIAL, INERTIAL.replace("0.1 0.1 0.01", "0.2 0.2 0.4")),
        (KEY, '<key name="hanging" qpos="0.8253356149 0.5646424734 0 0" ctrl="1.2 0 0"/>'),
        (END, f"{END}<actuator>{servos}</actuator>"),
    )


def spinning(integrator: str) -> tuple[tuple[str, str], ...]:
    """Return a free body that tumbles in the keyframe."""
    body = (
        '<body name="top" pos="9 0 0"><freejoint name="top"/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="0.02 0.03 0.04"/></body>'
    )
    return (
        (OPTION, f'<option timestep="0.0078125"{integrator}>'),
        (END, body + END),
        (KEY, '<key name="hanging" qvel="0 0 0 0 3 60 3"/>'),
    )


def held(*servos: str, key: str = "") -> tuple[tuple[str, str], ...]:
    """Return actuators of the joint, and what the keyframe says beside its name."""
    names = ("one", "two")
    every = "".join(
        f'<{servo.partition(" ")[0]} name="{name}" joint="swing" {servo.partition(" ")[2]}/>'
        for name, servo in zip(names, servos, strict=False)
    )
    acts = (END, f"{END}<actuator>{every}</actuator>")
    return (acts, (KEY, f'<key name="hanging" {key}/>')) if key else (acts,)


LIMITED = (JOINT, JOINT[:-2] + ' range="-1.5 1.5"/>')
BALL = (JOINT, '<joint name="swing" type="ball" stiffness="5" damping="0.1"/>')
CARRIED = '<body name="{}" pos="0 0 {}"><joint name="{}" axis="0 1 0" stiffness="1" damping="1"/>'
BOB = '<inertial pos="0 0 -0.1" mass="1" diaginertia="0.01 0.01 0.01"/>'
OVERLAPPING = (
    f"{CARRIED.format('mid', '-0.5', 'mid')}{BOB}{CARRIED.format('tip', '{}', 'tip')}{BOB}"
    '<geom name="bob" size="0.1" pos="0 0 {}"/></body></body>'
)

SOLID = ((FLAG, ON), after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -2"/>'))
"""With contact, geoms are what a body is, and no drawings."""

Edits = tuple[tuple[str, str], ...]

MISTAKES: dict[str, tuple[Edits, Edits]] = {
    "step_limit": (((OPTION, '<option timestep="2" integrator="RK4">'),), ()),
    "near_step_limit": (
        (
            (OPTION, '<option timestep="0.03125" integrator="RK4">'),
            ('stiffness="5" damping="0.1"', 'stiffness="2400" damping="4"'),
        ),
        (
            (OPTION, '<option timestep="0.00390625" integrator="RK4">'),
            ('stiffness="5" damping="0.1"', 'stiffness="2400" damping="4"'),
        ),
    ),
    "coarse_step": (((OPTION, '<option timestep="0.25" integrator="discrete">'),), ()),
    "unstable_mode": (turned("0.1"), turned("30")),
    "unstable_equilibrium": (
        ((JOINT, JOINT.replace('"5"', '"4"')), (INERTIAL, INERTIAL.replace("-0.5", "0.5"))),
        ((JOINT, JOINT.replace('"5"', '"6"')), (INERTIAL, INERTIAL.replace("-0.5", "0.5"))),
    ),
    "run_fails": (spinning(""), spinning(' integrator="implicitfast"')),
    "not_finite": ((('damping="0.1"', 'damping="inf"'),), ()),
    "closure_softness": (closed('solref="0.2 1"'), closed()),
    "closure_open": (
        (
            *closed(),
            ('<site name="end" pos="-0.5 0 -0.5"/>', '<site name="end" pos="-0.5 0 -0.49"/>'),
        ),
        closed(),
    ),
    "solref_raised": (closed('solref="0.001 1" solimp="0.9999 0.9999 0.001"'), closed()),
    "solimp_clamped": (closed('solref="-250000 -1000" solimp="0.99999 0.99999 0.001"'), closed()),
    "contact_depth": (
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 0.1"/>'),
        ),
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -0.5"/>'),
        ),
    ),
    "keyframe_outside_range": (
        (joint('range="-1 1"'), (KEY, '<key name="hanging" qpos="2"/>')),
        (joint('range="-1 1"'), (KEY, '<key name="hanging" qpos="0.5"/>')),
    ),
    "no_keyframe": (((KEY, ""),), ()),
    "auto_reset": (((FLAG, '<flag contact="disable"/>'),), ()),
    "clock_rounding": (((OPTION, '<option timestep="0.001" integrator="RK4">'),), ()),
    "energy_off": (
        ((' damping="0.1"', ""),),
        ((' damping="0.1"', ""), (FLAG, FLAG[:-2] + ' energy="enable"/>')),
    ),
    "ill_conditioned": (
        (
            (JOINT, '<joint name="swing" axis="0 1 0"/><joint name="again" axis="1e-6 1 0"/>'),
            (FLAG, FLAG[:-2] + ' energy="enable"/>'),
        ),
        (
            (JOINT, '<joint name="swing" axis="0 1 0"/><joint name="again" axis="1 0 0"/>'),
            (FLAG, FLAG[:-2] + ' energy="enable"/>'),
        ),
    ),
    "idle_gravity": (
        (('<joint name="swing" axis="0 1 0"', '<joint name="swing"'),),
        (('<joint name="swing" axis="0 1 0"', '<joint name="swing"'), option('gravity="0 0 0"')),
    ),
    "welded_body": (
        (after(GEOM, '<body name="tip" pos="0 0 -1"><geom size="0.1"/></body>'),),
        (after(GEOM, '<geom size="0.1" pos="0 0 -1"/>'),),
    ),
    "empty_body": ((after(GEOM, '<body name="tip" pos="0 0 -1"/>'),), ()),
    "locked_joint": (
        (after(END, '<equality><joint joint1="swing" solimp="0.999 0.999 0.001"/></equality>'),),
        (),
    ),
    "idle_joint": (
        (
            (
                END,
                '<body name="disc" pos="2 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
                f'<joint name="spin"/></body>{END}',
            ),
        ),
        (
            (
                END,
                '<body name="disc" pos="2 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
                f'<joint name="spin" damping="0.1" stiffness="1"/></body>{END}',
            ),
        ),
    ),
    "contact_unused": (((FLAG, ON),), ()),
    "geom_never_touches": (
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -2"/>'),
            after(GEOM, '<geom name="odd" size="0.1" contype="2" conaffinity="2"/>'),
        ),
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -2"/>'),
            after(GEOM, '<geom name="odd" size="0.1" contype="0" conaffinity="0"/>'),
        ),
    ),
    "contact_leftovers": (
        (
            (END, SECOND.format(GEOM.replace("rod", "other")) + END),
            after(END, '<contact><exclude body1="rod" body2="second"/></contact>'),
        ),
        ((END, SECOND.format(GEOM.replace("rod", "other")) + END),),
    ),
    "geom_mass": (((GEOM, GEOM[:-2] + ' mass="3"/>'),), ()),
    "inertia_floor": (
        ((INERTIAL, '<inertial pos="0 0 -0.5" mass="1" diaginertia="2e-15 2e-15 2e-15"/>'),),
        (),
    ),
    "inertia_raised": (((COMPILER, COMPILER[:-2] + ' boundmass="2"/>'),), ()),
    "merged_centre": ((after(GEOM, TIP.format("5e-7")),), (after(GEOM, TIP.format("5e-6")),)),
    "huge_armature": ((joint('armature="1000"'),), (joint('armature="0.1"'),)),
    "negative_damping": ((('damping="0.1"', 'damping="-0.1"'),), ()),
    "range_ignored": ((joint('range="1 1"'),), (joint('range="-1 1"'),)),
    "idle_actuator": (
        (after(END, '<actuator><general name="motor" joint="swing" gainprm="0"/></actuator>'),),
        (after(END, '<actuator><motor name="motor" joint="swing"/></actuator>'),),
    ),
    "idle_tendon": ((after(END, TENDON.format("")),), (after(END, TENDON.format(' damping="1"')),)),
    "duplicate_sensor": (
        (after(END, SENSORS.format("jointpos")),),
        (after(END, SENSORS.format("jointvel")),),
    ),
    "unused_asset": (
        ((WORLD, ASSETS + WORLD), (GEOM, GEOM + '<geom type="mesh" mesh="m"/>')),
        ((WORLD, ASSETS + WORLD), (GEOM, GEOM + '<geom type="mesh" mesh="m" material="blue"/>')),
    ),
    "unused_site": (
        (after(GEOM, '<site name="tip" pos="0 0 -1"/>'),),
        (
            after(GEOM, '<site name="tip" pos="0 0 -1"/>'),
            after(END, '<sensor><accelerometer name="a" site="tip"/></sensor>'),
        ),
    ),
    "inactive_equality": ((*closed(SOLREF + ' active="false"'),), closed()),
    "switched_off": (((FLAG, FLAG[:-2] + ' damper="disable"/>'),), ()),
    "odd_inertia": (
        (*SOLID, (INERTIAL, INERTIAL.replace("0.1 0.1 0.01", "100 100 10"))),
        (*SOLID, (INERTIAL, INERTIAL.replace("0.1 0.1 0.01", "0.9 0.9 0.09"))),
    ),
    "far_centre": (
        (*SOLID, (INERTIAL, INERTIAL.replace("-0.5", "-2.5"))),
        (*SOLID, (INERTIAL, INERTIAL.replace("-0.5", "-1"))),
    ),
    "odd_density": (
        (*SOLID, (INERTIAL, INERTIAL.replace('mass="1"', 'mass="1000"'))),
        (*SOLID, (INERTIAL, INERTIAL.replace('mass="1"', 'mass="20"'))),
    ),
    "uneven_masses": (
        ((GEOM, TIP.format("-0.1")), (INERTIAL, INERTIAL.replace('mass="1"', 'mass="1e-5"'))),
        ((GEOM, TIP.format("-0.1")), (INERTIAL, INERTIAL.replace('mass="1"', 'mass="1e-3"'))),
    ),
    "always_touching": (
        ((FLAG, ON), after(GEOM, OVERLAPPING.format("0.01", "0.02"))),
        ((FLAG, ON), after(GEOM, OVERLAPPING.format("-0.8", "-0.2"))),
    ),
    "self_collision": (
        ((FLAG, ON), after(GEOM, OVERLAPPING.format("-0.6", "-0.3"))),
        ((FLAG, ON), after(GEOM, OVERLAPPING.format("-2", "-0.2"))),
    ),
    "light_joint": (held('motor forcerange="-2e6 2e6"'), held('motor forcerange="-2e5 2e5"')),
    "unlimited_joint": (
        held('position kp="9" ctrlrange="-1 1"'),
        (LIMITED, *held('position kp="9" ctrlrange="-1 1"')),
    ),
    "control_in_degrees": (
        (LIMITED, *held('position kp="9" ctrlrange="-90 90"')),
        (LIMITED, *held('position kp="9" ctrlrange="-1.57 1.57"')),
    ),
    "control_beyond_range": (
        (LIMITED, *held('position kp="9" ctrlrange="-3 3"')),
        (LIMITED, *held('position kp="9" ctrlrange="-1.6 1.6"')),
    ),
    "positive_feedback": ((after(END, SERVO.format("3")),), (after(END, SERVO.format("-3")),)),
    "undamped_servo": (
        ((' damping="0.1"', ""), *held('position kp="9"')),
        ((' damping="0.1"', ""), *held('position kp="9" kv="1"')),
    ),
    "two_servos": (held('position kp="9"', 'position kp="8"'), held('position kp="9"', "motor")),
    "saturated_actuator": (
        held('position kp="100" kv="1" forcerange="-1 1"', key='qpos="0.5" ctrl="0.55"'),
        held('position kp="100" kv="1" forcerange="-90 90"', key='qpos="0.5" ctrl="0.55"'),
    ),
    "control_not_holding": (
        held('position kp="10"', key='qpos="0.9" ctrl="0.9"'),
        held('position kp="10"', key='qpos="0.9" ctrl="1.73"'),
    ),
    "spring_beyond_range": (
        (joint('range="-1 1" springref="2"'),),
        (joint('range="-1 1" springref="0.5"'),),
    ),
    "zero_quaternion": (
        (BALL, (KEY, '<key name="hanging" qpos="0 0 0 0"/>')),
        (BALL, (KEY, '<key name="hanging" qpos="0.8 0.6 0 0"/>')),
    ),
    "unused_class": (
        (
            (
                WORLD,
                f'<default><default class="odd"><geom rgba="1 0 0 1"/></default></default>{WORLD}',
            ),
        ),
        (
            (
                WORLD,
                f'<default><default class="odd"><geom rgba="1 0 0 1"/></default></default>{WORLD}',
            ),
            (GEOM, GEOM[:-2] + ' class="odd"/>'),
        ),
    ),
    "unused_option": ((option('tolerance="1e-10"'),), ()),
    "unused_setting": (
        (joint('springref="1" margin="0.1"'), (' stiffness="5"', "")),
        ((' stiffness="5"', ""),),
    ),
    "implicit_degrees": (
        ((COMPILER, ""), (GEOM, TILTED)),
        ((COMPILER, '<compiler angle="degree"/>'), (GEOM, TILTED)),
    ),
    "angle_unit": ((joint('range="-90 90"'),), (joint('range="-1.5 1.5"'),)),
    "repeated_default": ((joint('type="hinge"'),), ()),
    "waiver_reason": (((KEY, f"<!-- mbcheck: allow auto_reset: -->{KEY}"),), ()),
    "waiver_unknown": (((KEY, f"<!-- mbcheck: allow autoreset: I want it -->{KEY}"),), ()),
    "waiver_unused": (((KEY, f"<!-- mbcheck: allow auto_reset: I want it -->{KEY}"),), ()),
}
"""Rule -> what makes its mistake, and what mends it; nothing: the base."""

WITH_MODES = (
    "step_limit",
    "near_step_limit",
    "coarse_step",
    "unstable_mode",
    "unstable_equilibrium",
    "not_finite",
    "closure_softness",
    "huge_armature",
    "ill_conditioned",
)
"""Rules that look at small motions; the others are tried without, which is faster."""


def written(folder: Path, *edits: tuple[str, str], text: str = BASE) -> Path:
    """Write the base with edits, each of which applies once."""
    for old, new in edits:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "model.xml"
    path.write_text(text)
    return path
