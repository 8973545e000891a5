"""`simulate`: trajectories of the reference and of engines, and their steps."""

import json
import math
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.queries.simulate import Simulation
from mbcheck.reference.errors import UsageError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.tests.support.command import invoke, succeeds
from mbcheck.tests.support.documents import validated

TIMES = [0.0, 0.1, 0.25, 1 / 3]

POINT = HulaHoop()


@pytest.fixture(scope="module")
def truth() -> Simulation:
    return mbcheck.simulate("hula_hoop", times=TIMES)


def test_reference_states_its_error(truth: Simulation) -> None:
    document = validated("simulate", truth.as_json())
    assert document["step"] is None
    assert document["times"] == TIMES
    assert document["parameters"] == POINT.as_dict()
    assert set(document["error_bound"]) == {"y", "theta", "y_dot", "theta_dot"}
    assert all(0 < bound < 1e-7 for bound in document["error_bound"].values())


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [
        ({"engine": "mujoco"}, 1e-4),
        ({"engine": "exudyn"}, 1e-5),
        ({"engine": "exudyn", "model": "redundant"}, 1e-1),
    ],
)
def test_engine_meets_the_reference(
    truth: Simulation, options: dict[str, Any], tolerance: float
) -> None:
    found = mbcheck.simulate("hula_hoop", times=TIMES, **options)
    document = validated("simulate", found.as_json())
    assert document["error_bound"] is None
    assert document["work"]["steps"] == round(TIMES[-1] / document["step"])
    assert document["versions"][options["engine"]] == get_engine(options["engine"]).version
    for name, values in truth.observables.items():
        np.testing.assert_allclose(found.observables[name], values, rtol=0, atol=tolerance)


def test_simulation_repeats_from_its_document() -> None:
    first = mbcheck.simulate(
        "hula_hoop",
        engine="mujoco",
        times=TIMES,
        parameters={"rod_length": 0.06},
        state={"theta": 0.3},
    )
    again = mbcheck.simulate(
        first.scene,
        engine=first.engine,
        method=first.method,
        step=first.step,
        model=first.model,
        parameters=first.parameters,
        state={"theta": 0.3},
        times=first.times,
    )
    assert first.observables["theta"][0] == 0.3
    for name, values in first.observables.items():
        np.testing.assert_array_equal(again.observables[name], values)


@pytest.mark.parametrize(
    ("options", "method"),
    [
        ({"engine": "mujoco"}, "RK4"),
        ({"engine": "exudyn"}, "RK67"),
        ({"engine": "exudyn", "model": "redundant"}, "GeneralizedAlpha"),
        ({"engine": "reference"}, "DOP853"),
    ],
)
def test_default_method(options: dict[str, Any], method: str) -> None:
    assert mbcheck.simulate("hula_hoop", times=[0.01], **options).method == method


def test_times_beside_the_grid_are_refused_with_the_nearest() -> None:
    with pytest.raises(UsageError, match=r"nearest that fit are 0\.0005 and 0\.001"):
        mbcheck.simulate("hula_hoop", engine="mujoco", step=0.0005, times=[0.0007])


def test_a_typed_step_may_round() -> None:
    found = mbcheck.simulate("hula_hoop", engine="mujoco", step=0.0033333333, times=[0.3333333301])
    assert found.times[0] == pytest.approx(0.33333333, abs=1e-12)
    assert found.work["steps"] == 100


# What is lost

UNSTABLE = "simulate hula_hoop --state theta=1.5707963267948966 --times 1,2,9"


def test_what_is_lost_is_not_given_as_numbers() -> None:
    text = succeeds(UNSTABLE)
    assert "lost from t = 9 s" in text
    (row,) = [line for line in text.splitlines() if line.split()[:1] == ["9"]]
    assert row.split()[1:] == ["lost"] * 4
    lines = invoke(f"{UNSTABLE} --csv -")
    assert lines.stdout.splitlines()[-1] == "9.0,,,,"
    assert lines.stderr.startswith("Warning: lost from t = 9 s")


def test_what_is_lost_is_null_in_the_document() -> None:
    document = validated("simulate", json.loads(invoke(f"{UNSTABLE} --json -").stdout))
    assert document["lost_from"] == 9.0
    for name, values in document["observables"].items():
        assert values[2] is None
        assert all(math.isfinite(value) for value in values[:2])
        assert document["error_bound"][name] < 1e-2


def test_a_motion_that_is_lost_at_once_has_no_bound() -> None:
    lost = mbcheck.simulate("hula_hoop", state={"theta": math.pi / 2}, times=[9.0])
    assert lost.lost_from == 9.0
    assert lost.error_bound is None
    assert all(np.isnan(values).all() for values in lost.observables.values())
