"""The pytest plugin: the same checks as `mbcheck check`, and silence where it is not asked."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks import suite
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.catalogue import FAULTS
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.documents import validated

pytest_plugins = "pytester"

MODULE = "mbcheck.comparisons.cli.pytest_plugin"
TESTS = ("--pyargs", "mbcheck.tests.conformance")
SMALL = (*TESTS, "--mbcheck-engine=mujoco", "--mbcheck-scene=hula_hoop", "--mbcheck-kind=frequency")
KNOWN = """
[[known]]
id = "*/frequency/mujoco/*"
reason = "the spring is too stiff: issue 12"
"""


@pytest.fixture(autouse=True)
def _no_other_plugins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out what is installed; ours may be, and is loaded by hand."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)


@pytest.fixture
def _wrong_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let MuJoCo's model have a spring that is 0.1 % too stiff."""
    wrong = FAULTS["hula_hoop"]["spring_0.1_percent"].make["mujoco"]()

    def chosen(name: str) -> Any:
        return wrong if name == "mujoco" else get_engine(name)

    monkeypatch.setattr(suite, "get_engine", chosen)


def run(pytester: pytest.Pytester, *arguments: str) -> tuple[int, str]:
    """Run pytest in this process; return its exit code and all that it prints."""
    done = pytester.runpytest_inprocess("-p", "no:cacheprovider", "-p", MODULE, *arguments)
    return int(done.ret), done.stdout.str() + done.stderr.str()


def verdicts(file: Path) -> dict[str, tuple[str, Any, Any]]:
    found = json.loads(file.read_text())
    validated("check", found)
    return {
        item["id"]: (item["verdict"], item["error"], item["known"]) for item in found["results"]
    }


# The same checks


@pytest.mark.usefixtures("_wrong_engine")
def test_pytest_and_the_command_line_agree(pytester: pytest.Pytester) -> None:
    (pytester.path / "k.toml").write_text(KNOWN)
    same = ("engine=mujoco", "kind=frequency", "kind=algebra", "known=k.toml")
    scenes = ("hula_hoop", "speed_regulator")
    options = [f"--{word}" for word in (*same, "json=a.json")]
    line = " ".join(["check", *scenes, "-q -j 1", *options])
    words = (*same, "json=b.json", *(f"scene={scene}" for scene in scenes))
    code, _ = run(pytester, *TESTS, *(f"--mbcheck-{word}" for word in words))
    assert code == invoke(line).exit_code == 1
    by_line, by_pytest = (verdicts(pytester.path / name) for name in ("a.json", "b.json"))
    assert list(by_line.items()) == list(by_pytest.items())
    every = {verdict for verdict, *_ in by_line.values()}
    assert every == {"pass", "deviation", "known", "skipped", "error"}


def test_a_right_engine_passes(pytester: pytest.Pytester) -> None:
    code, text = run(pytester, *SMALL)
    assert code == 0
    assert f"mujoco {get_engine('mujoco').version}" in text.partition("collected")[0]
    assert "3 checks: 3 ran" in text
    assert re.search("PASS: [1-9][0-9]* passed", text)


@pytest.mark.usefixtures("_wrong_engine")
def test_a_deviation_is_a_failure_without_a_traceback(pytester: pytest.Pytester) -> None:
    code, text = run(pytester, *SMALL)
    assert code == 1
    assert re.search(r"deviation +rest_rod_aligned +tree +undamped_omega_2 .* 5e\+07", text)
    words = " ".join(text.replace("\\\n", "").split())
    assert "mbcheck check --id 'verification/hula_hoop/" in words
    assert "Traceback" not in text
    assert "pytest_plugin.py" not in text
    assert "FAIL: " in text


# Known deviations


