"""Measure what opening a cell and a flight of a report costs in the browser: processor time of the page's main thread.

    python benchmarks/page.py [REPORT.html]... [--rounds N]

Without a REPORT it writes that of the published campaign, 13,821 flights.  `store.py --campaign DIR` keeps a campaign
of 250,000.
Bars: a cell of the HAZOP matrix opens within 200 ms, a flight of the kill matrix within 500 ms.
"""

from __future__ import annotations

import checkout  # first: it sets the path and the threads

# isort: split
import shutil
import tempfile
from pathlib import Path
from statistics import median
from typing import Any

from playwright.sync_api import sync_playwright

import scaloft_fi

PARTS = {"cell": '#hazop [role="gridcell"]:not([aria-disabled])', "flight": "#kills td.state"}
"""What is clicked: places spread over all there are."""
SHOWN = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
OPENED = f"""async () => {{
  while (!document.querySelector("#sheet[open] .sheet-body")) await new Promise(requestAnimationFrame);
  await ({SHOWN})();
}}"""


def main() -> None:
    """Print a line for each report and part."""
    options = checkout.parser(__doc__)
    options.add_argument("reports", nargs="*", type=Path)
    options.add_argument("--rounds", type=int, default=20, help="clicks of each part")
    asked = options.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        reports = asked.reports or [_published(Path(folder))]
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        for report in reports:
            for part, where in PARTS.items():
                times_ms = _opened_ms(chromium, report, where, asked.rounds)
                print(f"{report.name}: a {part} opens in {median(times_ms):.0f} ms, at most {max(times_ms):.0f}")


def _published(folder: Path) -> Path:
    file = folder / "published.html"
    study = scaloft_fi.open(checkout.ROOT)
    study.campaign(str(checkout.ROOT / "results/published/reference")).report(file)
    return file


def _opened_ms(chromium: Any, report: Path, where: str, rounds: int) -> list[float]:
    """Processor time from a press until the second frame of what it opens [ms], for presses spread over the places.

    The mouse is there before, so that no time of the driver, which seeks and checks a place, is counted.
    """
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    page.goto(report.absolute().as_uri())
    page.get_by_role("link", name="Kill matrix").click()
    watch = page.context.new_cdp_session(page)
    watch.send("Performance.enable", {"timeDomain": "threadTicks"})
    page.wait_for_selector(where, state="attached")
    place = (
        "([where, at]) => { const all = document.querySelectorAll(where); return all[Math.floor(at * all.length)]; }"
    )
    times = []
    for at in range(rounds):
        page.evaluate_handle(place, [where, at / rounds]).as_element().hover()
        page.evaluate(SHOWN)
        before = _busy_s(watch)
        page.mouse.down()
        page.mouse.up()
        page.evaluate(OPENED)
        times.append(1000 * (_busy_s(watch) - before))
        page.keyboard.press("Escape")
        page.wait_for_function("() => !location.hash")
    page.close()
    return times


def _busy_s(watch: Any) -> float:
    told = {one["name"]: one["value"] for one in watch.send("Performance.getMetrics")["metrics"]}
    return float(told["TaskDuration"])


if __name__ == "__main__":
    main()
