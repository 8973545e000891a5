"""Drake, plugged in as anyone would: right on trees, and what its reader drops."""

from __future__ import annotations

import logging
import re
from typing import Any

import numpy as np
import pydrake.all as drake
import pytest

from mbcheck.comparisons.engines.adapter import Adapter, adapt
from mbcheck.comparisons.reports.run.located import located
from mbcheck.examples.drake_engine import DrakeEngine
from mbcheck.reference import get_scene
from mbcheck.tests.support.engines.examples import PLACES, QUICK, TOO_FINE, results

TREES = ("hula_hoop", "rotor_pendulum")
CHAIN = pytest.param("rotating_beam", marks=pytest.mark.slow)

pytestmark = pytest.mark.foreign


def engine(kind: type = DrakeEngine) -> Adapter:
    return adapt("drake", kind)


def text_of(scene: str) -> str:
    model, case, _ = PLACES[scene]
    return engine().bind(get_scene(scene).case(case), model).text


def plant_of(text: str) -> Any:
    plant = drake.MultibodyPlant(0.0)
    drake.Parser(plant).AddModelsFromString(text, "xml")
    plant.Finalize()
    return plant


@pytest.mark.parametrize("scene", [*TREES, CHAIN])
def test_it_is_right_on_every_level(scene: str) -> None:
    found = results(engine(), scene, QUICK)
    assert {item.verdict for item in found if item.quantity != TOO_FINE} == {"pass"}
    assert {item.kind for item in found if item.verdict == "pass"} >= {"algebra", "parts"}


@pytest.mark.parametrize("scene", [*TREES, CHAIN])
def test_its_runs_are_right(scene: str) -> None:
    found = results(engine(), scene, ("trajectory", "order", "energy"))
    assert {item.verdict for item in found} == {"pass"}


def test_it_has_no_loops() -> None:
    found = results(engine(), "speed_regulator", QUICK)
    assert {item.verdict for item in found} == {"skipped"}
    assert "a continuous plant of Drake has no constraints" in {item.reason for item in found}


@pytest.mark.parametrize("scene", ["rigid_body", "ball_hoop", "floating_platform", "floating_beam"])
def test_joints_in_space_are_refused(scene: str) -> None:
    found = results(engine(), scene, ("parts", "algebra", "frequency"))
    why = "ball and free joints, whose coordinates differ in Drake"
    assert {(item.verdict, item.reason) for item in found} == {("skipped", why)}


class Twice(DrakeEngine):
    """With the dampers that its reader has read, and those of the file as well."""

    def load(self, system: Any) -> Any:
        loaded = super().load(system)
        self.force = system.force
        return loaded


def test_dampers_that_count_twice_are_named() -> None:
    found = located(results(engine(Twice), "hula_hoop", ("parts",)))
    assert any("damper of theta: counted 2 times" in line for line in found), found


class Bare(DrakeEngine):
    """Without the armatures, as its reader leaves them."""

    def plant(self, system: Any) -> Any:
        return plant_of(system.mjcf)


def test_armatures_that_its_reader_drops_are_named() -> None:
    found = located(results(engine(Bare), "hula_hoop", ("parts",)))
    assert any("armature of foot: dropped" in line for line in found), found


@pytest.mark.parametrize("step", [2**-10, 1e-3, 1 / 384])
def test_it_counts_as_many_steps_as_were_asked_for(step: float) -> None:
    one = engine()
    system = one.bind(get_scene("hula_hoop").cases[0], "tree").system(
        get_scene("hula_hoop").cases[0]
    )
    times = system.start_time + step * np.linspace(0, 192, 25)
    for method in one.methods:
        motion = one.inner.simulate(system, method, step, times)
        assert motion.steps == 192
        assert motion.rhs_evaluations == 192 * (method.evaluations_per_step or 0)
        assert motion.clock == pytest.approx(times, abs=0, rel=1e-15)


class Exact(DrakeEngine):
    """With no longer step than was asked for."""

    stretch = 1.0


def test_without_a_longer_step_it_takes_slivers() -> None:
    one = engine(Exact)
    system = one.bind(get_scene("hula_hoop").cases[0], "tree").system(
        get_scene("hula_hoop").cases[0]
    )
    motion = one.inner.simulate(system, one.methods[0], 1 / 384, np.array([0.0, 0.5]))
    assert motion.steps is not None
    assert motion.steps > 192


def test_the_reader_still_drops_what_the_page_says(caplog: pytest.LogCaptureFixture) -> None:
    texts = [text_of(scene) for scene in ("rotor_pendulum", "speed_regulator", "hula_hoop")]
    with caplog.at_level(logging.WARNING, "drake"):
        *_, plant = map(plant_of, texts)
    told = set(re.findall(r"The (?:tag|attribute) '(\w+)'", caplog.text))
    assert {"stiffness", "springref", "tendon", "general", "site"} <= told
    assert "connect node uses the site1 and site2 specification" in caplog.text
    assert not {"armature", "damping", "ref"} & told
    assert plant.CalcMassMatrix(plant.CreateDefaultContext())[0, 0] == 1e-3
    assert plant.GetJointByName("y").default_damping() > 0


def test_its_reader_still_exits_at_a_body_without_mass() -> None:
    body = '<body><inertial pos="0 0 0" mass="0" diaginertia="0 0 0"/><joint/></body>'
    with pytest.raises(SystemExit, match="condition 'mass > 0' failed"):
        plant_of(f'<mujoco model="a"><worldbody>{body}</worldbody></mujoco>')
