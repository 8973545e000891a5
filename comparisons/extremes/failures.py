"""Every way to fail that is known of an engine and that a scene can provoke, provoked for real.

A failure is data: which engine, undone in what (`engines.variants`), runs which
case by which method and step. What comes of it is computed by `judge`, or, where no simulation is
wrong, by a function of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.errors import ParameterError
from ...reference.scene import Case
from ..checks.rules.cautions import cautions
from ..engines.equations import scene_equations
from ..engines.registry import get_engine
from ..engines.run import contained
from ..engines.setup import Setup
from ..engines.variants.catalogue import Variant, exudyn, mujoco
from .judge import judge
from .parameters import slender
from .row import ENGINE, FAILED, REFERENCE, REFUSED, RIGHT, RULE, WRONG, Row
from .task import Task

SECTION = "failures"

HARDER = (1 - 1e-8, 1 - 1e-8, 0.001, 0.5, 2.0)
"""An impedance above the 0.9999 that MuJoCo takes."""


@dataclass(frozen=True)
class Failure:
    """One way to fail.

    Attributes
    ----------
    name : str
    engine : str
    scene, case, model, method : str
        ``method`` is a name of the engine's, or one that its variant adds.
    step : float
        [s]
    variant : Variant or None
        The engine undone; None for the right one.
    horizon : float
        [s]
    changes : mapping
        Parameters that are changed.
    settings : mapping of str to float or str
        What the variant does, in words of the engine.
    state : mapping or None
        Initial values in place of those of the case.
    """

    name: str
    engine: str
    scene: str
    case: str
    model: str
    method: str
    step: float
    variant: Variant | None = None
    horizon: float = 0.5
    changes: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, float | str] = field(default_factory=dict)
    state: Mapping[str, float] | None = None

    def altered(self) -> Case:
        """Return the case that is run."""
        case = get_scene(self.scene).case(self.case)
        state = case.state if self.state is None else self.state
        changed = case.parameters.replace(**self.changes)
        return replace(case, parameters=changed, state=state)


hoop = partial(Failure, engine="mujoco", scene="hula_hoop", case="spinning_3hz_60n", model="tree")
loop = partial(Failure, engine="mujoco", scene="speed_regulator", case="rotation", horizon=2.0)
tree = partial(
    Failure, engine="exudyn", scene="hula_hoop", case="spinning_3hz_60n", model="kinematic_tree"
)
joints = partial(
    Failure,
    engine="exudyn",
    scene="speed_regulator",
    case="rotation",
    model="redundant",
    horizon=2.0,
)

AUTORESET = ' autoreset="disable"'
OVERDAMPED = {"damping_ratio": 1e4 / (2 * 0.495 * (1000 / 0.495) ** 0.5)}
CHAOS = {
    "force_amplitude": 10.0,
    "force_frequency": 30 / (2 * np.pi),
    "damping_ratio": 0.1 / (2 * 0.495 * (1000 / 0.495) ** 0.5),
    "hinge_damping_ratio": 1e-5 / (0.045 * 0.0025 * (1000 / 0.495) ** 0.5),
}
"""c = 0.1 N s/m and c_m = 1e-5 N m s/rad."""

DEFAULT_NEWTON = {
    "newton.residualMode": 0,
    "newton.relativeTolerance": 1e-8,
    "newton.absoluteTolerance": 1e-10,
}
"""Newton's method stops where it does by default: at a residual in newtons."""

DEFAULT_STEPS = {**DEFAULT_NEWTON, "adaptiveStep": True}
"""The same, and steps may be halved, as by default."""

OWN_ERROR_CONTROL = {"absoluteTolerance": 1e-8, "relativeTolerance": 1e-8}
AUTOMATIC_STEPS = {**OWN_ERROR_CONTROL, "automaticStepSize": True}
"""DOPRI5 has a tolerance, and chooses its steps, as by default."""

NO_DAMPING = {"generalizedAlpha.spectralRadius": 1.0}
NEWMARK = {"generalizedAlpha.useNewmark": True, "generalizedAlpha.useIndex2Constraints": False}

