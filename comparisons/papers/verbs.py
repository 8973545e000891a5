"""The verb ``mbcheck reproduce``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..reports.files import Destination
from ..terminal.options import with_options_of
from ..terminal.program import (
    FAILED,
    JSON,
    complain,
    console,
    examples,
    json_text,
    progress_bar,
    to_stdout,
)
from .reproduce import ReproduceRequest, announced, contents, reproduce

if TYPE_CHECKING:
    from .outcomes import Findings


@click.command(
    "reproduce",
    epilog=examples(
        "mbcheck reproduce --out papers",
        "mbcheck reproduce speed_regulator --figure 4 --out papers",
        "mbcheck reproduce rotating_beam --row crossover --out papers",
        "mbcheck reproduce --full --out papers --json ledger.json",
    ),
)
@with_options_of(ReproduceRequest)
@JSON
def reproduce_papers(json_file: Destination | None, **options: Any) -> int:
    """Draw the figures of the papers again, and judge what they print and claim.

    By the reference and by every installed engine. Exit code 0 whatever the verdicts
    on the papers are, 1 if something could not be drawn or judged.
    """
    from . import pages

    out = Path(options["out"])
    plan = announced(ReproduceRequest(**options))
    contents(out)  # refuses a folder that cannot be written
    click.echo(plan, err=True)
    try:
        with progress_bar(True, "figures and rows", lines=True) as advance:
            result = reproduce(**options, progress=advance)
    except KeyboardInterrupt:
        click.echo("finished figures and rows are kept: repeat with --resume", err=True)
        raise
    pages.write_pages(contents(out), out)
    if json_file:
        json_file.write(json_text(result.as_json()))
    if not to_stdout(json_file):
        print_reproduction(result, out, bool(options["rows"]))
    for words in result.failures:
        complain(words, FAILED)
    return FAILED if result.failures else 0


def print_reproduction(result: Findings, out: Path, each: bool) -> None:
    """Print each row's result, or the number of rows with each verdict, and where the pages are."""
    from ..engines.registry import REFERENCE
    from ..reports.text import print_line
    from .ledger import VERDICTS

    lines = []
    for row in result.rows if each else ():
        ours = {REFERENCE: row.reference, **row.engines}
        values = "; ".join(f"{name} {value}" for name, value in ours.items() if value)
        printed = f"printed {row.printed}" if row.printed else ""
        lines.append(f"{row.scene} {row.name}: {row.verdict or 'a reading'}")
        about = ("; ".join(filter(None, (printed, values))), row.reason)
        lines += [f"  {words}" for words in about if words]
    for scene in () if each else result.scenes:
        number, figures = result.verdicts(scene), len(result.figures_of(scene))
        words = ", ".join(f"{number[name]} {name}" for name in VERDICTS if number[name])
        lines.append(f"{scene}: {figures} figure{'s' * (figures != 1)}; {words or 'no rows'}")
    for line in (*lines, f"see {out / 'index.html'}"):
        print_line(console(), line)
