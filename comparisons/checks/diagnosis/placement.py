"""What is wrong with an engine's model only where it is placed otherwise than it stands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ....models.kinematics import Placed, inertias, mass_matrix, movers, place
from ....models.mechanism import Mechanism, mechanism
from ....models.placement import world_axes
from ....reference.errors import Unsupported
from ....reference.scene import Array
from ...engines.run import call_engine
from ...engines.setup import Setup
from ..kinds import algebra, one_step, parts, trajectory
from ..units import EXPLAINED
from ..verdict import Finding, judge

MEASURES = {
    "parts": parts.measure,
    "algebra": algebra.measure,
    "step": one_step.measure,
    "trajectory": trajectory.measure,
}
"""Of kinds of check that a model which stands as in its file is put to as well."""


def of_placement(setup: Setup, kind: str) -> str:
    """Return what is wrong with how a model is turned; empty of one that is wrong as it stands."""
    if not setup.case.placement or kind not in MEASURES:
        return ""
    stands = setup.with_case(replace(setup.case, placement=""))
    if stands.unsupported_reason is not None:
        return ""
    findings = MEASURES[kind](stands)
    if any(isinstance(one, Finding) and judge(one, 1.0)[0] == "deviation" for one in findings):
        return ""
    said = of_reactions(setup) if kind == "algebra" else ""
    return said or of_frames(setup) or "it is right as the model stands, and wrong where it turns"


def of_frames(setup: Setup) -> str:
    """Return which frame was mistaken for which, if one such mistake explains a mass matrix."""
    if not setup.engine.reads_mjcf:
        return ""
    times, states = algebra.random_states(
        setup.bound.equations, setup.case, setup.bound.coordinates
    )
    q, _ = setup.bound.joint_states(times, states)
    whole = mechanism(setup.bound.text)
    try:
        answer = call_engine(lambda: setup.bound.joint_mass_matrices(q, whole.layout.size[1]))
    except Unsupported:
        return ""

    def off(matrix: Callable[[Array], Array]) -> float:
        right = np.array([matrix(row) for row in q])
        return algebra.distance(answer, right, right)

    error = off(partial(mass_matrix, whole))
    mistakes: dict[str, Callable[[Array], Array]] = {
        "axes of joints are taken in the frame of the world, not of their bodies": partial(
            mass_matrix, with_axes_of_world(whole)
        ),
        "inertia tensors are not turned with their bodies": partial(with_tensors_behind, whole),
    }
    words = [said for said, matrix in mistakes.items() if off(matrix) < EXPLAINED * error]
    return words[0] if len(words) == 1 else ""


def as_placed(whole: Mechanism) -> Placed:
    """Return a mechanism as its file places it."""
    upright = {"ball": [1.0, 0.0, 0.0, 0.0], "free": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]}
    return place(whole, np.concatenate([upright.get(one.kind, [one.ref]) for one in whole.joints]))


def with_axes_of_world(whole: Mechanism) -> Mechanism:
    """Return a mechanism whose joints have axes that were read as those in the world."""
    rotations, joints = as_placed(whole).rotations, list(whole.joints)
    for body, rotation in zip(whole.bodies, rotations, strict=True):
        for i in body.joints:
            joints[i] = replace(joints[i], axis=rotation.T @ joints[i].axis)
    return replace(whole, joints=tuple(joints))


def with_tensors_behind(whole: Mechanism, q: Array) -> Array:
    """Return a mass matrix (n, n) with inertia tensors along the world's axes as placed."""
    matrices, moved, start = inertias(whole, q), place(whole, q), as_placed(whole).rotations
    for i, body in enumerate(whole.bodies):
        name = f"inertia.{body.name}"
        if name in matrices and any(movers(whole)[i]):
            rates = start[i] @ moved.rotations[i].T @ moved.turning(i)
            matrices[name] = rates.T @ body.inertia @ rates
    return np.asarray(np.sum(list(matrices.values()), axis=0))


def of_reactions(setup: Setup) -> str:
    """Return that reactions are those in the frame of the world, where they are."""
    case, equations, names = setup.case, setup.bound.solved_equations, setup.bound.coordinates
    reactions = setup.bound.reaction_names
    if not reactions:
        return ""
    times, states = algebra.random_states(equations, case, names)
    answer = call_engine(lambda: setup.bound.reactions(times, states))
    right = algebra.expected(case, equations, times, states, names, reactions)
    axes = world_axes(case.placement)[:2, :2]
    firsts = [name for name in reactions if name.endswith("_x")]
    for pair in [(name, f"{name[:-1]}y") for name in firsts if f"{name[:-1]}y" in reactions]:
        values = np.array([answer[name] for name in pair])
        force = np.array([right[name][:, 0] for name in pair])
        error = np.max(np.abs(values - force))
        if not error > 0 or np.max(np.abs(values - axes @ force)) > EXPLAINED * error:
            return ""
    return "reactions are told along the axes of the world, not of the model"
