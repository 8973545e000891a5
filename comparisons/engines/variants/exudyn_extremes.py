"""Exudyn as it is often used, and fails: each variant undoes one thing that the adapter does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ....reference.scene import Case
from ..exudyn import ExudynEngine
from ..protocol import Method

VELOCITY_VERLET = Method("VelocityVerlet", 2)
DVERK6 = Method("DVERK6", 6)
"""Explicit solvers that Exudyn lists and the adapter leaves out."""

Change = Callable[[Any], None]
"""What is done to Exudyn's settings of the time integration."""


class Changed(ExudynEngine):
    """Exudyn with other settings of its time integration."""

    def __init__(self, change: Change) -> None:
        super().__init__()
        self.change = change

    def settings(self, method: Method, start: float, step: float, large: bool = False) -> Any:
        """Return the adapter's settings, changed."""
        settings = super().settings(method, start, step, large)
        self.change(settings.timeIntegration)
        return settings


class Willing(ExudynEngine):
    """Exudyn without the adapter's refusals, and with all its explicit solvers."""

    def why_not(self, case: Case, model: str, method: Method | None) -> None:
        """Refuse nothing."""

    def solver(self, method: Method) -> Any:
        """Return a new solver; those that the adapter leaves out are explicit."""
        if method in (VELOCITY_VERLET, DVERK6):
            return self.exudyn.MainSolverExplicit()
        return super().solver(method)


def default_newton(time: Any) -> None:
    """Have Newton's method stop where Exudyn does by default: at a residual in newtons."""
    time.newton.residualMode = 0
    time.newton.relativeTolerance = 1e-8
    time.newton.absoluteTolerance = 1e-10


def default_steps(time: Any) -> None:
    """The same, and steps that may be halved, as by default."""
    default_newton(time)
    time.adaptiveStep = True


def no_damping(time: Any) -> None:
    """Take generalized-alpha without numerical damping."""
    time.generalizedAlpha.spectralRadius = 1.0


def newmark(time: Any) -> None:
    """Take the trapezoidal rule with constraints of positions."""
    time.generalizedAlpha.useNewmark = True
    time.generalizedAlpha.useIndex2Constraints = False


def no_damping_residuals(time: Any) -> None:
    """The same, and Newton's method as by default."""
    no_damping(time)
    default_newton(time)


def newmark_residuals(time: Any) -> None:
    """Take that rule, and Newton's method as by default."""
    newmark(time)
    default_newton(time)


def own_error_control(time: Any) -> None:
    """Give DOPRI5 a tolerance, as by default."""
    time.absoluteTolerance = time.relativeTolerance = 1e-8


def automatic_steps(time: Any) -> None:
    """Let DOPRI5 choose its steps, as by default."""
    own_error_control(time)
    time.automaticStepSize = True
