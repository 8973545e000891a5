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
            means("wall time of the stepping on this machine [s/s], the median of repeated runs"),
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
        "step": Annotated[Positive, means("[s]")],
        "error": Annotated[Number, means("largest of all observables; null if the run failed")],
        "errors": Annotated[dict[str, Number], means("by observable")],
        "cost": Annotated[Cost | None, means("per simulated second; null if the run failed")],
        "label": Annotated[
            Literal["step-limited", "model-limited", "round-off", "failed"],
            means("what limits it"),
        ],
        "limit": Annotated[str, means("the same in words: step, or the name of the floor")],
        "wasted": Annotated[bool, means("whether a longer step has the same error")],
        "reason": Annotated[str, means("why it failed")],
    },
)

Series = TypedDict(
    "Series",
    {
        "scene": Annotated[str, means("scene")],
        "case": Annotated[str, means("case that was run")],
        "engine": Annotated[str, means("engine")],
        "model": Annotated[str, means("model")],
        "method": Annotated[str, means("integrator")],
        "order": Annotated[int, means("declared order")],
        "settings": Annotated[
            Settings,
            means("options that are not at their default, and `segments` of a continuum"),
        ],
        "points": Annotated[list[Point], means("runs, the longest step first")],
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

FrontPoint = TypedDict(
    "FrontPoint",
    {
        "engine": Annotated[str, means("engine")],
        "model": Annotated[str, means("model")],
        "method": Annotated[str, means("integrator")],
        "settings": Annotated[Settings, means("as of a series")],
        "step": Annotated[float, means("[s]")],
        "error": Annotated[float, means("error")],
        "seconds": Annotated[Number, means("wall time per simulated second [s/s]")],
    },
)

Recommendation = TypedDict(
    "Recommendation",
    {
        "scene": Annotated[str, means("scene")],
        "case": Annotated[str, means("case")],
        "engine": Annotated[str, means("engine")],
        "target": Annotated[float, means("error allowed")],
        "model": Annotated[str | None, means("model; null if no setting meets the target")],
        "method": Annotated[str | None, means("integrator; null likewise")],
        "settings": Annotated[Settings | None, means("as of a series; null likewise")],
        "step": Annotated[Number, means("[s]; null likewise")],
        "error": Annotated[
            Number, means("measured; the least one where no setting meets the target")
        ],
        "cost": Annotated[Cost | None, means("per simulated second; null likewise")],
        "limit": Annotated[str, means("what limits the error")],
        "margin": Annotated[
            Number, means("longest stable step by theory over the step [1]; null if there is none")
        ],
        "longest": Annotated[
            Number, means("longest step that was survived, over the step [1]; null likewise")
        ],
        "met": Annotated[bool, means("whether the target is met")],
    },
)

# The least that a scene requires --------------------------------------------------------------

Curve = TypedDict(
    "Curve",
    {
        "engine": Annotated[str, means("engine")],
        "kind": Annotated[str, means("how the beam is made")],
        "part": Annotated[str, means("rods, elements or modes")],
        "case": Annotated[str, means("case")],
        "quantity": Annotated[str, means("what is compared")],
        "order": Annotated[int, means("declared order; 0 where none is")],
        "counts": Annotated[list[int], means("numbers of parts")],
        "errors": Annotated[list[Number], means("with so many")],
        "limit": Annotated[Number, means("error extrapolated to parts of no length")],
        "doubt": Annotated[Number, means("how far the extrapolation moved last")],
    },
)

Fewest = TypedDict(
    "Fewest",
    {
        "engine": Annotated[str, means("engine")],
        "kind": Annotated[str, means("how the beam is made")],
        "part": Annotated[str, means("rods, elements or modes")],
        "case": Annotated[str, means("case")],
        "quantity": Annotated[str, means("what is compared")],
        "target": Annotated[float, means("error allowed")],
        "count": Annotated[int | None, means("parts; null where no number meets the target")],
        "error": Annotated[Number, means("with so many")],
        "fewer": Annotated[Number, means("error with one less, which misses the target")],
        "extrapolated": Annotated[
            bool, means("whether the count follows from the declared order and was not run")
        ],
        "limit": Annotated[Number, means("error that no number of parts removes")],
        "integration": Annotated[Number, means("what halving the step changes")],
        "stable_step": Annotated[Number, means("longest step that theory grants [s]")],
        "step": Annotated[
            Number, means("longest power of two with which a run meets the target [s]")
        ],
        "cost": Annotated[Cost | None, means("with that step")],
        "reason": Annotated[str, means("in one sentence")],
    },
)

SoftClosure = TypedDict(
    "SoftClosure",
    {
        "engine": Annotated[str, means("engine")],
        "model": Annotated[str, means("model")],
        "method": Annotated[str, means("integrator")],
        "case": Annotated[str, means("case")],
        "knob": Annotated[str, means("option that softens it; empty for a model without one")],
        "unit": Annotated[str, means("its unit")],
        "target": Annotated[float, means("error allowed")],
        "value": Annotated[Number, means("the softest [`unit`]; null where none meets it")],
        "error": Annotated[Number, means("what it leaves, whatever the step")],
        "softer": Annotated[Number, means("the next softer one, which misses [`unit`]")],
        "softer_error": Annotated[Number, means("what that leaves")],
        "claimed": Annotated[bool, means("whether errors are those of the model's equations")],
        "stable_step": Annotated[Number, means("longest step that theory grants [s]")],
        "step": Annotated[
            Number, means("longest power of two with which a run meets the target [s]")
        ],
        "measured": Annotated[Number, means("error of that run")],
        "cost": Annotated[Cost | None, means("of that run")],
        "reason": Annotated[str, means("in one sentence")],
    },
)

LeftOut = TypedDict(
    "LeftOut",
    {
        "scene": Annotated[str, means("scene")],
        "engine": Annotated[str, means("engine")],
        "left_out": Annotated[str, means("what it is")],
        "compared": Annotated[str, means("the two models, the one that has it first")],
        "case": Annotated[str, means("case")],
        "error_with": Annotated[Number, means("with it")],
        "error_without": Annotated[float, means("without it")],
        "cost_ratio": Annotated[Number, means("cost with it over cost without [1]")],
        "lowest": Annotated[Number, means("lower quartile of the ratio")],
        "highest": Annotated[Number, means("upper quartile")],
        "cost_of": Annotated[str, means("what was compared")],
        "required": Annotated[
            dict[str, bool | None],
            means(
                "by target: whether it has to be there; null where the model that has it misses too"
            ),
        ],
        "verdict": Annotated[str, means("in one sentence")],
    },
)

Minimal = TypedDict(
    "Minimal",
    {
        "curves": Annotated[list[Curve], means("errors over the number of parts of a beam")],
        "fewest": Annotated[list[Fewest], means("the fewest parts that meet a target")],
        "closures": Annotated[
            list[SoftClosure], means("the softest closure of a loop that meets a target")
        ],
        "left_out": Annotated[
            list[LeftOut], means("what may be left out of models, and what that costs or saves")
        ],
    },
)

BoundaryShift = TypedDict(
    "BoundaryShift",
    {
        "scene": Annotated[str, means("scene")],
        "case": Annotated[str, means("case")],
        "engine": Annotated[str, means("engine")],
        "model": Annotated[str, means("model")],
        "method": Annotated[str, means("integrator")],
        "order": Annotated[int, means("declared order")],
        "parameter": Annotated[str, means("at which the orbit loses its stability")],
        "unit": Annotated[str, means("its unit")],
        "steps": Annotated[list[int], means("in a period of the orbit")],
        "shifts": Annotated[
            list[Number],
            means("its value less the reference's [`unit`]; null where there is none near"),
        ],
        "bounds": Annotated[
            list[Number], means("what rounding and differences leave of a shift [`unit`]")
        ],
        "slope": Annotated[
            Number, means("order of the last halving above the bounds; null without one")
        ],
        "reason": Annotated[str, means("why there is none near")],
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
        "series": Annotated[list[Series], means("a method of an engine on a model over steps")],
        "pareto": Annotated[
            dict[str, list[FrontPoint]],
            means("by scene: settings that none beats in both error and time, the cheapest first"),
        ],
        "recommendations": Annotated[
            list[Recommendation],
            means("for each scene, engine and target: the cheapest setting, or why there is none"),
        ],
        "minimal": Annotated[Minimal, means("the least that the scenes require")],
        "stability": Annotated[
            list[BoundaryShift],
            means("by how much a method shifts where a periodic orbit loses its stability"),
        ],
        "failures": Annotated[list[str], means("what came to nothing, and why")],
    },
)

# A user's model -------------------------------------------------------------------------------

ModelSetting = TypedDict(
    "ModelSetting",
    {
        "setting": Annotated[str, means("in words")],
        "integrator": Annotated[str, means("as MJCF spells it")],
        "step": Annotated[Positive, means("[s]")],
        "iterations": Annotated[int | None, means("of the solver; null: as in the file")],
        "closure": Annotated[
            Number, means("longest time constant of an equality [s]; null: as in the file")
        ],
        "error": Annotated[
            Number, means("largest, relative to the motion; null if the state was lost")
        ],
        "bound": Annotated[
            Number, means("by how much the converged run changes with half its step; null likewise")
        ],
        "energy": Annotated[
            Number,
            means("largest difference from the converged run's, in the largest kinetic energy [1]"),
        ],
        "violation": Annotated[Number, means("largest residual of an equality (m, rad)")],
        "seconds": Annotated[
            float,
            means("processor time of the stepping on this machine [s/s], the median of the runs"),
        ],
        "failed": Annotated[str, means("where the state was lost, and when; empty if it was not")],
        "limit": Annotated[Number, means("largest stable step of small motions [s]; null: none")],
    },
)

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
        "settings": Annotated[
            list[ModelSetting], means("all that were tried, the file's own first")
        ],
        "front": Annotated[
            list[ModelSetting], means("those that none beats in error and time, the fastest first")
        ],
        "recommendation": Annotated[ModelSetting | None, means("the one to choose")],
        "versions": Versions,
    },
)
