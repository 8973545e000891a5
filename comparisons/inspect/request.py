"""Requests of `inspect`: the fields that its function takes, and the options of its verb.

Nothing heavy is imported here, since help texts are made from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from ..documents.fields import OptionMark

FailOn = Literal["error", "warning", "note", "never"]


@dataclass(frozen=True)
class InspectRequest:
    """Request to inspect a model.

    Attributes
    ----------
    path : str or Path
        The MJCF file.
    about_rotation : mapping of str to float
        Also find the modes about the steady rotation of a hinge [rad/s].
    modes : bool or None
        Find modes of models of any size, or none; by default up to 120 degrees of freedom.
    strict : bool
        Evaluate rules of the house, too, which are matters of taste.
    select : sequence of str
        Evaluate this rule, and no others but those selected; * is a wildcard.
    ignore : sequence of str
        Leave out this rule; * is a wildcard.
    waivers : str or None
        Waivers with their reasons; by default mbcheck-inspect.toml beside the model, if any.
    baseline : str or None
        Waive the findings of a document of --json.
    """

    path: str | Path
    about_rotation: Annotated[Mapping[str, float | str], OptionMark("JOINT=SPEED")] = field(
        default_factory=dict
    )
    modes: Annotated[bool | None, OptionMark()] = None
    strict: Annotated[bool, OptionMark()] = False
    select: Annotated[Sequence[str], OptionMark("RULE")] = ()
    ignore: Annotated[Sequence[str], OptionMark("RULE")] = ()
    waivers: Annotated[str | None, OptionMark("FILE.toml")] = None
    baseline: Annotated[str | None, OptionMark("FILE")] = None


@dataclass(frozen=True, kw_only=True)
class InspectRun(InspectRequest):
    """Request of the verb; ``path`` is one of its models after the other.

    Attributes
    ----------
    models : sequence of str
        Files, folders and patterns.
    full : bool
        Print all tables, every finding, and the waivers to paste for them.
    lines : bool
        Print a line for each finding, as for many files.
    whole_models : bool
        Leave out files that are not MJCF, or that another one includes, as in folders.
    budget : float or None
        Stop after this time, and report the findings so far; by default without limit.
    fail_on : {"error", "warning", "note", "never"}
        The least severity that makes exit code 1.
    annotations : bool or None
        Print annotations for GitHub; by default if GITHUB_ACTIONS is true.
    fix : bool
        Remove attributes without which the file compiles to the same model, to the last bit.
    dry_run : bool
        With --fix: print the edits, and make none.
    """

    path: str | Path = ""
    models: Annotated[Sequence[str], OptionMark("[MODEL.xml|FOLDER|PATTERN]...", flags=())] = ()
    full: Annotated[bool, OptionMark()] = False
    lines: Annotated[bool, OptionMark()] = False
    whole_models: Annotated[bool, OptionMark()] = False
    budget: Annotated[float | None, OptionMark("SECONDS")] = None
    fail_on: Annotated[FailOn, OptionMark()] = "error"
    annotations: Annotated[bool | None, OptionMark()] = None
    fix: Annotated[bool, OptionMark()] = False
    dry_run: Annotated[bool, OptionMark()] = False
