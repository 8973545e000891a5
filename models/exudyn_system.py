"""What an Exudyn model of a scene is, and how it is driven without Python in the loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from ..reference.scene import Array

# As Any, since Exudyn's type stubs refuse calls that it documents.
exudyn: Any = import_module("exudyn")
items: Any = import_module("exudyn.itemInterface")
utilities: Any = import_module("exudyn.advancedUtilities")


@dataclass(frozen=True)
class System:
    """An assembled Exudyn system of a scene, with n coordinates out of N.

    Attributes
    ----------
    mbs : exudyn.MainSystem
    place : callable ``(q, v) -> (Q, V)``
        ODE2 coordinates (N,), less the reference coordinates, and their rates, of scene
        coordinates (n,) and rates; constraints are met in position and velocity.
    readout : array (n, N)
        And back: ``q = readout @ Q``, likewise for rates and accelerations.
    container : exudyn.SystemContainer
        Holder of ``mbs``; its ``Reset`` frees the memory, which Exudyn else keeps.
    functions : tuple of exudyn.symbolic.UserFunction
        Must live as long as ``mbs``.
    outputs : callable ``(Q (N, k), V (N, k)) -> {name: array (k,)}``
        The scene's observed outputs, as this system has them.
    """

    mbs: Any
    place: Callable[[Array, Array], tuple[Array, Array]]
    readout: Array
    container: Any
    functions: tuple[Any, ...] = ()
    outputs: Callable[[Array, Array], Mapping[str, Array]] = lambda coordinates, rates: {}


@dataclass(frozen=True)
class Model:
    """One way to model the scene.

    Attributes
    ----------
    build : callable ``(parameters) -> System``
    constrained : bool
        Whether it has algebraic constraints, which Exudyn's explicit solvers cannot keep.
    reactions : mapping of output to int
        Which output of the scene is which Lagrange multiplier, counted over the joints in the
        order in which they were added: the force of a joint on the body of its first marker.
    why_not : callable ``(parameters) -> str or None``
        Why the model cannot stand for the scene with these parameters.
    """

    build: Callable[[Any], System]
    constrained: bool
    reactions: Mapping[str, int] = field(default_factory=dict)
    why_not: Callable[[Any], str | None] = lambda parameters: None


def harmonic_load(mbs: Any, marker: Any, amplitude: float, omega: float) -> tuple[Any, ...]:
    """Put a load amplitude * cos(omega t) on a coordinate; return what must stay alive.

    Symbolic, so that Exudyn evaluates it in C++ at the time of every stage.
    """

    def force(mbs: Any, t: Any, load: Any) -> Any:
        return load * exudyn.symbolic.cos(float(omega) * t)

    symbolic = utilities.CreateSymbolicUserFunction(
        mbs, function=force, userFunctionName="loadUserFunction", itemTypeName="LoadCoordinate"
    )
    mbs.AddLoad(
        items.LoadCoordinate(markerNumber=marker, load=amplitude, loadUserFunction=symbolic)
    )
    return (symbolic,)
