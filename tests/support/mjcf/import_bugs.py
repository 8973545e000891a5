"""A gripper on a rail, and readings of it by importers that are wrong as public ones were."""

from __future__ import annotations

TEXT = """<mujoco model="gripper">
  <compiler angle="radian"/>
  <option gravity="0 0 -3.7"/>
  <default><equality solref=".008 1.5"/><default class="stiff"><joint stiffness="12"/></default>
  </default>
  <asset><mesh name="wedge" vertex="0 0 0 .1 0 0 0 .07 0 0 0 .05"/></asset>
  <worldbody>
    <body name="cart" pos="0 0 1.2"><joint name="rail" type="slide" axis="1 0 0" damping="3.1"
      frictionloss=".4"/><inertial pos="0 0 .02" mass="2.2"
      diaginertia=".03 .04 .05"/>
      <body name="column" pos="0 .1 .3" quat=".96 .1 .2 .15"><joint name="turn" axis="0 0 1"
        pos="0 .05 0" springdamper=".3 .7" range="-1.1 .8" limited="true"/><geom
        name="column_geom" type="box" size=".05 .04 .2" mass="1.1"/>
        <body name="elbow" pos="0 .2 .25"><joint name="bend" class="stiff" axis="0 1 0" ref=".35"
          springref=".15" armature=".013" actuatorfrcrange="-6 6"/><geom name="elbow_geom"
          type="capsule" size=".03" fromto="0 0 0 0 .3 0" mass=".6"/>
          <body name="link7" pos="0 .3 0"><joint name="twist" axis="0 1 0" armature="1e-4"
            damping=".05"/>
            <inertial pos="0 0 0" mass=".08" diaginertia="2e-7 2e-7 2e-7"/>
            <body name="left" pos=".02 .05 0"><joint name="left_finger" type="slide" axis="1 0 0"
              damping="4"/><geom name="left_geom" type="mesh" mesh="wedge" density="800"/></body>
            <body name="right" pos="-.02 .05 0"><joint name="right_finger" type="slide"
              axis="-1 0 0" damping="4"/><geom name="right_geom" type="box" size=".01 .03 .01"
              mass=".05" friction=".6 .01 .001"/></body>
          </body>
        </body>
      </body>
    </body>
    <body name="drone" pos="1 2 3" gravcomp=".8"><joint name="hover" type="free" damping=".3"/>
      <inertial pos=".01 0 0" mass=".9" fullinertia=".03 .04 .05 .004 -.003 .002"/></body>
  </worldbody>
  <tendon><fixed name="coupling" stiffness="7" damping=".4"><joint joint="turn" coef="1"/><joint
    joint="bend" coef="-1.5"/></fixed></tendon>
  <equality><joint name="mimic" joint1="right_finger" joint2="left_finger"
    polycoef=".003 .9 0 0 0"/></equality>
  <actuator><position name="servo" joint="bend" kp="35" kv="2.5"/>
    <damper name="brake" joint="rail" kv="6" ctrlrange="0 1.5"/>
    <motor name="hoist" joint="turn" gear="18" ctrlrange="-1.2 1.2" ctrllimited="true"/>
    <general name="grip" joint="left_finger" gainprm="9" biastype="affine" biasprm=".5 -9 -.4"
      forcerange="-8 8" forcelimited="true"/></actuator>
</mujoco>
"""

GRIPPER = " ".join(TEXT.split())

