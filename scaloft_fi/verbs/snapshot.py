"""A campaign at one moment: everything that a verb reads, from a store opened once, and what no longer counts."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from scaloft_fi.analysis.detection import LEAST, Spending
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import Score, score_of
from scaloft_fi.campaign.runs import gates
from scaloft_fi.campaign.store import held as holding
from scaloft_fi.campaign.store.archive import Archive, campaign_folder, opened
from scaloft_fi.campaign.store.held import with_tracks
from scaloft_fi.campaign.store.platforms import Platforms, warning_for
from scaloft_fi.campaign.store.store import FlownFlight, Store
from scaloft_fi.hazop.matrix import cell_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Outcome
from scaloft_fi.judge.status import Rulings, rulings_beside, rulings_of
from scaloft_fi.mutants.catalogue import defaults
from scaloft_fi.output import in_campaign
from scaloft_fi.sim.grid import ALL
from scaloft_fi.study import Study
from scaloft_fi.verbs.verdict import MOST_NAMED, next_step
from scaloft_fi.views.table import counted


def _again(study: Study, now: holding.Now, name: str, stale: Sequence[FlownFlight]) -> str:
    """The `run` that flies these flights; of what it asks for besides, the campaign holds the flights that count."""
    held = now.flights
    known = {flight.mutant for flight in held}
    asking = stale if _mutants(stale, study.roster) else held  # baselines alone are flown again beside their mutants
    mutants = _mutants(asking, study.roster) or [PLACEBO_ID]
    seeds = {flight.seed for flight in asking if flight.mutant in mutants} or {flight.seed for flight in stale}
    pool = {flight.seed for flight in stale if flight.mutant == BASELINE}
    words = [f"scaloft-fi run{in_campaign(name)}"]
    ids = {mutant.id for mutant in defaults(study.matrix)}
    if len(mutants) <= MOST_NAMED or not (ids.issuperset(mutants) and known.issuperset(ids)):
        words += [f"--mutant {shlex.quote(id_)}" for id_ in mutants]
    words += _situations(study, now.store, *({flight.situation for flight in flights} for flights in (stale, held)))
    words += [] if seeds == {0} else [f"--seeds {_range(seeds)}"]
    words += [f"--baseline-seeds {_range(pool)}"] if pool - seeds - set(range(LEAST)) else []
    return " ".join(words)


def _mutants(flights: Sequence[FlownFlight], roster: Roster) -> list[str]:
    """The mutants among `flights`, in the canonical order; a control that was flown once comes with every run."""
    flown = Counter(flight.mutant for flight in flights)
    canaries = {id_ for id_, number in flown.items() if number == 1 and cell_of(id_) in roster.controls}
    return sorted(flown.keys() - canaries - {BASELINE, PLACEBO_ID}, key=roster.rank)


def _situations(study: Study, store: Store, stale: Collection[str], held: Collection[str]) -> list[str]:
    """The options that choose these situations, among others of which the campaign holds flights."""
    grid = study.grid
    if grid.choose == ALL and set(grid.by_key) <= set(held):
        return []
    for one in holding.remembered(store):
        if len(stale) > MOST_NAMED and {key for key, _ in one.draws}.issuperset(stale):
            return [f"--choose {shlex.quote(one.text)}", *([f"--choose-seed {one.seed}"] if one.seed else [])]
    return [f"--situation {shlex.quote(key)}" for key in sorted(stale, key=study.space.rank)]


def _range(seeds: Collection[int]) -> str:
    """The seeds as `--seeds` takes them, with those between."""
    least, most = min(seeds), max(seeds)
    return f"{least}-{most}" if least else str(most + 1)


REASONS = 2
"""How many reasons a sentence names before it counts the rest."""


@dataclass(frozen=True)
class Reason:
    """One reason.

    Attributes:
        why: the reason, in words.
        flights: how many.
    """

    why: str
    flights: int


@dataclass(frozen=True)
class Stale:
    """The stored flights that no longer count and were not flown again, and those that did not repeat their bits.

    Attributes:
        flights: how many no longer count.
        reasons: why they no longer count, the commonest reason first.
        command: what flies them again; null: there are none that the study still has.
        differed: flights that count although their repetition had other bits; no score with them is valid.
        invalid: why no score of the campaign is valid, each reason in a sentence; often none.
        broken: how many flights that count are invalid, and say nothing.
    """

    flights: int = 0
    reasons: tuple[Reason, ...] = ()
    command: str | None = None
    differed: tuple[str, ...] = ()
    invalid: tuple[str, ...] = ()
    broken: int = 0

    @classmethod
    def of(cls, why: Mapping[str, int], command: str) -> Stale:
        """The flights by reason, with the command that flies them again; empty where the study has none any more."""
        return cls(sum(why.values()), tuple(Reason(*each) for each in why.items()), command or None)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The same for people; empty when every flight counts.

        >>> Stale.of({"operator delay changed": 3}, "scaloft-fi run --mutant LATE-human@3s").sentences
        ('3 stored flights no longer count: operator delay changed; `scaloft-fi run --mutant LATE-human@3s` flies \
them again',)
        """
        say_nothing = f"{counted(self.broken, 'invalid flight')}, which say nothing (`scaloft-fi status` says why)"
        first = (*self.invalid, *([say_nothing] if self.broken else ()))
        if not self.reasons:
            return first
        flights, several = self.flights, len(self.reasons) > 1
        reasons = [f"{one.why} ({one.flights})" if several else one.why for one in self.reasons]
        rest = [f"{len(reasons) - REASONS} more reasons (`scaloft-fi status`)"] if len(reasons) > REASONS else []
        told = f"{flights} stored flight{'s' * (flights != 1)} no longer count{'s' * (flights == 1)}"
        again = f"`{self.command}` flies {'them' if flights != 1 else 'it'} again"
        ends = again if self.command else "the study has no such flight any more"
        return (*first, f"{told}: {', '.join([*reasons[:REASONS], *rest])}; {ends}")


