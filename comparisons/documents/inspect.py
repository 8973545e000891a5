"""The document of ``inspect``."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from .core import (
    Count,
    Name,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    Vector,
    Version,
    Versions,
    limits,
    means,
)

# What is in the file --------------------------------------------------------------------------

FindingCounts = TypedDict(
    "FindingCounts",
    {
        "error": Annotated[Count, means("errors that are not waived; any is exit code 1")],
        "warning": Annotated[Count, means("warnings that are not waived")],
        "note": Annotated[Count, means("notes that are not waived")],
        "waived": Annotated[Count, means("findings that the file waives")],
    },
)

ModelOptions = TypedDict(
    "ModelOptions",
    {
        "integrator": Annotated[str, means("as MJCF spells it")],
        "timestep": Annotated[Positive, means("[s]")],
        "solver": Annotated[str, means("of constraints")],
        "tolerance": Annotated[float, means("of the solver")],
        "iterations": Annotated[Count, means("of the solver")],
        "cone": Annotated[str, means("of friction")],
        "jacobian": Annotated[str, means("dense, sparse or auto")],
        "gravity": Annotated[Vector, means("[m/s^2]; 0 if it is switched off")],
        "energy": Annotated[bool, means("whether energy is computed")],
        "autoreset": Annotated[bool, means("whether a run that fails starts anew")],
        "contact": Annotated[bool, means("whether bodies can touch at all")],
        "refsafe": Annotated[
            bool, means("whether constraints that are faster than two timesteps are softened")
        ],
    },
)

Joint = TypedDict(
    "Joint",
    {
        "name": Annotated[str, means("name, or kind and number")],
        "kind": Annotated[Literal["free", "ball", "slide", "hinge"], means("type")],
        "dofs": Annotated[Literal[1, 3, 6], means("degrees of freedom")],
        "axis": Annotated[
            Vector | None,
            means("of a slide or hinge, in the body's frame; null of the others"),
        ],
        "stiffness": Annotated[float | None, means("[N/m, Nm/rad]; null if not finite")],
        "damping": Annotated[
            float | None,
            means("[Ns/m, Nms/rad], of its first degree of freedom; null if not finite"),
        ],
        "armature": Annotated[float | None, means("[kg, kg m^2]; null if not finite")],
        "range": Annotated[
            Annotated[list[float | None], limits(minItems=2, maxItems=2)] | None,
            means("limits [m, rad]; null without any"),
        ],
    },
)

Body = TypedDict(
    "Body",
    {
        "name": Annotated[str, means("name, or kind and number")],
        "parent": Annotated[str, means("name of the parent; world")],
        "depth": Annotated[Count, means("bodies between it and the world")],
        "mass": Annotated[NotNegative, means("[kg]")],
        "centre": Annotated[Vector, means("centre of mass in its frame [m]")],
        "inertia": Annotated[Vector, means("principal moments of inertia [kg m^2]")],
        "joints": Annotated[list[Joint], means("its joints")],
    },
)

# How it moves ---------------------------------------------------------------------------------

ModelMode = TypedDict(
    "ModelMode",
    {
        "kind": Annotated[
            Literal["rigid", "oscillating", "decaying", "unstable"], means("what it does")
        ],
        "re": Annotated[float, means("real part of its eigenvalue [1/s]")],
        "im": Annotated[float, means("imaginary part [1/s]")],
        "omega": Annotated[NotNegative, means("modulus [rad/s]")],
        "hertz": Annotated[NotNegative, means("omega / (2 pi) [Hz]")],
        "damping_ratio": Annotated[float | None, means("-re / omega [1]; null for a rigid mode")],
        "joint": Annotated[str, means("joint that moves most in it, by kinetic energy")],
    },
)

ModelState = TypedDict(
    "ModelState",
    {
        "names": Annotated[
            list[str], means("keyframes that hold it; 'as opened' is qpos0", minItems=1)
        ],
        "position": Annotated[list[float], means("qpos [m, rad]")],
        "velocity": Annotated[list[float], means("qvel [m/s, rad/s]")],
        "held": Annotated[
            str | None,
            means("hinge that turns steadily, held at its speed; null in the file's states"),
        ],
        "reason": Annotated[str | None, means("why there are no modes; null if there are")],
        "acceleration": Annotated[
            NotNegative | None,
            means("largest, closed loops exact [m/s^2, rad/s^2]; null without modes"),
        ],
        "closed": Annotated[
            Count | None, means("directions that closed loops take away; null without modes")
        ],
        "contacts": Annotated[Count | None, means("contacts that act; null without modes")],
        "limits": Annotated[Count | None, means("limits that act; null without modes")],
        "modes": Annotated[
            list[ModelMode],
            means("loops closed exactly, contacts and limits left out; ascending in omega"),
        ],
        "simulated": Annotated[
            list[ModelMode],
            means("all constraints as soft as MuJoCo has them; ascending in omega"),
        ],
    },
)

StepLimit = TypedDict(
    "StepLimit",
    {
        "integrator": Annotated[str, means("as MJCF spells it")],
        "limit": Annotated[float | None, means("[s]; null if every step is stable")],
        "state": Annotated[
            str | None, means("state where it is least; null if every step is stable")
        ],
        "omega": Annotated[
            float | None, means("modulus of the mode that sets it [1/s]; null if there is none")
        ],
        "joint": Annotated[
            str | None, means("joint that moves most in that mode; null if there is none")
        ],
        "constraint": Annotated[
            str | None,
            means("closure, limit, contact or dry friction that sets it; null if none does"),
        ],
        "softened": Annotated[
            float | None,
            means("step from which on constraints are softened [s] (refsafe); null if none is"),
        ],
        "chosen": Annotated[bool, means("whether the file uses this integrator")],
        "ratio": Annotated[
            float | None,
            means("timestep of the file over the limit [1]; 0 if every step is stable"),
        ],
    },
)

LoopClosure = TypedDict(
    "LoopClosure",
    {
        "name": Annotated[str, means("name, or kind and number")],
        "kind": Annotated[Literal["connect", "weld", "joint", "tendon"], means("element")],
        "state": Annotated[str, means("state")],
        "solref": Annotated[Pair, means("as the file has it")],
        "solimp": Annotated[list[float], means("as the file has it", minItems=5, maxItems=5)],
        "effective": Annotated[Pair, means("solref as MuJoCo takes it at the file's timestep")],
        "impedance": Annotated[float, means("d, open as far as predicted [1]")],
        "omega": Annotated[
            NotNegative, means("nominal circular frequency of the closure itself [rad/s]")
        ],
        "decay": Annotated[float, means("nominal rate at which departures die away [1/s]")],
        "force": Annotated[NotNegative, means("load: norm of the exact closure's force [N, Nm]")],
        "opening": Annotated[
            float | None,
            means(
                "how far the load opens it, whatever the step [m], of a joint or tendon in its "
                "unit; null if nothing holds it"
            ),
        ],
        "turn": Annotated[
            float | None, means("the same of a weld's rotation [rad]; null for the others")
        ],
        "now": Annotated[NotNegative, means("how far it is open in the state itself")],
    },
)

# What it could do without ---------------------------------------------------------------------

Finding = TypedDict(
    "Finding",
    {
        "rule": Annotated[
            str,
            means("its id; `mbcheck inspect --explain` tells about it", pattern="^[a-z_]+$"),
        ],
        "severity": Annotated[Literal["error", "warning", "note"], means("how bad it is")],
        "element": Annotated[str, means("where: tag:name, tag:name/tag or tag")],
        "file": Annotated[str | None, means("file; null if it does not stand in the text")],
        "line": Annotated[Ordinal | None, means("line; null likewise")],
        "message": Annotated[Name, means("what was found, with its numbers")],
        "fix": Annotated[Name, means("what to do")],
        "attribute": Annotated[
            str | None, means("the attribute that is meant; null if it is not one")
        ],
        "measure": Annotated[
            float | None,
            means("how bad it is, the larger the worse; null where no number tells"),
        ],
        "waived": Annotated[
            str | None,
            means("the reason that the file gives for it; null if it does not waive it"),
        ],
    },
)

Inspect = TypedDict(
    "Inspect",
    {
        "schema": Version,
        "file": Annotated[Name, means("the file, as it was given")],
        "files": Annotated[list[str], means("it, and what it includes", minItems=1)],
        "name": Annotated[str, means("of the model; empty if the file gives none")],
        "summary": Annotated[FindingCounts, means("number of findings")],
        "options": Annotated[ModelOptions, means("how the file is simulated")],
        "counts": Annotated[
            dict[str, Count],
            means("number of positions nq, degrees of freedom nv, bodies, joints, geoms, ..."),
        ],
        "mass": Annotated[NotNegative, means("of all bodies [kg]")],
        "size": Annotated[NotNegative, means("MuJoCo's extent [m]")],
        "bodies": Annotated[list[Body], means("in the order of the tree, without the world")],
        "states": Annotated[
            list[ModelState],
            means("states of the file, then the steady rotation that was asked for"),
        ],
        "steps": Annotated[
            list[StepLimit], means("largest stable step of each integrator; empty without modes")
        ],
        "shortest_period": Annotated[
            float | None, means("of all that oscillates as simulated [s]; null if nothing does")
        ],
        "closures": Annotated[
            list[LoopClosure], means("closures of loops in each state, the stiffest first")
        ],
        "findings": Annotated[list[Finding], means("unwaived ones first, errors first")],
        "untried": Annotated[
            str | None,
            means("why some attributes were not tried for repeated_default; null if all were"),
        ],
        "left_out": Annotated[
            list[str], means("modes, steps and rules that were not begun before it was stopped")
        ],
        "versions": Versions,
    },
)

Unreadable = TypedDict(
    "Unreadable",
    {
        "file": Annotated[Name, means("as it was given")],
        "reason": Annotated[Name, means("why it could not be inspected")],
    },
)

Inspections = TypedDict(
    "Inspections",
    {
        "schema": Version,
        "summary": Annotated[FindingCounts, means("number of findings of all files")],
        "unreadable": Annotated[list[Unreadable], means("files that could not be inspected")],
        "models": Annotated[list[Inspect], means("the others, each as `inspect` describes it")],
    },
)
