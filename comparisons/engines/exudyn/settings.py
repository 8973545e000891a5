"""Settings of Exudyn by the names that its releases have for them."""

from __future__ import annotations

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
