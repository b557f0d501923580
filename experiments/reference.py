"""Make the published pages of the reference campaign from its published flights; with `--fly` fly them first.

    python -m experiments.reference [--fly] [--picture]

`results/published/reference/` is an archive of the campaign: `campaign.json`, `outcomes.parquet`, `tracks.parquet`.
Everything else there is made from these three and from the study, and a test makes it again.  `--fly` flies every
cell's default mutant, the controls and PLACEBO in all situations and searches the margin of LATE-human on seed 0, in
the campaign `reference`, where stored flights are not flown again; then it writes the three files anew.  `--picture`
takes a picture of the report: that needs `chromium` on the path and the packages of the extra `test`.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from array import array
from collections.abc import Iterator, Sequence
from contextlib import chdir, contextmanager
from functools import cache
from pathlib import Path
from unittest.mock import patch

import numpy as np
from click.testing import CliRunner

from experiments import PUBLISHED, ROOT
from experiments.coverage_against_kills import pages as of_situations
from scaloft_fi.campaign.store.archive import MANIFEST, OUTCOMES, TRACKS
from scaloft_fi.cli import main as scaloft_fi
from scaloft_fi.judge.outcome import TRACK_COLUMNS, unpack_track
from scaloft_fi.sim.log import FAR_M
from scaloft_fi.study import Study
from scaloft_fi.verbs import snapshot
from scaloft_fi.verbs.export.dossier import archive_files
from scaloft_fi.verbs.report.flights import FAR, quantised, quantum, thinned

REFERENCE = PUBLISHED / "reference"
RECORD = (MANIFEST, OUTCOMES, TRACKS)
"""The files from which the others are made."""
PAGES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("status.md", ("status", "--format", "markdown")),
    ("score.md", ("score", "--by", "parameter", "--format", "markdown")),
    ("score.json", ("score", "--format", "json")),
    ("coverage.md", ("coverage", "--format", "markdown")),
    ("matrix.md", ("matrix", "--margins", "--format", "markdown")),
    ("kills.md", ("kills", "--format", "markdown")),
    ("survivors.md", ("kills", "--show", "survivors", "--format", "markdown")),
    ("verification_log.md", ("export", "--format", "sace")),
    ("argument.gsn.yaml", ("export", "--format", "gsn")),
    ("worksheet.csv", ("worksheet", "--format", "csv")),
)
"""Commands whose output is a published file, by file."""
FILES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("subsumption.svg", ("kills",)),
    ("worksheet.xlsx", ("worksheet", "--format", "xlsx")),
)
"""Commands that write a published file with `--output`, by file."""
CAMPAIGN, SEEDS, BASELINE_SEEDS = "reference", "3", "50"
MARGINS = ("LATE-human",)
EVERY, COARSE = 2, 2
"""What is kept of the published trajectories: every second sample, in steps of 2 cm and 2 cm/s."""
PICTURE, PART = PUBLISHED / "report.png", "#hazop"
SCALE = 1.25


def call(*words: str) -> bytes:
    """What `scaloft-fi WORDS` prints."""
    return CliRunner().invoke(scaloft_fi, words, catch_exceptions=False).stdout_bytes


def record() -> dict[str, bytes]:
    """The files of the record, of the campaign that was flown."""
    return archive_files(Study.open(ROOT), CAMPAIGN, documents=False, kept=thin)


def thin(track: bytes) -> array[float]:
    """The published values of a packed track, row by row."""
    rows = quantised(thinned(unpack_track(track), EVERY), TRACK_COLUMNS, COARSE)
    steps = np.array([quantum(column, COARSE) for column in TRACK_COLUMNS])
    return array("f", np.where(rows == FAR, FAR_M, rows * steps).astype(np.float32).tobytes())


def pages(folder: Path = REFERENCE) -> dict[str, bytes]:
    """The files that are made from the record in `folder`, by their names."""
    name = os.path.relpath(folder, ROOT)
    where = ("--campaign", name if os.sep in name else f"./{name}")
    with chdir(ROOT), _once("opened"), _once("Snapshot"), tempfile.TemporaryDirectory() as made:
        printed = {name: call(*words, *where) for name, words in PAGES}
        for name, words in FILES:
            call(*words, *where, "--output", f"{made}/{name}")
        written = {name: Path(made, name).read_bytes() for name, _ in FILES}
        drawn = {name: text.encode() for name, text in of_situations(Study.open(ROOT), where[1]).items()}
    return printed | written | drawn


@contextmanager
def _once(name: str) -> Iterator[None]:
    """Read and score the campaign once for all pages, not for each."""
    with patch.object(snapshot, name, cache(getattr(snapshot, name))):
        yield


def pictured(page: Path, part: str, output: Path, width_px: int = 1280) -> None:
    """Take a picture of the part of a page that a selector of CSS names, in a window of this width."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        tab = opened.new_page(viewport={"width": width_px, "height": width_px}, device_scale_factor=SCALE)
        tab.goto(page.as_uri())
        tab.locator(part).screenshot(path=output)
        opened.close()


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly where that is asked for, and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fly", action="store_true", help="fly the campaign, and publish its flights")
    parser.add_argument("--picture", action="store_true", help="take a picture of the report")
    options = parser.parse_args(arguments)
    if options.fly:
        with chdir(ROOT):
            call("run", "--campaign", CAMPAIGN, "--seeds", SEEDS, "--baseline-seeds", BASELINE_SEEDS)
            call("margin", "--campaign", CAMPAIGN, *MARGINS)
        for name, content in record().items():
            (REFERENCE / name).write_bytes(content)
    for name, content in pages().items():
        (REFERENCE / name).write_bytes(content)
    if options.picture:
        with tempfile.TemporaryDirectory() as made:
            page = Path(made) / "report.html"
            call("report", "--campaign", str(REFERENCE), "--output", str(page))
            pictured(page, PART, PICTURE, 1440)


if __name__ == "__main__":
    main()
