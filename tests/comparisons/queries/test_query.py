"""What all queries refuse, in the words that they refuse it with."""

from collections.abc import Callable

import numpy as np
import pytest

import mbcheck
from mbcheck.reference.errors import (
    ParameterError,
    UnknownNameError,
    UsageError,
)

Refused = tuple[Callable[[], object], type[Exception], str]

REFUSED: list[Refused] = [
    (lambda: mbcheck.simulate("hula_hop", times=[1]), UnknownNameError, "'hula_hoop'"),
    (
        lambda: mbcheck.simulate(
            "hula_hoop", engine="exudyn", method="RK44", model="redundant", times=[1]
        ),
        UsageError,
        "GeneralizedAlpha",
    ),
    (
        lambda: mbcheck.simulate("hula_hoop", parameters={"main_mass": [1, 2]}, times=[1]),
        ParameterError,
        "must be a number",
    ),
    (lambda: mbcheck.simulate("hula_hoop", times=[]), UsageError, "not empty"),
    (lambda: mbcheck.simulate("hula_hoop", times=[0]), UsageError, "nothing to simulate"),
    (lambda: mbcheck.simulate("hula_hoop", times=[1e-320]), UsageError, "must be 1e-150 s or more"),
    (
        lambda: mbcheck.simulate("rigid_body", parameters={"axes_x": 1e12}, times=[1]),
        ParameterError,
        "axes_x must be an angle of 1e\\+09 rad at most",
    ),
    (lambda: mbcheck.simulate("hula_hoop", times=np.ones((2, 2))), UsageError, "one row"),
    (lambda: mbcheck.simulate("hula_hoop", times=["a"]), UsageError, "numbers"),  # type: ignore[list-item]
    (lambda: mbcheck.frequencies("hula_hoop", count=0), UsageError, "1 or more"),
    (lambda: mbcheck.orbit("hula_hoop", step=0.1), UsageError, "its own steps"),
    (lambda: mbcheck.orbit("hula_hoop", engine="mujoco", step=0.1), UsageError, "too long"),
    (lambda: mbcheck.orbit("hula_hoop", engine="mujoco", step=1e-3), UsageError, "nearest that do"),
]
"""What the command line cannot ask, or asks in `tests/comparisons/cli/test_cli.py` otherwise."""


@pytest.mark.parametrize("refused", REFUSED)
def test_refused(refused: Refused) -> None:
    call, error, words = refused
    with pytest.raises(error, match=words):
        call()
