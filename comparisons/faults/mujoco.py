"""Wrong engines that are MuJoCo with something changed or undone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from ...models import mjcf
from ...models.system import System
from ...reference import get_scene
from ...reference.scene import Array, Case
from ..engines.adapter import Adapter
from ..engines.mujoco.engine import MuJoCo, Order
from ..engines.mujoco.library import inputs, quiet, recorded
from ..engines.protocol import Method
from ..engines.run import Trajectory, grid_indices
from .variants import Law, Variant, Wrapped


class MujocoAdapter(Adapter):
    """MuJoCo as it is, for classes that change it.

    Parameters
    ----------
    inner : MuJoCo, optional
    """

    inner: MuJoCo

    def __init__(self, inner: MuJoCo | None = None) -> None:
        super().__init__(inner or MuJoCo())


class Edited(MujocoAdapter):
    """MuJoCo with parts of the MJCF's text exchanged.

    Parameters
    ----------
    edits : (old, new)
        Each old text must be there.
    """

    def __init__(self, *edits: tuple[str, str]) -> None:
        super().__init__()
        self.edits = edits

    def text(self, case: Case, model: str) -> str:
        """Return the edited MJCF of a case."""
        text = super().text(case, model)
        for old, new in self.edits:
            if old not in text:
                raise ValueError(f"the MJCF has no {old!r}")
            text = text.replace(old, new)
        return text


class Unwarned(Wrapped):
    """A variant that is read by someone who looks at no warning counter."""

    def __init__(self, variant: Variant) -> None:
        super().__init__(variant.make())

    def compute(self, method: Any, case: Case, model: str, *rest: Any) -> Any:
        """Call a method of the engine, and keep its warnings quiet."""
        result = method(case, model, *rest)
        return replace(result, warnings={}) if isinstance(result, Trajectory) else result


class AtAnyStep(MuJoCo):
    """MuJoCo without the class's refusal of steps that soften closures."""

    def refuse_softening(self, compiled: Any, order: Order) -> None:
        """Refuse nothing."""


class Willing(MujocoAdapter):
    """MuJoCo without refusals."""

    def __init__(self) -> None:
        super().__init__(AtAnyStep())

    def why_not(self, case: Case, model: str, method: Method | None) -> None:
        """Refuse nothing."""


class WithoutEquations(MujocoAdapter):
    """MuJoCo whose soft closure is taken for a joint.

    Parameters
    ----------
    make : callable ``(*arguments) -> Mjcf``, optional
        Makes the model that is run in place of the named one.
    arguments : tuple
    """

    def __init__(self, make: Callable[..., mjcf.Mjcf] | None = None, *arguments: Any) -> None:
        super().__init__()
        self.make, self.arguments = make, arguments

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the model without the equations that its closure has."""
        source = self.make(*self.arguments) if self.make else super().source(case, model)
        return replace(source, equations=None)


class Controlled(MujocoAdapter):
    """MuJoCo whose force comes through ``ctrl``, which is set before each step.

    Parameters
    ----------
    moment : float
        Of the step at which the force is taken: 0 its start, 1/2 its middle.
    factor : float
        On the force; not a number, or huge, to see what MuJoCo does of it.
    """

    def __init__(self, moment: float, factor: float = 1.0) -> None:
        super().__init__()
        self.moment, self.factor = moment, factor

    def text(self, case: Case, model: str) -> str:
        """Return the MJCF with a motor on the slide."""
        motor = '<actuator><motor name="force" joint="y"/></actuator>\n\n  <tendon>'
        return super().text(case, model).replace("<tendon>", motor)

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate with the spring's foot at rest, and the control in its place."""
        p = case.parameters
        still = replace(case, parameters=p.replace(force_amplitude=0.0))
        force, omega = self.factor * p.force_amplitude, 2 * np.pi * p.force_frequency
        numbers = grid_indices(times, case.start_time, step)
        system, mujoco = self.joint_system(still, model), self.inner.mujoco
        with quiet(mujoco):
            compiled = self.inner.compiled(Order(system, method.name, step))
            data = self.inner.data(compiled, case.start_time, system.positions, system.velocities)
            before = inputs(mujoco, compiled, data)
            states = []
            for number in range(int(numbers[-1]) + 1):
                if number in numbers:
                    states.append(np.concatenate([[data.time], data.qpos, data.qvel]))
                now = case.start_time + (number + self.moment) * step
                data.ctrl[0] = force * np.cos(omega * now)
                if number < numbers[-1]:
                    mujoco.mj_step(compiled, data)
            data.ctrl[0] = 0.0  # it was changed on purpose
            rows = np.array(states)
            motion = recorded(mujoco, compiled, system.start_time, data, rows, before)
        return self.trajectory(system, step, times, motion)


class PushedMujoco(MuJoCo):
    """MuJoCo with one more force on the first coordinate, which is its first joint.

    The force acts through MuJoCo's hook for passive forces, one for all models, which must see none
    being compiled.
    """

    def __init__(self, law: Law) -> None:
        super().__init__()
        self.law = law

    def load(self, system: System) -> Any:
        """Return the compiled model of a system."""
        hook = self.mujoco.get_mjcb_passive()
        self.mujoco.set_mjcb_passive(None)
        try:
            return super().load(system)
        finally:
            self.mujoco.set_mjcb_passive(hook)

    @contextmanager
    def opened(self, system: System) -> Iterator[None]:
        """Let the force act meanwhile."""
        source = mjcf.models(system.case.scene)[system.model]
        coordinates = get_scene(system.case.scene).coordinates
        sums = [source.readout.get(name, {name: 1.0}) for name in coordinates]

        def push(compiled: Any, data: Any) -> None:
            q, v = (
                [sum(f * getattr(data.joint(j), what)[0] for j, f in s.items()) for s in sums]
                for what in ("qpos", "qvel")
            )
            data.qfrc_passive[0] += self.law(q, v, system.case.parameters)

        with super().opened(system):
            self.mujoco.set_mjcb_passive(push)
            try:
                yield
            finally:
                self.mujoco.set_mjcb_passive(None)


class Rebound(MujocoAdapter):
    """MuJoCo with other values in the MJCF."""

    def __init__(self, bindings: Mapping[tuple[str, str], mjcf.Binding]) -> None:
        super().__init__()
        self.bindings = bindings

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the model with those values."""
        source = super().source(case, model)
        return replace(source, bindings={**source.bindings, **self.bindings})


class FlippedMujoco(MujocoAdapter):
    """MuJoCo with the slider-crank put together the other way round, the slider on top."""

    def motion(self, case: Case, model: str, time: float, state: Array) -> mjcf.Motion:
        """Return the motion of the joints with the rod mirrored at the height of the pin."""
        motion = dict(super().motion(case, model, time, state))
        if not case.name:  # as the file opens, which is right
            return motion
        (phi, speed), (pin, turn), (y, rate) = (motion[n] for n in ("phi", "pin_angle", "y"))
        r = case.parameters.crank_radius
        motion["pin_angle"] = np.pi - pin - 2 * phi, -turn - 2 * speed
        motion["y"] = 2 * r * np.sin(phi) - y, 2 * r * np.cos(phi) * speed - rate
        return motion