@pytest.mark.usefixtures("_wrong_engine")
def test_a_known_deviation_is_an_expected_failure(pytester: pytest.Pytester) -> None:
    (pytester.path / "k.toml").write_text(KNOWN)
    code, text = run(pytester, *SMALL, "--mbcheck-known=k.toml", "--mbcheck-strict-known", "-rx")
    assert code == 0
    assert "3 xfailed" in text
    assert "XFAIL" in text
    assert "known deviation: the spring is too stiff: issue 12" in text
    code, text = run(pytester, *SMALL, "--mbcheck-known=k.toml", "--runxfail")
    assert code == 1
    assert "3 failed" in text


def test_a_stale_entry_is_told_and_may_fail(pytester: pytest.Pytester) -> None:
    (pytester.path / "k.toml").write_text(KNOWN.replace("*/frequency", "*/hula_hoop/*/frequency"))
    code, text = run(pytester, *SMALL, "--mbcheck-known=k.toml")
    assert code == 0
    assert "stale: k.toml, entry 1" in text
    code, text = run(pytester, *SMALL, "--mbcheck-known=k.toml", "--mbcheck-strict-known")
    assert code == 1
    code, text = run(
        pytester, *SMALL, "--mbcheck-known=k.toml", "--mbcheck-strict-known", "-k", "aligned"
    )
    assert code == 0  # the run was filtered: not all of its checks ran
    assert "stale:" not in text


def test_options_from_the_ini_file(pytester: pytest.Pytester) -> None:
    folder = pytester.mkdir("ci")
    (folder / "k.toml").write_text(KNOWN.replace("mujoco", "nothing"))
    pytester.makeini(
        """
        [pytest]
        mbcheck_engine = mujoco
        mbcheck_known = ci/k.toml
        mbcheck_strict_known = true
        """
    )
    (pytester.path / "deep").mkdir()
    os.chdir(pytester.path / "deep")
    code, text = run(pytester, *TESTS, "--rootdir=..", "-c../tox.ini", "-k", "rest_rod_across")
    assert code == 1
    assert "no check has such an id" in text
    assert "exudyn" not in text


# Nothing ran


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("-k", "nothing"), 2),
        (("--mbcheck-scene=speed_regulator", "-k", "transmission"), 2),  # which cannot run
    ],
)
def test_nothing_that_ran_is_a_failure(
    pytester: pytest.Pytester, arguments: tuple[str, ...], code: int
) -> None:
    ended, text = run(pytester, *SMALL, *arguments)
    assert ended == code
    assert "NOTHING RAN" in text


def test_options_without_the_tests_are_a_failure(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_mine(): pass")
    code, text = run(pytester, "--mbcheck-engine=mujoco")
    assert code == 2
    assert "add --pyargs mbcheck.tests.conformance" in text


def test_collecting_is_no_failure(pytester: pytest.Pytester) -> None:
    code, text = run(pytester, *SMALL, "--collect-only", "-q")
    assert code == 0
    assert text.count("verification/hula_hoop/") == 3


# Misuse


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("--mbcheck-engine=mujco", "unknown engine 'mujco'; did you mean 'mujoco'?"),
        ("--mbcheck-engine=no.such:Thing", "no.such cannot be imported"),
        ("--mbcheck-scene=hula", "did you mean 'hula_hoop'?"),
        ("--mbcheck-kind=freqency", "did you mean 'frequency'?"),
        ("--mbcheck-id=nothing", "no check matches"),
        ("--mbcheck-profile=lose", "did you mean 'loose'?"),
        ("--mbcheck-known=nowhere.toml", "cannot read 'nowhere.toml'"),
        ("--mbcheck-strict-known", "needs a file of known deviations"),
        ("--mbcheck-json=nowhere/r.json", "No such file or directory"),
    ],
)
def test_misuse_is_one_line(pytester: pytest.Pytester, option: str, words: str) -> None:
    code, text = run(pytester, *TESTS, option)
    assert code == pytest.ExitCode.USAGE_ERROR
    (line,) = text.splitlines()
    assert line.startswith("ERROR: mbcheck: ")
    assert words in line


