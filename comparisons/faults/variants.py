"""Engines changed on purpose as data: a variant is made where it runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Any

from ...reference.scene import Array, Case
from ..engines.adapter import Adapter, BoundModel
from ..engines.protocol import Engine, Method
from ..engines.registry import get_engine
from ..engines.run import Trajectory

MUJOCO, EXUDYN = "mujoco", "exudyn"

EXTRA_METHODS: Mapping[str, tuple[str, ...]] = {MUJOCO: ("Euler",), EXUDYN: ("GeneralizedAlpha",)}
"""Methods that are pushed to extremes, in addition to an engine's best."""

LONG_METHODS: Mapping[str, tuple[str, ...]] = {
    MUJOCO: ("RK4", "implicitfast", "discrete"),
    EXUDYN: ("RK67", "RK44", "GeneralizedAlpha", "TrapezoidalIndex2"),
}
"""Methods of long runs: the best, and the most informative."""

DEFAULT_NEWTON = {
    "newton.residualMode": 0,
    "newton.relativeTolerance": 1e-8,
    "newton.absoluteTolerance": 1e-10,
}
"""Settings of Exudyn's Newton method by default: it stops at a residual in newtons."""

DEFAULT_STEPS = {**DEFAULT_NEWTON, "adaptiveStep": True}
"""The same, and steps that may be halved, as by default."""

OWN_ERROR_CONTROL = {"absoluteTolerance": 1e-8, "relativeTolerance": 1e-8}
"""A tolerance of Exudyn's DOPRI5, as by default."""

AUTOMATIC_STEPS = {**OWN_ERROR_CONTROL, "automaticStepSize": True}
"""The same, and steps that DOPRI5 chooses, as by default."""

NO_DAMPING = {"generalizedAlpha.spectralRadius": 1.0}
"""Generalized-alpha without numerical damping, of Exudyn."""

NEWMARK = {"generalizedAlpha.useNewmark": True, "generalizedAlpha.useIndex2Constraints": False}
"""The trapezoidal rule with constraints of positions, of Exudyn."""

NOT_PROVOKED: tuple[tuple[str, str], ...] = (
    (
        "MuJoCo: tendon equalities omit Jdot v",
        "no scene has a tendon equality; the fixed tendons of the models are linear, with Jdot = 0",
    ),
    (
        "MuJoCo 4.0.0: sparse Newton Hessian",
        "loops of the scenes are too small: sparse and dense agree to 1e-13",
    ),
    (
        "MuJoCo: RK4 of ball and free joints before 4.0",
        "one version is installed; *order* shows it of bodies in space, see versions.md",
    ),
    ("MuJoCo: 1-D flex converges with order 1", "no model uses flex"),
    ("MuJoCo: sleeping bodies never sleep", "no model enables sleep"),
    ("MuJoCo: default softness depends on qpos0", "every model is compiled at phi = 0"),
    (
        "MuJoCo: eigenvalues of discrete and of the transition matrix are not the physical ones",
        "adapters linearise the equations of motion, never a step",
    ),
    (
        "MuJoCo: rollout and Batch take a Python callback for a C one",
        "the drive is a body, no hook is used",
    ),
    ("foreign readers of MJCF drop stiffness, armature, inertia", "no such engine has an adapter"),
    (
        "MuJoCo: shows the energy of the state before until mj_forward",
        "adapters compute energies from states",
    ),
    ("MuJoCo: mjd_transitionFD refuses RK4", "adapters linearise the equations of motion"),
    (
        "MuJoCo: a body that MjSpec adds without ipos loses its inertia when it is written",
        "models are written as MJCF",
    ),
    (
        "MuJoCo: an unstable run leaves MUJOCO_LOG.TXT in the working directory",
        "runs have a temporary folder",
    ),
    ("MuJoCo: runs a crank longer than its rod", "the scene refuses its parameters"),
    (
        "Exudyn: the renderer aborts without a display",
        "it would kill the process, and no scene is rendered",
    ),
    ("Exudyn: -W error turns deprecations into failures", "the models use no deprecated name"),
    (
        "Exudyn: sensors of automatic steps lie off the grid",
        "adapters read states, no sensor; automatic steps themselves are provoked",
    ),
    (
        "Exudyn: holds Python's lock while it solves",
        "no result is wrong by it; runs go by processes",
    ),
    (
        "Exudyn: its own start accelerations keep 8 digits",
        "the adapter solves for accelerations itself",
    ),
)
"""Failure modes that the scenes cannot provoke, and why."""

