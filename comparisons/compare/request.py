"""What `compare` is asked for: the fields that its function takes, and the options of its verb."""

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
        FILE, or FILE@READER: mujoco, mujoco==3.3.7, or the path of a Python that has MuJoCo.
    install : bool
        Install a missing release of MuJoCo into the user's cache.
    annotations : bool or None
        Print annotations for GitHub; by default where GITHUB_ACTIONS is true.
    """

    a: Annotated[str, OptionMark("A", flags=())]
    b: Annotated[str, OptionMark("B", flags=())]
    install: Annotated[bool, OptionMark()] = False
    annotations: Annotated[bool | None, OptionMark()] = None
