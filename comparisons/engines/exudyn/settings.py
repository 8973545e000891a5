"""Settings of Exudyn by the names that its releases have for them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import reduce
from typing import Any


def assign(settings: Any, path: str, value: Any) -> None:
    """Set what `RENAMED` may have another name for."""
    *parents, name = (path if hasattr(settings, "solution") else RENAMED.get(path, path)).split(".")
    setattr(reduce(getattr, parents, settings), name, value)


RENAMED = {
    "solution.file.write": "solutionSettings.writeSolutionToFile",
    "solution.sensors.active": "solutionSettings.sensorsStoreAndWriteFiles",
    "timeIntegration.solverType": "timeIntegration.explicitIntegration.dynamicSolverType",
    "timeIntegration.newton.residualMode": "timeIntegration.newton.newtonResidualMode",
    "linearSolver.solverType": "linearSolverType",
}
"""Settings by their names of today: what Exudyn called them before 1.12."""


@contextmanager
def any_values(exudyn: Any) -> Iterator[None]:
    """Take Exudyn's settings out of its range checks, which before 1.12 no dictionary meets."""
    checks = exudyn.special.exceptions
    if not hasattr(checks, "parameterRangeChecks"):
        yield
        return
    saved = checks.parameterRangeChecks
    checks.parameterRangeChecks = False
    try:
        yield
    finally:
        checks.parameterRangeChecks = saved
