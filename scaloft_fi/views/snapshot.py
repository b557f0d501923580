"""A campaign at one moment: everything that a verb reads, from a store that is opened once."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.score import Score, score_of
from scaloft_fi.campaign.runs.request import Remembered, remembered
from scaloft_fi.campaign.runs.run import spending_of
from scaloft_fi.campaign.store.archive import Archive, campaign_folder
from scaloft_fi.campaign.store.flown_grid import opened
from scaloft_fi.campaign.store.held import Held, Now, held_in, latest_in, nothing_to_show, with_tracks
from scaloft_fi.campaign.store.platforms import Platforms, warning_for
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Rulings, rulings_of
from scaloft_fi.study import Study
from scaloft_fi.views.again import stale_of
from scaloft_fi.views.stale import Stale


@dataclass(frozen=True)
class Snapshot:
    """What a campaign holds while a snapshot of its store lasts; each part is read when it is first asked for.

    Attributes:
        study: what was flown, with the grid of the campaign.
        name: of the campaign, as `--campaign` takes it; of an archive the name that was archived.
        folder: of the campaign.
        store: open, within a snapshot.
    """

    study: Study
    name: str
    folder: Path
    store: Store

    @property
    def archive(self) -> Archive | None:
        """The archive that is read; None for a campaign that was flown here."""
        return self.store if isinstance(self.store, Archive) else None

    @cached_property
    def outcomes(self) -> tuple[Outcome, ...]:
        """The outcomes that count, ordered by mutant, situation and seed, without tracks.

        Raises:
            InputError: there are none.
        """
        return self.store.standing(self.now.stands) or nothing_to_show(self.store, self.folder)

    @cached_property
    def now(self) -> Now:
        """The study as it is now, beside which stored flights count or are stale."""
        return Now(self.study, self.store)

    @cached_property
    def rulings(self) -> Rulings:
        """What each of these flights shows beside its baseline: all that a score needs.

        Raises:
            InputError: there are none.
        """
        return rulings_of(self.outcomes)

    @cached_property
    def held(self) -> Held:
        """The same outcomes, of which there may be none, beside what is stale and what is planned and not flown."""
        return held_in(self.study, self.store, self.folder)

    @cached_property
    def stale(self) -> Stale:
        """The stored flights that no longer count and were not flown again."""
        return stale_of(self.study, self.store, self.now, self.name)

    @cached_property
    def latest(self) -> tuple[Outcome, ...]:
        """One outcome of each flight: the one that counts, else one that the study has outgrown."""
        return latest_in(self.study, self.store)

    @cached_property
    def score(self) -> Score:
        """The campaign's score.

        Raises:
            InputError: it has no outcome that counts.
        """
        return score_of(self.rulings, self.study.roster, self.study.space, self.spending)

    @cached_property
    def spending(self) -> Spending:
        """How alpha is spent on the campaign's mutants."""
        return spending_of(self.study, self.store)

    @cached_property
    def platform(self) -> Mapping[str, str]:
        """On which most flights that count were flown, part by part; `other platforms` tells of the rest."""
        platform = next((one for one, _ in self._platforms.by_platform(self.held.current)), self._platforms.own)
        return {**platform, **({"other platforms": self.mixture} if self.mixture else {})}

    @cached_property
    def mixture(self) -> str:
        """A sentence about the platforms of the flights that count; empty for one platform."""
        return self._platforms.mixture(self.held.current)

    @cached_property
    def _platforms(self) -> Platforms:
        return Platforms(self.store)

    @cached_property
    def platform_warning(self) -> str:
        """What a reader must know of the platforms of the flights; empty when there is nothing, as for a record.

        Raises:
            InputError: there are no outcomes.
        """
        return self.mixture if self.archive else warning_for(self._platforms, self.outcomes)

    @cached_property
    def choices(self) -> Sequence[Remembered]:
        """How the campaign's situations were chosen."""
        return remembered(self.store)

    def with_tracks(
        self, outcomes: Iterable[Outcome], mutants: Collection[str], seeds: Collection[int] | None = None
    ) -> tuple[Outcome, ...]:
        """The same outcomes, those of `mutants` (`baseline` among the ids) and `seeds` (None: all) with tracks."""
        return with_tracks(self.study, self.store, outcomes, mutants, seeds)


@contextmanager
def snapshot(study: Study, campaign: str) -> Iterator[Snapshot]:
    """The campaign at this moment, whatever others write to it meanwhile.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.

    Raises:
        InputError: there is no campaign.
    """
    folder = campaign_folder(study, campaign)
    study, store = opened(study, folder)
    with store, store.snapshot():
        name = store.manifest.campaign if isinstance(store, Archive) else campaign
        yield Snapshot(study, name, folder, store)
