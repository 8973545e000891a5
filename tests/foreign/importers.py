"""Engines that read MJCF by their importers alone, and Newton, which writes a file back."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

import mbcheck


class Importer(mbcheck.Engine):
    """An engine that reads each file once, and has accelerations alone."""

    methods = (mbcheck.Method("RK4", 4),)
    distribution: ClassVar[str]

    def __init__(self) -> None:
        self.version = version(self.distribution)
        self.known: dict[str, Any] = {}

    def read(self, system: mbcheck.System) -> Any:
        """Return the engine's model of a file."""
        raise NotImplementedError

    def loaded(self, system: mbcheck.System) -> Any:
        """Return the engine's model of a file, read once."""
        if system.path not in self.known:
            self.known[system.path] = self.read(system)
        return self.known[system.path]


def expect(engine: str, found: tuple[int, ...], system: mbcheck.System) -> None:
    """Refuse a model whose positions and velocities are not as many as those of the file.

    Raises
    ------
    mbcheck.Unsupported
    """
    if found != system.layout.size:
        wanted = system.layout.size
        raise mbcheck.Unsupported(
            f"{engine} reads {found[0]} positions and {found[1]} velocities; "
            f"the file has {wanted[0]} and {wanted[1]}"
        )


class Pinocchio(Importer):
    """Articulated bodies, without contacts and actuators."""

    name, distribution = "pinocchio_importer", "pin"

    def read(self, system: mbcheck.System) -> Any:
        import pinocchio

        model = pinocchio.buildModelFromMJCF(Path(system.path))
        expect("Pinocchio", (model.nq, model.nv), system)
        return model, model.createData()

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        import pinocchio

        model, data = self.loaded(system)
        return pinocchio.aba(model, data, q, v, np.zeros(model.nv)).copy()


class Drake(Importer):
    """A continuous plant, with the controls of its actuators."""

    name, distribution = "drake_importer", "drake"

    def read(self, system: mbcheck.System) -> Any:
        import pydrake.all as drake

        builder = drake.DiagramBuilder()
        plant, _ = drake.AddMultibodyPlantSceneGraph(builder, 0.0)
        try:
            drake.Parser(plant).AddModels(system.path)
        except (RuntimeError, SystemExit) as error:
            raise mbcheck.Unsupported(f"Drake: {' '.join(str(error).split())[:150]}") from error
        plant.Finalize()
        expect("Drake", (plant.num_positions(), plant.num_velocities()), system)
        diagram = builder.Build()
        return plant, diagram, diagram.CreateDefaultContext()

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        plant, _, root = self.loaded(system)
        context, q = plant.GetMyMutableContextFromRoot(root), np.array(q)
        for kind, at in zip(system.kinds, system.layout.positions, strict=True):
            if kind == "free":  # whose quaternion precedes its place
                q[at] = np.roll(q[at], 4)
        controls = dict(zip([t.name for t in system.terms], system.controls(time), strict=False))
        names = [plant.get_joint_actuator(i).name() for i in plant.GetJointActuatorIndices()]
        plant.get_actuation_input_port().FixValue(context, [controls.get(n, 0.0) for n in names])
        plant.SetPositionsAndVelocities(context, np.concatenate([q, v]))
        return plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector()


class Dart(Importer):
    """Skeletons without contacts and actuators; free joints are refused."""

    name, distribution = "dart_importer", "dartpy"

    def read(self, system: mbcheck.System) -> Any:
        import dartpy

        if {"ball", "free"} & set(system.kinds):
            raise mbcheck.Unsupported("DART's free and ball joints have other coordinates")
        world = dartpy.utils.MjcfParser.readWorld(f"file://{system.path}")
        if world is None:
            raise mbcheck.Unsupported("DART cannot read the file")
        skeletons = [world.getSkeleton(i) for i in range(world.getNumSkeletons())]
        count = sum(one.getNumDofs() for one in skeletons)
        expect("DART", (count, count), system)
        return world, skeletons

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        _, skeletons = self.loaded(system)
        found, begin = [], 0
        for one in skeletons:
            rows = slice(begin, begin := begin + one.getNumDofs())
            one.setPositions(q[rows])
            one.setVelocities(v[rows])
            one.setTimeStep(0.0)  # dampers are implicit otherwise
            one.computeForwardDynamics()
            found.append(one.getAccelerations())
        return np.concatenate(found)


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


IMPORTERS: Mapping[str, str] = {
    "Pinocchio": f"{__name__}:Pinocchio",
    "Drake": f"{__name__}:Drake",
    "DART": f"{__name__}:Dart",
    "MJX": "mbcheck.examples.mjx_engine:MjxEngine",
    "MuJoCo Warp": "mbcheck.examples.mujoco_warp_engine:MujocoWarpEngine",
}
"""Engine -> the class that reads a file by its importer."""
