"""The names that `import mbcheck` offers."""

import subprocess
import sys
from pathlib import Path

import pytest

import mbcheck
from mbcheck.comparisons.queries.simulate import simulate

VERBS = "check diff export extremes frequencies inspect list orbit simulate"


@pytest.mark.parametrize(
    "line",
    [
        "import mbcheck",
        *(
            f"from mbcheck.comparisons.cli.group import program; program.exit_code({words})"
            for words in (["--help"], *([verb, "--help"] for verb in VERBS.split()))
        ),
    ],
)
def test_import_and_help_are_cheap(tmp_path: Path, line: str) -> None:
    heavy = {"numpy", "scipy", "mujoco", "exudyn", "msgspec", "jinja2", "matplotlib", "sympy"}
    loaded = f"import sys; {line}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", loaded], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_public_names() -> None:
    assert set(mbcheck.__all__) <= set(dir(mbcheck))
    assert mbcheck.simulate is simulate
    assert isinstance(mbcheck.__version__, str)
    with pytest.raises(AttributeError, match="simulat"):
        mbcheck.simulat  # noqa: B018
