"""`scaloft-fi report`: one HTML file that tells a whole campaign."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from scaloft_fi.campaign.store.archive import campaign_folder, is_archive
from scaloft_fi.errors import InputError
from scaloft_fi.output import line, write_named
from scaloft_fi.study import Study
from scaloft_fi.verbs import options
from scaloft_fi.verbs.options import Option, answer, check_writable, verb
from scaloft_fi.verbs.report.analyses import gather
from scaloft_fi.verbs.report.page import page
from scaloft_fi.verbs.snapshot import Stale
from scaloft_fi.views.output import Answer, Output


@dataclass(frozen=True)
class Written:
    """Where the report was written.

    Attributes:
        report: path of the page.
        bytes: its size [bytes].
        stale: the stored flights that no longer count and were not flown again.
    """

    report: Path
    bytes: int
    stale: Stale


REPORT = Output("report", "1.1", Written, rows="summary")
NAME = "report.html"


@verb("report")
def report_command(
    *,
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    output: Annotated[
        Path | None, Option("Write the page there.", metavar="FILE", otherwise="report.html in the campaign's folder")
    ],
    today: options.AsOf,
    style: options.LineFormat,
) -> None:
    """Write one HTML file that opens from disk, without a network: both matrices, every flight, what follows.

    Examples:
        Write the page into the campaign's folder: `scaloft-fi report`
        Write it elsewhere: `scaloft-fi report --output report.html`
        Mark dispositions that have expired by a day: `scaloft-fi report --today 2027-01-31`
    """
    check_writable(output, *options.PAGE, what="HTML")
    study = Study.open(study_folder)
    folder = campaign_folder(study, campaign)
    if output is None and is_archive(folder):
        raise InputError(f"{folder}: an archive is a record, into which no report is written: give --output FILE")
    evidence = gather(study, campaign, today)
    path = output or folder / NAME
    content = page(evidence).encode()
    write_named(path, content)
    written = Written(path, len(content), evidence.stale)
    told = line(f"report: {path} ({written.bytes / 1e6:.1f} MB)")
    warnings = (*evidence.stale.sentences, *evidence.study.finds.warnings)
    answer(Answer(REPORT, lambda: written, told=lambda _: f"{told}\n", warnings=warnings), style)
