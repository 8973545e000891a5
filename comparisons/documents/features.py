"""The documents of ``compare-maps`` and ``reproduce``."""

from __future__ import annotations

from typing import Annotated, Literal, NotRequired, TypedDict

from .core import Count, NotNegative, Version, Versions, limits, means

# compare-maps ---------------------------------------------------------------------------------

Share = Annotated[float, limits(minimum=0, maximum=1)] | None

Offset = TypedDict(
    "Offset",
    {
        "median": Annotated[float, means("median")],
        "largest": Annotated[float, means("largest")],
    },
)

CompareMaps = TypedDict(
    "CompareMaps",
    {
        "schema": Version,
        "variable": Annotated[str, means("what is compared")],
        "unit": Annotated[str, means("its unit; 1 for classes")],
        "points": Annotated[Count, means("points that both maps computed with a value")],
        "maps": Annotated[
            list[str],
            means("engine, model and method of either map", minItems=2, maxItems=2),
        ],
        "largest_difference": NotRequired[
            Annotated[float, means("of numbers only: absolute [`unit`]")]
        ],
        "median_difference": NotRequired[
            Annotated[float, means("of numbers only: absolute [`unit`]")]
        ],
        "relative_difference": NotRequired[
            Annotated[
                float,
                means(
                    "of numbers only: the largest over the largest value of the first map; 0 "
                    "where that is 0 [1]"
                ),
            ]
        ],
        "agreement": NotRequired[
            Annotated[
                Share,
                means(
                    "of classes only, as all that follows: share of points that agree [1]; null "
                    "without points"
                ),
            ]
        ],
        "robust_points": NotRequired[
            Annotated[Count, means("points that are robust in both maps")]
        ],
        "robust_agreement": NotRequired[
            Annotated[Share, means("share of these that agree [1]; null without any")]
        ],
        "confusion": NotRequired[
            Annotated[
                dict[str, dict[str, Count]],
                means("points by class of the first map, then of the second"),
            ]
        ],
        "boundary_offset_cells": NotRequired[
            Annotated[
                Offset,
                means(
                    "by how many cells boundaries would have to move over the points that differ"
                ),
            ]
        ],
    },
)

# reproduce ------------------------------------------------------------------------------------

Figure = TypedDict(
    "Figure",
    {
        "scene": Annotated[str, means("scene")],
        "number": Annotated[int, means("as in the paper")],
        "title": Annotated[str, means("what it shows")],
        "caption": Annotated[str, means("what is drawn, with which choices")],
        "error": Annotated[str | None, means("why it was not drawn, or null")],
        "run": Annotated[Count, means("how it was made: its place in `runs`")],
        "seconds": Annotated[NotNegative, means("run time [s]")],
    },
)

Erratum = TypedDict(
    "Erratum",
    {
        "test": Annotated[str, means("the test that proves it")],
        "corrected": Annotated[str, means("the formula as it should be")],
        "why": Annotated[str, means("why")],
        "effect": Annotated[str, means("what it does to the paper's results")],
        "copy": Annotated[str, means("why our copy of the text may be at fault, if it may")],
    },
)

Printed = TypedDict(
    "Printed",
    {
        "value": Annotated[float, means("as printed, in the unit")],
        "tolerance": Annotated[NotNegative, means("half a unit of its last digit")],
        "unit": Annotated[str, means("unit; empty for a pure number")],
    },
)

Threshold = TypedDict(
    "Threshold",
    {
        "verdict": Annotated[str, means("the verdict whose conditions it is among")],
        "quantity": Annotated[str, means("what is judged")],
        "relation": Annotated[
            Literal["<", "<=", ">", ">=", "==", "rounds to"], means("to the limit")
        ],
        "limit": Annotated[float | None, means("limit; null if it is a word or a truth value")],
        "value": Annotated[
            float | None,
            means(
                "our number, of several the one nearest to breaking the condition; null as above"
            ),
        ],
        "distance": Annotated[
            float | None,
            means("from the limit, on the side that holds where positive; null as above"),
        ],
        "holds": Annotated[bool, means("whether the condition holds")],
        "ours": Annotated[
            bool,
            means(
                "whether the limit is ours, neither printed nor derived: within 5 % of it the "
                "verdict is `open`"
            ),
        ],
    },
)

LedgerRow = TypedDict(
    "LedgerRow",
    {
        "scene": Annotated[str, means("scene")],
        "name": Annotated[str, means("name of the row, unique in its scene")],
        "kind": Annotated[
            Literal["number", "claim", "misprint", "reading"],
            means("a printed number, a claim in words, a misprint, what the text leaves open"),
        ],
        "section": Annotated[str, means("where it stands in the paper")],
        "claim": Annotated[str, means("what it says, in our words")],
        "printed": Annotated[str, means("printed value; empty for a claim in words")],
        "test": Annotated[str, means("of a misprint: the test that shows it")],
        "verdict": Annotated[
            Literal[
                "reproduced",
                "reproduced, unconverged",
                "reproduced with a corrected equation",
                "not reproduced",
                "depends on what is not printed",
                "open",
                "not testable",
                "error",
                "",
            ],
            means("what became of it; `error` where we failed, empty for a reading"),
        ],
        "reason": Annotated[str, means("why")],
        "reference": Annotated[str, means("our value as text, with its unit")],
        "engines": Annotated[dict[str, str], means("the same by engine")],
        "candidates": Annotated[
            list[Annotated[list[str], limits(minItems=2, maxItems=2)]],
            means("of an open reading: each candidate, and what it gives"),
        ],
        "cause": Annotated[str, means("name of the cause that it shares with others, or empty")],
        "erratum": Annotated[Erratum | None, means("of a misprint; otherwise null")],
        "quantity": Annotated[
            Printed | None, means("the printed number that it is judged by; null if there is none")
        ],
        "values": Annotated[
            dict[str, float | None],
            means("of a printed number: ours in its unit, by `reference` and by engine"),
        ],
        "numbers": Annotated[
            dict[str, dict[str, float | list[float | None] | None]],
            means("the numbers in `reference` and `engines`, by who has them and by name"),
        ],
        "thresholds": Annotated[list[Threshold], means("conditions that decide on the verdict")],
        "run": Annotated[Count, means("how it was made: its place in `runs`")],
        "seconds": Annotated[
            NotNegative,
            means("run time, with that of maps and runs that it was the first to need [s]"),
        ],
    },
)

Cause = TypedDict(
    "Cause",
    {
        "scene": Annotated[str, means("scene")],
        "name": Annotated[str, means("unique in its scene")],
        "summary": Annotated[str, means("what it is")],
        "rows": Annotated[list[str], means("names of the rows that share it")],
    },
)

PaperRun = TypedDict(
    "PaperRun",
    {
        "versions": Versions,
        "full": Annotated[bool, means("whether `--full` was given")],
    },
)

Reproduce = TypedDict(
    "Reproduce",
    {
        "schema": Version,
        "versions": Versions,
        "full": Annotated[bool, means("whether `--full` was given")],
        "figures": Annotated[list[Figure], means("one for each figure")],
        "rows": Annotated[list[LedgerRow], means("the ledger")],
        "causes": Annotated[
            list[Cause], means("what several rows that do not hold as printed have in common")
        ],
        "runs": Annotated[list[PaperRun], means("the ways in which figures and rows were made")],
    },
)
