"""MuJoCo Warp plugged into mbcheck: MuJoCo's algorithms in numbers of 32 bits, here on the CPU.

    pip install mujoco-warp
    mbcheck check --quick --engine mbcheck.examples.mujoco_warp_engine:MujocoWarpEngine

It compiles for minutes when it is first used, and takes 20 ms for a step on a CPU, the time
that it takes to start its kernels.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import mbcheck


class MujocoWarpEngine(mbcheck.Engine):
    """MuJoCo Warp with MuJoCo's classical Runge-Kutta method and its Euler."""

    name, precision, closure = "mujoco_warp", "float32", "mjcf"
    methods = (mbcheck.Method("RK4", 4, "RK44"), mbcheck.Method("Euler", 1, "semi_implicit_euler"))

    def __init__(self) -> None:
        try:
            import mujoco
            import mujoco_warp
            import warp
        except ImportError as error:
            raise mbcheck.EngineUnavailableError(
                "mujoco_warp cannot be imported; install it with: pip install mujoco-warp"
            ) from error
        warp.config.quiet = True
        self.mujoco, self.mjw, self.warp = mujoco, mujoco_warp, warp
        self.version = mujoco_warp.__version__

    def load(self, system: mbcheck.System, method: str, step: float, at: Any) -> tuple[Any, Any]:
        """Return model and data at a time, positions and velocities, with the controls of then."""
        read = self.mujoco.MjModel
        model = (
            read.from_xml_path(system.path) if system.path else read.from_xml_string(system.mjcf)
        )
        time, q, v = at
        ended = any(term.until is not None and time >= term.until for term in system.terms)
        model.opt.disableactuator = int(ended)
        if not system.path:  # the timestep of a file limits its solref
            model.opt.timestep = step
        model.opt.disableflags &= ~int(self.mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # not supported
        model.opt.integrator = getattr(self.mujoco.mjtIntegrator, f"mjINT_{method.upper()}")
        data = self.mujoco.MjData(model)
        data.time, data.qpos[:], data.qvel[:] = time, q, v
        data.ctrl[:] = system.controls(time)
        return self.mjw.put_model(model), self.mjw.put_data(model, data)

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,)."""
        model, data = self.load(system, "RK4", 1e-3, (time, q, v))
        self.mjw.forward(model, data)
        return data.qacc.numpy()[0]

    def mass_matrix(self, system: mbcheck.System, q: Any) -> Any:
        """Return the mass matrix (n, n), column by column."""
        model, data = self.load(system, "RK4", 1e-3, (0.0, q, 0 * q))
        self.mjw.forward(model, data)
        columns = []
        for unit in np.eye(len(q), dtype=np.float32):
            column = self.warp.zeros((1, len(q)), dtype=float)
            self.mjw.mul_m(model, data, column, self.warp.array(unit[None], dtype=float))
            columns.append(column.numpy()[0])
        return np.array(columns).T

    def simulate(
        self, system: mbcheck.System, method: mbcheck.Method, step: float, times: Any
    ) -> mbcheck.Motion:
        """Integrate; a drive that ends is switched off on its step.

        Raises
        ------
        mbcheck.Unsupported
            If the drive is a force in time.
        """
        if any(term.amplitude for term in system.terms):
            raise mbcheck.Unsupported("MuJoCo Warp holds controls over a step")
        at = system.start_time, system.positions, system.velocities
        ends = [term.until for term in system.terms if term.until is not None]
        model, data = self.load(system, method.name, step, at)
        steps, states = 0, []
        for time in times:
            while system.start_time + (steps + 0.5) * step < time:
                now = system.start_time + steps * step
                if any(now - step < end <= now for end in ends) and steps:
                    at = now, data.qpos.numpy()[0], data.qvel.numpy()[0]
                    model, data = self.load(system, method.name, step, at)
                self.mjw.step(model, data)
                steps += 1
            views = (data.qpos, data.qvel, data.time)  # of what the next step fills
            states.append([part.numpy()[0].copy() for part in views])
        positions, velocities, clock = (np.array(part) for part in zip(*states, strict=True))
        return mbcheck.Motion(positions, velocities, clock, steps)
