"""80 columns: nothing that a verb prints is wider, but for an id on a line of its own."""

import io
import json
from pathlib import Path

import pytest

from mbcheck import models
from mbcheck.comparisons.cli.group import VERBS, program
from mbcheck.tests.support.command import SMALL, invoke, process, refusal, succeeds

WIDTH = 80

MODEL = Path(models.__file__).parent / "hula_hoop" / "hula_hoop.xml"


def too_wide(text: str) -> list[str]:
    """Return the lines of more than 80 columns, but those of an id, with ``--id`` before it."""
    lines = [line for line in text.splitlines() if len(line) > WIDTH]
    return [line for line in lines if len(line.split()[-1]) < WIDTH - len("      --id ")]


@pytest.mark.parametrize("verb", ["", *VERBS])
def test_help_fits(verb: str) -> None:
    assert not too_wide(succeeds(f"{verb} --help"))


@pytest.mark.parametrize(
    "line",
    [
        "list",
        "list --coverage",
        "simulate hula_hoop --times 0:0.02:0.01",
        "simulate floating_beam --times 0:0.002:0.001 --observe all",
        "orbit hula_hoop",
        "frequencies rotor_pendulum",
        "check ball_hoop --quick --engine mujoco --kind algebra --kind parts -v",
        "compare {model} {model}",
        pytest.param(SMALL, marks=pytest.mark.slow),
        pytest.param("reproduce rotor_pendulum --row eta --out {folder}", marks=pytest.mark.slow),
    ],
)
def test_what_a_verb_prints_fits(line: str, tmp_path: Path) -> None:
    pytest.importorskip("mujoco", exc_type=ImportError)
    text = succeeds(line.format(model=MODEL, folder=tmp_path))
    assert text
    assert not too_wide(text)


def test_a_comparison_of_runs_and_a_judgement_fit(tmp_path: Path) -> None:
    pytest.importorskip("mujoco", exc_type=ImportError)
    line = f"check hula_hoop --engine mujoco --kind algebra --json {tmp_path}/right.json"
    assert not too_wide(succeeds(line))
    document = json.loads((tmp_path / "right.json").read_text("utf-8"))
    for result in document["results"][::2]:
        result |= {"verdict": "deviation", "error": 0.25, "reason": "why " * 60}
    (tmp_path / "wrong.json").write_text(json.dumps(document), "utf-8")
    for more in ("", " -v"):
        changes = invoke(f"diff {tmp_path}/right.json {tmp_path}/wrong.json{more}")
        assert changes.exit_code == 1
        assert not too_wide(changes.stdout)
    succeeds(f"simulate hula_hoop --times 0:0.1:0.01 --csv {tmp_path}/run.csv")
    judged = invoke(f"judge {tmp_path}/run.csv --case hula_hoop/rod_aligned --tolerance 1e-3")
    assert judged.exit_code == 1
    assert not too_wide(judged.stdout)


class Terminal(io.StringIO):
    """Standard error on a terminal."""

    def isatty(self) -> bool:
        return True


def test_an_error_is_wrapped_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    line = "list zzzzzz"
    assert len(refusal(line)) > WIDTH
    monkeypatch.setattr("sys.stderr", screen := Terminal())
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    assert program.exit_code(line.split()) == 2
    assert not too_wide(screen.getvalue())
    assert " ".join(screen.getvalue().split()) == refusal(line)


# Completion


def completed(*words: str) -> list[str]:
    """Return what bash offers for the last of some words."""
    done = process(
        "",
        _MBCHECK_COMPLETE="bash_complete",
        COMP_WORDS=" ".join(("mbcheck", *words)),
        COMP_CWORD=str(len(words)),
    )
    return [line.removeprefix("plain,") for line in done.stdout.splitlines()]


def test_the_shell_completes_verbs_and_options() -> None:
    assert completed("comp") == ["compare", "compare-maps"]
    assert completed("check", "--prof") == ["--profile"]
    assert "complete(" in process("", _MBCHECK_COMPLETE="bash_source").stdout.replace(" ", "(")
