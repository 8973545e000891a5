"""The documents of ``check``, ``judge`` and ``diff``."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NotRequired, TypedDict

from .core import (
    Count,
    Name,
    NotNegative,
    Ordinal,
    Parameters,
    Positive,
    Scene,
    Version,
    Versions,
    limits,
    means,
)

# Results --------------------------------------------------------------------------------------

ID = (
    "^((verification|validation)(/[A-Za-z0-9_.+-]+){4}"
    "/[A-Za-z0-9_.+-]+(@[A-Za-z0-9_.+-]+)?/[A-Za-z0-9_.+-]+|validation(/[a-z0-9_]+){2})$"
)

NUMBERS = {name: {"type": "number"} for name in ("value", "reference", "error", "tolerance")}

CONDITIONS: dict[str, Any] = {
    "allOf": [
        {
            "if": {"properties": {"verdict": {"enum": ["pass", "deviation"]}}},
            "then": {"properties": NUMBERS},
        },
        {
            "if": {"properties": {"verdict": {"enum": ["deviation", "known", "skipped", "error"]}}},
            "then": {"properties": {"reason": {"minLength": 1}}},
        },
    ]
}
"""What is judged has numbers; all but what passes has a reason."""

Verdict = Literal["pass", "deviation", "known", "skipped", "error"]

Work = TypedDict(
    "Work",
    {"seconds": NotRequired[Annotated[NotNegative | None, means("wall time [s]")]]},
)

Result = TypedDict(
    "Result",
    {
        "id": Annotated[
            str,
            means(
                "source/scene/case/kind/engine/method/quantity; of a row of a paper "
                "validation/scene/row",
                pattern=ID,
            ),
        ],
        "scene": Annotated[Name, means("system; `-` if none was reached")],
        "case": Annotated[Name, means("parameters with initial state and horizon, by name")],
        "kind": Annotated[Name, means("kind of check")],
        "source": Annotated[
            Literal["verification", "validation"],
            means(
                "`verification`: against the reference ODE; `validation`: against numbers printed "
                "in the paper"
            ),
        ],
        "engine": Annotated[Name, means("engine")],
        "model": Annotated[Name, means("the engine's model of the scene")],
        "method": Annotated[
            Name | None,
            means("integrator, as the engine spells it; null for kinds that use none"),
        ],
        "quantity": Annotated[Name, means("what was measured")],
        "unit": Annotated[str, means("of the next four; `1` for a number without unit")],
        "value": Annotated[
            float | None,
            means(
                "what the engine gives, where it differs most from the reference; what is an "
                "error by nature (a residual, a drift) is judged against the reference 0"
            ),
        ],
        "reference": Annotated[float | None, means("the true value")],
        "error": Annotated[NotNegative | None, means("what is compared with the tolerance")],
        "tolerance": Annotated[
            NotNegative | None, means("largest error that passes, `--profile` included")
        ],
        "verdict": Annotated[Verdict, means("see below")],
        "reason": Annotated[
            str,
            means(
                "one line: where the tolerance comes from and what was seen; for `skipped` and "
                "`error`, why; which numbers are null because they are not finite"
            ),
        ],
        "work": Annotated[
            Work,
            means(
                "what the check cost, the same in all its results; empty if it did not run to "
                "its end"
            ),
        ],
        "known": Annotated[
            Name | None,
            means(
                "why a deviation is known, in the words of the user's file; null for other "
                "verdicts. `reason` and the numbers are as without the file"
            ),
        ],
        "traceback": Annotated[
            Name | None,
            means(
                "where the code of an engine raised, for its author: lines of files, then the "
                "message, at most 8000 characters, the middle of a longer one left out; null for "
                "anything else"
            ),
        ],
        "cause": NotRequired[
            Annotated[
                str | None,
                means("where a deviation comes from, if one mistake alone explains it; else null"),
            ]
        ],
        "noticed_by": NotRequired[
            Annotated[
                list[str],
                means(
                    "who notices a deviation, a failure or a refusal: `engine`, the engine itself "
                    "or its adapter; `guard`, what mbcheck asks of every run; `rule:NAME`, a rule "
                    "known before the run; `halving`, a run with half the step; `reference`"
                ),
            ]
        ],
    },
)

Results = list[Annotated[Result, limits(**CONDITIONS)]]

Summary = TypedDict(
    "Summary",
    {
        "pass": Annotated[Count, means("errors within their tolerance")],
        "deviation": Annotated[Count, means("errors beyond their tolerance")],
        "known": Annotated[Count, means("deviations that the user has listed")],
        "skipped": Annotated[Count, means("results that did not run")],
        "error": Annotated[Count, means("results that could not be judged")],
        "total": Annotated[Count, means("all results")],
    },
)

# check ----------------------------------------------------------------------------------------

Checks = TypedDict(
    "Checks",
    {
        "planned": Annotated[Count, means("that were to run, those that cannot among them")],
        "ran": Annotated[Count, means("of which a result was judged")],
        "skipped": Annotated[Count, means("of which none was")],
        "not_reached": Annotated[Count, means("that were not begun: the run was stopped")],
    },
)

SkipReason = TypedDict(
    "SkipReason",
    {
        "engine": Annotated[Name, means("engine")],
        "reason": Annotated[str, means("why")],
        "results": Annotated[Ordinal, means("how many")],
    },
)

Selection = TypedDict(
    "Selection",
    {
        "scenes": Annotated[list[str], means("empty: all")],
        "engines": Annotated[
            list[str], means("as they were given: names, or package.module:Class; empty: all")
        ],
        "kinds": Annotated[list[str], means("empty: all")],
        "methods": Annotated[list[str], means("empty: all")],
        "ids": Annotated[list[str], means("patterns; empty: all")],
        "profile": Annotated[str, means("what scales the tolerances")],
        "full": Annotated[bool, means("whether what the default set leaves out was included")],
        "quick": Annotated[bool, means("where all but a quick answer was left out")],
        "placement": Annotated[str, means("how models were placed in the world, if told")],
        "extremes": Annotated[bool, means("where engines are checked at extremes only")],
        "source": Annotated[Literal["validation"], means("where papers are checked, not engines")],
        "parameters": Annotated[
            Parameters, means("of a run at a user's own: those that differ from the defaults")
        ],
        "state": Annotated[
            dict[str, float], means("of such a run: the initial values that were given (SI)")
        ],
        "horizon": Annotated[
            float | None, means("of such a run, as it was given [s]; null for the default")
        ],
    },
    total=False,
)

CustomReference = TypedDict(
    "CustomReference",
    {
        "horizon": Annotated[float, means("of the run [s]")],
        "horizon_source": Annotated[str, means("what the horizon follows from")],
        "permitted": Annotated[
            float, means("part of it over which an initial error stays small enough [s]")
        ],
        "growth": Annotated[float, means("amplification of an initial error over that part")],
        "error_bound": Annotated[
            dict[str, float], means("bound on the error of each observable over the times")
        ],
        "units": Annotated[dict[str, str], means("of the observables")],
    },
)

KnownEntry = TypedDict(
    "KnownEntry",
    {
        "number": Annotated[Ordinal, means("its place in the file")],
        "id": Annotated[Name, means("pattern for ids")],
        "reason": Annotated[Name, means("as the user gave it")],
        "max_error": Annotated[
            float | None,
            means("largest error that it covers, in the unit of a result; null for any"),
        ],
        "results": Annotated[Count, means("how many are known because of it")],
        "state": Annotated[
            Literal["used", "stale", "open"],
            means("`stale`: of no use any more; `open`: this run cannot tell"),
        ],
        "why": Annotated[str, means("why it is not used; empty if it is")],
    },
)

Known = TypedDict(
    "Known",
    {
        "file": Annotated[str | None, means("file of known deviations; null without one")],
        "strict": Annotated[bool, means("whether stale entries fail")],
        "entries": Annotated[list[KnownEntry], means("one for each entry, in the file's order")],
    },
)

Environment = Annotated[
    dict[str, str],
    means("what rounding may depend on: python, system, machine, processor, libc"),
]

Check = TypedDict(
    "Check",
    {
        "schema": Version,
        "summary": Annotated[Summary, means("number of results by verdict")],
        "checks": Annotated[Checks, means("number of checks, of several results each")],
        "skipped": Annotated[list[SkipReason], means("why results were skipped")],
        "versions": Versions,
        "environment": Environment,
        "selection": Annotated[Selection, means("what was asked for")],
        "reference": NotRequired[
            Annotated[
                CustomReference,
                means("the reference, of a run at a user's own parameters only"),
            ]
        ],
        "known": Annotated[Known, means("the known deviations, and what became of them")],
        "results": Annotated[
            Results,
            means(
                "one for each quantity of each check, in the order of the checks whatever `-j` was"
            ),
        ],
    },
)

# judge ----------------------------------------------------------------------------------------

LargestError = TypedDict(
    "LargestError",
    {
        "quantity": Annotated[Name, means("observable")],
        "unit": Annotated[str, means("of the numbers but `time` and `relative`")],
        "time": Annotated[float, means("where the error is largest [s]")],
        "value": Annotated[float, means("of the file, there")],
        "reference": Annotated[float, means("true value, there")],
        "error": Annotated[NotNegative, means("largest error")],
        "size": Annotated[Positive, means("largest value of the reference; 1 where that stays 0")],
        "bound": Annotated[NotNegative, means("on the reference's own error")],
        "relative": Annotated[NotNegative, means("`error` / `size` [1]")],
    },
)

Tolerance = TypedDict(
    "Tolerance",
    {
        "relative": NotRequired[
            Annotated[
                float,
                means(
                    "share of each observable's size [1]", exclusiveMinimum=0, exclusiveMaximum=1
                ),
            ]
        ],
        "order": NotRequired[Annotated[Ordinal, means("order of the method")]],
        "step": NotRequired[Annotated[Positive, means("its step [s]")]],
    },
)

EITHER: dict[str, Any] = {
    "oneOf": [
        {"maxProperties": 0},
        {"required": ["relative"], "maxProperties": 1},
        {"required": ["order", "step"]},
    ]
}

Judge = TypedDict(
    "Judge",
    {
        "schema": Version,
        "scene": Scene,
        "case": Annotated[Name, means("its name; `user` if `--set` or `--state` change it")],
        "file": Annotated[str, means("name of the file, without folder and ending")],
        "parameters": Parameters,
        "state": Annotated[
            dict[str, float], means("initial values that are not 0, at `start_time` [SI]")
        ],
        "start_time": Annotated[float, means("time at which the case begins [s]")],
        "samples": Annotated[Ordinal, means("rows of the file")],
        "judged": Annotated[Ordinal, means("rows, from the first, that could be judged")],
        "until": Annotated[float, means("time of the last of these [s]")],
        "growth": Annotated[float, means("of an initial error until then [1]", minimum=1)],
        "tolerance": Annotated[
            Tolerance,
            means(
                "what tolerances follow from: `relative`, or `order` and `step`; empty where "
                "nothing was to be judged",
                **EITHER,
            ),
        ],
        "errors": Annotated[
            list[LargestError],
            means("one for each column that was compared; none of one that is not finite"),
        ],
        "notes": Annotated[
            list[Name],
            means(
                "what was seen beside the numbers: columns that were not compared, what looks "
                "like a slip"
            ),
        ],
        "summary": Annotated[Summary, means("number of results by verdict")],
        "results": Annotated[
            Results,
            means(
                "as in `check`, `model` being `file` and `engine` the file's name; none without "
                "a tolerance"
            ),
        ],
        "versions": Versions,
    },
)

# diff -----------------------------------------------------------------------------------------

Side = TypedDict(
    "Side",
    {
        "file": Annotated[str, means("file that was read")],
        "versions": Versions,
        "environment": Environment,
        "results": Annotated[Count, means("number of results")],
    },
)

Changes = TypedDict(
    "Changes",
    {
        "compared": Annotated[Count, means("ids in both runs")],
        "same": Annotated[Count, means("ids in both that have not changed")],
        "new_error": Annotated[Count, means("new errors; a regression")],
        "new_deviation": Annotated[Count, means("new deviations; a regression")],
        "grew": Annotated[Count, means("errors that grew; a regression")],
        "vanished": Annotated[Count, means("not there any more; a regression")],
        "now_skipped": Annotated[Count, means("skipped now; a regression")],
        "other_failure": Annotated[Count, means("errors that are deviations now")],
        "now_known": Annotated[Count, means("known now")],
        "fixed": Annotated[Count, means("fixed")],
        "shrank": Annotated[Count, means("errors that shrank")],
        "now_runs": Annotated[Count, means("no longer skipped")],
        "appeared": Annotated[Count, means("new, and not failing")],
        "left_out": Annotated[Count, means("not compared: left out of the new run")],
        "dropped": Annotated[Count, means("not there any more, and did not run before")],
    },
)

Sort = Literal[
    "new_error", "new_deviation", "grew", "vanished", "now_skipped", "other_failure", "now_known",
    "fixed", "shrank", "now_runs", "appeared", "left_out", "dropped",
]  # fmt: skip

Outcome = TypedDict(
    "Outcome",
    {
        "verdict": Annotated[Verdict, means("as in `check`")],
        "value": Annotated[float | None, means("the engine's value")],
        "reference": Annotated[float | None, means("the true value")],
        "error": Annotated[float | None, means("what was compared with the tolerance")],
        "tolerance": Annotated[float | None, means("largest error that passes")],
        "reason": Annotated[str, means("why the verdict is what it is")],
    },
)

Change = TypedDict(
    "Change",
    {
        "id": Annotated[Name, means("as in `check`, and so its parts")],
        "scene": Annotated[str, means("scene")],
        "case": Annotated[str, means("case")],
        "kind": Annotated[str, means("kind of check")],
        "engine": Annotated[str, means("engine")],
        "model": Annotated[str, means("the engine's model")],
        "method": Annotated[str | None, means("integrator; null for kinds that use none")],
        "quantity": Annotated[str, means("what was measured")],
        "unit": Annotated[str, means("of the numbers")],
        "change": Annotated[Sort, means("sort of change, one of those that `summary` counts")],
        "regression": Annotated[bool, means("whether it makes the new run worse")],
        "old": Annotated[Outcome | None, means("the result there; null where the id is not there")],
        "new": Annotated[Outcome | None, means("the result there; null where the id is not there")],
    },
)

Diff = TypedDict(
    "Diff",
    {
        "schema": Version,
        "old": Annotated[Side, means("one of the runs")],
        "new": Annotated[Side, means("the other run")],
        "notes": Annotated[list[str], means("what else differs about the runs, for readers")],
        "summary": Annotated[Changes, means("number of ids, and of changes by sort")],
        "regressions": Annotated[
            Count, means("number of changes that are regressions; exit code 1 if there is one")
        ],
        "changes": Annotated[list[Change], means("what matters most first")],
    },
)
