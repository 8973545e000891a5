"""Maps on disk.

The file is NetCDF (classic, 64-bit offsets) with the CF conventions' attributes: labelled
arrays with units that xarray, MATLAB, Octave, R, ncdump and Panoply open. SciPy writes it, so
that it needs no further dependency; it holds no date and no duration, so that equal maps are
equal files.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from ...reference import get_scene
from ...reference.errors import UsageError
from ...reference.scene import Array
from ..documents.reading import read_bytes
from ..reports.files import write_whole
from ..scenes.quantity import NO_VALUE, Variable
from .request import Axis, axis_names

COMPUTED = Variable("1", "1 where computed, 0 where taken from the nearest computed point")

BLANK = b"0" * 64
"""Placeholder of the digest while that of all bytes of a map is computed."""

DIGEST = re.compile(rb"digest\0\0\0\0\0\x02\0\0\0\x40([0-9a-f]{64})")
"""The attribute with the digest, as NetCDF writes it."""

BROKEN = (
    AssertionError, AttributeError, EOFError, IndexError, KeyError, MemoryError, OverflowError,
    RecursionError, TypeError, ValueError, struct.error,
)  # fmt: skip
"""Exceptions that SciPy raises for a file of another format."""


def sha256(*parts: bytes) -> str:
    """Return the digest of bytes."""
    return hashlib.sha256(b"".join(parts)).hexdigest()


@dataclass(frozen=True)
class Map:
    """A map as it was computed, or read from its file.

    Attributes
    ----------
    x, y : Axis
    variables : mapping of str to array (n_y, n_x)
        Classes are int8, with -1 for no value.
    about : mapping of str to Variable
        Unit, meaning and classes of each.
    computed : bool array (n_y, n_x)
        Where a point was computed, and not filled in from its nearest neighbour.
    settings : mapping
        What `Request` holds, and the versions of what it was computed with.
    problems : tuple of (x, y, reason)
        Where the engine failed, and how.
    """

    x: Axis
    y: Axis
    variables: Mapping[str, Array]
    about: Mapping[str, Variable]
    computed: Any
    settings: Mapping[str, Any]
    problems: tuple[tuple[float, float, str], ...] = ()

    @property
    def main_variable(self) -> str:
        """Return the name of the variable for pictures and comparisons."""
        return next(iter(self.about))

    @property
    def robust(self) -> Any:
        """Return where the class survives a perturbation (n_y, n_x); everywhere if unknown."""
        rated = self.variables.get("robust")
        return np.ones(self.computed.shape, bool) if rated is None else rated == 1

    def save(self, path: str | Path) -> None:
        """Write the NetCDF file of the map.

        Raises
        ------
        MbcheckError
            If it cannot be written.
        """
        write_whole(Path(path), to_bytes(self))

    def shares(self, name: str | None = None) -> dict[str, float]:
        """Return the share of computed points of each class of a variable."""
        name = name or self.main_variable
        values = self.variables[name][self.computed]
        return {
            label: float(np.mean(values == i)) for i, label in enumerate(self.about[name].classes)
        }


def units(scene: str, name: str) -> str:
    """Return the unit of what stands on an axis."""
    special = axis_names(scene)
    if name in special:
        return special[name].unit
    return get_scene(scene).parameters.unit_of(name)


# The file


def to_bytes(result: Map) -> bytes:
    """Return a map as the bytes of a NetCDF file."""
    text = io.BytesIO()
    scene = result.settings["scene"]
    with netcdf_file(text, "w", version=2) as file:
        file.Conventions = "CF-1.11"
        file.title = f"{scene}: {result.settings['quantity']} by {result.settings['engine']}"
        file.source = "mbcheck"
        file.settings = json.dumps(result.settings, sort_keys=True)
        file.problems = json.dumps(result.problems)
        file.digest = BLANK.decode()
        for axis in (result.y, result.x):
            file.createDimension(axis.name, axis.count)
            variable = file.createVariable(axis.name, "f8", (axis.name,))
            variable[:] = axis.values
            variable.units = units(scene, axis.name)
        shape = (result.y.name, result.x.name)
        everything = {**result.variables, "computed": result.computed.astype(np.int8)}
        for name, values in everything.items():
            about = result.about.get(name, COMPUTED)
            kind = "i1" if values.dtype == np.int8 else "f8"
            variable = file.createVariable(name, kind, shape)
            variable[:] = values
            variable.units = about.unit
            variable.long_name = about.meaning
            if about.classes:
                variable.flag_values = np.arange(NO_VALUE, len(about.classes), dtype=np.int8)
                variable.flag_meanings = " ".join(("no_value", *about.classes))
        file.flush()
        data = text.getvalue()
    place = slice(*DIGEST.search(data).span(1))  # type: ignore[union-attr]
    return data[: place.start] + sha256(data).encode() + data[place.stop :]


def read(path: str | Path) -> Map:
    """Read a map from its file.

    Raises
    ------
    UsageError
        If there is no such file, or it is none of a map.
    """
    data = read_bytes(path)
    try:
        refuse_damage(data)
        return from_bytes(data)
    except BROKEN:
        raise UsageError(f"{str(path)!r} is no map of mbcheck, or a broken one") from None


def refuse_damage(data: bytes) -> None:
    """Refuse the bytes of a file that are not those that were written.

    Raises
    ------
    ValueError
    """
    match = DIGEST.search(data)
    if match is None:
        raise ValueError("no digest")
    place = slice(*match.span(1))
    if sha256(data[: place.start], BLANK, data[place.stop :]) != match[1].decode():
        raise ValueError("another digest")


def from_bytes(data: bytes) -> Map:
    """Return the map in the bytes of a NetCDF file, beyond which no size in it can lead.

    Raises
    ------
    ValueError
        If it is none; or any other error of what reads it.
    """
    with netcdf_file(io.BytesIO(data), mmap=False) as file:
        settings = json.loads(file.settings)
        x, y = (Axis(**settings[name]) for name in ("x", "y"))
        variables, about = {}, {}
        for name, item in file.variables.items():
            if name in (x.name, y.name):
                continue
            if item.shape != (y.count, x.count):
                raise ValueError("another shape")
            values = np.array(item[:])
            variables[name] = values.astype(values.dtype.newbyteorder("="))
            classes = tuple(getattr(item, "flag_meanings", b"").decode().split())[1:]
            about[name] = Variable(item.units.decode(), item.long_name.decode(), classes)
        about.pop("computed")
        computed = variables.pop("computed") == 1
        problems = tuple((a, b, words) for a, b, words in json.loads(file.problems))
    return Map(x, y, variables, about, computed, settings, problems)
