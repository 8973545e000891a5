"""Joints in another order than the file's: every order is tried, of many each pair."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

from ....reference.errors import Unsupported
from ...engines.setup import Setup
from ..units import EXPLAINED
from .equations import error_of
from .steps import after_steps

FEW = 4
"""Joints of which every order is tried."""

MOST = 8
"""Joints of which each pair is tried."""

RIGHT = 1e-3
"""Relative error that other joints' numbers do not leave."""


def of_joints(setup: Setup) -> str:
    """Return which joints are exchanged, if that explains wrong accelerations or single steps."""
    scene = setup.scene
    if scene.discretisation_coordinates or not setup.engine.reads_mjcf:
        return ""
    away = error_of if setup.method is None else (lambda one: after_steps(one, 1).error)
    error = away(setup)
    joints = setup.engine.joint_system(setup.case, setup.model).joints
    if error < EXPLAINED or len(joints) > MOST:
        return ""
    words: dict[int, list[str]] = {}
    for order in permutations(range(len(joints))):
        moved = [i for i, j in enumerate(order) if i != j]
        if not moved or (len(moved) > 2 and len(joints) > FEW):
            continue
        for inputs_too in (True, False):
            try:
                left = away(replace(setup, engine=setup.engine.reordered(order, inputs_too)))
            except Unsupported:
                return ""
            if left < RIGHT and left < EXPLAINED * error:
                where = "" if inputs_too else " in what it returns"
                others = (f"{joints[i]} is {joints[order[i]]}" for i in moved)
                said = f"joints are in another order: {', '.join(others)}"
                if len(moved) == 2:
                    said = f"joints {joints[moved[0]]} and {joints[moved[1]]} are exchanged"
                words.setdefault(len(moved), []).append(f"{said}{where}")
    fewest = words[min(words)] if words else []
    return fewest[0] if len(fewest) == 1 else ""
