"""The maps of hula_hoop against single orbits, single runs, and motions known by heart."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.scenes.hula_hoop import motion as motion_module
from mbcheck.comparisons.scenes.hula_hoop.floquet import (
    FLOQUET_VARIABLES,
    SOLUTIONS,
    STABILITY,
    ZONES,
    floquet,
    least,
)
from mbcheck.comparisons.scenes.hula_hoop.motion import (
    LABELS,
    MOTION_VARIABLES,
    MOTIONS,
    OPTIONS,
    described,
    motion,
)
from mbcheck.comparisons.scenes.hula_hoop.steps import fastest_rate
from mbcheck.comparisons.scenes.quantity import NO_VALUE, Points, QuantityValues
from mbcheck.reference import get_scene
from mbcheck.reference.hula_hoop.equations import SEMICIRCLE, HulaHoop
from mbcheck.reference.hula_hoop.floquet import floquet_multipliers
from mbcheck.reference.hula_hoop.theory import corrected_solution, paper_solution
from mbcheck.reference.orbits import find_orbit, shoot

SCENE = get_scene("hula_hoop")
STABLE, UNSTABLE, NONE = range(3)


def points(
    frequency: Any, amplitude: Any, engine: str = "reference", model: Any = "exact", **more: Any
) -> Points:
    """Points in a row of the map, or on a grid if both have two axes."""
    frequency, amplitude = np.broadcast_arrays(
        np.asarray(frequency, float), np.asarray(amplitude, float)
    )
    row, column = np.indices(np.atleast_2d(frequency).shape)
    method, step = more.pop("method", None), more.pop("step", None)
    parameters = SCENE.parameters().replace(
        force_frequency=frequency.ravel(), force_amplitude=amplitude.ravel(), **more
    )
    places = np.stack([column.ravel(), row.ravel()], axis=1)
    return Points(SCENE, parameters, places, {}, engine, model, method, step)


def names(found: QuantityValues, variable: str, classes: tuple[str, ...]) -> list[str]:
    return [classes[i] for i in found.values[variable]]


# Stability of the rotation


@pytest.mark.parametrize(
    ("frequency", "amplitude", "inertia"),
    [
        (3.0, 60.0, 0.0),
        pytest.param(3.6129, 61.129, 0.0, marks=pytest.mark.slow),
        (9.0, 40.0, SEMICIRCLE),
    ],
)
def test_floquet_is_that_of_the_single_orbit(
    frequency: float, amplitude: float, inertia: float
) -> None:
    found = floquet(points([frequency], [amplitude], inertia_ratio=inertia))
    orbit = mbcheck.orbit(
        "hula_hoop",
        parameters=dict(
            force_frequency=frequency, force_amplitude=amplitude, inertia_ratio=inertia
        ),
    )
    leading = orbit.floquet_multipliers[0].modulus
    assert found.values["multiplier"][0] == pytest.approx(leading, abs=1e-8)
    assert (found.values["stability"][0] == STABLE) == orbit.stable
    u_1 = next(term.amplitude for term in orbit.harmonics["theta"].terms if term.order == 2)
    assert found.values["u_1"][0] == pytest.approx(u_1, abs=1e-7)
    assert found.values["robust"][0] == 1


def test_floquet_of_an_unstable_rotation() -> None:
    known = points([10.0, 7.3871], [5.0, 28.387])
    found = floquet(known)
    guess = SCENE.orbit.guesses(known.parameters)[0]
    truth = np.abs(shoot(SCENE, known.parameters, guess, steps=128).multipliers[0])
    assert np.all(truth > 1)
    np.testing.assert_allclose(found.values["multiplier"], truth, rtol=1e-7)
    assert names(found, "stability", STABILITY) == ["unstable", "unstable"]


def test_no_rotation_where_the_force_is_too_weak() -> None:
    """The friction of the hinge takes more than 0.3 N can give, whatever the neighbour has."""
    found = floquet(points([3.0, 3.0], [0.3, 60.0]))
    assert names(found, "stability", STABILITY) == ["no_rotation", "stable"]
    assert np.isnan(found.values["multiplier"][0])
    assert names(found, "zone", ZONES) == ["no_rotation", "blue_o"]


MISSED = {  # frequency [Hz], force [N], inertia ratio: a stable rotation that guesses do not give
    "over half a period alone": (2.8, 77.5, 0.0),
    "a twin at 5.5 Hz": (5.5, 92.0, SEMICIRCLE),
    "a twin at 8.2 Hz": (8.2, 92.0, SEMICIRCLE),
    "close to 1": (3.7, 145.17, SEMICIRCLE),
    "swings by more than its mean": (6.925, 120.0, 0.0),
    "the same, from another start": (7.6, 150.0, 0.0),
    "a twin just parted": (3.142857142857143, 78.65079365079364, 0.0),
    "a twin far from any": (5.714285714285714, 101.66666666666667, 0.0),
    "swings at the frequency of the force": (7.072072072072072, 51.591591591591595, 0.0),
    "the same, at a strong force": (6.54954954954955, 148.40340340340342, 0.0),
}


def test_each_point_alone_finds_its_stable_rotation() -> None:
    frequency, amplitude, inertia = np.array(list(MISSED.values())).T
    block = points(frequency, amplitude, inertia_ratio=inertia)
    far = replace(block, places=10 * block.places)  # so that none is another's neighbour
    found = floquet(far)
    for i, name in enumerate(MISSED):
        assert found.values["stability"][i] == STABLE, name
        assert found.values["robust"][i] == 1, name


@pytest.mark.parametrize(
    "every", [pytest.param(11, marks=pytest.mark.slow), pytest.param(1, marks=pytest.mark.campaign)]
)
@pytest.mark.parametrize("inertia", [0.0, SEMICIRCLE])
def test_a_block_has_what_each_point_has_alone(inertia: float, every: int) -> None:
    """Of all points of the campaign one in 200 may differ, of every eleventh none."""
    axes = np.linspace(1, 10, 16), np.linspace(5, 150, 16)
    block = points(*np.meshgrid(*axes), inertia_ratio=inertia)
    together = floquet(block).values
    alone = [
        floquet(points([f], [a], inertia_ratio=inertia)).values
        for f, a in zip(
            block.parameters.force_frequency[::every],
            block.parameters.force_amplitude[::every],
            strict=True,
        )
    ]
    for name in ("stability", "zone"):
        same = together[name][::every] == np.concatenate([v[name] for v in alone])
        assert np.mean(same) >= 0.995


@pytest.mark.parametrize("model", ["paper", "refined", "corrected"])
def test_floquet_of_approximate_rotations(model: str) -> None:
    block = points([3.0, 9.0, 3.0], [20.0, 40.0, 100.0], model=model)
    found = floquet(block)
    assert set(found.values) == set(FLOQUET_VARIABLES)
    for i in range(3):
        solution = SOLUTIONS[model](block.one(i))
        leading = abs(floquet_multipliers(solution, block.one(i))[0])
        assert found.values["multiplier"][i] == pytest.approx(leading, rel=1e-7)
        assert found.values["u_1"][i] == pytest.approx(abs(solution.u_1), rel=1e-12)


def test_zones_of_fig_4() -> None:
    """At 7 Hz, 150 N the paper's |u_1| is 1.9; at 3 Hz it stays below a half."""
    found = floquet(points([3.0, 7.0, 3.0], [20.0, 150.0, 100.0], model="paper"))
    assert names(found, "zone", ZONES) == ["blue_o", "black_o", "red_o"]
    solution = paper_solution(HulaHoop(force_frequency=7.0, force_amplitude=150.0))
    assert abs(solution.u_1) > 0.5
    assert found.values["min_speed"][1] == pytest.approx(1 - 2 * abs(solution.u_1))


