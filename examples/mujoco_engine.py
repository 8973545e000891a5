"""MuJoCo plugged into mbcheck by its public protocol alone, as docs/engines.md tells."""

import mujoco
import numpy as np

import mbcheck


class MujocoPlugin(mbcheck.Engine):
    name, version, closure, text = "mujoco_plugin", mujoco.__version__, "mjcf", ""
    methods = (mbcheck.Method("RK4", 4, "RK44"), mbcheck.Method("Euler", 1, "semi_implicit_euler"))

    def at(self, system, time, q, v):
        if self.text != system.mjcf:
            self.text, self.model = system.mjcf, mujoco.MjModel.from_xml_string(system.mjcf)
            self.data = mujoco.MjData(self.model)
        self.data.time, self.data.qpos[:], self.data.qvel[:] = time, q, v
        ended = any(term.until is not None and time >= term.until for term in system.terms)
        self.model.opt.disableactuator = int(ended)
        return self.model, self.data

    def call(self, function, system, *state):
        model, data = self.at(system, *state)
        mujoco.set_mjcb_control(lambda _, data: np.copyto(data.ctrl, system.controls(data.time)))
        function(model, data)
        mujoco.set_mjcb_control(None)  # no model can be compiled under it

    def accelerations(self, system, time, q, v):
        self.call(mujoco.mj_forward, system, time, q, v)
        return self.data.qacc

    def mass_matrix(self, system, q):
        self.call(mujoco.mj_forward, system, 0.0, q, 0 * system.velocities)
        matrix = np.empty((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, matrix)
        return matrix

    def simulate(self, system, method, step, times):
        model, data = self.at(system, system.start_time, system.positions, system.velocities)
        model.opt.timestep, model.opt.integrator = step, int(method.name == "RK4")
        steps, states = 0, []
        for time in times:
            while data.time < time - step / 2:
                self.call(mujoco.mj_step, system, data.time, data.qpos, data.qvel)
                steps += 1
            states.append((data.qpos.copy(), data.qvel.copy(), data.time))
        return mbcheck.Motion(*map(np.array, zip(*states)), steps)
