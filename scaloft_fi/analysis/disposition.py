"""Dispositions: survivors that somebody looked at and accepted, and the ratchet that holds a campaign against them.

A survivor is a mutant that the ratios count and that is not detected, or undecided: what is not decided is not shown.
A file of decisions instead of a percentage: a score may fall without notice when mutants are added, a survivor that
nobody has accepted may not.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import date
from enum import StrEnum
from typing import NamedTuple

from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.analysis.scoring.mutant_score import MutantScore
from scaloft_fi.analysis.scoring.score import Score


@dataclass(frozen=True)
class Disposition:
    """An accepted survivor.

    Attributes:
        mutant: canonical id.
        owner: who answers for it.
        reason: why it may survive.
        expires: the last day on which it holds.
        situations: keys of those where it may survive; empty = in all.
        place: file:line.
    """

    mutant: str
    owner: str
    reason: str
    expires: date
    situations: tuple[str, ...] = ()
    place: str = field(default="", compare=False)


class Standing(StrEnum):
    """How a survivor, or a disposition, stands."""

    ACCEPTED = "accepted"
    OPEN = "open"
    """It survives and nobody accepted that."""
    UNCOVERED = "uncovered"
    """It survives in a situation that its disposition does not name."""
    EXPIRED = "expired"
    """The day of its disposition has passed."""
    STALE = "stale"
    """It is detected now: the disposition can go."""
    UNTESTED = "untested"
    """Accepted, but not put to the test."""

    @property
    def fails(self) -> bool:
        """Whether the ratchet does not let it pass."""
        return self in (Standing.OPEN, Standing.UNCOVERED, Standing.EXPIRED)


@dataclass(frozen=True)
class Judged:
    """A survivor beside its disposition.

    Attributes:
        mutant: canonical id.
        state: how it stands.
        surviving: keys of the situations that put it to the test, where it survives.
        disposition: None where there is none.
        verdict: on the mutant; None where it was not flown.
    """

    mutant: str
    state: Standing
    surviving: tuple[str, ...] = ()
    disposition: Disposition | None = None
    verdict: Verdict | None = None


class Accepted(NamedTuple):
    """A survivor that somebody accepted: its canonical id, and who, why and until when."""

    mutant: str
    disposition: Disposition


def survives(mutant: MutantScore) -> bool:
    """Whether it is not detected though it was put to the test, or undecided."""
    return mutant.verdict in (Verdict.NOT_DETECTED, Verdict.UNDECIDED)


def judge(
    scored: Score, roster: Roster, dispositions: Iterable[Disposition], today: date | None = None
) -> tuple[Judged, ...]:
    """Every counted survivor and every disposition, survivors first in the canonical order.

    Args:
        scored: of a campaign.
        roster: says which mutants count.
        dispositions: of the study.
        today: by which expiry is judged; None = nothing expires.
    """
    known = {disposition.mutant: disposition for disposition in dispositions}
    flown = {mutant.subject.id: mutant for mutant in scored.mutants}
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject) and survives(mutant)]
    names = dict.fromkeys([*(mutant.subject.id for mutant in counted), *sorted(known, key=roster.rank)])
    return tuple(_judged(name, flown.get(name), known.get(name), today) for name in names)


def accepted_survivors(
    scored: Score, roster: Roster, dispositions: Iterable[Disposition], today: date | None = None
) -> tuple[Accepted, ...]:
    """The survivors that the score counts and somebody accepted, in the canonical order; the arguments of `judge`.

    Without a pool nobody knows what survives, so there are none.
    """
    if not scored.pooled:
        return ()
    counted = {mutant.subject.id for mutant in scored.counted}
    return tuple(
        Accepted(one.mutant, one.disposition)
        for one in judge(scored, roster, dispositions, today)
        if one.disposition is not None and one.state is Standing.ACCEPTED and one.mutant in counted
    )


def score_without(scored: Score, accepted: Sequence[Accepted]) -> Ratio:
    """Mutants detected, of those that `mutation_score` counts and nobody accepted as survivors."""
    return Ratio(scored.mutation_score.part, scored.mutation_score.whole - len(accepted))


def _judged(name: str, mutant: MutantScore | None, known: Disposition | None, today: date | None) -> Judged:
    surviving = tuple(r.situation for r in mutant.results if r.tested and not r.kills) if mutant else ()
    if known is None:
        state = Standing.OPEN
    elif mutant is not None and mutant.detected:
        state = Standing.STALE
    elif today is not None and today > known.expires:
        state = Standing.EXPIRED
    elif mutant is None or not survives(mutant):
        state = Standing.UNTESTED
    elif known.situations and set(surviving) - set(known.situations):
        state = Standing.UNCOVERED
    else:
        state = Standing.ACCEPTED
    return Judged(name, state, surviving, known, mutant.verdict if mutant else None)
