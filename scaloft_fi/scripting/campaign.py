"""A campaign of an open study: what the verbs that fly for a campaign do, for scripts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.defaults import SEARCHED
from scaloft_fi.errors import InputError
from scaloft_fi.scripting.arguments import Seeds, in_python, names, number
from scaloft_fi.scripting.arguments import seeds as seeds_of
from scaloft_fi.scripting.flight import FlownFlight
from scaloft_fi.scripting.held import HeldCampaign
from scaloft_fi.scripting.progress import Told, progress_of
from scaloft_fi.scripting.score import CampaignScore

if TYPE_CHECKING:
    from scaloft_fi.campaign.runs.gates import RunOptions
    from scaloft_fi.campaign.workers.local import Executor
    from scaloft_fi.views.outputs.answer import Answer

MOST_JOBS = 1024
MOST_SEED = 2**31 - 1
LEAST_TOLERANCE = 1e-9


@dataclass(frozen=True)
class OpenCampaign(HeldCampaign):
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
        from scaloft_fi.campaign.plan import parse_shard as shard_in
        from scaloft_fi.campaign.runs.gates import RunOptions
        from scaloft_fi.campaign.runs.request import Request, fly, planned_run
        from scaloft_fi.campaign.store.archive import campaign_folder
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

    def margin(
        self,
        mutants: str | Sequence[str],
        situations: str | Sequence[str] = (),
        *,
        seeds: Seeds = 1,
        tolerance: float | None = None,
        operability: bool = False,
        jobs: int | None = None,
        same_platform: bool = False,
        progress: Told = False,
    ) -> Answer:
        """Find the smallest magnitude of each fault that is killed, by bisection; flies what the campaign lacks.

        Args:
            mutants: names of cells, or ids.
            situations: keys, aliases or patterns; by default the whole grid.
            seeds: seeds of the flights.
            tolerance: width of the interval at which the search ends, in the magnitude's unit; by default a tenth of
                the strong end's distance from no fault.
            operability: whether violations of operability requirements kill, instead of those of safety requirements.
            jobs: number of processes; by default the number of processors.
            same_platform: whether only flights with the bits of this platform count.
            progress: as for `run`, round by round.

        Raises:
            GateError: a gate failed.
            InputError: an argument is not allowed, a fault has no order, or the study cannot be flown.
            Interrupted: the user stopped the search; every flight that ended is saved.
        """
        from scaloft_fi.views.answers.margin import margin

        with in_python():
            progress_of(progress)
            return margin(
                self._study,
                self.name,
                names(mutants, "mutants"),
                _options(jobs, same_platform),
                situations=names(situations, "situations"),
                seeds=seeds_of(seeds, "seeds") or (),
                tolerance=None if tolerance is None else number(tolerance, "tolerance", LEAST_TOLERANCE, 1e9),
                operability=operability,
                progress=lambda: progress_of(progress),
            )

    def seek(
        self,
        mutants: str | Sequence[str] = (),
        *,
        grid: str = SEARCHED,
        into: str | None = None,
        budget: str | None = None,
        seed: int = 0,
        anyhow: bool = False,
        replicate: bool = False,
        jobs: int | None = None,
        same_platform: bool = False,
        progress: Told = False,
    ) -> Answer:
        """Find situations that would have shown mutants, and write them to the study's `sim/found.yaml`.

        Args:
            mutants: ids or patterns, or `baseline` for situations that break the unmutated drone; by default every
                cell's default that this campaign does not detect and no found situation shows.
            grid: name of the grid that is searched, with free axes; by default `search`.
            into: name of the campaign that holds the flights of the search; by default that of the grid.
            budget: a wall time such as `10m`, or a number of flights such as `2000flights`; by default none.
            seed: seed of the search.
            anyhow: whether a situation counts too where the unmutated drone does not do its mission.
            replicate: whether nothing is searched, and the finds are flown on seeds that nothing before used.
            jobs: number of processes; by default the number of processors.
            same_platform: whether only flights with the bits of this platform count.
            progress: as for `run`.

        Raises:
            GateError: a gate failed.
            InputError: an argument is not allowed, Optuna is missing, or the study cannot be flown or written.
            Interrupted: the user stopped the search; flights and finds are saved.
        """
        from scaloft_fi.campaign.seeking.finds import Allowance
        from scaloft_fi.views.answers.seek import Search, seek, study_to_search

        with in_python(budget="budget"):
            options, allowance = _options(jobs, same_platform), Allowance.parse(budget)
            search = Search(
                into or grid,
                options,
                int(number(seed, "seed", 0, MOST_SEED)),
                allowance,
                progress_of(progress),
                anyhow,
                replicate,
            )
            study = study_to_search(self.study_folder, grid, search.into)
            return seek(study, self.name, names(mutants, "mutants"), search, named=self.study_folder)

    def merge(self, others: str | Sequence[str], *, same_platform: bool = False) -> Answer:
        """Add the flights of other campaigns to this one, which need not exist.

        Args:
            others: names of the campaigns.
            same_platform: whether a campaign of another platform is refused unless flights in both have equal digests.

        Raises:
            GateError: a flight has other digests on one platform, or other facts on two; nothing is written.
            InputError: there is no such campaign, two have different grids, or the campaign cannot be written.
        """
        from scaloft_fi.campaign.store.flown_grid import study_of_all
        from scaloft_fi.views.answers.merge import merge

        with in_python():
            sources = names(others, "others")
            if not sources:
                raise InputError("others=() must name a campaign")
            study = study_of_all(self.study_folder, [*sources, self.name])
            return merge(study, self.name, sources, same_platform=same_platform)


def _options(jobs: int | None, same_platform: bool) -> RunOptions:
    """Options of a search."""
    from scaloft_fi.campaign.processes import cores
    from scaloft_fi.campaign.runs.gates import RunOptions

    count = cores() if jobs is None else int(number(jobs, "jobs", 1, MOST_JOBS))
    return RunOptions(jobs=count, executor=_executor("local", count, None, None), same_platform=same_platform)


def _executor(
    name: str, jobs: int | None, cluster_key: Path | str | None, cluster_security: Path | str | None
) -> Executor:
    """What runs the flights; on this machine, new interpreters where the system can hand them a connection."""
    from scaloft_fi.campaign.processes import cores
    from scaloft_fi.campaign.workers.local import Clean
    from scaloft_fi.campaign.workers.named import LOCAL, executor_named

    count = None if jobs is None else int(number(jobs, "jobs", 1, MOST_JOBS))
    if name == LOCAL and os.name == "posix" and cluster_security is None:
        return Clean(count or cores())
    key, security = (None if path is None else Path(path) for path in (cluster_key, cluster_security))
    return executor_named(name, count, key, security)
