"""Input and output of rules: a model with everything computed about it, and findings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple, SupportsInt

import numpy as np

from ..checks.rules.conditions import Statement
from ..documents.fields import HIDDEN, documented
from .mujoco.closures import ClosedLoop
from .mujoco.facts import Facts, can_touch, meetings
from .mujoco.linear import Linear
from .mujoco.model import Flags, Loaded, Numbers
from .mujoco.source import Element
from .tuning import NUMERICS
from .views import Shape, StepLimit, View, fed_growth

Severity = Literal["error", "warning", "note"]

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
"""Severities, the worst first."""

Needs = Literal["model", "states", "modes", "runs", "findings"]


class Hit(NamedTuple):
    """A finding of a rule: element and its name, a sentence with numbers, and a remedy.

    ``attribute`` is the wrong attribute of the element, if it is one. ``fix`` is empty
    where that of the rule suffices. ``measure`` is the larger the worse. ``causes`` are findings,
    by rule and name of the element, which state the same mistake and are left out.
    """

    element: Element | None
    name: str
    message: str
    fix: str = ""
    attribute: str | None = None
    measure: float | None = None
    causes: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class InspectedModel(Facts):
    """A model, and everything computed about it.

    Attributes
    ----------
    loaded : Loaded
    strict : bool
        True if rules of the house count, too.
    views : tuple of View
        States with their modes; empty until they are computed, as all that follows.
    steps : tuple of StepLimit
        largest stable step of each integrator; empty without modes
    closures : tuple of ClosedLoop
        closures of loops in each state, the stiffest first
    rejected : dict of str to str
        Integrators that rules have tried as a remedy -> the fault of their runs.
    """

    loaded: Loaded = field(metadata=HIDDEN)
    strict: bool = field(metadata=HIDDEN)
    views: tuple[View, ...] = field(default=(), metadata=HIDDEN)
    steps: tuple[StepLimit, ...] = ()
    closures: tuple[ClosedLoop, ...] = ()
    rejected: dict[str, str] = field(default_factory=dict, metadata=HIDDEN)

    @property
    @documented
    def shortest_period(self) -> float | None:
        """Shortest period of all modes as simulated [s]; null if nothing oscillates."""
        rates = [
            mode.rate.imag
            for one in self.views
            for mode in one.simulated
            if mode.rate.imag > 0 and (mode.damping_ratio or 0.0) < NUMERICS.max_damping_ratio
        ]
        return 2 * math.pi / max(rates) if rates else None

    @cached_property
    def can_touch(self) -> np.ndarray:
        """Geoms (ngeom,) that can touch another one."""
        return can_touch(self.loaded, self.options.contact)

    @cached_property
    def meetings(self) -> dict[tuple[int, int], int]:
        """Number of random positions in which two geoms of one mechanism overlap."""
        possible = self.options.contact and bool(np.any(self.can_touch))
        return meetings(self.loaded) if possible else {}

    @cached_property
    def fed_growth(self) -> list[tuple[View, Shape]]:
        """Modes that drives or dampers feed, one of each joint; runs have shown their growth."""
        return list(fed_growth(self.loaded, self.views))

    @property
    def model(self) -> Any:
        """MuJoCo's ``MjModel``."""
        return self.loaded.model

    @property
    def timestep(self) -> float:
        """Timestep of the file [s]."""
        return self.options.timestep

    @property
    def linear_views(self) -> list[tuple[View, Linear]]:
        """States that have small motions, and these."""
        return [(one, one.linear) for one in self.views if one.linear is not None]

    @property
    def limits_of_file(self) -> list[StepLimit]:
        """Largest stable step of the file's integrator, if it is known."""
        return [one for one in self.steps if one.of_file and 0 < one.limit < math.inf]

    def size_of(self, closure: ClosedLoop) -> float:
        """Return the unit of a closure's opening: the size of the model [m], or 1 rad."""
        return self.size if closure.kind in ("connect", "weld") else 1.0

    def hit(self, kind: str, number: SupportsInt, message: str, **more: Any) -> Hit:
        """Return a finding about an object, with further fields of `Hit`."""
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
            Number of the object of each index.
        attribute : str, optional
            See `Hit`.
        """
        for i in np.flatnonzero(where):
            words = message if isinstance(message, str) else message(int(i))
            yield self.hit(kind, i if of is None else of[i], words, attribute=attribute)

    @cached_property
    def sections(self) -> dict[str, Element]:
        """Last section of each name, and of each name in it, as ``option/flag``."""
        tops = self.loaded.source.root.children
        parts = {f"{top.tag}/{part.tag}": part for top in tops for part in top.children}
        return {top.tag: top for top in tops} | parts

    def about(self, *paths: str, message: str, **more: Any) -> Hit:
        """Return a finding about the first of these sections that the file has."""
        element = next((self.sections[path] for path in paths if path in self.sections), None)
        return Hit(element, paths[0].rpartition("/")[2], message, **more)

    def state(self, statement: Statement | None, *paths: str) -> Iterator[Hit]:
        """Yield the statement of a rule about one of these sections, if there is any."""
        if statement is not None:
            yield self.about(*paths, message=statement.message, fix=statement.fix)

    def setting(self, key: str) -> str:
        """Return the last value of an attribute of the compiler; empty if there is none."""
        elements = self.loaded.source.tagged("compiler")
        return next((e.attributes[key] for e in elements[::-1] if key in e.attributes), "")


@dataclass(frozen=True)
class ModelRule:
    """A rule: its texts, and the function that finds its mistakes.

    Attributes
    ----------
    severity : {"error", "warning", "note"}
    meaning : str
        Short name of the mistake.
    why : str
        Reason why it matters.
    fix : str
        Remedy.
    find : callable
        From a model to the findings; rules that need those of others are evaluated with them.
    needs : {"model", "states", "modes", "runs", "findings"}
        Input computed first: nothing but the compiled model, its states with the loads of
        their loops, small motions about these (`--no-modes` leaves such rules out), short runs, or
        the findings of all other rules.
    house : bool
        True for a matter of taste, which ``--strict`` or ``--select`` includes.
    """

    severity: Severity
    meaning: str
    why: str
    fix: str
    find: Callable[[InspectedModel], Iterator[Hit]] = lambda _: iter(())
    needs: Needs = "model"
    house: bool = False
