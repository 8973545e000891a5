"""What figures and ledger of the rotor_pendulum paper share: orbits, runs, maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....reference import get_scene
from ....reference.errors import NoOrbitError
from ....reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients
from ....reference.rotor_pendulum.theory import Ratios
from ....reference.scene import Array
from ....reference.solve.single import states_at
from ...engines.registry import REFERENCE
from ...maps.store import Map
from ...queries.orbit import OrbitReport, find
from ...queries.request import Query
from ...queries.simulate import simulate
from ...scenes.quantity import Points
from ...scenes.rotor_pendulum.maps import QUANTITIES
from ...scenes.rotor_pendulum.phase import PHASES
from ..session import Session

SCENE = "rotor_pendulum"
REDUCED = "reduced"

CASES: Mapping[int, RotorPendulum] = {1: CASE_1, 2: CASE_2, 3: CASE_3}
PRINTED_RATIOS: Mapping[int, Ratios] = {
    1: Ratios(0.4943, 0.4943),
    2: Ratios(5.916, 5.029),
    3: Ratios(5.916, 5.029, beta=np.pi / 2),
}
"""Frequency ratios and installation angle printed for each case."""

BETAS = {"0": 0.0, "pi/6": np.pi / 6, "pi/3": np.pi / 3, "5 pi/12": 5 * np.pi / 12}
"""Installation angles [rad] of figure 3, by name."""
RANGE = (0.1, 7.0)
"""Of both frequency ratios in figs. 2, 3, and table 2."""

GRID, FULL_GRID = 29, 64
ENGINE_GRID, ENGINE_FULL_GRID = 8, 22
"""Points along an axis: of the smaller grids, the engines' are a part of the reference's."""

HORIZONS: Mapping[int, float] = {1: 16.0, 2: 4.0, 3: 10.0}
"""Time [s] of the simulations, which the text does not give: in case 1 the rotors start
beside the unstable phase and leave it at 0.5 1/s; in case 3 they slip by 1 rad/s."""

PER_SECOND = 1024
"""Samples of a run: 42 in a turn."""

STEP = 2.0**-12
"""Step of the engines [s], each with its method of highest order: 170 in a turn."""

RUN_TOLERANCES = {REFERENCE: (1e-10, 1e-8), REDUCED: (1e-7, 1e-6)}
"""Of the answer and of its check: the runs are long, and (11) is further off than that."""


def changes(p: RotorPendulum) -> dict[str, Any]:
    """Return the parameters that differ from the scene's defaults."""
    default = CASE_1.as_dict()
    return {name: value for name, value in p.as_dict().items() if value != default[name]}


def synchronous_orbit(
    session: Session, p: RotorPendulum, engine: str = REFERENCE, model: str | None = None
) -> OrbitReport | None:
    """Return the synchronous orbit, or None if there is none."""

    def search() -> OrbitReport | None:
        try:
            asked = Query(SCENE, engine=engine, model=model, parameters=changes(p))
            return find(asked, bounded=False)
        except NoOrbitError:
            return None

    return session.once((SCENE, "orbit", p, engine, model), search)


def orbit_value(report: OrbitReport | None, quantity: str) -> float:
    """Return a quantity of an orbit, NaN without one."""
    return np.nan if report is None else report.quantities[quantity].value


@dataclass(frozen=True)
class Settled:
    """The synchronous orbit of a set of parameters, of which there may be none.

    Attributes
    ----------
    kind : str
        One of `mbcheck.comparisons.scenes.rotor_pendulum.maps.PHASES`.
    phase, speed, torque : float
        Mean phase difference [rad], speed [rad/s] and motor torque [N m]; NaN without one.
    """

    kind: str
    phase: float
    speed: float
    torque: float

    @property
    def words(self) -> str:
        """Return what to print."""
        if self.kind == "none":
            return "not there"
        return f"{self.kind}, {self.phase:.4f} rad at {self.speed:.2f} rad/s, {self.torque:.3g} N m"


