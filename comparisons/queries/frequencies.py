"""``frequencies``: the modes of a scene about a state of rest or of steady motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...reference.bounds.modes import Entries, bounded_modes, linearisation_error
from ...reference.errors import UnknownNameError, UsageError
from ...reference.linear import Mode, linearise, modes
from ...reference.scene import Array
from ..checks import elements
from ..checks.kinds.frequency import resting
from ..documents import document
from ..documents.fields import takes_fields_of
from ..engines.registry import REFERENCE
from ..engines.run import call_engine
from ..engines.setup import Setup
from .query import Origin, by_state, described, floats
from .request import FrequenciesRequest

CONTINUUM_MODES = 4
"""Modes of a continuum that are returned by default."""

PLANES = ("chordwise", "flapwise")


@dataclass(frozen=True)
class Frequencies(Origin):
    """The modes about a state of rest or of steady motion, without forces and motors.

    Attributes
    ----------
    undamped : bool
        whether damping was left out
    about : str
        name of the state of rest, or of steady motion
    plane : str or None
        `chordwise` or `flapwise` of a rotating beam; null for other scenes
    state : mapping of str to float
        that state [SI]
    unforced : mapping of str to float
        parameters that switch forces and motors off, where they differ from `parameters`
    steady : tuple of str
        coordinates that keep their speed
    modes : tuple of Mode
        ascending in omega, zero modes listed; a complex pair of eigenvalues is one mode. The lowest
        `--count`: all by default, four of the reference's continuum
    """

    undamped: bool
    about: str
    plane: str | None
    state: Mapping[str, float]
    unforced: Mapping[str, float | str]
    steady: tuple[str, ...]
    modes: tuple[Mode, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the ``frequencies`` document of docs/json.md."""
        return document("frequencies", self)


@takes_fields_of(FrequenciesRequest)
def frequencies(asked: FrequenciesRequest) -> Frequencies:
    """Find the modes about a state of rest or steady motion, without forces and motors.

    Takes the fields of `FrequenciesRequest`.

    Raises
    ------
    UsageError
        For unknown names or impossible values.
    EngineError
        If the engine failed.
    """
    setup, scene, plane, count = asked.model_setup(), asked.scene, asked.plane, asked.count
    places = setup.scene.equilibria
    about = next(iter(places)) if asked.about is None else asked.about
    if about not in places:
        raise UnknownNameError(f"state of rest of {scene}", about, places)
    if count is not None and count < 1:
        raise UsageError(f"the number of modes must be 1 or more, not {count}")
    unforced = setup.scene.unforced(setup.case.parameters)
    still = setup.with_case(replace(setup.case, parameters=unforced, about=about))
    _, _, state, steady = resting(still.case)
    if setup.scene.continuum.spectrum:
        plane = plane or elements.PLANE
        lowest = continuum_modes(still, plane, count or CONTINUUM_MODES)
    elif plane is not None:
        raise UsageError(f"{scene} has no planes of vibration: leave the plane out")
    elif still.engine.name == REFERENCE:
        lowest = reference_modes(still, state, steady, asked.undamped)
    else:
        mass, damping, stiffness = call_engine(lambda: still.bound.linearise(state))
        lowest = modes(mass, 0 * damping if asked.undamped else damping, stiffness, steady)
    values, used = by_state(setup.scene, state), unforced.as_dict()
    driven = setup.case.parameters.as_dict()
    return Frequencies(
        **described(setup),
        undamped=asked.undamped,
        about=about,
        plane=plane,
        state=floats({name: values[name] for name in setup.scene.public_states}),
        unforced={name: used[name] for name in used if used[name] != driven[name]},
        steady=tuple(setup.scene.coordinates[i] for i in steady),
        modes=tuple(without_minus_zero(mode) for mode in lowest[:count]),
    )


def reference_modes(
    setup: Setup, state: Array, steady: Sequence[int], undamped: bool
) -> list[Mode]:
    """Return the modes of a scene's equations of motion, with bounds on their errors."""
    equations = setup.bound.equations.scene, setup.case.parameters, state
    matrices, errors = Entries(*linearise(*equations)), linearisation_error(*equations)
    if undamped:
        none = np.zeros_like(matrices.damping)
        matrices, errors = matrices._replace(damping=none), errors._replace(damping=none)
    lowest = bounded_modes(matrices, errors, steady)
    if not setup.scene.quaternions:
        return lowest
    plain = modes(*matrices, steady)  # nothing keeps the lengths of quaternions either
    free = sum(mode.damping_ratio is None for mode in plain)
    elastic = len(plain) - free  # rounding makes a pair of modes of a free direction
    return [*plain[:free], *lowest[len(lowest) - elastic :]]


def continuum_modes(setup: Setup, plane: str, count: int) -> Sequence[Mode]:
    """Return the lowest modes of a continuum, or of an engine's discretisation of it.

    Raises
    ------
    UsageError
        For an unknown plane, or one in which the model cannot move.
    EngineError
        If the engine failed.
    """
    if plane not in PLANES:
        raise UnknownNameError("plane", plane, PLANES)
    spectrum = (
        setup.bound.equations.scene.continuum.spectrum if setup.engine.name == REFERENCE else None
    )
    if spectrum:
        lowest = zip(*spectrum(setup.bound.equations.parameters, plane, count), strict=True)
        return [
            Mode(0.0, float(w), float(w), float(w) / (2 * np.pi), 0.0, float(bound), 0.0)
            for w, bound in lowest
        ]
    if plane != elements.PLANE:
        raise UsageError(
            f"model {setup.model} of {setup.engine.name} stays in the plane of rotation; {plane} "
            "frequencies are those of the reference's exact models: use one of them"
        )
    return call_engine(lambda: elements.engine_modes(setup))[:count]


def without_minus_zero(mode: Mode) -> Mode:
    """Return a mode with zeros without sign."""
    ratio = None if mode.damping_ratio is None else mode.damping_ratio + 0.0
    return replace(mode, re=mode.re + 0.0, im=mode.im + 0.0, damping_ratio=ratio)
