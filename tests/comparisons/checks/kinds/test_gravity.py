"""Gravity of a scene: an engine that has another one is told which."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

from mbcheck.comparisons.checks.suite import kinds_of, run_check
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.models.mechanism import mechanism
from mbcheck.models.mjcf import attribute_text
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array
from mbcheck.tests.support.example import all_checks, bad
from mbcheck.tests.support.placements import misreading

SCENES = ("hula_hoop", "rotor_pendulum")


def with_gravity(change: Callable[[Array], Array]) -> Callable[[str], str]:
    """Return what changes the gravity in a text."""

    def changed(text: str) -> str:
        gravity = attribute_text(tuple(change(mechanism(text).gravity)))
        return re.sub(r'gravity="[^"]*"', f'gravity="{gravity}"', text)

    return changed


WRONG: Mapping[str, tuple[Callable[[Array], Array], str]] = {
    "dropped": (lambda g: 0 * g, "gravity: dropped"),
    "sign": (lambda g: -g, "gravity: its sign is reversed"),
    "size": (lambda g: 1.1 * g, "gravity: counted 1.1 times"),
    "frame": (lambda g: g[[1, 0, 2]], "gravity: its direction is off by"),
    "own": (lambda g: g * [1, 3, 1], "in another direction, where the file has"),
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("scene", SCENES)
def test_a_wrong_gravity_is_named(scene: str, name: str) -> None:
    change, words = WRONG[name]
    case = get_scene(scene).case("weighed")
    engine = adapt("wrong", misreading(with_gravity(change)))
    found = {
        kind: bad(
            [
                item
                for one in all_checks(kind, case, engine)
                for item in run_check(one, engine=engine)
            ]
        )
        for kind in kinds_of(case)
        if kind in ("parts", "algebra")
    }
    assert found["algebra"]
    assert any(words in item.reason for item in found["parts"] if item.quantity == "gravity")


@pytest.mark.parametrize("placement", ["turned:7", "mirrored:2"])
@pytest.mark.parametrize("name", ["dropped", "sign", "size"])
def test_a_wrong_gravity_of_a_placed_model_is_named(name: str, placement: str) -> None:
    change, words = WRONG[name]
    case = replace(get_scene("rotor_pendulum").case("weighed"), placement=placement)
    engine = adapt("wrong", misreading(with_gravity(change)))
    (check,) = all_checks("parts", case, engine)
    found = bad(run_check(check, engine=engine))
    assert [item.quantity for item in found] == ["gravity"]
    assert words in found[0].reason
