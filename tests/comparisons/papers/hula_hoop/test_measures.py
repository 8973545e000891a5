"""What rows of the hula_hoop paper are made of: runs, maps, and measures that can fail."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.maps.request import Axis
from mbcheck.comparisons.maps.store import Map
from mbcheck.comparisons.papers.assess import assess
from mbcheck.comparisons.papers.claims import read_paper
from mbcheck.comparisons.papers.hula_hoop import measures
from mbcheck.comparisons.papers.hula_hoop.figures import motion_figure
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED, REPRODUCED, VERDICTS
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.queries import query
from mbcheck.comparisons.scenes.hula_hoop.motion import MOTION_VARIABLES, MOTIONS
from mbcheck.reference.hula_hoop.equations import SEMICIRCLE

ENGINES = ("mujoco", "exudyn")

BY_NAME = {row.name: row for row in read_paper(measures.SCENE).rows}
REGION_ROWS = [
    row for row in BY_NAME.values() if row.slow and re.match(r"5\.2|6|figure", row.section)
]


@pytest.fixture(scope="module")
def session() -> Session:
    return Session(engines=ENGINES)


@pytest.mark.parametrize(
    "name", ["mean_slope", "eigenvalues_62", "transient_end", "equations_of_motion"]
)
def test_engines_answer_where_they_can(session: Session, name: str) -> None:
    assert set(assess(BY_NAME[name], session).engines) == set(ENGINES)


# Rows can fail


def test_a_wrong_engine_fails_the_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    class Wrong:
        def __init__(self, engine: Any) -> None:
            self.engine = engine

        def bind(self, *args: Any) -> Any:
            self.bound = self.engine.bind(*args)
            return self

        def accelerations(self, *args: Any) -> Any:
            return 1.001 * self.bound.accelerations(*args)

    def choose_wrong(*args: Any) -> Any:
        engine, model = choose_engine(*args)
        return Wrong(engine), model

    choose_engine = query.choose_engine
    monkeypatch.setattr(query, "choose_engine", choose_wrong)
    assessment = assess(BY_NAME["equations_of_motion"], Session(engines=("mujoco",)))
    assert assessment.verdict == NOT_REPRODUCED


def test_a_wrong_plate_fails() -> None:
    (condition,) = BY_NAME["plate_inertia"].judgement[REPRODUCED]
    for wrong in (0.0, 1e-3):
        measured = measures.plate_inertia(Session(), SEMICIRCLE + wrong)
        assert condition.compare(measured).holds == (not wrong)


# Runs


def test_lock_in_sees_slips_reversals_and_the_direction() -> None:
    times = measures.samples(12.0)
    omega = 6 * np.pi
    for sign in (1, -1):
        theta = sign * (omega * times - 2 * np.pi / (1 + np.exp(40 * (times - 2))))
        speed = np.gradient(theta, times)
        speed[times < 1.0] *= -1
        end = measures.lock_in(times, theta, speed)
        assert end["turns"] == pytest.approx(sign)
        assert 1.5 < end["slip"] <= 2.0
        assert end["value"] == pytest.approx(1.0, abs=0.01)
        assert end["settled"] <= 2.34
        assert end["least"] == pytest.approx(1, abs=1e-6)


def test_second_harmonic_and_errors_are_those_of_the_orbit(session: Session) -> None:
    run = measures.example_rotation(session)
    theta = run.observables["theta"][:-1] - 6 * np.pi * run.times[:-1]
    amplitude = 2 * abs(np.fft.rfft(theta)[6]) / len(theta)  # three periods
    assert measures.second_harmonic(measures.example_orbit(session)) == pytest.approx(amplitude)
    errors = measures.approximation_errors(session)
    assert errors["paper"][1] > 1.4 > 0.1 > errors["corrected"][1]


@pytest.mark.slow
def test_readings_from_rest_are_like_the_run_that_queries_make(session: Session) -> None:
    run = measures.example_from_rest(session)
    single = measures.lock_in(run.times, run.observables["theta"], run.observables["theta_dot"])
    assert measures.from_rest(measures.EXAMPLE) == [measures.in_words(single)]


def test_difference_of_angles_is_taken_on_the_circle() -> None:
    gap = measures.apart(np.array([[1.0], [7.0], [0], [0]]), np.array([[0.5], [0.5], [0], [0]]))
    assert gap[:2, 0] == pytest.approx([0.5, 6.5 - 2 * np.pi])


# Maps


def test_regions_are_connected_and_sorted() -> None:
    where = np.zeros((6, 8), dtype=bool)
    where[0, 0] = where[1, 1] = where[2, 2] = True  # by their corners
    where[0:5, 5] = True
    where[5, 0] = True  # one point alone
    assert [int(region.sum()) for region in measures.regions(where)] == [5, 3]
    assert measures.near(where, 1)[5, 1]
    assert not measures.near(where, 1)[5, 3]


def test_regions_are_counted_with_several_choices(monkeypatch: pytest.MonkeyPatch) -> None:
    calm = np.ones((20, 20), dtype=bool)
    calm[np.ix_([0, 1, 2, 17, 18, 19], [0, 1, 2, 17, 18, 19])] = False
    monkeypatch.setattr(measures, "stable", lambda *which: calm)
    found = [measures.unstable_regions(Session(), False, count) for count in (4, 9)]
    assert set(found[0]["counts"].values()) == {4}
    assert 0 < found[0]["fitting"] < 1
    assert found[1]["fitting"] == 0


COUNT = 6
"""Points along an axis of maps that are made up."""


def synthetic(plate: bool = False) -> Map:
    """Fig. 5 with hula-hoop motion in the lower half, one point of it not robust.

    Fig. 7 (plate) has a row more of it.
    """
    motion = np.full((COUNT, COUNT), MOTIONS.index("red_x"), np.int8)
    motion[: COUNT // 2 + plate] = MOTIONS.index("blue_o")
    robust = np.ones_like(motion)
    robust[0, 0] = 0
    variables: dict[str, Any] = {"motion": motion, "label": 0 * motion, "robust": robust}
    for name in ("turns", "f_u", "min_speed", "periods"):
        variables[name] = np.ones((COUNT, COUNT))
    return Map(
        Axis("force_frequency", *measures.HERTZ, COUNT),
        Axis("force_amplitude", *measures.NEWTON, COUNT),
        variables,
        MOTION_VARIABLES,
        np.ones((COUNT, COUNT), dtype=bool),
        {"scene": "hula_hoop", "quantity": "class", "engine": "reference", "model": "exact",
         "method": None},
    )  # fmt: skip


class MadeUp(Session):
    """A session whose motions from rest are made up; other maps are those of the cache, if any."""

    def map(self, scene: str, quantity: str, x: Any, y: Any, **settings: Any) -> Map:
        """Return a map by its quantity, plate, engine and model."""
        key = quantity, bool(settings["parameters"]), settings["engine"], settings["model"]
        if quantity == "class":
            return self.once(key, lambda: synthetic(key[1]))
        return self.cache.get(key) or super().map(scene, quantity, x, y, **settings)


def made_up(*engines: str) -> Session:
    return MadeUp(engines, points=COUNT)


def test_agreement_counts_robust_points() -> None:
    session = made_up()
    calm = np.zeros((COUNT, COUNT), dtype=bool)
    calm[:4] = True  # six points too many; the one that is not robust would be right
    session.cache["hula_hoop.printed_multipliers", False] = np.where(calm, 0.5, 2.0)
    found = measures.agreements(session, REFERENCE, False)
    assert found["points"] == 35
    assert found["printed"] == pytest.approx(29 / 35)
    assert found["trivial"] == pytest.approx(18 / 35)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:An input array is constant")
def test_rows_on_regions_read_the_maps() -> None:
    """On a grid of 6 x 6 points; the corrected solution stands for the true rotation.

    Ends of the stable region are followed without a map.
    """
    session = made_up()
    for plate in (False, True):
        quick = measures.stability_map(session, plate, model="corrected")
        for model in (None, "exact"):
            session.cache["floquet", plate, REFERENCE, model] = quick
    rows = [row for row in REGION_ROWS if not row.name.startswith("upper_end")]
    by_name = {row.name: assess(row, session) for row in rows}
    for name, item in by_name.items():
        assert (item.verdict in VERDICTS) == (BY_NAME[name].kind != "reading"), name
        assert item.reason, name
    assert by_name["easier_with_inertia"].verdict == REPRODUCED
    assert by_name["easier_with_inertia"].reference == "50.0% to 66.7%"
    assert by_name["fewer_red"].verdict == REPRODUCED
    assert by_name["fewer_cyan"].verdict == NOT_REPRODUCED
    assert by_name["region_3"].verdict == NOT_REPRODUCED
    calm = measures.stable(session, False, "exact")
    assert by_name["large_set"].reference.startswith(f"true rotation stable at {np.mean(calm):.0%}")
    robust = synthetic().variables["robust"] == 1
    hoop = np.arange(COUNT)[:, None] < COUNT // 2
    share = np.mean((measures.stable(session, False, "printed") == hoop)[robust])
    assert by_name["good_agreement_4_5"].reference.startswith(f"printed solution {share:.1%};")


def test_names_of_formulas_are_arrays_of_figures() -> None:
    arrays, share = measures.Names(made_up(), REFERENCE), measures.share_of
    assert share(arrays["blue_o_5"], arrays["robust_5"]) == pytest.approx(17 / 35)
    assert share(arrays["cyan_o_5"], arrays["robust_5"]) == 0
    assert np.isnan(share(arrays["blue_o_5"], arrays["cyan_o_5"]))
    assert share(arrays["blue_o"]) == pytest.approx([1 / 2, 2 / 3])
    assert list(measures.number_of(arrays["frequency"] < 5)) == [3, 3]
    with pytest.raises(KeyError, match="blue_x"):
        arrays["blue_x_5"]


def test_figure_of_motions_from_rest() -> None:
    session = made_up(*ENGINES)
    own = measures.motion_map(session, False, "exudyn")
    own.variables["motion"][5, 5] = MOTIONS.index("cyan_plus")
    figure = motion_figure(session, plate=False)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert "mujoco agrees at 100.0%" in titles[1]
    assert "exudyn agrees at 97.1%" in titles[2]
    markers = {line.get_marker(): len(line.get_xdata()) for line in figure.axes[0].lines
               if len(line.get_xdata())}  # fmt: skip
    assert markers == {"o": 18, "x": 18}
    apart = {line.get_label(): len(line.get_xdata()) for line in figure.axes[3].lines}
    assert apart == {"not robust": 1, "mujoco differs": 0, "exudyn differs": 1}
