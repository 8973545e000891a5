"""A model that has nearly every attribute, and edits of it that importers make silently."""

from __future__ import annotations

TEXT = """<mujoco model="arm">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="implicitfast" cone="elliptic" impratio="5" density="1.2"
    viscosity=".01"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1" condim="4" margin=".002"/>
    <body name="upper" pos="0 0 1" gravcomp=".3">
      <inertial pos=".2 0 .01" mass="1.5" diaginertia=".01 .02 .025" quat=".9 .1 .2 .3"/>
      <joint name="shoulder" axis="0 1 0" damping=".4" armature=".02" range="-2 2"
        limited="true" frictionloss=".05" ref=".1" actuatorfrcrange="-20 20"/>
      <geom name="upper_geom" type="capsule" size=".04" fromto="0 0 0 .4 0 0"/>
      <body name="lower" pos=".4 0 0">
        <joint name="elbow" axis="0 1 0" stiffness="3" springref=".3" damping=".2"
          range="-2.5 2.5" limited="true" solreflimit=".01 1" margin=".01"/>
        <geom name="lower_geom" type="capsule" size=".03" fromto="0 0 0 .35 0 0" friction=".7"
          solref=".01 1" solimp=".8 .9 .01"/>
        <body name="hand" pos=".35 0 0"><joint name="wrist" axis="0 0 1" damping=".05"/><geom
          name="hand_geom" type="box" size=".03 .05 .02" priority="1"/><site name="tip"
          pos=".02 0 0"/></body>
      </body>
    </body>
    <body name="ball" pos=".3 .4 .06"><freejoint name="float"/><geom name="ball_geom"
      type="sphere" size=".07"/><site name="ball_site"/></body>
  </worldbody>
  <tendon><fixed name="couple" stiffness="1.5" damping=".1"><joint joint="shoulder"
    coef="1"/><joint joint="elbow" coef="-.5"/></fixed>
   <spatial name="rope" stiffness="5" springlength=".2" damping=".3" range="0 .9" limited="true"
     frictionloss=".02"><site site="tip"/><site site="ball_site"/></spatial></tendon>
  <equality><joint name="mimic" joint1="wrist" joint2="elbow" polycoef="0 .5 0 0 0"
    solref=".005 1"/></equality>
  <actuator><motor name="m1" joint="shoulder" gear="50" ctrlrange="-1 1" ctrllimited="true"
    forcerange="-30 30" forcelimited="true"/><position name="p1" joint="elbow" kp="20" kv="1"/>
  <general name="f1" tendon="rope" dyntype="filter" dynprm=".1" gainprm="3" actlimited="true"
    actrange="-1 1"/></actuator>
  <contact><exclude body1="upper" body2="hand"/><pair name="bf" geom1="ball_geom" geom2="floor"
    condim="3" friction=".5 .5 .01 .001 .001" solref=".015 1"/></contact>
  <sensor><jointpos name="s1" joint="elbow" cutoff="3"/></sensor>
  <keyframe><key name="home" qpos=".3 -.5 .1 .3 .4 .06 1 0 0 0" ctrl=".2 -.4 .1"/></keyframe>
</mujoco>
"""
"""An arm, a ball on a floor, and a rope between them."""

WHOLE = " ".join(TEXT.split())

