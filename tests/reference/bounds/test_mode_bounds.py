"""Modes keep the bounds that they state, against characteristic polynomials in many digits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from mbcheck.reference import get_scene
from mbcheck.reference.bounds.modes import Entries, bounded_modes, linearisation_error
from mbcheck.reference.errors import MbcheckError, NoOrbitError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.linear import Mode, linearise, modes
from mbcheck.reference.rotor_pendulum.equations import RotorPendulum
from mbcheck.tests.support.exact import modes as exact_modes

DRAWS = 500
FEW = 10

MEDIAN = 35.0
"""Largest median of bound over error."""


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
    matrices = Entries(*linearise(known, p, state))
    errors = linearisation_error(known, p, state)
    if not damped:
        matrices, errors = (item._replace(damping=0 * item.damping) for item in (matrices, errors))
    where = (float(state[0]),) if scene == "speed_regulator" else ()
    with mp.workdps(exact_modes.DIGITS):
        truth = exact_modes.eigenvalues(getattr(exact_modes, scene)(p, about, *where), damped)
    return bounded_modes(matrices, errors, steady), truth


SCENES = ("hula_hoop", "rotor_pendulum", "speed_regulator")
"""Those with characteristic polynomials in `support.exact`: a beam has tests of its own, and for
rigid_body none is written yet."""


def shares(found: list[Mode], truth: list[Any]) -> Iterator[tuple[float, float]]:
    """Yield error over bound of each mode that is not zero, and bound over omega."""
    left = list(truth)
    for mode in found:
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


@pytest.mark.parametrize(
    ("scene", "count"),
    [(scene, FEW) for scene in SCENES]
    + [pytest.param(scene, DRAWS, marks=pytest.mark.campaign) for scene in SCENES],
)
def test_drawn_modes_keep_their_bounds(scene: str, count: int) -> None:
    rng, unknown, left = np.random.default_rng(count), 0, count
    rows: list[tuple[float, float]] = []
    while left:
        try:
            p = drawn(scene, rng)
            about = str(rng.choice(list(get_scene(scene).equilibria)))
            of_scene, truth = bounded(scene, p, about, bool(rng.random() < 0.7))
        except (NoOrbitError, MbcheckError):
            continue
        left -= 1
        rows += shares(of_scene, truth)
        unknown += sum(mode.error_bound is None for mode in of_scene)
    error, bound = np.array(rows).T
    assert np.max(error) <= 1
    assert unknown == 0
    print(
        f"{scene}: {len(error)} modes, largest error/bound {error.max():.2g}, median of "
        f"bound/error {np.median(1 / error[error > 0]):.3g}, bound/omega {np.median(bound):.2g}"
    )
    if count == DRAWS:
        assert 1 / np.median(error) < MEDIAN


@pytest.mark.parametrize("ratio", [1e9, 1e21, 1e33])
def test_a_slow_mode_beside_a_fast_one_keeps_its_digits(ratio: float) -> None:
    """3 rad/s beside 1.4e6, 1.4e12 and 1.4e18 rad/s; `modes` called the slow one a zero mode."""
    p = RotorPendulum(platform_stiffness=1000.0, rod_stiffness=2e3 * ratio)
    for damped in (False, True):
        found, truth = bounded("rotor_pendulum", p, "synchronous", damped)
        assert len(list(shares(found, truth))) == (3 if damped else 2)
        for mode in found[2:]:
            assert mode.error_bound is not None
            assert mode.error_bound < 1e-14 * mode.omega
    slow, fast = bounded("rotor_pendulum", p, "synchronous", False)[0][2:]
    assert slow.omega == pytest.approx(2.96, rel=1e-2)
    assert fast.omega == pytest.approx(1.38e6 * np.sqrt(ratio / 1e9), rel=1e-2)


@pytest.mark.parametrize("near", [0.0, 1e-15, -1e-12, 1e-8, -1e-4])
def test_two_decays_that_meet(near: float) -> None:
    p = HulaHoop(damping_ratio=1 + near)
    found, truth = bounded("hula_hoop", p, "rod_aligned")
    for mode in found[2:]:
        error = min(abs(root - mp.mpc(mode.re, mode.im)) for root in truth)
        assert mode.error_bound is not None
        assert error <= mode.error_bound < 1e-6 * mode.omega


def test_frequencies_that_overflow_are_an_error() -> None:
    """A stiffness of 1e308 came out as a frequency of 6e-275 rad/s."""
    mass, zero = np.eye(2), np.zeros((2, 2))
    huge = np.full((2, 2), 1e308) + np.diag([5e307, 5e307])
    with pytest.raises(MbcheckError, match="exceed what floating-point numbers hold"):
        modes(1e-5 * mass, zero, huge)
    with pytest.raises(MbcheckError, match="exceed what floating-point numbers hold"):
        modes(mass, zero, huge)
    with pytest.raises(MbcheckError, match="exceed what floating-point numbers hold"):
        bounded_modes(Entries(1e-5 * mass, zero, huge), Entries(zero, zero, zero))
    endless = np.diag([np.inf, np.inf])
    for way in (
        modes,
        lambda *of: bounded_modes(Entries(*of), Entries(zero, zero, zero)),
    ):
        with pytest.raises(MbcheckError, match="not finite"):
            way(mass, zero, endless)


def test_a_stiffness_near_the_largest_number_is_no_overflow() -> None:
    p = RotorPendulum(rod_stiffness=1e308)
    found, truth = bounded("rotor_pendulum", p, "synchronous")
    assert len(list(shares(found, truth))) == 2
    assert found[-1].omega == pytest.approx(9.75e153, rel=1e-3)
