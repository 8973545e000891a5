"""Pinocchio, plugged in as anyone would: right on trees and on the closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.adapter import Adapter, adapt
from mbcheck.comparisons.reports.run.located import located
from mbcheck.examples import pinocchio_engine
from mbcheck.examples.pinocchio_engine import PinocchioEngine
from mbcheck.reference import get_scene
from mbcheck.tests.support.engines.examples import PLACES, QUICK, TOO_FINE, results

FREE = ("floating_platform", "floating_beam")
SERVED = tuple(scene for scene in PLACES if scene not in FREE)

pytestmark = pytest.mark.foreign


def engine(kind: type = PinocchioEngine) -> Adapter:
    return adapt("pinocchio", kind)


@pytest.mark.parametrize("scene", SERVED)
def test_it_is_right_on_every_level(scene: str) -> None:
    found = results(engine(), scene, QUICK)
    assert {item.verdict for item in found if item.quantity != TOO_FINE} == {"pass"}
    ran = {item.kind for item in found}
    assert ran >= {"algebra", "step"} or scene == "rotating_beam"
    assert "frequency" in ran


@pytest.mark.parametrize("scene", SERVED)
def test_its_runs_are_right(scene: str) -> None:
    found = results(engine(), scene, ("trajectory", "order", "energy"))
    assert {item.verdict for item in found} == {"pass"}


@pytest.mark.parametrize("scene", FREE)
def test_free_joints_are_refused(scene: str) -> None:
    found = results(engine(), scene, ("parts", "algebra"))
    why = "free joints, whose velocities Pinocchio has in the body's frame"
    assert {(item.verdict, item.reason) for item in found} == {("skipped", why)}


class Plain(PinocchioEngine):
    """With a gravity of its own, turned into the plane of the scenes."""

    def load(self, system: Any) -> Any:
        loaded = super().load(system)
        loaded[0].gravity = self.pin.Motion(np.array([0, -9.81, 0]), np.zeros(3))
        return loaded


def test_a_gravity_of_its_own_is_named() -> None:
    found = located(results(engine(Plain), "speed_regulator", ("parts",)))
    assert any("gravity of 9.81 m/s^2, where the file has none" in line for line in found), found


def test_bodies_that_its_reader_drops_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pinocchio_engine, "below_one_body", lambda text: text)
    found = results(engine(), "hula_hoop", ("parts",))
    assert {item.verdict for item in found} == {"skipped"}
    assert {item.reason for item in found} == {"Pinocchio read the joints ['foot']"}


def test_the_reader_still_drops_what_the_page_says(tmp_path: Path) -> None:
    import pinocchio

    file = tmp_path / "model.xml"
    file.write_text(
        engine()
        .bind(get_scene("hula_hoop").cases[0], "tree")
        .system(get_scene("hula_hoop").cases[0])
        .mjcf,
        encoding="utf-8",
    )
    model = pinocchio.buildModelFromMJCF(str(file))
    assert list(model.names) == ["universe", "foot"]
    assert model.gravity.linear[2] == -9.81
