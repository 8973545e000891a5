"""What accuracy costs: sweeps, what limits them, and what to choose."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks.kinds.order import relative_error
from mbcheck.comparisons.checks.truth import roundoff_reference
from mbcheck.comparisons.cli.group import program
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import run
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.comparisons.reports.files import Destination
from mbcheck.comparisons.tradeoff.pages import steps_table, write
from mbcheck.comparisons.tradeoff.report import Tradeoff, tradeoff
from mbcheck.comparisons.tradeoff.request import TradeoffRequest
from mbcheck.comparisons.tradeoff.sweep import (
    beside,
    case_of,
    horizon_of,
    setup_of,
    smallest,
    sweeps,
)
from mbcheck.comparisons.tradeoff.sweep import swept as sweep
from mbcheck.comparisons.tradeoff.table import (
    MODEL,
    ROUND_OFF,
    STEP,
    UNEXPLAINED,
    Choice,
    Cost,
    Point,
    StepSeries,
    choose,
    pareto,
    trials_of,
)
from mbcheck.comparisons.tradeoff.tuning import SWEEP
from mbcheck.reference.equations import scene_equations
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import refusal
from mbcheck.tests.support.documents import validated


def header(scene: str, engine: str, model: str, method: str, **settings: float) -> StepSeries:
    """Return a series that is to be measured."""
    order = next(one.order for one in get_engine(engine).methods if one.name == method)
    return StepSeries(scene, case_of(scene).name, engine, model, method, order, settings)


def swept(*words: str, **settings: float) -> StepSeries:
    """Return a series, each run made once."""
    scene, engine, model, method = words
    return sweep(header(scene, engine, model, method, **settings), repeats=1)


def series(*points: tuple[float, float, float], engine: str = "mujoco", **words: Any) -> StepSeries:
    """Return a series of (step, error, seconds)."""
    listed = tuple(Point(h, e, {}, Cost(t, t, t, 1.0), STEP, "step") for h, e, t in points)
    return StepSeries("hula_hoop", "a case", engine, "tree", "RK4", 4, words, listed)


@pytest.mark.parametrize(
    ("engine", "model", "method", "order"),
    [
        ("mujoco", "tree", "Euler", 1),
        ("exudyn", "kinematic_tree", "RK33", 3),
        ("exudyn", "kinematic_tree", "TrapezoidalIndex2", 2),
    ],
)
def test_order_above_the_floor(engine: str, model: str, method: str, order: int) -> None:
    found = swept("hula_hoop", engine, model, method)
    assert found.slope == pytest.approx(order, abs=0.1)
    good = [p for p in found.points if p.error is not None and p.error < SWEEP.asymptotic_error]
    assert {p.label for p in good} <= {STEP}
    assert not any(p.wasted for p in good)
    assert found.plateau is None


def test_the_floor_of_inertia_is_named() -> None:
    found = swept("hula_hoop", "mujoco", "tree", "RK4")
    assert found.plateau_name == "inertia floor"
    assert found.plateau == pytest.approx(3.4e-11, rel=0.2)  # 2e-15 / (m R^2), times its growth
    assert found.points[-1].wasted
    assert found.points[-1].label == MODEL
    assert found.stable_step is not None
    assert found.points[2].cost is not None
    assert found.points[2].cost.rhs_evaluations == pytest.approx(4 * found.points[2].cost.steps)


def test_round_off_is_named() -> None:
    found = swept("hula_hoop", "exudyn", "kinematic_tree", "RK67")
    assert found.plateau_name == "round-off"
    assert found.points[-1].label == ROUND_OFF


def test_closure_softness_is_named_and_hardens() -> None:
    soft = swept("speed_regulator", "mujoco", "connect", "RK4")
    assert soft.plateau_name == "closure softness"
    assert soft.plateau == pytest.approx(1.9e-3, rel=0.05)
    hard = swept("speed_regulator", "mujoco", "connect_hard", "RK4", closure_time=0.02)
    assert hard.plateau_name == "closure softness"
    assert hard.plateau is not None
    assert hard.plateau < 1e-5


def test_failed_runs_say_why() -> None:
    found = swept("speed_regulator", "mujoco", "connect", "Euler")
    first = found.points[0]
    assert first.error is None
    assert first.reason.startswith("step: ")


@pytest.mark.slow
def test_what_limits_a_beam() -> None:
    words = ("rotating_beam", "exudyn", "elements", "GeneralizedAlpha")
    default = swept(*words)
    assert default.plateau_name == "spatial discretisation"
    assert swept(*words, segments=24).plateau_name == "continuum"
    loose = beside(swept(*words, newton_tolerance=1e-4), [default])
    assert loose.plateau_name == "solver tolerance"
    chain = swept("rotating_beam", "mujoco", "chain", "RK4")
    assert chain.plateau_name == "spatial discretisation"
    assert chain.plateau == pytest.approx(0.017, rel=0.1)


def test_a_wrong_engine_meets_a_floor(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mass that is off by 0.1 % leaves an error that no step removes, and no name explains."""
    heavier = Misread(get_engine("exudyn"), lambda p: p.replace(free_mass=1.001 * p.free_mass))
    monkeypatch.setattr("mbcheck.comparisons.tradeoff.sweep.get_engine", lambda name: heavier)
    found = swept("hula_hoop", "exudyn", "kinematic_tree", "RK67")
    assert found.plateau is not None
    assert found.plateau > 1e-5
    assert found.plateau_name == UNEXPLAINED
    assert found.points[-1].label == MODEL
    assert found.points[-1].wasted


