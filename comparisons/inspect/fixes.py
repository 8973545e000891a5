"""Edits of a file that leave the compiled model the same to the last bit: `inspect --fix`."""

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
"""Rules whose findings are attributes that may be left out, where that changes no bit."""

START_TAG = re.compile(rb"""<[^\s/>]+(?:\s+[^\s=/>]+\s*=\s*(?:"[^"]*"|'[^']*'))*""")
ATTRIBUTE = re.compile(rb"""\s+([^\s=/>]+)\s*=\s*(?:"[^"]*"|'[^']*')""")


@dataclass(frozen=True)
class NeutralEdit:
    """The text of a file before and after an edit, and what was left out.

    Attributes
    ----------
    file : str
        As it was given.
    before, after : bytes
    attributes : tuple of (Element, str)
    refused : int
        Findings that were left: without these attributes the model is another, if only by a bit, or
        they stand in a file that others may include.
    """

    file: str
    before: bytes
    after: bytes
    attributes: tuple[Attribute, ...]
    refused: int

    @property
    def diff(self) -> str:
        """The edit as a unified diff."""
        old, new = (
            raw.decode("utf-8", "replace").splitlines(keepends=True)
            for raw in (self.before, self.after)
        )
        return "".join(difflib.unified_diff(old, new, self.file, self.file))

    @property
    def summary(self) -> str:
        """What was done, in a sentence."""
        count = len(self.attributes)
        words = f"{self.file}: {plural(count, 'attribute')} without effect"
        proof = ": the compiled model is the same to the last bit" if count else ""
        left = f"; {plural(self.refused, 'finding')} left as it is" if self.refused == 1 else ""
        left = left or (f"; {self.refused} findings left as they are" if self.refused else "")
        return f"{words}{proof}{left}"

    def write(self) -> None:
        """Write the file, if anything changes in it."""
        if self.attributes:
            write_whole(Path(self.file), self.after)


def neutral_edit(asked: InspectRequest) -> NeutralEdit:
    """Return the edit that leaves out all attributes which a file can do without.

    Those that rules of the house find are among them, unless rules are selected. All of them
    together: the file as it is after the edit was compiled, and compared.

    Raises
    ------
    UsageError
        If the file cannot be read again, or does not compile to the same from one text.
    """
    inspection = whole_inspection(replace(asked, modes=False, select=asked.select or FIXED))
    loaded, path = inspection.loaded, Path(inspection.file)
    raw = read_bytes(path, label=inspection.file)
    idle = [one for one in inspection.unwaived if one.rule in FIXED]
    places = {(one.file, one.line, one.element, one.attribute) for one in idle}
    own = loaded.source.files[0]
    candidates = [
        (element, key)
        for element in loaded.source.walk()
        if element.file == own
        for key in element.attributes
        if (own, element.line, element.address, key) in places
    ]
    if candidates and not same(loaded, raw, ()):
        raise UsageError(f"--fix: {inspection.file} does not compile to the same from one text")
    attributes = neutral(loaded, raw, (), candidates)
    after = without(raw, attributes)
    refused = len(idle) - len({(one.line, one.address, key) for one, key in attributes})
    return NeutralEdit(inspection.file, raw, after, tuple(attributes), max(0, refused))


def neutral(
    loaded: Loaded, raw: bytes, taken: Sequence[Attribute], more: Sequence[Attribute]
) -> list[Attribute]:
    """Return attributes, those taken first, that may be left out together; halves on failure."""
    every = [*taken, *more]
    if not more or same(loaded, raw, every):
        return every
    if len(more) == 1:
        return list(taken)
    half = len(more) // 2
    first = neutral(loaded, raw, taken, more[:half])
    return neutral(loaded, raw, first, more[half:])


def same(loaded: Loaded, raw: bytes, attributes: Sequence[Attribute]) -> bool:
    """Return whether a file without some attributes compiles to the same bytes."""
    return loaded.compiles_alike(read(loaded.path, without(raw, attributes)).text())


def without(raw: bytes, attributes: Sequence[Attribute]) -> bytes:
    """Return a file without some attributes; all else stays as it is, blanks and comments too."""
    spans = []
    for element, key in attributes:
        tag = START_TAG.match(raw, element.offset)
        if tag is None or not tag[0].startswith(f"<{element.tag}".encode()):
            raise UsageError(f"--fix: {element.file}, line {element.line} is not plain UTF-8")
        for part in ATTRIBUTE.finditer(raw, element.offset, tag.end()):
            if part[1] == key.encode():
                spans.append(part.span())
    for begin, end in sorted(spans, reverse=True):
        raw = raw[:begin] + raw[end:]
    return raw
