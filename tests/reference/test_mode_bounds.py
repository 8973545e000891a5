"""Modes keep the bounds that they state, against characteristic polynomials in many digits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from mbcheck.reference import get_scene
from mbcheck.reference.errors import MbcheckError, NoOrbitError
from mbcheck.reference.linear import Mode, linearise
from mbcheck.reference.mode_bounds import Linear, bounded_modes, linearisation_error
from mbcheck.tests.support import exact_modes

DRAWS = 500
FEW = 10

TIGHT = 30.0
"""Largest median of bound over error, where the error is not below what rounding a result costs."""


def drawn(scene: str, rng: np.random.Generator) -> Any:
    """Return parameters over six decades, the corners where something is 0 among them."""
    default = get_scene(scene).parameters()
    numbers = {k: v for k, v in default.as_dict().items() if not isinstance(v, str)}
    decades = rng.choice([0.3, 1.0, 3.0])
    values = {k: v * 10 ** rng.uniform(-decades, decades) for k, v in numbers.items()}
    for name, value in numbers.items():
        if name.endswith(("damping", "stiffness", "damping_ratio")) and rng.random() < 0.05:
            try:
                default.replace(**{name: 0 * value})
                values[name] = 0.0
            except MbcheckError:
                pass
    if scene == "hula_hoop":
        values["inertia_ratio"] = rng.choice([0.0, 10 ** rng.uniform(-3, 1)])
    if scene == "rotor_pendulum":
        values["installation_angle"] = rng.choice([0.0, np.pi / 2, rng.uniform(-np.pi, np.pi)])
    if scene == "speed_regulator":
        values["rod_length"] = values["crank_radius"] * (1 + 10 ** rng.uniform(-4, 2))
        reach = values["rod_length"], values["crank_radius"]
        values["spring_rest"] = -reach[0] + reach[1] * rng.uniform(-1.2, 1.2)
        strength = values["stiffness"] * reach[1] ** 2
        values["torque"] = strength * 10 ** rng.uniform(-4, 0.3)
    return default.replace(**values)


def bounded(scene: str, p: Any, about: str, damped: bool = True) -> tuple[list[Mode], list[Any]]:
    """Return the modes, and all eigenvalues that are not zero in many digits."""
    known = get_scene(scene)
    p = known.unforced(p)
    state = known.state(known.equilibria[about](p))
    steady = [known.coordinates.index(k) for k in known.steady_coordinates.get(about, ())]
    matrices = Linear(*linearise(known, p, state))
    errors = linearisation_error(known, p, state)
    if not damped:
        matrices, errors = (item._replace(damping=0 * item.damping) for item in (matrices, errors))
    where = (float(state[0]),) if scene == "speed_regulator" else ()
    with mp.workdps(exact_modes.DIGITS):
        truth = exact_modes.eigenvalues(getattr(exact_modes, scene)(p, about, *where), damped)
    return bounded_modes(matrices, errors, steady), truth


def shares(modes: list[Mode], truth: list[Any]) -> Iterator[tuple[float, float]]:
    """Yield error over bound of each mode that is not zero, and bound over omega."""
    left = list(truth)
    for mode in modes:
        if mode.omega == 0:
            assert mode.error_bound == 0
            continue
        value = mp.mpc(mode.re, mode.im)
        assert left, "more modes than there are"
        nearest = min(left, key=lambda root: abs(root - value))
        left.remove(nearest)
        if mode.im:  # a pair is one mode
            left.remove(min(left, key=lambda root: abs(root - mp.conj(value))))
        if mode.error_bound is None:
            continue
        error = abs(nearest - value)
        assert error <= mode.error_bound, (mode, nearest)
        if mode.damping_ratio is not None:
            off = abs(-nearest.real / abs(nearest) - mp.mpf(mode.damping_ratio))
            assert off <= mode.damping_ratio_bound, (mode, nearest)
        yield float(error / mode.error_bound), mode.error_bound / mode.omega
    assert not left, "fewer modes than there are"


def survey(scene: str, count: int, seed: int) -> tuple[np.ndarray, int]:
    """Return (error over bound, bound over omega) of drawn modes, and how many have no bound."""
    rng = np.random.default_rng(seed)
    rows: list[tuple[float, float]] = []
    unknown = drawn_points = 0
    while drawn_points < count:
        try:
            p = drawn(scene, rng)
            about = str(rng.choice(list(get_scene(scene).equilibria)))
            modes, truth = bounded(scene, p, about, bool(rng.random() < 0.7))
        except (NoOrbitError, MbcheckError):
            continue
        drawn_points += 1
        rows += shares(modes, truth)
        unknown += sum(mode.error_bound is None for mode in modes)
    return np.array(rows), unknown


SCENES = ("hula_hoop", "rotor_pendulum", "speed_regulator")


@pytest.mark.parametrize(
    ("scene", "count"),
    [(scene, FEW) for scene in SCENES]
    + [pytest.param(scene, DRAWS, marks=pytest.mark.slow) for scene in SCENES],
)
def test_drawn_modes_keep_their_bounds(scene: str, count: int) -> None:
    rows, unknown = survey(scene, count, seed=count)
    assert unknown <= count / 20
    error, bound = rows.T
    print(
        scene,
        count,
        error.max(),
        np.median(1 / error[error > 0]),
        np.median(bound),
        bound.max(),
        unknown,
    )