IMPORT_BUGS = {
    "products of inertia dropped": (
        ".03 .04 .05 .004 -.003 .002", ".03 .04 .05 0 0 0", "body drone", "inertia"),
    "damping in degrees": (
        ' damping=".05"', ' damping="2.86479"', "joint twist", "damping"),
    "springdamper dropped": (' springdamper=".3 .7"', "", "joint turn", "stiffness"),
    "damper read as motor": (
        '<damper name="brake" joint="rail" kv="6" ctrlrange="0 1.5"/>',
        '<motor name="brake" joint="rail" ctrlrange="0 1.5"/>', "actuator brake", "gainprm"),
    "default of an equality lost": (
        '<equality solref=".008 1.5"/>', "", "equality mimic", "solref"),
    "class of a default lost": ('"bend" class="stiff"', '"bend"', "joint bend", "stiffness"),
    "tendon dropped": (
        '<tendon><fixed name="coupling" stiffness="7" damping=".4"><joint joint="turn" coef="1"/>'
        '<joint joint="bend" coef="-1.5"/></fixed></tendon>', "", "tendon coupling", ""),
    "tendon's coefficient lost": ('coef="-1.5"', 'coef="1"', "tendon coupling", "coef"),
    "ref lost": (' ref=".35"', "", "joint bend", "ref"),
    "springref lost": (' springref=".15"', "", "joint bend", "springref"),
    "kp read as a motor's gear": (
        '<position name="servo" joint="bend" kp="35" kv="2.5"/>',
        '<motor name="servo" joint="bend" gear="35"/>', "actuator servo", "gear"),
    "kv dropped": (' kv="2.5"', "", "actuator servo", "kv"),
    "bias of a general actuator dropped": (
        ' biastype="affine" biasprm=".5 -9 -.4"', "", "actuator grip", "biasprm"),
    "mass by another density of a mesh": ('density="800"', 'density="1000"', "body left", "mass"),
    "free joint's damping dropped": (
        'type="free" damping=".3"', 'type="free"', "joint hover", "damping"),
    "gravity compensation dropped": (' gravcomp=".8"', "", "body drone", "gravcomp"),
    "mimic on a slide loses its offset": (
        'polycoef=".003 .9 0 0 0"', 'polycoef="0 .9 0 0 0"', "equality mimic", "polycoef"),
    "mimic dropped": (
        '<equality><joint name="mimic" joint1="right_finger" joint2="left_finger" '
        'polycoef=".003 .9 0 0 0"/></equality>', "", "equality mimic", ""),
    "small inertia raised to a floor": (
        'diaginertia="2e-7 2e-7 2e-7"', 'diaginertia="1e-6 1e-6 1e-6"', "body link7", "inertia"),
    "armature dropped": (' armature=".013"', "", "joint bend", "armature"),
    "friction loss dropped": (' frictionloss=".4"', "", "joint rail", "frictionloss"),
    "range in degrees": (
        'range="-1.1 .8"', 'range="-.0191986 .0139626"', "joint turn", "range"),
    "limit of a joint's force lost": (
        ' actuatorfrcrange="-6 6"', "", "joint bend", "actuatorfrcrange"),
    "gear read as 1": (' gear="18"', "", "actuator hoist", "gear"),
    "ctrlrange dropped": (
        ' ctrlrange="-1.2 1.2" ctrllimited="true"', "", "actuator hoist", "ctrlrange"),
    "forcerange dropped": (
        ' forcerange="-8 8" forcelimited="true"', "", "actuator grip", "forcerange"),
    "gravity of the file ignored": (' gravity="0 0 -3.7"', "", "option", "gravity"),
    "quaternion with the scalar last": (
        'quat=".96 .1 .2 .15"', 'quat=".15 .96 .1 .2"', "body column", "quat"),
    "axis with the other sign": ('axis="-1 0 0"', 'axis="1 0 0"', "joint right_finger", "axis"),
    "anchor of a joint dropped": (' pos="0 .05 0"', "", "joint turn", "pos"),
    "centre of mass dropped": (
        'inertial pos=".01 0 0" mass=".9"', 'inertial pos="0 0 0" mass=".9"', "body drone",
        "inertial pos"),
    "actuator on the wrong joint": (
        '"hoist" joint="turn"', '"hoist" joint="twist"', "actuator hoist", "target"),
    "mimic of the wrong joint": (
        'joint2="left_finger"', 'joint2="twist"', "equality mimic", "second element"),
}  # fmt: skip
"""Bug -> text, how it is read, and the element and the attribute that are named first."""

