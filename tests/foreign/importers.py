"""Pinocchio, which reads MJCF by its importer alone, and Newton, which writes a file back."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import mbcheck


class Pinocchio(mbcheck.Engine):
    """Articulated bodies, without contacts and actuators."""

    name = "pinocchio_importer"
    methods = (mbcheck.Method("RK4", 4),)

    def __init__(self) -> None:
        self.version = version("pin")
        self.known: dict[str, Any] = {}

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,) of the file, read once."""
        import pinocchio

        if system.path not in self.known:
            self.known[system.path] = pinocchio.buildModelFromMJCF(Path(system.path))
        model = self.known[system.path]
        if (model.nq, model.nv) != system.layout.size:
            raise mbcheck.Unsupported(
                f"Pinocchio reads {model.nq} positions and {model.nv} velocities; the file has "
                f"{system.layout.size[0]} and {system.layout.size[1]}"
            )
        return pinocchio.aba(model, model.createData(), q, v, np.zeros(model.nv)).copy()


def written_by_newton(path: Path, folder: Path) -> Path:
    """Return a file as Newton reads it and hands it to MuJoCo."""
    import newton

    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    builder.add_mjcf(str(path))
    copy = folder / f"{path.stem}_newton.xml"
    model = builder.finalize(device="cpu")
    newton.solvers.SolverMuJoCo(model, use_mujoco_cpu=True, save_to_mjcf=str(copy))
    return copy
