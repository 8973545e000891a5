"""Curves of equilibria and of homoclinic orbits, against closed forms and motions in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.continuation.bifurcations import (
    BRANCH_POINT,
    FOLD,
    NEIMARK_SACKER,
    BifurcationCurve,
    ParameterWindow,
)
from mbcheck.reference.continuation.network import CurveSearch, Line, Network, SearchOutcome, Task
from mbcheck.reference.continuation.rest import RestTracer
from mbcheck.reference.parameters import Parameters, quantity
from mbcheck.reference.scene import EquationsOfMotion, PeriodicOrbit, Scene
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.theory import least_torque, saddle_node_torques


@dataclass(frozen=True)
class Galloping(Parameters):
    """Parameters of ``x'' - (a - x^2) x' + b x + x^3 = f``: Hopf at a = 0, pitchfork at b = 0."""

    a: float = quantity(-0.5, "a", "1", "chosen", "negative damping", "any")
    b: float = quantity(1.0, "b", "1", "chosen", "stiffness", "any")
    f: float = quantity(0.0, "f", "1", "chosen", "load", "any")


class Numbers(NamedTuple):
    """Coefficients of `Galloping`."""

    a: Any
    b: Any
    f: Any


def pull(u: Any, q: Any, v: Any, c: Numbers, xp: Any = np) -> list[Any]:
    return [(c.a - q[0] ** 2) * v[0] - c.b * q[0] - q[0] ** 3 + c.f]


GALLOPING = EquationsOfMotion(
    name="galloping",
    title="Galloping",
    parameters=Galloping,
    coordinates=("x",),
    units={"x": "m", "x_dot": "m/s"},
    coefficients=lambda p: Numbers(p.a, p.b, p.f),
    mass_matrix=lambda q, c, xp=np: [[1.0]],
    forces=pull,
    accelerations=pull,
    damping_matrix=lambda c: np.zeros((1, 1)),
    energy=lambda q, v, c: 0.0,
    powers=lambda u, q, v, c: {},
    equilibria={
        "rest": lambda p: {},
        "aside": lambda p: {"x": 0.4},
        "beyond": lambda p: {"x": -0.4},
    },
    period=lambda p: 2 * np.pi,
)


def followed(
    scene: EquationsOfMotion, x: tuple[str, float, float], y: tuple[str, float, float], **base: Any
) -> tuple[Network, ParameterWindow]:
    """Return the network of a window, and the window."""
    ends = np.array([x[1:], y[1:]])
    window = ParameterWindow((x[0], y[0]), *ends.T)
    parameters = scene.parameters().replace(**base)
    tracer = RestTracer(scene, window.parameters(parameters), window=window)
    network = Network([*map(Line, (0.0, 0.5, 1.0))], 1)

    def execute(tasks: Sequence[Task]) -> SearchOutcome:
        search = CurveSearch(tracer, tracer)
        tasks[0](search)
        return search.outcome

    assert list(network.work(execute))
    return network, window


def places(network: Network, window: ParameterWindow, kind: str) -> list[np.ndarray]:
    """Return parameters (k, 2) and error bounds along the curves of a kind."""
    size = window.high - window.low
    return [
        np.array([[*(window.low + size * p.place), *(p.bound * size)] for p in curve.points])
        for curve in network.curves
        if curve.kind == kind
    ]


def test_hopf_points_lie_on_their_line() -> None:
    network, window = followed(GALLOPING, ("b", 0.5, 1.5), ("a", -0.5, 0.4))
    (curve,) = places(network, window, NEIMARK_SACKER)
    assert np.max(np.abs(curve[:, 1])) < 1e-12
    assert curve[[0, -1], 0] == pytest.approx([0.5, 1.5]) or curve[[0, -1], 0] == pytest.approx(
        [1.5, 0.5]
    )
    (item,) = network.curves
    tracer = RestTracer(GALLOPING, window.parameters(Galloping()), window=window)
    unit = tracer.units[1]
    for point, b in zip(item.points, curve[:, 0], strict=True):
        assert abs(np.log(point.critical) / unit) == pytest.approx(np.sqrt(b), rel=1e-9)


def test_a_pitchfork_is_followed_to_where_a_hopf_curve_begins() -> None:
    network, window = followed(GALLOPING, ("a", -0.5, 0.4), ("b", -0.5, 0.7))
    (branch,) = places(network, window, BRANCH_POINT)
    assert np.max(np.abs(branch[:, 1])) < 1e-10
    hopf = places(network, window, NEIMARK_SACKER)
    assert hopf
    for a, b, *_ in np.vstack(hopf):  # about x = 0, and about x^2 = -b
        assert min(abs(a), abs(a + b)) < 1e-9
    assert not places(network, window, FOLD)
    (pitchfork,) = (curve for curve in network.curves if curve.kind == BRANCH_POINT)
    assert "with_neimark_sacker" in pitchfork.ends


