"""What a sweep over steps found: points, and the series that they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

STEP, MODEL, ROUND_OFF, FAILED = "step-limited", "model-limited", "round-off", "failed"
LABELS = (STEP, MODEL, ROUND_OFF, FAILED)

UNEXPLAINED = "unexplained"
"""Name of a plateau that a right model by a method without a solver has no reason for."""

TARGETS = (1e-2, 1e-3, 1e-4)
"""Relative errors that settings are recommended for by default."""


@dataclass(frozen=True)
class Cost:
    """What a run costs per simulated second.

    Attributes
    ----------
    seconds : float
        Wall time of the stepping [s/s], the median of repeated runs, on this machine.
    fastest, slowest : float
        Of these runs.
    steps : float
    rhs_evaluations, newton_iterations : float or None
        None where the engine does not tell. Counts are what may be compared across machines.
    """

    seconds: float
    fastest: float
    slowest: float
    steps: float
    rhs_evaluations: float | None
    newton_iterations: float | None


@dataclass(frozen=True)
class Point:
    """One run: its error, and what it costs.

    Attributes
    ----------
    step : float
        [s]
    error : float or None
        Against the scene's reference: the largest of all observables over all samples,
        relative to their sizes; None if the run failed.
    errors : mapping of str to float
        By observable.
    cost : Cost or None
    label : str
        One of `LABELS`.
    limit : str
        What limits it, in words: ``step``, or the name of the plateau.
    wasted : bool
        A longer step has the same error.
    reason : str
        Why it failed.
    """

    step: float
    error: float | None
    errors: Mapping[str, float] = field(default_factory=dict)
    cost: Cost | None = None
    label: str = FAILED
    limit: str = ""
    wasted: bool = False
    reason: str = ""


@dataclass(frozen=True)
class StepSeries:
    """A method of an engine on a model over steps, the longest first.

    Attributes
    ----------
    scene, case, engine, model, method : str
    order : int
        Declared.
    settings : mapping of str to float
        Options that are not at their default, and ``segments`` of a continuum.
    points : tuple of Point
    slope : float or None
        Order fitted to the points that are step-limited; None if fewer than two are.
    plateau : float or None
        Error that no step removes; None where none was reached.
    plateau_name : str
        ``closure softness``, ``inertia floor``, ``spatial discretisation``, ``continuum``,
        ``round-off``, ``solver tolerance`` or `UNEXPLAINED`. No clock rounds: all steps are
        powers of two.
    stable_step : float or None
        Longest step that keeps free vibrations bounded over many periods, by theory [s]; None
        if there is none, or no theory is known.
    """

    scene: str
    case: str
    engine: str
    model: str
    method: str
    order: int
    settings: Mapping[str, float]
    points: tuple[Point, ...]
    slope: float | None = None
    plateau: float | None = None
    plateau_name: str = ""
    stable_step: float | None = None
