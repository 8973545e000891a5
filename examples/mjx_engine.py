"""MJX plugged into mbcheck: MuJoCo's algorithms in JAX, here in 64 bits on whatever JAX finds.

    pip install mujoco-mjx
    mbcheck check --quick --engine mbcheck.examples.mjx_engine:MjxEngine

It compiles for seconds for each structure of a model, and takes a millisecond for a step.
"""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import numpy as np

import mbcheck


class MjxEngine(mbcheck.Engine):
    """MJX with MuJoCo's classical Runge-Kutta method and its Euler."""

    name, closure = "mjx", "mjcf"
    methods = (mbcheck.Method("RK4", 4, "RK44"), mbcheck.Method("Euler", 1, "semi_implicit_euler"))

    def __init__(self) -> None:
        try:
            import jax
            import mujoco
            from mujoco import mjx
        except ImportError as error:
            raise mbcheck.EngineUnavailableError(
                "mjx cannot be imported; install it with: pip install mujoco-mjx"
            ) from error
        jax.config.update("jax_enable_x64", True)
        self.mujoco, self.mjx, self.version = mujoco, mjx, version("mujoco-mjx")
        self.forward, self.step, self.full = map(jax.jit, (mjx.forward, mjx.step, mjx.full_m))

    def load(self, system: mbcheck.System, method: str, step: float, at: Any) -> tuple[Any, Any]:
        """Return model and data at a time, positions and velocities, with the controls of then."""
        read = self.mujoco.MjModel
        model = (
            read.from_xml_path(system.path) if system.path else read.from_xml_string(system.mjcf)
        )
        ended = any(term.until is not None and at[0] >= term.until for term in system.terms)
        model.opt.disableactuator = int(ended)
        if not system.path:  # the timestep of a file limits its solref
            model.opt.timestep = step
        model.opt.integrator = getattr(self.mujoco.mjtIntegrator, f"mjINT_{method.upper()}")
        data = self.mujoco.MjData(model)
        data.time, data.qpos[:], data.qvel[:] = at
        data.ctrl[:] = system.controls(at[0])
        return self.mjx.put_model(model), self.mjx.put_data(model, data)

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return accelerations (n,)."""
        return np.array(self.forward(*self.load(system, "RK4", 1e-3, (time, q, v))).qacc)

    def mass_matrix(self, system: mbcheck.System, q: Any) -> Any:
        """Return the mass matrix (n, n)."""
        model, data = self.load(system, "RK4", 1e-3, (0.0, q, 0 * system.velocities))
        return np.array(self.full(model, self.forward(model, data)))

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
            raise mbcheck.Unsupported("a control would be constant over each step")
        now, steps, states = system.start_time, 0, []
        ends = [term.until for term in system.terms if term.until is not None]
        model, data = self.load(
            system, method.name, step, (now, system.positions, system.velocities)
        )
        for time in times:
            while now + step / 2 < time:
                if any(now - step < end <= now for end in ends) and steps:
                    model, data = self.load(system, method.name, step, (now, data.qpos, data.qvel))
                data, steps = self.step(model, data), steps + 1
                now = system.start_time + steps * step
            states.append((data.qpos, data.qvel, data.time))
        positions, velocities, clock = (np.array(part) for part in zip(*states, strict=True))
        return mbcheck.Motion(positions, velocities, clock, steps)
