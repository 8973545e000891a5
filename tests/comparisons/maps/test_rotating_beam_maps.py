"""Maps of rotating_beam: frequencies and stability against theory, other routes, and faults."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.maps.request import Axis, Request, resolved
from mbcheck.comparisons.maps.run import compute
from mbcheck.comparisons.scenes.quantity import NO_VALUE, Points, QuantityValues
from mbcheck.comparisons.scenes.rotating_beam import maps
from mbcheck.reference.rotating_beam import SCENE, critical_speed
from mbcheck.reference.rotating_beam.frequencies.numbers import numbers, time_unit
from mbcheck.reference.rotating_beam.frequencies.stretching import frequencies
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.tests.support.chain import chain_frequencies
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.exact.shooting import shooting

UNIT = time_unit(RotatingBeam())


def evaluated(
    quantity: str,
    values: Mapping[str, Any],
    engine: str = "reference",
    model: str = "",
    **changes: Any,
) -> tuple[QuantityValues, Points]:
    """Return a quantity at points (k,) given by parameters or names of axes."""
    p = RotatingBeam().replace(**changes)
    arrays = {name: np.asarray(value, float) for name, value in values.items()}
    for name, value in arrays.items():
        p = maps.AXES[name].apply(p, value) if name in maps.AXES else p.replace(**{name: value})
    count = len(next(iter(arrays.values())))
    places = np.stack([np.arange(count), np.zeros(count, int)], axis=1)
    points = Points(SCENE, p, places, arrays, engine, model)
    return maps.QUANTITIES[quantity].evaluate(points), points


# Frequencies --------------------------------------------------------------------------------


def test_frequencies_are_those_of_the_other_route() -> None:
    found, points = evaluated(
        "frequency",
        {"nondimensional_speed": [0.0, 9.0], "mass_ratio": [0.3, 0.8]},
        hub_radius=8.0,
        mass_position=0.4,
    )
    assert not found.problems
    for i in range(len(points)):
        n = numbers(points.one(i))
        assert n == pytest.approx((1.0, [0.0, 9.0][i], [0.3, 0.8][i], 0.4, 0.0))
        omega, _ = shooting(n, count=1)
        assert abs(found.values["nondimensional_1"][i] - omega[0]) < 1e-10 * omega[0]
        assert abs(found.values["frequency_1"][i] * UNIT - omega[0]) < 1e-10 * omega[0]
        assert 0 < found.values["bound_1"][i] < 1e-9
        square = found.values["frequency_1"][i] ** 2 + points.one(i).angular_speed ** 2
        assert found.values["flapwise_1"][i] == pytest.approx(np.sqrt(square), rel=1e-9)
    ascending = [found.values[f"frequency_{i}"] for i in (1, 2, 3)]
    assert np.all(np.diff(ascending, axis=0) > 0)


def test_frequency_models_differ_as_they_should() -> None:
    speeds = [0.0, 2.0, 10.0]
    of = {
        name: evaluated("frequency", {"angular_speed": speeds}, model=name, hub_radius=8.0)[0]
        for name in maps.FREQUENCY
    }
    exact, soft, paper, zero = (of[name].values["frequency_1"] for name in maps.FREQUENCY)
    np.testing.assert_allclose([soft[0], paper[0], zero[0]], exact[0], rtol=1e-9)
    assert np.all(soft[1:] < exact[1:])
    assert np.all(paper[1:] > exact[1:])
    assert zero[1] == pytest.approx(np.sqrt(exact[0] ** 2 - 4))
    assert np.isnan(zero[2])
    assert np.all(np.isnan(of["paper"].values["frequency_3"]))
    assert not of["zero_order"].problems


def test_engines_show_their_own_systems() -> None:
    values = {"angular_speed": [0.0, 7.0], "mass_ratio": [0.25, 0.25]}
    more: dict[str, Any] = {"segments": 8, "hub_radius": 8.0, "mass_position": 0.5}
    chain, points = evaluated("frequency", values, "mujoco", **more)
    elements, _ = evaluated("frequency", values, "exudyn", **more)
    for i in range(len(points)):
        p = points.one(i)
        own = [chain.values[f"frequency_{j}"][i] for j in (1, 2)]
        np.testing.assert_allclose(own, chain_frequencies(p), rtol=1e-8)
        truth = frequencies(p, continuum="extensible").omega
        own = [elements.values[f"frequency_{j}"][i] for j in (1, 2)]
        np.testing.assert_allclose(own, truth, rtol=2e-3)
        shown = mbcheck.frequencies(
            "rotating_beam", parameters=p.as_dict(), engine="exudyn", count=1
        ).modes
        assert elements.values["frequency_1"][i] == shown[0].omega
    assert np.all(np.isnan(chain.values["flapwise_1"]))
    assert np.all(np.isnan(chain.values["bound_1"]))


def test_a_point_that_fails_does_not_stop_the_map() -> None:
    """This beam is torn apart at the second speed: no steady shape exists."""
    values = {"angular_speed": [1.0, 40.0]}
    soft: dict[str, Any] = {"youngs_modulus": 1e8, "segments": 4}
    for engine, model in (("exudyn", ""), ("reference", "extensible")):
        found, _ = evaluated("frequency", values, engine, model, **soft)
        assert list(found.problems) == [1], engine
        assert np.isfinite(found.values["frequency_1"][0])
        assert np.all(np.isnan([found.values[name][1] for name in found.values]))
    found, _ = evaluated("stability", values, "exudyn", **soft)
    assert found.values["stable"].tolist() == [1, NO_VALUE]
    assert found.values["robust"][1] == 0


def test_a_map_without_any_value_is_no_success(tmp_path: Path) -> None:
    words = ("--x angular_speed=1:2:2 --y length=5:6:2", "--quantity stability")
    line = f"map rotating_beam {' '.join(words)} -o {tmp_path / 'map.nc'}"
    result = invoke(f"{line} --set gravity_y=-9")
    assert result.exit_code == 1
    assert "no value at 4 points" in result.stdout
    assert (tmp_path / "map.nc").exists()


def test_drive_and_ramp_do_not_matter() -> None:
    values = {"angular_speed": [3.0]}
    one, _ = evaluated("frequency", values)
    other, _ = evaluated("frequency", values, drive="torque", ramp_time=0.0)
    assert one.values["frequency_1"] == other.values["frequency_1"]
    steady, _ = evaluated("stability", values, model="zero_order", drive="torque")
    assert steady.values["stable"].tolist() == [0]


# Stability ----------------------------------------------------------------------------------


def test_zero_order_is_lost_at_the_frequency_at_rest() -> None:
    """The truth is of the continuum at rest, found by polynomials; the map's has 8 shapes."""
    cases = [(m, a, d) for m in (0.0, 1.0) for a in (0.0, 8.0) for d in (0.5, 1.0)]
    for mass, radius, place in cases:
        beam = RotatingBeam(mass=mass, hub_radius=radius, mass_position=place, angular_speed=0.0)
        limit = frequencies(beam, count=1).omega[0]
        found, _ = evaluated(
            "stability",
            {"angular_speed": limit * np.array([0.5, 0.999, 1.00003, 1.001, 3.0])},
            model="zero_order",
            mass=mass,
            hub_radius=radius,
            mass_position=place,
        )
        assert found.values["stable"].tolist() == [1, 1, 0, 0, 0]
        assert found.values["robust"].tolist() == [1, 1, 0, 1, 1]
        rates = found.values["growth_rate"]
        assert rates[-1] == pytest.approx(np.sqrt(8) * limit, rel=1e-3)
    assert critical_speed(beam) == pytest.approx(limit, rel=1e-6)