def test_a_limit_longer_than_the_run_is_a_margin() -> None:
    """RK67 is unstable at 2.1 s over many periods; a run of 2 s alone would not tell."""
    found = swept("speed_regulator", "exudyn", "one_dof", "RK67")
    assert found.stable_step == pytest.approx(2.1, rel=0.05)
    margin = choose([found], 1e-2).margin
    assert margin is not None
    assert margin > 1


def test_second_axes_are_swept() -> None:
    every = sweeps((), ("mujoco", "exudyn"))
    assert len({one.name for one in every}) == len(every)
    settings = {(one.scene, one.engine, name) for one in every for name in one.settings}
    assert {
        ("speed_regulator", "mujoco", "closure_time"),
        ("speed_regulator", "mujoco", "solver_tolerance"),
        ("speed_regulator", "exudyn", "newton_tolerance"),
        ("rotating_beam", "mujoco", "segments"),
        ("rotating_beam", "exudyn", "segments"),
    } <= settings


# Choices


def test_pareto_front() -> None:
    one = series((0.1, 1e-2, 1.0), (0.05, 1e-3, 2.0), (0.02, 1e-3, 3.0))
    other = series((0.1, 5e-2, 0.5), (0.05, 5e-4, 2.5), (0.01, 2.0, 0.1))
    places = ((other, 0), (one, 0), (one, 1), (other, 1))
    assert pareto(trials_of([one, other])) == [(of, of.points[i]) for of, i in places]


def test_the_cheapest_that_meets_the_target() -> None:
    one = series((0.1, 1e-2, 1.0), (0.05, 1e-3, 2.0), (0.02, 1e-5, 3.0))
    assert choose([one], 1e-2).step == 0.1
    assert choose([one], 2e-3).step == 0.05
    one = replace(one, points=(*one.points, replace(one.points[-1], error=9e-6, step=0.01)))
    none = choose([one], 1e-6)
    assert not none.met
    assert none.error == 9e-6
    assert "RK4" in none.limit


def test_the_step_of_each_method_is_listed() -> None:
    one = series((0.1, 1e-2, 1.0), (0.05, 1e-3, 2.0), (0.02, 1e-5, 3.0))
    other = replace(series((0.2, 5e-3, 1.0), (0.1, 1e-3, 2.0)), method="Euler", stable_step=0.5)
    result = Tradeoff((1e-2, 1e-3), (one.scene,), (one.engine,), series=[one, other])
    heads, rows = steps_table(result)
    assert heads[-2:] == ("1 % [s]", "0.1 % [s]")
    names = [row[2] for row in rows]
    assert names == [one.method, "Euler"]
    assert [row[-2:] for row in rows] == [("0.1", "0.05"), ("0.2", "-")]
    assert [row[3] for row in rows] == ["-", "0.5"]


def test_an_error_that_is_small_by_chance_is_not_chosen() -> None:
    one = series((0.1, 1e-4, 1.0), (0.05, 1e-2, 2.0), (0.02, 1e-5, 3.0), (0.01, 1e-6, 6.0))
    assert choose([one], 1e-3).step == 0.02


