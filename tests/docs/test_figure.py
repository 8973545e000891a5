"""The picture of the README, drawn by a script in `docs`."""

from __future__ import annotations

import importlib
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mbcheck.reference import SCENES
from mbcheck.reference.errors import UsageError


@pytest.fixture
def figure(clone: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the script as a module."""
    monkeypatch.syspath_prepend(clone / "docs")
    for name in ("figure", "sketches", "drawn_runs"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return importlib.import_module("figure")


def brief(row: Any) -> Any:
    """Return a row with runs of a sixteenth of their length, and two points of each curve."""
    motions = tuple(short(motion) for motion in row.motions)
    panel = row.panel._replace(last=row.panel.first + 1)
    return row._replace(motions=motions, panel=short(panel) if hasattr(panel, "case") else panel)


def short(item: Any) -> Any:
    """Return what has a case with a sixteenth of its horizon."""
    return item._replace(case=replace(item.case, horizon=item.case.horizon / 16))


FEW = "hula_hoop", "speed_regulator", "rigid_body"


@pytest.mark.parametrize(
    ("length", "scenes"),
    [
        ("brief", FEW),
        pytest.param("brief", SCENES, marks=pytest.mark.slow),
        pytest.param("whole", SCENES, marks=pytest.mark.campaign),
    ],
    ids=["brief-few", "brief-all", "whole-all"],
)
def test_figure_is_drawn(length: str, scenes: tuple[str, ...], tmp_path: Path, figure: Any) -> None:
    for engine in ("mujoco", "exudyn", "matplotlib"):
        pytest.importorskip(engine, exc_type=ImportError)
    rows = {scene: row for scene, row in figure.rows().items() if scene in scenes}
    if length == "brief":
        rows = {scene: brief(row) for scene, row in rows.items()}
    figure.scenes_figure(tmp_path / "a.png", rows)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "a.png").stat().st_size < 30_000 * len(rows)


def test_figure_has_every_scene(figure: Any) -> None:
    assert set(figure.rows()) == set(figure.SKETCHES) == set(SCENES)


def test_figure_without_matplotlib(
    tmp_path: Path, figure: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UsageError, match=r"pip install 'mbcheck\[plot\]'"):
        figure.scenes_figure(tmp_path / "a.png", {})


def test_figure_refuses_other_files(
    tmp_path: Path, figure: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    assert figure.main([str(tmp_path / "a.jpg")]) == 2
    assert "unknown kind of picture '.jpg'" in capsys.readouterr().err


def test_figure_is_called_by_its_path(clone: Path, tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, clone / "docs" / "figure.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 2
    assert ended.stderr == "usage: python docs/figure.py PATH\n"


def test_the_picture_of_the_readme_shows_which_engine_is_wrong(
    tmp_path: Path, clone: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("mujoco", "matplotlib"):
        pytest.importorskip(module, exc_type=ImportError)
    monkeypatch.syspath_prepend(clone / "docs")
    picture = importlib.import_module("picture")
    found = picture.runs(picture.STEPS[2:4])
    assert found["right"][0] > 14 * found["right"][1]
    assert found["wrong"][1] > 0.9 * found["wrong"][0] > 1e-3
    picture.draw(tmp_path / "picture.png", found)
    header = (tmp_path / "picture.png").read_bytes()[16:24]
    assert (int.from_bytes(header[:4]), int.from_bytes(header[4:])) == (800, 500)
