"""Rules of inspection: each finds its own mistake, and nothing in the file that is mended."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from mbcheck.comparisons.inspect.findings import findings
from mbcheck.comparisons.inspect.inspection import Inspection, inspect, subject_of
from mbcheck.comparisons.inspect.mujoco.model import load
from mbcheck.comparisons.inspect.rules.table import RULES

BASE = """<mujoco model="pendulum">
  <compiler angle="radian"/>
  <option timestep="0.0009765625" integrator="RK4">
    <flag contact="disable" autoreset="disable"/>
  </option>
  <worldbody>
    <body name="rod" pos="0 0 1">
      <inertial pos="0 0 -0.5" mass="1" diaginertia="0.1 0.1 0.01"/>
      <joint name="swing" axis="0 1 0" stiffness="5" damping="0.1"/>
      <geom name="rod" type="capsule" size="0.02" fromto="0 0 0 0 0 -1"/>
    </body>
  </worldbody>
  <keyframe>
    <key name="hanging"/>
  </keyframe>
</mujoco>
"""

OPTION = '<option timestep="0.0009765625" integrator="RK4">'
FLAG = '<flag contact="disable" autoreset="disable"/>'
ON = '<flag autoreset="disable"/>'
JOINT = '<joint name="swing" axis="0 1 0" stiffness="5" damping="0.1"/>'
GEOM = '<geom name="rod" type="capsule" size="0.02" fromto="0 0 0 0 0 -1"/>'
INERTIAL = '<inertial pos="0 0 -0.5" mass="1" diaginertia="0.1 0.1 0.01"/>'
WORLD, END = "  <worldbody>", "  </worldbody>"
KEY = '<key name="hanging"/>'
COMPILER = '<compiler angle="radian"/>'
SECOND = (
    '<body name="second" pos="1 0 1">' + INERTIAL + JOINT.replace("swing", "other") + "{}</body>"
)
LOOP = (
    '<body name="arm" pos="0.5 0 0.5"><inertial pos="0 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>'
    '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide"/>'
    '<site name="end" pos="-0.5 0 -0.5"/></body>'
)
TIP = (
    '<body name="tip" pos="0 0 -1"><joint name="tip" axis="0 1 0" stiffness="1" damping="1"/>'
    '<inertial pos="0 0 {}" mass="1" diaginertia="0.1 0.1 0.1"/></body>'
)
TENDON = '<tendon><fixed name="t"{}><joint joint="swing" coef="1"/></fixed></tendon>'
SENSORS = '<sensor><jointpos name="a" joint="swing"/><{} name="b" joint="swing"/></sensor>'
ASSETS = (
    '<asset><material name="blue" rgba="0 0 1 1"/>'
    '<mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
)
TILTED = '<geom name="rod" type="capsule" size="0.02 0.5" euler="9 0 0"/>'
SOLREF = 'solref="-250000 -1000" solimp="0.9999 0.9999 0.001"'


def closed(how: str = SOLREF) -> tuple[tuple[str, str], ...]:
    """Return what closes a loop of the base."""
    connect = f'<connect name="pin" site1="tip" site2="end" {how}/>'
    return (
        (GEOM, GEOM + '<site name="tip" pos="0 0 -1"/>'),
        (END, f"{LOOP}{END}<equality>{connect}</equality>"),
    )


def option(attributes: str) -> tuple[str, str]:
    """Return an option more."""
    return OPTION, OPTION[:-1] + f" {attributes}>"


def joint(attributes: str) -> tuple[str, str]:
    """Return attributes more of the joint."""
    return JOINT, JOINT[:-2] + f" {attributes}/>"


def after(place: str, text: str) -> tuple[str, str]:
    """Return a text more behind a place."""
    return place, place + text


Edits = tuple[tuple[str, str], ...]

MISTAKES: dict[str, tuple[Edits, Edits]] = {
    "step_limit": (
        ((OPTION, '<option timestep="2" integrator="RK4">'),),
        (),
    ),
    "near_step_limit": (
        (
            (OPTION, '<option timestep="0.03125" integrator="RK4">'),
            ('stiffness="5" damping="0.1"', 'stiffness="2400" damping="4"'),
        ),
        (
            (OPTION, '<option timestep="0.00390625" integrator="RK4">'),
            ('stiffness="5" damping="0.1"', 'stiffness="2400" damping="4"'),
        ),
    ),
    "coarse_step": (((OPTION, '<option timestep="0.25" integrator="discrete">'),), ()),
    "not_finite": ((('damping="0.1"', 'damping="inf"'),), ()),
    "closure_softness": (closed('solref="0.2 1"'), closed()),
    "closure_open": (
        (
            *closed(),
            ('<site name="end" pos="-0.5 0 -0.5"/>', '<site name="end" pos="-0.5 0 -0.49"/>'),
        ),
        closed(),
    ),
    "solref_raised": (closed('solref="0.001 1" solimp="0.9999 0.9999 0.001"'), closed()),
    "solimp_clamped": (closed('solref="-250000 -1000" solimp="0.99999 0.99999 0.001"'), closed()),
    "contact_depth": (
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 0.1"/>'),
        ),
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -0.5"/>'),
        ),
    ),
    "keyframe_outside_range": (
        (joint('range="-1 1"'), (KEY, '<key name="hanging" qpos="2"/>')),
        (joint('range="-1 1"'), (KEY, '<key name="hanging" qpos="0.5"/>')),
    ),
    "no_keyframe": (((KEY, ""),), ()),
    "auto_reset": (((FLAG, '<flag contact="disable"/>'),), ()),
    "clock_rounding": (
        ((OPTION, '<option timestep="0.001" integrator="RK4">'),),
        (),
    ),
    "energy_off": (
        ((' damping="0.1"', ""),),
        ((' damping="0.1"', ""), (FLAG, FLAG[:-2] + ' energy="enable"/>')),
    ),
    "ill_conditioned": (
        (
            (JOINT, '<joint name="swing" axis="0 1 0"/><joint name="again" axis="1e-6 1 0"/>'),
            (FLAG, FLAG[:-2] + ' energy="enable"/>'),
        ),
        (
            (JOINT, '<joint name="swing" axis="0 1 0"/><joint name="again" axis="1 0 0"/>'),
            (FLAG, FLAG[:-2] + ' energy="enable"/>'),
        ),
    ),
    "idle_gravity": (
        (('<joint name="swing" axis="0 1 0"', '<joint name="swing"'),),
        (('<joint name="swing" axis="0 1 0"', '<joint name="swing"'), option('gravity="0 0 0"')),
    ),
    "welded_body": (
        (after(GEOM, '<body name="tip" pos="0 0 -1"><geom size="0.1"/></body>'),),
        (after(GEOM, '<geom size="0.1" pos="0 0 -1"/>'),),
    ),
    "empty_body": ((after(GEOM, '<body name="tip" pos="0 0 -1"/>'),), ()),
    "locked_joint": (
        (
            after(
                END,
                '<equality><joint joint1="swing" solimp="0.999 0.999 0.001"/></equality>',
            ),
        ),
        (),
    ),
    "idle_joint": (
        (
            (
                END,
                '<body name="disc" pos="2 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
                f'<joint name="spin"/></body>{END}',
            ),
        ),
        (
            (
                END,
                '<body name="disc" pos="2 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
                f'<joint name="spin" damping="0.1" stiffness="1"/></body>{END}',
            ),
        ),
    ),
    "contact_unused": (((FLAG, ON),), ()),
    "geom_never_touches": (
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -2"/>'),
            after(GEOM, '<geom name="odd" size="0.1" contype="2" conaffinity="2"/>'),
        ),
        (
            (FLAG, ON),
            after(WORLD, '<geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -2"/>'),
            after(GEOM, '<geom name="odd" size="0.1" contype="0" conaffinity="0"/>'),
        ),
    ),
    "contact_leftovers": (
        (
            (END, SECOND.format(GEOM.replace("rod", "other")) + END),
            after(END, '<contact><exclude body1="rod" body2="second"/></contact>'),
        ),
        ((END, SECOND.format(GEOM.replace("rod", "other")) + END),),
    ),
    "geom_mass": (((GEOM, GEOM[:-2] + ' mass="3"/>'),), ()),
    "inertia_floor": (
        ((INERTIAL, '<inertial pos="0 0 -0.5" mass="1" diaginertia="2e-15 2e-15 2e-15"/>'),),
        (),
    ),
    "inertia_raised": (((COMPILER, COMPILER[:-2] + ' boundmass="2"/>'),), ()),
    "merged_centre": (
        (after(GEOM, TIP.format("5e-7")),),
        (after(GEOM, TIP.format("5e-6")),),
    ),
    "huge_armature": ((joint('armature="1000"'),), (joint('armature="0.1"'),)),
    "negative_damping": ((('damping="0.1"', 'damping="-0.1"'),), ()),
    "range_ignored": ((joint('range="1 1"'),), (joint('range="-1 1"'),)),
    "idle_actuator": (
        (after(END, '<actuator><general name="motor" joint="swing" gainprm="0"/></actuator>'),),
        (after(END, '<actuator><motor name="motor" joint="swing"/></actuator>'),),
    ),
    "idle_tendon": (
        (
            after(
                END,
                TENDON.format(""),
            ),
        ),
        (
            after(
                END,
                TENDON.format(' damping="1"'),
            ),
        ),
    ),
    "duplicate_sensor": (
        (
            after(
                END,
                SENSORS.format("jointpos"),
            ),
        ),
        (
            after(
                END,
                SENSORS.format("jointvel"),
            ),
        ),
    ),
    "unused_asset": (
        (
            (
                WORLD,
                ASSETS + WORLD,
            ),
            (GEOM, GEOM + '<geom type="mesh" mesh="m"/>'),
        ),
        (
            (
                WORLD,
                ASSETS + WORLD,
            ),
            (GEOM, GEOM + '<geom type="mesh" mesh="m" material="blue"/>'),
        ),
    ),
    "unused_site": (
        (after(GEOM, '<site name="tip" pos="0 0 -1"/>'),),
        (
            after(GEOM, '<site name="tip" pos="0 0 -1"/>'),
            after(END, '<sensor><accelerometer name="a" site="tip"/></sensor>'),
        ),
    ),
    "inactive_equality": (
        (*closed(SOLREF + ' active="false"'),),
        closed(),
    ),
    "switched_off": (((FLAG, FLAG[:-2] + ' damper="disable"/>'),), ()),
    "unused_class": (
        (
            (
                WORLD,
                f'<default><default class="odd"><geom rgba="1 0 0 1"/></default></default>{WORLD}',
            ),
        ),
        (
            (
                WORLD,
                f'<default><default class="odd"><geom rgba="1 0 0 1"/></default></default>{WORLD}',
            ),
            (GEOM, GEOM[:-2] + ' class="odd"/>'),
        ),
    ),
    "unused_option": ((option('tolerance="1e-10"'),), ()),
    "unused_setting": (
        (joint('springref="1" margin="0.1"'), (' stiffness="5"', "")),
        ((' stiffness="5"', ""),),
    ),
    "implicit_degrees": (
        ((COMPILER, ""), (GEOM, TILTED)),
        ((COMPILER, '<compiler angle="degree"/>'), (GEOM, TILTED)),
    ),
    "angle_unit": ((joint('range="-90 90"'),), (joint('range="-1.5 1.5"'),)),
    "repeated_default": ((joint('type="hinge"'),), ()),
    "waiver_reason": (((KEY, f"<!-- mbcheck: allow auto_reset: -->{KEY}"),), ()),
    "waiver_unknown": (((KEY, f"<!-- mbcheck: allow autoreset: I want it -->{KEY}"),), ()),
    "waiver_unused": (((KEY, f"<!-- mbcheck: allow auto_reset: I want it -->{KEY}"),), ()),
}
"""Rule -> what makes its mistake, and what mends it; nothing: the base."""

WITH_MODES = (
    "step_limit",
    "near_step_limit",
    "coarse_step",
    "not_finite",
    "closure_softness",
    "huge_armature",
    "ill_conditioned",
)
"""Rules that look at small motions; the others are tried without, which is faster."""


def written(folder: Path, *edits: tuple[str, str], text: str = BASE) -> Path:
    """Write the base with edits, each of which applies once."""
    for old, new in edits:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "model.xml"
    path.write_text(text)
    return path


def inspected(path: Path, rule: str) -> Inspection:
    """Inspect a file, with modes if a rule looks at them."""
    return inspect(path, modes=None if rule in WITH_MODES else False)


def test_every_rule_has_its_mistake() -> None:
    assert set(MISTAKES) == set(RULES) - {"compiler_warning"}


def test_the_base_is_clean(tmp_path: Path) -> None:
    found = inspect(written(tmp_path))
    assert found.findings == ()
    assert found.steps


@pytest.mark.parametrize("rule", MISTAKES)
def test_a_mistake_is_found_by_its_rule_alone(rule: str, tmp_path: Path) -> None:
    mistake, mended = MISTAKES[rule]
    found = inspected(written(tmp_path, *mistake), rule)
    assert {one.rule for one in found.findings} == {rule}, found.findings
    for one in found.findings:
        assert one.severity == RULES[rule].severity
        assert one.message
        assert one.fix
        assert one.waived is None
    assert found.exit_code == (RULES[rule].severity == "error")
    assert inspected(written(tmp_path, *mended), rule).findings == ()


def test_lines_and_elements_are_those_of_the_text(tmp_path: Path) -> None:
    text = BASE.replace(JOINT, JOINT[:-2] + ' type="hinge"/>')
    line = next(i for i, row in enumerate(text.splitlines(), 1) if 'name="swing"' in row)
    (one,) = inspect(written(tmp_path, text=text), modes=False).findings
    assert (one.element, one.file, one.line) == ("joint:swing", "model.xml", line)


def test_lines_in_included_files(tmp_path: Path) -> None:
    body = BASE[BASE.index("    <body") : BASE.index(END)].replace(
        JOINT, JOINT[:-2] + ' margin="1"/>'
    )
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "rod.xml").write_text(f"<mujocoinclude>\n\n{body}</mujocoinclude>")
    around = (
        BASE[: BASE.index("    <body")]
        + '<include file="parts/rod.xml"/>'
        + BASE[BASE.index(END) :]
    )
    (one,) = inspect(written(tmp_path, text=around), modes=False).findings
    assert (one.rule, one.file, one.line) == ("unused_setting", "parts/rod.xml", 5)


def test_what_mujoco_warns_of_is_told(tmp_path: Path) -> None:
    flex = (
        '<flexcomp name="cloth" type="grid" count="3 3 1" spacing="0.1 0.1 0.1" radius="0.01">'
        '<contact contype="0" conaffinity="0"/></flexcomp>'
    )
    path = written(tmp_path, (END, flex + END))
    rules = {one.rule: one.message for one in inspect(path, modes=False).findings}
    assert "no equality constraints or passive forces" in rules["compiler_warning"]


# Waivers ------------------------------------------------------------------------------------

TWO = JOINT[:-2] + ' type="hinge" margin="1"/>'


@pytest.mark.parametrize(
    ("waiver", "waived"),
    [
        ("allow repeated_default: it is a joint", {"repeated_default"}),
        ("allow repeated_default, swing: it is\n a joint", {"repeated_default"}),
        ("allow repeated_default, joint:swing: it is a joint", {"repeated_default"}),
        ("allow repeated_default, joint:*: it is a joint", {"repeated_default"}),
        ("allow unused_setting, s*g: for later", {"unused_setting"}),
    ],
)
def test_a_waiver_allows_what_it_names(waiver: str, waived: set[str], tmp_path: Path) -> None:
    found = inspect(
        written(tmp_path, (JOINT, TWO), (KEY, f"<!-- mbcheck: {waiver} -->{KEY}")), modes=False
    )
    assert {one.rule for one in found.findings if one.waived} == waived
    assert {one.rule for one in found.unwaived} == {"repeated_default", "unused_setting"} - waived
    assert all(
        " a joint" in one.waived or one.waived == "for later"
        for one in found.findings
        if one.waived
    )


@pytest.mark.parametrize(
    ("waiver", "complaint"),
    [
        ("allow repeated_default, other: not here", "waiver_unused"),
        ("allow repeated_default, body:swing: not here", "waiver_unused"),
        ("allow repeated_default", "waiver_reason"),
        ("allow repeated_default, swing:", "waiver_reason"),
        ("allow everything: please", "waiver_unknown"),
        ("ignore repeated_default: please", "waiver_reason"),
    ],
)
def test_a_waiver_that_does_not_hold_is_found_itself(
    waiver: str, complaint: str, tmp_path: Path
) -> None:
    found = inspect(
        written(tmp_path, (JOINT, TWO), (KEY, f"<!-- mbcheck: {waiver} -->{KEY}")), modes=False
    )
    rules = Counter(one.rule for one in found.unwaived)
    assert rules == {"repeated_default": 1, "unused_setting": 1, complaint: 1}


def test_a_waived_error_does_not_fail(tmp_path: Path) -> None:
    mistake, _ = MISTAKES["step_limit"]
    waiver = "<!-- mbcheck: allow step_limit, option: a test of instability -->"
    assert inspect(written(tmp_path, *mistake)).exit_code == 1
    found = inspect(written(tmp_path, *mistake, (KEY, waiver + KEY)))
    assert found.exit_code == 0
    assert found.summary == {"error": 0, "warning": 0, "note": 0, "waived": 1}


def test_what_was_not_tried_is_told(tmp_path: Path) -> None:
    """A model that is too large leaves attributes out, says so, and blames no waiver for it."""
    waiver = f"<!-- mbcheck: allow repeated_default, swing: an editor writes it -->{KEY}"
    path = written(tmp_path, joint('type="hinge"'), (KEY, waiver))
    assert inspect(path, modes=False).untried is None
    results, untried = findings(subject_of(load(path), modes=False), budget=1.0)
    assert results == ()
    assert "not tried" in str(untried)


def test_other_comments_are_no_waivers(tmp_path: Path) -> None:
    assert inspect(written(tmp_path, (KEY, f"<!-- see mbcheck: allow -->{KEY}"))).findings == ()