TEXT_OF_COMPILER = """<mujoco model="rig">
  <compiler angle="degree" autolimits="true" boundmass=".01" boundinertia=".0001" eulerseq="zyx"/>
  <default><joint damping=".2"/><default class="arm"><joint armature=".03" damping=".5"/>
    <default class="fore"><joint stiffness="2" frictionloss=".1"/></default></default></default>
  <worldbody>
    <body name="base" pos="0 0 1" euler="20 35 50" childclass="arm"><joint name="yaw" axis="0 0 1"
      range="-70 80"/><geom type="box" size=".1 .06 .05" mass="1.2"/>
      <body name="mid" pos="0 .1 .3"><joint name="lift" class="fore" axis="0 1 0" range="-40 60"/>
        <geom type="capsule" fromto="0 0 0 .3 0 0" size=".03" mass=".4"/><site name="grip"
          pos=".3 0 0"/>
        <body name="tiny" pos=".3 0 0"><joint name="tip" type="slide" axis="1 0 0"/><geom
          size=".01" mass=".001"/></body></body></body>
    <body name="twin" pos="1 0 1" childclass="fore"><joint name="follow" axis="0 1 0"/><geom
      type="box" size=".1 .05 .02" mass=".7"/><site name="anchor" pos="0 .1 0"/></body>
    <body name="load" pos="0 2 1"><freejoint name="free"/><geom type="box" size=".1 .1 .1"
      density="300"/><site name="hook" pos="0 0 .1"/></body>
  </worldbody>
  <tendon><spatial name="rope" springlength=".3 2" stiffness="40" damping="1"><site site="grip"/>
    <site site="hook"/></spatial></tendon>
  <equality><joint name="mimic" joint1="follow" joint2="lift" polycoef=".4 -1.2 0 0 0"/><connect
    name="pin" body1="load" body2="twin" anchor="0 0 .1" active="false"/></equality>
  <actuator><position name="servo" joint="lift" kp="30" inheritrange="1"/><general name="lag"
      joint="yaw" dyntype="filterexact" dynprm=".02" gainprm="7" actearly="true"/>
    <general name="thrust" site="hook" refsite="anchor" gear="0 0 3 0 0 0" gainprm="2"/>
    <motor name="jet" site="hook" gear="0 4 0 0 0 1"/><velocity name="drive" joint="tip" kv="5"/>
  </actuator>
</mujoco>
"""

RIG = " ".join(TEXT_OF_COMPILER.split())

COMPILER_BUGS = {
    "sequence of Euler angles ignored": (' eulerseq="zyx"', "", "body base", "quat"),
    "degrees read as radians": ('angle="degree"', 'angle="radian"', "joint yaw", "range"),
    "least mass ignored": (' boundmass=".01"', "", "body tiny", "mass"),
    "least inertia ignored": (' boundinertia=".0001"', "", "body tiny", "inertia"),
    "masses scaled to a total": ("<compiler ", '<compiler settotalmass="5" ', "body twin", "mass"),
    "nested class ignored": (' class="fore" axis', " axis", "joint lift", "frictionloss"),
    "childclass ignored": (' childclass="fore"', "", "joint follow", "armature"),
    "free joint with the default's damping": (
        '<freejoint name="free"/>', '<joint name="free" type="free"/>', "joint free", "damping"),
    "dead band of a tendon lost": (
        'springlength=".3 2"', 'springlength=".3"', "tendon rope", "springlength"),
    "refsite dropped": (' refsite="anchor"', "", "actuator thrust", "target"),
    "torque of a site dropped": (
        'gear="0 4 0 0 0 1"', 'gear="0 4 0 0 0 0"', "actuator jet", "gear"),
    "inheritrange ignored": (' inheritrange="1"', "", "actuator servo", "ctrlrange"),
    "actearly ignored": (' actearly="true"', "", "actuator lag", "actearly"),
    "exact filter read as filter": ('"filterexact"', '"filter"', "actuator lag", "dyntype"),
    "kv of a speed servo lost": (' kv="5"', "", "actuator drive", "kv"),
    "mimic on a hinge loses its offset": (
        'polycoef=".4 -1.2 0 0 0"', 'polycoef="0 -1.2 0 0 0"', "equality mimic", "polycoef"),
    "inactive equality switched on": (' active="false"', "", "equality pin", "active"),
    "density of a geom lost": (' density="300"', "", "body load", "mass"),
}  # fmt: skip
"""The same of a model that uses the compiler's options, nested classes and sites."""
