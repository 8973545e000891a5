"""Random parameters, states, models, methods and steps: nothing may be wrong in silence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds import pushed
from mbcheck.comparisons.checks.verdict import REFERENCE
from mbcheck.comparisons.engines.isolation import STATM, isolated
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.catalogue import ENGINES
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.reference import SCENES
from mbcheck.tests.support import draws
from mbcheck.tests.support.draws import (
    Draw,
    drawn,
    result_of_draw,
    result_of_outcome,
    silent,
)

SECONDS, MEGABYTES = 60.0, 4000.0 if STATM.exists() else None
"""Contained, not waited for: no draw takes as long."""

COUNTS: Mapping[str, int] = {
    "hula_hoop": 300,
    "rotor_pendulum": 300,
    "rotating_beam": 100,
    "speed_regulator": 300,
    "rigid_body": 100,
    "ball_hoop": 100,
    "floating_platform": 100,
    "floating_beam": 100,
}
"""Draws of each scene, half of them by each engine: 1,400, a campaign. The first of each thirty
are slow tests, beside `FOUND` and `FEW` by default.
"""


FOUND: Mapping[str, tuple[Draw, str]] = {
    "euler_light_rod": (
        Draw(
            "hula_hoop", "mujoco", 188, 4, 295,
            (-316, -167, -128, 8, -124, 271, -49, 4, 165), (-148, 427, 271, 427),
        ),
        "5 % off as predicted, where coarse_step spoke from 60 % on: now from half of LOST on",
    ),
    "euler_heavy_mass": (
        Draw(
            "hula_hoop", "mujoco", 236, 4, 154,
            (359, 257, -303, 360, 202, 259, 359, -216, -303), (-216, 360, 360, 60),
        ),
        "5 % off as predicted, where coarse_step spoke from 60 % on: now from half of LOST on",
    ),
    "index_2_from_rest": (
        Draw("rotor_pendulum", "exudyn", 579, 0, 0, (0,) * 14, (0,) * 8),
        "the opening of a loop that has hardly moved was taken for an error of the motion",
    ),
    "index_2_from_rest_again": (
        Draw("rotor_pendulum", "exudyn", 689, 0, 0, (0,) * 14, (0,) * 8),
        "the opening of a loop that has hardly moved was taken for an error of the motion",
    ),
}  # fmt: skip
"""Draws that were wrong in silence, and what was mended."""


FEW: Mapping[tuple[str, str], tuple[int, int]] = {
    ("ball_hoop", "exudyn"): (1, 3),
    ("ball_hoop", "mujoco"): (0, 2),
    ("floating_beam", "exudyn"): (1, 3),
    ("floating_platform", "exudyn"): (0, 2),
    ("rigid_body", "mujoco"): (0, 2),
}
"""Draws of a scene by an engine that have a reference, or need none; the first two of others do."""


@pytest.mark.parametrize("engine", sorted(ENGINES))
@pytest.mark.parametrize("scene", sorted(set(SCENES) - {"rotating_beam"}))
def test_a_few_draws(scene: str, engine: str) -> None:
    places = FEW.get((scene, engine), (0, 1))
    draws = drawn(scene, engine, max(places) + 1)
    for row in map(result_of_draw, [draws[place] for place in places]):
        assert not silent(row), row


@pytest.mark.parametrize(
    "share", [pytest.param(30, marks=pytest.mark.slow), pytest.param(1, marks=pytest.mark.campaign)]
)
@pytest.mark.parametrize("engine", sorted(ENGINES))
@pytest.mark.parametrize("scene", sorted(SCENES))
def test_nothing_is_wrong_in_silence(scene: str, engine: str, share: int) -> None:
    if not get_engine(engine).models(scene):
        pytest.skip(f"{engine} has no model of {scene}")
    found = drawn(scene, engine, COUNTS[scene] // 2 // share)
    classes: Counter[str] = Counter()
    wrong = []
    calls = [partial(result_of_draw, draw) for draw in found]
    for index, result in isolated(calls, 1, SECONDS, MEGABYTES):
        row = result_of_outcome(result)
        classes[row.verdict] += 1
        if row.scene != scene or (silent(row) and found[index] not in OPEN.values()):
            wrong.append(f"{row.id}: {row.reason}\n{found[index]}")
    print(scene, engine, dict(classes))
    assert not wrong, "\n".join(wrong)
    assert sum(classes.values()) == len(found)
    if share == 1:  # a test that skips everything shows nothing
        assert classes["skipped"] < len(found)
        if scene != "rotating_beam":  # whose reference is too dear for most draws
            assert classes["pass"] > len(found) / 5


SEVEN_RODS = (-169, 72, 172, -96, 20, -394, 363, 93, -179, -31, -179, 500, 439, -394, 100)

OPEN: Mapping[str, Draw] = {
    f"seven_rods_in_the_first_second_{place}": Draw(
        "rotating_beam", "mujoco", 867, -2, 93, (298, place, *SEVEN_RODS), (500, 128)
    )
    for place in (298, 172)
}
"""Draws that only the reference notices: the first frequency is off by 0.9 %, and discretisation
speaks from 1 % on, but so short a run shows the higher ones."""


@pytest.mark.parametrize("name", FOUND)
def test_what_was_found_is_mended(name: str) -> None:
    row = result_of_draw(FOUND[name][0])
    assert not silent(row), row


# A test of the test: what it would catch


MIDDLE = Draw(
    "hula_hoop", "exudyn", 3, 0, 500, (0, 0, 0, 0, 0, 0, -500, 0, 0), (100, 200, 250, 400)
)
"""Near the scene's defaults, by an explicit method of order 4."""


def test_a_silent_wrong_engine_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    assert result_of_draw(MIDDLE).verdict == "pass"
    wrong = Misread(ENGINES["exudyn"](), lambda p: p.replace(stiffness=1.01 * p.stiffness))
    monkeypatch.setattr(draws, "get_engine", lambda name: wrong)
    row = result_of_draw(MIDDLE)
    assert (row.verdict, row.noticed_by) == ("deviation", (REFERENCE,))
    assert silent(row)


def test_chaos_is_skipped_with_its_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    middle = result_of_draw(MIDDLE)
    reason = "wrong; errors of the start grow by {}"
    for growth, verdict in (("3e+06", "skipped"), ("3e+04", "deviation")):
        wrong = replace(
            middle, verdict="deviation", noticed_by=(REFERENCE,), reason=reason.format(growth)
        )
        monkeypatch.setattr(draws, "run_check", lambda *_, wrong=wrong, **__: [wrong])
        found = result_of_draw(MIDDLE)
        assert found.verdict == verdict
        assert silent(found) == (verdict == "deviation")


def test_a_check_that_takes_too_long_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    def endless(*_: object, **__: object) -> None:
        while True:
            np.zeros(1)

    monkeypatch.setattr(pushed, "truth_to_the_end", endless)
    row = result_of_draw(MIDDLE, patience=0.5)
    assert row.verdict == "skipped"
    assert "takes more than 0.5 s" in row.reason
