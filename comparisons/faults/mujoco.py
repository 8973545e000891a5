"""Wrong engines that are MuJoCo with something changed or undone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ...models import mjcf
from ...models.system import System
from ...reference import get_scene
from ...reference.scene import Array, Case
from ..engines.adapter import Adapter, BoundModel
from ..engines.mujoco.engine import MuJoCo
from ..engines.mujoco.library import inputs, quiet, recorded
from ..engines.protocol import Method
from ..engines.run import Trajectory, grid_indices
from .runs import Altered
from .variants import Law, Variant


class MujocoAdapter(Adapter):
    """MuJoCo as it is, for classes that change it.

    Parameters
    ----------
    inner : MuJoCo, optional
    """

    inner: MuJoCo

    def __init__(self, inner: MuJoCo | None = None) -> None:
        super().__init__(inner or MuJoCo())


class RewrittenModel(BoundModel):
    """A model whose text is rewritten."""

    engine: Rewritten

    @cached_property
    def text(self) -> str:
        """The rewritten MJCF."""
        return self.engine.rewrite(super().text, self.case.parameters)


class Rewritten(MujocoAdapter):
    """MuJoCo that reads another text.

    Parameters
    ----------
    rewrite : callable ``(text, parameters) -> text``
    """

    bound = RewrittenModel

    def __init__(self, rewrite: Callable[[str, Any], str]) -> None:
        super().__init__()
        self.rewrite = rewrite


class Edited(Rewritten):
    """MuJoCo with parts of the MJCF's text exchanged.

    Parameters
    ----------
    edits : (old, new)
        Each old text must be there.
    """

    def __init__(self, *edits: tuple[str, str]) -> None:
        super().__init__(self.edited)
        self.edits = edits

    def edited(self, text: str, parameters: Any) -> str:
        """Return the text with the new parts."""
        for old, new in self.edits:
            if old not in text:
                raise ValueError(f"the MJCF has no {old!r}")
            text = text.replace(old, new)
        return text


class Unwarned(Altered):
    """A variant whose warning counters are ignored."""

    def __init__(self, variant: Variant) -> None:
        super().__init__(variant.make(), lambda run, _: replace(run, warnings={}))


class AtAnyStep(MuJoCo):
    """MuJoCo without the class's refusal of steps that soften closures."""

    def refuse_softening(self, compiled: Any, model: str, step: float) -> None:
        """Refuse nothing."""


class WillingModel(BoundModel):
    """A model that supports everything."""

    def unsupported_reason(self, case: Case, method: Method | None) -> None:
        """Refuse nothing."""


class Willing(MujocoAdapter):
    """MuJoCo without refusals."""

    bound = WillingModel

    def __init__(self) -> None:
        super().__init__(AtAnyStep())


class WithoutEquations(MujocoAdapter):
    """MuJoCo whose soft closure is taken for a joint.

    Parameters
    ----------
    make : callable ``(*arguments) -> Mjcf``, optional
        Makes the model to run in place of the named one.
    arguments : tuple
    """

    def __init__(self, make: Callable[..., mjcf.Mjcf] | None = None, *arguments: Any) -> None:
        super().__init__()
        self.make_source, self.arguments = make, arguments

    def read_source(self, scene: str, model: str) -> mjcf.Mjcf:
        """Return the model without the equations that its closure has."""
        make = self.make_source
        source = make(*self.arguments) if make else super().read_source(scene, model)
        return replace(source, equations=None)


class ControlledModel(BoundModel):
    """A model whose spring's foot is at rest, with a motor on its slide."""

    engine: Controlled

    @cached_property
    def text(self) -> str:
        """The MJCF with the motor."""
        motor = '<actuator><motor name="force" joint="y"/></actuator>\n\n  <tendon>'
        return super().text.replace("<tendon>", motor)

    def simulate(self, case: Case, method: Method, step: float, times: Array) -> Trajectory:
        """Integrate with the spring's foot at rest, and the control in its place."""
        p, engine = case.parameters, self.engine
        still = replace(case, parameters=p.replace(force_amplitude=0.0))
        force, omega = engine.factor * p.force_amplitude, 2 * np.pi * p.force_frequency
        numbers = grid_indices(times, case.start_time, step)
        system, mujoco = engine.bind(still, self.name).system(still), engine.inner.mujoco
        with quiet(mujoco):
            compiled = engine.inner.compiled(system.mjcf, self.name, method.name, step)
            data = engine.inner.data(compiled, case.start_time, system.positions, system.velocities)
            before = inputs(mujoco, compiled, data)
            states = []
            for number in range(int(numbers[-1]) + 1):
                if number in numbers:
                    states.append(np.concatenate([[data.time], data.qpos, data.qvel]))
                now = case.start_time + (number + engine.moment) * step
                data.ctrl[0] = force * np.cos(omega * now)
                if number < numbers[-1]:
                    mujoco.mj_step(compiled, data)
            data.ctrl[0] = 0.0  # it was changed on purpose
            rows = np.array(states)
            motion = recorded(mujoco, compiled, system.start_time, data, rows, before)
        return self.trajectory(system, step, times, motion)


class Controlled(MujocoAdapter):
    """MuJoCo whose force comes through ``ctrl``, which is set before each step.

    Parameters
    ----------
    moment : float
        Of the step at which the force is taken: 0 its start, 1/2 its middle.
    factor : float
        On the force; not a number, or huge, to see what MuJoCo does of it.
    """

    bound = ControlledModel

    def __init__(self, moment: float, factor: float = 1.0) -> None:
        super().__init__()
        self.moment, self.factor = moment, factor


class PushedMujoco(MuJoCo):
    """MuJoCo with one more force on the first coordinate, which is its first joint.

    The force acts through MuJoCo's hook for passive forces, one for all models, which must see none
    being compiled.
    """

    def __init__(self, law: Law) -> None:
        super().__init__()
        self.law = law

    def load(self, text: str) -> Any:
        """Return the compiled model of a text."""
        hook = self.mujoco.get_mjcb_passive()
        self.mujoco.set_mjcb_passive(None)
        try:
            return super().load(text)
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

    def read_source(self, scene: str, model: str) -> mjcf.Mjcf:
        """Return the model with those values."""
        source = super().read_source(scene, model)
        return replace(source, bindings={**source.bindings, **self.bindings})


class FlippedModel(BoundModel):
    """A slider-crank on its other assembly branch."""

    def motion(self, time: float, state: Array) -> mjcf.Motion:
        """Return the motion of the joints with the rod mirrored at the height of the pin."""
        motion = dict(super().motion(time, state))
        if "origin" not in vars(self):  # as the file opens, which is right
            return motion
        (phi, speed), (pin, turn), (y, rate) = (motion[n] for n in ("phi", "pin_angle", "y"))
        r = self.case.parameters.crank_radius
        motion["pin_angle"] = np.pi - pin - 2 * phi, -turn - 2 * speed
        motion["y"] = 2 * r * np.sin(phi) - y, 2 * r * np.cos(phi) * speed - rate
        return motion


class FlippedMujoco(MujocoAdapter):
    """MuJoCo with the slider-crank on its other assembly branch, the slider on top."""

    bound = FlippedModel
