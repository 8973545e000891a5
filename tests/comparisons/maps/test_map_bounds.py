"""The numbers of maps keep the bounds that they state, against extended precision."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.maps.request import quantities
from mbcheck.comparisons.scenes.hula_hoop.floquet import rotation_values
from mbcheck.comparisons.scenes.hula_hoop.floquet import rotations as rotations_of
from mbcheck.comparisons.scenes.quantity import Points, QuantityValues
from mbcheck.comparisons.scenes.rotor_pendulum.maps import coupling
from mbcheck.comparisons.scenes.rotor_pendulum.phase import orbit_values, orbits_of
from mbcheck.comparisons.scenes.speed_regulator.limit_cycles import rotations, speed_values
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.orbits import period_advance, section_row
from mbcheck.reference.periodic import extremes
from mbcheck.reference.solve.rk8 import rk8_steps
from mbcheck.tests.support.exact import orbits as exact
from mbcheck.tests.support.exact.orbits import LONG

EXTENDED = pytest.mark.skipif(
    not exact.EXTENDED, reason="no numbers with more digits than doubles on this platform"
)

Truth = Mapping[str, list[tuple[int, float]]]
"""By variable the numbers of points, and how far off each is."""


def drawn(scene: str, count: int, seed: int, spread: float, model: str = "exact") -> Points:
    """Return points up to so many decades around the default parameters, none near another."""
    rng, known = np.random.default_rng(seed), get_scene(scene)
    values: dict[str, Any] = {
        name: value * 10 ** rng.uniform(-spread, spread, count)
        for name, value in known.parameters().as_dict().items()
        if not isinstance(value, str)
    }
    if scene == "hula_hoop":
        values["inertia_ratio"] = rng.choice([0.0, 1.0], count) * rng.uniform(0, 3, count)
        values["force_frequency"] = rng.uniform(1, 10, count)
        values["force_amplitude"] = rng.uniform(5, 150, count)
    if scene == "speed_regulator":
        values["rod_length"] = values["crank_radius"] * rng.choice([1.02, 1.5, 5.0, 20.0], count)
        values["spring_rest"] = -values["rod_length"]
    places = np.arange(count)[:, None] * np.array([[1000, 0]])
    parameters = known.parameters().replace(**values)
    return Points(known, parameters, places, {}, REFERENCE, model)


def true_orbits(
    points: Points, which: Any, states: Any, periods: Any, steps: int
) -> tuple[Any, Any, Any]:
    """Return samples (k, 2 n, steps) of the orbits, their periods and multipliers."""
    scene, motion_of = points.scene, getattr(exact, points.scene.name)
    of = [points.one(i) for i in which]
    known = [SimpleNamespace(state=x, period=t) for x, t in zip(states.T, periods, strict=True)]
    x, period, jacobians, change = exact.orbits(
        motion_of, of, known, period_advance(scene).astype(LONG), section_row(scene), steps
    )  # fmt: skip
    assert np.max(change) < 1e-10, "the truth itself has not converged"
    path = exact.flow(motion_of, x, period, exact.stacked(of), steps)[:-1]
    return (
        np.moveaxis(path, -1, 0).swapaxes(1, 2),
        period,
        np.linalg.eigvals(jacobians.astype(float)),
    )


def floquet_errors(count: int, seed: int, spread: float) -> tuple[QuantityValues, Truth]:
    points = drawn("hula_hoop", count, seed, spread)
    maps, orbits = rotations_of(points)
    found = rotation_values(maps, orbits)
    which, number = np.flatnonzero(orbits.closed), 192
    samples, period, multipliers = true_orbits(
        points, which, orbits.states[:, which], maps.periods[which], number
    )
    phase = 2 * exact.PI * np.arange(number) / number
    swing = samples[:, 1] - phase
    truth = {
        "multiplier": np.max(np.abs(multipliers), axis=1),
        "u_1": 2 * np.abs(np.mean(swing * np.exp(-2j * phase), axis=1)),
        "min_speed": [
            extremes(row)[0]
            for row in (samples[:, 3] * period[:, None] / (2 * exact.PI)).astype(float)
        ],
    }
    return found, errors(found, which, truth)


def phase_errors(count: int, seed: int, spread: float) -> tuple[QuantityValues, Truth]:
    points = drawn("rotor_pendulum", count, seed, spread)
    maps, orbits = orbits_of(points)
    found, which = orbit_values(maps, orbits), np.flatnonzero(orbits.closed)
    samples, period, multipliers = true_orbits(
        points, which, orbits.states[:, which], orbits.periods[which], 192
    )
    trivial = np.argmin(np.abs(multipliers - 1), axis=1)
    np.put_along_axis(multipliers, trivial[:, None], 0.0, axis=1)
    turned = np.exp(1j * (samples[:, 1] - samples[:, 2])).mean(axis=1)
    truth = {
        "phase_difference": np.angle(turned.astype(complex)),
        "mean_speed": 2 * exact.PI / period,
        "multiplier": np.max(np.abs(multipliers), axis=1),
    }
    return found, errors(found, which, truth)


def speed_errors(count: int, seed: int, spread: float) -> tuple[QuantityValues, Truth]:
    points = drawn("speed_regulator", count, seed, spread)
    cycles = rotations(points)
    found = speed_values(points, cycles.mean_speed, cycles.bound, {})
    which = np.flatnonzero(np.isfinite(cycles.mean_speed))
    starts = np.stack([0 * cycles.start_speed, cycles.start_speed])[:, which]
    with np.errstate(all="ignore"):
        rough, fine = (
            true_orbits(points, which, starts, 2 * np.pi / cycles.mean_speed[which], steps)[1]
            for steps in (144, 288)
        )
    good = np.abs(rough - fine) / fine * cycles.mean_speed[which] < 0.02 * cycles.bound[which]
    assert np.mean(good) > 0.5  # a crank that nearly stands takes more steps than the truth does
    return found, errors(found, which[good], {"mean_speed": (2 * exact.PI / fine)[good]})


def coupling_errors(count: int, seed: int, spread: float) -> tuple[QuantityValues, Truth]:
    points = drawn("rotor_pendulum", count, seed, spread, "corrected")
    with mp.workdps(40):
        rows = [exact_coupling(points.one(i)) for i in range(count)]
        truth = dict(zip(("mu_1", "mu_2", "mu_3", "mu_4"), zip(*rows, strict=True), strict=True))
        found = coupling(points)
        return found, errors(found, np.arange(count), truth)


def exact_coupling(p: Any) -> list[Any]:
    """Return the coupling coefficients (22), mu_1 corrected, in many digits."""
    m = {name: mp.mpf(value) for name, value in p.as_dict().items() if not isinstance(value, str)}
    end = m["rotor_mass"] + m["rod_mass"]
    mass = m["platform_mass"] + end + m["rotor_mass"]
    speed = m["motor_slope"] * m["synchronous_speed"] / (m["motor_slope"] + m["friction"])
    x = speed**2 * mass / m["platform_stiffness"]
    phi = speed**2 * m["rod_length"] ** 2 * end / m["rod_stiffness"]
    sigma, r, sin = m["rotor_mass"] / end, m["rotor_mass"] / mass, mp.sin(m["installation_angle"])
    n = sigma * (1 - x) * (1 - phi) - r * x * phi * sin**2
    sums = sigma * x * (phi - 1), r * x * phi * sin, sigma * x * phi * sin, sigma * (x - 1) * phi
    return [one / n for one in sums]


def errors(found: QuantityValues, which: Any, truth: Mapping[str, Any]) -> Truth:
    """Return how far off the values at some points are."""
    off: dict[str, list[tuple[int, float]]] = {}
    for name, values in truth.items():
        own = found.values[name][which]
        apart = [
            abs(mp.mpf(float(a)) - b) if isinstance(b, mp.mpf) else abs(b - LONG(a))
            for a, b in zip(own, values, strict=True)
        ]
        turn = 2 * np.pi if name == "phase_difference" else np.inf
        off[name] = [
            (int(i), min(float(e), abs(turn - float(e)))) for i, e in zip(which, apart, strict=True)
        ]
    return off


ROUTES: Mapping[str, tuple[Callable[..., tuple[QuantityValues, Truth]], int, int]] = {
    "floquet": (floquet_errors, 2, 300),
    "phase": (phase_errors, 1, 64),
    "mean_speed": (speed_errors, 4, 300),
    "coupling": (coupling_errors, 20, 500),
}
"""What is off by how much, how many points are drawn by default, and how many by hand."""

SLOW = ("phase", 0.3), ("mean_speed", 0.3), ("floquet", 0.3)
BY_HAND = ("phase", 0.05), ("mean_speed", 0.05)
"""Routes and spreads that take longest; the narrow draws of two are a campaign's alone."""

