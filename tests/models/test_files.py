"""The MJCF files of all scenes: bound to the defaults, and every parameter and binding counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.models.mjcf import Mjcf, bind, export, models
from mbcheck.reference import SCENES, get_scene

ALL = {(scene, name): model for scene in SCENES for name, model in models(scene).items()}

OTHER_SOFTNESS = {"connect_hard"}
"""Models whose file is that of another one."""

CLOSURES = {"connect", "connect_hard"}
"""Models of which numbers are bound that depend on no parameter."""

VALUES = {
    "motor_placement": "relative",
    "scheme": "B",
    "drive": "torque",
    "element": "geometrically_exact",
    "segments": 3,
}
"""Other values of parameters that are no real numbers."""

IN_NO_FILE: dict[str, set[str]] = {
    "rotating_beam": {"torque_amplitude", "torque_period", "element"},
}
"""Parameters of another drive than the default's, and of other engines."""


def changed(parameters: Any, name: str, factor: float = 0.99) -> Any:
    """Return parameters of which one has another value."""
    value = VALUES[name] if name in VALUES else factor * getattr(parameters, name) or 0.1
    return parameters.replace(**{name: value})


@pytest.mark.parametrize("key", [key for key in ALL if key[1] not in OTHER_SOFTNESS], ids="-".join)
def test_a_committed_file_is_bound_to_the_defaults(key: tuple[str, str]) -> None:
    default = get_scene(key[0]).cases[0].parameters.__class__()
    assert export(ALL[key], default) == ALL[key].path.read_text(encoding="utf-8")


@pytest.mark.parametrize("scene", SCENES)
def test_every_parameter_changes_a_file(scene: str) -> None:
    default = get_scene(scene).cases[0].parameters.__class__()
    texts = [export(model, default) for model in models(scene).values()]
    for name in default.names():
        other = changed(default, name)
        same = [export(model, other) for model in models(scene).values()] == texts
        assert same == (name in IN_NO_FILE.get(scene, ())), name


def compiled(text: str) -> bytes:
    """Return what MuJoCo compiles of a text."""
    mujoco = pytest.importorskip("mujoco")
    loaded = mujoco.MjModel.from_xml_string(text)
    image = np.empty(mujoco.mj_sizeModel(loaded), np.uint8)
    mujoco.mj_saveModel(loaded, None, image)
    return image.tobytes()


@pytest.mark.parametrize("key", [key for key in ALL if key[1] not in CLOSURES], ids="-".join)
def test_every_binding_reaches_the_compiled_model(key: tuple[str, str]) -> None:
    """Each bound attribute, set to another value alone, changes what MuJoCo compiles."""
    model: Mjcf = ALL[key]
    other = get_scene(key[0]).cases[0].parameters.__class__()
    for i, name in enumerate(other.names()):
        other = changed(other, name, 0.95 - 0.01 * i)
    text = model.path.read_text(encoding="utf-8")
    default = compiled(text)
    for place, value in model.bindings.items():
        assert compiled(bind(text, {place: value(other)})) != default, place