def test_min_speed_of_an_approximate_rotation_is_that_of_its_motion() -> None:
    block = points([4.0], [50.0], model="corrected")
    solution = corrected_solution(block.one(0))
    tau = np.linspace(0, 2 * np.pi / solution.alpha, 20001)
    least = np.min(solution.motion(tau).theta_dot) / solution.alpha
    assert floquet(block).values["min_speed"][0] == pytest.approx(least, abs=1e-6)


def test_search_ends_where_nothing_turns() -> None:
    found = floquet(points([3.0, 4.0], [0.0, 0.0]))
    assert names(found, "stability", STABILITY) == ["no_rotation"] * 2


def test_undamped_resonance_is_no_crash() -> None:
    omega_n = float(HulaHoop().omega_n) / (2 * np.pi)
    rate = fastest_rate(points([omega_n], [60.0], damping_ratio=0.0).parameters)
    assert np.all(np.isfinite(rate))


# Motion from rest


def window(theta: Any, y: Any, sign: int = 1) -> dict[str, Any]:
    """What `described` makes of theta(s) and y(s), s in periods of a 1 rad/s force."""
    count = OPTIONS.window * OPTIONS.samples
    phase = 2 * np.pi * np.arange(count + 1) / OPTIONS.samples
    step = 1e-5
    rows = [
        y(phase),
        sign * theta(phase),
        (y(phase + step) - y(phase - step)) / (2 * step),
        sign * (theta(phase + step) - theta(phase - step)) / (2 * step),
    ]
    return described(np.array(rows)[:, None], np.ones(1))


