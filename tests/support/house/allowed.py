"""What the rules of the house allow, each with its reason."""

from __future__ import annotations

from collections.abc import Mapping

ALLOWED: Mapping[str, Mapping[str, str]] = {
    "large_classes": {
        "reference/scene.py::Dynamics": "solvers must know when its drive ends",
        "reference/rotating_beam/parameters.py::RotatingBeam": "the parameters of its two papers",
    },
    "patched_constants": {
        "tests/comparisons/engines/test_isolation.py::STATM": "a platform without /proc",
    },
}
"""Rule -> what breaks it (as ``python -m mbcheck.tests.support.house`` names it) -> why it may."""

PENDING: Mapping[str, int] = {
    "long_modules": 13,
    "large_classes": 4,
    "long_signatures": 18,
    "scenes_by_name": 10,
    "engines_by_name": 12,
    "asked_engines": 2,
    "upward_imports": 1,
    "broad_excepts": 20,
    "module_caches": 1,
    "patched_constants": 5,
    "shared_names": 62,
    "private_words": 200,
}
"""Rule -> how often it is still broken beside that. Only ever lower these numbers."""