UNDAMPED = (
    ("generalized_alpha_undamped", "GeneralizedAlpha", NO_DAMPING, {"spectralRadius": 1.0}),
    ("newmark_index_3", "TrapezoidalIndex2", NEWMARK, {"useIndex2Constraints": "False"}),
)
"""Methods of index 3 without numerical damping: name, method, changes, settings."""

FAILURES = (
    # MuJoCo: forces and time
    hoop(
        "force_through_ctrl_at_step_start",
        method="RK4",
        step=2**-10,
        variant=mujoco("Controlled", 0.0),
        settings={"ctrl": "at the start of the step"},
    ),
    hoop(
        "force_through_ctrl_at_midpoint",
        method="RK4",
        step=2**-10,
        variant=mujoco("Controlled", 0.5),
        settings={"ctrl": "at the middle of the step"},
    ),
    hoop(
        "ctrl_not_a_number",
        method="RK4",
        step=2**-10,
        variant=mujoco("Controlled", 0.0, float("nan")),
        settings={"ctrl": "nan"},
    ),
    hoop(
        "ctrl_huge",
        method="RK4",
        step=2**-10,
        variant=mujoco("Controlled", 0.0, 1e13),
        settings={"ctrl": 6e14},
    ),
    hoop(
        "ctrl_huge_unwarned",
        method="RK4",
        step=2**-10,
        variant=mujoco("Unwarned", mujoco("Controlled", 0.0, 1e13)),
        settings={"ctrl": 6e14, "warnings": "not read"},
    ),
    hoop("step_no_power_of_two", method="RK4", step=1e-3, settings={}),
    # MuJoCo: instability
    hoop(
        "automatic_reset",
        method="Euler",
        step=2**-3,
        horizon=25.0,
        variant=mujoco("Edited", (AUTORESET, "")),
        settings={"autoreset": "enable"},
    ),
    hoop(
        "automatic_reset_unwarned",
        method="Euler",
        step=2**-3,
        horizon=25.0,
        variant=mujoco("Unwarned", mujoco("Edited", (AUTORESET, ""))),
        settings={"autoreset": "enable", "warnings": "not read"},
    ),
    hoop("huge_damping_explicit", method="RK4", step=2**-10, changes=OVERDAMPED),
    hoop("huge_damping_implicit", method="Euler", step=2**-13, changes=OVERDAMPED),
    hoop(
        "acceleration_above_1e10",
        case="spinning_unforced",
        method="RK4",
        step=2**-25,
        horizon=2**-15,
        changes={"stiffness": 1e12},
        state={"y": 0.1},
    ),
    hoop(
        "speed_above_1e10",
        case="spinning_unforced",
        method="RK4",
        step=2**-46,
        horizon=2**-36,
        state={"theta_dot": 2e10},
    ),
    # MuJoCo: discrete
    hoop("discrete_dissipates", case="free_undamped", method="discrete", step=2**-10),
    hoop("discrete_refused_with_a_clock", method="discrete", step=2**-10),
    hoop("discrete_damps_the_clock", method="discrete", step=2**-10, variant=mujoco("Willing")),
    # MuJoCo: inertia
    hoop(
        "no_inertia",
        method="RK4",
        step=2**-10,
        variant=mujoco("Edited", ("2e-15 2e-15 2e-15", "0 0 0")),
        settings={"diaginertia": 0.0},
    ),
    hoop(
        "inertia_floor",
        method="RK4",
        step=2**-13,
        horizon=0.05,
        changes={"rod_length": 1e-4, "free_mass": 1e-5},
    ),
    hoop(
        "short_frame_taken_for_none",
        case="spinning_unforced",
        method="RK4",
        step=2**-10,
        changes={"rod_length": 9e-7, "inertia_ratio": 1.0},
        state={"theta": 0.3, "theta_dot": 18.0},
    ),
    # MuJoCo: closed loops
    loop(
        "default_closure",
        model="connect",
        method="RK4",
        step=2**-10,
        variant=mujoco("Trusted"),
        settings={"solref": "0.02 1", "claims": "a joint"},
    ),
    loop(
        "closure_softened_by_the_step",
        model="connect",
        method="RK4",
        step=2**-5,
        variant=mujoco("Willing"),
        settings={"solref": "0.02 1"},
    ),
    loop("closure_softened_refused", model="connect", method="RK4", step=2**-5),
    loop(
        "impedance_clamped",
        model="connect",
        method="RK4",
        step=2**-10,
        variant=mujoco("Trusted", ((0.02, 1.0), HARDER)),
        settings={"solimp": "1-1e-8", "claims": "a joint"},
    ),
    loop("hard_closure_long_step", model="connect_hard", method="RK4", step=2**-7),
    loop(
        "cg_at_1e-8",
        model="connect_hard",
        method="RK4",
        step=2**-10,
        variant=mujoco("Edited", ('tolerance="1e-30"', 'tolerance="1e-08" solver="CG"')),
        settings={"solver": "CG", "tolerance": 1e-8},
    ),
    loop(
        "cg_at_1e-2",
        model="connect_hard",
        method="RK4",
        step=2**-10,
        variant=mujoco("Edited", ('tolerance="1e-30"', 'tolerance="0.01" solver="CG"')),
        settings={"solver": "CG", "tolerance": 1e-2},
    ),
    loop(
        "closed_loop_without_mass",
        case="massless_rod_and_slider",
        model="connect",
        method="RK4",
        step=2**-10,
        variant=mujoco("Trusted"),
    ),
    loop(
        "transmission_carries_no_mass",
        model="transmission",
        method="RK4",
        step=2**-10,
        variant=mujoco("Willing"),
    ),
    # Exudyn: explicit solvers
    tree("unstable_is_success", method="RK44", step=2**-10, changes={"stiffness": 1e9}),
    tree("velocity_verlet", method="VelocityVerlet", step=2**-10, variant=exudyn("Willing")),
    tree("dverk6", method="DVERK6", step=2**-10, variant=exudyn("Willing")),
    tree(
        "dopri5_error_control",
        method="DOPRI5",
        step=0.025,
        variant=exudyn("Changed", OWN_ERROR_CONTROL),
        settings={"absoluteTolerance": 1e-8},
    ),
    tree(
        "dopri5_automatic_steps",
        method="DOPRI5",
        step=0.025,
        variant=exudyn("Changed", AUTOMATIC_STEPS),
        settings={"automaticStepSize": "True"},
    ),
    joints("explicit_with_joints", method="RK44", step=2**-10, variant=exudyn("Willing")),
    joints("explicit_with_joints_refused", method="RK44", step=2**-10),
    # Exudyn: Newton's method
    tree(
        "halved_steps",
        method="GeneralizedAlpha",
        step=0.05,
        variant=exudyn("Changed", DEFAULT_STEPS),
        settings={"adaptiveStep": "True"},
    ),
    tree("halved_steps_switched_off", method="GeneralizedAlpha", step=0.05),
    tree(
        "residual_of_a_light_mass",
        model="redundant",
        method="GeneralizedAlpha",
        step=2**-12,
        changes={"free_mass": 4.5e-7},
        variant=exudyn("Changed", DEFAULT_NEWTON),
        settings={"newton.absoluteTolerance": 1e-10},
    ),
    Failure(
        "stalled_newton",
        "exudyn",
        "rotating_beam",
        "spin_up_quick",
        "elements",
        "GeneralizedAlpha",
        2**-8,
        exudyn("Changed", DEFAULT_STEPS),
        0.0625,
        {**slender(1e9), "segments": 16.0},
        {"adaptiveStep": "True", "newton.absoluteTolerance": 1e-10},
    ),
    # Exudyn: constraints
    *(
        tree(
            f"{name}_{how}",
            model="redundant",
            method=method,
            step=2**-12,
            variant=exudyn("Changed", change | more),
            settings={**told, "newton": how},
        )
        for how, more in (("increments", {}), ("residuals", DEFAULT_NEWTON))
        for name, method, change, told in UNDAMPED
    ),
    joints("drift_over_many_turns", method="TrapezoidalIndex2", step=2**-7, horizon=30.0),
    joints(
        "through_the_dead_centre",
        method="GeneralizedAlpha",
        step=2**-8,
        horizon=1.0,
        changes={"crank_radius": 1.25 * (1 - 1e-9)},
        state={"phi": 1.0, "phi_dot": 5.07},
    ),
    # both: chaos
    hoop(
        "chaos",
        method="RK4",
        step=2**-8,
        horizon=3.0,
        changes=CHAOS,
        state={"theta": 0.3, "theta_dot": 30.0},
    ),
    tree(
        "chaos",
        method="RK67",
        step=2**-7,
        horizon=3.0,
        changes=CHAOS,
        state={"theta": 0.3, "theta_dot": 30.0},
    ),
)
"""In the order of the report."""

