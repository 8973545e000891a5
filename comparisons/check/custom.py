"""Checks at a user's own parameters: their case, and the range in which the reference can judge."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.cost import expected_end
from ...reference.equations import scene_equations
from ...reference.errors import MbcheckError, NoOrbitError, UsageError
from ...reference.orbits import state_scale
from ...reference.scene import Array, Case
from ..checks.comparison import drifts
from ..checks.kinds.stability import PERIODS
from ..checks.orbits import true_orbit
from ..checks.suite import Check
from ..checks.table import KINDS
from ..checks.truth import (
    MOST_AMPLIFICATION,
    MOST_STEPS,
    Truth,
    moves,
    permitted_horizon,
    sample_spacing,
    truth,
)
from ..engines.setup import STEPS_PER_PERIOD, shortest_period
from ..queries.request import Query
from ..reports.run.outcome import CustomReference

NAME = "custom"
"""The name of the case in ids."""

USUAL_PERIODS = 32
"""Most periods of the fastest motion in a default horizon."""

LEAST_PERIODS = 0.25
"""Least periods of the fastest motion in a horizon: a few steps of the best method."""

MOST_PERIODS = MOST_STEPS // min(STEPS_PER_PERIOD.values())
"""Most periods of the fastest motion in a horizon: no method is followed for longer."""

SINGULAR = 1e-9
"""Smallest eigenvalue of a mass matrix below which a position is singular, relative to the
inertias of the coordinates elsewhere."""

POSITIONS = 16
"""Number of positions at which these inertias are evaluated."""

RESOLVED = 1e-4
"""Largest error bound of a reference that can judge an engine, in the size of each observable: a
tenth of the effect of a mass with an error of 0.1 %."""

CONSERVED = 1e-8
"""Largest relative drift over the reference of a quantity that counts as conserved."""


@dataclass(frozen=True)
class CustomCase:
    """A user's own case, with the reference's solution as far as it can judge an engine.

    Attributes
    ----------
    case : Case
    solution : Truth
        Observables and states of the reference.
    reference : CustomReference
        Summary of the reference for reports.
    """

    case: Case
    solution: Truth
    reference: CustomReference

    def cases(self, full: bool) -> tuple[Case, ...]:
        """Return the case of runs, of elements where the scene is a continuum, and of the orbit.

        Unless ``full``, the orbit is followed by the best method of each model.
        """
        case = self.case
        orbit = replace(case, kinds=("stability",), methods="all" if full else "best")
        if get_scene(case.scene).continuum.spectrum:
            elements = replace(case, kinds=("frequency", "order"), watch="elements")
            return replace(case, kinds=("algebra", "trajectory", "energy")), elements, orbit
        own = (name for name, kind in KINDS.items() if not kind.follows and name != "stability")
        return replace(case, kinds=tuple(own)), orbit


def custom_case(
    scenes: Sequence[str],
    parameters: Mapping[str, Any] | None,
    state: Mapping[str, float] | None,
    horizon: float | None,
) -> CustomCase:
    """Return the case that a user describes, and how far the reference can judge it.

    Raises
    ------
    UsageError
        For unknown names or impossible values, unless exactly one scene is named, or where no
        reference can judge a run.
    """
    if len(set(scenes)) != 1:
        raise UsageError("--set, --state and --horizon need exactly one scene: name it")
    case = replace(Query(scenes[0], parameters=parameters, state=state).case, name=NAME)
    try:
        case, source = with_horizon(case, horizon)
        refuse_singular(case)
        with expected_end(case.start_time + case.horizon):
            permitted, growth = permitted_horizon(case)
            fastest = shortest_period(case)
            if permitted < LEAST_PERIODS * fastest:
                raise UsageError(
                    f"errors grow too fast for a reference: by {growth:.3g} in {permitted:.3g} s "
                    f"and more than {MOST_AMPLIFICATION:g} soon after, while the fastest motion "
                    f"takes {fastest:.3g} s; choose other parameters or another state"
                )
            solution = reference_of(case, permitted)
    except UsageError:
        raise
    except (MbcheckError, ArithmeticError, np.linalg.LinAlgError) as error:
        raise UsageError(
            f"no reference can judge {case.scene} here: {error}; choose other parameters, "
            "another state or a shorter horizon"
        ) from error
    case = replace(case, about=place_of_rest(case))
    scene = get_scene(case.scene)
    bounds = dict(zip(scene.observables, map(float, solution.bound), strict=True))
    units = {name: scene.units[name] for name in scene.observables}
    reference = CustomReference(case.horizon, source, permitted, growth, bounds, units)
    return CustomCase(case, solution, reference)


def with_horizon(case: Case, horizon: float | None) -> tuple[Case, str]:
    """Return the case with its horizon, and what that follows from.

    By default it lasts as many periods as the scene's first case, at most `USUAL_PERIODS` of the
    fastest motion.

    Raises
    ------
    UsageError
        For a horizon that shows too little of the fastest motion, or more than any method is
        followed for.
    """
    scene = get_scene(case.scene)
    fastest = shortest_period(case)
    if horizon is None:
        first = scene.cases[0]
        periods = first.horizon / float(scene.period(first.parameters))
        usual = periods * float(scene.period(case.parameters))
        if usual > USUAL_PERIODS * fastest:
            limit = f"{USUAL_PERIODS} periods of the fastest motion"
            return replace(case, horizon=USUAL_PERIODS * fastest), limit
        source = f"{periods:.3g} periods, as the case {first.name}"
        return replace(case, horizon=max(usual, LEAST_PERIODS * fastest)), source
    least, most = LEAST_PERIODS * fastest, MOST_PERIODS * fastest
    if not least <= horizon <= most:
        raise UsageError(
            f"--horizon {horizon:g}: choose {least:.3g} to {most:.3g} s, {LEAST_PERIODS} to "
            f"{MOST_PERIODS} periods of the fastest motion here"
        )
    return replace(case, horizon=horizon), "as given"


def refuse_singular(case: Case) -> None:
    """Refuse a start where a motion of the mechanism has no inertia, as at a dead centre.

    Raises
    ------
    UsageError
    """
    scene = get_scene(case.scene)
    c, start = scene.coefficients(case.parameters), scene.state(case.state)
    n = len(scene.coordinates)
    turns = np.random.default_rng(0).uniform(-np.pi, np.pi, (POSITIONS, n))
    angles = np.array([scene.units[name] == "rad" for name in scene.coordinates])
    positions = np.where(angles, turns, start[:n])
    matrices = [np.array(scene.mass_matrix(q, c), dtype=float) for q in (start[:n], *positions)]
    size = np.sqrt(np.max([np.abs(np.diag(matrix)) for matrix in matrices], axis=0))
    if np.min(np.linalg.eigvalsh(matrices[0] / np.outer(size, size))) < SINGULAR:
        raise UsageError(
            f"{case.scene} starts in a singular position (a dead centre: some motion has no "
            "inertia there), where no reference can judge; choose another --state"
        )


def reference_of(case: Case, permitted: float) -> Truth:
    """Return the reference's solution of a case over the permitted part [s] of its horizon.

    Raises
    ------
    UsageError
        If its own error may be too large to judge an engine.
    """
    names = get_scene(case.scene).observables
    spacing = sample_spacing(permitted)
    times = case.start_time + spacing * np.arange(1, int(permitted / spacing) + 1)
    solution = truth(scene_equations(case), case, times, names)
    for name, bound, size in zip(names, solution.bound, solution.size, strict=True):
        if not bound <= RESOLVED * size:
            raise UsageError(
                f"the reference may itself be off by {bound / size:.2g} of {name}: too much to "
                "judge an engine; choose other parameters, another state or a shorter horizon"
            )
    return solution


def place_of_rest(case: Case) -> str | None:
    """Return the scene's first state of rest that there is at these parameters."""
    for name, place in get_scene(case.scene).equilibria.items():
        try:
            place(get_scene(case.scene).unforced(case.parameters))
        except NoOrbitError:
            continue
        return name
    return None