MEDIAN = 150.0
"""Largest median of bound over error: of mean speeds, whose only error is rounding."""

ROUNDED = 1e-11
"""Median error below which numbers are exact to rounding: the bounds of multipliers are norms, 1e5
times that."""


@EXTENDED
@pytest.mark.parametrize(
    ("route", "count", "spread"),
    [
        pytest.param(name, count, spread, marks=marks)
        for spread in (0.05, 0.3)
        for name, (_, few, many) in ROUTES.items()
        for count, marks in (
            (few, [pytest.mark.slow] if (name, spread) in SLOW else []),
            (many, [pytest.mark.campaign]),
        )
        if count == many or (name, spread) not in BY_HAND
    ],
)
def test_drawn_points_keep_their_bounds(route: str, count: int, spread: float) -> None:
    found, truth = ROUTES[route][0](count, count, spread)
    for name, rows in truth.items():
        bounds = found.values[f"{name}_bound"]
        pairs = np.array([(e, bounds[i]) for i, e in rows if np.isfinite(bounds[i])])
        shares = pairs[:, 0] / pairs[:, 1]
        median = np.median(1 / shares[shares > 0])
        print(
            f"{route} {name} ({spread}): {len(pairs)} of {len(rows)} known, largest error/bound "
            f"{shares.max():.2g}, median of bound/error {median:.3g}"
        )
        assert len(pairs) > 0.9 * len(rows)
        assert shares.max() <= 1
        assert count < 60 or median < MEDIAN or np.median(pairs[:, 0]) < ROUNDED


