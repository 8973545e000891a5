"""Drake plugged into mbcheck: a continuous `MultibodyPlant` under Drake's own integrators.

    pip install "mbcheck[drake]"
    mbcheck check --engine drake

What Drake 1.51 reads and drops of MJCF, and how it is completed here:

- bodies, inertials, ``euler``, ``ref``, ``gravity``, defaults and ``damping`` are read, and right:
  the dampers of joints act in the plant, and are left out of what `System.force` adds,
- ``stiffness``, ``springref``, tendons, ``general`` actuators, sites and ``connect`` between sites
  are dropped, each with a warning on the console: `System.force` has the forces among them,
- ``armature`` is dropped silently where no ``motor`` or ``position`` stands on the joint: here each
  joint that has one gets an actuator whose rotor has this inertia,
- a body of mass 0 raises `SystemExit` (condition 'mass > 0' failed): without joints it is left out,
- loops are not run: a continuous plant refuses constraints,
- nor are ball and free joints: a ball is turned by three angles, and velocities are in the world.

Where a time of the grid is no multiple of the step in binary numbers, `Simulator` comes out at it
with one more step of 1e-14 of its size. It may stretch a step to reach a time: so its largest step
is set 0.1 % longer, and it is advanced by one step of the grid at a time. It then counts as many
steps as requested.
"""

from __future__ import annotations

import logging
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

import mbcheck