@pytest.mark.parametrize(("label", "met"), [(STEP, False), (MODEL, True), (ROUND_OFF, True)])
def test_the_last_point_is_chosen_only_at_its_floor(label: str, met: bool) -> None:
    """What half of the shortest step gives is not known: by chance, where the step limits."""
    one = series((0.1, 1e-2, 1.0), (0.05, 1e-5, 2.0))
    one = replace(one, points=(one.points[0], replace(one.points[1], label=label)))
    assert choose([one], 1e-3).met is met


def test_noise_of_the_clock_turns_no_knob() -> None:
    plain = series((0.1, 1e-4, 1.1), (0.05, 1e-4, 2.0))
    turned = series((0.1, 2e-4, 1.0), (0.05, 2e-4, 2.0), newton_tolerance=1e-4)
    dearer = series((0.1, 1e-4, 1.3), (0.05, 1e-4, 2.0))
    assert choose([plain, turned], 1e-3).settings == {}
    assert choose([dearer, turned], 1e-3).settings == {"newton_tolerance": 1e-4}


def test_margin_to_instability() -> None:
    one = replace(series((0.1, 1e-3, 1.0), (0.05, 1e-4, 2.0)), stable_step=0.25)
    assert choose([one], 1e-2).margin == pytest.approx(2.5)


def fresh_error(series: StepSeries, step: float) -> float:
    """Return the error of one run of a series, as in `Point.error`, run anew."""
    setup = setup_of(series)
    span, names = horizon_of(setup.case), setup.scene.observables
    times = span.times(step)
    right = roundoff_reference(scene_equations(setup.case), setup.case, times, names)
    return relative_error(run(setup.with_step(step), times).matrix(names), right)


def series_of(choice: Choice) -> StepSeries:
    """Return the series of a choice that meets its target."""
    assert choice.model is not None
    assert choice.method is not None
    settings = dict(choice.settings or {})
    return header(choice.scene, choice.engine, choice.model, choice.method, **settings)


def test_recommendations_hold_when_run_afresh() -> None:
    found = Tradeoff.of_request(TradeoffRequest(("hula_hoop",), ("mujoco",)))
    found.series = [swept("hula_hoop", "mujoco", "tree", name) for name in ("Euler", "RK4")]
    choices = [one for one in found.recommendations if one.axis == "step"]
    assert len(choices) == 3
    for choice in choices:
        assert choice.step is not None
        fresh = fresh_error(series_of(choice), choice.step)
        assert fresh <= choice.target
        assert fresh == pytest.approx(choice.error, rel=1e-6)


@pytest.mark.campaign
def test_every_recommendation_holds_when_run_afresh() -> None:
    found = tradeoff()
    assert isinstance(found, Tradeoff)
    assert not found.failures
    assert {choice.scene for choice in found.recommendations if choice.met} == set(found.scenes)
    for choice in found.recommendations:
        if choice.step is not None:
            assert fresh_error(series_of(choice), choice.step) <= choice.target, choice


# The smallest models


def closures(*rows: tuple[float, float]) -> list[StepSeries]:
    """Return a hard closure by its time constant [s]; each floor is met with two steps."""
    every = []
    for value, floor in rows:
        words = {} if value == 0.002 else {"closure_time": value}
        one = header("speed_regulator", "mujoco", "connect_hard", "RK4", **words)
        points = [
            Point(step, floor, {}, Cost(time, time, time, 1.0), MODEL, "closure softness")
            for step, time in ((0.02, 1.0), (0.01, 2.0))
        ]
        every.append(replace(one, points=tuple(points)))
    return every


def test_the_softest_closure_from_which_on_all_meet_the_target() -> None:
    """One that is softer may do so by chance."""
    rows = ((0.02, 1e-4), (0.01, 2e-3), (0.005, 4e-4), (0.002, 3e-5), (0.001, 8e-6))
    for target, value, error, smaller in (
        (1e-3, 0.005, 4e-4, 2e-3),
        (1e-4, 0.002, 3e-5, 4e-4),
        (1e-2, 0.02, 1e-4, None),
    ):
        (choice,) = smallest(closures(*rows), target)
        assert (choice.axis, choice.unit, choice.model) == ("closure_time", "s", "connect_hard")
        assert choice.met
        assert (choice.value, choice.error, choice.smaller) == (value, error, smaller)
        assert choice.step == 0.02
    (none,) = smallest(closures(*rows), 1e-6)
    assert not none.met
    assert (none.value, none.error) == (None, 8e-6)
    assert not list(smallest(closures((0.002, 1e-5)), 1e-2))


