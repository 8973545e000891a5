"""The text of an MJCF file: its elements with their lines, its includes, and its waivers."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from ....models.mjcf import address
from ....reference.errors import UsageError
from ...documents.reading import read_bytes
from ...documents.waivers import Waiver

ROOT = "mujoco"
"""Tag of the root element of every MJCF file."""

WAIVER = re.compile(r"allow\s+(\w+)\s*(?:,\s*(.*?))?\s*:(?:\s+(.*))?", re.DOTALL)
"""``allow RULE[, element]: reason``; the colon ends the element where a blank follows it."""

COMMENT = "mbcheck:"
"""Beginning of a comment that addresses this program."""


@dataclass(eq=False)
class Element:
    """An element of the text with its position; ``parent`` is None for the root.

    ``offset`` is the number of bytes before it in its file.
    """

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    parent: Element | None = None
    children: list[Element] = field(default_factory=list)
    offset: int = 0

    @property
    def name(self) -> str | None:
        """Value of the attribute ``name``."""
        return self.attributes.get("name")

    def ancestors(self) -> Iterator[Element]:
        """Yield the ancestors, the nearest first."""
        element = self.parent
        while element is not None:
            yield element
            element = element.parent

    @property
    def address(self) -> str:
        """Name in reports: ``tag:name``, ``tag:name/tag`` or ``tag``."""
        return address([(one.tag, one.name) for one in (self, *self.ancestors())][::-1])

    def within(self, *tags: str) -> bool:
        """Return True if an ancestor has one of these tags."""
        return any(one.tag in tags for one in self.ancestors())

    def walk(self) -> Iterator[Element]:
        """Yield this element and all below it, in the order of the text."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))


Attribute = tuple[Element, str]
"""An attribute of the text: its element and its name."""


@dataclass(frozen=True)
class Source:
    """A main file with what it includes."""

    path: Path
    root: Element
    waivers: tuple[Waiver, ...]
    files: tuple[str, ...]

    def tagged(self, *tags: str) -> list[Element]:
        """Return all elements with one of these tags."""
        return [element for element in self.root.walk() if element.tag in tags]

    def text(self, leave_out: Collection[Attribute] = ()) -> str:
        """Return the model as one text, includes inserted, without some attributes."""
        omitted, made = set(leave_out), dict[Element, ET.Element]()
        for element in self.root.walk():
            attributes = element.attributes.items()
            left = {key: value for key, value in attributes if (element, key) not in omitted}
            made[element] = ET.Element(element.tag, left)
            if element.parent is not None:
                made[element.parent].append(made[element])
        return ET.tostring(made[self.root], encoding="unicode")


class OtherRootError(UsageError):
    """A file is XML, but not MJCF."""


def read(path: Path, instead: bytes | None = None) -> Source:
    """Read a file, or the bytes ``instead`` of its content, and the files that it includes.

    Raises
    ------
    UsageError
        If it cannot be read, or is not MJCF.
    """
    waivers: list[Waiver] = []
    files: list[str] = []
    root = parse(path, path.parent, waivers, files, instead)
    if root.tag != ROOT:
        hint = "; convert URDF to MJCF first" if root.tag == "robot" else ""
        raise OtherRootError(
            f"{path.name} is not MJCF: its root is <{root.tag}>, not <{ROOT}>{hint}"
        )
    return Source(path, root, tuple(waivers), tuple(files))


def parse(
    path: Path, folder: Path, waivers: list[Waiver], files: list[str], instead: bytes | None = None
) -> Element:
    """Return the root of a file; ``waivers`` and ``files`` are added to.

    Raises
    ------
    UsageError
        If it cannot be read, or is no XML.
    """
    name = str(path.relative_to(folder)) if path.is_relative_to(folder) else str(path)
    if name in files:
        raise UsageError(f"{files[0]} includes {name} more than once, which MuJoCo refuses")
    raw = content(path, name) if instead is None else instead
    files.append(name)
    parser = expat.ParserCreate()
    document = Element("", {}, name, 0)
    path_to_here = [document]

    def enter(tag: str, attributes: dict[str, str]) -> None:
        parent = path_to_here[-1]
        above = None if parent is document else parent
        line, offset = parser.CurrentLineNumber, parser.CurrentByteIndex
        element = Element(tag, attributes, name, line, above, offset=offset)
        parent.children.append(element)
        path_to_here.append(element)

    def leave(tag: str) -> None:
        element = path_to_here.pop()
        if tag == "include" and element.parent is not None:
            insert(element, folder, waivers, files)

    def comment(text: str) -> None:
        text, line = text.strip(), parser.CurrentLineNumber
        if text.startswith(COMMENT):
            match = WAIVER.fullmatch(text.removeprefix(COMMENT).strip())
            rule, pattern, reason = match.groups() if match else ("", None, "")
            reason = " ".join((reason or "").split())
            waivers.append(Waiver(rule, pattern, reason, text, name, line))

    parser.StartElementHandler, parser.EndElementHandler = enter, leave
    parser.CommentHandler = comment
    try:
        parser.Parse(raw, True)
    except (expat.ExpatError, ValueError, LookupError) as error:  # or an encoding is not known
        raise UsageError(f"{name} is not XML: {error}") from None
    except RecursionError:
        raise UsageError(f"{name} is included by too many files in turn") from None
    return document.children[0]


def insert(include: Element, folder: Path, waivers: list[Waiver], files: list[str]) -> None:
    """Replace an ``include`` by the elements of the file that it names."""
    parent, name = include.parent, include.attributes.get("file")
    assert parent is not None
    if not name:
        raise UsageError(f"{include.file}, line {include.line}: <include> names no file")
    if not (folder / name).exists():
        where = f"which {include.file}, line {include.line}, includes"
        raise UsageError(f"cannot read {name}, {where}: No such file or directory")
    inner = parse(folder / name, folder, waivers, files)
    parent.children.remove(include)
    for child in inner.children:
        child.parent = parent
        parent.children.append(child)


def content(path: Path, name: str) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    UsageError
        If it cannot be read, or is a compiled model.
    """
    if path.suffix.lower() == ".mjb":
        raise UsageError(
            f"{name} is a compiled model, which has no text to inspect: give the MJCF file "
            "from which it was compiled"
        )
    raw = read_bytes(path, label=name)
    if not raw.strip():
        raise UsageError(f"{name} is empty")
    if b"\0" in raw[:4096] and not raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise UsageError(f"{name} is not XML but a binary file")
    return raw
