"""Engines that do what they must not are errors, and a right one beside them passes."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from mbcheck.comparisons.engines.isolation import STATM
from mbcheck.tests.support.command import process
from mbcheck.tests.support.engines import plugins

pytestmark = pytest.mark.skipif(not STATM.exists(), reason="signals and limits of Linux")

HOSTILE, HARMLESS = plugins.sources(), plugins.harmless()

FEW = (
    "import_exit_0", "simulate_abort", "zero_max", "unpickled", "evil_rows", "reason_5",
    "unsupported_reason_exit_0", "reason_later", "no_version",
)  # fmt: skip

SERVER = ("server",)
"""It kills the process from which those of all engines start: others may be starting then."""

REST = [name for name in HOSTILE if name not in FEW + SERVER]


def verdicts(
    folder: Path, names: Sequence[str], monkeypatch: pytest.MonkeyPatch, limit: int
) -> tuple[int, dict[str, dict[str, str]]]:
    """Return the exit code, and by engine the reason of each verdict."""
    monkeypatch.chdir(folder)
    Path("right.py").write_text(plugins.RIGHT)
    for name in names:
        Path(f"{name}.py").write_text(HOSTILE[name][0] if name in HOSTILE else HARMLESS[name])
    engines = " ".join(f"--engine {name}:Bad" for name in names)
    scratch = folder.parent / "emptied"  # a socket's path has 100 characters
    scratch.mkdir(exist_ok=True)
    done = process(
        "check hula_hoop --kind algebra --kind trajectory --id */point_mass_3hz_60n/* --json - "
        f"--junit junit.xml --time-limit {limit} --engine right:Right {engines}",
        TMPDIR=str(scratch),
    )
    assert done.stdout, done.stderr
    assert "Traceback" not in done.stderr
    assert not any(line.startswith("printed") for line in done.stderr.splitlines())
    reasons: dict[str, dict[str, str]] = {}
    for item in json.loads(done.stdout)["results"]:
        engine = item["engine"].removesuffix(":Bad")
        told = reasons.setdefault(engine, {})
        told[item["verdict"]] = f"{told.get(item['verdict'], '')} | {item['reason']}"
    assert Path("junit.xml").read_text()
    assert set(reasons.pop("right")) <= {"pass", "skipped"}
    return done.returncode, reasons


@pytest.mark.parametrize("names", [FEW, SERVER])
def test_some_are_contained(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, names: tuple[str, ...]
) -> None:
    refuse(tmp_path, names, monkeypatch, 300)


@pytest.mark.campaign
@pytest.mark.parametrize("names", [tuple(REST[i : i + 20]) for i in range(0, len(REST), 20)])
def test_all_are_contained(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, names: tuple[str, ...]
) -> None:
    assert len(HOSTILE) >= 80
    refuse(tmp_path, names, monkeypatch, 40)


def refuse(folder: Path, names: Sequence[str], monkeypatch: pytest.MonkeyPatch, limit: int) -> None:
    """Make sure that each of some engines fails, and why."""
    code, reasons = verdicts(folder, names, monkeypatch, limit)
    assert code == 1
    for name in names:
        verdict = {"own_unsupported": "skipped"}.get(name) or (
            "deviation" if "x its" in HOSTILE[name][1] else "error"
        )
        assert HOSTILE[name][1] in reasons[name][verdict], (name, reasons[name])


@pytest.mark.slow
def test_odd_and_right_engines_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code, reasons = verdicts(tmp_path, tuple(HARMLESS), monkeypatch, 60)
    wrong = {name: found for name, found in reasons.items() if set(found) - {"pass", "skipped"}}
    assert (code, wrong) == (0, {})


@pytest.mark.slow
def test_an_installed_package_ends_no_run(tmp_path: Path) -> None:
    about = tmp_path / "evil-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: evil\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[mbcheck.engines]\nevil = evil:Bad\n")
    (tmp_path / "evil.py").write_text("import os\nos._exit(0)\n")
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    done = process("check hula_hoop --kind frequency --json -", PYTHONPATH=path)
    results = json.loads(done.stdout)["results"]
    reasons = {item["engine"]: item["reason"] for item in results if item["verdict"] == "error"}
    assert "exit code 0" in reasons.pop("evil")
    assert not reasons
    assert {item["verdict"] for item in results if item["engine"] == "mujoco"} == {"pass"}
    assert done.returncode == 1
