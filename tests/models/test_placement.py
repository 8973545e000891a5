"""A model that is placed in the world is the same mechanism, by its own mass matrix and loops."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from mbcheck.models import kinematics, mjcf
from mbcheck.models.mechanism import Mechanism, mechanism, orientation, vector
from mbcheck.models.placement import (
    make_inertias_unequal,
    placed,
    placed_motion,
    unplaceable_reason,
    world_axes,
)
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.scene import Array

MODELS = [
    (scene, name) for scene in SCENES for name in mjcf.models(scene) if name != "transmission"
]
GRAVITY = np.array([1.5, -4.0, 8.0])


@pytest.mark.parametrize("placement", ["turned:1", "turned:5", "mirrored:2", "mirrored:9"])
@pytest.mark.parametrize(("scene", "model"), MODELS)
def test_it_is_the_same_mechanism(scene: str, model: str, placement: str) -> None:
    source, axes = mjcf.models(scene)[model], world_axes(placement)
    p = next(
        c.parameters
        for c in get_scene(scene).cases
        if source.unsupported_reason(c.parameters) is None
    )
    text = mjcf.export(source, p).replace('gravity="0 0 0"', f'gravity="{GRAVITY[0]} -4 8"')
    if reason := unplaceable_reason(text, placement):
        pytest.skip(reason)
    stands, turned = mechanism(text), mechanism(placed(text, placement))
    np.testing.assert_allclose(turned.gravity, axes @ stands.gravity, rtol=1e-14)
    random = np.random.default_rng(3)
    for _ in range(3):
        at, moving = (random.normal(size=count) for count in stands.layout.size)
        state = at, moving
        moved, turn = placed_state(stands, at, moving, placement)
        pairs = [
            [
                to_model.T @ kinematics.mass_matrix(one, q) @ to_model,
                kinematics.inertial_force(one, q, v) @ to_model,
                kinematics.weight(one, q, one.gravity) @ to_model,
            ]
            for one, (q, v), to_model in (
                (stands, state, np.eye(len(turn))),
                (turned, moved, turn),
            )
        ]
        for right, found in zip(*pairs, strict=True):
            size = np.max(np.abs(right), initial=1e-300)
            np.testing.assert_allclose(found, right, rtol=1e-9, atol=1e-12 * size)
        loops = [
            kinematics.gaps(one, q).reshape(-1, 3)
            for one, (q, _) in ((stands, state), (turned, moved))
        ]
        np.testing.assert_allclose(loops[1], loops[0] @ axes.T, atol=1e-14)


def placed_state(
    whole: Mechanism, q: Array, v: Array, placement: str
) -> tuple[tuple[Array, Array], Array]:
    """Return a state of a model that is placed so, and the matrix that turns velocities."""
    places = list(zip(whole.layout.positions, whole.layout.velocities, strict=True))
    motion = {str(i): (q[at], v[own]) for i, (at, own) in enumerate(places)}
    moved = placed_motion(motion, placement).values()
    turn = np.eye(len(v))
    for kind, (_, own) in zip(whole.layout.kinds, places, strict=True):
        if kind == "free":
            first = slice(own.start, own.start + 3)
            turn[first, first] = world_axes(placement)
    return (np.hstack([one[0] for one in moved]), np.hstack([one[1] for one in moved])), turn


@pytest.mark.parametrize("word", ["turned", "mirrored"])
def test_axes_are_orthogonal_and_of_one_hand(word: str) -> None:
    axes = world_axes(f"{word}:4")
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1 if word == "turned" else -1)


@pytest.mark.parametrize(
    "attributes",
    [
        {"euler": "0.3 -0.8 2"},
        {"quat": "0.3 -0.8 2 1"},
        {"zaxis": "0.3 -0.8 2"},
        {"zaxis": "0 0 -2"},
        {"xyaxes": "1 2 0 0 1 3"},
    ],
)
def test_orientations_are_read_as_mujoco_does(attributes: dict[str, str]) -> None:
    mujoco = pytest.importorskip("mujoco")
    told = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    text = (
        '<mujoco><compiler angle="radian"/><worldbody>'
        f'<site name="one" {told}/></worldbody></mujoco>'
    )
    data = mujoco.MjData(mujoco.MjModel.from_xml_string(text))
    mujoco.mj_forward(data.model, data)
    found = orientation(attributes)
    np.testing.assert_allclose(found, data.site("one").xmat.reshape(3, 3), atol=1e-14)


def test_only_a_body_with_one_moment_of_inertia_gets_three() -> None:
    """Of a body in the plane the other two are not seen as it stands."""
    world = ElementTree.fromstring(
        '<worldbody><inertial diaginertia="2 2 2"/><inertial diaginertia="1 2 3"/></worldbody>'
    )
    make_inertias_unequal(world)
    moments = np.array([vector(item.get("diaginertia", "")) for item in world])
    np.testing.assert_allclose(moments, np.array([[1.2, 1.4, 2.0], [1.0, 2.0, 3.0]]))
