"""Dispositions: survivors that somebody looked at and accepted, and the ratchet that holds a campaign against them.

A survivor is a mutant that the ratios count and that is not detected, or undecided: what is not decided is not shown.
A file of decisions instead of a percentage: a score may fall without notice when mutants are added, a survivor that
nobody has accepted may not.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from datetime import date
from enum import StrEnum
from pathlib import Path

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.analysis.scoring.mutant_score import MutantScore
from scaloft_fi.analysis.scoring.score import Score
from scaloft_fi.document import Item, load
from scaloft_fi.errors import InputError, did_you_mean
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.derive import realise

HEADER = """\
# Survivors that were looked at and accepted; `scaloft-fi score --ratchet` fails on any other.
# Each says who answers for it (owner), why it may survive (reason) and until which day that holds (expires);
# `situations`, if given, limits it to those: a survival elsewhere is to be looked at again.
"""


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

    def __str__(self) -> str:
        """In a sentence."""
        where = f" in {', '.join(self.situations)}" if self.situations else ""
        return f"accepted{where} by {self.owner} until {self.expires.isoformat()}: {self.reason}"


class State(StrEnum):
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
        return self in (State.OPEN, State.UNCOVERED, State.EXPIRED)


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
    state: State
    surviving: tuple[str, ...] = ()
    disposition: Disposition | None = None
    verdict: Verdict | None = None

    @property
    def words(self) -> str:
        """The verdict as people read it."""
        return self.verdict.words if self.verdict else "not flown"


def load_dispositions(path: Path, matrix: Matrix, situations: Collection[str]) -> tuple[Disposition, ...]:
    """The dispositions of a study; none where it has no such file.

    Args:
        path: `hazop/dispositions.yaml`.
        matrix: of the study.
        situations: keys of its grid.

    Raises:
        InputError: naming the place of a mutant, a situation or a date that does not exist, of a key that is missing,
            empty or unknown, of a mutant that stands twice.
    """
    if not path.exists():
        return ()
    found: dict[str, Disposition] = {}
    for name, item in load(path).mapping().items():
        disposition = _disposition(name, item, matrix, situations)
        if disposition.mutant in found:
            first = found[disposition.mutant].place
            raise InputError(
                f"{item.place}: mutant {name!r} is {disposition.mutant!r}, which stands at {first} already"
            )
        found[disposition.mutant] = disposition
    return tuple(found.values())


def _disposition(name: str, item: Item, matrix: Matrix, situations: Collection[str]) -> Disposition:
    try:
        mutant = realise(matrix, name)
    except InputError as error:
        raise InputError(f"{item.place}: {error}") from None
    item.need("status").choice(("accepted",))
    only = item.get("situations")
    keys = tuple(_situation(entry, situations) for entry in only.items()) if only else ()
    if only is not None and not keys:
        raise only.error("a list of at least one, or left out")
    disposition = Disposition(
        mutant=mutant.id,
        owner=item.need("owner").text(),
        reason=item.need("reason").text(),
        expires=_date(item.need("expires")),
        situations=keys,
        place=item.place,
    )
    item.close()
    return disposition


def _situation(item: Item, situations: Collection[str]) -> str:
    if item.value not in situations:
        raise InputError(f"{item.place}: no situation {item.value!r}{did_you_mean(str(item.value), situations)}")
    return str(item.value)


def _date(item: Item) -> date:
    found = parse_date(str(item.value))
    if found is None:
        raise item.error("a date such as 2027-01-31")
    return found


def parse_date(text: str) -> date | None:
    """A date as ISO 8601 writes it, YYYY-MM-DD; None for anything else.

    >>> parse_date("2027-01-31"), parse_date("2027-02-30"), parse_date("20270131")
    (datetime.date(2027, 1, 31), None, None)
    """
    if not re.fullmatch(r"\d{4}-\d{2}-\d{2}", text):
        return None
    try:
        return date.fromisoformat(text)
    except ValueError:
        return None


def survives(mutant: MutantScore) -> bool:
    """Whether it is not detected though it was put to the test, or undecided."""
    return mutant.verdict in (Verdict.NOT_DETECTED, Verdict.UNDECIDED)


def judge(
    scored: Score, roster: Roster, dispositions: Iterable[Disposition], today: date | None = None
) -> tuple[Judged, ...]:
    """Every counted survivor and every disposition, survivors first in the canonical order.

    Args:
        scored: of a campaign.
        roster: tells which mutants count.
        dispositions: of the study.
        today: by which expiry is judged; None = nothing expires.
    """
    known = {disposition.mutant: disposition for disposition in dispositions}
    flown = {mutant.subject.id: mutant for mutant in scored.mutants}
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject) and survives(mutant)]
    names = dict.fromkeys([*(mutant.subject.id for mutant in counted), *sorted(known, key=roster.rank)])
    return tuple(_judged(name, flown.get(name), known.get(name), today) for name in names)


def _judged(name: str, mutant: MutantScore | None, known: Disposition | None, today: date | None) -> Judged:
    surviving = tuple(r.situation for r in mutant.results if r.tested and not r.kills) if mutant else ()
    if known is None:
        state = State.OPEN
    elif mutant is not None and mutant.detected:
        state = State.STALE
    elif today is not None and today > known.expires:
        state = State.EXPIRED
    elif mutant is None or not survives(mutant):
        state = State.UNTESTED
    elif known.situations and set(surviving) - set(known.situations):
        state = State.UNCOVERED
    else:
        state = State.ACCEPTED
    return Judged(name, state, surviving, known, mutant.verdict if mutant else None)


def told(judged: Judged) -> str:
    """The sentence of one that does not pass, or can go.

    >>> told(Judged("LATE-human@3s", State.OPEN, ("D0H1",), verdict=Verdict.NOT_DETECTED))
    'LATE-human@3s is not detected (tested in D0H1) and not accepted'
    """
    known = judged.disposition
    if known is None:
        some = ", ".join(judged.surviving[:3]) + " and more" * (len(judged.surviving) > 3)
        return f"{judged.mutant} is {judged.words}{f' (tested in {some})' if some else ''} and not accepted"
    if judged.state is State.STALE:
        return f"{judged.mutant} is detected now; its disposition can go ({known.place})"
    if judged.state is State.EXPIRED:
        return f"{judged.mutant}: its disposition expired on {known.expires.isoformat()} ({known.place})"
    new = [key for key in judged.surviving if key not in known.situations]
    return f"{judged.mutant} survives in {', '.join(new)}, which its disposition does not name ({known.place})"


def draft(judged: Sequence[Judged]) -> str:
    """YAML to append for the survivors that are not accepted.

    What a person has to decide is left empty, so that the file is refused until somebody has.
    """
    return "".join(
        f'\n{entry.mutant}:\n  status: accepted\n  owner: ""\n  reason: ""\n  expires: ""\n'
        for entry in judged
        if entry.state is State.OPEN
    )