def settled(
    session: Session, several: Sequence[RotorPendulum], model: str = "exact"
) -> list[Settled]:
    """Return the orbits of many parameters, all with the motor in one place."""
    numbers = {
        name: np.array([getattr(p, name) for p in several])
        for name in RotorPendulum.numeric_names()
    }
    together = several[0].replace(**numbers)
    places = np.arange(len(several))[:, None] * np.array([100, 0])  # no neighbours
    points = Points(get_scene(SCENE), together, places, {}, REFERENCE, model)
    values = session.once(
        (SCENE, tuple(several), model), lambda: QUANTITIES["phase"].evaluate(points).values
    )
    return [
        Settled(
            PHASES[int(values["class"][i])],
            float(values["phase_difference"][i]),
            float(values["mean_speed"][i]),
            float(p.motor_slope * (p.synchronous_speed - values["mean_speed"][i])),
        )
        for i, p in enumerate(several)
    ]


@dataclass(frozen=True)
class StartUp:
    """A run from rest.

    Attributes
    ----------
    parameters : RotorPendulum
    times : array (n,) [s]
    states : array (8, n)
    """

    parameters: RotorPendulum
    times: Array
    states: Array

    @property
    def phase(self) -> Array:
        """phi_1 - phi_2 [rad], which starts at 0 and is not wrapped."""
        return self.states[1] - self.states[2]

    @property
    def torques(self) -> tuple[Array, Array]:
        """Torques of the two motors [N m]."""
        c = coefficients(self.parameters)
        first, second = (c.slope * (c.speed - rate) for rate in self.states[5:7])
        return first, second

    @property
    def last(self) -> slice:
        """The last second."""
        return slice(-PER_SECOND, None)

    def after(self, time: float) -> slice:
        """Return what comes after a time [s]."""
        return slice(int(time * PER_SECOND), None)


def from_rest(session: Session, case: int, who: str = REFERENCE) -> StartUp:
    """Return the start-up of a case: by the reference, its `REDUCED` equations, or an engine."""
    p = CASES[case]
    times = np.arange(round((session.seconds or HORIZONS[case]) * PER_SECOND) + 1) / PER_SECOND

    def states() -> Array:
        scene = get_scene(SCENE)
        if who in (REFERENCE, REDUCED):
            own = scene.variants.get(who, scene)
            return states_at(own, p, np.zeros(8), times, RUN_TOLERANCES[who])
        run = simulate(SCENE, engine=who, step=STEP, parameters=changes(p), times=times)
        return np.array([run.observables[name] for name in scene.state_names])

    return session.once((SCENE, "from rest", case, who), lambda: StartUp(p, times, states()))


def phase_map(session: Session, beta: float, model: str = "exact", engine: str = "") -> Map:
    """Return the phase over n_x and n_phi: by a model of the reference, or an engine."""
    fewer = session.engine_points or ENGINE_GRID
    counts = (fewer, ENGINE_FULL_GRID) if engine else (GRID, FULL_GRID)
    axis = (*RANGE, session.points or counts[session.full])
    return session.map(
        SCENE,
        "phase",
        ("n_x", *axis),
        ("n_phi", *axis),
        engine=engine or REFERENCE,
        model=None if engine else model,
        parameters={"installation_angle": beta},
    )


def inside(plane: Map, x: tuple[float, float], y: tuple[float, float]) -> Any:
    """Return which points of a map lie between two n_x and two n_phi, ends included."""
    column, row = plane.x.values, plane.y.values
    return _between(row, *y)[:, None] & _between(column, *x)[None]


def _between(values: Array, low: float, high: float) -> Any:
    return (values > low - NEAR) & (values < high + NEAR)


NEAR = 1e-9
"""Distance of a value from an end that is rounding."""


def class_shares(plane: Map, where: Any) -> dict[str, float]:
    """Return the share of each class that there is among some points of a map."""
    classes, names = plane.variables["class"][where], plane.about["class"].classes
    shares = {name: float(np.mean(classes == i)) for i, name in enumerate(names)}
    return {name: share for name, share in shares.items() if share > 0}
