"""Results made by hand, and text that breaks what prints it carelessly."""

from dataclasses import replace
from typing import Any

from mbcheck.comparisons.checks.verdict import Result, Subject, Verdict, result_from
from mbcheck.comparisons.documents.core import hints_of

HOSTILE = "[bold red]\\[/] ]]> <a b='c'> & \x1b[31m\x00\x08\ud800\ufffe\r\n ünïcødé 🦀 | %s {x}"


def result(
    method: str = "RK4",
    verdict: Verdict = "pass",
    *,
    kind: str = "trajectory",
    engine: str = "mujoco",
    quantity: str = "theta",
    error: float | None = 1.23456e-6,
    reason: str = "predicted error 1.5e-06",
    work: dict[str, float] | None = None,
) -> Result:
    """Make a result; one that did not run has no numbers."""
    ran = error is not None and verdict != "skipped"
    scene, case = "hula_hoop", "point_mass_3hz_60n"
    prefix = f"verification/{scene}/{case}/{kind}/{engine}/{method}"
    return Subject(prefix, "verification", engine, scene, case, kind, "tree", method).result(
        quantity,
        verdict,
        reason,
        unit="rad",
        value=error if ran else None,
        reference=0.0 if ran else None,
        error=error if ran else None,
        tolerance=2e-6 if ran else None,
        work={"seconds": 0.5} if work is None else work,
    )


def changed(result: Result, **fields: Any) -> Result:
    """Return a result with other fields of its document."""
    shown = {name: getattr(result, name) for name in hints_of(Result)}
    return replace(result_from(shown | fields), series=result.series)


MIXED = [
    result("RK4"),
    result("Euler", quantity="y"),
    result("Euler", "deviation", error=5e-5, reason="error is 25 x its tolerance"),
    replace(
        result("RK67", "known", engine="exudyn", error=1e-4, reason="error is 50 x its tolerance"),
        known="listed",
    ),
    result("RK44", "skipped", engine="exudyn", reason="no such model"),
    result("RK33", "skipped", engine="exudyn", reason="no such model"),
    result("RK33", "error", engine="exudyn", kind="order", error=None, reason="non_finite: y"),
]
VERSIONS = {"mbcheck": "0.1.0", "mujoco": "4.0.0"}
