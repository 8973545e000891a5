"""Checks of the engines in `examples`, plugged in as anyone would."""

from __future__ import annotations

from mbcheck.comparisons.checks.suite import Check, kinds_of, run_check
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.reference import get_scene

PLACES = {
    "hula_hoop": ("tree", "semicircle_3hz_60n", "rest_rod_across"),
    "rotor_pendulum": ("tree", "case_2_startup", "modes_at_rest"),
    "rotating_beam": ("chain", "spin_up_quick", "steady_at_rest"),
    "rigid_body": ("ball", "heavy_tumbling", "rest_hanging"),
    "ball_hoop": ("ball", "weighed", "hanging"),
    "floating_platform": ("free", "tumbling", "afloat"),
    "floating_beam": ("free", "tumbling", "afloat"),
    "speed_regulator": ("connect", "rotation", "rest_right"),
}
"""Scene -> model, a case of motion, a case of modes."""

QUICK = ("parts", "algebra", "step", "frequency")
"""Kinds of check that take seconds."""

TOO_FINE = "least_error"
"""Quantity that is skipped where a step leaves less than the reference knows."""


def results(engine: Adapter, scene: str, kinds: tuple[str, ...]) -> list[Result]:
    """Return what kinds of check say of a scene's model, with the engine's first method."""
    model, *cases = PLACES[scene]
    found = []
    for case in map(get_scene(scene).case, cases):
        for kind in set(kinds) & set(kinds_of(case)):
            method = engine.methods[0] if KINDS[kind].integrates else None
            names = KINDS[kind].quantities(Setup(engine, case, model, method))
            if names:
                check = Check(kind, case, engine.name, model, method, names)
                found += run_check(check, engine=engine)
    return found
