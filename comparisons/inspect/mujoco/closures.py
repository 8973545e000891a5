r"""Closed loops of an MJCF model: their softness, and their opening under load.

MuJoCo's constraint ("Computation", constraint model) pulls the residual r of a loop with
``f = (A + R)^-1 (-b r' - d k r - a_0)``, ``R = (1 - d) / d A`` for a body's approximate inverse
inertia A. Under a load that needs the force f_0 of the exact loop, the loop stays open by

    r = -R f_0 / (d k),

whatever the step, and departures from this opening decay as ``r'' + d b r' + d^2 k r = 0``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from scipy.optimize import brentq

from ....reference.scene import Array
from ....reference.soft_constraint import clamped, impedance, reference_spring
from ...documents.fields import HIDDEN, NULLABLE, Number
from ..tuning import NUMERICS
from .facts import integrator, word
from .linear import LinearProbe, solved
from .model import Loaded, State


@dataclass(frozen=True)
class ClosedLoop:
    """A constraint that closes a loop, in one state.

    Attributes
    ----------
    number : int
        Number of the equality.
    name : str
        name, or kind and number if it has none
    kind : {"connect", "weld", "joint", "tendon"}
        element of MJCF
    state : str
        state of the file
    solref, solimp : tuple of float
        value in the file
    effective : tuple of float
        solref as MuJoCo uses it at the file's timestep
    impedance : float
        impedance d at the predicted opening [1]
    omega : float
        nominal circular frequency of the closure [rad/s]
    decay : float
        nominal rate at which departures decay [1/s]
    force : float
        load: norm of the force of the exact closure [N, Nm]
    opening : float
        opening under the load, whatever the step [m], for a joint or tendon in its unit; null if
        nothing resists it
    turn : float or None
        rotation of a weld under the load [rad]; null for other closures
    now : float
        opening in the state
    """

    number: int = field(metadata=HIDDEN)
    name: str
    kind: str
    state: str
    solref: tuple[float, float]
    solimp: tuple[float, ...]
    effective: tuple[float, float]
    impedance: float
    omega: float
    decay: float
    force: float
    opening: Number
    turn: Annotated[float | None, NULLABLE]
    now: float


KINDS = ("connect", "weld", "joint", "tendon")
"""Equalities that are listed one by one; those of flexes are too many, one for each edge."""


def closures(loaded: Loaded, state: State) -> list[ClosedLoop]:
    """Return the closures of a model in a state, the stiffest first."""
    lib = loaded.mujoco
    listed = [i for i in range(loaded.model.neq) if equality_kind(loaded, i) in KINDS]
    if not listed:
        return []
    probe = LinearProbe(loaded, state)
    forces = solved(probe).multipliers
    probe.put(state.position, state.velocity)
    lib.mj_forward(probe.model, probe.data)
    data = probe.data
    equality = data.efc_type == int(lib.mjtConstraint.mjCNSTR_EQUALITY)
    owner, residual = np.array(data.efc_id)[equality], np.array(data.efc_pos)[equality]
    stiff = np.array(data.efc_KBIP)[equality, 2]
    inverse = np.array(data.efc_R)[equality] * stiff / (1 - stiff)
    every = [
        closure(loaded, state.name, i, inverse[at], forces[at], residual[at])
        for i, at in ((i, owner == i) for i in listed if i in owner)
    ]
    return sorted(every, key=lambda one: -one.omega)


def equality_kind(loaded: Loaded, number: int) -> str:
    """Return the kind of an equality, as MJCF names it."""
    return word(loaded.mujoco.mjtEq, loaded.model.eq_type[number]).lower()


def closure(
    loaded: Loaded, state: str, number: int, inverse: Array, force: Array, residual: Array
) -> ClosedLoop:
    """Return one closure, the equality of this number, in a state.

    Parameters
    ----------
    loaded : Loaded
    state : str
    number : int
    inverse : array (rows,)
        Approximate inverse inertias A [1/kg, 1/(kg m^2)].
    force : array (rows,)
        Forces f_0 of the exact loop [N, Nm].
    residual : array (rows,)
        Opening in the state [m, rad].
    """
    model, kind = loaded.model, equality_kind(loaded, number)
    solref = float(model.eq_solref[number, 0]), float(model.eq_solref[number, 1])
    solimp = tuple(map(float, model.eq_solimp[number]))
    used, clamps = effective(loaded, solref), clamped(solimp)
    spring, damper = reference_spring(used, clamps[1])
    stiff, opened = opening(clamps, spring, inverse * np.abs(force))
    square, half = stiff**2 * spring, stiff * damper / 2
    return ClosedLoop(
        number=number,
        name=loaded.name("equality", number),
        kind=kind,
        state=state,
        solref=solref,
        solimp=solimp,
        effective=used,
        impedance=stiff,
        omega=float(np.sqrt(square)),
        decay=float(half - np.sqrt(max(0.0, half**2 - square))),
        force=float(np.linalg.norm(force)),
        opening=float(np.linalg.norm(opened[:3])),
        turn=float(np.linalg.norm(opened[3:])) if kind == "weld" else None,
        now=float(np.linalg.norm(residual)),
    )


def effective(loaded: Loaded, solref: tuple[float, float]) -> tuple[float, float]:
    """Return ``solref`` as MuJoCo uses it: a positive time constant is at least two steps."""
    raised = not loaded.disabled("refsafe") and integrator(loaded) != "discrete"
    if solref[0] > 0 and raised:
        return max(solref[0], 2 * float(loaded.model.opt.timestep)), solref[1]
    return solref


def opening(solimp: tuple[float, ...], spring: float, load: Array) -> tuple[float, Array]:
    """Return the impedance d and the opening (rows,) of a closure, which depend on each other.

    Parameters
    ----------
    solimp : tuple of float
        Clamped to MuJoCo's limits.
    spring : float
        Stiffness k [1/s^2].
    load : array (rows,)
        Inverse inertia times force.
    """

    def opened(stiff: float) -> Array:
        return np.asarray((1 - stiff) / stiff * load / (stiff * spring))

    def excess(stiff: float) -> float:
        return float(impedance(np.sum(opened(stiff) ** 2), solimp)) - stiff

    low, high = sorted(solimp[:2])
    if not spring > 0:
        return high, np.full(len(load), np.inf) * (load > 0)
    stiff = float(impedance(0.0, solimp))
    if (
        np.linalg.norm(opened(low)) > NUMERICS.min_opening
        and excess(low) * excess(high) <= 0
        and low != high
    ):
        stiff = float(brentq(excess, low, high, xtol=1e-15))
    return stiff, opened(stiff)
