"""The attributes that a reader lost or scaled, found by what its accelerations differ in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ...reference.errors import MbcheckError
from .elements import SWITCHES, Compiled, ModelElement
from .reading import Edit

MAX_EDITS, TRIED_AGAIN = 8, 60
"""Largest number of edits of one explanation, and of edits that are tried again for the next."""

MIN_SHARE, OPEN_SHARE = 0.03, 0.3
"""Smallest share of the remaining squared gap that an edit must explain, and largest share of the
gap that an explanation may leave open."""

DEPENDENT = 1e-8
"""Share of an effect below which those of edits already selected have it, too."""

ALIKE, WHOLE = 0.999, 1e-3
"""Share of the best explanation from which another is as good, and distance from a complete loss
within which the complete loss is tried."""

FACTORS: Mapping[str, float] = {
    **dict.fromkeys(("opt.gravity", "opt.density", "opt.viscosity"), 0.0),
    **dict.fromkeys(("body_gravcomp", "body_ipos"), 0.0),
    **dict.fromkeys(("body_mass", "body_inertia"), 2.0),
    **dict.fromkeys(("dof_damping", "dof_armature", "dof_frictionloss"), 0.0),
    **dict.fromkeys(("jnt_stiffness", "qpos_spring", "jnt_limited", "jnt_actfrclimited"), 0.0),
    **dict.fromkeys(("jnt_axis",), -1.0),
    **dict.fromkeys(("tendon_stiffness", "tendon_damping", "tendon_lengthspring"), 0.0),
    **dict.fromkeys(("tendon_frictionloss", "tendon_limited", "eq_active0"), 0.0),
    **dict.fromkeys(("actuator_gear", "actuator_gainprm", "actuator_biasprm"), 0.0),
    **dict.fromkeys(("actuator_ctrllimited", "actuator_forcelimited", "geom_contype"), 0.0),
}
"""Field -> the factor of a complete loss, or of another value by which its effect is measured."""

INERTIAL = ("body_mass", "body_inertia", "body_ipos", "dof_armature")
"""Fields of which the mass matrix consists."""

MIN_CHANGE = 1e-4
"""Smaller relative changes of an attribute are not named; they follow errors of the fit."""

FACTORS_ALLOWED, POSITIVE_FACTORS = (-1e4, 1e4), (0.0, 100.0)
"""Bounds of the factors by which a reader may have scaled attributes, and those of `POSITIVE`.

