"""``mbcheck tradeoff MODEL.xml``: what it recommends holds, and it says where nothing can."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.inspect.inspection import inspect
from mbcheck.comparisons.inspect.mujoco.model import load
from mbcheck.comparisons.tradeoff.bench import Bench, Converged, Setting, converge
from mbcheck.comparisons.tradeoff.model import ModelTradeoff, setting_of
from mbcheck.comparisons.tradeoff.request import TradeoffRequest
from mbcheck.comparisons.tradeoff.table import Cost, Trial
from mbcheck.comparisons.tradeoff.tuning import BENCH
from mbcheck.tests.support.command import invoke, refusal, succeeds
from mbcheck.tests.support.documents import validated

mujoco = pytest.importorskip("mujoco")

ARM = """<mujoco>
  <option timestep="0.002" {option}/>
  <worldbody>
    {floor}
    <body>
      <joint name="shoulder" axis="0 1 0" damping="{damping}"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.5" {contact}/>
      <body pos="0.3 0 0">
        <joint name="elbow" axis="0 1 0" damping="{damping}"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.3" {contact}/>
        <site name="tip" pos="0.3 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="shoulder" joint="shoulder" kp="{kp}" ctrlrange="-1 1"/>
  </actuator>
  {keys}
</mujoco>
"""
FREE = dict.fromkeys(("option", "floor", "keys"), "")
FREE |= {"contact": 'contype="0"', "kp": "20", "damping": "0.02"}


def written(folder: Path, **changes: str) -> str:
    """Return the path of an arm."""
    path = folder / "arm.xml"
    path.write_text(ARM.format(**FREE | changes), encoding="utf-8")
    return str(path)


def asked(file: str, target: float = 0.01, **options: Any) -> TradeoffRequest:
    """Return a request with time for all of it."""
    return TradeoffRequest((file,), targets=(target,), **{"budget": 1e4} | options)


def advised(file: str, **options: Any) -> ModelTradeoff:
    """Return the advice on a file, all of it worked out."""
    advice = ModelTradeoff(asked(file, **options))
    for _ in advice.work():
        pass
    return advice


def test_the_recommended_setting_meets_its_target_with_other_controls(tmp_path: Path) -> None:
    file = written(tmp_path)
    advice = advised(file, horizon=0.25)
    choice = advice.choice
    assert choice is not None
    listed = {limit.integrator for limit in inspect(file).steps}
    assert {trial.series.method for trial in advice.trials} == listed
    assert choice.error <= BENCH.margin * 0.01
    other = advised(file, horizon=0.25, seed=7)
    (again,) = [one for one in other.trials if setting_of(one) == setting_of(choice)]
    assert again.error <= 0.01


@pytest.mark.parametrize("changes", [{}, {"kp": "2000", "damping": "2"}])
def test_what_is_not_run_would_not_be_chosen(changes: dict[str, str], tmp_path: Path) -> None:
    """All settings left out are run after the choice, and each integrator has one before."""
    file = written(tmp_path, **changes)
    advice, bench = advised(file, horizon=0.25), Bench(load(file), asked(file, horizon=0.25))
    choice, known = advice.choice, {setting_of(one) for one in advice.trials}
    left = [one for one in bench.settings() if one not in known]
    assert choice is not None
    assert left
    assert advice.next_setting(bench) is None
    for setting in left:
        advice.tried(bench, setting)
    assert advice.choice is not None
    assert setting_of(advice.choice) == setting_of(choice)


def test_a_smooth_motion_converges_at_an_eighth_of_the_step(tmp_path: Path) -> None:
    """Its bound holds against a run with a 64th."""
    file = written(tmp_path)
    bench = Bench(load(file), asked(file, horizon=0.25))
    start = next(bench.starts((1,)))
    truth = converge(bench, start)
    assert isinstance(truth, Converged)
    assert truth.setting == bench.file._replace(integrator="RK4", step=0.002 / 8)
    finer = bench.run(start, truth.setting._replace(step=0.002 / 64), sharp=True)
    assert np.all(bench.apart(finer, truth.run, truth.size) <= truth.error + 1e-12)
    assert float(np.max(truth.error)) <= BENCH.known_share * BENCH.enough * 0.01


LIMITED = """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody><body>
  <joint name="x" axis="0 1 0" range="-60 60" stiffness="0.5"/>
  <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.5" contype="0"/></body>
  </worldbody><actuator><motor joint="x" ctrlrange="-1 1"/></actuator></mujoco>"""


def test_what_fails_from_another_start_is_not_recommended(tmp_path: Path) -> None:
    """From the file's start long steps do; at a limit that the control reaches they do not."""
    path = tmp_path / "limited.xml"
    path.write_text(LIMITED)
    advice = advised(str(path), horizon=0.4)
    bench = Bench(load(path), asked(str(path), horizon=0.4))
    starts = list(bench.other_starts())
    assert [one.draw > 0 for one in starts] == [True, True, False]
    assert all(abs(one.state.position[0]) < 0.81 * math.pi / 3 for one in starts)
    assert set(starts[2].controls.ravel().tolist()) <= {-1.0, 1.0}
    longest = max(advice.missed, key=lambda setting: setting.step)
    assert next(one.error for one in advice.trials if setting_of(one) == longest) < 0.005
    assert advice.missed[longest] > 0.1
    assert advice.choice is not None
    assert advice.elsewhere is not None
    assert advice.elsewhere < 0.01
    setting = setting_of(advice.choice)
    assert setting.step < longest.step
    for start in starts:  # against a run with a 64th of the step, by another clock
        exact, own = (
            bench.run(start, one, sharp=True) for one in (setting._replace(step=0.01 / 64), setting)
        )
        assert exact is not None
        assert own is not None
        assert bench.apart(own, exact, bench.sizes(exact)).max() < 0.01


