"""Count the package's statements, and list what breaks the rules of the house."""

import ast
import sys
from pathlib import Path

from mbcheck.tests.support.house.allowed import ALLOWED, PENDING
from mbcheck.tests.support.house.module import is_shipped, modules
from mbcheck.tests.support.house.rules import RULES

house = modules(Path.cwd())
shipped = [node for module in house if is_shipped(module) for node in module.nodes]
print(f"{sum(isinstance(node, ast.stmt) for node in shipped)} statements in the package")
for rule in sys.argv[1:] or RULES:
    left = set(RULES[rule](house)) - set(ALLOWED.get(rule, ()))
    print(f"{rule}: {len(left)}, pending {PENDING.get(rule, 0)}", *sorted(left), sep="\n    ")
