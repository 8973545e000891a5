"""Edits of a file that leave the compiled model unchanged to the last bit: `inspect --fix`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ...reference.errors import UsageError
from ..documents.reading import read_bytes
from ..reports.files import write_whole
from ..reports.words import plural
from .inspection import whole_inspection
from .mujoco.model import Loaded
from .mujoco.source import Attribute, read
from .request import InspectRequest

FIXED = ("repeated_default", "unused_option", "unused_setting")
"""Rules whose findings are attributes that may be redundant."""

START_TAG = re.compile(rb"""<[^\s/>]+(?:\s+[^\s=/>]+\s*=\s*(?:"[^"]*"|'[^']*'))*""")
ATTRIBUTE = re.compile(rb"""\s+([^\s=/>]+)\s*=\s*(?:"[^"]*"|'[^']*')""")


@dataclass(frozen=True)
class NeutralEdit:
    """Text of a file before and after an edit, and the attributes that were removed.

    Attributes
    ----------
    file : str
        The file, as it was given.
    before, after : bytes
    attributes : tuple of (Element, str)
    refused : int
        Findings that remain: without these attributes the model changes, if only by a bit, or they
        are in a file that other models may include.
    """

    file: str
    before: bytes
    after: bytes
    attributes: tuple[Attribute, ...]
    refused: int

    @property
    def diff(self) -> str:
        """Unified diff of the edit."""
        old, new = (
            raw.decode("utf-8", "replace").splitlines(keepends=True)
            for raw in (self.before, self.after)
        )
        return "".join(difflib.unified_diff(old, new, self.file, self.file))

    @property
    def summary(self) -> str:
        """Sentence about the edit."""
        count = len(self.attributes)
        words = f"{self.file}: {plural(count, 'attribute')} without effect"
        proof = ": the compiled model is the same to the last bit" if count else ""
        left = f"; {plural(self.refused, 'finding')} left unchanged" if self.refused else ""
        return f"{words}{proof}{left}"

    def write(self) -> None:
        """Write the file, if it changes."""
        if self.attributes:
            write_whole(Path(self.file), self.after)


def neutral_edit(request: InspectRequest) -> NeutralEdit:
    """Return the edit that removes all redundant attributes of a file.

    Findings of rules of the house are included, unless rules are selected. The edited file was
    compiled, and the model compared.

    Raises
    ------
    UsageError
        If the file cannot be read again, or does not compile to the same from one text.
    """
    inspection = whole_inspection(replace(request, modes=False, select=request.select or FIXED))
    loaded, path = inspection.loaded, Path(inspection.file)
    raw = read_bytes(path, label=inspection.file)
    idle = [one for one in inspection.unwaived if one.rule in FIXED]
    places = {(one.file, one.line, one.element, one.attribute) for one in idle}
    own = loaded.source.files[0]
    candidates = [
        (element, key)
        for element in loaded.source.root.walk()
        if element.file == own
        for key in element.attributes
        if (own, element.line, element.address, key) in places
    ]
    if candidates and not same(loaded, raw, ()):
        raise UsageError(f"--fix: {inspection.file} does not compile to the same from one text")
    attributes = neutral(loaded, raw, (), candidates)
    refused = len(idle) - len({(one.line, one.address, key) for one, key in attributes})
    return NeutralEdit(
        inspection.file, raw, without(raw, attributes), tuple(attributes), max(0, refused)
    )


def neutral(
    loaded: Loaded, raw: bytes, taken: Sequence[Attribute], more: Sequence[Attribute]
) -> list[Attribute]:
    """Return attributes that may be left out together, by bisection; ``taken`` comes first."""
    every = [*taken, *more]
    if not more or same(loaded, raw, every):
        return every
    if len(more) == 1:
        return list(taken)
    half = len(more) // 2
    first = neutral(loaded, raw, taken, more[:half])
    return neutral(loaded, raw, first, more[half:])


def same(loaded: Loaded, raw: bytes, attributes: Sequence[Attribute]) -> bool:
    """Return True if a file without some attributes compiles to the same bytes."""
    return loaded.compiles_alike(read(loaded.path, without(raw, attributes)).text())


def without(raw: bytes, attributes: Sequence[Attribute]) -> bytes:
    """Return a file without some attributes; blanks and comments are kept."""
    spans = []
    for element, key in attributes:
        tag = START_TAG.match(raw, element.offset)
        if tag is None or not tag[0].startswith(f"<{element.tag}".encode()):
            raise UsageError(
                f"--fix: {element.file}, line {element.line} is not plain UTF-8: convert the file"
            )
        for part in ATTRIBUTE.finditer(raw, element.offset, tag.end()):
            if part[1] == key.encode():
                spans.append(part.span())
    for begin, end in sorted(spans, reverse=True):
        raw = raw[:begin] + raw[end:]
    return raw
