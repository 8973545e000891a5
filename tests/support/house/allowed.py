"""What the rules of the house allow, each with its reason."""

from __future__ import annotations

from collections.abc import Mapping

DOCUMENT = "a field of the JSON document"
FOREIGN = "runs code of an engine, which raises what it likes"

ALLOWED: Mapping[str, Mapping[str, str]] = {
    "engines_by_name": {
        "comparisons/engines/registry.py::exudyn": "loads it",
        "comparisons/engines/registry.py::mujoco": "loads it",
        "comparisons/compare/reading.py::mujoco": "whose readings are compared",
    },
    "asked_engines": {
        "comparisons/faults/reference.py::Impostor.__getattr__": "delegates all there is",
        "comparisons/faults/variants.py::Wrapped.__getattr__": "delegates all there is",
    },
    "broad_excepts": {
        "comparisons/checks/diagnosis.py::cause": "runs the engine again, for words only",
        "comparisons/checks/suite.py::run_check": "a check that crashes must not end the others",
        "comparisons/checks/suite.py::origin": "asks an engine whose check has failed",
        "comparisons/engines/protocol.py::import_library": "imports a binary, which may be broken",
        "comparisons/engines/isolation.py::outcome": FOREIGN,
        "comparisons/engines/isolation.py::answer_next": FOREIGN,
        "comparisons/engines/messages.py::decoded": FOREIGN,
        "comparisons/engines/messages.py::encoded": FOREIGN,
        "comparisons/engines/run.py::call_engine": FOREIGN,
        "comparisons/engines/run.py::traceback_of": FOREIGN,
        "comparisons/checks/kinds/pushed.py::builds": FOREIGN,
        "comparisons/compare/mujoco/probe.py::main": "MuJoCo refuses in several ways",
        "comparisons/inspect/mujoco/model.py::Loaded.compiled": "MuJoCo refuses in several ways",
        "comparisons/inspect/mujoco/model.py::load": "MuJoCo refuses in several ways",
        "comparisons/papers/assess.py::attempt": "runs engines and matplotlib",
    },
    "module_caches": {
        "comparisons/engines/registry.py::_named": "engines that the user named by their class",
    },
    "private_words": {
        "comparisons/inspect/inspection.py::held": DOCUMENT,
        "comparisons/papers/ledger.py::claim": DOCUMENT,
        "comparisons/papers/outcomes.py::claim": DOCUMENT,
        "comparisons/judge/judge.py::judged": DOCUMENT,
    },
    "patched_constants": {
        "tests/comparisons/engines/test_isolation.py::STATM": "stands for other platforms",
        "tests/comparisons/scenes/test_scene_data.py::SCENES": "stands for one more scene",
    },
}
"""Rule -> what breaks it (as ``python -m mbcheck.tests.support.house`` names it) -> why it may."""

PENDING: Mapping[str, int] = {
    "shared_names": 18,
}
"""Rule -> how often it is still broken beside that. Only ever lower these numbers."""
