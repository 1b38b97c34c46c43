"""Interactive pages in headless Chromium: seconds to the first picture and to the first frame of the view, and sizes.

Without a graphics processor, so that all is drawn by software (SwiftShader), in a window of 1400 x 1000 pixels. The
first load is that of a browser that has just been started. Seconds of the clock are on a machine that may do other
work; processor seconds are of the browser's processes.
"""

from __future__ import annotations

__all__ = ["run"]

import os
import shutil
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import lbskel
from benchmarks.harness import markdown_table, save_json, save_markdown
from lbskel.shapes import make

SIZES = (25_000, 173_000)  # vertices of the dinosaur: 50,000 and 346,000 faces
LOADS = 6  # of each page, the first of which starts the graphics process
FLAGS = """--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run
--disable-background-networking --disable-component-update --disable-sync --window-size=1400,1000"""
MARKS = {"picture": "first picture", "library": "plotly read", "decoded": "data decoded", "drawn": "first frame"}
PATIENCE = 300  # seconds after which a page that is not ready never will be


def run(quick: bool, results: Path) -> None:
    """Write pages, open them, and write page.json and page.md."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for n_vertices in (2_000,) if quick else SIZES:
            path = Path(name) / f"{n_vertices}.html"
            mesh = make("dinosaur", n_vertices=n_vertices).mesh
            lbskel.view(mesh, path)
            profile = Path(name) / f"profile-{n_vertices}"
            with _browser(profile) as browser:
                loads = [_load(browser, path, profile) for _ in range(2 if quick else LOADS)]
            size = {"faces": len(mesh.faces), "megabytes": path.stat().st_size / 1e6}
            rows.append({**size, "load": "first", **loads[0]})
            later = {key: statistics.median(load[key] for load in loads[1:]) for key in loads[0]}
            rows.append({**size, "load": "median of the others", **later})
    save_json(results / "page.json", {"loads": rows}, packages=("plotly",))
    text = "\nSeconds of the clock after the page is opened, and of the processor in all processes of the browser.\n"
    save_markdown(results / "page.md", "Interactive pages", {"Loads": markdown_table(rows) + text})


@contextmanager
def _browser(profile: Path) -> Iterator[Any]:
    """Start Chromium."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for flag in [*FLAGS.split(), f"--user-data-dir={profile}"]:
        options.add_argument(flag)
    service = webdriver.ChromeService(shutil.which("chromedriver"), log_output=os.devnull)
    driver = webdriver.Chrome(options=options, service=service)
    try:
        yield driver
    finally:
        driver.quit()


def _load(browser: Any, path: Path, profile: Path) -> dict[str, float]:
    """Open a page, and return the seconds at its marks and those of the processor."""
    browser.get("about:blank")
    before = _processor_seconds(profile)
    browser.get(path.as_uri())
    end = time.monotonic() + PATIENCE
    while not browser.execute_script("return document.body.dataset.ready"):
        if time.monotonic() > end:
            raise RuntimeError(f"{path} is not ready after {PATIENCE} s: {browser.get_log('browser')}")
        time.sleep(0.05)
    spent = _processor_seconds(profile) - before
    marks = dict(
        browser.execute_script("return performance.getEntriesByType('mark').map((each) => [each.name, each.startTime])")
    )
    return {**{text: marks[name] / 1000 for name, text in MARKS.items()}, "processor seconds": spent}


def _processor_seconds(profile: Path) -> float:
    """Sum over the processes that have the profile in their command."""
    ticks = 0
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            if str(profile) in (entry / "cmdline").read_text():
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
                ticks += int(fields[11]) + int(fields[12])
        except OSError:  # it has ended
            continue
    return ticks / os.sysconf("SC_CLK_TCK")