def slowed(trial: Trial, factor: float) -> Trial:
    """Return a run that took a factor longer."""
    assert isinstance(trial.point.cost, Cost)
    cost = replace(trial.point.cost, seconds=factor * trial.seconds)
    return trial._replace(point=replace(trial.point, cost=cost))


def test_what_is_said_does_not_hang_on_times(tmp_path: Path) -> None:
    """Decided by counted evaluations: a busy machine says the same."""
    advice = advised(written(tmp_path), horizon=0.2)
    said, generator = advice.sentence, np.random.default_rng(0)
    for _ in range(20):
        advice.trials = [slowed(one, generator.uniform(0.2, 5)) for one in advice.trials]
        assert advice.sentence == said


def test_a_sharper_target_asks_for_more(tmp_path: Path) -> None:
    file = written(tmp_path)
    rough, sharp = (advised(file, horizon=0.25, target=target) for target in (0.05, 1e-5))
    assert rough.choice is not None
    assert sharp.choice is not None
    assert sharp.choice.series.method == "RK4"
    assert sharp.choice.error < rough.choice.error
    assert sharp.truths[0].smooth
    assert max(float(one.error.max()) for one in sharp.truths) < 1e-6


def test_a_step_that_the_limit_calls_unstable_is_not_recommended(tmp_path: Path) -> None:
    advice = advised(written(tmp_path, kp="20000"), horizon=0.2)
    lost = [one for one in advice.trials if one.point.reason]
    assert lost
    assert all(one.error == float("inf") for one in lost)
    if advice.choice is not None and advice.choice.series.stable_step:
        assert setting_of(advice.choice).step <= 1.02 * advice.choice.series.stable_step


@pytest.mark.slow
def test_what_grows_is_compared_as_long_as_it_is_known(tmp_path: Path) -> None:
    """A double pendulum that swings over is chaotic: after some seconds nothing converges."""
    keys = '<keyframe><key name="up" qpos="-1.5 0.1"/></keyframe>'
    file = written(tmp_path, kp="0", damping="0", keys=keys)
    advice = advised(file, horizon=2.5)
    assert 0 < advice.compared < 2.5
    factors = re.findall(r"small errors grow by a factor of (\S+)", " ".join(advice.notes))
    assert factors
    assert min(map(float, factors)) > BENCH.known_share / BENCH.departure
    assert f"over {advice.compared:.3g} s of 2.5 s" in advice.sentence


SMALL = """<mujoco><option timestep="0.002"/><worldbody>
  <body><joint name="arm" axis="0 1 0" damping="0.02"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.1" contype="0"/></body>
  <body><joint name="base" type="slide" axis="1 0 0" {base}/>
    <geom type="box" size="0.1 0.1 0.1" mass="100" contype="0"/></body>
  </worldbody></mujoco>"""
