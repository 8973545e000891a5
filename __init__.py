"""mbcheck: a validation suite for multibody engines.

`check`, `simulate`, `orbit`, `frequencies` and `reproduce` return, typed, what the command line
prints; `compute_map`, `read_map` and `compare_maps` are for maps, `tradeoff` is for what accuracy
costs, `judge_trajectory` for runs of other simulators, `compare` for two readings of a model.
`check_engine` is `check` of an engine given as an object. `budget` limits the time of all calls
within it.
`Engine`, `Method`, `Option`, `ModelDescription`, `System`, `Motion`, `Unsupported`, `EngineError`,
`UsageError`, `EngineUnavailableError`, `import_library` and `refuse_older` are for engines that
are plugged in. All are loaded when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .comparisons.check.request import check, check_engine
    from .comparisons.compare.comparison import compare
    from .comparisons.engines.protocol import (
        Engine,
        EngineError,
        EngineUnavailableError,
        Method,
        ModelDescription,
        Motion,
        Option,
        System,
        Unsupported,
        UsageError,
        import_library,
        refuse_older,
    )
    from .comparisons.inspect.inspection import inspect
    from .comparisons.judge.judge import judge_trajectory
    from .comparisons.maps.compare import compare as compare_maps
    from .comparisons.maps.run import compute_map
    from .comparisons.maps.store import read as read_map
    from .comparisons.papers.reproduce import reproduce
    from .comparisons.queries.frequencies import frequencies
    from .comparisons.queries.orbit import orbit
    from .comparisons.queries.simulate import simulate
    from .comparisons.tradeoff.report import tradeoff
    from .reference.cost import within as budget

    __version__: str

PLACES = {
    "Engine": ("comparisons.engines.protocol", "Engine"),
    "EngineError": ("comparisons.engines.protocol", "EngineError"),
    "EngineUnavailableError": ("comparisons.engines.protocol", "EngineUnavailableError"),
    "Method": ("comparisons.engines.protocol", "Method"),
    "Motion": ("comparisons.engines.protocol", "Motion"),
    "Option": ("comparisons.engines.protocol", "Option"),
    "ModelDescription": ("comparisons.engines.protocol", "ModelDescription"),
    "System": ("comparisons.engines.protocol", "System"),
    "Unsupported": ("comparisons.engines.protocol", "Unsupported"),
    "UsageError": ("comparisons.engines.protocol", "UsageError"),
    "budget": ("reference.cost", "within"),
    "check": ("comparisons.check.request", "check"),
    "check_engine": ("comparisons.check.request", "check_engine"),
    "compare": ("comparisons.compare.comparison", "compare"),
    "compare_maps": ("comparisons.maps.compare", "compare"),
    "compute_map": ("comparisons.maps.run", "compute_map"),
    "frequencies": ("comparisons.queries.frequencies", "frequencies"),
    "import_library": ("comparisons.engines.protocol", "import_library"),
    "inspect": ("comparisons.inspect.inspection", "inspect"),
    "judge_trajectory": ("comparisons.judge.judge", "judge_trajectory"),
    "orbit": ("comparisons.queries.orbit", "orbit"),
    "read_map": ("comparisons.maps.store", "read"),
    "refuse_older": ("comparisons.engines.protocol", "refuse_older"),
    "reproduce": ("comparisons.papers.reproduce", "reproduce"),
    "simulate": ("comparisons.queries.simulate", "simulate"),
    "tradeoff": ("comparisons.tradeoff.report", "tradeoff"),
}
"""Module and name of each public object."""

__all__ = [
    "Engine",
    "EngineError",
    "EngineUnavailableError",
    "Method",
    "ModelDescription",
    "Motion",
    "Option",
    "System",
    "Unsupported",
    "UsageError",
    "__version__",
    "budget",
    "check",
    "check_engine",
    "compare",
    "compare_maps",
    "compute_map",
    "frequencies",
    "import_library",
    "inspect",
    "judge_trajectory",
    "orbit",
    "read_map",
    "refuse_older",
    "reproduce",
    "simulate",
    "tradeoff",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module(".comparisons.queries.environment", __name__).own_version()
    if name == "OwnModel":
        raise AttributeError("mbcheck.OwnModel is now mbcheck.ModelDescription, see CHANGELOG.md")
    if name not in PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = PLACES[name]
    return getattr(import_module(f".{module}", __name__), attribute)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
