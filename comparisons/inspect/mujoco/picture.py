"""The process that draws a model: MuJoCo reads ``MUJOCO_GL`` as it is imported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from ....reference.scene import Array

WIDTH, HEIGHT = 640, 480
FRAMES, RATE = 60, 25
"""Of an animation, and how many of them are shown in a second."""

LONGEST = FRAMES / RATE
"""Motion that is shown [s]: in real time, or slowed down."""

TURN = 0.6
"""Largest angle [rad] that a hinge may turn between two frames."""

SHORTEST = 1e-4
"""Motion that is shown at least [s]."""

ACROSS = {0: (180, -10), 1: (90, -10), 2: (90, -75), None: (130, -25)}
"""Azimuth and elevation [deg] of a camera that looks across the plane of an axis' rotation."""

PARALLEL = 0.999
"""Cosine above which axes are parallel."""

SKY = {"rgb1": (1.0, 1.0, 1.0), "rgb2": (0.82, 0.88, 0.94), "width": 64, "height": 384}
"""Behind a model that brings none."""


def draw(request: dict[str, Any]) -> dict[str, str]:
    """Draw a file, and return ``seen``, ``refused`` (nothing to draw) or ``failed`` (no GL)."""
    model = visible(request["file"])
    if not model.ngeom:
        return {"refused": "there is nothing to draw: the model has no geoms"}
    data = start(model)
    model.vis.global_.offwidth = max(WIDTH, model.vis.global_.offwidth)
    model.vis.global_.offheight = max(HEIGHT, model.vis.global_.offheight)
    try:
        renderer = mujoco.Renderer(model, HEIGHT, WIDTH)
    except Exception as error:  # each GL has errors of its own
        return {"failed": f"{type(error).__name__}: {error}"}
    target, camera = Path(request["target"]), looking(model, data)
    origin = f"keyframe {model.key(0).name or 0}" if model.nkey else "it opens"
    if target.suffix == ".png":
        states, seen = [data.qpos.copy()], f"the model as {origin}"
    else:
        states, span, words = motion(model)
        seen = f"{span:.3g} s of motion from {origin}{words}"
    save(target, [picture(model, data, position, renderer, camera) for position in states])
    return {"seen": seen}


def visible(path: str) -> Any:
    """Return the model of a file, with a sky and light where it has none."""
    spec = mujoco.MjSpec.from_file(path)
    if not any(one.type == mujoco.mjtTexture.mjTEXTURE_SKYBOX for one in spec.textures):
        kind = {"type": mujoco.mjtTexture.mjTEXTURE_SKYBOX, "name": "mbcheck sky"}
        spec.add_texture(builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT, **kind, **SKY)
    if not spec.lights:
        spec.visual.headlight.ambient = [0.5, 0.5, 0.5]
    return spec.compile()


def start(model: Any) -> Any:
    """Return data in the first keyframe, or as the model opens."""
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return data


def motion(model: Any) -> tuple[list[Array], float, str]:
    """Return positions (nq,) of each frame, the time they span [s], and what to add in words."""
    hinges = model.jnt_qposadr[model.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE)]
    span = LONGEST
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    while True:
        states, words = run(model, span)
        fastest = np.max(np.abs(np.diff(states, axis=0))[:, hinges], initial=0.0)
        if fastest <= TURN or span <= max(SHORTEST, FRAMES * model.opt.timestep):
            slow = f", {LONGEST / span:.3g} times slowed down" if span < LONGEST else ""
            return states, span, slow + words
        span /= 2


def run(model: Any, span: float) -> tuple[list[Array], str]:
    """Return positions at each frame of a run, as far as it stays finite."""
    data, states = start(model), list[Array]()
    for frame in range(FRAMES):
        while data.time < frame * span / FRAMES - 1e-12:
            mujoco.mj_step(model, data)
            if not np.all(np.isfinite(data.qpos)) or np.max(np.abs(data.qvel), initial=0) > 1e10:
                return states, f"; it diverges at {data.time:.3g} s"
        states.append(data.qpos.copy())
    return states, ""


def looking(model: Any, data: Any) -> Any:
    """Return a camera that sees the whole model, across its plane if it moves in one."""
    seen = (model.geom_rbound > 0) & (model.geom_rbound < 1e3)
    seen |= not np.any(seen)
    cranks = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_SLIDERCRANK)
    places = np.concatenate([data.geom_xpos[seen], data.site_xpos])
    reach = np.zeros(len(places))
    reach[: np.sum(seen)] = model.geom_rbound[seen]
    reach[np.sum(seen) + model.actuator_trnid[cranks, 0]] = model.actuator_cranklength[cranks]
    low = np.min(places - reach[:, None], axis=0)
    high = np.max(places + reach[:, None], axis=0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = (low + high) / 2
    camera.distance = 1.1 * float(np.linalg.norm(high - low))
    camera.azimuth, camera.elevation = ACROSS[plane(model, data)]
    return camera


def plane(model: Any, data: Any) -> int | None:
    """Return the axis (0, 1, 2) of the world about which all hinges turn, if there is one."""
    hinges = model.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE)
    if np.any(model.jnt_type <= int(mujoco.mjtJoint.mjJNT_BALL)) or not np.any(hinges):
        return None
    along = np.min(np.abs(data.xaxis[hinges]), axis=0)
    axis = int(np.argmax(along))
    return axis if along[axis] > PARALLEL else None


def picture(model: Any, data: Any, position: Array, renderer: Any, camera: Any) -> Array:
    """Return an image (HEIGHT, WIDTH, 3) of the model at a position (nq,)."""
    data.qpos[:] = position
    mujoco.mj_forward(model, data)
    renderer.update_scene(data, camera)
    return np.array(renderer.render())


def save(target: Path, frames: list[Array]) -> None:
    """Write an image as PNG, or images as a GIF that repeats."""
    from PIL import Image

    first, *others = map(Image.fromarray, frames)
    more: dict[str, Any] = {
        "save_all": True,
        "append_images": others,
        "duration": round(1000 / RATE),
        "loop": 0,
    }
    first.save(target, optimize=True, **(more if others else {}))
