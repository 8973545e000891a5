"""The text of an MJCF file: its elements with their lines, its includes, and its waivers."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from xml.parsers import expat

from ...models.mjcf import address
from ...reference.errors import UsageError

LARGEST = 256 * 2**20
"""Bytes of a file that is read; no model is written in more."""

WAIVER = re.compile(r"allow\s+(\w+)\s*(?:,\s*(.*?))?\s*:(?:\s+(.*))?", re.DOTALL)
"""``allow RULE[, element]: reason``; the colon ends the element where a blank follows it."""

COMMENT = "mbcheck:"
"""How a comment begins that is meant for this program."""


@dataclass(eq=False)
class Element:
    """One element of the text, where it stands; ``parent`` is None of the root."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    parent: Element | None = None
    children: list[Element] = field(default_factory=list)

    @property
    def name(self) -> str | None:
        """Its attribute of this name."""
        return self.attributes.get("name")

    @property
    def above(self) -> list[Element]:
        """Its ancestors, the root first."""
        found: list[Element] = []
        at = self.parent
        while at is not None:
            found.append(at)
            at = at.parent
        return found[::-1]

    @property
    def address(self) -> str:
        """How it is named in reports: ``tag:name``, ``tag:name/tag`` or ``tag``."""
        return address([(one.tag, one.name) for one in (*self.above, self)])

    def within(self, tag: str) -> bool:
        """Return whether an ancestor has a tag."""
        return any(one.tag == tag for one in self.above)

    def walk(self) -> Iterator[Element]:
        """Yield itself and all below it, in the order of the text."""
        waiting = [self]
        while waiting:
            at = waiting.pop()
            yield at
            waiting.extend(reversed(at.children))


@dataclass(eq=False)
class Waiver:
    """A comment that allows a finding, or that tries to.

    Attributes
    ----------
    rule : str
        Empty if the comment is no waiver that can be read.
    pattern : str or None
        Which element it is for; ``*`` and ``?`` are wildcards. None for all.
    reason : str
    text, file, line
        The comment as it stands.
    """

    rule: str
    pattern: str | None
    reason: str
    text: str
    file: str
    line: int

    def covers(self, rule: str, element: str) -> bool:
        """Return whether it allows a finding of a rule on an element ``tag:name``."""
        if rule != self.rule or not self.reason:
            return False
        if self.pattern is None:
            return True
        bare = element.partition("/")[0].partition(":")[2] or element
        return any(fnmatchcase(word, self.pattern) for word in (element, bare))


@dataclass(frozen=True)
class Source:
    """A main file with what it includes."""

    path: Path
    root: Element
    waivers: tuple[Waiver, ...]
    files: tuple[str, ...]

    def walk(self) -> Iterator[Element]:
        """Yield all elements, in the order of the text."""
        return self.root.walk()

    def tagged(self, *tags: str) -> list[Element]:
        """Return all elements with one of these tags."""
        return [element for element in self.walk() if element.tag in tags]

    def text(self, leave_out: Iterable[tuple[Element, str]] = ()) -> str:
        """Return the model as one text, includes inserted, without some attributes."""
        top, made = self.tree
        taken = [(made[element].attrib, name) for element, name in leave_out]
        kept = [(attributes, name, attributes.pop(name)) for attributes, name in taken]
        try:
            return ET.tostring(top, encoding="unicode")
        finally:
            for attributes, name, value in kept:
                attributes[name] = value

    @cached_property
    def tree(self) -> tuple[ET.Element, dict[Element, ET.Element]]:
        """The same as a tree that can be written, and each element's place in it."""
        made: dict[Element, ET.Element] = {}
        for element in self.walk():
            made[element] = ET.Element(element.tag, dict(element.attributes))
            if element.parent is not None:
                made[element.parent].append(made[element])
        return made[self.root], made


def read(path: Path) -> Source:
    """Read a file and all that it includes.

    Raises
    ------
    UsageError
        If it cannot be read, or is not MJCF.
    """
    waivers: list[Waiver] = []
    files: list[str] = []
    root = parse(path, path.parent, waivers, files)
    if root.tag != "mujoco":
        hint = "; URDF is to be converted first" if root.tag == "robot" else ""
        raise UsageError(f"{path.name} is not MJCF: its root is <{root.tag}>, not <mujoco>{hint}")
    return Source(path, root, tuple(waivers), tuple(files))


def parse(path: Path, folder: Path, waivers: list[Waiver], files: list[str]) -> Element:
    """Return the root of a file; ``waivers`` and ``files`` are added to.

    Raises
    ------
    UsageError
        If it cannot be read, or is no XML.
    """
    shown = str(path.relative_to(folder)) if path.is_relative_to(folder) else str(path)
    if shown in files:
        raise UsageError(f"{files[0]} includes {shown} more than once, which MuJoCo refuses")
    raw = content(path, shown)
    files.append(shown)
    parser = expat.ParserCreate()
    top: list[Element] = []
    open_: list[Element] = []

    def enter(tag: str, attributes: dict[str, str]) -> None:
        parent = open_[-1] if open_ else None
        made = Element(tag, attributes, shown, parser.CurrentLineNumber, parent)
        (parent.children if parent else top).append(made)
        open_.append(made)

    def leave(tag: str) -> None:
        done = open_.pop()
        if tag == "include" and done.parent is not None:
            insert(done, folder, waivers, files)

    def comment(text: str) -> None:
        if text.strip().startswith(COMMENT):
            waivers.append(waiver(text.strip(), shown, parser.CurrentLineNumber))

    parser.StartElementHandler = enter
    parser.EndElementHandler = leave
    parser.CommentHandler = comment
    try:
        parser.Parse(raw, True)
    except expat.ExpatError as error:
        raise UsageError(f"{shown} is not XML: {error}") from None
    return top[0]


def insert(include: Element, folder: Path, waivers: list[Waiver], files: list[str]) -> None:
    """Put what a file holds in the place of the element that includes it."""
    parent, name = include.parent, include.attributes.get("file")
    assert parent is not None
    if not name:
        raise UsageError(f"{include.file}, line {include.line}: <include> names no file")
    inner = parse(folder / name, folder, waivers, files)
    parent.children.remove(include)
    for child in inner.children:
        child.parent = parent
        parent.children.append(child)


def content(path: Path, shown: str) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    UsageError
        If it cannot be read, or is a compiled model.
    """
    if path.suffix.lower() == ".mjb":
        raise UsageError(
            f"{shown} is a compiled model, which has no text to inspect: give the MJCF that it "
            "was compiled from"
        )
    try:
        if path.is_dir():
            raise UsageError(f"{shown} is a folder: give one of its files")
        if path.exists() and not path.is_file():
            raise UsageError(f"{shown} is no file")
        if path.stat().st_size > LARGEST:
            raise UsageError(f"{shown} has more than {LARGEST // 2**20} MiB: that is no MJCF")
        raw = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UsageError(f"cannot read {shown}: {reason}") from None
    if not raw.strip():
        raise UsageError(f"{shown} is empty")
    if b"\0" in raw[:4096] and not raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise UsageError(f"{shown} is not XML but a binary file")
    return raw


def waiver(text: str, file: str, line: int) -> Waiver:
    """Return what a comment for this program says."""
    match = WAIVER.fullmatch(text.removeprefix(COMMENT).strip())
    if match is None:
        return Waiver("", None, "", text, file, line)
    rule, pattern, reason = match.groups()
    return Waiver(rule, pattern, " ".join((reason or "").split()), text, file, line)
