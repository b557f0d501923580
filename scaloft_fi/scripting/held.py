"""A campaign of an open study, read: what the verbs that fly nothing do with a campaign, for scripts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError
from scaloft_fi.scripting.arguments import in_python, names
from scaloft_fi.scripting.score import CampaignScore
from scaloft_fi.views.columns import Columns

if TYPE_CHECKING:
    from scaloft_fi.study import Study
    from scaloft_fi.views.answers.worksheet import Worksheet
    from scaloft_fi.views.outputs.answer import Answer

REPORT_NAME = "report.html"


@dataclass(frozen=True)
class HeldCampaign:
    """A campaign of a study, which need not exist yet.

    Each method reads study and campaign as they are when it is called.

    Attributes:
        study_folder: folder of the study.
        name: name of the campaign.
        grid: name of the grid; None for that of the campaign.
    """

    study_folder: Path
    name: str
    grid: str | None = None

    @property
    def folder(self) -> Path:
        """Folder of the campaign."""
        from scaloft_fi.campaign.store.archive import campaign_folder

        with in_python():
            return campaign_folder(self._study, self.name)

    def score(self, *, baseline_from: str | None = None, today: date | None = None) -> CampaignScore:
        """Score the flights that the campaign holds, without flying.

        Args:
            baseline_from: name of a campaign whose baselines join the pool.
            today: day by which dispositions expire; by default the system's date.

        Raises:
            InputError: there is no campaign, or it holds no flight that counts.
        """
        from scaloft_fi.views.scored_campaign import scored_campaign

        with in_python():
            return CampaignScore(scored_campaign(self._study, self.name, baseline_from, today))

    def flights(self) -> Columns:
        """The flights that count, one row each, with the columns of `scaloft-fi export`.

        Raises:
            InputError: there is no campaign, or it holds no flight that counts.
        """
        from scaloft_fi.views.exchange.gather import dossier
        from scaloft_fi.views.flights.export import flight_columns

        with in_python():
            made = dossier(self._study, self.name)
            return flight_columns(made.rows, made.columns)

    def export(
        self,
        format: str = "json",  # noqa: A002 - the name of the option
        *,
        today: date | None = None,
    ) -> bytes:
        """The campaign in a format of `scaloft-fi export`, as the bytes of a file.

        Args:
            format: name of the format.
            today: day by which dispositions expire; by default the system's date.

        Raises:
            InputError: there is no such format or campaign, or the campaign holds no flight that counts.
        """
        from scaloft_fi.views.exchange import FORMATS
        from scaloft_fi.views.exchange.gather import dossier

        with in_python():
            chosen = FORMATS[format]
            return chosen.content(dossier(self._study, self.name, today))

    def report(self, path: Path | str | None = None, *, today: date | None = None) -> Path:
        """Write one HTML file that tells the whole campaign; returns its path.

        Args:
            path: path of the file; by default `report.html` in the folder of the campaign.
            today: day by which dispositions expire; by default none is judged.

        Raises:
            InputError: there is no campaign, it holds no flight that counts, or the file cannot be written.
        """
        from scaloft_fi.campaign.store.archive import is_archive
        from scaloft_fi.output import write_named
        from scaloft_fi.views.report.evidence import gather
        from scaloft_fi.views.report.page import page

        with in_python():
            if path is None and is_archive(self.folder):
                raise InputError(f"{self.folder}: an archive is a record, into which no report is written: give path")
            content = page(gather(self._study, self.name, today)).encode()
            file = self.folder / REPORT_NAME if path is None else Path(path)
            write_named(file, content, "path")
            return file

    def status(self) -> Answer:
        """How many flights the campaign holds, by status, and why those are stale that do not count any more.

        Raises:
            InputError: there is no campaign.
        """
        from scaloft_fi.views.answers.status import status

        with in_python():
            return status(self._study, self.name)

    def coverage(self) -> Answer:
        """How much of the situations the campaign covers, number by number.

        Raises:
            InputError: there is no campaign, or it holds no flight that counts.
        """
        from scaloft_fi.views.answers.coverage import coverage

        with in_python():
            return coverage(self._study, self.name)

    def kills(
        self,
        mutants: str | Sequence[str] = (),
        situations: str | Sequence[str] = (),
        *,
        show: str | Sequence[str] = (),
        by_requirement: bool = False,
    ) -> Answer:
        """Where mutants are killed, which situations are needed, and what would change the survivors.

        Args:
            mutants: names, ids or patterns; by default every mutant flown but the controls.
            situations: keys, aliases or patterns; `summary` tells what they kill together.
            show: `conditions`, `situations`, `suite`, `subsumption` or `survivors`, at length; by default all, shortly.
            by_requirement: whether subsumption tells kills by different requirements of a situation apart.

        Raises:
            InputError: there is no campaign, mutant, situation or part, or the campaign holds no such flight.
        """
        from scaloft_fi.views.answers.kills import kills

        with in_python():
            return kills(
                self._study,
                self.name,
                names(mutants, "mutants"),
                show=names(show, "show"),
                situations=names(situations, "situations"),
                by_requirement=by_requirement,
            )

    def when(self, mutants: str | Sequence[str], *, operability: bool = False) -> Answer:
        """At which times and events of the flight faults are killed: `scaloft-fi margin --when`; flies nothing.

        Args:
            mutants: names of cells, or ids.
            operability: as for `margin`.

        Raises:
            InputError: a mutant has no phases, or the campaign fewer than two of them.
        """
        from scaloft_fi.views.answers.margin import when

        with in_python():
            return when(self._study, self.name, names(mutants, "mutants"), operability=operability)

    def worksheet(self) -> Worksheet:
        """The HAZOP worksheet: every deviation beside what its default mutant did; `save` writes it for a meeting.

        Raises:
            InputError: there is no campaign, or it holds no flight that counts.
        """
        from scaloft_fi.views.answers.worksheet import worksheet

        with in_python():
            return worksheet(self._study, self.name)

    def dispositions(self, *, today: date | None = None) -> Answer:
        """The survivors beside the study's dispositions; the column `fails` is what `score --ratchet` does not pass.

        Args:
            today: day by which dispositions expire; by default the system's date.

        Raises:
            InputError: there is no campaign, it holds no flight that counts, or no baseline pool to decide by.
        """
        from scaloft_fi.views.answers.dispositions import dispositions

        with in_python():
            return dispositions(self._study, self.name, today)

    def diff(self, other: str) -> Answer:
        """The flights of which this campaign and another one do not say the same.

        Args:
            other: name of the other campaign.

        Raises:
            InputError: one of the campaigns does not exist, or they were flown over different grids.
        """
        from scaloft_fi.views.answers.diff import diff

        with in_python():
            return diff(self._study, self.name, other)

    @property
    def _study(self) -> Study:
        from scaloft_fi.campaign.store.flown_grid import study_of

        return study_of(self.study_folder, self.name, self.grid)

    def _repr_html_(self) -> str:
        from scaloft_fi.campaign.store.archive import STORE_NAME, is_archive
        from scaloft_fi.views.tables.html import html
        from scaloft_fi.views.tables.table import Table

        if is_archive(self.folder) or (self.folder / STORE_NAME).is_file():
            return self.status()._repr_html_()
        return html((Table(f"Campaign {self.folder}", (), (), ("Nothing was flown here yet.",)),))
