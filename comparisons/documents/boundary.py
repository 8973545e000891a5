"""The document of ``boundary``: curves of bifurcations, and what is still to be followed."""

from __future__ import annotations

from typing import Annotated, Literal, NotRequired, TypedDict

from .core import (
    Count,
    Engine,
    Model,
    Name,
    NotNegative,
    Ordinal,
    Parameters,
    Positive,
    Scene,
    Version,
    Versions,
    means,
)

BoundaryAxis = TypedDict(
    "BoundaryAxis",
    {
        "name": Annotated[Name, means("parameter")],
        "low": Annotated[float, means("lower end of the window")],
        "high": Annotated[float, means("upper end")],
        "unit": Annotated[str, means("unit")],
    },
)

ComplexNumber = TypedDict(
    "ComplexNumber",
    {
        "re": Annotated[float, means("real part [1]")],
        "im": Annotated[float, means("imaginary part [1]")],
    },
)

BoundaryPoint = TypedDict(
    "BoundaryPoint",
    {
        "x": Annotated[float, means("of the first axis, in its unit")],
        "y": Annotated[float, means("of the second")],
        "x_bound": Annotated[
            NotNegative, means("bound on the error of `x` at this `y`, large where it is flat")
        ],
        "y_bound": Annotated[
            NotNegative,
            means("bound on the error of `y` at this `x`, large where it is steep"),
        ],
        "x_bound_across": NotRequired[
            Annotated[NotNegative, means("bound on the error of `x` on the line across the curve")]
        ],
        "y_bound_across": NotRequired[Annotated[NotNegative, means("the same of `y`")]],
        "state": Annotated[
            dict[str, float],
            means(
                "of the orbit where its period begins, angles not wrapped [SI]; the equilibrium, "
                "or the saddle of a homoclinic orbit"
            ),
        ],
        "period": Annotated[
            Positive | None, means("after which the orbit closes [s]; null for an equilibrium")
        ],
        "multipliers": Annotated[
            list[ComplexNumber],
            means("of the map that closes the orbit, descending in modulus, that of a shift too"),
        ],
        "eigenvalues": Annotated[
            list[ComplexNumber],
            means("of the equations about an equilibrium [1/s], descending in their real parts"),
        ],
        "critical": Annotated[
            ComplexNumber,
            means(
                "that of them, or one of the pair, which lies on the unit circle or the imaginary "
                "axis; that with which a homoclinic orbit leaves its saddle"
            ),
        ],
        "unstable": Annotated[
            Count, means("how many others are unstable: 0 on a stability boundary")
        ],
        "direction": Annotated[
            list[float], means("unit tangent: states, `x` and `y`, in the sizes that they have")
        ],
        "stable_side": NotRequired[
            Annotated[
                list[float] | None,
                means(
                    "unit vector, `x` and `y` in the size of the window, to the side on which what "
                    "loses its stability is stable; null for branch points and homoclinic orbits"
                ),
            ]
        ],
        "shift_x": Annotated[
            float | None,
            means(
                "of an engine: by how far the curve lies from that of the reference at the same "
                "`y`, in the unit of `x`; null for the reference, and where that has no point near"
            ),
        ],
        "shift_y": Annotated[float | None, means("the same in `y`")],
    },
)

Kind = Literal[
    "fold",
    "period_doubling",
    "neimark_sacker",
    "symmetry_breaking",
    "hopf",
    "branch_point",
    "homoclinic",
]

Subject = Literal["orbits", "equilibria"]

End = Literal[
    "window",
    "closed",
    "resonance_1_1",
    "resonance_1_2",
    "with_fold",
    "with_period_doubling",
    "with_neimark_sacker",
    "heteroclinic",
    "symmetric",
    "neutral",
    "unstable",
    "lost",
    "points",
]

ENDS = (
    "why a curve ends: `window`: it leaves it; `closed`; `resonance_1_1`, `resonance_1_2`: the "
    "pair meets at 1 or -1; `with_...`: another bifurcation comes in, whose curve begins there, or "
    "its saddle vanishes; `heteroclinic`: the orbit meets another saddle; "
    "`symmetric`: the orbits become symmetric; `neutral`, `unstable`: what lies beyond bounds no "
    "stability; `lost`: no further point was found; `points`: there are too many"
)

BoundaryPlace = TypedDict(
    "BoundaryPlace",
    {
        "x": Annotated[float, means("of the first axis, in its unit")],
        "y": Annotated[float, means("of the second")],
    },
)

BoundaryCurve = TypedDict(
    "BoundaryCurve",
    {
        "of": Annotated[Subject, means("what loses its stability, or ends")],
        "kind": Annotated[Kind, means("what happens to it there")],
        "parts": Annotated[
            Ordinal,
            means(
                "after how many periods the orbit closes, or half periods if the equations of the "
                "scene have that symmetry"
            ),
        ],
        "doubled": NotRequired[
            Annotated[
                bool,
                means("whether more was found on the orbits of twice the length that part there"),
            ]
        ],
        "begins": Annotated[End, means(ENDS)],
        "ends": Annotated[End, means("the same of its end")],
        "points": Annotated[list[BoundaryPoint], means("along the curve")],
    },
)

BoundaryStart = TypedDict(
    "BoundaryStart",
    {
        "of": Annotated[Subject, means("as of a curve")],
        "kind": Annotated[Kind, means("as of a curve")],
        "parts": Annotated[Ordinal, means("as of a curve")],
        "point": Annotated[BoundaryPoint, means("where it is to be followed from")],
        "unknowns": NotRequired[
            Annotated[
                list[float],
                means(
                    "the point in the unknowns that are solved for: a run goes on from just these"
                ),
            ]
        ],
        "begins": NotRequired[
            Annotated[
                End | None,
                means("why the curve ends there, if the point is on another that ends there, too"),
            ]
        ],
    },
)

Boundary = TypedDict(
    "Boundary",
    {
        "schema": Version,
        "scene": Scene,
        "engine": Engine,
        "model": Model,
        "method": Annotated[Name, means("integrator, as the engine spells it")],
        "step": Annotated[
            Positive | None, means("longest step in the window [s]; null for the reference")
        ],
        "steps_per_period": Annotated[
            Count | None, means("the same all along a curve; null for the reference")
        ],
        "parameters": Parameters,
        "x": Annotated[BoundaryAxis, means("first axis")],
        "y": Annotated[BoundaryAxis, means("second axis")],
        "lines": Annotated[
            Ordinal,
            means("on which `x` stays: bifurcations are looked for along them"),
        ],
        "near": NotRequired[
            Annotated[
                list[BoundaryPlace], means("places through which lines are looked along as well")
            ]
        ],
        "of": Annotated[list[Subject], means("what was followed along them")],
        "lines_done": Annotated[
            Count, means("of these, and of those through places, of all subjects together")
        ],
        "lines_done_of": Annotated[dict[Subject, Count], means("of these, for each subject")],
        "orbits": Annotated[
            Count, means("that were solved for by the reference, equilibria among them")
        ],
        "engine_orbits": Annotated[Count, means("that were solved for by the engine")],
        "curves": Annotated[list[BoundaryCurve], means("in the order in which they were followed")],
        "pending": Annotated[
            list[BoundaryStart], means("what is still to be followed; empty when all is done")
        ],
        "doublings": NotRequired[
            Annotated[
                list[BoundaryStart],
                means("where orbits of twice the length are still to be followed along lines"),
            ]
        ],
        "missing": Annotated[
            Count, means("bifurcations of the reference near which the engine has none")
        ],
        "versions": Versions,
    },
)
