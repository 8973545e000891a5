"""What a scene's folder tells the features, and what it leaves out."""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from mbcheck.comparisons import scenes
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.reference import Undeclared
from mbcheck.comparisons.scenes import data
from mbcheck.comparisons.scenes.data import scene_data
from mbcheck.comparisons.scenes.quantity import NO_VALUE, QuantityValues
from mbcheck.reference import get_scene
from mbcheck.reference.errors import UnknownNameError


@pytest.fixture
def newcomer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A scene whose folder is empty."""
    folder = tmp_path / "newcomer"
    folder.mkdir()
    monkeypatch.setattr(scenes, "__path__", [*scenes.__path__, str(tmp_path)])
    monkeypatch.setattr(data, "SCENES", ("newcomer",))
    yield folder
    for name in [name for name in sys.modules if ".newcomer" in name]:
        del sys.modules[name]


def test_a_table_that_is_filled_is_read(newcomer: Path) -> None:
    (newcomer / "maps.py").write_text("QUANTITIES = {'height': 1}\n")
    assert scene_data("newcomer", "maps", "QUANTITIES", {}) == {"height": 1}


def test_a_module_or_a_table_that_is_missing_is_empty(newcomer: Path) -> None:
    assert scene_data("newcomer", "extremes", "STARTS", ()) == ()
    (newcomer / "maps.py").write_text("AXES = {}\n")
    assert scene_data("newcomer", "maps", "QUANTITIES", None) is None


def test_a_module_that_cannot_be_imported_is_no_empty_one(newcomer: Path) -> None:
    (newcomer / "extremes.py").write_text("import no_such_module\n")
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        scene_data("newcomer", "extremes", "STARTS", None)


def test_a_scene_that_is_none_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="pendulum"):
        scene_data("pendulum", "maps", "AXES", {})


def test_no_value_where_an_engine_failed() -> None:
    values = {"kind": np.array([1, 2, 3]), "height": [0.5, 1.5, 2.5], "robust": np.ones(3, int)}
    found = QuantityValues.of(values, {1: "it exploded"})
    np.testing.assert_array_equal(found.values["kind"], [1, NO_VALUE, 3])
    np.testing.assert_array_equal(found.values["height"], [0.5, np.nan, 2.5])
    np.testing.assert_array_equal(found.values["robust"], [1, 0, 1])
    assert found.problems == {1: "it exploded"}


def test_the_reference_undone_declares_no_theory() -> None:
    """It runs a simplified theory as the exact one, and says nothing."""
    case = get_scene("rotating_beam").cases[0]
    second_order = "second_order"
    assert get_engine("reference").bind(case, second_order).own_equations is not None
    assert Undeclared().bind(case, second_order).own_equations is None
