"""What rules look at: a model with what was found about it, and how they tell a finding."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from .findings.contact import touching
from .mujoco.mujoco_closures import Closure
from .mujoco.mujoco_facts import Facts
from .mujoco.mujoco_linear import Linear
from .mujoco.mujoco_model import Loaded, State
from .source import Element
from .spectrum import Shape

Severity = Literal["error", "warning", "note"]


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
    held : str or None
        The hinge that turns steadily, and is held at its speed.
    """

    state: State
    linear: Linear | None = None
    modes: tuple[Shape, ...] = ()
    simulated: tuple[Shape, ...] = ()
    reason: str | None = None
    failed: bool = False
    held: str | None = None


@dataclass(frozen=True)
class StepLimit:
    """The largest stable step of an integrator over all states.

    Attributes
    ----------
    integrator : str
    limit : float
        [s]; infinite if every step is stable.
    state : str or None
        Where it is least.
    omega : float or None
        Of the mode that sets it [1/s].
    joint : str or None
        That moves most in it.
    chosen : bool
        Whether it is the file's own.
    """

    integrator: str
    limit: float
    state: str | None
    omega: float | None
    joint: str | None
    chosen: bool


@dataclass(frozen=True)
class Subject:
    """A model, and what was found about it."""

    loaded: Loaded
    facts: Facts
    views: tuple[View, ...]
    steps: tuple[StepLimit, ...]
    shortest_period: float | None
    closures: tuple[Closure, ...]

    @cached_property
    def touching(self) -> np.ndarray:
        """Which geoms (ngeom,) can touch another."""
        return touching(self.loaded, self.facts.options.contact)

    @property
    def timestep(self) -> float:
        """Of the file [s]."""
        return self.facts.options.timestep

    def hit(
        self, kind: str, number: int, message: str, fix: str = "", attribute: str | None = None
    ) -> Hit:
        """Return a finding about an object."""
        element = self.loaded.element(kind, number)
        name = f"{kind}:{self.loaded.name(kind, number)}"
        return Hit(element, element.address if element else name, message, fix, attribute)

    def section(self, *tags: str) -> Element | None:
        """Return the last element of the text that has the first of these tags that is there."""
        for tag in tags:
            found = [e for e in self.loaded.source.root.children if e.tag == tag.split("/")[0]]
            if "/" in tag:
                found = [
                    child for e in found for child in e.children if child.tag == tag.split("/")[1]
                ]
            if found:
                return found[-1]
        return None

    def about(self, *tags: str, message: str, fix: str = "") -> Hit:
        """Return a finding about a section of the file, or about the file itself."""
        element = self.section(*tags)
        return Hit(element, tags[0].rpartition("/")[2], message, fix, None)


class Hit(NamedTuple):
    """What a rule found: where, a sentence with its numbers, and what to do.

    ``attribute`` is the one of the element that is meant, if it is one. ``fix`` is empty where
    that of the rule says all.
    """

    element: Element | None
    name: str
    message: str
    fix: str = ""
    attribute: str | None = None


@dataclass(frozen=True)
class Words:
    """What is said of a rule: its meaning in few words, why it matters, and what to do."""

    severity: Severity
    meaning: str
    why: str
    fix: str


@dataclass(frozen=True)
class Rule(Words):
    """A rule, and how it is found."""

    find: Callable[[Subject], Iterator[Hit]]
