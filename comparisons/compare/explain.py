"""The attributes that a reader lost or scaled, found by what its accelerations differ in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ...reference.errors import MbcheckError
from .elements import Compiled, ModelElement
from .reading import Edit

MAX_EDITS = 8
"""Largest number of edits that explain one gap."""

MIN_SHARE = 0.03
"""Smallest share of the remaining squared gap that an edit must explain."""

CLOSED_SHARE = 0.3
"""Share of the gap that edits may leave open and still be reported."""

ALIKE = 0.999
"""Edits that explain this share of what the best one explains are taken for as good; the one that
is nearest to a complete loss is chosen."""

TRIED_AGAIN = 60
"""Number of edits that are tried again after the first one is chosen."""

WHOLE = 1e-3
"""Distance from a complete loss within which a complete loss is tried."""


def nothing(values: Any) -> Any:
    """Return zeros."""
    return 0 * values


def twice(values: Any) -> Any:
    """Return values multiplied by 2."""
    return 2 * values


def reversed_sign(values: Any) -> Any:
    """Return values multiplied by -1."""
    return -values


def default_solref(values: Any) -> Any:
    """Return MJCF's default time constant and damping ratio."""
    return 0 * values + [0.02, 1.0]


EVERY = "every"
"""First word of the label of all elements of a kind."""

LOSSES: Mapping[str, Callable[[Any], Any]] = {
    "opt.gravity": nothing,
    "opt.density": nothing,
    "opt.viscosity": nothing,
    "body_gravcomp": nothing,
    "body_mass": twice,
    "body_inertia": twice,
    "body_ipos": nothing,
    "dof_damping": nothing,
    "dof_armature": nothing,
    "dof_frictionloss": nothing,
    "jnt_stiffness": nothing,
    "jnt_axis": reversed_sign,
    "jnt_limited": nothing,
    "jnt_actfrclimited": nothing,
    "qpos_spring": nothing,
    "tendon_stiffness": nothing,
    "tendon_damping": nothing,
    "tendon_frictionloss": nothing,
    "tendon_limited": nothing,
    "tendon_lengthspring": nothing,
    "eq_active0": nothing,
    "eq_solref": default_solref,
    "actuator_gear": nothing,
    "actuator_gainprm": nothing,
    "actuator_biasprm": nothing,
    "actuator_ctrllimited": nothing,
    "actuator_forcelimited": nothing,
    "geom_contype": nothing,
}
"""Field -> a value that readers give it, or one on the way from the file's to theirs."""

DISCRETE = ("jnt_axis", "eq_active0", "geom_contype", "solref", "limited")
"""Ends of fields that a reader either keeps or not; others may be scaled."""

SWITCHES = {
    "jnt_range": "jnt_limited",
    "jnt_actfrcrange": "jnt_actfrclimited",
    "tendon_range": "tendon_limited",
    "actuator_ctrlrange": "actuator_ctrllimited",
    "actuator_forcerange": "actuator_forcelimited",
    "eq_type": "eq_active0",
}
"""Field -> the field that switches it on."""


@dataclass(frozen=True)
class Guess:
    """An edit that a reader may have made: an attribute of one or of all elements of a kind.

    Attributes
    ----------
    element, attribute : str
        Labels.
    field : str
    rows : list of int or None
        Rows of the field; None for all of an option.
    before, after : array
        Values of the file, and of a complete loss.
    """

    element: str
    attribute: str
    field: str
    rows: list[int] | None
    before: Any
    after: Any

    @property
    def is_discrete(self) -> bool:
        """True if a reader either keeps it or not."""
        return self.field.endswith(DISCRETE)

    def value(self, share: float) -> Any:
        """Return the values at a share of the way from the file's to a complete loss."""
        return self.before + share * (self.after - self.before)

    def cells(self, share: float) -> tuple[Any, Any]:
        """Return values of the file and those read; of several elements the factor alone."""
        read = self.value(share)
        if self.field.endswith("limited") or self.field.endswith("active0"):
            return [], ["none"]
        if not self.element.startswith(EVERY) or not read.any():
            return self.before.ravel().tolist(), read.ravel().tolist()
        at = np.unravel_index(int(np.argmax(abs(self.before))), self.before.shape)
        return [], [f"{read[at] / self.before[at]:.6g} times as large"]

    def edits(self, share: float = 1.0) -> list[Edit]:
        """Return the edit of a model at this share."""
        return [(self.field, self.rows, self.value(share).tolist())]


