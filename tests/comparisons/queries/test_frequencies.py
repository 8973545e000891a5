"""`frequencies`: modes about a state of rest, damped and undamped."""

from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.adapter import BoundModel
from mbcheck.reference.errors import (
    EngineError,
)
from mbcheck.tests.support.command import succeeds
from mbcheck.tests.support.documents import validated

ENGINES = ("reference", "mujoco", "exudyn")

ACROSS = np.sqrt(1000 / 0.45)  # the free mass does not take part
ALIGNED = np.sqrt(1000 / 0.495)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("about", "omega"), [(None, ACROSS), ("rod_aligned", ALIGNED)])
def test_undamped_frequencies(engine: str, about: str | None, omega: float) -> None:
    found = mbcheck.frequencies("hula_hoop", about=about, engine=engine, undamped=True)
    document = validated("frequencies", found.as_json())
    zero, mode = document["modes"]
    assert zero["damping_ratio"] is None
    assert zero["omega"] == pytest.approx(0, abs=1e-6)
    assert mode["omega"] == pytest.approx(omega, rel=1e-9)
    assert mode["hertz"] == pytest.approx(omega / 2 / np.pi, rel=1e-9)
    assert document["about"] == (about or "rod_across")


@pytest.mark.parametrize("engine", ENGINES)
def test_damped_frequencies(engine: str) -> None:
    found = mbcheck.frequencies("hula_hoop", about="rod_aligned", engine=engine)
    assert found.state["theta"] == np.pi / 2
    slide = found.modes[-1]
    assert slide.damping_ratio == pytest.approx(0.1, rel=1e-8)  # rho, by its definition
    assert slide.im == pytest.approx(ALIGNED * np.sqrt(1 - 0.1**2), rel=1e-8)
    assert [mode.omega for mode in found.modes] == sorted(mode.omega for mode in found.modes)
    assert len(mbcheck.frequencies("hula_hoop", engine=engine, count=1).modes) == 1


@pytest.mark.parametrize(
    ("scene", "words", "steady"),
    [
        ("hula_hoop", "damped modes, with force_amplitude=0", ()),
        ("speed_regulator", "damped modes", ()),
        ("rotating_beam", ", theta keeps its speed", ("theta",)),
    ],
)
def test_what_drives_the_scene_is_said(scene: str, words: str, steady: tuple[str, ...]) -> None:
    document = validated("frequencies", mbcheck.frequencies(scene, count=1).as_json())
    assert document["steady"] == list(steady)
    first = " ".join(succeeds(f"frequencies {scene} --count 1").partition("parameters:")[0].split())
    assert first.endswith(words)


def test_a_beam_that_shears_has_a_first_mode() -> None:
    """Shear is 10^10 times as stiff as bending: its first mode was taken for a free one."""
    loads = {"mass": 0.4, "ramp_time": 0.0, "angular_speed": 0.0}
    (right,) = mbcheck.frequencies("rotating_beam", parameters=loads, count=1).modes
    shears = loads | {"element": "geometrically_exact"}
    (found,) = mbcheck.frequencies(
        "rotating_beam", parameters=shears, engine="exudyn", count=1
    ).modes
    assert found.omega == pytest.approx(right.omega, rel=1e-3)


def test_an_engine_that_raises_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: Any) -> Any:
        raise ValueError("no such body\nand more")

    monkeypatch.setattr(BoundModel, "linearise", broken)
    with pytest.raises(EngineError, match=r"ValueError: no such body \(test_frequencies.py:\d+\)$"):
        mbcheck.frequencies("hula_hoop", engine="mujoco")


def test_the_plane_of_a_beams_modes_is_the_one_that_is_asked_for() -> None:
    """Spinning stiffens the beam across the plane more (by the square of the speed)."""
    speed = {"angular_speed": 4.0}
    default, chordwise, flapwise = (
        mbcheck.frequencies("rotating_beam", parameters=speed, plane=plane, count=1)
        for plane in (None, "chordwise", "flapwise")
    )
    assert [found.plane for found in (default, flapwise)] == ["chordwise", "flapwise"]
    assert default.modes == chordwise.modes
    assert len(mbcheck.frequencies("rotating_beam", parameters=speed).modes) == 4
    squares = [found.modes[0].omega ** 2 for found in (flapwise, chordwise)]
    assert squares[0] - squares[1] == pytest.approx(4.0**2, rel=0.05)


@pytest.mark.parametrize(
    ("scene", "coordinates", "loss"),
    [("rigid_body", 4, {}), ("ball_hoop", 5, {"joint_damping": 0.0})],
)
def test_what_nothing_resists_is_listed_once(
    scene: str, coordinates: int, loss: dict[str, float]
) -> None:
    """The turn about the vertical, and the length of the quaternion."""
    parameters = {"gravity_z": 9.81} | loss
    found = mbcheck.frequencies(scene, about="hanging", parameters=parameters).modes
    assert len(found) == coordinates
    assert [mode.damping_ratio is None for mode in found] == [True] * 2 + [False] * (
        coordinates - 2
    )
    assert all(mode.omega > 1 for mode in found[2:])


def test_friction_in_a_ball_joint_ends_the_turn_about_the_vertical() -> None:
    """The attitude that is left is any; the rate decays by r / J."""
    upright = dict.fromkeys(("centre_x", "centre_y", "axes_x", "axes_y", "axes_z"), 0.0)
    values = upright | {"gravity_z": 9.81, "joint_damping": 0.005, "moment_3": 0.007}
    modes = mbcheck.frequencies("ball_hoop", about="hanging", parameters=values).modes
    decays = [mode.re for mode in modes if mode.im == 0 and mode.re < 0]
    assert decays == [pytest.approx(-0.005 / 0.007, rel=1e-9)]