def test_a_broken_ini_file_where_the_checks_are_collected_by_the_way(
    pytester: pytest.Pytester,
) -> None:
    pytester.makeini("[pytest]\nmbcheck_known = nowhere.toml\n")
    pytester.makepyfile(
        """
        from mbcheck.comparisons.cli.pytest_plugin import parametrize, run_test

        def pytest_generate_tests(metafunc):
            parametrize(metafunc)

        def test_check(check, request):
            run_test(check, request.node)
        """
    )
    code, text = run(pytester)
    assert code == 2
    assert "mbcheck: --known: cannot read" in text
    assert "Traceback" not in text


def test_the_commands_of_the_page(pytester: pytest.Pytester, clone: Path) -> None:
    page = (clone / "docs" / "ci.md").read_text(encoding="utf-8")
    lines = re.findall(r"^pytest (.*)$", page, re.MULTILINE)
    assert lines
    (pytester.path / "mbcheck-known.toml").write_text("")
    for line in lines:
        words = line.replace("-n auto", "").split()
        assert run(pytester, *words, "--collect-only", "-q", "-k", "frequency")[0] == 0
    options = set(re.findall(r"`?(--mbcheck-[a-z-]+)", page))
    _, told = run(pytester, "--help")
    assert options == set(re.findall(r"--mbcheck-[a-z-]+", told))


# Everyone else


def process(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_it_is_light_and_silent_in_other_projects(tmp_path: Path) -> None:
    folder = tmp_path / "tests" / "conformance"  # a common name
    folder.mkdir(parents=True)
    (folder / "test_theirs.py").write_text(
        "import sys\n"
        "def test_theirs():\n"
        "    ours = [name for name in sys.modules if name.startswith('mbcheck')]\n"
        "    assert len(ours) < 15, ours\n"
        "    assert not {'numpy', 'mujoco', 'exudyn', 'rich', 'click'} & set(sys.modules)\n"
    )
    done = process(tmp_path, "-p", MODULE, "tests/conformance")
    assert done.returncode == 0, done.stdout
    assert "mbcheck" not in done.stdout.replace(str(tmp_path), "")
    assert not done.stderr


def test_the_tests_run_without_the_plugin(pytester: pytest.Pytester) -> None:
    done = pytester.runpytest_inprocess(*TESTS, "-k", "rest_rod_across and mujoco")
    assert int(done.ret) == 0
    assert "1 passed" in done.stdout.str()


def test_the_summary_of_github(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    summary = pytester.path / "summary.md"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(summary))
    run(pytester, *SMALL)
    assert re.match("## mbcheck: PASS: [1-9][0-9]* passed", summary.read_text())


@pytest.mark.slow
def test_processes_of_xdist_report_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "k.toml").write_text(KNOWN.replace("*/frequency", "*/hula_hoop/*/frequency"))
    (tmp_path / "wrong.py").write_text(
        "from mbcheck.comparisons.checks import suite\n"
        "from mbcheck.comparisons.engines.registry import get_engine\n"
        "from mbcheck.comparisons.faults.catalogue import FAULTS\n"
        "wrong = FAULTS['hula_hoop']['spring_0.1_percent'].make['mujoco']()\n"
        "suite.get_engine = lambda name: wrong if name == 'mujoco' else get_engine(name)\n"
    )
    options = ("-p", "xdist", "-n", "2", *SMALL, "--mbcheck-kind=algebra")
    known = ("--mbcheck-known=k.toml", "--mbcheck-json")
    right = process(tmp_path, "-p", MODULE, *options, *known, "right.json")
    assert right.returncode == 0, right.stdout
    assert right.stdout.count("stale: k.toml") == 1
    assert "mujoco " in right.stdout.partition("workers")[0]
    env_path = ("-p", "wrong", "-p", MODULE)
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    monkeypatch.setenv("PYTHONPATH", path)
    wrong = process(tmp_path, *env_path, *options, *known, "wrong.json")
    assert wrong.returncode == 1, wrong.stdout
    assert "xfailed" in wrong.stdout
    good, bad = (verdicts(tmp_path / name) for name in ("right.json", "wrong.json"))
    assert list(good) == list(bad)
    assert {verdict for verdict, *_ in bad.values()} == {"pass", "known", "deviation"}