def guesses(model: Compiled, elements: Sequence[ModelElement]) -> Iterator[Guess]:
    """Yield the losses of each attribute: of all elements of a kind together, and of each."""
    for field, lose in LOSSES.items():
        key = field if field.startswith("opt.") else f"model.{field}"
        if key not in model.answer:
            continue
        singles = []
        for element in elements:
            for attribute, rows in rows_of(element, field):
                before = np.array(model.answer[key], dtype=float)
                before = before if rows is None else before[rows]
                after = lose(before)
                if not np.array_equal(before, after):
                    singles.append(Guess(element.label, attribute, key, rows, before, after))
        if len(singles) > 1:
            before, after = (
                np.concatenate([getattr(one, side) for one in singles])
                for side in ("before", "after")
            )
            rows = [row for one in singles for row in one.rows or ()]
            kind = singles[0].element.partition(" ")[0]
            yield Guess(f"{EVERY} {kind}", singles[0].attribute, key, rows, before, after)
        yield from singles


def rows_of(element: ModelElement, field: str) -> Iterator[tuple[str, list[int] | None]]:
    """Yield the attribute of an element that a field holds, and its rows of the field."""
    for attribute, one in element.attributes.items():
        if field in one.rows:
            rows = one.rows[field]
            yield attribute, None if rows is None else list(map(int, rows))
        elif field in (SWITCHES.get(name) for name in one.rows):
            yield attribute, [element.number]


def explain(
    gap: Callable[[Sequence[Edit]], Any],
    is_closed: Callable[[Sequence[Edit]], bool],
    candidates: Sequence[Guess],
) -> list[tuple[Guess, float]]:
    """Return the edits, each with its share, that together close most of a gap.

    One edit after the other is chosen, by the part of the remaining gap that it explains, as in
    orthogonal matching pursuit; all shares are then fitted again by least squares.

    Parameters
    ----------
    gap : callable ``(edits) -> array (m,)``
        Differences of accelerations after edits, weighted.
    is_closed : callable ``(edits) -> bool``
        True if nothing is left beyond round-off.
    candidates : sequence of Guess

    References
    ----------
    Mallat and Zhang, Matching pursuits with time-frequency dictionaries, IEEE Transactions on
    Signal Processing 41 (1993).
    """
    start = left = gap(())
    chosen: list[Guess] = []
    shares = np.zeros(0)

    def edits_at(values: Any) -> list[Edit]:
        return [e for guess, s in zip(chosen, values, strict=True) for e in guess.edits(float(s))]

    def remaining(values: Any) -> Any:
        after = attempted(gap, edits_at(values))
        return np.full(len(start), np.linalg.norm(start)) if after is None else after

    while len(chosen) < MAX_EDITS and not is_closed(edits_at(shares)):
        trials = list[Trial]()
        for guess in candidates:
            after = attempted(gap, [*edits_at(shares), *guess.edits()])
            if guess not in chosen and after is not None and np.any(after != left):
                trials.append(Trial(guess, left, left - after))
        best = max((one.gain for one in trials), default=0.0)
        if best < MIN_SHARE * float(left @ left):
            break
        alike = [one for one in trials if one.gain >= ALIKE * best]
        pick = min(alike, key=lambda one: abs(one.share - 1))
        chosen.append(pick.guess)
        shares = fitted(remaining, np.append(shares, pick.share), chosen)
        left = remaining(shares)
        ranked = sorted(trials, key=lambda one: one.gain, reverse=True)
        candidates = [one.guess for one in ranked[:TRIED_AGAIN]]
    if np.linalg.norm(left) > CLOSED_SHARE * np.linalg.norm(start):
        return []
    return list(zip(chosen, shares.tolist(), strict=True))


class Trial:
    """An edit that is tried: its share, and the part of the squared gap that it explains."""

    def __init__(self, guess: Guess, left: Any, effect: Any) -> None:
        self.guess = guess
        self.share = 1.0 if guess.is_discrete else float(left @ effect / (effect @ effect))
        after = left - self.share * effect
        self.gain = float(left @ left - after @ after)


def attempted(gap: Callable[[Sequence[Edit]], Any], edits: Sequence[Edit]) -> Any:
    """Return a gap after edits, or None if they cannot be made."""
    try:
        after = gap(edits)
    except MbcheckError:
        return None
    return after if np.all(np.isfinite(after)) else None


def fitted(remaining: Callable[[Any], Any], shares: Any, chosen: Sequence[Guess]) -> Any:
    """Return the shares that leave least of a gap; complete losses where these do as well."""
    free = np.array([not guess.is_discrete for guess in chosen])

    def full(values: Any) -> Any:
        every = shares.copy()
        every[free] = values
        return every

    if free.any():
        done = least_squares(
            lambda x: remaining(full(x)), shares[free], diff_step=1e-4, max_nfev=12,
            xtol=1e-15, ftol=1e-15, gtol=1e-15,
        )  # fmt: skip
        shares = full(done.x)
    rounded = np.where(abs(shares - 1) < WHOLE, 1.0, shares)
    ends = [float(np.linalg.norm(remaining(one))) for one in (rounded, shares)]
    return rounded if ends[0] <= 2 * ends[1] else shares
