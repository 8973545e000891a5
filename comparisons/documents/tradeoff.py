"""The document of ``tradeoff``."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from .core import Positive, Version, Versions, means

Number = float | None
Settings = dict[str, float]

# Sweeps ---------------------------------------------------------------------------------------

Cost = TypedDict(
    "Cost",
    {
        "seconds": Annotated[
            float,
            means(
                "time of the stepping on this machine [s/s], the median of repeated runs: wall "
                "time of a scene, processor time of a file"
            ),
        ],
        "fastest": Annotated[float, means("of these runs [s/s]")],
        "slowest": Annotated[float, means("of these runs [s/s]")],
        "steps": Annotated[float, means("steps [1/s]")],
        "rhs_evaluations": Annotated[
            Number, means("evaluations of the forces [1/s]; null if not counted")
        ],
        "newton_iterations": Annotated[
            Number, means("Newton iterations [1/s]; null if there are none, or not counted")
        ],
    },
)

Point = TypedDict(
    "Point",
    {
        "step": Annotated[Number, means("[s]; null where equations are compared")],
        "value": Annotated[Number, means("on an axis that is not the step; null otherwise")],
        "error": Annotated[Number, means("largest of all observables; null if the run failed")],
        "bound": Annotated[Number, means("uncertainty of the error; null if not known")],
        "errors": Annotated[
            dict[str, Number],
            means(
                "by observable; a shift with its sign; of a file `energy`, the largest difference "
                "over the largest kinetic energy [1], and `violation`, the largest residual of an "
                "equality (m, rad)"
            ),
        ],
        "cost": Annotated[Cost | None, means("per simulated second; null if not measured")],
        "label": Annotated[
            Literal["step-limited", "model-limited", "round-off", "failed", ""],
            means("what limits the error; empty if not known"),
        ],
        "limit": Annotated[str, means("the same in words: step, or the name of the floor")],
        "wasted": Annotated[bool, means("whether a longer step has the same error")],
        "reason": Annotated[str, means("why it failed")],
    },
)

Series = TypedDict(
    "Series",
    {
        "scene": Annotated[str, means("scene, or name of the file")],
        "case": Annotated[str, means("case that was run; empty of a file")],
        "engine": Annotated[str, means("engine")],
        "model": Annotated[str, means("model")],
        "method": Annotated[str, means("integrator")],
        "order": Annotated[int, means("declared order; 0 where none is")],
        "settings": Annotated[
            Settings,
            means(
                "options that are not at their default, and `segments` of a continuum; of a file "
                "`iterations` of the solver and `closure_steps`, the largest time constant of an "
                "equality over the step"
            ),
        ],
        "axis": Annotated[
            str,
            means(
                "what varies: step, parts of a continuum, an option that closes a loop, what is "
                "left out (0: left out, 1: there), or steps in a period"
            ),
        ],
        "unit": Annotated[str, means("unit of the axis; of a shift that of the parameter")],
        "quantity": Annotated[str, means("what the error is of; empty for all observables")],
        "points": Annotated[
            list[Point], means("runs, the longest step or the smallest model first")
        ],
        "slope": Annotated[
            Number, means("order fitted above the floor; null of fewer than two points")
        ],
        "plateau": Annotated[Number, means("error that no step removes; null if none was met")],
        "plateau_name": Annotated[
            str,
            means(
                "what makes it: closure softness, inertia floor, spatial discretisation, "
                "continuum, round-off, solver tolerance, or unexplained"
            ),
        ],
        "stable_step": Annotated[
            Number,
            means("longest that theory grants [s]; null without a limit, or without a theory"),
        ],
    },
)

# Choices --------------------------------------------------------------------------------------

SettingRun = TypedDict(
    "SettingRun",
    {
        "engine": Annotated[str, means("engine")],
        "model": Annotated[str, means("model")],
        "method": Annotated[str, means("integrator")],
        "settings": Annotated[Settings, means("as of a series")],
        "step": Annotated[Positive, means("[s]")],
        "error": Annotated[Number, means("error; null if the run failed")],
        "seconds": Annotated[Number, means("time per simulated second [s/s]")],
    },
)

Recommendation = TypedDict(
    "Recommendation",
    {
        "scene": Annotated[str, means("scene")],
        "case": Annotated[str, means("case")],
        "engine": Annotated[str, means("engine")],
        "target": Annotated[float, means("error allowed")],
        "axis": Annotated[
            str, means("step: the cheapest setting; otherwise the smallest model on this axis")
        ],
        "unit": Annotated[str, means("unit of the axis")],
        "quantity": Annotated[str, means("as of a series")],
        "model": Annotated[str | None, means("model; null if no setting meets the target")],
        "method": Annotated[str | None, means("integrator; null likewise")],
        "settings": Annotated[Settings | None, means("as of a series; null likewise")],
        "value": Annotated[
            Number,
            means("smallest model from which on all meet the target [`unit`]; null likewise"),
        ],
        "smaller": Annotated[Number, means("error of the next smaller model, which misses it")],
        "extrapolated": Annotated[
            bool, means("whether the value follows from the declared order and was not run")
        ],
        "step": Annotated[
            Number, means("longest step with which a run meets the target [s]; null without a run")
        ],
        "error": Annotated[
            Number, means("measured; the smallest one where nothing meets the target")
        ],
        "cost": Annotated[Cost | None, means("per simulated second; null without a run")],
        "limit": Annotated[str, means("what limits the error, or why nothing meets the target")],
        "margin": Annotated[
            Number, means("largest stable step by theory over the step [1]; null if there is none")
        ],
        "longest": Annotated[
            Number, means("longest step that was survived, over the step [1]; null likewise")
        ],
        "met": Annotated[bool, means("whether the target is met")],
    },
)

Tradeoff = TypedDict(
    "Tradeoff",
    {
        "schema": Version,
        "versions": Versions,
        "targets": Annotated[
            list[float], means("relative errors that settings are recommended for [1]")
        ],
        "series": Annotated[
            list[Series],
            means(
                "a method of an engine on a model over steps; models from small to large; and by "
                "how much a method shifts where a periodic orbit loses its stability"
            ),
        ],
        "pareto": Annotated[
            dict[str, list[SettingRun]],
            means("by scene: settings that none beats in both error and time, the cheapest first"),
        ],
        "recommendations": Annotated[
            list[Recommendation],
            means(
                "for each scene, engine and target: the cheapest setting, and the smallest models, "
                "or why there is none"
            ),
        ],
        "failures": Annotated[list[str], means("what came to nothing, and why")],
    },
)

# A user's model -------------------------------------------------------------------------------

ModelStart = TypedDict(
    "ModelStart",
    {
        "name": Annotated[str, means("state of the file, and whether controls move")],
        "compared": Annotated[float, means("time over which runs are compared [s]")],
        "smooth": Annotated[bool, means("whether no contact, limit or friction acted")],
        "integrator": Annotated[str, means("of the converged run")],
        "step": Annotated[Positive, means("of the converged run [s]")],
        "bound": Annotated[float, means("relative change of the converged run with half its step")],
        "spread": Annotated[float, means("relative change with a start that is 1e-6 off")],
    },
)

TradeoffModel = TypedDict(
    "TradeoffModel",
    {
        "schema": Version,
        "file": Annotated[str, means("name of the file")],
        "target": Annotated[Positive, means("relative error allowed")],
        "asked": Annotated[Positive, means("horizon that was asked for [s]")],
        "horizon": Annotated[float, means("over which all starts are compared [s]")],
        "budget": Annotated[Positive, means("time to try settings in [s]")],
        "seed": Annotated[int, means("of the controls that move")],
        "observed": Annotated[
            list[str], means("joints and sites that are judged; empty: all joints")
        ],
        "exact_closures": Annotated[
            bool, means("whether loops count as closed exactly, not as soft as in the file")
        ],
        "softness": Annotated[
            Number,
            means("how far closures as soft as in the file go from hard ones [1]; null: none"),
        ],
        "met": Annotated[bool, means("whether a setting meets the target with a margin")],
        "sentence": Annotated[str, means("what to do")],
        "notes": Annotated[list[str], means("what else is to be known")],
        "complete": Annotated[bool, means("whether the time was enough")],
        "starts": Annotated[list[ModelStart], means("from where runs are compared")],
        "unknown": Annotated[list[str], means("starts that were left out, with their reasons")],
        "series": Annotated[list[Series], means("all that were tried, by integrator and settings")],
        "front": Annotated[
            list[SettingRun], means("those that none beats in error and time, the fastest first")
        ],
        "own": Annotated[SettingRun | None, means("the file's own setting")],
        "recommendation": Annotated[SettingRun | None, means("the one to choose")],
        "versions": Versions,
    },
)