"""A pendulum, and beside it a heavy body that moves little, or rests."""


@pytest.mark.parametrize(
    "base", ['stiffness="1e5" damping="30" springref="0.00005"', 'stiffness="1e5" damping="30"']
)
def test_a_small_motion_is_not_taken_for_errors_that_grow(tmp_path: Path, base: str) -> None:
    path = tmp_path / "small.xml"
    path.write_text(SMALL.format(base=base))
    advice = advised(str(path), horizon=0.25)
    assert not advice.unknown
    assert advice.compared > 0.2
    (truth,) = advice.truths
    assert float(np.max(truth.spread)) < 10 * truth.apart
    assert truth.apart == pytest.approx(BENCH.departure * 0.01, rel=1e-6)


@pytest.mark.slow
def test_contacts_have_no_bound(tmp_path: Path) -> None:
    floor = '<geom type="plane" size="1 1 1" pos="0 0 -0.1"/>'
    advice = advised(written(tmp_path, floor=floor, contact="", kp="0"), horizon=0.25)
    assert any("errors have no order, and no bound" in note for note in advice.notes) or any(
        "contacts" in note for note in advice.unknown
    )


def test_a_model_at_rest_has_nothing_to_compare(tmp_path: Path) -> None:
    still = 'gravity="0 0 0"'
    done = invoke(f"tradeoff {written(tmp_path, option=still, kp='0')} --horizon 0.1")
    assert done.exit_code == 1
    text = " ".join(done.stdout.split())
    assert "no run converges: as opened, constant controls; as opened, moving controls (1);" in text
    assert ": nothing moves by 1e-06 m or rad" in text


def test_sites_may_be_observed(tmp_path: Path) -> None:
    """The tip moves less, in its size, than the elbow turns in its own."""
    file = written(tmp_path)
    joints, tip = (advised(file, horizon=0.2, observed=names) for names in ((), ("tip",)))
    assert joints.own is not None
    assert tip.own is not None
    assert 0 < tip.own.error < joints.own.error


@pytest.mark.usefixtures("own_folder")
def test_its_documents(tmp_path: Path) -> None:
    file = written(tmp_path)
    printed = succeeds(f"tradeoff {file} --horizon 0.2 --json a.json --plot a.png")
    answer = validated("tradeoff_model", json.loads(Path("a.json").read_text()))
    assert answer["met"]
    assert answer["recommendation"]["step"] in [
        point["step"] for one in answer["series"] for point in one["points"]
    ]
    assert " ".join(answer["sentence"].split()) in " ".join(printed.split())
    assert Path("a.png").stat().st_size > 10_000
    page = succeeds(f"tradeoff {file} --horizon 0.2 --markdown -")
    assert page.splitlines()[0].endswith("arm.xml")
    assert f"* {answer['sentence']}" in page
    assert "| >" in page


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--horizon 0", "--horizon must be a positive number"),
        ("--target 2", "between 0 and 1"),
        ("--target 0.1 --target 0.2", "for a model: one --target (0.1, 0.2)"),
        ("--engine mujoco", "for a model: no --engine (mujoco): MuJoCo runs it"),
        ("hula_hoop", "for a model: one file, and nothing else ("),
        ("--observe nothing", "has no such joint or site"),
        ("--exact-closures", "has no equality"),
    ],
)
def test_what_makes_no_sense_is_refused(tmp_path: Path, options: str, said: str) -> None:
    assert said in refusal(f"tradeoff {written(tmp_path)} {options}")


def test_the_time_is_kept(tmp_path: Path) -> None:
    advice = advised(written(tmp_path), budget=1e-6)
    assert not advice.complete
    assert advice.choice is None


LOOP = """<mujoco>
  <option timestep="0.002" iterations="{iterations}"/>
  <worldbody>
    <body>
      <joint name="crank" axis="0 1 0"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.2 0 0.1" mass="0.5" contype="0"/>
      <body pos="0.2 0 0.1">
        <joint name="coupler" axis="0 1 0"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0" mass="3" contype="0"/>
      </body>
    </body>
    <body pos="0.7 0 0">
      <joint name="rocker" axis="0 1 0"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.1" mass="0.5" contype="0"/>
      <site name="pin" pos="0 0 0.1"/>
    </body>
  </worldbody>
  <equality><connect body1="body2" body2="body3" anchor="0.5 0 0" solref="0.1 1"/></equality>
</mujoco>
"""