SEARCHED = (
    "no score is valid, because a search chose what to fly by what it saw; `seek` says what fresh seeds confirm, and "
    "`run --grid NAME+found` flies it for a score"
)


NONE = Stale()
"""Every stored flight counts."""


@dataclass(frozen=True)
class Snapshot:
    """What a campaign holds while a snapshot of its store lasts; each part is read when it is first asked for.

    Attributes:
        study: what was flown, with the grid of the campaign.
        name: of the campaign, as `--campaign` takes it.
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
        return self.store.standing(self.now.stands) or holding.nothing_to_show(self.study, self.store, self.folder)

    @cached_property
    def now(self) -> holding.Now:
        """The study as it is now, beside which stored flights count or are stale."""
        return holding.Now(self.study, self.store)

    def outcomes_of(self, subjects: Collection[str]) -> tuple[Outcome, ...]:
        """Those of some subjects."""
        return self.store.standing(self.now.stands, subjects)

    @cached_property
    def ruled(self) -> Rulings:
        """What each of these flights, of which there may be none, shows beside its baseline: all that a score needs."""
        if "outcomes" in self.__dict__:  # read already
            return rulings_of(self.outcomes)
        return rulings_beside(self.outcomes_of({BASELINE}), self.store.standing_mutants(self.now.stands))

    @property
    def rulings(self) -> Rulings:
        """The same.

        Raises:
            InputError: there are none.
        """
        return self.ruled or holding.nothing_to_show(self.study, self.store, self.folder)

    @cached_property
    def held(self) -> holding.Held:
        """What is stale, and what is planned and not flown."""
        return holding.held_in(self.now, self.folder)

    @cached_property
    def stale(self) -> Stale:
        """The stored flights that no longer count and were not flown again, with the command that does it."""
        found, study = holding.stale_in(self.now), self.study
        again = ""
        if found.flown:
            again = study.again if study.tests_of else _again(study, self.now, self.name, found.flown)
        if holding.searched(self.store):
            invalid: tuple[str, ...] = (SEARCHED,)
        else:
            failed = gates.failed_in(self.now, self.folder)
            invalid = (f"no score is valid: {failed}",) if failed else ()
        differed, broken = holding.differed_in(self.now), len(self.now.broken)
        return replace(Stale.of(found.why, again), differed=differed, invalid=invalid, broken=broken)

    @cached_property
    def latest(self) -> tuple[Outcome, ...]:
        """One outcome of each flight: the one that counts, else one that the study has outgrown."""
        return holding.latest_in(self.study, self.store)

    @cached_property
    def score(self) -> Score:
        """The campaign's score.

        Raises:
            InputError: it has no outcome that counts.
        """
        return score_of(self.rulings, self.study.roster, self.study.space, self.spending)

    @property
    def next_step(self) -> str:
        """What to do next, as every screen of the campaign says.

        Raises:
            InputError: it has no outcome that counts.
        """
        return next_step(self.score, self.study, self.name, self.stale.invalid)

    @cached_property
    def spending(self) -> Spending:
        """How alpha is spent on the campaign's mutants."""
        return Spending(self.study.alpha, holding.grown_in(self.store))

    @cached_property
    def platform(self) -> Mapping[str, str]:
        """On which most flights that count were flown, part by part; `other platforms` tells of the rest."""
        platform = next((one for one, _ in self._platforms.by_platform(self._counting)), self._platforms.own)
        return {**platform, **({"other platforms": self.mixture} if self.mixture else {})}

    @cached_property
    def mixture(self) -> str:
        """A sentence about the platforms of the flights that count; empty for one platform."""
        return self._platforms.mixture(self._counting)

    @cached_property
    def _platforms(self) -> Platforms:
        return Platforms(self.store)

    @cached_property
    def _counting(self) -> Sequence[FlownFlight]:
        """The flights that count; of those of one platform no more than one of each mutant in each situation."""
        flights = self.now.flights if self._platforms.several else self.now.one_each
        return [flight for flight in flights if self.now.stands(flight)]

    @cached_property
    def platform_warning(self) -> str:
        """What a reader must know of the platforms of the flights; empty when there is nothing, as for a record.

        Raises:
            InputError: there are no outcomes.
        """
        if not self._counting:
            holding.nothing_to_show(self.study, self.store, self.folder)
        return self.mixture if self.archive else warning_for(self._platforms, self._counting)

    @cached_property
    def choices(self) -> Sequence[holding.Remembered]:
        """How the campaign's situations were chosen."""
        return holding.remembered(self.store)

    def with_tracks(
        self, outcomes: Iterable[Outcome], wanted: Callable[[Outcome], bool] | None = None
    ) -> tuple[Outcome, ...]:
        """The same outcomes, those that are `wanted` (None: all) with tracks."""
        return with_tracks(self.study, self.store, outcomes, wanted)


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
        yield Snapshot(study, campaign, folder, store)
