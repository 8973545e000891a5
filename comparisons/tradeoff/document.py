"""The documents of ``tradeoff``: of scenes, and of an MJCF file."""

from __future__ import annotations

from typing import Annotated, TypedDict

from ..documents.core import Version, Versions, means
from .table import Choice, StepSeries


class SettingRun(TypedDict):
    """One setting, run."""

    engine: Annotated[str, means("engine")]
    model: Annotated[str, means("model; empty of a file")]
    method: Annotated[str, means("integrator")]
    settings: Annotated[dict[str, float], means("as of a series")]
    step: Annotated[float, means("[s]")]
    error: Annotated[float | None, means("error; null if the run failed")]
    seconds: Annotated[float, means("time per simulated second [s/s]")]


class TradeoffDocument(TypedDict):
    """What accuracy costs of scenes."""

    schema: Version
    versions: Versions
    targets: Annotated[list[float], means("relative errors that settings are recommended for [1]")]
    series: Annotated[
        list[StepSeries],
        means(
            "a method of an engine on a model over steps; models from small to large; and by how "
            "much a method shifts where a periodic orbit loses its stability"
        ),
    ]
    pareto: Annotated[
        dict[str, list[SettingRun]],
        means("by scene: settings that none beats in both error and time, the cheapest first"),
    ]
    recommendations: Annotated[
        list[Choice],
        means(
            "for each scene, engine and target: the cheapest setting, and the smallest models, or "
            "why there is none"
        ),
    ]
    failures: Annotated[list[str], means("what came to nothing, and why")]


class ModelStart(TypedDict):
    """A start from which runs of a file are compared."""

    name: Annotated[str, means("state of the file, and whether controls move")]
    compared: Annotated[float, means("time over which runs are compared [s]")]
    smooth: Annotated[bool, means("whether no contact, limit or friction acted")]
    integrator: Annotated[str, means("of the converged run")]
    step: Annotated[float, means("of the converged run [s]")]
    bound: Annotated[float, means("relative change of the converged run with half its step")]
    spread: Annotated[float, means("relative change with a start that is 1e-6 off")]


class TradeoffModelDocument(TypedDict):
    """What accuracy costs of an MJCF file."""

    schema: Version
    file: Annotated[str, means("name of the file")]
    target: Annotated[float, means("relative error allowed")]
    asked: Annotated[float, means("horizon that was asked for [s]")]
    horizon: Annotated[float, means("over which all starts are compared [s]")]
    budget: Annotated[float, means("time to try settings in [s]")]
    seed: Annotated[int, means("of the controls that move")]
    observed: Annotated[list[str], means("joints and sites that are judged; empty: all joints")]
    exact_closures: Annotated[
        bool, means("whether loops count as closed exactly, not as soft as in the file")
    ]
    softness: Annotated[
        float | None,
        means("how far closures as soft as in the file go from hard ones [1]; null: none"),
    ]
    met: Annotated[bool, means("whether a setting meets the target with a margin")]
    sentence: Annotated[str, means("what to do")]
    notes: Annotated[list[str], means("what else is to be known")]
    complete: Annotated[bool, means("whether the time was enough")]
    starts: Annotated[list[ModelStart], means("from where runs are compared")]
    unknown: Annotated[list[str], means("starts that were left out, with their reasons")]
    series: Annotated[list[StepSeries], means("all that were tried, by integrator and settings")]
    front: Annotated[
        list[SettingRun], means("those that none beats in error and time, the fastest first")
    ]
    own: Annotated[SettingRun | None, means("the file's own setting")]
    recommendation: Annotated[SettingRun | None, means("the one to choose")]
    versions: Versions