def loop(folder: Path, iterations: int = 100) -> str:
    """Return the path of a four-bar linkage with a soft closure."""
    path, text = folder / "loop.xml", LOOP.format(iterations=iterations)
    for number in (1, 2, 3):
        text = text.replace("<body>", f'<body name="body{number}">', 1)
        text = text.replace("<body pos", f'<body name="body{number + 1}" pos', 1)
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_soft_closures_are_told_and_hardened(tmp_path: Path) -> None:
    file = loop(tmp_path)
    own, exact = (advised(file, horizon=0.1, target=5e-3, exact=exact) for exact in (False, True))
    assert own.sentence.startswith("closures as soft as in the file change the motion by ")
    assert "(--exact-closures); with soft ones, " in own.sentence
    assert "; with hard ones, " in exact.sentence
    assert own.largest("softness") == pytest.approx(exact.largest("softness"), rel=0.1)
    assert {setting_of(one).closure for one in own.trials} == {None}
    # as soft as in the file a short step does not meet the target; with hard closures it does
    bench, short_step = Bench(load(file), exact.request), Setting("RK4", 0.0005)
    for setting in (short_step, short_step._replace(closure=BENCH.closure_steps * 0.0005)):
        exact.tried(bench, setting)
    errors = {setting_of(one): one.error for one in exact.trials}
    short = {one: errors[one] for one in errors if one.integrator == "RK4" and one.step <= 0.002}
    soft, hard = (
        min(error for one, error in short.items() if (one.closure is None) == own)
        for own in (True, False)
    )
    assert hard < BENCH.margin * exact.request.target < exact.request.target < soft
    assert exact.choice is not None


def test_a_solver_with_few_iterations_is_told(tmp_path: Path) -> None:
    """The file's single iteration leaves a projected Gauss-Seidel solver far from its end."""
    path = Path(loop(tmp_path, iterations=1))
    path.write_text(path.read_text().replace("iterations", 'solver="PGS" iterations'))
    advice = advised(str(path), horizon=0.1, target=1e-3)
    errors = [(setting_of(one).iterations, one.error) for one in advice.trials]
    assert {count for count, _ in errors} == {None, 8, 32, 128}
    one, many = (min(error for n, error in errors if n == count) for count in (None, 128))
    assert many < one


def test_a_stiff_arm_has_a_converged_run_of_shorter_steps(tmp_path: Path) -> None:
    advice = advised(written(tmp_path, kp="20000", damping="200"), horizon=0.05, target=1e-5)
    assert advice.truths
    assert advice.truths[0].setting.step < 0.99 * 0.002 / 32


@pytest.mark.usefixtures("own_folder")
def test_runs_go_on_where_they_ended(tmp_path: Path) -> None:
    file = written(tmp_path)
    options = f"tradeoff {file} --horizon 0.05 --seed 0 --resume runs.json"
    request = TradeoffRequest((file,), horizon=0.05, seed=0, resume="runs.json")
    advice = ModelTradeoff(request)
    work = advice.work()
    for done, total, _ in work:
        if done > total // 2:  # as if interrupted
            break
    work.close()
    half = json.loads(Path("runs.json").read_text())["entries"]
    succeeds(options)
    whole = json.loads(Path("runs.json").read_text())["entries"]
    assert half.items() <= whole.items()
    assert len(half) < len(whole)
    again = succeeds(f"{options} --json again.json")
    assert json.loads(Path("runs.json").read_text())["entries"] == whole
    assert again == succeeds(options)
    for change, said in (
        ("--horizon 0.06", "holds runs of another horizon"),
        ("--seed 1", "holds runs of another seed"),
    ):
        assert said in refusal(f"{options} {change}")
    assert "holds runs of another model" in refusal(options.replace(file, loop(tmp_path)))
    broken = json.dumps(
        json.loads(Path("runs.json").read_text()) | {"entries": {key: {} for key in whole}}
    )
    for text in ("[]", broken):
        Path("runs.json").write_text(text)
        assert "holds no runs" in refusal(options)
    assert "cannot both go" in refusal(f"{options} --json runs.json")
