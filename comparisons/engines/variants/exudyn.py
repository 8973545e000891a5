"""Exudyn with something undone that its adapter does, or with more than the adapter offers."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from ....models import exudyn_system
from ....reference.scene import Case
from ..exudyn.engine import ExudynEngine
from ..exudyn.settings import assign
from ..protocol import Method

VELOCITY_VERLET = Method("VelocityVerlet", 2)
DVERK6 = Method("DVERK6", 6)


class Changed(ExudynEngine):
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


class Unrestricted(ExudynEngine):
    """Exudyn without the adapter's refusals, and with explicit solvers that it leaves out."""

    methods = (*ExudynEngine.methods, VELOCITY_VERLET, DVERK6)

    def why_not(self, case: Case, model: str, method: Method | None) -> None:
        """Refuse nothing."""

    def solver(self, method: Method) -> Any:
        """Return a new solver; those that the adapter leaves out are explicit."""
        if method in (VELOCITY_VERLET, DVERK6):
            return self.exudyn.MainSolverExplicit()
        return super().solver(method)


class Spatial(ExudynEngine):
    """Exudyn with the model ``spatial`` of a scene beside those in the plane."""

    def model(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model."""
        if model != "spatial":
            return super().model(case, model)
        package = exudyn_system.__package__
        return import_module(f"{package}.{case.scene}.exudyn_spatial").MODEL
