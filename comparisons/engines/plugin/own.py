"""Engines that read no MJCF, and tell what there is to know of models of their own."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ....models.system import System
from ....reference import get_scene
from ....reference.errors import EngineError, Unsupported
from ....reference.scene import Array, Case
from ..equations import ModelEquations, scene_equations
from ..protocol import Engine, Method
from ..run import VIOLATIONS
from .adapter import OWN, PluginAdapter
from .linear import linearise
from .planning import UNKNOWN_SOFTNESS, ahead, description, names_of, own_reason
from .validation import matrices, numbers


class OwnModelsAdapter(PluginAdapter):
    """An engine with models of its own; states are in the coordinates of the scene.

    Those of a model that tells the equations of its elements may be in their coordinates.
    """

    def hold(self, inner: Engine) -> None:
        """Take an engine, and forget what is known of the models of the one before."""
        super().hold(inner)
        self.names = lru_cache(self.names_of_models)

    def names_of_models(self, scene: str) -> tuple[str, ...]:
        """Return the names of models that the engine tells, none of a scene that it refuses."""
        if "models" not in self.functions:
            return (OWN,)
        try:
            return ahead(self, "models", lambda: names_of(self.inner.models(scene)))
        except Unsupported:
            return ()

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of its models of a scene, default first."""
        return self.names(scene)

    def twins(self, scene: str) -> tuple[str, ...]:
        """Return none: each is driven as the engine likes."""
        return ()

    def coordinates(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the names of the scene's coordinates."""
        return get_scene(case.scene).public

    def has_constraints(self, case: Case, model: str) -> bool:
        """Return whether constraints close loops of the model."""
        return self.about(case, model).constrained

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of motion that the model has, None where they are the scene's."""
        equations = self.about(case, model).equations
        return None if equations is None else ModelEquations(*equations)

    def discrete_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of the model's elements, None where it tells none."""
        elements = self.about(case, model).elements
        return None if elements is None else ModelEquations(elements, case.parameters)

    def element_order(self, case: Case, model: str) -> int:
        """Return the order with which the model converges to a continuum, or 0."""
        return self.about(case, model).element_order

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None."""
        about, reason = description(self, case, model)
        if reason is None and "why_not" in self.functions:
            reason = own_reason(self, case, model, method)
        if reason is not None:
            return reason
        soft = about.constrained and about.equations is not None
        if case.inconsistency and not soft:
            return "only a soft closure can close a loop that starts open"
        if about.constrained and self.closure == "soft" and about.equations is None:
            return UNKNOWN_SOFTNESS
        own = about.equations is not None or about.elements is not None
        if get_scene(case.scene).discretisation_coordinates and not own:
            return f"{case.scene} is a continuum: tell the equations of the model, or its elements"
        return None

    def why_not_placed(self, case: Case, model: str) -> str | None:
        """Return why a model cannot be placed in the world otherwise than it stands, or None."""
        return self.about(case, model).why_not_placed

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the published scheme that a method is on this model, None if it is none."""
        closed = self.has_constraints(case, model)
        return method.scheme if method.scheme_with_loops or not closed else None

    def start(self, case: Case, model: str) -> Array:
        """Return the initial state of a case, of the elements where their equations are told."""
        discrete = self.discrete_equations(case, model)
        if discrete is not None:
            return discrete.start(case)
        scene = get_scene(case.scene)
        values = scene.completed(case.state)
        return np.array([float(values[name]) for name in scene.public_states])

    def system_of(self, scene: str, model: str, parameters: Any, placement: str = "") -> System:
        """Return what the engine is told of parameters."""
        case = Case(scene, "", parameters, placement=placement)
        discrete = self.discrete_equations(case, model)
        names = get_scene(scene).public if discrete is None else discrete.scene.coordinates
        q, v = np.zeros((2, len(names)))
        return System(case, model, names, q, v, observables=get_scene(scene).observed)

    def system_at(self, case: Case, model: str, state: Array) -> System:
        """Return what the engine is told of a case, from another state (2 n,) on."""
        q, v = np.split(state, 2)
        return replace(self.joint_system(case, model), positions=q, velocities=v)

    def observed(self, system: System, q: Array, v: Array, sensed: Any) -> dict[str, Array]:
        """Return the coordinates (n_t, n) and what the engine tells beside, by name.

        Raises
        ------
        EngineError
            ``returned``, if outputs of the scene are missing that do not follow from them.
        """
        names = (*system.joints, *(f"{name}_dot" for name in system.joints))
        values = dict(zip(names, np.hstack([q, v]).T, strict=True)) | dict(sensed)
        closed = self.has_constraints(system.case, system.model)
        wanted = (*get_scene(system.case.scene).observables, *(VIOLATIONS if closed else ()))
        missing = [name for name in wanted if name not in values]
        if not missing:
            return values
        equations = scene_equations(system.case)
        if set(missing) & set(VIOLATIONS) or system.joints != equations.scene.coordinates:
            raise EngineError("returned", f"Motion.observables must tell {', '.join(missing)}")
        with np.errstate(all="ignore"):  # the guard tells of what is not finite
            observables = equations.scene.observe(np.hstack([q, v]).T, equations.parameters)
        return values | {name: observables[name] for name in missing}

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        system, rows = self.joint_system(case, model), []
        with self.session(system):
            for time, state in zip(times, states, strict=True):
                q, v = np.split(np.array(state), 2)
                answer = self.inner.accelerations(system, float(time), q, v)
                rows.append(numbers("accelerations", answer, q.shape, finite=True))
        return np.array(rows)

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n)."""
        system, n = self.joint_system(case, model), len(states[0]) // 2
        with self.session(system):
            return np.array(
                [
                    numbers(
                        "mass_matrix",
                        self.inner.mass_matrix(system, np.array(state[:n])),
                        (n, n),
                        finite=True,
                    )
                    for state in states
                ]
            )

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        return tuple(self.about(case, model).reactions) if "reactions" in self.functions else ()

    def joint_states(
        self, case: Case, model: str, times: Array, states: Array
    ) -> tuple[System, Array, Array]:
        """Return what the engine is told, and positions and velocities (k, n) at states."""
        q, v = np.split(states, 2, axis=1)
        return self.joint_system(case, model), q, v

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest or steady motion.

        In the coordinates that the engine gives them in, which may be fewer than the states'.
        """
        if "linearise" not in self.functions:
            return linearise(self, case, model, state)
        answer = self.inner.linearise(self.system_at(case, model, state))
        mass, damping, stiffness = matrices(answer)
        return mass, damping, stiffness
