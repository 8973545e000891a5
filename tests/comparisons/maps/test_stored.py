"""Maps and blocks on disk: what is damaged, exchanged or absurd is never used."""

from __future__ import annotations

import dataclasses
import tracemalloc
from pathlib import Path

import pytest

from mbcheck.comparisons.maps import run, store
from mbcheck.comparisons.maps.request import Axis, Request, resolved
from mbcheck.comparisons.maps.store import Map
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.reports import files
from mbcheck.reference.errors import MbcheckError, UsageError
from mbcheck.tests.support.command import refusal

X, Y = ("force_frequency", 1.0, 10.0, 6), ("force_amplitude", 5.0, 150.0, 6)
FLOQUET = resolved(Request("hula_hoop", "floquet", Axis(*X), Axis(*Y), model="paper", block=9))


@pytest.fixture(scope="module")
def serial() -> Map:
    return run.compute(FLOQUET)


@pytest.mark.parametrize("place", [100, 700, -200, -1])
def test_a_damaged_map_is_refused(serial: Map, tmp_path: Path, place: int) -> None:
    path, data = tmp_path / "map.nc", bytearray(store.to_bytes(serial))
    data[place] ^= 1
    path.write_bytes(data)
    assert "no map of mbcheck, or a broken one" in refusal(f"compare-maps {path} {path}")
    path.write_bytes(store.to_bytes(serial)[:place])
    assert "no map of mbcheck, or a broken one" in refusal(f"compare-maps {path} {path}")


def test_sizes_in_a_map_are_those_of_its_data(serial: Map, tmp_path: Path) -> None:
    x = dataclasses.replace(serial.x, count=10**9)
    settings = {**serial.settings, "x": dataclasses.asdict(x)}
    data = store.to_bytes(dataclasses.replace(serial, settings=settings))
    store.refuse_damage(data)
    with pytest.raises(ValueError, match="another shape"):
        store.from_bytes(data)


def test_a_header_with_absurd_sizes_takes_no_memory(serial: Map) -> None:
    data = store.to_bytes(serial)
    length = serial.x.count.to_bytes(4, "big")
    absurd = data.replace(b"\0\0" + serial.x.name.encode(), b"\0\0" + serial.x.name.encode(), 1)
    absurd = absurd.replace(length, b"\x7f\xff\xff\xff", 1)
    assert absurd != data
    tracemalloc.start()
    with pytest.raises(store.BROKEN):
        store.from_bytes(absurd)
    assert tracemalloc.get_traced_memory()[1] < 100 * len(data)
    tracemalloc.stop()


def test_what_is_unfinished_is_refused_if_it_is_damaged_or_lacks_a_variable(
    serial: Map, tmp_path: Path
) -> None:
    file = tmp_path / "unfinished"
    fewer = {name: serial.variables[name] for name in ("stability", "robust")}
    about = {name: serial.about[name] for name in fewer}
    dataclasses.replace(serial, variables=fewer, about=about).save(file)
    with pytest.raises(UsageError, match=r"another map \(its variables\)"):
        run.compute(FLOQUET, unfinished=file, resume=True)
    file.write_bytes(file.read_bytes()[:-9])
    with pytest.raises(UsageError, match="or a broken one"):
        run.compute(FLOQUET, unfinished=file, resume=True)


def test_a_file_that_is_written_follows_no_link(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    precious = tmp_path / "precious"
    precious.write_text("mine")
    monkeypatch.setattr(files, "token_hex", lambda _: "guessed")
    (tmp_path / ".map.nc.guessed.tmp").symlink_to(precious)
    with pytest.raises(MbcheckError, match="cannot write"):
        files.write_whole(tmp_path / "map.nc", b"new")
    assert precious.read_text() == "mine"


def test_a_paper_takes_no_map_that_is_damaged_or_of_something_else(
    serial: Map, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def stored() -> Map:
        session = Session(engines=(), folder=tmp_path)
        return session.map("hula_hoop", "floquet", X, Y, model="paper", block=9)

    right = store.to_bytes(serial)
    assert store.to_bytes(stored()) == right
    (file,) = tmp_path.iterdir()
    with monkeypatch.context() as patched:
        patched.setattr(run, "evaluate", lambda *_: pytest.fail("computed again"))
        assert store.to_bytes(stored()) == right
    assert not caplog.messages
    other = dataclasses.replace(serial, settings={**serial.settings, "quantity": "other"})
    for wrong in (store.to_bytes(other), right[:-9]):
        file.write_bytes(wrong)
        assert store.to_bytes(stored()) == right
        assert file.read_bytes() == right
    assert len([line for line in caplog.messages if "computed again" in line]) == 2