class DrakeEngine(mbcheck.Engine):
    """Trees as continuous plants, under the explicit integrators of `Simulator`.

    Of these `runge_kutta2` is Heun's, `runge_kutta3` Kutta's, and `bogacki_shampine3` of order 3
    as well; `mbcheck.Method` has no names for them. Those with an error estimate evaluate it too.

    Attributes
    ----------
    stretch : float
        Largest step that an integrator may take, in steps of the grid.
    """

    name = "drake"
    stretch = 1.001
    methods = (
        mbcheck.Method("runge_kutta5", 5, "DOPRI5", evaluations_per_step=7),
        mbcheck.Method("runge_kutta3", 3, evaluations_per_step=3),
        mbcheck.Method("bogacki_shampine3", 3, evaluations_per_step=4),
        mbcheck.Method("runge_kutta2", 2, evaluations_per_step=2),
        mbcheck.Method("semi_explicit_euler", 1, evaluations_per_step=1),
        mbcheck.Method("explicit_euler", 1, "ExplicitEuler", evaluations_per_step=1),
    )

    def __init__(self) -> None:
        try:
            import pydrake.all
        except ImportError as error:
            raise mbcheck.EngineUnavailableError(
                "pydrake cannot be imported; install it with: pip install drake"
            ) from error
        self.drake, self.version = pydrake.all, version("drake")
        logging.getLogger("drake").setLevel(logging.ERROR)  # its reader warns on every reading
        self.loaded: tuple[str, Any, Any, Any] | None = None
        self.force: Callable[..., Any]

    def load(self, system: mbcheck.System) -> tuple[Any, Any, Any]:
        """Return plant, diagram and a context of the diagram.

        Raises
        ------
        mbcheck.Unsupported
            For a loop, and for ball and free joints.
        """
        if {"ball", "free"} & set(system.kinds):
            raise mbcheck.Unsupported("ball and free joints, whose coordinates differ in Drake")
        if system.closures:
            raise mbcheck.Unsupported("a continuous plant of Drake has no constraints")
        dropped = tuple(term for term in system.terms if term.kind != "damper")
        self.force = replace(system, terms=dropped).force
        if self.loaded is None or self.loaded[0] != system.mjcf:
            builder = self.drake.DiagramBuilder()
            plant = builder.AddSystem(self.plant(system))
            forces = builder.AddSystem(self.forces(len(system.joints)))
            builder.Connect(plant.get_state_output_port(), forces.get_input_port())
            port = plant.get_applied_generalized_force_input_port()
            builder.Connect(forces.get_output_port(), port)
            diagram = builder.Build()
            self.loaded = system.mjcf, plant, diagram, diagram.CreateDefaultContext()
        return self.loaded[1:]

    def plant(self, system: mbcheck.System) -> Any:
        """Return the plant that Drake reads from the file, with armatures.

        Raises
        ------
        mbcheck.Unsupported
            If it reads other joints.
        """
        plant = self.drake.MultibodyPlant(time_step=0.0)
        text = without_massless_bodies(system.mjcf)
        self.drake.Parser(plant).AddModelsFromString(text, "xml")
        for name, armature in (system.armatures or {}).items():
            rotor = plant.AddJointActuator(name, plant.GetJointByName(name))
            rotor.set_default_rotor_inertia(armature)
        plant.Finalize()
        joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
        moving = sorted((one for one in joints if one.num_positions()), key=position_start)
        if tuple(one.name() for one in moving) != system.joints:
            raise mbcheck.Unsupported(f"Drake read the joints {[one.name() for one in moving]}")
        return plant

    def forces(self, n: int) -> Any:
        """Return a system whose input is the plant's state, and its output the forces it lacks."""
        engine = self

        class Forces(self.drake.LeafSystem):  # type: ignore[name-defined]
            """Generalised forces (n,) of a state (2 n,)."""

            def __init__(self) -> None:
                super().__init__()
                self.DeclareVectorInputPort("state", 2 * n)
                self.DeclareVectorOutputPort("force", n, self.calculate)

            def calculate(self, context: Any, output: Any) -> None:
                state = self.get_input_port().Eval(context)
                output.SetFromVector(engine.force(context.get_time(), state[:n], state[n:]))

        return Forces()

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,) at positions (n,) and velocities (n,)."""
        _, diagram, context = self.load(system)
        set_state(context, time, q, v)
        return diagram.EvalTimeDerivatives(context).CopyToVector()[len(q) :]

    def mass_matrix(self, system: mbcheck.System, q: Any) -> Any:
        """Return the mass matrix (n, n)."""
        plant, _, context = self.load(system)
        set_state(context, system.start_time, q, 0 * q)
        return plant.CalcMassMatrix(plant.GetMyContextFromRoot(context))

    def simulate(
        self, system: mbcheck.System, method: mbcheck.Method, step: float, times: Any
    ) -> mbcheck.Motion:
        """Advance Drake's simulator with a fixed step of one of its integrators."""
        diagram = self.load(system)[1]
        simulator = self.drake.Simulator(diagram)
        context = simulator.get_mutable_context()
        set_state(context, system.start_time, system.positions, system.velocities)
        integrator = self.drake.ResetIntegratorFromFlags(
            simulator, method.name, self.stretch * step
        )
        if not integrator.get_fixed_step_mode():
            integrator.set_fixed_step_mode(True)
        simulator.Initialize()
        done, rows = 0, []
        for time in times:
            while system.start_time + (done + 0.5) * step < time:
                done += 1
                simulator.AdvanceTo(system.start_time + done * step)
            state = context.get_continuous_state_vector().CopyToVector()
            rows.append((*state, context.get_time()))
        states, n = np.array(rows), len(system.joints)
        return mbcheck.Motion(
            states[:, :n],
            states[:, n:-1],
            states[:, -1],
            integrator.get_num_steps_taken(),
            rhs_evaluations=integrator.get_num_derivative_evaluations(),
        )


def set_state(context: Any, time: float, q: Any, v: Any) -> None:
    """Put a time and a state into a context of Drake."""
    context.SetTime(time)
    context.SetContinuousState(np.concatenate([q, v]))


def position_start(joint: Any) -> int:
    """Return where a joint stands in the vector of positions."""
    return int(joint.position_start())


def without_massless_bodies(text: str) -> str:
    """Return MJCF without the bodies that have neither mass nor joints nor bodies of their own."""
    root = ET.fromstring(text)
    for parent in list(root.iter("body")):
        for body in parent.findall("body"):
            inertial = body.find("inertial")
            if inertial is None or float(inertial.get("mass", "1")):
                continue
            if body.find("joint") is None and body.find("body") is None:
                parent.remove(body)
    return ET.tostring(root, encoding="unicode")
