"""Parameters, cases, scenes and errors refuse what is impossible."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from mbcheck.reference import get_scene
from mbcheck.reference.errors import (
    EngineError,
    MbcheckError,
    ParameterError,
    UnknownNameError,
)
from mbcheck.reference.hula_hoop.equations import (
    HulaHoop,
)

SCENE = get_scene("hula_hoop")


# Parameters, cases, scenes, errors -----------------------------------------------------

NAMES = HulaHoop.names()
NON_NEGATIVE = {
    "damping_ratio", "hinge_damping_ratio", "inertia_ratio", "force_amplitude"
}  # fmt: skip


BOUNDED = [name for name in NAMES if not name.startswith("gravity_")]


@pytest.mark.parametrize("name", BOUNDED)
@pytest.mark.parametrize(
    "value", [np.nan, np.inf, -np.inf, -1e-300, "heavy", None, 1j, [[1], [1, 2]]]
)
def test_impossible_value(name: str, value: Any) -> None:
    with pytest.raises(ParameterError, match=name):
        HulaHoop(**{name: value})


@pytest.mark.parametrize("name", BOUNDED)
def test_zero(name: str) -> None:
    if name in NON_NEGATIVE:
        assert getattr(HulaHoop(**{name: 0}), name) == 0.0
    else:
        with pytest.raises(ParameterError, match=f"{name} must be greater than 0"):
            HulaHoop(**{name: 0})


@pytest.mark.parametrize("name", BOUNDED)
def test_one_impossible_value_in_an_array(name: str) -> None:
    values: dict[str, Any] = {name: [1.0, 2.0]}
    good = HulaHoop(**values)
    np.testing.assert_array_equal(getattr(good, name), [1.0, 2.0])
    for bad in (-1.0, np.nan):
        with pytest.raises(ParameterError, match=name):
            HulaHoop(**(values | {name: [1.0, bad]}))


def test_replace() -> None:
    assert HulaHoop().replace(main_mass=2.0) == HulaHoop(main_mass=2.0)
    with pytest.raises(UnknownNameError, match=r"'main_mas'; did you mean 'main_mass'\?"):
        HulaHoop().replace(main_mas=2.0)
    with pytest.raises(UnknownNameError, match="known: main_mass, free_mass"):
        HulaHoop().replace(xyz=2.0)
    with pytest.raises(ParameterError, match="stiffness"):
        HulaHoop().replace(stiffness=-1.0)
    assert HulaHoop(**HulaHoop().as_dict()) == HulaHoop()


def test_state_by_name() -> None:
    assert SCENE.state_names == ("y", "theta", "y_dot", "theta_dot")
    np.testing.assert_array_equal(SCENE.state({"theta_dot": 2, "y": 1}), [1, 0, 0, 2])
    with pytest.raises(UnknownNameError, match=r"'theta_dott'; did you mean 'theta_dot'\?"):
        SCENE.state({"theta_dott": 1.0})
    for value in (np.nan, np.inf, "fast", None):
        with pytest.raises(ParameterError, match="initial theta"):
            SCENE.state({"theta": value})


def test_cases_by_name() -> None:
    assert SCENE.case("rod_aligned").name == "rod_aligned"
    with pytest.raises(UnknownNameError, match=r"did you mean 'rod_aligned'\?"):
        SCENE.case("rod_alined")
    names = [case.name for case in SCENE.cases]
    assert len(set(names)) == len(names)
    for case in SCENE.cases:
        assert case.scene == SCENE.name
        assert case.horizon > 0
        assert SCENE.state(case.state).shape == (4,)
    with pytest.raises(UnknownNameError, match=r"scene 'hula_hop'; did you mean 'hula_hoop'\?"):
        get_scene("hula_hop")


@pytest.mark.parametrize(
    "error", [UnknownNameError("scene", "a", ["b"]), EngineError("clock", "it went back")]
)
def test_errors_survive_a_process_boundary(error: MbcheckError) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
