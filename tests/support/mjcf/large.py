"""Larger MJCF models, in the style of public ones, that inspection must take."""

from __future__ import annotations

import math
import struct
from pathlib import Path

HEAD = """<mujoco model="{name}">
  <compiler angle="radian"/>
  <option timestep="{step}" integrator="{integrator}">
    <flag autoreset="disable"/>
  </option>
"""


def head(name: str, step: float = 2**-9, integrator: str = "implicitfast") -> str:
    """Return the beginning of a model."""
    return HEAD.format(name=name, step=step, integrator=integrator)


def chain(count: int, joint: str = 'type="hinge" axis="0 1 0" stiffness="40" damping="0.2"') -> str:
    """Return a chain of rods that hangs from the world, its hinges sprung."""
    rod = (
        '<body name="rod_{i}" pos="0 0 {at}"><joint name="joint_{i}" {joint}/>'
        '<geom name="rod_{i}" type="capsule" size="0.01" fromto="0 0 0 0 0 -0.05" mass="0.02"/>'
    )
    bodies = "\n".join(
        rod.format(i=i, at=0 if i == 1 else -0.05, joint=joint) for i in range(1, count + 1)
    )
    return (
        head(f"chain of {count}", 2**-13)
        + f"<worldbody>\n{bodies}\n{'</body>' * count}\n</worldbody>\n"
        + '<keyframe><key name="hanging"/></keyframe>\n</mujoco>\n'
    )


def heap(count: int) -> str:
    """Return free bodies of all shapes that lie on and in each other on a floor."""
    shapes = (
        'type="box" size="0.1 0.08 0.05"',
        'type="sphere" size="0.08"',
        'type="capsule" size="0.05 0.06"',
        'type="ellipsoid" size="0.1 0.06 0.05"',
        'type="cylinder" size="0.06 0.05"',
    )
    side = math.ceil(count ** (1 / 3))
    bodies = "\n".join(
        f'<body pos="{0.14 * (i % side):.3g} {0.14 * (i // side % side):.3g} '
        f'{0.05 + 0.12 * (i // side**2):.3g}"><freejoint/><geom {shapes[i % len(shapes)]}/></body>'
        for i in range(count)
    )
    return (
        head(f"heap of {count}")
        + f'<worldbody><geom type="plane" size="5 5 0.1"/>\n{bodies}\n</worldbody>\n'
        + '<keyframe><key name="thrown"/></keyframe>\n</mujoco>\n'
    )


LIMB = """
      <body name="{side}_thigh" pos="0 {y} -0.1">
        <joint name="{side}_hip" type="ball" damping="2" stiffness="8"/>
        <geom class="limb" fromto="0 0 0 0 0 -0.38" size="0.05"/>
        <site name="{side}_hip_front" pos="0.06 0 -0.05"/>
        <body name="{side}_shin" pos="0 0 -0.4">
          <joint name="{side}_knee" axis="0 1 0" range="-2.6 0.1"/>
          <geom class="limb" fromto="0 0 0 0 0 -0.36" size="0.04"/>
          <geom name="{side}_kneecap" type="sphere" class="wrap" size="0.045"/>
          <site name="{side}_kneecap" pos="0.07 0 0"/>
          <site name="{side}_shin_front" pos="0.05 0 -0.1"/>
          <body name="{side}_foot" pos="0 0 -0.38">
            <joint name="{side}_ankle" axis="0 1 0" range="-0.8 0.8"/>
            <joint name="{side}_roll" axis="1 0 0" range="-0.5 0.5"/>
            <geom class="foot" type="mesh" mesh="foot"/>
            <site name="{side}_sole"/>
          </body>
        </body>
      </body>"""

