"""The system that an engine simulates: an MJCF model with the parameters of a case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..reference.scene import Array, Case
from .joints import SPATIAL, JointLayout, layout_of
from .mechanism import Closure, Term


@dataclass(frozen=True, eq=False)
class System:
    """The system that an engine simulates: a model of a scene with the parameters of a case.

    Attributes
    ----------
    case : Case
        Its ``scene``, ``name`` and ``parameters`` say what it is.
    model : str
        Name of the MJCF model; ``scene`` for an engine that reads none.
    joints : tuple of str
        Names of all joints, in the order of the file; all vectors here are in this order. For
        an engine that reads no MJCF, the scene's coordinates.
    positions : array (n_q,)
    velocities : array (n,)
        The initial state (m, rad and 1/s of them). A ball joint has a quaternion (w, x, y, z) and
        an angular velocity in the frame of its body, see `layout`; else n_q = n.
    start_time : float
        Time of the initial state [s].
    mjcf : str
        Text of the file, parameters applied; empty for an engine that reads none.
    path : str
        The file of a model of the user's, beside which its meshes are; empty for a scene.
    terms : tuple of Term
        Its springs, dampers, tendons and actuators, which include all forcing; actuators in the
        order of the file. The damper of a ball joint acts against its angular velocity.
    armatures : mapping of joint to float
        Inertia added to the diagonal of the mass matrix (kg, kg m^2).
    closures : tuple of Closure
        Loops, closed by constraints.
    kinds : tuple of str
        Of the joints: ``hinge``, ``slide``, ``ball`` or ``free``.
    drivers : tuple of str
        Joints of bodies that move as the drive does, so heavy that nothing else moves them.
    observables : tuple of str
        Outputs that are compared as well as the coordinates; the file's sensors have these names.
    reactions : mapping of str to (element, array (3,))
        Forces in joints that `Engine.reactions` returns: the component, along a direction in the
        world, of the force that ``body:name`` puts on its parent, or ``connect:name`` on the body
        of its first site. Empty for an engine that reads no MJCF.
    """

    case: Case
    model: str
    joints: tuple[str, ...]
    positions: Array
    velocities: Array
    start_time: float = 0.0
    mjcf: str = ""
    path: str = ""
    terms: tuple[Term, ...] = ()
    armatures: Mapping[str, float] | None = None
    closures: tuple[Closure, ...] = ()
    kinds: tuple[str, ...] = ()
    drivers: tuple[str, ...] = ()
    observables: tuple[str, ...] = ()
    reactions: Mapping[str, tuple[str, Array]] = field(default_factory=dict)

    @cached_property
    def layout(self) -> JointLayout:
        """Places of each joint in vectors of positions and of velocities."""
        return layout_of(self.kinds or ("hinge",) * len(self.joints))

    def displaced(self, positions: Array, change: Array) -> Array:
        """Return positions (n_q,) after constant velocities (n,) times a time: ``change``.

        The sum of both but for quaternions, which turn and keep their length.
        """
        return self.layout.displaced(positions, change)

    @property
    def drive_end(self) -> float | None:
        """When what drives it ends [s]: all actuators are switched off then; None: never."""
        return next((term.until for term in self.terms if term.until is not None), None)

    def force(self, time: float, positions: Array, velocities: Array) -> Array:
        """Return the generalised force (n,) of all `terms` at a time [s] and state (n,), (n,)."""
        factors, constant, per_length, per_rate, amplitude, omega, phase, until = self._rows
        lengths = factors @ scalar_positions(self.layout, positions)
        along = constant + per_length * lengths + per_rate * (factors @ velocities)
        along = along + amplitude * np.cos(omega * time + phase)
        return np.asarray(np.where(time < until, along, 0.0) @ factors)

    def controls(self, time: float) -> Array:
        """Return the controls (n_actuators,) of all actuators of the file at a time [s].

        Of those that take none it is 0.
        """
        return np.array([term.control(time) for term in self.terms if term.kind == "actuator"])

    @cached_property
    def _rows(self) -> tuple[Array, ...]:
        """All terms together: factors (k, n), the numbers of each (k,), and when it ends (k,)."""
        numbers = np.array([[getattr(t, name) for name in NUMBERS] for t in self.terms])
        ends = np.array([np.inf if t.until is None else t.until for t in self.terms])
        rows = [factors_of(t, self.joints, self.layout) for t in self.terms]
        of = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
        factors = np.vstack([np.zeros((0, self.layout.size[1])), *rows])
        return factors, *numbers.reshape(-1, len(NUMBERS))[of].T, ends[of]


NUMBERS = ("constant", "per_length", "per_rate", "amplitude", "omega", "phase")
"""The numbers of a term."""


def factors_of(term: Term, joints: tuple[str, ...], layout: JointLayout) -> Array:
    """Return by how much each velocity (1, n) lengthens a term of hinges and slides.

    Of the damper of a ball joint there is a row (3, n) for each component of its angular velocity.
    """
    size = layout.size[1]
    factors = np.zeros((1, size))
    for name, kind, own in zip(joints, layout.kinds, layout.velocities, strict=True):
        if kind in SPATIAL and name in term.joints:
            return np.eye(size)[own]
        factors[:, own] = term.joints.get(name, 0.0)
    return factors


def scalar_positions(layout: JointLayout, positions: Array) -> Array:
    """Return positions (n,) in the places of velocities: of hinges and slides, 0 of all others."""
    if not layout.is_spatial:
        return positions
    scalars = np.zeros(layout.size[1])
    for kind, at, own in zip(layout.kinds, layout.positions, layout.velocities, strict=True):
        if kind not in SPATIAL:
            scalars[own] = positions[at]
    return scalars


def term_force(
    term: Term, system: System, time: float, positions: Array, velocities: Array
) -> Array:
    """Return the generalised force (n,) of one term of a system at a time [s]."""
    return replace(system, terms=(term,)).force(time, positions, velocities)
