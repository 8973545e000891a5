"""The reference with something undone: a stand-in for engines that leave out a theory's terms."""

from __future__ import annotations

from ....reference.scene import Case
from ..equations import ModelEquations
from ..registry import REFERENCE, get_engine
from .catalogue import Wrapped


class Undeclared(Wrapped):
    """The reference, whose simplified theories pass for exact."""

    def __init__(self) -> None:
        super().__init__(get_engine(REFERENCE))

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Declare none."""
        return None
