"""Mutate lines of modules at random and say which mutants no test sees, in a copy of the clone.

``python -m mbcheck.tests.support.mutate FILE... --count N --seed S``. A mutant meets the tests
that are named as its module first, then those of the folder that mirrors its own.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import monotonic

from .mutants import Mutant, mutants

LEFT_OUT = shutil.ignore_patterns(".*", "__pycache__", "build", "dist", "*.egg-info")

PATIENCE, GRACE = 3.0, 20.0
"""A mutant that takes so many times what the right module does, and so many seconds, is seen."""


def main() -> int:
    """Run what the command line asks for; return 1 where a mutant survives."""
    parser = argparse.ArgumentParser(prog="mutate", description=__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE", help="modules, relative to the clone")
    parser.add_argument("--count", type=int, default=20, help="of mutants, over all files")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--tests", nargs="+", help="tests to run in place of those that mirror")
    asked = parser.parse_args()
    clone = Path(__file__).resolve().parents[3]
    drawn = [
        (name, one)
        for name in asked.files
        for one in mutants((clone / name).read_text(encoding="utf-8"), asked.count, asked.seed)
    ]
    random.Random(asked.seed).shuffle(drawn)
    survivors, drawn = [], drawn[: asked.count]
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "mbcheck"  # as it is imported, whatever the clone is called
        shutil.copytree(clone, copy, ignore=LEFT_OUT)
        usual: dict[str, float] = {}
        for name, mutant in drawn:
            tests = asked.tests or tests_of(name, clone)
            seen = is_seen(copy, name, mutant, tests, usual)
            word = "killed" if seen else "SURVIVED"
            print(f"{word} {name}:{mutant.line}: {mutant.what}", flush=True)
            survivors += [] if seen else [mutant]
    killed = len(drawn) - len(survivors)
    print(f"{killed} of {len(drawn)} mutants killed: {killed / max(1, len(drawn)):.0%}")
    return int(bool(survivors))


def tests_of(name: str, clone: Path) -> list[str]:
    """Return the tests of a module, the quickest first; a folder without any has its parent's."""
    place = Path("tests") / Path(name).with_suffix("")
    named = sorted(path.relative_to(clone) for path in (clone / "tests").rglob("test_*.py")
                   if place.name in path.stem)  # fmt: skip
    folder = place.parent
    while not list((clone / folder).glob("test_*.py")) and folder != Path("tests"):
        folder = folder.parent
    return [*map(str, named), *([] if folder == Path("tests") else [str(folder)])]


def is_seen(
    copy: Path, name: str, mutant: Mutant, tests: list[str], usual: dict[str, float]
) -> bool:
    """Return whether a test fails, or takes far longer, with a mutant in the copy.

    Raises
    ------
    SystemExit
        If it fails without.
    """
    module = copy / name
    right = module.read_text(encoding="utf-8")
    for target in tests:
        if target not in usual:
            begin = monotonic()
            if not passes(copy, target, None):
                sys.exit(f"{target} fails before anything is changed")
            usual[target] = monotonic() - begin
        module.write_text(mutant.source, encoding="utf-8")
        try:
            if not passes(copy, target, PATIENCE * usual[target] + GRACE):
                return True
        finally:
            module.write_text(right, encoding="utf-8")
    return False


def passes(copy: Path, target: str, seconds: float | None) -> bool:
    """Return whether tests pass within a time [s]."""
    command = (sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", target)
    environment = os.environ | {"PYTHONPATH": str(copy.parent), "PYTHONDONTWRITEBYTECODE": "1"}
    process = subprocess.Popen(
        command,
        cwd=copy,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return process.wait(seconds) in (0, 5)  # 5: all are left out by their markers
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.wait()
        return False


if __name__ == "__main__":
    sys.exit(main())