@pytest.mark.parametrize("steps", [16, 24, 48])
def test_the_second_run_is_better_by_its_order(steps: int) -> None:
    """What the bounds take for granted: a factor of 2; the method's order 8 has 255."""
    scene = get_scene("hula_hoop")
    derivative, x = scene.right_hand_side(scene.parameters()), np.array([0.1, 0.2, 0.3, 4.0])
    truth = rk8_steps(derivative, x, 0.0, 0.2, 200)
    first, second = (
        np.max(np.abs(rk8_steps(derivative, x, 0.0, 0.2, n) - truth)) for n in (steps, 2 * steps)
    )
    assert second < first / 2
    assert first < 1e-12 or second < first / 64


def test_real_variables_have_bounds() -> None:
    """Those of the beam have names of their own; growth rates and periods are told by classes."""
    without = {
        (scene, quantity): {
            name
            for name, about in quantities(scene)[quantity].variables.items()
            if not about.classes and "bound" not in name and name != "robust"
            if f"{name}_bound" not in quantities(scene)[quantity].variables
        }
        for scene in SCENES
        if scene != "rotating_beam"
        for quantity in quantities(scene)
    }
    assert {key: names for key, names in without.items() if names} == {
        ("hula_hoop", "class"): {"periods"}
    }


def test_engines_have_no_bounds() -> None:
    points = replace(drawn("speed_regulator", 2, 1, 0.01), engine="mujoco", model="")
    values = quantities("speed_regulator")["mean_speed"].evaluate(points).values
    assert np.all(np.isnan(values["mean_speed_bound"]))
