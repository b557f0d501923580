"""Fly the reference campaign and write its published pages.

    python benchmarks/reference.py [--campaign reference] [--seeds 3] [--baseline-seeds 50] [--pages]

The script flies every cell's default mutant, the controls and PLACEBO in all situations, and searches the margin of
LATE-human on seed 0; stored flights are not flown again.  Then it writes the tables and the report of the campaign into
`results/published/reference/`.  `--pages` only writes.  With `chromium` on the path and the packages of the extra
`test`, it also takes a picture of the report.
"""

from __future__ import annotations

from checkout import ROOT  # first: it sets the path and the threads

# isort: split

import argparse
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

PUBLISHED = ROOT / "results" / "published" / "reference"
PAGES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("score.md", ("score", "--by", "parameter", "--format", "markdown")),
    ("score.json", ("score", "--format", "json")),
    ("coverage.md", ("coverage", "--format", "markdown")),
    ("matrix.md", ("matrix", "--margins", "--format", "markdown")),
    ("kills.md", ("kills", "--format", "markdown")),
    ("survivors.md", ("kills", "--show", "survivors", "--format", "markdown")),
)
"""Commands whose output is a published file, by file."""
FILES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("subsumption.svg", ("kills",)),
    ("worksheet.csv", ("worksheet", "--format", "csv")),
    ("worksheet.xlsx", ("worksheet", "--format", "xlsx")),
    ("outcomes.parquet", ("export", "--format", "parquet")),
    ("verification_log.md", ("export", "--format", "sace")),
    ("argument.gsn.yaml", ("export", "--format", "gsn")),
    ("report.html", ("report",)),
)
"""Commands that write a published file with `--output`, by file."""
EXPERIMENT = ROOT / "benchmarks" / "coverage_against_kills"
MARGINS = ("LATE-human",)
PICTURE, PART = "report.png", "#hazop"
WIDTH_PX, SCALE = 1280, 1.25


def call(*words: str) -> str:
    """The output of `scaloft-fi WORDS`."""
    done = subprocess.run([sys.executable, "-m", "scaloft_fi", *words], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    return done.stdout.decode()


def picture(page: Path, browser: str, output: Path) -> None:
    """Take a picture of the top of `page`."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox", "--disable-gpu"])
        tab = opened.new_page(viewport={"width": WIDTH_PX, "height": WIDTH_PX}, device_scale_factor=SCALE)
        tab.goto(page.as_uri())
        tab.locator(PART).screenshot(path=output)
        opened.close()


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--campaign", default="reference", help="where the flights are")
    parser.add_argument("--seeds", default="3", help="seeds of the mutants' flights")
    parser.add_argument("--baseline-seeds", default="50", help="seeds of the baseline pool")
    parser.add_argument("--pages", action="store_true", help="fly nothing")
    options = parser.parse_args(arguments)
    where = ("--campaign", options.campaign)
    if not options.pages:
        call("run", *where, "--seeds", options.seeds, "--baseline-seeds", options.baseline_seeds)
        call("margin", *where, *MARGINS)
    PUBLISHED.mkdir(parents=True, exist_ok=True)
    for name, words in PAGES:
        (PUBLISHED / name).write_text(call(*words, *where), encoding="utf-8")
    for name, words in FILES:
        call(*words, *where, "--output", str(PUBLISHED / name))
    subprocess.run([sys.executable, EXPERIMENT, *where, "--output", PUBLISHED], cwd=ROOT, check=True)
    browser = shutil.which("chromium")
    if browser:
        picture(PUBLISHED / "report.html", browser, PUBLISHED / PICTURE)
    for path in sorted(PUBLISHED.iterdir()):
        print(f"{path.relative_to(ROOT)}  {path.stat().st_size / 1024:.0f} KiB")


if __name__ == "__main__":
    main()
