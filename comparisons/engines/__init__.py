"""Engines: the protocol, the guard around a run, the registry, adapters."""

from __future__ import annotations

import os

REFERENCE = "reference"
"""Name of the engine that the others are checked against."""

THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Environment variables from which libraries of linear algebra take their number of threads."""


def use_one_thread() -> None:
    """Let linear algebra run in one thread, unless the user's environment says otherwise.

    Sums then have one order on any number of cores, and processes do not compete for them. The
    libraries look at the variables once, as they are loaded: call this before NumPy is imported.
    Processes that are started later inherit them.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")
