"""The trajectory that tests judge, by the reference and by an engine."""

import pytest

from mbcheck.comparisons.queries.simulate import Simulation, simulate
from mbcheck.tests.support.trajectory import START, TIMES, run


@pytest.fixture(scope="package")
def truth() -> Simulation:
    """Return the reference's trajectory."""
    return simulate("hula_hoop", state=START, times=TIMES)


@pytest.fixture(scope="package")
def simulated() -> Simulation:
    """Return MuJoCo's trajectory."""
    return run()
