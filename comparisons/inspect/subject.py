"""What rules look at: a model with all that is computed of it, and how they state a finding."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple, SupportsInt

import numpy as np

from ..checks.rules.conditions import Statement
from ..documents.fields import Number
from .mujoco.closures import ClosedLoop
from .mujoco.facts import Facts, can_touch, meetings
from .mujoco.linear import Linear
from .mujoco.model import Flags, Loaded, Numbers, State
from .mujoco.source import Element
from .spectrum import Shape

Severity = Literal["error", "warning", "note"]

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
"""The worst first."""

Needs = Literal["model", "states", "modes", "runs", "findings"]

OSCILLATING = 1.0
"""Modes whose damping ratio is below this have a period to speak of."""


@dataclass(frozen=True)
class View:
    """A state, and small motions about it.

    Attributes
    ----------
    state : State
    linear : Linear or None
    modes : tuple of Shape
        Loops closed exactly; vectors (nv,).
    simulated : tuple of Shape
        All constraints as soft as they are.
    reason : str or None
        Why there are no modes.
    failed : bool
        True if that is because forces are not finite.
    steady_hinge : str or None
        The hinge that turns steadily, and keeps its speed.
    """

    state: State
    linear: Linear | None = None
    modes: tuple[Shape, ...] = ()
    simulated: tuple[Shape, ...] = ()
    reason: str | None = None
    failed: bool = False
    steady_hinge: str | None = None


@dataclass(frozen=True)
class StepLimit:
    """The largest stable step of an integrator over all states.

    Attributes
    ----------
    integrator : str
        as MJCF spells it
    limit : float
        [s]; null if every step is stable
    state : str or None
        state where it is least; null if every step is stable
    omega : float or None
        modulus of the mode that sets it [1/s]; null if there is none
    joint : str or None
        joint that moves most in that mode; null if there is none
    of_file : bool
        whether the file uses this integrator
    constraint : str or None
        closure, limit, contact or dry friction that sets it; null if none does
    softened : float
        step from which on constraints are softened [s] (refsafe); null if none is
    """

    integrator: str
    limit: Number
    state: str | None
    omega: float | None
    joint: str | None
    of_file: bool
    constraint: str | None = None
    softened: Number = math.inf

    @property
    def place(self) -> str:
        """What sets it, in words."""
        return self.constraint or str(self.joint)

    def share_of(self, step: float) -> float:
        """Return by what share of its limit a step [s] is long; 0 if nothing limits it."""
        return step / self.limit if self.limit > 0 else math.inf


class Hit(NamedTuple):
    """What a rule finds: where, a sentence with its numbers, and what to do.

    ``attribute`` is the one of the element that is meant, if it is one. ``fix`` is empty where
    that of the rule says all. ``measure`` tells how bad it is, the larger the worse.
    """

    element: Element | None
    name: str
    message: str
    fix: str = ""
    attribute: str | None = None
    measure: float | None = None


@dataclass(frozen=True)
class InspectedModel:
    """A model, and all that is computed of it.

    Attributes
    ----------
    loaded : Loaded
    facts : Facts
    strict : bool
        Whether the rules of the house count, too.
    views : tuple of View
        States with their modes; empty until they are computed, as what follows.
    steps : tuple of StepLimit
        Of each integrator; empty without modes.
    closures : tuple of Closure
        Stiffest first.
    """

    loaded: Loaded
    facts: Facts
    strict: bool
    views: tuple[View, ...] = ()
    steps: tuple[StepLimit, ...] = ()
    closures: tuple[ClosedLoop, ...] = ()

    @property
    def shortest_period(self) -> float | None:
        """Of all modes as simulated [s]; None if nothing oscillates."""
        rates = [
            mode.rate.imag
            for one in self.views
            for mode in one.simulated
            if mode.rate.imag > 0 and (mode.damping_ratio or 0.0) < OSCILLATING
        ]
        return 2 * math.pi / max(rates) if rates else None

    @cached_property
    def can_touch(self) -> np.ndarray:
        """Which geoms (ngeom,) can touch another."""
        return can_touch(self.loaded, self.facts.options.contact)

    @cached_property
    def meetings(self) -> dict[tuple[int, int], int]:
        """How often two geoms of one mechanism lie in each other as its joints move."""
        possible = self.facts.options.contact and bool(np.any(self.can_touch))
        return meetings(self.loaded) if possible else {}

    @property
    def model(self) -> Any:
        """MuJoCo's ``MjModel``."""
        return self.loaded.model

    @property
    def timestep(self) -> float:
        """Of the file [s]."""
        return self.facts.options.timestep

    @property
    def limits_of_file(self) -> list[StepLimit]:
        """The stability limit of the file's own integrator, if it has one that is known."""
        return [one for one in self.steps if one.of_file and 0 < one.limit < math.inf]

    def hit(self, kind: str, number: SupportsInt, message: str, **more: Any) -> Hit:
        """Return a finding about an object; ``more`` are further fields of it."""
        element = self.loaded.places.get((kind, int(number)))
        name = element.address if element else f"{kind}:{self.loaded.name(kind, number)}"
        return Hit(element, name, message, **more)

    def hits(
        self,
        kind: str,
        where: Flags,
        message: str | Callable[[int], str],
        of: Numbers | None = None,
        attribute: str | None = None,
    ) -> Iterator[Hit]:
        """Yield a finding about each object of a kind for which an array is true.

        Parameters
        ----------
        kind : str
        where : array (n,)
        message : str, or callable from an index of that array
        of : array (n,), optional
            The number of the object of each index.
        attribute : str, optional
            See `Hit`.
        """
        for i in np.flatnonzero(where):
            words = message if isinstance(message, str) else message(int(i))
            yield self.hit(kind, i if of is None else of[i], words, attribute=attribute)

    @cached_property
    def sections(self) -> dict[str, Element]:
        """The last section of each name, and of each name in it, as ``option/flag``."""
        tops = self.loaded.source.root.children
        parts = {f"{top.tag}/{part.tag}": part for top in tops for part in top.children}
        return {top.tag: top for top in tops} | parts

    def about(self, *paths: str, message: str, **more: Any) -> Hit:
        """Return a finding about the first of these sections that the file has, or about it."""
        element = next((self.sections[path] for path in paths if path in self.sections), None)
        return Hit(element, paths[0].rpartition("/")[2], message, **more)

    def state(self, statement: Statement | None, *paths: str) -> Iterator[Hit]:
        """Yield what a rule says about one of these sections, if it says anything."""
        if statement is not None:
            yield self.about(*paths, message=statement.message, fix=statement.fix)

    def setting(self, key: str) -> str:
        """Return an attribute of the compiler's, the last that stands in the file; or nothing."""
        elements = self.loaded.source.tagged("compiler")
        return next((e.attributes[key] for e in elements[::-1] if key in e.attributes), "")


@dataclass(frozen=True)
class ModelRule:
    """A rule: what is said of it, and how its mistakes are found.

    Attributes
    ----------
    severity : {"error", "warning", "note"}
    meaning : str
        In few words.
    why : str
        Why it matters.
    fix : str
        What to do.
    find : callable
        From a model to the findings; those of a rule that needs the others' are made of these.
    needs : {"model", "states", "modes", "runs", "findings"}
        What is computed before it is asked: nothing beside the model as it is compiled, its states
        with the loads of their loops, small motions about these (`--no-modes` leaves such rules
        out), short runs, or the findings of all other rules.
    house : bool
        Whether it is a matter of taste, which is looked for only if asked for.
    """

    severity: Severity
    meaning: str
    why: str
    fix: str
    find: Callable[[InspectedModel], Iterator[Hit]] = lambda _: iter(())
    needs: Needs = "model"
    house: bool = False
