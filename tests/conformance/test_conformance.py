"""The comparisons as tests: what ``mbcheck check`` runs, one test for each check.

The options are those of the pytest plugin, `mbcheck.comparisons.pytest_plugin`.
"""

from __future__ import annotations

import pytest

from mbcheck.comparisons.pytest_plugin import parametrize, run_test
from mbcheck.comparisons.suite import Check


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    parametrize(metafunc)


def test_check(check: Check, request: pytest.FixtureRequest) -> None:
    run_test(check, request.node)