Law = Callable[[Any, Any, Any], float]
"""(q, v, parameters) -> generalised force on the scene's first coordinate."""

COMPUTED = ("accelerations", "reactions", "mass_matrices", "linearise")
"""Functions of a model that compute from states, its runs apart."""


@dataclass(frozen=True)
class Variant:
    """An engine as it is, or with something undone; it need not be installed before `make`.

    Attributes
    ----------
    engine : str
    name : str
        A class in the engine's module of this folder; empty for the engine as it is.
    arguments : tuple
        Of this class.
    """

    engine: str
    name: str = ""
    arguments: tuple[Any, ...] = ()

    def make(self) -> Adapter:
        """Return the engine."""
        if not self.name:
            return get_engine(self.engine)
        variants = import_module(f".{self.engine}", __package__)
        engine: Adapter | Engine = getattr(variants, self.name)(*self.arguments)
        return Adapter(engine) if isinstance(engine, Engine) else engine


def mujoco(name: str = "", *arguments: Any) -> Variant:
    """Return a variant of MuJoCo."""
    return Variant(MUJOCO, name, arguments)


def exudyn(name: str = "", *arguments: Any) -> Variant:
    """Return a variant of Exudyn."""
    return Variant(EXUDYN, name, arguments)


Delegating: Any = object
"""Base of classes that pass for others by delegation, which type checkers cannot follow."""


class Wrapped(Delegating):
    """An engine with something around all that it computes."""

    def __init__(self, engine: Adapter) -> None:
        self.engine = engine

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def bind(self, case: Case, model: str) -> Any:
        """Return a model of the engine, with something around what it computes."""
        return WrappedModel(self, self.engine.bind(case, model))

    def computing(self, model: BoundModel) -> BoundModel:
        """Return the model that computes in place of one."""
        return model

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate, see `BoundModel.simulate`."""
        return model.simulate(case, method, step, times)

    def compute(self, model: BoundModel, name: str, *arguments: Any) -> Any:
        """Return the result of another function of a model, one of `COMPUTED`."""
        return getattr(model, name)(*arguments)


class WrappedModel(Delegating):
    """A model of a wrapped engine."""

    def __init__(self, owner: Wrapped, model: BoundModel) -> None:
        self.owner, self.model = owner, model

    def __getattr__(self, name: str) -> Any:
        if name in COMPUTED:
            return partial(self.owner.compute, self.owner.computing(self.model), name)
        return getattr(self.model, name)

    def simulate(self, case: Case, method: Method, step: float, times: Array) -> Trajectory:
        """Integrate as the engine around it does."""
        return self.owner.simulate(self.owner.computing(self.model), case, method, step, times)


class Misread(Wrapped):
    """An engine whose model has other parameters than the case.

    Parameters
    ----------
    engine : Adapter
    change : callable ``(parameters) -> parameters``, or mapping of parameter to value
    """

    def __init__(self, engine: Adapter, change: Callable[[Any], Any] | Mapping[str, Any]) -> None:
        super().__init__(engine)
        self.change = change if callable(change) else lambda p: p.replace(**change)

    def computing(self, model: BoundModel) -> BoundModel:
        """Return the model with the wrong parameters."""
        wrong = replace(model.case, parameters=self.change(model.case.parameters))
        return model.engine.bind(wrong, model.name)
