"""Exudyn with something undone that its adapter does, or with more than the adapter offers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ....reference.scene import Case
from ..adapter import OwnModelsAdapter
from ..exudyn.engine import Exudyn, assign
from ..protocol import Engine, Method

VELOCITY_VERLET = Method("VelocityVerlet", 2)
DVERK6 = Method("DVERK6", 6)


class Hooked(Exudyn):
    """Exudyn that takes its parts from its adapter, where classes exchange them."""

    owner: ExudynAdapter

    def source(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model."""
        return self.owner.own_source(case, model)

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        return self.owner.system(case, model)

    def settings(self, *call: Any) -> Any:
        """Return Exudyn's settings."""
        return self.owner.settings(*call)

    def solver(self, method: Method) -> Any:
        """Return a new solver."""
        return self.owner.solver(method)


class ExudynAdapter(OwnModelsAdapter):
    """Exudyn as it is, for classes that exchange parts of it."""

    methods = Exudyn.methods
    inner: Hooked

    def __init__(self) -> None:
        methods = self.methods
        super().__init__(Hooked())
        self.methods = methods

    def hold(self, inner: Engine) -> None:
        """Take an engine, which then takes its parts from here."""
        super().hold(inner)
        self.inner.owner = self

    def own_source(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model."""
        return Exudyn.source(self.inner, case, model)

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        return Exudyn.system(self.inner, case, model)

    def settings(self, method: Method, start: float, step: float, large: bool = False) -> Any:
        """Return Exudyn's settings for a method with this step, from this time on."""
        return Exudyn.settings(self.inner, method, start, step, large)

    def solver(self, method: Method) -> Any:
        """Return a new solver of Exudyn for a method."""
        return Exudyn.solver(self.inner, method)


class Changed(ExudynAdapter):
    """Exudyn with other settings of its time integration.

    Parameters
    ----------
    changes : mapping of str to value
        By name below ``timeIntegration``.
    """

    def __init__(self, changes: Mapping[str, Any]) -> None:
        super().__init__()
        self.changes = changes

    def settings(self, method: Method, start: float, step: float, large: bool = False) -> Any:
        """Return the adapter's settings, changed."""
        settings = super().settings(method, start, step, large)
        for name, value in self.changes.items():
            assign(settings, f"timeIntegration.{name}", value)
        return settings


class Unrestricted(ExudynAdapter):
    """Exudyn without the adapter's refusals, and with explicit solvers that it leaves out."""

    methods = (*Exudyn.methods, VELOCITY_VERLET, DVERK6)

    def why_not(self, case: Case, model: str, method: Method | None) -> None:
        """Refuse nothing."""

    def solver(self, method: Method) -> Any:
        """Return a new solver; those that the adapter leaves out are explicit."""
        if method in (VELOCITY_VERLET, DVERK6):
            return self.inner.exudyn.MainSolverExplicit()
        return super().solver(method)
