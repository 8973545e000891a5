"""Sample times, and the step on whose grid they lie."""

from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.queries.simulate import step_for
from mbcheck.reference.errors import (
    UsageError,
)


@pytest.mark.parametrize(
    ("times", "longest", "step"),
    [
        ([0.5, 1.0], 2**-10, 2**-10),
        ([0.1, 0.25], 2**-10, 0.05 / 52),
        (np.arange(31) * 0.1, 2**-10, 0.1 / 103),
        ([1 / 3, 2 / 3], 2**-10, 1 / 3 / 342),
        ([0.0, 7.3], 0.5, 7.3 / 15),
        ([1e-4], 2**-10, 1e-4),
    ],
)
def test_default_step_fits_the_times(times: Any, longest: float, step: float) -> None:
    times = np.array(times, dtype=float)
    found = step_for(times, longest)
    assert found == pytest.approx(step, rel=1e-14)
    np.testing.assert_allclose(times / found, np.rint(times / found), atol=1e-9)


@pytest.mark.parametrize("times", [[0.5, np.pi], [1e-9, 1.0], [1e9]])
def test_times_without_a_grid_are_refused(times: list[float]) -> None:
    with pytest.raises(UsageError, match="choose"):
        step_for(np.array(times), 2**-10)
