"""Engines whose numbers have 32 bits: right ones pass, wrong ones are seen all the same."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.models.kinematics import movers, place
from mbcheck.models.mechanism import Body, Site
from mbcheck.reference import get_scene
from mbcheck.reference.errors import MbcheckError
from mbcheck.tests.support.engines.reading import Reader
from mbcheck.tests.support.engines.solved import Single
from mbcheck.tests.support.example import bad, cases_of_all_kinds, results

METHODS = {
    "scheme": mbcheck.Method("RK4", 4, "RK44"),
    "no_scheme": mbcheck.Method("RK4", 4),
    "order_1": mbcheck.Method("Euler", 1, "ExplicitEuler"),
}
QUICK = ("algebra", "step", "trajectory", "frequency")
SCENES = {
    "hula_hoop": ("stiffness", "hinge_damping"),
    "rotor_pendulum": ("rotor_mass", "rod_damping"),
    "speed_regulator": ("slider_mass", "crank_inertia"),
}
"""Scenes of engines that read no MJCF, and parameters of which 1 % is seen."""


def everything(engine: Any, scene: str) -> list[Result]:
    """Return what all kinds say, each in a case of the default set or more.

    In all of them where few have an energy or a motion that is large beside its rounding.
    """
    cases = [case.name for case in get_scene(scene).cases if not case.full_only]
    if scene != "speed_regulator":
        cases = cases_of_all_kinds(scene)
    return [one for name in cases for one in results(engine, scene, tuple(KINDS), name)]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scene", ["hula_hoop", pytest.param("rigid_body", marks=pytest.mark.slow)])
def test_a_right_engine_passes(scene: str, method: str) -> None:
    found = results(Single(METHODS[method]), scene, QUICK)
    assert not bad(found)
    passed = {one.kind for one in found if one.verdict == "pass"}
    assert passed >= {"algebra", "step", "trajectory"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "method"), [*((scene, "scheme") for scene in SCENES), ("hula_hoop", "no_scheme")]
)
def test_a_right_engine_passes_whatever_is_checked(scene: str, method: str) -> None:
    found = everything(Single(METHODS[method]), scene)
    assert not bad(found)
    judged = {one.kind for one in found if one.verdict == "pass"}
    assert judged >= {"algebra", "step", "trajectory", "frequency", "stability", "energy"}


@pytest.mark.parametrize(
    ("scene", "name"),
    [
        pytest.param(scene, name, marks=[] if scene == "hula_hoop" else [pytest.mark.slow])
        for scene, names in SCENES.items()
        for name in names
    ],
)
def test_one_per_cent_of_a_parameter_is_seen(scene: str, name: str) -> None:
    def change(p: Any) -> Any:
        return p.replace(**{name: 1.01 * getattr(p, name)})

    wrong = Single(METHODS["scheme"], change=change)
    kinds = {one.kind for one in bad(results(wrong, scene, QUICK, explain=False))}
    assert "algebra" in kinds
    assert kinds & {"step", "trajectory"}


class Summed(Reader):
    """Mass matrices by composite rigid bodies about the origin of the world, in 32 bits."""

    name, precision = "summed", "float32"

    def mass_matrix(self, system: Any, q: Any) -> Any:
        """Return the momenta of all bodies beyond a joint at each joint before it."""
        whole, one = self.read(system.mjcf), np.float32
        here, unit = place(whole, q), np.eye(3, dtype=one)
        axes = here.axes.astype(one)
        slides = np.array([joint.kind == "slide" for joint in whole.joints])[:, None]
        moments = np.cross(here.anchors.astype(one), axes)  # velocity of the origin
        motions = np.where(slides, np.hstack([0 * axes, axes]), np.hstack([axes, moments]))
        composite = []
        for i, body in enumerate(whole.bodies):
            mass, rotation = one(body.mass), here.rotations[i].astype(one)
            across = np.cross(unit, here.point(Site(i, body.centre)).astype(one))
            inertia = rotation @ body.inertia.astype(one) @ rotation.T + mass * across @ across.T
            composite.append(np.block([[inertia, mass * across], [-mass * across, mass * unit]]))
        total = np.diag([joint.armature for joint in whole.joints]).astype(one)
        for i, body in reversed([*enumerate(whole.bodies)][1:]):
            composite[body.parent] = composite[body.parent] + composite[i]
            before = {*movers(whole)[i][0], *movers(whole)[i][1]} - {*body.joints}
            for k in body.joints:
                momentum = composite[i] @ motions[k]
                total[k, k] += motions[k] @ momentum
                for j in before:
                    total[j, k] = total[k, j] = motions[j] @ momentum
        return total.astype(float)


def test_a_sum_of_large_inertias_may_be_off_by_their_rounding() -> None:
    """At the tip of a chain of beams: an entry is small, the moments in it are not."""
    found = results(Summed(), "rotating_beam", ("parts", "algebra"), explain=False)
    matrices = [one for one in found if one.quantity == "mass_matrix"]
    assert [one.verdict for one in matrices] == ["pass", "pass"]
    # without these terms 0.96 of it, and 1.1 where the slides are summed in another order
    assert all((one.error or 0.0) < (one.tolerance or 0.0) / 2 for one in matrices)
    wrong = Summed(lambda whole: replace(whole, bodies=tuple(map(heavier, whole.bodies))))
    found = results(wrong, "rotating_beam", ("algebra",), explain=False)
    assert "mass_matrix" in {one.quantity for one in bad(found)}


def heavier(body: Body) -> Body:
    """Return a body with 1 % more mass."""
    return replace(body, mass=1.01 * body.mass)


class Undeclared(Single):
    """Numbers of 32 bits, and nothing said of them."""

    precision = "float64"


@pytest.mark.parametrize("kind", ["algebra", "step", "trajectory"])
def test_what_is_not_declared_is_named(kind: str) -> None:
    found = bad(results(Undeclared(METHODS["scheme"]), "hula_hoop", (kind,)))
    assert found
    assert all('precision = "float32"' in (one.cause or "") for one in found)


def test_a_precision_is_one_that_there_is() -> None:
    class Half(Single):
        precision = "float16"

    with pytest.raises(MbcheckError, match="did you mean 'float64'"):
        adapt("half", Half(METHODS["scheme"]))