HARMLESS = (
    "step_no_power_of_two",
    "huge_damping_implicit",
    "residual_of_a_light_mass",
    "drift_over_many_turns",
)
"""Told to fail, or beside one that does, and right: with these versions and in these scenes the
failure does not come about."""


def provoke(number: int) -> list[Row]:
    """Return the row of one of `FAILURES`."""
    failure = FAILURES[number]
    engine = failure.variant.make() if failure.variant else get_engine(failure.engine)
    known = {method.name: method for method in engine.methods}
    return [
        judge(
            SECTION,
            failure.name,
            engine,
            failure.altered(),
            failure.model,
            known[failure.method],
            failure.step,
            {**failure.changes, **(failure.state or {}), **failure.settings},
            horizon=failure.horizon,
        )
    ]


# What is wrong without a run ----------------------------------------------------------------


def plain(
    name: str,
    scene: str,
    model: str,
    method: str | None,
    outcome: str,
    noticed: tuple[str, ...],
    reason: str,
    **more: Any,
) -> list[Row]:
    """Return the one row of something that MuJoCo does beside simulating."""
    told: dict[str, Any] = {"step": None, "changed": {}, "error": None, "predicted": None, **more}
    return [
        Row(
            SECTION,
            scene,
            name,
            "mujoco",
            model,
            method,
            outcome=outcome,
            noticed_by=noticed,
            reason=reason,
            **told,
        )
    ]