@pytest.mark.slow
def test_the_fewest_rods_of_a_chain() -> None:
    """So many meet the target, and the next fewer that were run do not."""
    words = ("rotating_beam", "mujoco", "chain", "RK4")
    every = [swept(*words), swept(*words, segments=6), swept(*words, segments=24)]
    (choice,) = smallest(every, 1e-2)
    assert (choice.axis, choice.value, choice.met) == ("segments", 24, True)
    assert choice.error is not None
    assert choice.smaller is not None
    assert choice.error <= 1e-2 < choice.smaller


# The verb


def test_document_page_and_picture(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    found = Tradeoff.of_request(TradeoffRequest(("hula_hoop",), ("mujoco",), (1e-4, 1e-2)))
    found.series = [series((0.1, 1e-2, 1.0), (0.05, 1e-5, 2.0), (0.02, 1e-7, 3.0))]
    document = validated("tradeoff", found.as_json())
    assert document["targets"] == [1e-2, 1e-4]
    assert [one["step"] for one in document["recommendations"]] == [0.1, 0.05]
    assert [one["step"] for one in document["pareto"]["hula_hoop"]] == [0.1, 0.05, 0.02]
    page, plot = tmp_path / "page.md", tmp_path / "one.png"
    write(found, None, Destination("--markdown", str(page)), Destination("--plot", str(plot)))
    assert plot.read_bytes().startswith(b"\x89PNG")
    title = "What limits the methods"
    assert f"## {title}\n\n![{title}](one.png)\n\n| scene |" in page.read_text()
    assert "| hula_hoop | mujoco | 0.0001 | tree RK4 | 0.05 |" in page.read_text()


def test_what_was_done_is_kept_and_resumed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A series that fails costs no other, and these are not run again."""
    only = header("speed_regulator", "exudyn", "one_dof", "RK67")
    lost = replace(only, method="lost")
    report = "mbcheck.comparisons.tradeoff.report"
    monkeypatch.setattr(f"{report}.sweeps", lambda scenes, who: [only, lost])
    monkeypatch.setattr(f"{report}.pairs_of", lambda scenes, who: [])
    file = str(tmp_path / "runs.json")

    def found(*targets: float) -> Tradeoff:
        names = ("speed_regulator",), ("exudyn",)
        result = Tradeoff.of_request(TradeoffRequest(*names, targets, resume=file))
        result.done = [what for _, _, what in result.work()]  # type: ignore[attr-defined]
        return result

    first, again = found(1e-2), found(1e-2)
    for one in (first, again):
        assert len(one.failures) == 1
        assert one.failures[0].startswith(f"{lost.name}: raised")
        assert one.recommendations[0].method == "RK67"
    assert len(first.done) == 2  # type: ignore[attr-defined]
    assert again.done == [lost.name]  # type: ignore[attr-defined]
    assert again.as_json() == first.as_json()
    assert found(1e-3).done == [lost.name]  # type: ignore[attr-defined]
    broken = json.loads(Path(file).read_text())
    broken["entries"] = {key: {"series": 1} for key in broken["entries"]}
    Path(file).write_text(json.dumps(broken))
    with pytest.raises(UsageError, match="holds no runs"):
        found(1e-2)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("--target 0", "between 0 and 1"),
        ("--target 1", "between 0 and 1"),
        ("--target nan", "between 0 and 1, not nan"),
        ("speed_regulatr", "did you mean 'speed_regulator'"),
        ("--engine reference", "checked against"),
        ("hula_hoop --horizon 2", "are for a model"),
        ("no_such.xml", "no_such.xml"),
    ],
)
def test_what_makes_no_sense_is_refused(line: str, words: str) -> None:
    assert words in refusal(f"tradeoff {line}")


def test_an_interrupted_run_keeps_what_it_has(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(found: Tradeoff) -> Iterator[tuple[int, int, str]]:
        found.series.append(series((0.1, 1e-2, 1.0)))
        yield 1, 2, "one of two"
        raise KeyboardInterrupt

    monkeypatch.setattr(Tradeoff, "work", interrupted)
    file = tmp_path / "found.json"
    assert program.exit_code(args=["tradeoff", "hula_hoop", "--json", str(file)]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert len(json.loads(file.read_text())["series"]) == 1