LOSSES = (
    (' armature=".02"', "", "joint shoulder", "armature"),
    (' damping=".4"', "", "joint shoulder", "damping"),
    (' frictionloss=".05"', "", "joint shoulder", "frictionloss"),
    (' range="-2 2" limited="true"', "", "joint shoulder", "range"),
    (' ref=".1"', "", "joint shoulder", "ref"),
    (' actuatorfrcrange="-20 20"', "", "joint shoulder", "actuatorfrcrange"),
    (' stiffness="3"', "", "joint elbow", "stiffness"),
    (' springref=".3"', "", "joint elbow", "springref"),
    (' solreflimit=".01 1"', "", "joint elbow", "solreflimit"),
    (' margin=".01"', "", "joint elbow", "margin"),
    ('axis="0 0 1"', 'axis="0 1 0"', "joint wrist", "axis"),
    (' gravcomp=".3"', "", "body upper", "gravcomp"),
    ('quat=".9 .1 .2 .3"', "", "body upper", "inertia"),
    ('diaginertia=".01 .02 .025"', 'diaginertia=".02 .02 .025"', "body upper", "inertia"),
    ('mass="1.5"', 'mass="1.6"', "body upper", "mass"),
    ('inertial pos=".2 0 .01"', 'inertial pos=".2 0 0"', "body upper", "inertial pos"),
    ('body name="lower" pos=".4 0 0"', 'body name="lower" pos=".41 0 0"', "body lower", "pos"),
    (' cone="elliptic"', "", "option", "cone"),
    (' impratio="5"', "", "option", "impratio"),
    (' density="1.2"', "", "option", "density"),
    (' viscosity=".01"', "", "option", "viscosity"),
    ('integrator="implicitfast"', "", "option", "integrator"),
    ('timestep="0.002"', 'timestep="0.004"', "option", "timestep"),
    (' condim="4"', "", "geom floor", "condim"),
    (' margin=".002"', "", "geom floor", "margin"),
    (' friction=".7"', "", "geom lower_geom", "friction"),
    (' solref=".01 1" solimp', " solimp", "geom lower_geom", "solref"),
    (' solimp=".8 .9 .01"', "", "geom lower_geom", "solimp"),
    (' priority="1"', "", "geom hand_geom", "priority"),
    (' size=".07"', ' size=".08"', "geom ball_geom", "size"),
    (' stiffness="1.5"', "", "tendon couple", "stiffness"),
    (' damping=".1"', "", "tendon couple", "damping"),
    ('coef="-.5"', 'coef=".5"', "tendon couple", "coef"),
    (' springlength=".2"', "", "tendon rope", "springlength"),
    (' range="0 .9" limited="true"', "", "tendon rope", "range"),
    (' frictionloss=".02"', "", "tendon rope", "frictionloss"),
    (' damping=".3"', "", "tendon rope", "damping"),
    (' solref=".005 1"', "", "equality mimic", "solref"),
    ('polycoef="0 .5 0 0 0"', 'polycoef="0 1 0 0 0"', "equality mimic", "polycoef"),
    (
        '<joint name="mimic" joint1="wrist" joint2="elbow" polycoef="0 .5 0 0 0" solref=".005 1"/>',
        "",
        "equality mimic",
        "",
    ),
    (' gear="50"', "", "actuator m1", "gear"),
    (' ctrlrange="-1 1" ctrllimited="true"', "", "actuator m1", "ctrlrange"),
    (' forcerange="-30 30" forcelimited="true"', "", "actuator m1", "forcerange"),
    (' kp="20"', ' kp="2"', "actuator p1", "kp"),
    (' kv="1"', "", "actuator p1", "kv"),
    (' dynprm=".1"', "", "actuator f1", "dynprm"),
    (' gainprm="3"', "", "actuator f1", "gainprm"),
    (' actlimited="true" actrange="-1 1"', "", "actuator f1", "actrange"),
    ('dyntype="filter"', 'dyntype="integrator"', "actuator f1", "dyntype"),
    ('<exclude body1="upper" body2="hand"/>', "", "exclude", ""),
    (
        '<pair name="bf" geom1="ball_geom" geom2="floor" condim="3" friction=".5 .5 .01 .001 .001" '
        'solref=".015 1"/>',
        "",
        "pair bf",
        "",
    ),
    (' friction=".5 .5 .01 .001 .001"', "", "pair bf", "friction"),
    ('condim="3"', 'condim="1"', "pair bf", "condim"),
    (' solref=".015 1"', "", "pair bf", "solref"),
    (' ctrl=".2 -.4 .1"', "", "key home", "ctrl"),
    (' cutoff="3"', "", "sensor s1", "cutoff"),
)
"""What is lost or misread: text, text in its place, element, attribute (empty: all of it)."""
