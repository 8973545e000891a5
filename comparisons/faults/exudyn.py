"""Wrong engines that are Exudyn with something changed or undone, or with more than it offers."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from types import ModuleType
from typing import Any
from unittest.mock import patch

import numpy as np

from ...models import exudyn_mjcf, exudyn_system, mjcf
from ...reference.scene import Array, Case
from ..engines.adapter import Adapter, BoundModel
from ..engines.exudyn.engine import Exudyn, assign
from ..engines.protocol import Engine, Method
from .variants import Law

VELOCITY_VERLET = Method("VelocityVerlet", 2)
DVERK6 = Method("DVERK6", 6)


class Hooked(Exudyn):
    """Exudyn that takes its parts from its adapter, where classes exchange them."""

    owner: ExudynAdapter

    def source(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model."""
        return self.owner.own_source(case, model)

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        return self.owner.system(case, model)

    def settings(self, *call: Any) -> Any:
        """Return Exudyn's settings."""
        return self.owner.settings(*call)

    def solver(self, method: Method) -> Any:
        """Return a new solver."""
        return self.owner.solver(method)


class ExudynModel(BoundModel):
    """A model of Exudyn, which its adapter may run whatever the reasons against it."""

    engine: ExudynAdapter

    def unsupported_reason(self, case: Case, method: Method | None) -> str | None:
        """Return why this method cannot run a case, or None."""
        return None if self.engine.refuses_nothing else super().unsupported_reason(case, method)


class ExudynAdapter(Adapter):
    """Exudyn as it is, for classes that exchange parts of it."""

    bound = ExudynModel
    methods = Exudyn.methods
    refuses_nothing = False
    inner: Hooked

    def __init__(self) -> None:
        methods = self.methods
        super().__init__(Hooked())
        self.methods = methods

    def hold(self, inner: Engine) -> None:
        """Take an engine, which then takes its parts from here."""
        super().hold(inner)
        self.inner.owner = self

    def own_source(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model."""
        return Exudyn.source(self.inner, case, model)

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        return Exudyn.system(self.inner, case, model)

    def settings(self, method: Method, start: float, step: float, large: bool = False) -> Any:
        """Return Exudyn's settings for a method with this step, from this time on."""
        return Exudyn.settings(self.inner, method, start, step, large)

    def solver(self, method: Method) -> Any:
        """Return a new solver of Exudyn for a method."""
        return Exudyn.solver(self.inner, method)


class Changed(ExudynAdapter):
    """Exudyn with other settings of its time integration.

    Parameters
    ----------
    changes : mapping of str to value
        By name below ``timeIntegration``.
    """

    def __init__(self, changes: Mapping[str, Any]) -> None:
        super().__init__()
        self.changes = changes

    def settings(self, method: Method, start: float, step: float, large: bool = False) -> Any:
        """Return the adapter's settings, changed."""
        settings = super().settings(method, start, step, large)
        for name, value in self.changes.items():
            assign(settings, f"timeIntegration.{name}", value)
        return settings


class Unrestricted(ExudynAdapter):
    """Exudyn without the adapter's refusals, and with explicit solvers that it leaves out."""

    methods = (*Exudyn.methods, VELOCITY_VERLET, DVERK6)
    refuses_nothing = True

    def solver(self, method: Method) -> Any:
        """Return a new solver; those that the adapter leaves out are explicit."""
        if method in (VELOCITY_VERLET, DVERK6):
            return self.inner.exudyn.MainSolverExplicit()
        return super().solver(method)


class Spatial(ExudynAdapter):
    """Exudyn with the model ``spatial`` of a scene: the bodies of ``redundant`` in space."""

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the models."""
        return (*super().models(scene), "spatial")

    def own_source(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model."""
        if model != "spatial":
            return super().own_source(case, model)
        default = next(iter(mjcf.models(case.scene).values()))
        return exudyn_mjcf.model_of(case.scene, default, exudyn_mjcf.build_space)


class PushedExudyn(ExudynAdapter):
    """Exudyn with one more load on the first coordinate, which is one of Exudyn's own."""

    def __init__(self, law: Law) -> None:
        super().__init__()
        self.law = law

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case, with the load."""
        system = super().system(case, model)
        mbs, items = system.mbs, exudyn_system.items

        def push(mbs: Any, time: float, load: float) -> float:
            data = mbs.systemData
            q, v = (
                system.readout @ np.array(values)
                for values in (data.GetODE2Coordinates(), data.GetODE2Coordinates_t())
            )
            return float(self.law(q, v, case.parameters))

        (place,) = np.flatnonzero(system.readout[0])
        node, coordinate = divmod(int(place), 3 if self.bind(case, model).has_constraints else 100)
        first = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddLoad(items.LoadCoordinate(markerNumber=first, load=1.0, loadUserFunction=push))
        mbs.Assemble()
        return system


class Rebuilt(ExudynAdapter):
    """Exudyn with other functions or other items in a module that builds its models."""

    def __init__(self, module: ModuleType, **changes: Any) -> None:
        super().__init__()
        self.patched = partial(patch.multiple, module, **changes) if changes else nullcontext

    def system(self, case: Case, model: str) -> Any:
        """Return the system that is built with them."""
        with self.patched():
            return super().system(case, model)


class ReboundExudyn(Rebuilt):
    """Exudyn with other values in the MJCF that its models are built from, or of `Rebuilt`."""

    def __init__(
        self,
        bindings: Mapping[tuple[str, str], mjcf.Binding],
        module: ModuleType = exudyn_mjcf,
        **changes: Any,
    ) -> None:
        super().__init__(module, **changes)
        self.bindings = bindings

    def system(self, case: Case, model: str) -> Any:
        """Return the system that is built with them."""

        def export(source: mjcf.Mjcf, parameters: Any) -> str:
            bindings = {**source.bindings, **self.bindings}
            return mjcf.export(replace(source, bindings=bindings), parameters)

        with patch.object(exudyn_mjcf, "export", export):
            return super().system(case, model)


class OtherItems:
    """Exudyn's items, some of them exchanged."""

    def __init__(self, **items: Any) -> None:
        self.__dict__.update(items)

    def __getattr__(self, name: str) -> Any:
        return getattr(exudyn_system.items, name)


class FlippedExudyn(ExudynAdapter):
    """Exudyn with the slider-crank put together the other way round, the slider on top."""

    def system(self, case: Case, model: str) -> Any:
        """Return a system that is placed so."""
        system = super().system(case, model)
        r, kinds = case.parameters.crank_radius, self.inner.exudyn.ConfigurationType
        reference = np.array(system.mbs.systemData.GetODE2Coordinates(kinds.Reference))

        def place(q: Array, v: Array) -> tuple[Array, Array]:
            places, rates = (np.array(values) for values in system.place(q, v))
            pin, climb = r * np.sin(q[0]), r * np.cos(q[0]) * v[0]
            places += reference
            places[[4, 5, 7]] = 2 * pin - places[4], np.pi - places[5], 2 * pin - places[7]
            rates[[4, 5, 7]] = 2 * climb - rates[4], -rates[5], 2 * climb - rates[7]
            return places - reference, rates

        return replace(system, place=place)
