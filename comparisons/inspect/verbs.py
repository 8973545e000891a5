"""The verb ``mbcheck inspect``."""

from __future__ import annotations

from typing import Any

import click

from ..reports.files import Destination
from ..terminal.options import with_options_of
from ..terminal.program import JSON, JUNIT, SARIF, examples
from .request import InspectRun


@click.command(
    epilog=examples(
        "mbcheck inspect model.xml",
        "mbcheck inspect model.xml --full --about-rotation theta=10",
        "mbcheck inspect robots/ 'scenes/*.xml' --fail-on warning --sarif found.sarif",
        "mbcheck inspect model.xml --strict --ignore 'unused_*'",
        "mbcheck inspect model.xml --fix --dry-run",
    )
)
@with_options_of(InspectRun)
@JSON
@JUNIT
@SARIF
def inspect(
    json_file: Destination | None,
    junit_file: Destination | None,
    sarif_file: Destination | None,
    **options: Any,
) -> int:
    """Inspect MJCF models: mistakes, modes, largest stable steps, redundant parts.

    It reports findings, each with rule, reason and fix; natural frequencies and damping at each
    keyframe; the largest stable step of each integrator; the opening of soft loops. A comment in
    the file waives a finding: <!-- mbcheck: allow RULE, ELEMENT: REASON -->. Exit code 1 if an
    error (see --fail-on) is not waived, or a dry run of --fix would change something, 2 if a file
    cannot be read.
    """
    from .batch import inspect_models

    return inspect_models(InspectRun(**options), json_file, junit_file, sarif_file)