def test_folds_form_a_cusp() -> None:
    """With a load the pitchfork unfolds: 4 b^3 + 27 f^2 = 0."""
    network, window = followed(GALLOPING, ("b", -0.6, 0.2), ("f", -0.15, 0.2))
    curves = places(network, window, FOLD)
    assert sum(len(curve) for curve in curves) > 8
    for curve in curves:
        b, f, *bound = curve.T
        np.testing.assert_allclose(4 * b**3 + 27 * f**2, 0, atol=1e-12)
        assert np.max(bound) < 1e-12


def test_the_rod_without_gravity_turns_over_on_a_line() -> None:
    network, window = followed(
        get_scene("hula_hoop"), ("stiffness", 500, 1500), ("gravity_x", -5, 6), force_amplitude=0.0
    )
    (curve,) = places(network, window, BRANCH_POINT)
    assert np.max(np.abs(curve[:, 1])) < 1e-12


def test_the_cranks_rest_ends_where_the_spring_gives_way() -> None:
    scene = get_scene("speed_regulator")
    still = replace(scene, orbit=PeriodicOrbit())  # no homoclinic orbits
    network, window = followed(still, ("stiffness", 20, 40), ("torque", 0.4, 1.5))
    curves = places(network, window, FOLD)
    assert len(curves) == 2
    for curve in curves:
        for stiffness, torque, *bounds in curve:
            p = SpeedRegulator(stiffness=stiffness)
            off = min(abs(torque - own) for own in saddle_node_torques(p).values())
            assert off < max(bounds) + 1e-14
            assert max(bounds) < 1e-10


def least_curves(scene: Scene, window: ParameterWindow, *count: int) -> list[BifurcationCurve]:
    """Return the curves on which rotations end in a window."""
    tracer = RestTracer(scene, window.parameters(scene.parameters()), window=window)
    return tracer.least_curves(*count)


@pytest.mark.slow
def test_the_rotation_ends_at_homoclinic_orbits() -> None:
    """The curve begins where the least torque comes into the window."""
    scene = get_scene("speed_regulator")
    window = ParameterWindow(("damping", "torque"), np.array([2.0, 0.06]), np.array([4.0, 0.13]))
    (curve,) = least_curves(scene, window, 3)
    assert curve.ends == ("window", "window")
    places = np.array([window.low + (window.high - window.low) * p.place for p in curve.points])
    assert places[0, 1] == pytest.approx(0.06, abs=1e-8)
    assert places[-1, 0] == pytest.approx(4)
    for (damping, torque), point in zip(places, curve.points, strict=True):
        limit = least_torque(SpeedRegulator(damping=damping))
        assert abs(torque - limit.torque) < 1e-12
        assert limit.error <= point.bound[1] * 0.07 * 1.001 < 1e-8
        assert abs(point.critical) > 1
        assert not point.unstable


@pytest.mark.slow
def test_the_curve_of_homoclinic_orbits_ends_where_the_saddle_vanishes() -> None:
    scene = get_scene("speed_regulator")
    window = ParameterWindow(("damping", "torque"), np.array([48.0, 0.9]), np.array([60.0, 1.2]))
    (curve,) = least_curves(scene, window)
    assert curve.ends == ("window", "with_fold")


@pytest.mark.slow
def test_the_curve_of_homoclinic_orbits_may_leave_the_window_and_come_back() -> None:
    """Each stay is a curve of its own, and one that passes between two places is there."""
    scene = get_scene("speed_regulator")
    window = ParameterWindow(
        ("spring_rest", "torque"), np.array([-2.6, 0.1]), np.array([0.1, 0.25])
    )
    curves = least_curves(scene, window, 7)
    assert len(curves) == 2
    for curve in curves:
        for point in curve.points:
            rest, torque = window.low + (window.high - window.low) * point.place
            limit = least_torque(SpeedRegulator(spring_rest=float(rest)))
            assert torque == pytest.approx(limit.torque, abs=1e-9)
    narrow = ParameterWindow(("damping", "torque"), np.array([0.1, 0.05]), np.array([20.0, 0.06]))
    (curve,) = least_curves(scene, narrow, 9)
    assert curve.ends == ("window", "window")
    ends = [narrow.low[1] + 0.01 * float(p.place[1]) for p in (curve.points[0], curve.points[-1])]
    assert ends == pytest.approx([0.05, 0.06], abs=1e-8)
