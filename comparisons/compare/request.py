"""The request of `compare`: parameters of its function, and options of its verb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ..documents.fields import OptionMark


@dataclass(frozen=True)
class CompareRequest:
    """Two readings of one model.

    Attributes
    ----------
    a, b : str
        FILE, or FILE@READER: mujoco, mujoco==3.3.7, the path of a Python that has MuJoCo, or, of
        B, an engine as package.module:Class.
    install : bool
        Install a missing release of MuJoCo into the user's cache.
    waivers : str or None
        Waivers of differences, with their reasons.
    annotations : bool or None
        Print annotations for GitHub; by default where GITHUB_ACTIONS is true.
    """

    a: Annotated[str, OptionMark("A", flags=())]
    b: Annotated[str, OptionMark("B", flags=())]
    install: Annotated[bool, OptionMark()] = False
    waivers: Annotated[str | None, OptionMark("FILE.toml")] = None
    annotations: Annotated[bool | None, OptionMark()] = None
