"""What accelerations alone tell: how soft a loop is, and forces that only motion shows."""

from __future__ import annotations

import warnings
from typing import Any

import pytest

import mbcheck
from mbcheck.comparisons.checks.suite import run_check
from mbcheck.comparisons.faults.mujoco import Edited
from mbcheck.tests.support.engines.reading import Reader
from mbcheck.tests.support.engines.solved import Solved
from mbcheck.tests.support.example import bad, results
from mbcheck.tests.support.subjects import Subject, check_of

LOOP = Subject("speed_regulator", "mujoco", "connect", "RK4")


@pytest.mark.parametrize(
    ("solref", "what"),
    [
        ("0.0202 1", "stiffness and damping"),
        ("0.02 1.01", "stiffness"),
        ("-2500 -106.3", "stiffness and damping"),
    ],
)
def test_another_softness_of_a_loop_is_named_by_accelerations(solref: str, what: str) -> None:
    """With the loop closed nothing shows it."""
    wrong = Edited(('solref="0.02 1"', f'solref="{solref}"'))
    (one, *more) = bad(run_check(check_of(LOOP, "algebra", "rotation"), engine=wrong))
    assert {item.quantity for item in (one, *more)} == {"accelerations"}
    assert one.cause
    assert one.cause.startswith(f"the loop has another {what} than the file says")


class Still(Solved):
    """The scene's equations without what motion, or damping, makes of its accelerations."""

    name = "still"

    def __init__(self, odd: bool) -> None:
        super().__init__(mbcheck.Method("RK4", 4, "RK44"))
        self.odd = odd

    def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
        """Return accelerations less their part that is odd, or even, in the velocities."""
        ahead, back, rest = (
            super(Still, self).accelerations(system, time, q, factor * v) for factor in (1, -1, 0)
        )
        return (ahead + back) / 2 if self.odd else rest + (ahead - back) / 2


@pytest.mark.parametrize(("odd", "what"), [(False, "Coriolis forces"), (True, "dampers")])
def test_what_is_wrong_in_motion_alone_is_told(odd: bool, what: str) -> None:
    found = bad(results(Still(odd), "hula_hoop", ("algebra",), "point_mass_3hz_60n"))
    (said,) = {one.cause for one in found}
    assert said
    assert said.startswith("accelerations are right at rest, and wrong in motion")
    assert said.endswith(f": {what} are missing or wrong")


class Huge(Solved):
    """Accelerations that no 32 bits hold."""

    def accelerations(self, *asked: Any) -> Any:
        """Return them times 1e200."""
        return 1e200 * super().accelerations(*asked)


def test_huge_numbers_leave_no_warning_on_the_console() -> None:
    pushed = Reader(push=lambda time, q, v: 1e200 * v)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert bad(results(pushed, "hula_hoop", ("parts", "algebra")))
        huge = Huge(mbcheck.Method("RK4", 4, "RK44"))
        assert bad(results(huge, "hula_hoop", ("algebra",)))