def stale_energy() -> list[Row]:
    """Read MuJoCo's energy right after the state is set, before and after `mj_forward`."""
    from ..engines.variants.mujoco import raw

    case = get_scene("hula_hoop").case("free_undamped")
    library, compiled, data = raw(case, "tree")
    compiled.opt.enableflags |= int(library.mjtEnableBit.mjENBL_ENERGY)
    before = float(np.sum(data.energy))
    library.mj_forward(compiled, data)
    after = float(np.sum(data.energy))
    own = scene_equations(case)
    state = own.start(case)
    right = float(own.scene.energy(state[:2], state[2:], own.scene.coefficients(own.parameters)))
    error = abs(before - right) / right
    wrong = error > 1e-9
    return plain(
        "energy_before_mj_forward",
        "hula_hoop",
        "tree",
        None,
        WRONG if wrong else RIGHT,
        (REFERENCE,) if wrong else (),
        f"MuJoCo shows {before:.6g} J before mj_forward and {after:.6g} J after it, where the "
        f"state has {right:.6g} J: nobody but the reference sees it",
        error=error,
        predicted=abs(after - right) / right,
    )


def transition_matrix() -> list[Row]:
    """Ask MuJoCo for the transition matrix of RK4."""
    from ..engines.variants.mujoco import raw

    case = get_scene("hula_hoop").case("spinning_unforced")
    library, compiled, data = raw(case, "tree")
    compiled.opt.integrator = library.mjtIntegrator.mjINT_RK4
    size = 2 * compiled.nv
    found = np.zeros((size, size))
    try:
        library.mjd_transitionFD(compiled, data, 1e-6, True, found, None, None, None)
    except Exception as error:  # of any class
        said = f"the engine refuses: {type(error).__name__}: {str(error).splitlines()[0]}"
        return plain("transition_matrix", "hula_hoop", "tree", "RK4", REFUSED, (ENGINE,), said)
    return plain(
        "transition_matrix", "hula_hoop", "tree", "RK4", RIGHT, (), "MuJoCo takes RK4 here"
    )


