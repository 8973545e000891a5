"""What a user's model needs, in words."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from ...reports.words import plural
from .converged import DEPARTURE, SHARPEST, percent
from .outcome import MARGIN, RELIABLE, Outcome, Trial
from .runs import CONVERGED

SOFT = 0.1
"""Share of the target from which on the softness of closures is told."""


def sentence(advice: Outcome) -> str:
    """Return what to do, in one sentence."""
    choice, own, asked = advice.choice, advice.own, advice.asked
    if not advice.truths:
        words = "nothing converges" if advice.complete else f"no answer in {asked.budget:g} s"
        return f"{words}: " + "; ".join(advice.unknown)
    over = f"over {advice.compared:.3g} s"
    if own is None:
        return f"no setting was tried in {asked.budget:g} s; --budget gives more"
    if choice is None:
        errors = {x.setting: max(x.error, advice.missed.get(x.setting, 0.0)) for x in advice.trials}
        best = min(errors, key=lambda setting: errors[setting])
        if errors[best] == inf:
            return f"no setting came to an end {over}"
        where = "from other starts, too" if advice.missed else "with a margin"
        return (
            f"no setting meets {percent(asked.target)} {where} {over}; the least error is "
            f"{percent(errors[best])}, of {best.name}"
        )
    said = f"{choice.setting.name}: {percent(max(choice.error, advice.elsewhere))} {over}"
    if choice is own:
        return f"{said}, the file's own setting"
    fewer = own.work / choice.work
    compared = f"{fewer:.2g} times fewer evaluations of forces than" if fewer > 1 else ""
    compared = compared or f"{1 / fewer:.2g} times as many evaluations of forces as"
    compared = "as many evaluations of forces as" if fewer == 1 else compared
    compared += " the file's setting"
    mine = "which loses its state" if own.failed else f"which errs by {percent(own.error)}"
    if MARGIN * asked.target < own.error <= asked.target:
        mine += ": no margin for other motions"
    return f"{said}, {compared} ({own.setting.name}, {mine})"


def notes(advice: Outcome) -> list[str]:
    """Return what else is to be known."""
    target = advice.asked.target
    said = [f"left out: {one}" for one in advice.unknown if advice.truths]
    for truth, count in zip(advice.truths, advice.counts, strict=True):
        if count < len(truth.error):
            over = f"compared over {count * advice.period:.3g} s"
            said.append(f"{truth.start.name}: {truth.reason(target)}; {over}")
    usual = advice.trials[0].step / CONVERGED if advice.trials else 0.0
    for truth in advice.truths:
        by, step = truth.setting.integrator, truth.setting.step
        if by != SHARPEST[0] or (usual and step < 0.99 * usual):
            said.append(
                f"{truth.start.name}: the converged run is by {by} at {1e3 * step:.3g} ms; "
                f"longer steps, or {SHARPEST[0]}, do not do"
            )
    if any(not truth.smooth for truth in advice.truths):
        said.append(
            "contacts, limits or friction act: errors have no order, and no bound; a start "
            f"that is {DEPARTURE:g} off ends {percent(advice.largest('spread'))} apart"
        )
    said += softness(advice)
    if (least := advice.least_iterations) is not None:
        words = f"{plural(least[1], 'iteration')} of the solver"
        said.append(f"{words} leave the error of {least[0].setting.name} as it is")
    said += [
        f"{setting.name} errs by {percent(error)} from other starts or with other controls, and is "
        "not recommended"
        for setting, error in advice.missed.items()
    ]
    if advice.choice is not None and not advice.proved:
        said.append("there was no time to try the choice from other starts and with other controls")
    said += [f"the choice was not tried from {one}" for one in advice.unproved if advice.choice]
    said += disagreements(advice.trials)
    if not advice.complete:
        said.append(
            f"not all was tried in {advice.asked.budget:g} s; --budget gives more, and --resume "
            "goes on from what was kept"
        )
    return said


def softness(advice: Outcome) -> list[str]:
    """Return what the softness of closures comes to, if it matters for the target."""
    soft = advice.largest("softness")
    if not advice.softens or soft < SOFT * advice.asked.target:
        return []
    words = f"closures as soft as in the file move {percent(soft)} otherwise than hard ones"
    more = "" if advice.asked.exact else "; --exact-closures compares with those"
    return [words + more]


def disagreements(trials: Sequence[Trial]) -> list[str]:
    """Return where limits of small motions and runs say different things."""
    said = []
    every = [one for one in trials if one.setting[2:] == (None, None)]
    for name in dict.fromkeys(one.integrator for one in every):
        mine = [one for one in every if one.integrator == name]
        limit = mine[0].limit
        lost = [one.step for one in mine if one.failed and one.step < limit / RELIABLE]
        harmless = [one.step for one in mine if one.error < 0.1 and one.step > RELIABLE * limit]
        if lost:
            words = f"below its limit of small motions, {1e3 * limit:.4g} ms"
            words = words if limit < inf else "though small motions limit no step"
            said.append(f"{name} loses its state at {1e3 * min(lost):.4g} ms, {words}")
        if harmless:
            said.append(
                f"{name} at {1e3 * max(harmless):.4g} ms is above its limit of small motions, "
                f"{1e3 * limit:.4g} ms: over this time it came to no harm, and is not recommended"
            )
    return said


def legend(advice: Outcome) -> str:
    """Return what the table shows."""
    known = percent(advice.largest("error"))
    return (
        f"> chosen, * on the front, = as in the file. error: the largest of {what(advice)} over "
        f"{advice.compared:.3g} s from {plural(len(advice.truths), 'start')}, in the size of the "
        f"motion; the converged run is known to {known}. energy: largest difference from the "
        "converged run's, in the largest kinetic energy. violation: how far an equality opens "
        "(m, rad). time: of the processor, median of the runs on this machine. limit: the largest "
        "stable step of small motions."
    )


def what(advice: Outcome) -> str:
    """Return what is compared, in words."""
    return ", ".join(advice.asked.observed) or "all joints"
