"""What scenes with a floating base share: outputs, what they conserve, rest, mistakes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..errors import NoOrbitError
from ..scene import Case, Scene, with_placements, with_rates
from .floating import FloatingTree
from .floating_mistakes import hinge_mistakes
from .mistakes import with_mistakes
from .rotation import (
    AXES,
    COORDINATES,
    MOMENTUM,
    QUATERNION,
    RATES,
    ROTATION,
    UNITS,
    accelerations_by,
    rotation_outputs,
)

LINEAR = tuple(f"linear_{name}" for name in MOMENTUM)
"""Components in the world of the linear momentum."""


def outputs(tree: FloatingTree, q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
    """Return attitude, body rates, both momenta, energy, length of q.

    The angular momentum is that about the centre of mass.
    """
    turning, energy = tree.angular_momentum(q, v, c), tree.energy(q, v, c)
    rotation = rotation_outputs(q[-4:], v[-4:], turning, energy, xp)
    return rotation | dict(zip(LINEAR, tree.momentum(q, v, c), strict=True))


def component(of: Callable[..., list[Any]], axis: int, q: Any, v: Any, c: Any) -> Any:
    """Return one of the components of a vector."""
    return of(q, v, c)[axis]


def invariants(
    tree: FloatingTree, keeps_energy: Callable[[Any], bool], p: Any
) -> Mapping[str, Callable[..., Any]]:
    """Return the angular momentum; without gravity the linear one; energy, if it is kept."""
    known: dict[str, Callable[..., Any]] = {}
    if keeps_energy(p):
        known["energy"] = tree.energy
    for axis, (turning, moving) in enumerate(zip(MOMENTUM, LINEAR, strict=True)):
        known[turning] = partial(component, tree.angular_momentum, axis)
        if not np.any(p.gravity):
            known[moving] = partial(component, tree.momentum, axis)
    return known


def afloat(name: str, p: Any) -> dict[str, float]:
    """Return the state of rest, which is any place and attitude with the springs relaxed.

    Raises
    ------
    NoOrbitError
        If it falls.
    """
    if np.any(p.gravity):
        raise NoOrbitError(f"nothing holds {name}: with gravity it falls")
    return {}


def floating_scene(
    tree: FloatingTree,
    coefficients_of: Callable[..., Any],
    keeps_energy: Callable[[Any], bool],
    placed: Case,
    **fields: Any,
) -> Scene:
    """Return the scene of a tree.

    Parameters
    ----------
    tree : FloatingTree
    coefficients_of : callable ``(parameters, inertia tensor) -> c``
    keeps_energy : callable ``(parameters) -> bool``
        Whether nothing drives it and nothing damps.
    placed : Case
        That of which the default set has a model that is turned; a mirror has other quaternions.
    fields :
        Others of `Scene`; of ``coordinates`` and ``units`` those of the hinges alone.
    """
    hinges = fields.pop("coordinates")
    units = {**dict.fromkeys(AXES, "m"), **fields.pop("units"), **dict.fromkeys(COORDINATES, "1")}
    scene = Scene(
        coordinates=(*AXES, *hinges, *COORDINATES),
        quaternions=(QUATERNION._replace(place=tuple(AXES)),),
        units=with_rates(**units) | UNITS | dict.fromkeys(LINEAR, "kg m/s"),
        eliminates=True,
        mass_matrix=tree.mass_matrix,
        forces=tree.forces,
        accelerations=accelerations_by(tree.body_accelerations, 3 + len(hinges)),
        energy=tree.energy,
        outputs=partial(outputs, tree),
        observed=(*ROTATION, *RATES),
        equilibria={"afloat": partial(afloat, fields["name"])},
        invariants=partial(invariants, tree, keeps_energy),
        placed=with_placements(placed, "algebra")[:1],
        **fields,
    )
    turning = {
        words: one
        for words, one in with_mistakes(scene, tree.body_accelerations, coefficients_of).items()
        if "gravity" not in words  # of which no torque acts about the centre of mass
    }
    return replace(scene, mistakes=turning | hinge_mistakes(scene, tree))
