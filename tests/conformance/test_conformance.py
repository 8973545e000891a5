"""The comparisons as tests: what ``mbcheck check`` runs, one test for each check.

The options are those of the pytest plugin, `mbcheck.comparisons.cli.pytest_plugin`.
"""

from __future__ import annotations

import pytest

from mbcheck.comparisons.checks.suite import Check
from mbcheck.comparisons.cli.pytest_plugin import parametrize, run_test


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    parametrize(metafunc)


def test_check(check: Check, request: pytest.FixtureRequest) -> None:
    run_test(check, request.node)
