"""DART, plugged in as anyone would: right on trees, and what its reader drops."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.adapter import Adapter, adapt
from mbcheck.comparisons.reports.run.located import located
from mbcheck.examples import dart_engine
from mbcheck.examples.dart_engine import DartEngine
from mbcheck.reference.errors import MbcheckError
from mbcheck.tests.support.engines.examples import QUICK, TOO_FINE, results

TREES = ("hula_hoop", "rotor_pendulum", "ball_hoop")

pytestmark = pytest.mark.foreign


def engine() -> Adapter:
    return adapt("dart", DartEngine)


@pytest.mark.parametrize("scene", TREES)
def test_it_is_right_on_every_level(scene: str) -> None:
    found = results(engine(), scene, QUICK)
    assert {item.verdict for item in found if item.quantity != TOO_FINE} == {"pass"}
    assert {item.kind for item in found} >= {"algebra", "parts", "step", "frequency"}


@pytest.mark.parametrize("scene", TREES)
def test_its_runs_are_right(scene: str) -> None:
    found = results(engine(), scene, ("trajectory", "order"))
    assert {item.verdict for item in found} == {"pass"}


def test_it_has_neither_loops_nor_armatures() -> None:
    for scene, why in (
        ("speed_regulator", "DART closes loops by impulses that depend on the step"),
        ("rotating_beam", "DART has no armature"),
    ):
        found = results(engine(), scene, ("parts", "algebra"))
        assert {(item.verdict, item.reason) for item in found} == {("skipped", why)}


def test_inertias_that_its_reader_drops_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dart_engine, "tensor", lambda inertial: np.eye(3))
    found = located(results(engine(), "hula_hoop", ("parts",)))
    assert any("inertia of rod: counted" in line for line in found), found


def test_orientations_that_its_reader_drops_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dart_engine, "with_positions", lambda text: text)
    for scene, deviate in (("hula_hoop", False), ("rotor_pendulum", True)):
        found = results(engine(), scene, ("parts", "algebra"))
        assert any(item.verdict == "deviation" for item in found) == deviate


def test_a_body_without_inertial_is_refused_in_words(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    body = '<body name="cart"><joint name="slide" type="slide"/><geom size=".1"/></body>'
    file.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    with pytest.raises(MbcheckError, match="body cart has no inertial"):
        mbcheck.compare(file, f"{file}@mbcheck.examples.dart_engine:DartEngine")
