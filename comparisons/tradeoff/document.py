"""The documents of ``tradeoff``: of scenes, and of an MJCF file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .table import SettingRun, StepSeries


@dataclass(frozen=True)
class ModelStart:
    """A start from which runs of a file are compared.

    Attributes
    ----------
    name : str
        state of the file, and whether controls move
    compared : float
        time over which runs are compared [s]
    smooth : bool
        whether no contact, limit or friction acted
    integrator : str
        of the converged run
    step : float
        of the converged run [s]
    bound : float
        relative change of the converged run with half its step
    spread : float
        relative change with a start that is 1e-6 off
    """

    name: str
    compared: float
    smooth: bool
    integrator: str
    step: float
    bound: float
    spread: float


@dataclass(frozen=True)
class TradeoffModelDocument:
    """What accuracy costs of an MJCF file.

    Attributes
    ----------
    file : str
        name of the file
    target : float
        relative error allowed
    asked : float
        horizon that was asked for [s]
    horizon : float
        over which all starts are compared [s]
    budget : float
        time to try settings in [s]
    seed : int
        of the controls that move
    observed : sequence of str
        joints and sites that are judged; empty: all joints
    exact_closures : bool
        whether loops count as closed exactly, not as soft as in the file
    softness : float or None
        how far closures as soft as in the file go from hard ones [1]; null: none
    met : bool
        whether a setting meets the target with a margin
    sentence : str
        what to do
    notes : sequence of str
        what else is to be known
    complete : bool
        whether the time was enough
    starts : sequence of ModelStart
        from where runs are compared
    unknown : sequence of str
        starts that were left out, with their reasons
    series : sequence of StepSeries
        all that were tried, by integrator and settings
    front : sequence of SettingRun
        those that none beats in error and time, the fastest first
    own : SettingRun or None
        the file's own setting
    recommendation : SettingRun or None
        the one to choose
    """

    file: str
    target: float
    asked: float
    horizon: float
    budget: float
    seed: int
    observed: Sequence[str]
    exact_closures: bool
    softness: float | None
    met: bool
    sentence: str
    notes: Sequence[str]
    complete: bool
    starts: Sequence[ModelStart]
    unknown: Sequence[str]
    series: Sequence[StepSeries]
    front: Sequence[SettingRun]
    own: SettingRun | None
    recommendation: SettingRun | None
    versions: Mapping[str, str]