HUMANOID = (
    head("humanoid", 2**-9)
    + """
  <default>
    <joint damping="1" armature="0.01" stiffness="3"/>
    <geom condim="3" friction="0.8 0.02 0.01" rgba="0.8 0.6 0.4 1"/>
    <default class="limb"><geom type="capsule" density="900"/></default>
    <default class="foot"><geom density="800" rgba="0.2 0.2 0.3 1"/></default>
    <default class="wrap">
      <geom contype="0" conaffinity="0" mass="0" rgba="0.2 0.6 0.3 0.4"/>
    </default>
    <position kp="40" ctrlrange="-1 1"/>
  </default>
  <asset>
    <mesh name="foot" file="foot.stl" scale="0.5 0.5 0.5"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="4 4 0.1"/>
    <body name="pelvis" pos="0 0 1.02">
      <freejoint name="root"/>
      <geom class="limb" fromto="0 -0.08 0 0 0.08 0" size="0.1"/>
      <site name="imu"/>
      {left}
      {right}
      <body name="trunk" pos="0 0 0.12">
        <joint name="waist" type="ball" stiffness="300" damping="10"/>
        <geom class="limb" fromto="0 0 0 0 0 0.35" size="0.12"/>
      </body>
    </body>
    <body name="crank" pos="1 1 0.5">
      <joint name="crank" axis="0 1 0"/>
      <geom class="limb" fromto="0 0 0 0.2 0 0" size="0.02"/>
      <site name="crank_pin" pos="0.2 0 0"/>
    </body>
    <body name="slider" pos="1.2 1 0.5">
      <joint name="slider_x" type="slide" axis="1 0 0"/>
      <joint name="slider_z" type="slide" axis="0 0 1"/>
      <geom class="limb" type="box" size="0.04 0.04 0.04"/>
      <site name="slider_pin"/>
    </body>
    <body name="load" pos="-1 0 0.6">
      <freejoint name="load"/>
      <geom class="limb" type="box" size="0.1 0.1 0.1"/>
    </body>
    <body name="hook" pos="-1 0 0.9">
      <joint name="hook" type="slide" axis="0 0 1" stiffness="2000" damping="50"/>
      <geom class="limb" type="sphere" size="0.05"/>
    </body>
  </worldbody>
  <contact>
    <exclude body1="crank" body2="slider"/>
    <exclude body1="pelvis" body2="trunk"/>
    <exclude body1="load" body2="hook"/>
  </contact>
  <tendon>
    <spatial name="left_quad" stiffness="900" damping="5" springlength="0.4">
      <site site="left_hip_front"/>
      <geom geom="left_kneecap" sidesite="left_kneecap"/>
      <site site="left_shin_front"/>
    </spatial>
    <spatial name="right_quad" range="0 0.6">
      <site site="right_hip_front"/>
      <geom geom="right_kneecap" sidesite="right_kneecap"/>
      <site site="right_shin_front"/>
    </spatial>
    <fixed name="knees">
      <joint joint="left_knee" coef="1"/><joint joint="right_knee" coef="-1"/>
    </fixed>
    <fixed name="ankles"><joint joint="left_ankle" coef="1"/></fixed>
  </tendon>
  <equality>
    <connect name="pin" site1="crank_pin" site2="slider_pin"/>
    <weld name="hold" body1="load" body2="hook"/>
    <joint name="rolls" joint1="left_roll" joint2="right_roll" polycoef="0 -1 0 0 0"/>
    <tendon name="gait" tendon1="knees" tendon2="ankles" polycoef="0 0.1 0 0 0"/>
  </equality>
  <actuator>
    <position name="knee" joint="left_knee"/>
    <motor name="quad" tendon="right_quad" ctrlrange="0 200"/>
  </actuator>
  <sensor>
    <subtreecom name="balance" body="pelvis"/>
  </sensor>
  <keyframe>
    <key name="standing"/>
    <key name="crouched" qpos="{crouched}"/>
  </keyframe>
</mujoco>
"""
)


def humanoid(folder: Path) -> Path:
    """Write a floating-base model with meshes, tendons that wrap, and equalities of all types."""
    (folder / "foot.stl").write_bytes(stl())
    left, right = (LIMB.format(side=side, y=y) for side, y in (("left", 0.1), ("right", -0.1)))
    leg = "1 0 0 0 -0.4 0 0"
    parts = ("0 0 0.9 1 0 0 0", leg, leg, "1 0 0 0", "0 0 0", "-1 0 0.6 1 0 0 0", "0")
    crouched = " ".join(parts)
    path = folder / "humanoid.xml"
    text = HUMANOID.replace("{left}", left).replace("{right}", right)
    path.write_text(text.replace("{crouched}", crouched))
    return path


def stl() -> bytes:
    """Return a binary STL of a wedge of 0.4 x 0.16 x 0.1 m: a foot at twice its size."""
    corners = [(x, y, z) for x in (-0.12, 0.28) for y in (-0.08, 0.08) for z in (-0.05, 0.05)]
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    faces += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    records = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(c for corner in face for c in corners[corner]), 0)
        for face in faces
    )
    return b"wedge".ljust(80) + struct.pack("<I", len(faces)) + records
