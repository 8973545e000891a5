"""Wrong engines: Exudyn with something changed or undone, or with more methods and models."""

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
from ...models.system import System
from ...reference.scene import Array, Case
from ..engines.adapter import Adapter
from ..engines.exudyn.engine import Exudyn, assign
from ..engines.protocol import Method
from .variants import Law

VELOCITY_VERLET = Method("VelocityVerlet", 2)
DVERK6 = Method("DVERK6", 6)


class ExudynAdapter(Adapter):
    """Exudyn as checks call it.

    Parameters
    ----------
    inner : Exudyn, optional
    """

    inner: Exudyn

    def __init__(self, inner: Exudyn | None = None) -> None:
        super().__init__(inner or Exudyn())


class Changed(Exudyn):
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
        """Return the engine's settings, changed."""
        settings = super().settings(method, start, step, large)
        for name, value in self.changes.items():
            assign(settings, f"timeIntegration.{name}", value)
        return settings


class Unrestricted(Exudyn):
    """Exudyn that refuses nothing, with the explicit solvers that `Exudyn` leaves out."""

    methods = (*Exudyn.methods, VELOCITY_VERLET, DVERK6)

    def unsupported_reason(self, system: System, method: Method | None) -> None:
        """Refuse nothing."""

    def solver(self, method: Method) -> Any:
        """Return a new solver."""
        if method in (VELOCITY_VERLET, DVERK6):
            return self.exudyn.MainSolverExplicit()
        return super().solver(method)


class Spatial(Exudyn):
    """Exudyn with the model ``spatial`` of a scene: the bodies of ``redundant`` in space."""

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the models."""
        return (*super().models(scene), "spatial")

    def source(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model."""
        if model != "spatial":
            return super().source(case, model)
        default = next(iter(mjcf.models(case.scene).values()))
        return exudyn_mjcf.model_of(case.scene, default, exudyn_mjcf.build_space)


class PushedExudyn(Exudyn):
    """Exudyn with an additional load on the scene's first coordinate."""

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

        (place,) = np.flatnonzero(system.readout[0])  # a coordinate of the first node
        first = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=0, coordinate=int(place)))
        mbs.AddLoad(items.LoadCoordinate(markerNumber=first, load=1.0, loadUserFunction=push))
        mbs.Assemble()
        return system


class Rebuilt(Exudyn):
    """Exudyn with other functions or other items in a module that builds its models."""

    def __init__(self, module: ModuleType, **changes: Any) -> None:
        super().__init__()
        self.patched = partial(patch.multiple, module, **changes) if changes else nullcontext

    def system(self, case: Case, model: str) -> Any:
        """Return the system of a case, built with them."""
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
        """Return the system of a case, built with them."""

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


class FlippedExudyn(Exudyn):
    """Exudyn with the slider-crank on its other assembly branch, the slider on top."""

    def system(self, case: Case, model: str) -> Any:
        """Return the system of a case on that branch."""
        system = super().system(case, model)
        r, kinds = case.parameters.crank_radius, self.exudyn.ConfigurationType
        reference = np.array(system.mbs.systemData.GetODE2Coordinates(kinds.Reference))

        def place(q: Array, v: Array) -> tuple[Array, Array]:
            places, rates = (np.array(values) for values in system.place(q, v))
            pin, climb = r * np.sin(q[0]), r * np.cos(q[0]) * v[0]
            places[6] += 2 * (pin - system.outputs(places, rates)["y"])  # the slider
            places += reference
            places[[4, 5]] = 2 * pin - places[4], np.pi - places[5]
            rates[[4, 5, 6]] = 2 * climb - rates[4], -rates[5], 2 * climb - rates[6]
            return places - reference, rates

        return replace(system, place=place)