def test_no_other_model_and_no_engine_loses_stability() -> None:
    values = {"angular_speed": [0.0, 4.0, 20.0]}
    more: dict[str, Any] = {"mass": 0.8, "segments": 4}
    for model in ("exact", "extensible", "second_order"):
        found, _ = evaluated("stability", values, model=model, **more)
        assert found.values["stable"].tolist() == [1, 1, 1], model
        assert found.values["robust"].tolist() == [1, 1, 1]
    for engine in ("mujoco", "exudyn"):
        found, _ = evaluated("stability", values, engine, **more)
        assert found.values["stable"].tolist() == [1, 1, 1], engine
        assert found.values["growth_rate"].tolist() == [0, 0, 0]


def test_an_engine_without_foreshortening_is_found_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its stiffness is that at rest, less what the speed takes."""
    from mbcheck.comparisons.engines.adapter import BoundModel

    true = BoundModel.linearise

    def linearise(self: Any, state: Any) -> Any:
        speed = state[len(state) // 2]
        mass, damping, stiffness = true(self, 0 * state)
        return mass, damping, stiffness - speed**2 * mass

    monkeypatch.setattr(BoundModel, "linearise", linearise)
    found, _ = evaluated("stability", {"angular_speed": [2.0, 4.0]}, "mujoco", segments=4)
    assert found.values["stable"].tolist() == [1, 0]


# As maps ------------------------------------------------------------------------------------


def test_a_map_has_these_values() -> None:
    asked = resolved(
        Request(
            "rotating_beam",
            "frequency",
            Axis("mass_position", 0.25, 1.0, 4),
            Axis("mass_ratio", 0.0, 0.5, 2),
            parameters={"hub_radius": 8.0, "angular_speed": 7.0},
        )
    )
    found = compute(asked)
    alone, _ = evaluated(
        "frequency",
        {"mass_position": [0.75], "mass_ratio": [0.5]},
        hub_radius=8.0,
        angular_speed=7.0,
    )
    assert found.variables["frequency_1"][1, 2] == alone.values["frequency_1"][0]
    assert found.problems == ()
    assert np.ptp(found.variables["frequency_1"][0]) < 1e-12  # no mass: no place
