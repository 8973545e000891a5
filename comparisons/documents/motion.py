"""The documents of ``simulate``, ``orbit`` and ``frequencies``."""

from __future__ import annotations

from typing import Annotated, TypedDict

from .core import (
    Count,
    Engine,
    Method,
    Model,
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

State = Annotated[dict[str, float], limits(minProperties=1)]
Bound = dict[str, NotNegative] | None
Limit = NotNegative | None
Step = Positive | None

# simulate -------------------------------------------------------------------------------------

RunWork = TypedDict(
    "RunWork",
    {
        "steps": Annotated[Count, means("steps that the engine counted")],
        "rhs_evaluations": Annotated[
            Count | None,
            means("evaluations of the forces; null if the engine does not count them"),
        ],
        "seconds": Annotated[NotNegative, means("wall time [s]")],
    },
)

Caution = TypedDict(
    "Caution",
    {
        "rule": Annotated[Name, means("name of the rule")],
        "message": Annotated[Name, means("what is wrong, with its numbers, and what to do")],
    },
)

Simulate = TypedDict(
    "Simulate",
    {
        "schema": Version,
        "scene": Scene,
        "engine": Engine,
        "method": Method,
        "model": Model,
        "step": Annotated[
            Step,
            means("fixed step [s]; null for the reference, whose error control chooses its steps"),
        ],
        "parameters": Parameters,
        "times": Annotated[list[NotNegative], means("sample times [s], increasing", minItems=1)],
        "observables": Annotated[
            dict[str, Annotated[list[float | None], limits(minItems=1)]],
            means(
                "values at `times`: every state (coordinates and their `_dot`; the internal ones "
                "of a continuum, which differ from model to model, only on request), what the "
                "scene always observes, what `--observe` asked for, and `position_violation`, "
                "`velocity_violation` of an engine's model that closes a loop; null from "
                "`lost_from` on",
                minProperties=1,
            ),
        ],
        "units": Annotated[dict[str, str], means("of the observables")],
        "error_bound": Annotated[
            Bound,
            means(
                "bound on the error of each observable, in its unit, the largest over the times "
                "before `lost_from`; null for an engine, which states none, and where all is lost"
            ),
        ],
        "lost_from": Annotated[
            NotNegative | None,
            means(
                "first of the times [s] from which on nothing is known of the motion: what "
                "rounding and the method leave open has grown to its size; null if there is none"
            ),
        ],
        "work": Annotated[RunWork, means("what the run cost")],
        "versions": Versions,
        "cautions": Annotated[
            list[Caution],
            means(
                "what rules say of the run from its case, model, method and step alone, also a "
                "warning on standard error; empty for the reference"
            ),
        ],
    },
)

# orbit ----------------------------------------------------------------------------------------

Multiplier = TypedDict(
    "Multiplier",
    {
        "re": Annotated[float, means("real part [1]")],
        "im": Annotated[float, means("imaginary part [1]")],
        "modulus": Annotated[NotNegative, means("modulus [1]; below 1 the perturbation decays")],
        "trivial": Annotated[
            bool,
            means("whether it is the 1 of a shift in time, which one is where nothing drives it"),
        ],
        "error_bound": Annotated[
            Limit, means("bound on its error in the complex plane [1]; null for an engine")
        ],
    },
)

Harmonic = TypedDict(
    "Harmonic",
    {
        "order": Annotated[Ordinal, means("multiple of Omega")],
        "amplitude": Annotated[NotNegative, means("in the unit of the observable")],
        "phase": Annotated[float, means("[rad]")],
    },
)

Spectrum = TypedDict(
    "Spectrum",
    {
        "mean": Annotated[float, means("in the unit of the observable")],
        "terms": Annotated[list[Harmonic], means("ascending in order")],
        "error_bound": Annotated[
            Limit,
            means(
                "bound on the error of `mean`, and of each term's complex amplitude; null for an "
                "engine"
            ),
        ],
    },
)

OrbitQuantity = TypedDict(
    "OrbitQuantity",
    {
        "value": Annotated[float | None, means("[`unit`]; null if it is not finite")],
        "unit": Annotated[str, means("its unit")],
        "error_bound": Annotated[Limit, means("bound on the error of `value`; null for an engine")],
    },
)

Orbit = TypedDict(
    "Orbit",
    {
        "schema": Version,
        "scene": Scene,
        "engine": Engine,
        "method": Method,
        "model": Model,
        "step": Annotated[
            Step,
            means("fixed step [s], a whole fraction of the period; null for the reference"),
        ],
        "parameters": Parameters,
        "period": Annotated[Positive, means("[s]")],
        "period_bound": Annotated[
            Limit, means("bound on the error of `period` [s]; null for an engine")
        ],
        "state": Annotated[
            State,
            means(
                "coordinates and their `_dot` [SI] where the period begins; a coordinate that "
                "turns lies in [0, 2 pi)"
            ),
        ],
        "mean_speed": Annotated[
            float | None, means("of the coordinate that turns [rad/s]; null where none turns")
        ],
        "mean_speed_bound": Annotated[
            Limit, means("bound on the error of `mean_speed` [rad/s]; null for an engine")
        ],
        "stable": Annotated[
            bool,
            means("whether every multiplier that is not `trivial` lies inside the unit circle"),
        ],
        "floquet_multipliers": Annotated[
            list[Multiplier],
            means("eigenvalues of the monodromy matrix, descending in modulus", minItems=1),
        ],
        "harmonics": Annotated[
            dict[str, Spectrum],
            means(
                "Fourier series of what is left of each observable without its secular part: "
                "mean + sum of amplitude cos(order Omega t + phase), Omega = 2 pi / period",
                minProperties=1,
            ),
        ],
        "power": Annotated[
            dict[str, float],
            means("mean power of each non-conservative force [W]; their sum is 0"),
        ],
        "power_bound": Annotated[
            Bound, means("bound on the error of each `power` [W]; null for an engine")
        ],
        "quantities": Annotated[
            dict[str, OrbitQuantity], means("what else the scene's orbit is measured by, see below")
        ],
        "error_bound": Annotated[
            Bound, means("bound on the error of `state` [SI]; null for an engine")
        ],
        "versions": Versions,
    },
)

# frequencies ----------------------------------------------------------------------------------

Mode = TypedDict(
    "Mode",
    {
        "re": Annotated[float, means("real part of the eigenvalue [1/s]")],
        "im": Annotated[NotNegative, means("imaginary part [rad/s]")],
        "omega": Annotated[NotNegative, means("its modulus [rad/s]")],
        "hertz": Annotated[NotNegative, means("omega / (2 pi) [Hz]")],
        "damping_ratio": Annotated[
            float | None, means("-re / omega [1]; null for a zero mode, which has none")
        ],
        "error_bound": Annotated[
            Limit,
            means(
                "bound on the error of the eigenvalue in the complex plane, hence of `re`, `im` "
                "and `omega` [1/s]; null for an engine, and where rounding leaves none"
            ),
        ],
        "damping_ratio_bound": Annotated[
            Limit,
            means("bound on the error of `damping_ratio` [1]; null where there is none"),
        ],
    },
)

Frequencies = TypedDict(
    "Frequencies",
    {
        "schema": Version,
        "scene": Scene,
        "engine": Engine,
        "model": Model,
        "parameters": Parameters,
        "undamped": Annotated[bool, means("whether damping was left out")],
        "about": Annotated[Name, means("name of the state of rest, or of steady motion")],
        "plane": Annotated[
            str | None,
            means("`chordwise` or `flapwise` of a rotating beam; null for other scenes"),
        ],
        "state": Annotated[State, means("that state [SI]")],
        "modes": Annotated[
            list[Mode],
            means(
                "ascending in omega, zero modes listed; a complex pair of eigenvalues is one "
                "mode. The lowest `--count`: all by default, four of the reference's continuum"
            ),
        ],
        "versions": Versions,
    },
)
