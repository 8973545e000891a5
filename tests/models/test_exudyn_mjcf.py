"""Exudyn's models are built from parsed MJCF: what the parser would leave out shows."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from mbcheck.comparisons.checks.suite import plan_cases, run_check
from mbcheck.comparisons.faults.exudyn import ExudynAdapter, Rebuilt
from mbcheck.models import exudyn_mjcf
from mbcheck.models.mechanism import mechanism
from mbcheck.models.mjcf import Mjcf, models
from mbcheck.reference import get_scene
from mbcheck.reference.errors import CannotJudgeError

ATTRIBUTES = (
    ("hula_hoop", "weighed", "option", "gravity"),
    ("hula_hoop", "weighed", "joint", "ref"),
    ("hula_hoop", "weighed", "joint", "armature"),
    ("hula_hoop", "weighed", "fixed", "stiffness"),
    ("hula_hoop", "weighed", "joint", "axis"),
    ("hula_hoop", "weighed", "joint", "type"),
    ("rotor_pendulum", "case_1_startup", "body", "euler"),
    ("rotor_pendulum", "case_1_startup", "inertial", "pos"),
    ("rotor_pendulum", "case_1_startup", "general", "biasprm"),
    ("speed_regulator", "rotation", "joint", "stiffness"),
    ("speed_regulator", "rotation", "joint", "springref"),
    ("speed_regulator", "rotation", "joint", "damping"),
    ("speed_regulator", "rotation", "inertial", "diaginertia"),
    ("speed_regulator", "rotation", "site", "pos"),
    ("speed_regulator", "rotation", "joint", "ref"),
    ("speed_regulator", "rotation+turned-1", "body", "quat"),
    ("ball_hoop", "weighed", "joint", "damping"),
    ("ball_hoop", "weighed", "inertial", "fullinertia"),
    ("rigid_body", "heavy_tumbling", "inertial", "mass"),
    ("rigid_body", "heavy_tumbling+turned-1", "body", "quat"),
    ("floating_beam", "tumbling", "body", "pos"),
)
"""Scene, case, and what is left out of its file."""


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "label", "tag", "name"), ATTRIBUTES)
def test_an_attribute_that_is_left_out_is_seen(scene: str, label: str, tag: str, name: str) -> None:
    pytest.importorskip("exudyn", exc_type=ImportError)
    known = get_scene(scene)
    (case,) = (one for one in (*known.cases, *known.placed) if one.label == label)

    def read(text: str) -> object:
        root = ET.fromstring(text)
        removed = [item.attrib.pop(name, None) for item in root.iter(tag)]
        assert any(removed)
        return mechanism(ET.tostring(root, encoding="unicode"))

    verdicts = set()
    for check in plan_cases([case], ["exudyn"], ["algebra"], full=True):
        if not check.unsupported_reason and check.model != "one_dof":
            wrong = ExudynAdapter(Rebuilt(exudyn_mjcf, mechanism=read))
            verdicts |= {one.verdict for one in run_check(check, engine=wrong, explain=False)}
    assert verdicts & {"deviation", "error"}


def changed(scene: str, old: str, new: str) -> Mjcf:
    """Return the default MJCF model of a scene with other text."""
    source = next(iter(models(scene).values()))

    def expand(text: str, p: object) -> str:
        assert old in text
        return text.replace(old, new)

    return Mjcf(source.path, source.bindings, source.joints, source.readout, expand=expand)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('<joint name="phi_1"', '<joint pos="0.1 0 0" name="phi_1"', "rotor_1 has not one joint"),
        ('joint="phi_3" coef="1"', 'joint="phi_3" coef="2"', "is not the angle between two bodies"),
    ],
)
def test_what_is_not_understood_is_refused(old: str, new: str, words: str) -> None:
    pytest.importorskip("exudyn", exc_type=ImportError)
    p = get_scene("rotor_pendulum").parameters()
    wrong = exudyn_mjcf.model_of(
        "rotor_pendulum", changed("rotor_pendulum", old, new), exudyn_mjcf.build_space
    )
    with pytest.raises(CannotJudgeError, match=words):
        wrong.build(p, "")
