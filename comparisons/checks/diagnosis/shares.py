"""Which few parts of a model explain what an engine has beside what it should have."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ....reference.scene import Array

VISIBLE = 1e-2
"""A share that rounding could move by more cannot be told."""

APART = 1e-6
"""Share of a part that others could stand for, above which they cannot all be told apart."""

DISTINCT = 1e-9
"""Parts whose forces differ by less count as the same."""

RUNNER_UP = 10.0
"""How many times rounding every other explanation leaves at least, where one is named."""

ROWS = 2
"""Least number of rows for each share where all are fit_effects together."""

MOST_OTHERS = 2
"""Most other explanations that are named beside one; where there are more, none is."""


class Effect(NamedTuple):
    """A part of a model, or what a reader of files may add or lose.

    Attributes
    ----------
    name : str
    columns : array (m, k)
        What it adds to the rows by each of k numbers, all 0 where an engine follows the file.
    words : callable
        Meaning of these numbers (k,); empty where no reader does that.
    added : bool
        Whether it is none of the file's parts.
    members : tuple of str
        Parts that it stands for, each by the same number.
    """

    name: str
    columns: Array
    words: Callable[[Array], str]
    added: bool = False
    members: tuple[str, ...] = ()

    @property
    def acting(self) -> int:
        """How many of its numbers change the rows."""
        return int(np.count_nonzero(np.any(self.columns, axis=0)))


class Fit(NamedTuple):
    """Numbers of some candidates, by how much rounding moves them, and what they leave.

    They are distinct where no other numbers leave the same.
    """

    effects: tuple[Effect, ...]
    values: tuple[Array, ...]
    moved: tuple[Array, ...]
    left: float
    distinct: bool = True

    @property
    def said(self) -> dict[str, str]:
        """Meaning of the numbers of each candidate."""
        return {one.name: one.words(x) for one, x in zip(self.effects, self.values, strict=True)}

    @property
    def is_meant(self) -> bool:
        """Whether the numbers are distinct, and each of them means something."""
        return self.distinct and all(self.said.values())


Others = Mapping[str, tuple[str, ...]]
"""In words, what would explain the same in place of a candidate."""


class Explanation(NamedTuple):
    """What explains the rows.

    Attributes
    ----------
    values : mapping of str to array (k,)
        Of each part and of what is added, beside what the file says.
    tolerances : mapping of str to array (k,)
        By how much rounding could move them.
    others : mapping of str to tuple of str
    added : tuple of str
        What an engine adds or loses that is no part, in words.
    left, granted : float
        What the shares of parts leave of the rows, and what rounding may.
    unique : bool
        Whether this explains all, and nothing else does.
    """

    values: Mapping[str, Array]
    tolerances: Mapping[str, Array]
    others: Others
    added: tuple[str, ...]
    left: float
    granted: float
    unique: bool


def explain(
    parts: Sequence[Effect], additions: Sequence[Effect], rows: Array, room: float
) -> Explanation:
    """Explain rows (m,) by shares of parts, and by what readers of files add or lose.

    By the fewest numbers that leave no more than rounding, if all others as few leave `RUNNER_UP`
    times that: those of one candidate, of two, or of all parts and up to two additions.

    Parameters
    ----------
    parts, additions : sequence of Effect
    rows : array (m,)
        What an engine has beside what it should have, relative.
    room : float
        What rounding may leave of a row.
    """
    granted, error = room * float(np.sqrt(len(rows))), float(np.linalg.norm(rows))
    whole = fit_effects(parts, rows, room)
    names = [one.name for one in parts]
    tolerances = dict(zip(names, whole.moved, strict=True))
    if error <= granted:
        values = dict(zip(names, whole.values, strict=True))
        return Explanation(values, tolerances, {}, (), whole.left, granted, True)
    values = {name: 0 * x for name, x in zip(names, whole.values, strict=True)}
    best = None
    if RUNNER_UP * granted < error < np.inf:
        shares = [one for one in (*parts, *kinds(parts)) if is_visible(one, room)]
        every = [*shares, *additions, *kinds(additions)]
        best = alone(every, rows, room) or in_pairs(every, rows, room)
        best = best or together(parts, additions, rows, room)
    if best is None:
        return Explanation(values, tolerances, {}, (), error, granted, False)
    fit, others = best
    for one, x, moved in zip(fit.effects, fit.values, fit.moved, strict=True):
        values |= dict.fromkeys(one.members or (one.name,), x)
        tolerances |= dict.fromkeys(one.members or (one.name,), moved)
    explained = np.sum([one.columns @ values[one.name] for one in parts], axis=0)
    added = tuple(
        ", or ".join([fit.said[one.name], *others.get(one.name, ())])
        for one in fit.effects
        if one.added
    )
    left = float(np.linalg.norm(rows - explained))
    return Explanation(values, tolerances, others, added, left, granted, True)


def is_visible(part: Effect, room: float) -> bool:
    """Return whether rounding moves the share of a part by little."""
    size, along = np.sum(np.abs(part.columns), axis=0), np.sum(part.columns**2, axis=0)
    return bool(part.acting and np.all(room * size[along > 0] < VISIBLE * along[along > 0]))


def kinds(parts: Sequence[Effect]) -> Iterator[Effect]:
    """Yield all candidates of each kind that has several, by one number."""
    for kind in dict.fromkeys(one.name.partition(".")[0] for one in parts):
        same = [one for one in parts if one.name.startswith(f"{kind}.") and one.acting]
        if len(same) > 1 and same[0].columns.shape[1] == 1:
            columns = np.sum([one.columns for one in same], axis=0)
            yield Effect(
                kind,
                columns,
                partial(words_of_all, same),
                same[0].added,
                tuple(one.name for one in same),
            )


def words_of_all(several: Sequence[Effect], x: Array) -> str:
    """Return what it means that several effects have the same number (1,)."""
    return "; ".join(one.words(x) for one in several)


def fit_effects(effects: Sequence[Effect], rows: Array, room: float) -> Fit:
    """Fit some candidates by least squares."""
    columns = np.hstack([np.zeros((len(rows), 0)), *(one.columns for one in effects)])
    size = np.max(np.abs(columns), axis=0, initial=0.0)
    acting = np.where(size > 0, size, 1.0)
    inverse = np.linalg.pinv(columns / acting, rcond=DISTINCT) / acting[:, None]
    distinct = bool(np.linalg.matrix_rank(columns / acting, DISTINCT) == np.count_nonzero(size))
    x = inverse @ rows
    moved = np.where(size > 0, room * np.sum(np.abs(inverse), axis=1), np.inf)
    ends = np.cumsum([one.columns.shape[1] for one in effects])[:-1]
    left = float(np.linalg.norm(rows - columns @ x))
    values, tolerances = (tuple(np.split(numbers, ends)) for numbers in (x, moved))
    return Fit(tuple(effects), values, tolerances, left, distinct)


def the_only(fits: Iterable[Fit], granted: float) -> tuple[Fit, Others] | None:
    """Return the fit that explains all, the smallest change of parts first.

    None where there is none, or where others explain as much that differ by more than one
    candidate.
    """
    near = [one for one in fits if one.left < RUNNER_UP * granted and one.is_meant]
    near.sort(
        key=lambda fit: (
            fit.left > granted,
            sum(one.added for one in fit.effects),
            0.0 if fit.effects[0].added else float(np.max(np.abs(fit.values[0]))),
        )
    )
    if not near or near[0].left > granted:
        return None
    first, *rivals = near
    others: dict[str, tuple[str, ...]] = {}
    for rival in rivals:
        mine = first.said.keys() - rival.said.keys()
        theirs = [text for name, text in rival.said.items() if name not in first.said]
        if any(one.members and mine < {*one.members} for one in rival.effects):
            continue  # the same part, with others of its kind that hardly act
        if len(mine) != 1 or len(theirs) != 1:
            return None
        (name,) = mine
        others[name] = (*others.get(name, ()), *theirs)
    return None if any(len(rest) > MOST_OTHERS for rest in others.values()) else (first, others)


def alone(every: Sequence[Effect], rows: Array, room: float) -> tuple[Fit, Others] | None:
    """Return the candidate of fewest numbers that explains all."""
    granted = room * float(np.sqrt(len(rows)))
    for count in sorted({one.acting for one in every} - {0}):
        fits = [fit_effects([one], rows, room) for one in every if one.acting == count]
        if any(one.left <= granted and one.is_meant for one in fits):
            return the_only(fits, granted)
    return None


def in_pairs(every: Sequence[Effect], rows: Array, room: float) -> tuple[Fit, Others] | None:
    """Return the two candidates, of one number each, that explain all."""
    single = [one for one in every if one.acting == one.columns.shape[1] == 1]
    if len(single) < 2:
        return None
    columns = np.hstack([one.columns / np.linalg.norm(one.columns) for one in single])
    along, both = columns.T @ rows, columns.T @ columns
    apart = np.maximum(1 - both**2, DISTINCT)
    explained = (along[:, None] ** 2 + along**2 - 2 * both * np.outer(along, along)) / apart
    near = (explained > (1 - APART) * float(rows @ rows)) & (apart > DISTINCT)
    pairs = [(single[i], single[j]) for i, j in combinations(range(len(single)), 2) if near[i, j]]
    fits = (fit_effects(pair, rows, room) for pair in pairs)
    return the_only(fits, room * float(np.sqrt(len(rows))))


def together(
    parts: Sequence[Effect], additions: Sequence[Effect], rows: Array, room: float
) -> tuple[Fit, Others] | None:
    """Return all parts, each by its share, with up to two additions, if they explain all.

    None where several parts could stand for another, or rows are too few to prove anything.
    """
    columns = np.hstack([one.columns for one in parts])
    columns = columns[:, np.any(columns, axis=0)]
    columns = columns / np.linalg.norm(columns, axis=0)
    basis, sizes, axes = np.linalg.svd(columns, full_matrices=False)
    count = len(sizes)
    if len(rows) < ROWS * count or sizes[-1] < APART * sizes[0]:
        return None

    def across(values: Array) -> Array:
        rest = values - basis @ (basis.T @ values)
        return np.asarray(rest - basis @ (basis.T @ rest))

    left, granted = across(rows), room * float(np.sqrt(len(rows)))
    wrong = np.abs(axes.T @ (basis.T @ rows / sizes)) > DISTINCT * np.linalg.norm(rows)
    seen = []
    for one in (*additions, *kinds(additions)):
        rest = one._replace(columns=across(one.columns))
        if np.linalg.norm(rest.columns) > APART * np.linalg.norm(one.columns):
            seen.append(rest)
            continue
        weights = np.abs(axes.T @ (basis.T @ one.columns / sizes[:, None]))
        those = np.any(weights > APART * np.max(weights), axis=1)
        if np.count_nonzero(those) > 1 and not np.any(those & ~wrong):
            return None
    best: tuple[Fit, Others] | None = (Fit((), (), (), 0.0), {})
    if np.linalg.norm(left) > granted:
        best = alone(seen, left, room) or in_pairs(seen, left, room)
    if best is None:
        return None
    effects = [one for one in (*additions, *kinds(additions)) if one.name in best[0].said]
    return fit_effects([*parts, *effects], rows, room), best[1]
