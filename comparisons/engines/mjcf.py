"""What every engine that reads our MJCF has in common: models, their equations, joints, states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...models import mjcf
from ...models.mechanism import mechanism, switched_off
from ...models.placement import placed, placed_motion, why_not_placed, world_axes
from ...models.readout import Readout
from ...models.system import System
from ...reference import get_scene
from ...reference.errors import UnknownNameError
from ...reference.scene import Array, Case
from .adapter import Adapter
from .equations import ModelEquations


class MjcfAdapter(Adapter):
    """The MJCF models of the scenes: the part of an adapter that is the same for all readers."""

    reads_mjcf = True

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the MJCF models of a scene, default first."""
        return tuple(mjcf.models(scene))

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the named MJCF model of a case's scene.

        Raises
        ------
        UnknownNameError
            If there is none.
        """
        known = mjcf.models(case.scene)
        if model not in known:
            raise UnknownNameError(f"MJCF model of {case.scene}", model, known)
        return known[model]

    def text(self, case: Case, model: str) -> str:
        """Return the MJCF of a case, placed in the world as it says."""
        return placed(mjcf.export(self.source(case, model), case.parameters), case.placement)

    def why_not_placed(self, case: Case, model: str) -> str | None:
        """Return why a model cannot be placed in the world otherwise than it stands, or None."""
        if not self.reads_mjcf:
            return super().why_not_placed(case, model)
        text = self.source(case, model).path.read_text(encoding="utf-8")
        return why_not_placed(text, case.placement)

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of motion that the model has, None where they are the scene's."""
        equations = self.source(case, model).equations
        return ModelEquations(*equations(case.parameters)) if equations else None

    def twins(self, scene: str) -> tuple[str, ...]:
        """Return the models that a force in time drives in place of a body."""
        table = mjcf.models(scene)
        return tuple(name for name in self.models(scene) if name in table and table[name].controls)

    def integrates_drive(self, case: Case, model: str) -> bool:
        """Return whether the drive is a body of the model, integrated like the rest."""
        return self.source(case, model).controls is None

    def coordinates(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the coordinates of states: the scene's, or its own where those are internal."""
        scene = get_scene(case.scene)
        equations = self.model_equations(case, model) if scene.discretisation_coordinates else None
        return equations.scene.coordinates if equations else scene.coordinates

    def has_constraints(self, case: Case, model: str) -> bool:
        """Return whether a loop of the model is closed by a constraint."""
        return self.source(case, model).closed

    def element_order(self, case: Case, model: str) -> int:
        """Return the order with which the model converges to a continuum, or 0."""
        return self.source(case, model).elements.order

    def frequency_side(self, case: Case, model: str) -> int:
        """Return whether its first frequency lies below (-1) or above (1) the continuum's, or 0."""
        return self.source(case, model).elements.side(case.parameters)

    def start(self, case: Case, model: str) -> Array:
        """Return the initial state of a case; a case need not know the model's coordinates."""
        scene = get_scene(case.scene)
        equations = self.model_equations(case, model) if scene.discretisation_coordinates else None
        return equations.start(case) if equations else scene.state(case.state)

    def prescribed(self, case: Case, model: str) -> list[int]:
        """Return which coordinates have a given motion."""
        names = self.source(case, model).prescribed(case.parameters)
        return [self.coordinates(case, model).index(name) for name in names]

    def motion(self, case: Case, model: str, time: float, state: Array) -> mjcf.Motion:
        """Return position and velocity of every joint."""
        coordinates = self.coordinates(case, model)
        names = (*coordinates, *(f"{name}_dot" for name in coordinates))
        values = dict(zip(names, map(float, state), strict=True))
        motion = self.source(case, model).joints(case.parameters, time, values)
        return placed_motion(motion, case.placement)

    def initial_motion(self, case: Case, model: str) -> mjcf.Motion:
        """Return position and velocity of every joint at the start, which may be inconsistent."""
        motion = self.motion(case, model, case.start_time, self.start(case, model))
        off = case.inconsistency
        return {
            joint: (q + off.get(joint, 0.0), v + off.get(f"{joint}_dot", 0.0))
            for joint, (q, v) in motion.items()
        }

    def readout(self, case: Case, model: str) -> dict[str, Mapping[str, float]]:
        """Return each coordinate as a sum of joints."""
        sums = self.source(case, model).readout
        return {name: sums.get(name, {name: 1.0}) for name in self.coordinates(case, model)}

    def joint_readout(self, case: Case, model: str, system: System) -> Readout:
        """Return how the coordinates follow from the joints of a system."""
        scene, names = get_scene(case.scene), self.coordinates(case, model)
        sums = self.source(case, model).readout
        axes = world_axes(case.placement)
        return Readout(scene, names, system.joints, system.layout, sums, axes)

    def joint_system(self, case: Case, model: str) -> System:
        """Return the model in joint coordinates, with the initial state of a case.

        Raises
        ------
        CannotJudgeError
            If it holds what `models.mechanism` does not understand.
        """
        text = self.text(case, model)
        whole = mechanism(text)
        motion = self.initial_motion(case, model)
        stop = self.source(case, model).stop(case.parameters)
        joints = tuple(one.name for one in whole.joints)
        terms = whole.terms
        if controls := self.source(case, model).controls:
            waves = controls(case.parameters)
            terms = tuple(
                replace(term, **waves[term.name]._asdict())
                if term.kind == "actuator" and term.name in waves
                else term
                for term in terms
            )
        return System(
            case=case,
            model=model,
            joints=joints,
            positions=np.hstack([motion[name][0] for name in joints]),
            velocities=np.hstack([motion[name][1] for name in joints]),
            start_time=case.start_time,
            mjcf=text,
            terms=terms if stop is None else switched_off(terms, stop),
            armatures={one.name: one.armature for one in whole.joints if one.armature},
            closures=whole.closures,
            kinds=whole.layout.kinds,
        )

    def joint_states(
        self, case: Case, model: str, times: Array, states: Array
    ) -> tuple[System, Array, Array]:
        """Return the system, and positions (k, n_q) and velocities (k, n) of its joints at states.

        Parameters
        ----------
        times : array (k,)
        states : array (k, 2 n_coordinates)
        """
        system = self.joint_system(case, model)
        rows = zip(times, states, strict=True)
        motions = [self.joint_motion(case, model, system.joints, float(t), x) for t, x in rows]
        q, v = zip(*motions, strict=True)
        return system, np.array(q), np.array(v)

    def joint_motion(
        self, case: Case, model: str, joints: tuple[str, ...], time: float, state: Array
    ) -> tuple[Array, Array]:
        """Return positions (n_q,) and velocities (n,) of joints at a time and state."""
        motion = self.motion(case, model, time, state)
        q, v = (np.hstack([motion[name][i] for name in joints]) for i in (0, 1))
        return q, v

    def jacobian(self, case: Case, model: str, joints: tuple[str, ...], state: Array) -> Array:
        """Return the velocities (n, n_v) of joints per unit rate of each coordinate."""
        n = len(state) // 2
        standing = np.concatenate([state[:n], np.zeros(n)])
        moving = standing + np.vstack([np.zeros(2 * n), np.eye(2 * n)[n:]])
        rates = [self.joint_motion(case, model, joints, case.start_time, x)[1] for x in moving]
        return np.array(rates[1:]) - rates[0]

    def of_coordinates(
        self, case: Case, model: str, system: System, state: Array, matrix: Array
    ) -> Array:
        """Return the mass matrix (n, n) of coordinates from the joints' (n_v, n_v) at a state."""
        jacobian = self.jacobian(case, model, system.joints, state)
        own = self.with_identity_rows(case, model, jacobian @ matrix @ jacobian.T)
        return self.joint_readout(case, model, system).completed(own, state, case.parameters)

    def with_identity_rows(self, case: Case, model: str, matrix: Array) -> Array:
        """Return a mass matrix with the identity's rows and columns where motion is prescribed."""
        places = self.prescribed(case, model)
        matrix[places, :] = matrix[:, places] = 0
        matrix[places, places] = 1
        return matrix
