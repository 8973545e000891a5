"""Bent and turning starts of chains and elements, against the scene's beam."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from mbcheck.comparisons.checks.truth import Truth, truncated
from mbcheck.reference.equations import ModelEquations
from mbcheck.reference.rotating_beam import SCENE
from mbcheck.reference.rotating_beam.chain import chain_scene
from mbcheck.reference.rotating_beam.elements import NODAL, element_scene
from mbcheck.reference.rotating_beam.parameters import RotatingBeam
from mbcheck.reference.rotating_beam.starts import bent, unstretched_nodes
from mbcheck.reference.scene import Array, EquationsOfMotion
from mbcheck.reference.solve.solution import Solution

CASE = SCENE.case("turning")
INNER = CASE.parameters.replace(mass_position=0.625)
TIP = ("tip_deflection", "tip_deflection_dot", "tip_axial")


def scene_of(model: str, n: int) -> EquationsOfMotion:
    return chain_scene(n, model) if len(model) == 1 else element_scene(n, model)


def started(model: str, n: int, p: RotatingBeam, values: Mapping[str, float]) -> Array:
    """Return what the tip of a model does at the start."""
    scene = scene_of(model, n)
    p = p.replace(segments=n, **({"scheme": model} if len(model) == 1 else {}))
    found = scene.observe(scene.state(dict(scene.embedding(p, values))), p)
    return np.array([found[name] for name in TIP])


@pytest.mark.parametrize(
    ("model", "p"),
    [(model, CASE.parameters) for model in ("A", "B", *NODAL)] + [(one, INNER) for one in NODAL],
)
def test_models_start_as_the_beam_does(model: str, p: RotatingBeam) -> None:
    """Rods and straight elements cut corners, by the square of their length."""
    right = SCENE.observe(SCENE.state(CASE.state), p)
    errors = [started(model, n, p, CASE.state) - [right[name] for name in TIP] for n in (16, 32)]
    if model == "ancf":  # what is left is how far the beam stretches, no error of the shape
        assert np.max(np.abs(errors[1])) < 1e-4
        assert abs(errors[1][0]) < 2e-5  # along its chords, which hardly turns it aside
        assert abs(errors[1][1]) < 1e-9
    else:
        assert np.max(np.abs(errors[1])) < 2e-3
        assert errors[0][1] / errors[1][1] == pytest.approx(4, rel=0.3)


@pytest.mark.parametrize("p", [CASE.parameters, INNER])
def test_more_coordinates_start_with_the_same_shape(p: RotatingBeam) -> None:
    """They are angles at other points: those of the same names were a beam with a kink."""
    state = tuple(SCENE.state(CASE.state))
    right = SCENE.observe(SCENE.state(CASE.state), p)
    begun = []

    def solved(one: ModelEquations, at: tuple[float, ...]) -> Solution:
        begun.append(one.scene.observe(np.array(at), p))
        nothing = np.array(at)[:, None]
        return Solution(np.zeros(1), nothing, np.zeros(len(at)), 0, 0)

    equations, zero = ModelEquations(SCENE, p), np.zeros((len(TIP), 1))
    known = Truth(np.zeros(1), zero + 1, zero[:, 0], zero[:, 0] + 1, zero[:, 0] + 1, zero)
    truncated(equations, state, known, TIP, solved)
    assert len(begun) == 2
    for found in begun:
        for name in TIP:
            assert found[name] == pytest.approx(right[name], rel=1e-13)


def test_a_bent_beam_is_as_long_as_a_straight_one() -> None:
    places = np.linspace(0, 1, 2001)
    shape = bent(INNER, CASE.state, places)
    pieces = np.hypot(np.diff(places) + np.diff(shape.x[0]), np.diff(shape.y[0]))
    assert np.max(np.abs(pieces * 2000 - 1)) < 1e-8
    swept = np.gradient(shape.y[0], places, edge_order=2)
    assert np.max(np.abs(swept - np.sin(shape.angle[0]))) < 2e-6


def test_rates_and_accelerations_are_derivatives() -> None:
    p, places, h = CASE.parameters, np.linspace(0, 1, 9), 1e-5
    q, v = np.split(SCENE.state(CASE.state), 2)
    a = np.asarray(SCENE.accelerations(0.0, q, v, SCENE.coefficients(p)))
    shapes = []
    for t in (-h, 0.0, h):
        state = np.append(q + t * v + t * t / 2 * a, v + t * a)
        shapes.append(bent(p, dict(zip(SCENE.state_names, state.tolist(), strict=True)), places))
    for name in ("angle", "x", "y"):
        before, now, after = (getattr(shape, name) for shape in shapes)
        assert now[1] == pytest.approx((after[0] - before[0]) / (2 * h), abs=1e-6)
        assert now[2] == pytest.approx((after[1] - before[1]) / (2 * h), abs=1e-5)


@pytest.mark.parametrize("element", NODAL)
def test_a_bent_start_has_no_waves_along_the_beam(element: str) -> None:
    """The tip is accelerated along the beam as the scene's is; unstretched it is by 36 m/s^2."""
    scene, p = element_scene(8, element), CASE.parameters
    c = scene.coefficients(p)
    right = p.length * bent(p, CASE.state, [1.0]).x[2, 0]
    start = dict(scene.embedding(p, CASE.state))
    still = dict(scene.embedding(p, {**CASE.state, "theta_dot": 0.0}))
    tip = scene.coordinates.index("node_8_x")
    found = []
    for state in (start, still | {"theta_dot": CASE.state["theta_dot"]}):
        q, v = np.split(scene.state(state), 2)
        found.append(float(scene.accelerations(0.0, q, v, c)[tip]))
    assert abs(found[0] - right) < 0.02 * abs(found[1] - right)


def test_a_straight_beam_is_left_straight() -> None:
    for model in ("A", "B", *NODAL):
        p = replace(CASE.parameters, drive="torque")
        assert not any(scene_of(model, 8).embedding(p, {}).values())


def test_elements_are_stretched_along_their_chords() -> None:
    at = np.linspace(0, 1, 9)
    begin = unstretched_nodes(CASE.parameters, CASE.state, at, False)
    x, y = begin.along[-3], begin.along[-2]  # of the tip
    places = begin.places.reshape(-1, 3)[:, :2] + np.outer(at, [CASE.parameters.length, 0])
    chords = np.diff(places, axis=0)
    columns = np.stack([x, y], axis=-1)
    assert columns == pytest.approx(chords / np.hypot(*chords.T)[:, None], abs=1e-12)
