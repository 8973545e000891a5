"""What a figure of a paper is here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .session import Session


@dataclass(frozen=True)
class Figure:
    """One figure of a paper, drawn again.

    Attributes
    ----------
    number : int
        As in the paper.
    title : str
        What it shows, in our own words.
    caption : str
        What is drawn and with which choices, where the text leaves them open; how the engines
        compare.
    draw : callable ``(Session) -> matplotlib Figure``
    """

    number: int
    title: str
    caption: str
    draw: Callable[[Session], Any]
