"""What MuJoCo does beside simulating, and where that is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....reference.scene import Case
from ..equations import scene_equations
from ..mujoco.library import warnings
from ..run import contained
from .catalogue import Observation, Outcome
from .mujoco import MujocoAdapter, raw

NEGLIGIBLE = 1e-9
"""Relative error, or phase [rad], that counts as none."""

LOG = "MUJOCO_LOG.TXT"


def energy_before_forward(case: Case, model: str) -> Observation:
    """Read MuJoCo's energy right after the state is set, before and after `mj_forward`."""
    library, compiled, data = raw(case, model)
    compiled.opt.enableflags |= int(library.mjtEnableBit.mjENBL_ENERGY)
    before = float(np.sum(data.energy))
    library.mj_forward(compiled, data)
    after = float(np.sum(data.energy))
    equations = scene_equations(case)
    scene, state = equations.scene, equations.start(case)
    right = float(scene.energy(state[:2], state[2:], scene.coefficients(equations.parameters)))
    error = abs(before - right) / right
    return Observation(
        "wrong" if error > NEGLIGIBLE else "right",
        f"MuJoCo shows {before:.6g} J before mj_forward and {after:.6g} J after it, where the "
        f"state has {right:.6g} J: nobody but the reference sees it",
        error,
        abs(after - right) / right,
    )


def transition_matrix(case: Case, model: str) -> Observation:
    """Ask MuJoCo for the transition matrix of RK4."""
    library, compiled, data = raw(case, model)
    compiled.opt.integrator = library.mjtIntegrator.mjINT_RK4
    matrix = np.zeros((2 * compiled.nv, 2 * compiled.nv))
    try:
        library.mjd_transitionFD(compiled, data, 1e-6, True, matrix, None, None, None)
    except Exception as error:  # of any class
        words = f"{type(error).__name__}: {str(error).splitlines()[0]}"
        return Observation("refused", f"the engine refuses: {words}")
    return Observation("right", "MuJoCo takes RK4 here")


def lost_inertia(case: Case, model: str) -> Observation:
    """Add a body without ``ipos`` to the model, write it and read it again."""
    engine = MujocoAdapter()
    library = engine.inner.mujoco
    spec = library.MjSpec.from_string(engine.text(case, model))
    body = spec.worldbody.add_body(name="added", mass=2.0, inertia=[1.0, 1.0, 1.0])
    body.explicitinertial = True
    body.add_joint(name="free_slide", type=library.mjtJoint.mjJNT_SLIDE)
    mass = float(spec.compile().body("added").mass[0])
    changed: dict[str, float | str] = {"body.mass": mass, "body.ipos": "not set"}
    try:
        again = float(library.MjModel.from_xml_string(spec.to_xml()).body("added").mass[0])
    except ValueError as error:
        words = " ".join(str(error).split())[:160]
        reason = f"the engine refuses what it wrote itself: {words}"
        return Observation("failed", reason, changed=changed)
    reason = f"a mass of {mass:g} kg is read back as {again:g} kg"
    outcome: Outcome = "wrong" if again != mass else "right"
    return Observation(outcome, reason, abs(again - mass) / mass, 0.0, changed)


def clock_rounding(case: Case, model: str) -> Observation:
    """Step MuJoCo 200,000 times by a step that is no power of two, and read its clock."""
    engine, drift = MujocoAdapter(), []
    method = next(one for one in engine.methods if one.name == "Euler")
    for step in (1e-3, 2**-10):
        end = np.array([200_000 * step])
        with contained():
            clock = engine.simulate(case, model, method, step, end).clock
        drift.append(float(abs(clock[0] - end[0])))
    phase = 2 * np.pi * case.parameters.force_frequency * drift[0]
    return Observation(
        "wrong" if phase > NEGLIGIBLE else "right",
        f"after 200000 steps the clock is {drift[0]:.2g} s off with h = 1e-3 s, "
        f"{drift[1]:.2g} s with 2^-10: a phase of {phase:.2g} rad for a force that reads it",
        phase,
        0.0,
        values={"clock_drift": drift[0]},
    )


def log_file(case: Case, model: str) -> Observation:
    """Let MuJoCo log an unstable run as it does by default, and look into the working directory."""
    with contained():
        library, compiled, data = raw(case, model, timestep=1024.0)
        library.mj_step(compiled, data, nstep=100)
        counted = {name: count for name, count in warnings(library, data).items() if count}
        written = sorted(path.name for path in Path().iterdir())
    reason = (
        f"an unstable run ({', '.join(counted)}) leaves {', '.join(written) or 'nothing'} in "
        "the working directory"
    )
    outcome: Outcome = "failed" if LOG in written else "right"
    return Observation(outcome, reason, values={"files": float(len(written))})
