"""A campaign of an open study: what the verbs run, score, export, report, replay and status do, for scripts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.scripting.arguments import Seeds, in_python, names, number
from scaloft_fi.scripting.arguments import seeds as seeds_of
from scaloft_fi.scripting.flight import FlownFlight
from scaloft_fi.scripting.progress import Told, progress_of
from scaloft_fi.scripting.score import CampaignScore
from scaloft_fi.views.columns import Columns
from scaloft_fi.views.tables.html import html

if TYPE_CHECKING:
    from scaloft_fi.campaign.workers.executor import Executor
    from scaloft_fi.study import Study
    from scaloft_fi.views.tables.table import Table

MOST_JOBS = 1024
REPORT_NAME = "report.html"


@dataclass(frozen=True)
class OpenCampaign:
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
        from scaloft_fi.campaign.store.folder import campaign_folder

        with in_python():
            return campaign_folder(self._study, self.name)

    def run(
        self,
        mutants: str | Sequence[str] = (),
        situations: str | Sequence[str] = (),
        *,
        seeds: Seeds | None = None,
        baseline_seeds: Seeds | None = None,
        baseline_from: str | None = None,
        choose: str | None = None,
        choose_seed: int = 0,
        sequential: bool = False,
        shard: str | None = None,
        budget_s: float | None = None,
        jobs: int | None = None,
        executor: str = "local",
        cluster_key: Path | str | None = None,
        cluster_security: Path | str | None = None,
        share: bool = True,
        max_invalid: float = 0.1,
        same_platform: bool = False,
        progress: Told = False,
    ) -> CampaignScore:
        """Fly the flights that the campaign lacks, and score those of this call; the same call resumes.

        Args:
            mutants: names, ids or patterns; by default every cell's default mutant and the controls.
            situations: keys, aliases or patterns; by default those that `choose` chooses.
            seeds: seeds of the mutants' flights; by default seed 0.
            baseline_seeds: seeds of the baseline pool in addition to `seeds`; by default as many as make ten.
            baseline_from: name of a campaign whose baselines join the pool.
            choose: which of the situations, such as `random:8`; by default what the grid says.
            choose_seed: seed of the choice.
            sequential: whether to fly 1, 3, 5 and 10 seeds in looks, of which each spends a quarter of alpha.
            shard: `K/N` for the K-th of N parts.
            budget_s: wall time after which no flight begins [s].
            jobs: number of processes; by default the number of processors.
            executor: `local`, or `dask://HOST:PORT` for the workers of a Dask scheduler.
            cluster_key: key file that the workers of the scheduler have too.
            cluster_security: folder with the certificates for the scheduler.
            share: whether mutants share the beginning of their baseline; the outcomes are the same.
            max_invalid: greatest share 0..1 of flights over which the harness may fail.
            same_platform: whether only flights with the bits of this platform count.
            progress: True for lines on the standard error, or a function of the flights flown and expected so far.

        Raises:
            GateError: a gate failed, so there is no valid score.
            InputError: an argument is not allowed, or the study cannot be flown.
            Interrupted: the user stopped the run; every flight that ended is saved.
        """
        from scaloft_fi.campaign.flights.fork import CAN_FORK
        from scaloft_fi.campaign.plan.choose import shard as shard_in
        from scaloft_fi.campaign.runs.options import RunOptions
        from scaloft_fi.campaign.runs.request import Request, fly, planned_run
        from scaloft_fi.campaign.store.folder import campaign_folder
        from scaloft_fi.views.scored_campaign import scored_run

        with in_python():
            request = Request(
                mutants=names(mutants, "mutants"),
                situations=names(situations, "situations"),
                choose=choose,
                choose_seed=choose_seed,
                seeds=seeds_of(seeds, "seeds"),
                baseline_seeds=seeds_of(baseline_seeds, "baseline_seeds"),
                baseline_from=baseline_from,
                sequential=sequential,
                shard=None if shard is None else shard_in(shard),
                budget_s=None if budget_s is None else number(budget_s, "budget_s", 0.0, 1e9),
            )
            options = RunOptions(
                executor=_executor(executor, jobs, cluster_key, cluster_security),
                share=CAN_FORK and share,
                max_invalid=number(max_invalid, "max_invalid", 0.0, 1.0),
                same_platform=same_platform,
            )
            shown = progress_of(progress)
            study = self._study
            flown = fly(planned_run(study, request), campaign_folder(study, self.name), options, progress=shown)
            return CampaignScore(scored_run(flown, self.name))

    def score(self, *, baseline_from: str | None = None) -> CampaignScore:
        """Score the flights that the campaign holds, without flying.

        Args:
            baseline_from: name of a campaign whose baselines join the pool.

        Raises:
            InputError: there is no campaign, or it holds no flight that counts.
        """
        from scaloft_fi.views.scored_campaign import scored_campaign

        with in_python():
            return CampaignScore(scored_campaign(self._study, self.name, baseline_from))

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

    def export(self, format: str = "json") -> bytes:  # noqa: A002 - the name of the option
        """The campaign in a format of `scaloft-fi export`, as the bytes of a file.

        Raises:
            InputError: there is no such format or campaign, or the campaign holds no flight that counts.
        """
        from scaloft_fi.views.exchange import FORMATS
        from scaloft_fi.views.exchange.gather import dossier

        with in_python():
            chosen = FORMATS[format]
            return chosen.content(dossier(self._study, self.name))

    def report(self, path: Path | str | None = None, *, today: date | None = None) -> Path:
        """Write one HTML file that tells the whole campaign; returns its path.

        Args:
            path: path of the file; by default `report.html` in the folder of the campaign.
            today: day by which dispositions expire; by default none is judged.

        Raises:
            InputError: there is no campaign, it holds no flight that counts, or the file cannot be written.
        """
        from scaloft_fi.output import write_named
        from scaloft_fi.views.report.evidence import gather
        from scaloft_fi.views.report.page import page

        with in_python():
            content = page(gather(self._study, self.name, today)).encode()
            file = self.folder / REPORT_NAME if path is None else Path(path)
            write_named(file, content, "path")
            return file

    def replay(self, mutant: str, situation: str, seed: int = 0, *, same_platform: bool = False) -> FlownFlight:
        """Fly one flight again, in this process; its `comparison` says how it compares with that of the campaign.

        Args:
            mutant: `baseline`, `PLACEBO`, or name or id of a mutant.
            situation: key or alias of a situation.
            seed: seed of the noise.
            same_platform: whether only an equal digest will do, also beside a flight of another platform.

        Raises:
            GateError: the flight differs from that of the campaign.
            InputError: there is no such mutant or situation, or the study cannot be flown.
        """
        from scaloft_fi.views.flights.logged_flight import fly_with_log, ready_to_fly
        from scaloft_fi.views.flights.repeated import compared

        with in_python():
            study = self._study
            flown = fly_with_log(study, ready_to_fly(study, mutant, situation, seed, lambda _text: None))
            return FlownFlight(flown, compared(flown, self.name, same_platform=same_platform))

    @property
    def _study(self) -> Study:
        from scaloft_fi.campaign.store.flown_grid import study_of

        return study_of(self.study_folder, self.name, self.grid)

    def _status(self) -> Sequence[Table]:
        from scaloft_fi.views.flights.status import status_tables, status_values
        from scaloft_fi.views.snapshot import snapshot

        with snapshot(self._study, self.name) as now:
            return status_tables(status_values(now))

    def _repr_html_(self) -> str:
        from scaloft_fi.campaign.store.folder import STORE_NAME
        from scaloft_fi.views.tables.table import Table

        with in_python():
            if (self.folder / STORE_NAME).is_file():
                return html(self._status())
            return html((Table(f"Campaign {self.folder}", (), (), ("Nothing was flown here yet.",)),))


def _executor(
    name: str, jobs: int | None, cluster_key: Path | str | None, cluster_security: Path | str | None
) -> Executor:
    """What runs the flights; on this machine, new interpreters where the system can hand them a connection."""
    from scaloft_fi.campaign.processes.start import cores
    from scaloft_fi.campaign.workers.clean import Clean
    from scaloft_fi.campaign.workers.named import LOCAL, executor_named

    count = None if jobs is None else int(number(jobs, "jobs", 1, MOST_JOBS))
    if name == LOCAL and os.name == "posix" and cluster_security is None:
        return Clean(count or cores())
    key, security = (None if path is None else Path(path) for path in (cluster_key, cluster_security))
    return executor_named(name, count, key, security)
