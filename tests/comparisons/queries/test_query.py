"""What all queries refuse, in the words that they refuse it with."""

from collections.abc import Callable

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.queries.query import mjcf_text
from mbcheck.reference.errors import (
    ParameterError,
    UnknownNameError,
    UsageError,
)

Refused = tuple[Callable[[], object], type[Exception], str]

REFUSED: list[Refused] = [
    (lambda: mbcheck.simulate("hula_hop", times=[1]), UnknownNameError, "'hula_hoop'"),
    (
        lambda: mbcheck.simulate("hula_hoop", engine="mujco", times=[1]),
        UnknownNameError,
        "'mujoco'",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", engine="mujoco", method="RK5", times=[1]),
        UnknownNameError,
        "'RK4'",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", engine="exudyn", model="redundnt", times=[1]),
        UnknownNameError,
        "'redundant'",
    ),
    (
        lambda: mbcheck.simulate(
            "hula_hoop", engine="exudyn", method="RK44", model="redundant", times=[1]
        ),
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
        lambda: mbcheck.simulate("hula_hoop", engine="mujoco", step=np.nan, times=[1]),
        ParameterError,
        "step must be",
    ),
    (lambda: mbcheck.simulate("hula_hoop", times=[]), UsageError, "not empty"),
    (lambda: mbcheck.simulate("hula_hoop", times=[0]), UsageError, "nothing to simulate"),
    (lambda: mbcheck.simulate("hula_hoop", times=[1e-320]), UsageError, "must be 1e-150 s or more"),
    (
        lambda: mbcheck.simulate("rigid_body", parameters={"axes_x": 1e12}, times=[1]),
        ParameterError,
        "axes_x must be an angle of 1e\\+09 rad at most",
    ),
    (lambda: mbcheck.simulate("hula_hoop", times=[2, 1]), UsageError, "increase"),
    (lambda: mbcheck.simulate("hula_hoop", times=np.ones((2, 2))), UsageError, "one row"),
    (lambda: mbcheck.simulate("hula_hoop", times=["a"]), UsageError, "numbers"),  # type: ignore[list-item]
    (
        lambda: mbcheck.frequencies("hula_hoop", about="rod_alinged"),
        UnknownNameError,
        "'rod_aligned'",
    ),
    (lambda: mbcheck.frequencies("hula_hoop", count=0), UsageError, "1 or more"),
    (lambda: mbcheck.orbit("hula_hoop", step=0.1), UsageError, "its own steps"),
    (lambda: mbcheck.orbit("hula_hoop", engine="mujoco", step=0.1), UsageError, "too long"),
    (lambda: mbcheck.orbit("hula_hoop", engine="mujoco", step=1e-3), UsageError, "nearest that do"),
    (lambda: mjcf_text("hula_hoop", model="tee"), UnknownNameError, "'tree'"),
]


@pytest.mark.parametrize("refused", REFUSED)
def test_refused(refused: Refused) -> None:
    call, error, words = refused
    with pytest.raises(error, match=words):
        call()
