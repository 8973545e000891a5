"""Request of ``mbcheck tradeoff``: scenes, or an MJCF file."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, fields
from typing import Annotated

from ...reference.errors import UsageError
from ..documents.fields import OptionMark, number_from

TARGETS = (1e-2, 1e-3, 1e-4)
"""Relative errors for which settings of scenes are recommended by default."""

OF_MODELS = ("horizon", "budget", "observed", "seed", "exact")
"""Fields for MJCF files only."""


@dataclass(frozen=True)
class TradeoffRequest:
    """Everything that a trade-off depends on.

    Attributes
    ----------
    scenes : tuple of str
        Names of scenes, all if there are none; or one MJCF file.
    engines : tuple of str
        Run only this engine.
    targets : tuple of float
        Relative error to recommend settings for; by default 0.01, 0.001 and 0.0001 for scenes, 0.01
        for a model, which has one
    horizon : float
        For a model: simulated time of each run [s], rounded to a multiple of 8 steps of the file.
    budget : float
        For a model: time to try settings [s].
    observed : tuple of str
        For a model: judge by this joint or site, not by all joints.
    seed : int
        For a model: seed of the moving controls.
    exact : bool
        For a model: compare with exactly closed loops, and try how hard closures must be.
    resume : str or None
        Keep runs in FILE, and continue from those of an earlier call.

    Raises
    ------
    UsageError
        If a number makes no sense, or an option does not go with a scene or a file.
    """

    scenes: Annotated[tuple[str, ...], OptionMark("[SCENE|MODEL.xml]...", ())] = ()
    engines: Annotated[tuple[str, ...], OptionMark("ENGINE")] = ()
    targets: Annotated[tuple[float, ...], OptionMark("ERR", parse=number_from)] = ()
    horizon: Annotated[float, OptionMark("T")] = 1.0
    budget: Annotated[float, OptionMark("SECONDS")] = 120.0
    observed: Annotated[tuple[str, ...], OptionMark("NAME", ("--observe",))] = ()
    seed: Annotated[int, OptionMark("N", least=0)] = 1
    exact: Annotated[bool, OptionMark(flags=("--exact-closures",))] = False
    resume: Annotated[str | None, OptionMark("FILE")] = None

    def __post_init__(self) -> None:
        for target in self.targets:
            if not 0 < target < 1:
                raise UsageError(f"a target is a relative error between 0 and 1, not {target!r}")
        if not self.is_model:
            defaults = {item.name: item.default for item in fields(self)}
            if any(getattr(self, name) != defaults[name] for name in OF_MODELS):
                options = "--horizon, --budget, --observe, --seed and --exact-closures"
                raise UsageError(f"{options} are for a model: give MODEL.xml")
            return
        for name in ("horizon", "budget"):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise UsageError(f"--{name} must be a positive number, not {value:g}")
        wrong = {
            f"one file, and nothing else ({', '.join(self.scenes)})": len(self.scenes) > 1,
            f"one --target ({', '.join(map(str, self.targets))})": len(self.targets) > 1,
            f"no --engine ({', '.join(self.engines)}): MuJoCo runs it": bool(self.engines),
        }
        if any(wrong.values()):
            raise UsageError("for a model: " + "; ".join(words for words in wrong if wrong[words]))

    @property
    def is_model(self) -> bool:
        """True if a file is named, not scenes."""
        return any(name.lower().endswith(".xml") or os.path.isfile(name) for name in self.scenes)

    @property
    def target(self) -> float:
        """Largest target, the only one of a model."""
        return max(self.targets, default=TARGETS[0])
