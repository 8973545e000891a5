"""Options of ``check``, and the ``selection`` of its document.

Nothing heavy is imported here, since help texts are made from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Annotated

from ..documents.fields import JOBS, OptionMark

SOURCES = ("verification", "validation")
"""Subjects of checks: engines (the default) or papers."""

AS_THEY_STAND = "none"
"""Placement of models as their files place them."""


@dataclass(frozen=True)
class CheckRequest:
    """Which checks are to run, and what their results are compared with.

    Attributes
    ----------
    scenes : sequence of str
        Only these scenes.
    engines : sequence of str
        Only this engine, or package.module:Class.
    kinds : sequence of str
        Only this kind of check.
    methods : sequence of str
        Only this integrator.
    ids : sequence of str
        Only results whose id matches; * and ? are wildcards.
    source : {"verification", "validation"}
        Check engines (verification), or what the papers say (validation).
    profile : {"strict", "default", "loose"}
        Scales every tolerance.
    known : str or None
        TOML file of deviations that are known, and do not fail; see docs/ci.md.
    strict_known : bool
        Fail if an entry of --known is stale.
    parameters : mapping of str to float or str
        Change a parameter from its default, SI units.
    state : mapping of str to float
        Initial value, otherwise 0, SI units.
    horizon : float or None
        With --set and --state: how long engines run [s]; by default as many periods as in the
        scene's first case.
    quick : bool
        A first answer within seconds: parts, algebra, a step and a trajectory of each scene.
    placement : str
        Place all models in the world by a random rotation (turned:SEED) or as mirror images
        (mirrored:SEED); none leaves those out that the default set has placed so.
    extremes : bool
        Check engines at extremes, in place of the usual cases; see mbcheck extremes.
    full : bool
        Include the cases left out of the default set.
    """

    scenes: Annotated[Sequence[str], OptionMark("[SCENE]...", flags=())] = ()
    engines: Annotated[Sequence[str], OptionMark("ENGINE")] = ()
    kinds: Annotated[Sequence[str], OptionMark("KIND")] = ()
    methods: Annotated[Sequence[str], OptionMark("METHOD")] = ()
    ids: Annotated[Sequence[str], OptionMark("PATTERN")] = ()
    profile: Annotated[str, OptionMark("strict|default|loose")] = "default"
    full: Annotated[bool, OptionMark()] = False
    known: Annotated[str | None, OptionMark("FILE")] = None
    strict_known: Annotated[bool, OptionMark()] = False
    parameters: Annotated[Mapping[str, float | str], OptionMark("NAME=VALUE", flags=("--set",))] = (
        field(default_factory=dict)
    )
    state: Annotated[Mapping[str, float], OptionMark("NAME=VALUE")] = field(default_factory=dict)
    horizon: Annotated[float | None, OptionMark("T")] = None
    source: Annotated[str, OptionMark("SOURCE")] = SOURCES[0]
    quick: Annotated[bool, OptionMark()] = False
    placement: Annotated[str, OptionMark("PLACEMENT")] = ""
    extremes: Annotated[bool, OptionMark()] = False

    @property
    def is_custom(self) -> bool:
        """Whether engines are checked at the user's own parameters."""
        return bool(self.parameters or self.state) or self.horizon is not None

    @property
    def axes(self) -> str:
        """The placement of all models; empty for that of their files."""
        return "" if self.placement == AS_THEY_STAND else self.placement


@dataclass(frozen=True, kw_only=True)
class Execution:
    """How checks are run.

    Attributes
    ----------
    jobs : int
        Processes, on which results do not depend; by default one for each core on the command line,
        and one in Python.
    fail_fast : bool
        Stop at the first new deviation or error.
    time_limit : float or None
        Stop a check that takes longer [s]: an error, and the others go on.
    memory_limit : float or None
        The same for a check that takes more memory [MiB] (on Linux).
    """

    jobs: Annotated[int, JOBS] = 1
    fail_fast: Annotated[bool, OptionMark()] = False
    time_limit: Annotated[float | None, OptionMark("SECONDS")] = None
    memory_limit: Annotated[float | None, OptionMark("MB")] = None

    def limited(self) -> AbstractContextManager[None]:
        """Return a context in which engines of others are loaded within the limits of a check."""
        from ..engines.isolation import within_limits

        return within_limits(self.time_limit, self.memory_limit)