KNOWN = {
    "turning": (lambda s: s + 0.1 * np.cos(2 * s), "blue_o", "rotator", 1),
    "turning and reversing": (lambda s: s + 0.6 * np.cos(2 * s), "blue_plus", "rotator", 1),
    "turning, another frequency": (lambda s: s + 0.1 * np.cos(s), "cyan_o", "rotator", 1),
    "turning, thrice the period": (lambda s: s + 1.8 * np.cos(s / 3), "cyan_o", "rotator", 3),
    "reversing, another frequency": (lambda s: s + 1.2 * np.cos(s), "cyan_plus", "rotator", 1),
    "at rest": (lambda s: np.pi / 2 + 0 * s, "red_x", "rest", 1),
    "librating": (lambda s: np.pi / 2 + np.cos(s), "red_x", "libration", 1),
    "librating, twice the period": (lambda s: np.cos(s / 2), "red_x", "libration", 2),
    "half a turn per period": (lambda s: s / 2 + 0.1 * np.cos(s), "red_x", "other_lock", 2),
    "twice a turn per period": (lambda s: 2 * s + 0.1 * np.cos(s), "red_x", "other_lock", 1),
    "slipping": (lambda s: s * (1 - 0.02) + 0.1 * np.cos(s), "red_x", "not_periodic", 0),
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("sign", [1, -1])
def test_motions_known_by_heart(name: str, sign: int) -> None:
    theta, motion, label, periods = KNOWN[name]
    found = window(theta, np.sin, sign)
    assert MOTIONS[found["motion"][0]] == motion
    assert LABELS[found["label"][0]] == label
    assert found["periods"][0] == periods


def test_one_slip_in_the_window_is_no_rotation() -> None:
    found = window(lambda s: s - np.pi * (1 + np.tanh(s - 300)), np.sin)
    assert MOTIONS[found["motion"][0]] == "red_x"


def test_frequency_and_least_speed() -> None:
    found = window(lambda s: s + 0.3 * np.cos(2 * s + 0.7), np.sin)
    assert found["f_u"][0] == pytest.approx(2)
    assert found["turns"][0] == pytest.approx(1)
    assert found["min_speed"][0] == pytest.approx(1 - 0.6, abs=1e-3)


def test_a_lost_motion_has_no_class() -> None:
    found = window(lambda s: np.where(s > 100, np.nan, s), np.sin)
    assert found["motion"][0] == found["label"][0] == NO_VALUE
    assert np.isnan(found["turns"][0])


@pytest.fixture(scope="module")
def from_rest() -> QuantityValues:
    return motion(points([3.0, 9.0, 4.0], [60.0, 40.0, 5.0]))


def test_a_rotator_from_rest_soon() -> None:
    """More friction and a shorter window, so that this takes little time."""
    found = motion(points([9.0, 4.0], [40.0, 5.0], hinge_damping_ratio=0.1), window=40)
    assert names(found, "motion", MOTIONS) == ["blue_o", "red_x"]
    assert found.values["robust"].tolist() == [1, 1]
    rotation = floquet(points([9.0], [40.0], hinge_damping_ratio=0.1))
    least = rotation.values["min_speed"][0]
    assert found.values["min_speed"][0] == pytest.approx(least, abs=2e-3)


@pytest.mark.slow
def test_what_comes_of_rest(from_rest: QuantityValues) -> None:
    """Section 5.1 has the first; 5 N only pulls the rod into line."""
    assert names(from_rest, "motion", MOTIONS) == ["blue_o", "blue_o", "red_x"]
    assert names(from_rest, "label", LABELS) == ["rotator", "rotator", "rest"]
    assert from_rest.values["robust"].tolist() == [1, 1, 1]
    assert set(from_rest.values) == set(MOTION_VARIABLES)


@pytest.mark.parametrize("decay", [0.0, 0.02, 1.0])
def test_the_least_speed_is_bounded_between_samples_and_after_the_transient(decay: float) -> None:
    """Of sums of harmonics that come again after a period or two; the transient dies, or lasts."""

    def speed(phase: Any) -> Any:
        return np.array([
            1 + 0.8 * np.cos(phase) + 0.3 * np.cos(2 * phase + 0.3),
            1 + 0.8 * np.cos(phase) + 0.01 * np.cos(phase / 2),
        ])  # fmt: skip

    phase = 2 * np.pi * np.arange(24 * 80 + 1) / 24
    samples = speed(phase) + decay * 0.01 * np.exp(-decay * phase / 20)
    truth = least(speed(np.linspace(0, 4 * np.pi, 10_001)))
    lowest = least(samples)
    off = motion_module.unsettled(samples, np.array([1.0, 2.0]), 24, lowest)
    assert np.all(np.abs(lowest - truth) <= off)
    assert np.all(off < 2e-3)
    grows = samples + 1e-3 * np.exp(phase / 300)
    assert np.all(np.isnan(motion_module.unsettled(grows, np.array([1.0, 0.0]), 24, lowest)))


def test_what_the_check_leads_elsewhere_is_not_robust(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check starts off and takes twice the step; motion or label may differ by it."""
    asked = []

    def ends(flow: Any, starts: Any, per_period: float, window: int) -> list[dict[str, Any]]:
        asked.extend(starts)
        return [variables(int(coarser > 1)) for _, coarser in starts]

    def variables(other: int) -> dict[str, Any]:
        names = "turns", "f_u", "min_speed", "periods", "turns_off", "min_speed_off"
        numbers = dict.fromkeys(names, np.ones(3))
        classes = {"motion": np.array([0, other, 4]), "label": np.array([0, 0, 2 + other])}
        return {**numbers, **classes}

    monkeypatch.setattr(motion_module, "runs_from_rest", ends)
    found = motion(points([3.0, 4.0, 5.0], [60.0, 60.0, 60.0]))
    assert found.values["robust"].tolist() == [1, 0, 0]
    assert found.values["motion"].tolist() == [0, 0, 4]
    assert np.isfinite(found.values["turns_bound"]).tolist() == [True, False, False]
    assert asked == [(0.0, 1), (OPTIONS.off, 2)]


def test_an_approximate_motion_turns_where_it_is_stable() -> None:
    found = motion(points([3.0, 3.0, 1.0], [20.0, 100.0, 5.0], model="paper"))
    assert names(found, "motion", MOTIONS) == ["blue_o", "red_x", "blue_o"]
    assert names(found, "label", LABELS) == ["rotator", "unstable_rotation", "rotator"]


# Engines


@pytest.mark.parametrize("engine", [pytest.param("exudyn", marks=pytest.mark.slow), "mujoco"])
def test_floquet_of_an_engine(engine: str) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    true = floquet(points([3.0, 5.5], [60.0, 40.0]))
    own = floquet(points([3.0, 5.5], [60.0, 40.0], engine, None))
    assert own.values["stability"].tolist() == [STABLE, UNSTABLE]
    np.testing.assert_allclose(own.values["multiplier"], true.values["multiplier"], rtol=1e-4)
    assert not own.problems


@pytest.mark.slow
def test_floquet_of_an_engine_is_its_own() -> None:
    """Euler's method with 100 steps per period has another map; `mbcheck orbit` finds the same."""
    pytest.importorskip("mujoco", exc_type=ImportError)
    step = 1 / 3 / 96
    own = floquet(points([3.0], [60.0], "mujoco", None, method="Euler", step=step))
    parameters = dict(force_frequency=3.0, force_amplitude=60.0)
    single = mbcheck.orbit(
        "hula_hoop", parameters=parameters, engine="mujoco", method="Euler", step=step
    )
    leading = single.floquet_multipliers[0].modulus
    assert own.values["multiplier"][0] == pytest.approx(leading, abs=1e-6)
    true = floquet(points([3.0], [60.0]))
    assert abs(leading - true.values["multiplier"][0]) > 1e-4


def test_an_engine_that_fails_leaves_no_value() -> None:
    """Steps far beyond an explicit method's stability: the run overflows at one point alone."""
    pytest.importorskip("mujoco", exc_type=ImportError)
    block = points([3.0, 3.0], [60.0, 0.0], "mujoco", None, method="Euler", step=1.0)
    block = replace(block, parameters=block.parameters.replace(damping_ratio=np.array([50.0, 0.1])))
    found = motion(block)
    assert found.problems
    for i in found.problems:
        assert (found.values["motion"][i], found.values["robust"][i]) == (NO_VALUE, 0)
        assert np.isnan(found.values["turns"][i])


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["exudyn", "mujoco"])
def test_motion_of_an_engine(engine: str, from_rest: QuantityValues) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    own = motion(points([3.0, 9.0, 4.0], [60.0, 40.0, 5.0], engine, None))
    for name in ("motion", "label"):
        np.testing.assert_array_equal(own.values[name], from_rest.values[name][:3])


@pytest.mark.parametrize(
    "count", [pytest.param(2, marks=pytest.mark.slow), pytest.param(5, marks=pytest.mark.campaign)]
)
def test_no_stable_rotation_is_missed(count: int) -> None:
    """`find_orbit` tries far more starts; where it finds a stable one, the map has one."""
    frequency, amplitude = np.meshgrid(np.linspace(2, 9, count), np.linspace(10, 140, count))
    block = points(frequency, amplitude)
    found = floquet(block)
    for i in range(len(block)):
        try:
            stable = find_orbit(SCENE, block.one(i)).stable
        except Exception:
            stable = False
        assert (found.values["stability"][i] == STABLE) >= stable, block.one(i)