# Kinds that do not apply ----------------------------------------------------------------------


def applied(checks: Sequence[Check], custom: CustomCase) -> list[Check]:
    """Return checks, with why those are skipped that do not apply."""
    why_of = cache(partial(why_inapplicable, custom))
    skipped = []
    for check in checks:
        reason = why_of(check.kind)
        if not reason and check.kind == "order" and check.case.watch == "elements":
            reason = "the number of elements from which they converge as declared is unknown"
        if not reason and check.kind == "algebra":
            setup = check.setup()
            if setup.bound.approximates_continuum and not setup.bound.discrete:
                reason = "elements converge to the continuum, and have no closed form"
        skipped.append(replace(check, unsupported_reason=reason or check.unsupported_reason))
    return skipped


def why_inapplicable(custom: CustomCase, kind: str) -> str:
    """Return the reason for which a kind of check does not apply; empty if it does."""
    return next(filter(None, (MISSING[need](custom) for need in KINDS[kind].needs)), "")


def why_no_rest(custom: CustomCase) -> str:
    """Return a reason if there is no state of rest; empty otherwise."""
    return "" if custom.case.about else "these parameters leave the scene no state of rest"


def why_no_motion(custom: CustomCase) -> str:
    """Return a reason if no coordinate moves; empty otherwise."""
    coordinates = custom.solution.states[: len(get_scene(custom.case.scene).coordinates)]
    return "" if moves(coordinates) else "nothing moves from this state: give --state"


def why_no_orbit(custom: CustomCase) -> str:
    """Return a reason if no run can stay on a periodic orbit; empty otherwise."""
    case, scene = custom.case, get_scene(custom.case.scene)
    try:
        orbit = true_orbit(case.scene, case.parameters)
    except NoOrbitError as error:
        return str(error)
    scale = state_scale(scene, orbit.state, 2 * np.pi / orbit.period)
    growth = float(np.linalg.norm(orbit.monodromy * scale / scale[:, None], 2))
    if growth**PERIODS > MOST_AMPLIFICATION:
        return f"errors grow by a factor of {growth:.3g} per period: no run stays on the orbit"
    return ""


def why_no_energy(custom: CustomCase) -> str:
    """Return a reason if an invariant drifts or starts near 0; empty otherwise."""
    case, equations = custom.case, scene_equations(custom.case)
    end = float(equations.scene.drive_end_time(case.parameters))
    if end >= custom.reference.permitted:
        return f"the scene is driven until t = {end:.3g} s, and the run ends before"
    states: Mapping[str, Array] = dict(
        zip(equations.scene.state_names, custom.solution.states, strict=True)
    )
    with np.errstate(all="ignore"):
        by_name = drifts(equations, case, custom.solution.times, states)
    for name, drift in by_name.items():
        if not np.max(np.abs(drift)) < CONSERVED:
            return f"{name} is not conserved here, or starts near 0"
    return ""


MISSING: Mapping[str, Callable[[CustomCase], str]] = {
    "rest": why_no_rest,
    "motion": why_no_motion,
    "orbit": why_no_orbit,
    "conserved": why_no_energy,
}
"""Requirement of a kind of check -> function that gives the reason if a case lacks it."""
