"""The documents of ``inspect``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .inspection import ModelFinding
from .mujoco.closures import ClosedLoop
from .mujoco.facts import BodyFacts, Options
from .subject import StepLimit


@dataclass(frozen=True)
class ModelMode:
    """A mode of small motions.

    Attributes
    ----------
    kind : {"rigid", "oscillating", "decaying", "unstable"}
        what it does
    re : float
        real part of its eigenvalue [1/s]
    im : float
        imaginary part [1/s]
    omega : float
        modulus [rad/s]
    hertz : float
        omega / (2 pi) [Hz]
    damping_ratio : float or None
        -re / omega [1]; null for a rigid mode
    joint : str
        joint that moves most in it, by kinetic energy
    """

    kind: str
    re: float
    im: float
    omega: float
    hertz: float
    damping_ratio: float | None
    joint: str


@dataclass(frozen=True)
class ModelState:
    """A state of the file, and small motions about it.

    Attributes
    ----------
    names : tuple of str
        keyframes that hold it; 'as opened' is qpos0
    position : tuple of float
        qpos [m, rad]
    velocity : tuple of float
        qvel [m/s, rad/s]
    held : str or None
        hinge that turns steadily, held at its speed; null in the file's states
    reason : str or None
        why there are no modes; null if there are
    acceleration : float or None
        largest, closed loops exact [m/s^2, rad/s^2]; null without modes
    closed : int or None
        directions that closed loops take away; null without modes
    contacts : int or None
        contacts that act; null without modes
    limits : int or None
        limits that act; null without modes
    modes : tuple of ModelMode
        loops closed exactly, contacts and limits left out; ascending in omega
    simulated : tuple of ModelMode
        all constraints as soft as MuJoCo has them; ascending in omega
    """

    names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    held: str | None
    reason: str | None
    acceleration: float | None
    closed: int | None
    contacts: int | None
    limits: int | None
    modes: tuple[ModelMode, ...]
    simulated: tuple[ModelMode, ...]


@dataclass(frozen=True)
class Unreadable:
    """A file that could not be inspected.

    Attributes
    ----------
    file : str
        as it was given
    reason : str
        why it could not be inspected
    """

    file: str
    reason: str


@dataclass(frozen=True)
class InspectDocument:
    """What is in an MJCF file, and what it could do without.

    Attributes
    ----------
    file : str
        the file, as it was given
    files : tuple of str
        it, and what it includes
    name : str
        of the model; empty if the file gives none
    summary : mapping of str to int
        number of findings by severity, waived ones apart; any `error` is exit code 1
    options : Options
        how the file is simulated
    counts : mapping of str to int
        number of positions nq, degrees of freedom nv, bodies, joints, geoms, ...
    mass : float
        of all bodies [kg]
    size : float
        MuJoCo's extent [m]
    bodies : tuple of BodyFacts
        in the order of the tree, without the world
    states : tuple of ModelState
        states of the file, then the steady rotation that was asked for
    steps : tuple of StepLimit
        largest stable step of each integrator; empty without modes
    shortest_period : float or None
        of all that oscillates as simulated [s]; null if nothing does
    closures : tuple of ClosedLoop
        closures of loops in each state, the stiffest first
    findings : tuple of ModelFinding
        unwaived ones first, errors first
    untried : str or None
        why some attributes were not tried for repeated_default; null if all were
    left_out : tuple of str
        modes, steps and rules that were not begun before it was stopped
    """

    file: str
    files: tuple[str, ...]
    name: str
    summary: Mapping[str, int]
    options: Options
    counts: Mapping[str, int]
    mass: float
    size: float
    bodies: tuple[BodyFacts, ...]
    states: tuple[ModelState, ...]
    steps: tuple[StepLimit, ...]
    shortest_period: float | None
    closures: tuple[ClosedLoop, ...]
    findings: tuple[ModelFinding, ...]
    untried: str | None
    left_out: tuple[str, ...]
    versions: Mapping[str, str]


@dataclass(frozen=True)
class InspectionsDocument:
    """What is found in several MJCF files.

    Attributes
    ----------
    summary : mapping of str to int
        number of findings of all files
    unreadable : tuple of Unreadable
        files that could not be inspected
    models : tuple of InspectDocument
        the others, each as `inspect` describes it
    """

    summary: Mapping[str, int]
    unreadable: tuple[Unreadable, ...]
    models: tuple[InspectDocument, ...]
