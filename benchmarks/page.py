"""Interactive pages in headless Chromium: seconds to the first picture and to the first frame of the view, and sizes.

There is no graphics processor, so all is drawn by software, in a window of 1400 x 1000 pixels: the view by SwiftShader,
and the page around it by Chromium's own rasterizer, its default there, or by SwiftShader too. Each browser has just
been started with a new profile when it loads the page (cold), and then loads it again (warm). Wall-clock seconds are
measured on a machine that may do other work; processor seconds are those of the browser's processes.
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
BROWSERS = 7  # that are started for each row
FLAGS = """--headless=new --no-sandbox --enable-unsafe-swiftshader --disable-quic --no-first-run
--disable-background-networking --disable-component-update --disable-sync --window-size=1400,1000"""
DRAWN_BY = {"Chromium": "", "SwiftShader": "--use-angle=swiftshader"}  # what draws the page around the view
MARKS = {"picture": "first picture", "library": "plotly read", "decoded": "data decoded", "drawn": "first frame drawn"}
# tells when the first frame is on the screen: with it comes a dot, whose time the browser reports (Element Timing)
OBSERVER = """
new PerformanceObserver((list) => list.getEntriesByName("drawn").forEach(() => {
  const dot = document.createElement("span");
  dot.setAttribute("elementtiming", "dot");
  dot.style.position = "fixed";
  dot.style.top = 0;
  dot.textContent = ".";
  document.body.append(dot);
})).observe({ type: "mark", buffered: true });
new PerformanceObserver((list) => { window.shownAt = list.getEntries()[0].renderTime; })
  .observe({ type: "element", buffered: true });
"""
PATIENCE = 300  # seconds after which a page that is not ready never will be


def run(quick: bool, results: Path) -> None:
    """Write pages, open them, and write page.json and page.md."""
    rows = []
    n = 1 if quick else BROWSERS
    with tempfile.TemporaryDirectory() as name:
        for n_vertices in (2_000,) if quick else SIZES:
            path = Path(name) / f"{n_vertices}.html"
            mesh = make("dinosaur", n_vertices=n_vertices).mesh
            lbskel.view(mesh, path)
            size = {"faces": len(mesh.faces), "megabytes": path.stat().st_size / 1e6}
            for drawn_by in DRAWN_BY:
                loads = [_cold_and_warm(path, drawn_by) for _ in range(n)]
                for number, kind in enumerate(("cold", "warm")):
                    rows.append(
                        {**size, "page drawn by": drawn_by, "load": kind, **_summary([x[number] for x in loads])}
                    )
    save_json(results / "page.json", {"loads": rows}, packages=("plotly",))
    text = (
        f"\nMedians of {n} browsers: seconds of the clock after the page is opened, and of the processor in all "
        "processes of the browser. Markers and curves, which come after the first frame, count for the processor.\n"
    )
    save_markdown(results / "page.md", "Interactive pages", {"Loads": markdown_table(rows) + text})


def _cold_and_warm(path: Path, drawn_by: str) -> list[dict[str, float]]:
    """Open a page twice in a browser that has just been started."""
    with tempfile.TemporaryDirectory() as name:
        profile = Path(name) / "profile"
        with _browser(profile, DRAWN_BY[drawn_by]) as browser:
            return [_load(browser, path, profile) for _ in range(2)]


def _summary(loads: list[dict[str, float]]) -> dict[str, float]:
    """Medians of all, and the longest of the time that counts."""
    medians = {key: statistics.median(load[key] for load in loads) for key in loads[0]}
    return {**medians, "longest on the screen": max(load["on the screen"] for load in loads)}


@contextmanager
def _browser(profile: Path, flag: str) -> Iterator[Any]:
    """Start Chromium."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for each in [*FLAGS.split(), *flag.split(), f"--user-data-dir={profile}"]:
        options.add_argument(each)
    service = webdriver.ChromeService(shutil.which("chromedriver"), log_output=os.devnull)
    driver = webdriver.Chrome(options=options, service=service)
    try:
        driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": OBSERVER})
        yield driver
    finally:
        driver.quit()


def _load(browser: Any, path: Path, profile: Path) -> dict[str, float]:
    """Open a page, and return the seconds at its marks and those of the processor."""
    browser.get("about:blank")
    before = _processor_seconds(profile)
    browser.get(path.as_uri())
    end = time.monotonic() + PATIENCE
    while not browser.execute_script("return document.body.dataset.ready && window.shownAt"):
        if time.monotonic() > end:
            raise RuntimeError(f"{path} is not ready after {PATIENCE} s: {browser.get_log('browser')}")
        time.sleep(0.05)
    spent = _processor_seconds(profile) - before
    marks = dict(
        browser.execute_script("return performance.getEntriesByType('mark').map((each) => [each.name, each.startTime])")
    )
    shown = browser.execute_script("return window.shownAt")
    seconds = {text: marks[name] / 1000 for name, text in MARKS.items()}
    return {**seconds, "on the screen": shown / 1000, "processor seconds": spent}


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
