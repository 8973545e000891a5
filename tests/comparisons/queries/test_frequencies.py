"""`frequencies`: modes about a state of rest, damped and undamped."""

from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.reference.errors import (
    EngineError,
)
from mbcheck.tests.support.documents import validated

ENGINES = ("reference", "mujoco", "exudyn")

ACROSS = np.sqrt(1000 / 0.45)  # the free mass does not take part
ALIGNED = np.sqrt(1000 / 0.495)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("about", "omega"), [(None, ACROSS), ("rod_aligned", ALIGNED)])
def test_undamped_frequencies(engine: str, about: str | None, omega: float) -> None:
    found = mbcheck.frequencies("hula_hoop", about, engine=engine, undamped=True)
    document = validated("frequencies", found.as_json())
    zero, mode = document["modes"]
    assert zero["damping_ratio"] is None
    assert zero["omega"] == pytest.approx(0, abs=1e-6)
    assert mode["omega"] == pytest.approx(omega, rel=1e-9)
    assert mode["hertz"] == pytest.approx(omega / 2 / np.pi, rel=1e-9)
    assert document["about"] == (about or "rod_across")


@pytest.mark.parametrize("engine", ENGINES)
def test_damped_frequencies(engine: str) -> None:
    found = mbcheck.frequencies("hula_hoop", "rod_aligned", engine=engine)
    assert found.state["theta"] == np.pi / 2
    slide = found.modes[-1]
    assert slide.damping_ratio == pytest.approx(0.1, rel=1e-8)  # rho, by its definition
    assert slide.im == pytest.approx(ALIGNED * np.sqrt(1 - 0.1**2), rel=1e-8)
    assert [mode.omega for mode in found.modes] == sorted(mode.omega for mode in found.modes)
    assert len(mbcheck.frequencies("hula_hoop", engine=engine, count=1).modes) == 1


def test_an_engine_that_raises_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: Any) -> Any:
        raise ValueError("no such body\nand more")

    monkeypatch.setattr(get_engine("mujoco"), "linearise", broken)
    with pytest.raises(EngineError, match=r"ValueError: no such body$"):
        mbcheck.frequencies("hula_hoop", engine="mujoco")
