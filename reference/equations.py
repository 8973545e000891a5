"""The equations of motion that an engine's model has, which need not be those of its scene.

Three layers are distinguished. The scene's equations are the truth. An engine's model may have
others: the difference is *model error*, which no step removes. The error of the method on the
model's equations is *integration error*.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from traceback import walk_tb
from types import FunctionType
from typing import Any, NamedTuple

from . import get_scene
from .scene import Array, Case, EquationsOfMotion


class ModelEquations(NamedTuple):
    """Equations of motion and their parameters; `scene` is another one where they differ."""

    scene: EquationsOfMotion
    parameters: Any

    def start(self, case: Case) -> Array:
        """Return the initial state (2 n,) of a case in the coordinates of these equations."""
        scene, own = get_scene(case.scene), {*self.scene.state_names}
        names = {*scene.state_names, *scene.initial_states}
        state = dict(embedded(self, case.scene, tuple(case.state.items())))
        # an unknown name is kept, for `Dynamics.state` to refuse
        state |= {
            name: value for name, value in case.state.items() if name in own or name not in names
        }
        if self.scene is not get_scene(case.scene):  # the scene itself cannot be off
            for name, offset in case.inconsistency.items():
                state[name] = state.get(name, 0.0) + offset
        return self.scene.state(state)

    def is_exact_for(self, case: Case) -> bool:
        """Return True if these are the scene's equations with the parameters of the case."""
        return self.scene is get_scene(case.scene) and self.parameters == case.parameters


@lru_cache(maxsize=64)
def embedded(
    equations: ModelEquations, scene: str, state: tuple[tuple[str, float], ...]
) -> Mapping[str, float]:
    """Return a state of a scene by the names of equations; that of elements is solved for."""
    values = get_scene(scene).completed(dict(state))
    return equations.scene.embedding(equations.parameters, values)


def scene_equations(case: Case) -> ModelEquations:
    """Return the scene's equations with the parameters of a case."""
    return ModelEquations(get_scene(case.scene), case.parameters)


def invariants_of(equations: ModelEquations) -> Mapping[str, Callable[..., Array]]:
    """Return the conserved quantities of undriven equations: the energy, and others they name."""
    scene = equations.scene
    if scene.invariants is None:
        return {"energy": scene.energy}
    return scene.invariants(scene.unforced(equations.parameters))


def function_that_raised(equations: ModelEquations, error: BaseException) -> str | None:
    """Return the function of these equations that an exception came out of, None if of none."""
    codes = {}
    for name, value in vars(equations.scene).items():
        function = value.func if isinstance(value, partial) else value
        if isinstance(function, FunctionType):
            codes[function.__code__] = name
    inside = [codes.get(frame.f_code) for frame, _ in walk_tb(error.__traceback__)]
    return next(filter(None, reversed(inside)), None)
