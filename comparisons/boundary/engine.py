"""The periodic orbits of an engine, as curves over two parameters.

An engine is a stepper: its map is that of a fixed number of steps in a period. Newton's method takes
the slopes of the reference's equations, mended by secants, so that a point costs an engine the runs
of a difference for each iteration, and no more.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...reference.continuation.bifurcations import Family, OrbitCurve, PeriodFlow
from ...reference.continuation.curve import correct
from ...reference.continuation.network import Point, Tracer
from ...reference.errors import EngineError
from ...reference.scene import Array, Case
from ..checks.orbits import ORDER, PERTURBATION
from ..engines.run import run_many
from ..engines.setup import Setup


@dataclass
class EngineTracer(Tracer):
    """Follows curves of an engine's orbits.

    Attributes
    ----------
    setup : Setup
    per_period : int
        Its steps in a period.
    problems : list of str
        Why runs failed.
    """
