"""What an engine is to simulate: an MJCF model in its own joints, with the parameters of a case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..reference.scene import Array, Case
from .mechanism import Closure, Term


@dataclass(frozen=True, eq=False)
class System:
    """What an engine is to simulate: a model of a scene, with the parameters of a case.

    Attributes
    ----------
    case : Case
        Its ``scene``, ``name`` and ``parameters`` say what it is.
    model : str
        Name of the MJCF model; ``scene`` for an engine that reads none.
    joints : tuple of str
        Names of all joints, in the order of the file; all vectors here are in this order. For
        an engine that reads no MJCF, the scene's coordinates.
    positions, velocities : array (n,)
        The initial state (m, rad and 1/s of them).
    start_time : float
        Time of the initial state [s].
    mjcf : str
        Text of the file, parameters applied; empty for an engine that reads none.
    terms : tuple of Term
        Its springs, dampers, tendons and actuators, which include all forcing; actuators in the
        order of the file.
    armatures : mapping of joint to float
        Inertia added to the diagonal of the mass matrix (kg, kg m^2).
    closures : tuple of Closure
        Loops, held closed by constraints.
    drivers : tuple of str
        Joints of bodies that move as the drive does, so heavy that nothing else moves them.
    observables : tuple of str
        What is looked at beside the coordinates; the file's sensors have these names.
    reactions : mapping of str to (element, axis)
        Forces in joints that may be asked for: the component, along an axis of the world
        (0, 1, 2), of the force that ``body:name`` puts on its parent, or ``connect:name`` on the
        body of its first site. Empty for an engine that reads no MJCF.
    """

    case: Case
    model: str
    joints: tuple[str, ...]
    positions: Array
    velocities: Array
    start_time: float = 0.0
    mjcf: str = ""
    terms: tuple[Term, ...] = ()
    armatures: Mapping[str, float] | None = None
    closures: tuple[Closure, ...] = ()
    drivers: tuple[str, ...] = ()
    observables: tuple[str, ...] = ()
    reactions: Mapping[str, tuple[str, int]] = field(default_factory=dict)

    @property
    def drive_end(self) -> float | None:
        """When what drives it ends [s]: all actuators are switched off then; None: never."""
        return next((term.until for term in self.terms if term.until is not None), None)

    def force(self, time: float, positions: Array, velocities: Array) -> Array:
        """Return the generalised force (n,) of all `terms` at a time [s] and state (n,), (n,)."""
        factors, constant, per_length, per_rate, amplitude, omega, phase, until = self._rows
        along = constant + per_length * (factors @ positions) + per_rate * (factors @ velocities)
        along = along + amplitude * np.cos(omega * time + phase)
        forces: Array = np.where(time < until, along, 0.0) @ factors
        return forces

    def controls(self, time: float) -> Array:
        """Return the controls (n_actuators,) of all actuators of the file at a time [s].

        Of those that take none it is 0.
        """
        return np.array([term.control(time) for term in self.terms if term.kind == "actuator"])

    @cached_property
    def _rows(self) -> tuple[Array, ...]:
        """All terms together: factors (k, n), the numbers of each (k,), and when it ends (k,)."""
        numbers = np.array([[getattr(t, name) for name in NUMBERS] for t in self.terms])
        ends = [np.inf if t.until is None else t.until for t in self.terms]
        factors = [[t.joints.get(name, 0.0) for name in self.joints] for t in self.terms]
        shape = len(self.terms), len(self.joints)
        return np.reshape(factors, shape), *numbers.reshape(-1, len(NUMBERS)).T, np.array(ends)


NUMBERS = ("constant", "per_length", "per_rate", "amplitude", "omega", "phase")
"""Of a term."""


def term_force(
    term: Term, joints: tuple[str, ...], time: float, positions: Array, velocities: Array
) -> Array:
    """Return the generalised force (n,) of one term at a time [s]."""
    factors = np.array([term.joints.get(name, 0.0) for name in joints])
    if term.until is not None and time >= term.until:
        return 0 * factors
    length, rate = factors @ positions, factors @ velocities
    passive = term.constant + term.per_length * length + term.per_rate * rate
    return factors * (passive + term.control(time))
