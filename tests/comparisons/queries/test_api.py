"""The public functions: their numbers, their documents, and what they refuse."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks import orbits, suite
from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.queries import api
from mbcheck.reference.errors import (
    EngineError,
    EngineUnavailableError,
    NoOrbitError,
    ParameterError,
    UnknownNameError,
    UsageError,
)
from mbcheck.reference.hula_hoop.equations import SCENE, HulaHoop
from mbcheck.reference.orbits import find_orbit, state_scale
from mbcheck.reference.scene import Case
from mbcheck.tests.support.documents import validated

TIMES = [0.0, 0.1, 0.25, 1 / 3]
ENGINES = ("reference", "mujoco", "exudyn")
POINT = HulaHoop()


def test_import_is_cheap(tmp_path: Path) -> None:
    loaded = "import mbcheck, sys; print(sorted({'numpy', 'mujoco', 'exudyn'} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", loaded], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_public_names() -> None:
    assert set(mbcheck.__all__) <= set(dir(mbcheck))
    assert mbcheck.simulate is api.simulate
    assert isinstance(mbcheck.__version__, str)
    with pytest.raises(AttributeError, match="simulat"):
        mbcheck.simulat  # noqa: B018


# simulate


@pytest.fixture(scope="module")
def truth() -> api.Simulation:
    return mbcheck.simulate("hula_hoop", times=TIMES)


def test_reference_states_its_error(truth: api.Simulation) -> None:
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
    truth: api.Simulation, options: dict[str, Any], tolerance: float
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
        "hula_hoop", "mujoco", times=TIMES, parameters={"rod_length": 0.06}, state={"theta": 0.3}
    )
    again = mbcheck.simulate(
        first.scene,
        first.engine,
        first.method,
        first.step,
        first.model,
        first.parameters,
        {"theta": 0.3},
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


@pytest.mark.parametrize(
    ("times", "longest", "step"),
    [
        ([0.5, 1.0], 2**-10, 2**-10),
        ([0.1, 0.25], 2**-10, 0.05 / 52),
        (np.arange(31) * 0.1, 2**-10, 0.1 / 103),
        ([1 / 3, 2 / 3], 2**-10, 1 / 3 / 342),
        ([0.0, 7.3], 0.5, 7.3 / 15),
        ([1e-4], 2**-10, 1e-4),
    ],
)
def test_default_step_fits_the_times(times: Any, longest: float, step: float) -> None:
    times = np.array(times, dtype=float)
    found = api.step_for(times, longest)
    assert found == pytest.approx(step, rel=1e-14)
    np.testing.assert_allclose(times / found, np.rint(times / found), atol=1e-9)


@pytest.mark.parametrize("times", [[0.5, np.pi], [1e-9, 1.0], [1e9]])
def test_times_without_a_grid_are_refused(times: list[float]) -> None:
    with pytest.raises(UsageError, match="choose"):
        api.step_for(np.array(times), 2**-10)


def test_times_beside_the_grid_are_refused_with_the_nearest() -> None:
    with pytest.raises(UsageError, match=r"nearest that fit are 0\.0005 and 0\.001"):
        mbcheck.simulate("hula_hoop", "mujoco", step=0.0005, times=[0.0007])


def test_a_typed_step_may_round() -> None:
    found = mbcheck.simulate("hula_hoop", "mujoco", step=0.0033333333, times=[0.3333333301])
    assert found.times[0] == pytest.approx(0.33333333, abs=1e-12)
    assert found.work["steps"] == 100


Refused = tuple[Callable[[], object], type[Exception], str]

REFUSED: list[Refused] = [
    (lambda: mbcheck.simulate("hula_hop", times=[1]), UnknownNameError, "'hula_hoop'"),
    (lambda: mbcheck.simulate("hula_hoop", "mujco", times=[1]), UnknownNameError, "'mujoco'"),
    (
        lambda: mbcheck.simulate("hula_hoop", "mujoco", "RK5", times=[1]),
        UnknownNameError,
        "'RK4'",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", "exudyn", model="redundnt", times=[1]),
        UnknownNameError,
        "'redundant'",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", "exudyn", "RK44", model="redundant", times=[1]),
        UsageError,
        "GeneralizedAlpha",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", parameters={"main_mas": 1}, times=[1]),
        UnknownNameError,
        "'main_mass'",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", parameters={"main_mass": -1}, times=[1]),
        ParameterError,
        "greater than 0",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", parameters={"main_mass": [1, 2]}, times=[1]),
        ParameterError,
        "must be a number",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", state={"thet": 1}, times=[1]),
        UnknownNameError,
        "'theta'",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", state={"theta": np.nan}, times=[1]),
        ParameterError,
        "finite",
    ),
    (lambda: mbcheck.simulate("hula_hoop", step=0.1, times=[1]), UsageError, "its own steps"),
    (
        lambda: mbcheck.simulate("hula_hoop", "mujoco", step=np.nan, times=[1]),
        ParameterError,
        "step must be",
    ),
    (lambda: mbcheck.simulate("hula_hoop", times=[]), UsageError, "not empty"),
    (lambda: mbcheck.simulate("hula_hoop", times=[0]), UsageError, "nothing to simulate"),
    (lambda: mbcheck.simulate("hula_hoop", times=[2, 1]), UsageError, "increase"),
    (lambda: mbcheck.simulate("hula_hoop", times=np.ones((2, 2))), UsageError, "one row"),
    (lambda: mbcheck.simulate("hula_hoop", times=["a"]), UsageError, "numbers"),  # type: ignore[list-item]
    (lambda: mbcheck.frequencies("hula_hoop", "rod_alinged"), UnknownNameError, "'rod_aligned'"),
    (lambda: mbcheck.frequencies("hula_hoop", count=0), UsageError, "1 or more"),
    (lambda: mbcheck.orbit("hula_hoop", step=0.1), UsageError, "its own steps"),
    (lambda: mbcheck.orbit("hula_hoop", engine="mujoco", step=0.1), UsageError, "too long"),
    (lambda: mbcheck.orbit("hula_hoop", engine="mujoco", step=1e-3), UsageError, "nearest that do"),
    (lambda: mbcheck.check(["hula_hop"]), UnknownNameError, "'hula_hoop'"),
    (lambda: mbcheck.check(ids=["nothing"]), UsageError, "no check"),
    (lambda: api.mjcf_text("hula_hoop", model="tee"), UnknownNameError, "'tree'"),
]


@pytest.mark.parametrize("refused", REFUSED)
def test_refused(refused: Refused) -> None:
    call, error, words = refused
    with pytest.raises(error, match=words):
        call()


# orbit


@pytest.fixture(scope="module")
def true_orbit() -> api.OrbitReport:
    return mbcheck.orbit("hula_hoop")


def test_reference_orbit(true_orbit: api.OrbitReport) -> None:
    document = validated("orbit", true_orbit.as_json())
    assert document["period"] == pytest.approx(1 / 3)
    assert document["mean_speed"] == pytest.approx(6 * np.pi)
    assert document["stable"]
    assert sum(document["power"].values()) == pytest.approx(0, abs=1e-8)
    moduli = [item["modulus"] for item in document["floquet_multipliers"]]
    assert moduli == sorted(moduli, reverse=True)
    theta = document["harmonics"]["theta"]
    assert [term["order"] for term in theta["terms"]] == [1, 2, 3, 4, 5, 6]
    assert theta["terms"][1]["amplitude"] == pytest.approx(0.2606, abs=1e-4)


def test_harmonics_sum_to_the_state(true_orbit: api.OrbitReport) -> None:
    for name, (mean, terms) in true_orbit.harmonics.items():
        value = mean + sum(term.amplitude * np.cos(term.phase) for term in terms)
        assert value == pytest.approx(true_orbit.state[name], abs=3e-2)


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_engine_orbit(engine: str, true_orbit: api.OrbitReport) -> None:
    found = mbcheck.orbit("hula_hoop", engine=engine)
    document = validated("orbit", found.as_json())
    assert document["error_bound"] is None
    assert document["period"] / document["step"] == pytest.approx(
        round(document["period"] / document["step"]), rel=1e-14
    )
    for name, value in true_orbit.state.items():
        assert found.state[name] == pytest.approx(value, abs=1e-5)
    np.testing.assert_allclose(
        np.abs(found.floquet_multipliers), np.abs(true_orbit.floquet_multipliers), atol=1e-6
    )
    assert found.power["hinge"] == pytest.approx(true_orbit.power["hinge"], rel=1e-6)


def test_orbit_with_a_given_step() -> None:
    found = mbcheck.orbit("hula_hoop", engine="mujoco", method="Euler", step=1 / 3 / 1024)
    assert found.step == 1 / 3 / 1024


def test_difference_quotients_are_exact_to_nine_digits() -> None:
    orbit = find_orbit(SCENE, POINT)
    engine = get_engine("exudyn")
    method = next(item for item in engine.methods if item.name == "RK67")
    case = Case("hula_hoop", "orbit", POINT)
    flow = orbits.PeriodMap(Setup(engine, case, "kinematic_tree", method), orbit.period, 512)
    scale = state_scale(SCENE, orbit.state, 2 * np.pi / orbit.period)
    error = (flow.jacobian(orbit.state, scale) - orbit.monodromy) * scale / scale[:, None]
    assert np.max(np.abs(error)) < 1e-9


@pytest.mark.slow  # that of the command line is not
@pytest.mark.parametrize("engine", ["reference", "mujoco"])
def test_no_orbit(engine: str) -> None:
    with pytest.raises(NoOrbitError, match="no periodic orbit"):
        mbcheck.orbit("hula_hoop", {"force_amplitude": 0.5}, engine)


def test_newton_that_does_not_converge_is_no_orbit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(orbits, "MOST_ITERATIONS", 1)
    with pytest.raises(NoOrbitError, match="mujoco Euler has no periodic orbit"):
        mbcheck.orbit("hula_hoop", engine="mujoco", method="Euler", step=1 / 3 / 256)


# frequencies

ACROSS = np.sqrt(1000 / 0.45)  # the free mass does not take part
ALIGNED = np.sqrt(1000 / 0.495)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("about", "omega"), [(None, ACROSS), ("rod_aligned", ALIGNED)])
def test_undamped_frequencies(engine: str, about: str | None, omega: float) -> None:
    found = mbcheck.frequencies("hula_hoop", about, engine=engine, undamped=True)
    document = validated("frequencies", found.as_json())
    zero, mode = document["modes"]
    assert zero["damping_ratio"] is None
    assert zero["omega"] == pytest.approx(0, abs=1e-6)
    assert mode["omega"] == pytest.approx(omega, rel=1e-9)
    assert mode["hertz"] == pytest.approx(omega / 2 / np.pi, rel=1e-9)
    assert document["about"] == (about or "rod_across")


@pytest.mark.parametrize("engine", ENGINES)
def test_damped_frequencies(engine: str) -> None:
    found = mbcheck.frequencies("hula_hoop", "rod_aligned", engine=engine)
    assert found.state["theta"] == np.pi / 2
    slide = found.modes[-1]
    assert slide.damping_ratio == pytest.approx(0.1, rel=1e-8)  # rho, by its definition
    assert slide.im == pytest.approx(ALIGNED * np.sqrt(1 - 0.1**2), rel=1e-8)
    assert [mode.omega for mode in found.modes] == sorted(mode.omega for mode in found.modes)
    assert len(mbcheck.frequencies("hula_hoop", engine=engine, count=1).modes) == 1


def test_an_engine_that_raises_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: Any) -> Any:
        raise ValueError("no such body\nand more")

    monkeypatch.setattr(get_engine("mujoco"), "linearise", broken)
    with pytest.raises(EngineError, match=r"ValueError: no such body$"):
        mbcheck.frequencies("hula_hoop", engine="mujoco")


# check


def test_check() -> None:
    seen: list[tuple[int, int, int]] = []
    report = mbcheck.check(
        engines=["mujoco"],
        kinds=["frequency"],
        progress=lambda done, total, results: seen.append((done, total, len(results))),
    )
    document = validated("check", report.as_json())
    assert document["summary"] == report.summary
    assert report.summary["total"] == sum(n for _, _, n in seen)
    assert report.summary["pass"] == report.summary["total"] - report.summary["skipped"] > 0
    assert [done for done, _, _ in seen] == list(range(1, seen[0][1] + 1))
    assert report.exit_code == 0
    assert "exudyn" not in report.versions


def test_an_engine_not_asked_for_may_be_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def without_exudyn(name: str) -> Any:
        if name == "exudyn":
            raise EngineUnavailableError("exudyn cannot be imported; install libgl1")
        return get_engine(name)

    for module in (engines, suite):
        monkeypatch.setattr(module, "get_engine", without_exudyn)
    report = mbcheck.check(kinds=["frequency"])
    missing = [item for item in report.results if "libgl1" in item.reason]
    assert [(item.engine, item.verdict) for item in missing] == [("exudyn", "skipped")]
    assert report.exit_code == 0
    validated("check", report.as_json())
    with pytest.raises(EngineUnavailableError, match="libgl1"):
        mbcheck.check(engines=["exudyn"])
