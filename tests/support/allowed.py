"""What the rules of the house allow, each with its reason."""

from __future__ import annotations

from collections.abc import Mapping

ALLOWED: Mapping[str, Mapping[str, str]] = {
    "large_classes": {
        "reference/rotating_beam/parameters.py::RotatingBeam": "the parameters of its two papers",
    },
    "module_caches": {
        "comparisons/engines/registry.py::_named": "engines named as package.module:Class",
    },
}
"""Rule -> what breaks it (as ``python -m mbcheck.tests.support.house`` names it) -> why it may."""

PENDING: Mapping[str, int] = {
    "long_modules": 32,
    "large_classes": 9,
    "long_signatures": 42,
    "scenes_by_name": 20,
    "engines_by_name": 32,
    "asked_engines": 22,
    "upward_imports": 6,
    "broad_excepts": 24,
    "module_caches": 3,
    "patched_constants": 27,
    "shared_names": 70,
    "private_words": 450,
}
"""Rule -> how often it is still broken beside that. Only ever lower these numbers."""
