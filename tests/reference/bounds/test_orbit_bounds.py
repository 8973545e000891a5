"""Periodic orbits keep the bounds that they state, against extended precision."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.bounds.orbits import OrbitBounds, orbit_bounds
from mbcheck.reference.errors import MbcheckError, NoOrbitError
from mbcheck.reference.orbits import (
    Orbit,
    find_orbit,
    mean_powers,
    orbit_samples,
    period_advance,
    section_row,
    shoot,
)
from mbcheck.reference.periodic import harmonics
from mbcheck.reference.scene import Scene
from mbcheck.tests.support.exact import orbits as exact_orbits
from mbcheck.tests.support.exact.orbits import LONG

pytestmark = pytest.mark.skipif(
    not exact_orbits.EXTENDED, reason="no numbers with more digits than doubles on this platform"
)

SCENES = ("hula_hoop", "rotor_pendulum", "speed_regulator")
"""Those with periodic orbits: nothing drives rigid_body on, and a beam is pushed or spun up."""


def drawn(scene: str, rng: np.random.Generator, spread: float) -> Any:
    """Return parameters up to so many decades around the paper's."""
    default = get_scene(scene).parameters()
    values: dict[str, Any] = {
        name: value if isinstance(value, str) else value * 10 ** rng.uniform(-spread, spread)
        for name, value in default.as_dict().items()
    }
    if scene == "hula_hoop":
        values["inertia_ratio"] = rng.choice([0.0, rng.uniform(0, 3)])
    if scene == "rotor_pendulum":
        values["motor_placement"] = str(rng.choice(["absolute", "relative"]))
    if scene == "speed_regulator":
        values["rod_length"] = values["crank_radius"] * rng.choice([1.02, 1.5, 5.0, 20.0])
        values["spring_rest"] = -values["rod_length"]
    return default.replace(**values)


def found(scene: str, count: int, seed: int) -> tuple[list[Any], list[Orbit], list[OrbitBounds]]:
    """Return parameters, orbits and bounds of drawn points that have an orbit."""
    rng, known = np.random.default_rng(seed), get_scene(scene)
    rows: list[tuple[Any, Orbit, OrbitBounds]] = []
    while len(rows) < count:
        try:
            p = drawn(scene, rng, 0.03 if count <= FEW else float(rng.choice([0.05, 0.15, 0.4])))
            orbit = find_orbit(known, p)
            rows.append((p, orbit, orbit_bounds(known, p, orbit)))
        except (NoOrbitError, MbcheckError):
            continue
    return tuple(map(list, zip(*rows, strict=True)))  # type: ignore[return-value]


def shares(scene: str, count: int, seed: int, steps: int) -> Iterator[tuple[str, float, float]]:
    """Yield error over bound, and bound relative to the size, of periods, states, multipliers."""
    known = get_scene(scene)
    parameters, orbits, bounds = found(scene, count, seed)
    states, periods, jacobians, change = exact_orbits.orbits(
        getattr(exact_orbits, scene), parameters, orbits, period_advance(known).astype(LONG),
        section_row(known), steps,
    )  # fmt: skip
    scale = np.max(np.abs(states), axis=0)
    for i, (orbit, bound) in enumerate(zip(orbits, bounds, strict=True)):
        assert change[i] < 1e-2 * np.max(bound.state), "the truth itself has not converged"
        off = np.abs(states[:, i] - orbit.state)
        turning = [known.rotations_per_period.get(k, 0) for k in known.state_names]
        off = np.where(turning, np.minimum(off, np.abs(off - 2 * exact_orbits.PI)), off)
        for error, limit in zip(off, bound.state, strict=True):
            if limit:
                yield "state", float(error / limit), float(limit / scale[i])
        period = np.abs(periods[i] - LONG(orbit.period))
        yield "period", float(period / bound.period), float(bound.period / orbit.period)
        with mpmath.workdps(30):
            rows = [[mpmath.mpf(str(value)) for value in row] for row in jacobians[i]]
            values = mpmath.eig(mpmath.matrix(rows), left=False, right=False)
        for value, limit in zip(orbit.multipliers, bound.multipliers, strict=True):
            error = min(abs(other - complex(value)) for other in values)
            yield "multiplier", float(error / limit), float(limit)
    truth = exact_orbits.stacked(parameters)
    path = exact_orbits.flow(getattr(exact_orbits, scene), states, periods, truth, steps)[:-1]
    for i, rest in enumerate(zip(parameters, orbits, bounds, strict=True)):
        p = object.__new__(type(rest[0]))  # which takes doubles alone
        vars(p).update({name: value[i] for name, value in vars(truth).items()})
        yield from sampled(known, *rest, path[..., i].T, known.coefficients(p))


