"""The tool that mutates lines: each mutant differs in one thing, and is found again by its seed."""

from __future__ import annotations

import ast

from mbcheck.tests.support.mutate.mutants import mutants

SOURCE = '''
"""Text with 1 < 2."""

def area(a: float, b: int = 3) -> float:
    """Return 2."""
    if not a <= 0 and b != 1:
        raise ValueError(f"{a + b}")
    return min(a * b, -a[0], z(strict=True))

def name(a: str) -> str:
    return a
'''

CHANGES = {
    "3 -> 4", "a <= 0 -> a < 0", "a <= 0 -> a >= 0", "b != 1 -> b == 1", "0 -> 1", "1 -> 2",
    "not a <= 0 -> a <= 0", "not a <= 0 and b != 1 -> not a <= 0 or b != 1", "a * b -> a / b",
    "-a[0] -> a[0]", "min -> max",
    "return min(a * b, -a[0], z(strict=True)) -> return -min(a * b, -a[0], z(strict=True))",
}  # fmt: skip


def test_every_change_is_drawn_in_the_end_and_no_other() -> None:
    drawn = [one for seed in range(100) for one in mutants(SOURCE, 9, seed)]
    assert {one.what for one in drawn} == CHANGES
    assert {one.line for one in drawn} == {4, 6, 8}
    right = ast.unparse(ast.parse(SOURCE))
    for one in drawn:
        compile(one.source, "mutant", "exec")
        assert one.source != right


def test_a_seed_and_a_count_give_the_same_mutants_again() -> None:
    assert mutants(SOURCE, 2, 5) == mutants(SOURCE, 2, 5)
    assert len(mutants(SOURCE, 2, 5)) == 2
    assert len({one.source for seed in range(9) for one in mutants(SOURCE, 1, seed)}) > 3