def lost_inertia() -> list[Row]:
    """Add a body without ``ipos`` to the model, write it and read it again."""
    from ..engines.mujoco.engine import MujocoEngine
    from ..engines.variants.mujoco import raw

    case = get_scene("hula_hoop").case("spinning_unforced")
    library, _, _ = raw(case, "tree")
    spec = library.MjSpec.from_string(MujocoEngine().text(case, "tree"))
    body = spec.worldbody.add_body(name="added", mass=2.0, inertia=[1.0, 1.0, 1.0])
    body.explicitinertial = True
    body.add_joint(name="free_slide", type=library.mjtJoint.mjJNT_SLIDE)
    mass = float(spec.compile().body("added").mass[0])
    changed = {"body.mass": mass, "body.ipos": "not set"}
    try:
        again = float(library.MjModel.from_xml_string(spec.to_xml()).body("added").mass[0])
    except ValueError as error:
        said = f"the engine refuses what it wrote itself: {' '.join(str(error).split())[:160]}"
        return plain(
            "lost_inertia", "hula_hoop", "tree", None, FAILED, (ENGINE,), said, changed=changed
        )
    wrong = again != mass
    return plain(
        "lost_inertia",
        "hula_hoop",
        "tree",
        None,
        WRONG if wrong else RIGHT,
        (REFERENCE,) if wrong else (),
        f"a mass of {mass:g} kg is read back as {again:g} kg",
        error=abs(again - mass) / mass,
        predicted=0.0,
        changed=changed,
    )


def too_long_crank() -> list[Row]:
    """Give the slider-crank transmission a rod that is shorter than the crank."""
    from ..engines.variants.mujoco import Edited

    case = get_scene("speed_regulator").case("massless_rod_and_slider")
    short = 0.8 * case.parameters.crank_radius
    changed = {"rod_length": short}
    engine = Edited(('cranklength="1.25"', f'cranklength="{short}"'))
    method = next(m for m in engine.methods if m.name == "RK4")
    with contained():
        found = engine.simulate(case, "transmission", method, 2**-10, np.array([1.0, 2.0]))
    finite = all(np.all(np.isfinite(values)) for values in found.values.values())
    silent = finite and not any(found.warnings.values())
    try:
        case.parameters.replace(**changed)
    except ParameterError as error:
        said = f"the adapter refuses: {error}" + (
            f"; MuJoCo runs it without a word, and turns to phi = {found.values['phi'][-1]:.3g} rad"
            if silent
            else ""
        )
        row = plain(
            "crank_longer_than_rod",
            "speed_regulator",
            "transmission",
            "RK4",
            REFUSED,
            (ENGINE,),
            said,
            changed=changed,
        )
        return row
    return plain(
        "crank_longer_than_rod",
        "speed_regulator",
        "transmission",
        "RK4",
        WRONG,
        (REFERENCE,),
        "nobody refuses a crank longer than its rod",
        changed=changed,
    )


def clock_rounding() -> list[Row]:
    """Step MuJoCo 200,000 times by a step that is no power of two, and read its clock."""
    case = get_scene("hula_hoop").case("spinning_3hz_60n")
    engine = get_engine("mujoco")
    method = next(m for m in engine.methods if m.name == "Euler")
    drift = {}
    warned = cautions(Setup(engine, case, "tree", method, 1e-3), 200.0)
    noticed = tuple(f"{RULE}{name}" for name in dict.fromkeys(item.rule for item in warned))
    for step in (1e-3, 2**-10):
        end = np.array([200_000 * step])
        with contained():
            found = engine.simulate(case, "tree", method, step, end)
        drift[step] = float(abs(found.clock[0] - end[0]))
    phase = 2 * np.pi * case.parameters.force_frequency * drift[1e-3]
    wrong = phase > 1e-9
    return plain(
        "clock_rounding",
        "hula_hoop",
        "tree",
        "Euler",
        WRONG if wrong else RIGHT,
        (*noticed, REFERENCE) if wrong else (),
        f"after 200000 steps the clock is {drift[1e-3]:.2g} s off with h = 1e-3 s, "
        f"{drift[2**-10]:.2g} s with 2^-10: a phase of {phase:.2g} rad for a force that reads it",
        step=1e-3,
        error=phase,
        predicted=0.0,
        values={"clock_drift": drift[1e-3]},
    )


