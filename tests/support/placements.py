"""Engines that are right as long as a model stands as in its file, and wrong where it is turned."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mbcheck.comparisons.checks.mistakes.parts import as_placed, with_axes_of_world
from mbcheck.comparisons.engines.adapter import BoundModel
from mbcheck.comparisons.engines.exudyn.engine import Exudyn
from mbcheck.comparisons.faults.mujoco import MujocoAdapter
from mbcheck.examples.mujoco_engine import MujocoPlugin
from mbcheck.models.mechanism import Mechanism, mechanism
from mbcheck.models.mjcf import attribute_text
from mbcheck.models.placement import right_handed, world_axes, write_orientation
from mbcheck.reference.scene import Array, Case
from mbcheck.tests.support.engines.reading import Reader


def misreading(change: Callable[[str], str]) -> type[MujocoPlugin]:
    """Return MuJoCo as a plug-in that reads a text as another one."""

    class Misreading(MujocoPlugin):
        def at(self, system: Any, *state: Any) -> Any:
            return super().at(replace(system, mjcf=change(system.mjcf)), *state)

    return Misreading


def with_axes_along_the_world(text: str) -> str:
    """Return MJCF in which a joint's axis is that in the world."""
    root, wrong = ET.fromstring(text), with_axes_of_world(mechanism(text))
    axes = {one.name: one.axis for one in wrong.joints}
    for item in root.iterfind("worldbody//joint"):
        item.set("axis", attribute_text(tuple(axes[item.get("name", "")])))
    return ET.tostring(root, encoding="unicode")


def with_tensors_along_the_world(text: str) -> str:
    """Return MJCF in which the inertia of a body keeps the world's axes as the body is placed."""
    root, whole = ET.fromstring(text), mechanism(text)
    rotations = as_placed(whole).rotations
    names = {body.name: rotation for body, rotation in zip(whole.bodies, rotations, strict=True)}
    for body in root.iterfind("worldbody//body"):
        about = body.find("inertial")
        if about is not None:
            write_orientation(about, names[body.get("name", "")].T)
    return ET.tostring(root, encoding="unicode")


class FlatLoops(Reader):
    """Loops whose ends are taken to have no acceleration along the world's z axis."""

    name = "flat_loops"

    def drift(self, whole: Mechanism, q: Array, v: Array) -> Array:
        """Return the accelerations of the gaps (3 l,), none along z."""
        return super().drift(whole, q, v) * np.tile([1.0, 1.0, 0.0], len(whole.closures))


class ModelWithReactionsAlongTheWorld(BoundModel):
    """A model whose reactions are told along the axes of the world."""

    def reactions(self, times: Array, states: Array) -> dict[str, Array]:
        """Return the components along x and y of the world, of forces in the model's plane."""
        right = super().reactions(times, states)
        axes, told = world_axes(self.case.placement)[:2, :2], dict[str, Array]()
        for point in ("a", "b"):
            names = [f"reaction_{point}_{axis}" for axis in "xy"]
            told |= zip(names, axes @ [right[name] for name in names], strict=True)
        return told


class WithReactionsAlongTheWorld(MujocoAdapter):
    """MuJoCo with these models."""

    bound = ModelWithReactionsAlongTheWorld


WRONG: Mapping[str, tuple[Any, str, str]] = {
    "axes": (
        misreading(with_axes_along_the_world),
        "hula_hoop",
        "axes of joints are taken in the frame of the world, not of their bodies",
    ),
    "tensors": (
        misreading(with_tensors_along_the_world),
        "hula_hoop",
        "inertia tensors are not turned with their bodies",
    ),
    "loops": (
        FlatLoops,
        "speed_regulator",
        "right for the model as in its file, and wrong for the same model {placed}",
    ),
}
"""Plug-ins, the scene that shows what is wrong with them, and the words for it."""


class Rebuilt(Exudyn):
    """Exudyn whose models are changed once they are built.

    Parameters
    ----------
    change : callable ``(mbs, axes (3, 3), parameters)``
        What is done to the system of a model in the axes of its placement.
    """

    def __init__(self, change: Callable[[Any, Array, Any], None]) -> None:
        super().__init__()
        self.change = change

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        built = super().system(case, model)
        self.change(built.mbs, right_handed(world_axes(case.placement)), case.parameters)
        return built


def slides_along_the_world(mbs: Any, axes: Array, p: Any) -> None:
    """Let bodies slide along the axes of the world."""
    for item in range(mbs.systemData.NumberOfObjects()):
        if mbs.GetObject(item)["objectType"] == "Mass1D":
            turn = axes.T @ mbs.GetObjectParameter(item, "referenceRotation")
            mbs.SetObjectParameter(item, "referenceRotation", turn)


def weights_along_the_world(mbs: Any, axes: Array, p: Any) -> None:
    """Let bodies and trees have weights in the frame of the world."""
    for load in range(mbs.systemData.NumberOfLoads()):
        if mbs.GetLoad(load)["loadType"] == "MassProportional":
            mbs.SetLoadParameter(load, "loadVector", [p.gravity_x, p.gravity_y, 0])
    for item in range(mbs.systemData.NumberOfObjects()):
        if mbs.GetObject(item)["objectType"] == "KinematicTree":
            mbs.SetObjectParameter(item, "gravity", [p.gravity_x, p.gravity_y, 0])


class WithExudynsReactionsAlongTheWorld(Exudyn):
    """Exudyn whose reactions are told along the axes of the world."""

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        built, axes = super().system(case, model), world_axes(case.placement)
        if built.reactions is None:
            return built
        turn = np.kron(np.eye(2), axes[:2, :2])
        return replace(built, reactions=turn @ built.reactions)