The loss of all forces has the same effect as a mass a thousand times as large."""

MIN_INERTIA = 1e-3
"""Smallest factor of a mass or inertia: without any, no force is left over in a fit."""

POSITIVE = ("mass", "inertia", "damping", "armature", "stiffness", "frictionloss", "density")
"""Ends of fields that no reader makes negative."""

DISCRETE = ("jnt_axis", "eq_active0", "geom_contype", "limited")
"""Ends of fields that a reader either keeps or not; others may be scaled."""


@dataclass(frozen=True, eq=False)
class Guess:
    """An attribute, of one or of every element of a kind, that a reader may have multiplied.

    Attributes
    ----------
    element, attribute : str
        Labels.
    field : str
    rows : list of int or None
        Rows of the field; None for all of an option.
    values : array
        Values of the file.
    factor : float
        The factor of a complete loss.
    """

    element: str
    attribute: str
    field: str
    rows: list[int] | None
    values: Any
    factor: float

    @property
    def is_discrete(self) -> bool:
        """True if a reader either keeps it or not."""
        return self.field.endswith(DISCRETE)

    def is_lost(self, factor: float) -> bool:
        """Return True if a factor is the one of a complete loss."""
        return self.is_discrete or abs(factor - self.factor) < WHOLE

    def allows(self, factor: float) -> bool:
        """Return True if a reader may have multiplied the attribute by a factor."""
        low, high = POSITIVE_FACTORS if self.field.endswith(POSITIVE) else FACTORS_ALLOWED
        if self.field in ("body_mass", "body_inertia"):
            return MIN_INERTIA < factor < high
        return self.is_discrete or low - WHOLE < factor < high

    def edit(self, factor: float) -> Edit:
        """Return the edit of a model by a factor, by that of a complete loss if it is discrete."""
        return (
            self.field,
            self.rows,
            ((self.factor if self.is_discrete else factor) * self.values).tolist(),
        )

    def cells(self, factor: float) -> tuple[list[Any], list[Any]]:
        """Return values of the file and those read; of several elements the factor alone."""
        if self.is_discrete and self.factor == 0:
            return [], ["none"]
        if self.element.startswith("every ") and factor != 0:
            return [], [f"{factor:.6g} times as large"]
        values = np.ravel(self.values)
        return values.tolist(), (factor * values).tolist()


def guesses(model: Compiled, elements: Sequence[ModelElement]) -> Iterator[Guess]:
    """Yield the losses of each attribute: of all elements of a kind together, and of each."""
    for field, factor in FACTORS.items():
        singles = []
        for element in elements if field in model.answer else ():
            for attribute, one in element.attributes.items():
                switched = field in (SWITCHES.get(name) for name in one.rows)
                if not switched and field not in one.rows:
                    continue
                rows = [element.number] if switched else one.rows[field]
                values = np.asarray(model.field(field), dtype=float)
                values = values if rows is None else values[rows]
                if values.any():
                    singles.append(Guess(element.label, attribute, field, rows, values, factor))
        if len(singles) > 1:
            every = f"every {singles[0].element.partition(' ')[0]}"
            rows = [row for one in singles for row in one.rows or ()]
            values = np.concatenate([one.values for one in singles])
            yield Guess(every, singles[0].attribute, field, rows, values, factor)
        yield from singles


def find_edits(
    gap: Callable[[Sequence[Edit]], Any],
    is_closed: Callable[[Sequence[Edit]], bool],
    candidates: Sequence[Guess],
) -> list[tuple[Guess, float]]:
    """Return the edits, each with its factor, that together close most of a gap.

    One edit after the other is selected, by the part of the remaining gap that it explains after
    all factors are fitted again (orthogonal least squares); they are then fitted.

    Parameters
    ----------
    gap : callable ``(edits) -> array (m,)``
        Differences of accelerations after edits, weighted.
    is_closed : callable ``(edits) -> bool``
        True if nothing is left beyond round-off.
    candidates : sequence of Guess

    References
    ----------
    Chen, Billings and Luo, Orthogonal least squares methods and their application to non-linear
    system identification, International Journal of Control 50 (1989).
    """
    start = left = gap(())
    picks: list[Guess] = []
    factors = np.zeros(0)

    def edits(values: Any) -> list[Edit]:
        return [one.edit(float(factor)) for one, factor in zip(picks, values, strict=True)]

    def remaining(values: Any, *more: Edit) -> Any:
        try:
            after = gap([*edits(values), *more])
        except MbcheckError:  # of a model that cannot be simulated
            after = np.full_like(start, np.inf)
        return after if np.all(np.isfinite(after)) else np.full_like(start, np.linalg.norm(start))

    def is_allowed() -> bool:
        return all(map(Guess.allows, picks, factors))

    while len(picks) < MAX_EDITS and not (is_allowed() and is_closed(edits(factors))):
        scaled = np.flatnonzero([not one.is_discrete for one in picks])
        moved = [left - remaining(factors + unit) for unit in np.eye(len(picks))[scaled]]
        basis = np.linalg.qr(np.reshape(moved, (-1, len(left))).T)[0]
        gains: dict[Guess, tuple[float, float]] = {}
        for guess in candidates:
            whole = left - remaining(factors, guess.edit(guess.factor))
            effect = whole - basis @ (basis.T @ whole)
            if guess not in picks and np.linalg.norm(effect) > DEPENDENT * np.linalg.norm(whole):
                share = 1.0 if guess.is_discrete else float(left @ effect / (effect @ effect))
                gains[guess] = float(left @ left - np.sum((left - share * effect) ** 2)), share
        candidates = sorted(gains, key=lambda one: gains[one][0], reverse=True)[:TRIED_AGAIN]
        if not gains or gains[candidates[0]][0] < MIN_SHARE * float(left @ left):
            break
        alike = [one for one in candidates if gains[one][0] >= ALIKE * gains[candidates[0]][0]]
        pick = min(alike, key=lambda one: abs(gains[one][1] - 1))
        picks.append(pick)
        first = np.append(factors, 1 + gains[pick][1] * (pick.factor - 1))
        factors = fitted(remaining, first, np.array([one.factor for one in picks]))
        left = remaining(factors)
    if not is_allowed():
        return []
    pairs = zip(picks, factors.tolist(), strict=True)
    return [(one, f) for one, f in pairs if one.is_discrete or abs(f - 1) > MIN_CHANGE]


def fitted(remaining: Callable[[Any], Any], factors: Any, whole: Any) -> Any:
    """Return the factors that leave least of a gap; complete losses where these do as well."""
    best = refitted(remaining, factors, np.ones(len(factors), dtype=bool))
    lost = abs(best - whole) < WHOLE
    rounded = np.where(lost, whole, best)
    if lost.any() and not lost.all():
        rounded = refitted(remaining, rounded, ~lost)
    ends = [float(np.linalg.norm(remaining(one))) for one in (rounded, best)]
    return rounded if ends[0] <= 2 * ends[1] else best


def refitted(remaining: Callable[[Any], Any], factors: Any, free: Any) -> Any:
    """Return the factors of which those that are free leave least of a gap."""

    def placed(values: Any) -> Any:
        every = factors.copy()
        every[free] = values
        return every

    return placed(
        least_squares(
            lambda values: remaining(placed(values)), factors[free],
            diff_step=1e-4, max_nfev=12, xtol=1e-15, ftol=1e-15, gtol=1e-15,
        ).x
    )  # fmt: skip