LOG = "MUJOCO_LOG.TXT"


def log_file() -> list[Row]:
    """Let MuJoCo log an unstable run as it does by default, and look into the working directory."""
    from ..engines.mujoco.runs import warnings
    from ..engines.variants.mujoco import raw

    case = get_scene("hula_hoop").case("spinning_unforced")
    with contained():
        library, compiled, data = raw(case, "tree", timestep=1024.0)
        library.mj_step(compiled, data, nstep=100)
        counted = {name: count for name, count in warnings(library, data).items() if count}
        written = sorted(path.name for path in Path().iterdir())
    logged = LOG in written
    return plain(
        "log_in_the_working_directory",
        "hula_hoop",
        "tree",
        "Euler",
        FAILED if logged else RIGHT,
        (ENGINE,) if logged else (),
        f"an unstable run ({', '.join(counted)}) leaves {', '.join(written) or 'nothing'} in "
        "the working directory",
        step=1024.0,
        values={"files": float(len(written))},
    )


PLAIN: Mapping[str, tuple[str, Callable[[], list[Row]]]] = {
    "energy_before_mj_forward": ("hula_hoop", stale_energy),
    "transition_matrix": ("hula_hoop", transition_matrix),
    "lost_inertia": ("hula_hoop", lost_inertia),
    "clock_rounding": ("hula_hoop", clock_rounding),
    "log_in_the_working_directory": ("hula_hoop", log_file),
    "crank_longer_than_rod": ("speed_regulator", too_long_crank),
}
"""What MuJoCo does beside simulating: name -> scene, and what provokes it."""

NOT_PROVOKED = (
    (
        "MuJoCo: tendon equalities omit Jdot v",
        "no scene has a tendon equality; the fixed tendons of the models are linear, with Jdot = 0",
    ),
    (
        "MuJoCo 4.0.0: sparse Newton Hessian",
        "loops of the scenes are too small: sparse and dense agree to 1e-13",
    ),
    (
        "MuJoCo: RK4 of ball and free joints before 4.0",
        "no scene has such a joint, and one version is installed",
    ),
    ("MuJoCo: free rotation under implicit methods", "no scene has a free body"),
    ("MuJoCo: 1-D flex converges with order 1", "no model uses flex"),
    ("MuJoCo: sleeping bodies never sleep", "no model enables sleep"),
    ("MuJoCo: default softness depends on qpos0", "every model is compiled at phi = 0"),
    (
        "MuJoCo: eigenvalues of discrete and of the transition matrix are not the physical ones",
        "adapters linearise the equations of motion, never a step",
    ),
    (
        "MuJoCo: rollout and Batch take a Python callback for a C one",
        "the drive is a body, no hook is used",
    ),
    ("foreign readers of MJCF drop stiffness, armature, inertia", "no such engine has an adapter"),
    (
        "Exudyn: the renderer aborts without a display",
        "it would kill the process, and no scene is rendered",
    ),
    ("Exudyn: -W error turns deprecations into failures", "the models use no deprecated name"),
    (
        "Exudyn: sensors of automatic steps lie off the grid",
        "adapters read states, no sensor; automatic steps themselves are provoked",
    ),
    (
        "Exudyn: holds Python's lock while it solves",
        "no result is wrong by it; runs go by processes",
    ),
    (
        "Exudyn: its own start accelerations keep 8 digits",
        "the adapter solves for accelerations itself",
    ),
)
"""Failure modes that the scenes cannot provoke, and why."""


def tasks(scenes: tuple[str, ...], engines: tuple[str, ...], full: bool) -> list[Task]:
    """Return the tasks of this section."""
    found = [
        Task(SECTION, failure.scene, failure.name, failure.engine, partial(provoke, number))
        for number, failure in enumerate(FAILURES)
        if failure.scene in scenes and failure.engine in engines
    ]
    found += [
        Task(SECTION, scene, name, "mujoco", call)
        for name, (scene, call) in PLAIN.items()
        if scene in scenes and "mujoco" in engines
    ]
    return found
