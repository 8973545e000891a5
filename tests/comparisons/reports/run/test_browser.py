"""What a browser makes of the page of a run."""

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest

from mbcheck.tests.support.pages import text_of

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next(filter(None, map(shutil.which, NAMES)), None)
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--allow-file-access-from-files",
)

PROBE = """<!DOCTYPE html><meta charset="utf-8"><title>probe</title>
<iframe id="f" src="index.html" style="border:0;width:{width}px;height:800px"></iframe>
<pre id="out"></pre>
<script>
const frame = document.getElementById("f");
frame.onload = () => {{
  const page = frame.contentDocument, view = frame.contentWindow, found = {{}};
  found.width = page.documentElement.scrollWidth;
  found.wide = [...page.querySelectorAll(".wide")].filter(e => e.scrollWidth > e.clientWidth + 1)
    .every(e => view.getComputedStyle(e).overflowX === "auto");
  found.images = [...page.images].map(i => i.complete && i.naturalWidth > 0);
  found.links = [...page.querySelectorAll("a")].map(a => {{
    for (const d of page.querySelectorAll("details")) d.open = false;
    a.click();
    const target = page.getElementById(a.hash.slice(1));
    return target !== null && target.getClientRects().length > 0;
  }});
  found.requests = view.performance.getEntriesByType("resource").map(e => e.name)
    .filter(name => !name.startsWith("data:"));
  document.getElementById("out").textContent = JSON.stringify(found);
}};
</script>
"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Lend a function that runs the browser in a folder that holds the page."""
    if BROWSER is None:
        pytest.skip(f"there is no browser: none of {', '.join(NAMES)}")
    folder = tmp_path_factory.mktemp("browser")
    (folder / "index.html").write_text(text_of(), encoding="utf-8")

    def run(*arguments: str, name: str = "index.html") -> str:
        profile = folder / "profile"
        profile.mkdir(exist_ok=True)
        place = f"{(folder / name).as_uri()}"
        done = subprocess.run(
            [BROWSER, *QUIET, f"--user-data-dir={profile}", *arguments, place],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        )
        return done.stdout

    yield run, folder
    shutil.rmtree(folder / "profile", ignore_errors=True)


@pytest.mark.parametrize("width", [390, pytest.param(1280, marks=pytest.mark.slow)])
def test_in_a_browser(browser: Any, width: int) -> None:
    run, folder = browser
    (folder / "probe.html").write_text(PROBE.format(width=width), encoding="utf-8")
    dumped = run("--virtual-time-budget=10000", "--dump-dom", name="probe.html")
    told = re.search(r'<pre id="out">(.+?)</pre>', dumped)
    assert told, dumped[-2000:]
    found = json.loads(told[1])
    assert found["width"] <= width
    assert found["wide"]
    assert found["images"]
    assert all(found["images"])
    assert found["links"]
    assert all(found["links"]), "a link must open what it leads to"
    assert found["requests"] == []


@pytest.mark.slow
def test_it_is_drawn_and_printed(browser: Any) -> None:
    from PIL import Image

    run, folder = browser
    run("--window-size=1280,1600", f"--screenshot={folder / 'page.png'}")
    with Image.open(folder / "page.png") as image:
        assert image.size == (1280, 1600)
        assert len(image.convert("RGB").getcolors(1 << 20) or []) > 50
    run("--no-pdf-header-footer", f"--print-to-pdf={folder / 'page.pdf'}")
    assert (folder / "page.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.slow
def test_the_probe_sees_a_page_that_is_too_wide(browser: Any) -> None:
    run, folder = browser
    whole = (folder / "index.html").read_text(encoding="utf-8")
    try:
        broken = whole.replace("overflow-x: auto", "overflow-x: visible").replace(
            'id="verdicts"', 'id="elsewhere"'
        )
        (folder / "index.html").write_text(broken, encoding="utf-8")
        (folder / "probe.html").write_text(PROBE.format(width=390), encoding="utf-8")
        dumped = run("--virtual-time-budget=10000", "--dump-dom", name="probe.html")
    finally:
        (folder / "index.html").write_text(whole, encoding="utf-8")
    found = json.loads(re.search(r'<pre id="out">(.+?)</pre>', dumped)[1])  # type: ignore[index]
    assert found["width"] > 390
    assert not all(found["links"])