def sampled(
    known: Scene, p: Any, orbit: Orbit, bound: OrbitBounds, path: Any, c: Any
) -> Iterator[tuple[str, float, float]]:
    """Yield the same of what follows from samples: harmonics, powers, quantities.

    ``path`` holds the true states (2 n, k), and ``c`` the true coefficients.
    """
    samples, own = orbit_samples(known, p, orbit), known.coefficients(p)
    turns = [known.rotations_per_period.get(name, 0) for name in known.state_names]
    phase = 2 * exact_orbits.PI * np.arange(path.shape[1]) / path.shape[1]
    for row, limit in enumerate(bound.harmonics):
        mean, terms = harmonics(samples[row], turns[row])
        swing = path[row] - turns[row] * phase
        off = abs(np.mean(swing) - LONG(mean))
        off = min(off, abs(off - 2 * exact_orbits.PI)) if turns[row] else off
        for term in terms:  # the bound is one for all of them
            true = 2 * np.mean(swing * np.exp(-1j * term.order * phase))
            amplitude = LONG(term.amplitude) * np.exp(1j * LONG(term.phase))
            off = max(off, abs(true - amplitude))
        yield "harmonic", float(off / limit), float(limit / np.max(np.abs(swing)))
    tables = (
        ("power", mean_powers(known, samples, own, orbit.period), bound.power,
         mean_powers(known, path, c, orbit.period)),
        ("quantity", known.orbit.quantities(samples, own), bound.quantities,
         known.orbit.quantities(path, c)),
    )  # fmt: skip
    for kind, values, limits, true_values in tables:
        for name, limit in limits.items():
            apart = abs(true_values[name] - values[name])
            if name == "phase_difference":
                apart = min(apart, abs(apart - 2 * np.pi))
            if limit:
                size = abs(values[name]) or 1.0
                yield kind, float(apart / limit), float(limit / size)
            else:
                assert apart == 0


MOST = 0.5
"""Largest share of a multiplier's bound that its error may be: two numbers of steps differ by the
error of the smaller one, and their difference counts twice."""


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("hula_hoop", {}),
        ("hula_hoop", {"force_amplitude": 66.0, "force_frequency": 3.83, "rod_length": 0.0667}),
        ("speed_regulator", {}),
        ("speed_regulator", {"stiffness": 0.0}),
    ],
)
def test_multipliers_keep_half_their_bounds(name: str, changes: dict[str, float]) -> None:
    """By the steps of the reference, and by so few that truncation is all of the error."""
    scene = get_scene(name)
    p = scene.parameters().replace(**changes)
    found = find_orbit(scene, p)

    def at(steps: int) -> Orbit:
        """Return the orbit by so many steps, its slopes those at the orbit."""
        near = shoot(scene, p, found.state[:, None], steps, np.array([found.period]))
        near = shoot(scene, p, near.states, steps, near.periods)
        return replace(
            found, state=near.states[:, 0], period=float(near.periods[0]),
            multipliers=near.multipliers[:, 0], steps=steps,
        )  # fmt: skip

    truth = at(3 * found.steps).multipliers
    for orbit in (found, at(16), at(8)):
        bounds = orbit_bounds(scene, p, orbit).multipliers
        errors = [np.min(np.abs(truth - value)) for value in orbit.multipliers]
        assert np.all(errors <= MOST * bounds), (orbit.steps, errors / bounds)


STEPS = {"hula_hoop": 144, "rotor_pendulum": 288, "speed_regulator": 288}
"""Of the truth, over a period; 144 leave extremes of fast rotations 1e-12 off."""

MEDIAN = 30.0
"""Largest median of bound over error."""

FEW = 2
"""Orbits that are drawn by default, near the papers'; `DRAWS` behind the marker."""

DRAWS = {"hula_hoop": 40, "rotor_pendulum": 12, "speed_regulator": 40}


@pytest.mark.parametrize(
    ("scene", "count"),
    [("hula_hoop", FEW), pytest.param("speed_regulator", FEW, marks=pytest.mark.slow)]
    + [pytest.param(scene, DRAWS[scene], marks=pytest.mark.campaign) for scene in SCENES],
)
def test_drawn_orbits_keep_their_bounds(scene: str, count: int) -> None:
    rows = list(shares(scene, count, seed=count, steps=STEPS[scene]))
    kinds = ["state", "period", "multiplier", "harmonic", "power"]
    kinds += ["quantity"] if get_scene(scene).orbit.units else []
    for kind in kinds:
        error, bound = np.array([row[1:] for row in rows if row[0] == kind]).T
        assert np.max(error) <= 1, kind
        print(
            f"{scene}: {kind} {len(error)}, largest error/bound {error.max():.2g}, median of "
            f"bound/error {np.median(1 / error[error > 0]):.3g}, bound {np.median(bound):.2g}"
        )
        if count > FEW and kind in ("state", "multiplier"):
            assert 1 / np.median(error) < MEDIAN, kind
