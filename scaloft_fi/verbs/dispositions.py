"""`scaloft-fi dispositions`: the survivors of a campaign beside those that were accepted."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import Judged, Standing, judge
from scaloft_fi.console import say
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.errors import ExitCode, InputError
from scaloft_fi.study import Study, append_drafts
from scaloft_fi.verbs.options import Campaign, Option, StudyFolder, TableFormat, Today, answer, check_own, verb
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.verbs.verdict import NO_POOL, in_campaign, next_find
from scaloft_fi.views.output import Answer, Columns, Output
from scaloft_fi.views.table import Table, counted, said


@dataclass(frozen=True)
class JudgedSurvivor:
    """One mutant.

    Attributes:
        mutant: id of the mutant.
        state: how it stands.
        fails: whether `score --ratchet` does not pass because of it.
        verdict: on the mutant; null: not flown.
        survives_in: keys of the situations that put it to the test, where it survives.
        owner: who accepted it; null: nobody has accepted it.
        reason: why; null: nobody has accepted it.
        expires: last day of the acceptance; null: nobody has accepted it.
        accepted_in: keys of the situations for which it is accepted; empty for all.
        has_find: whether a search found a situation that shows it and is still to be flown.
    """

    mutant: str
    state: Standing
    fails: bool
    verdict: Verdict | None
    survives_in: tuple[str, ...]
    owner: str | None
    reason: str | None
    expires: date | None
    accepted_in: tuple[str, ...]
    has_find: bool

    @classmethod
    def of(cls, one: Judged, *, has_find: bool) -> JudgedSurvivor:
        """What is told of a survivor."""
        known = one.disposition
        return cls(
            mutant=one.mutant,
            state=one.state,
            fails=one.state.fails,
            verdict=one.verdict,
            survives_in=one.surviving,
            owner=known.owner if known else None,
            reason=known.reason if known else None,
            expires=known.expires if known else None,
            accepted_in=known.situations if known else (),
            has_find=has_find,
        )


@dataclass(frozen=True)
class Dispositions:
    """The survivors of a campaign beside those that somebody accepted.

    Attributes:
        survivors: every survivor and every disposition, survivors first.
    """

    survivors: tuple[JudgedSurvivor, ...]


DISPOSITIONS = Output("dispositions", "1.0", Dispositions, rows="survivors")


def _words(verdict: Verdict | None) -> str:
    return verdict.words if verdict else "not flown"


def complaint(judged: Judged) -> str:
    """The sentence of one that does not pass, or can go.

    >>> from scaloft_fi.analysis.detection import Verdict
    >>> complaint(Judged("LATE-human@3s", Standing.OPEN, ("D0H1",), verdict=Verdict.NOT_DETECTED))
    'LATE-human@3s is not detected (tested in D0H1) and not accepted'
    """
    known = judged.disposition
    if known is None:
        some = ", ".join(judged.surviving[:3]) + " and more" * (len(judged.surviving) > 3)
        return f"{judged.mutant} is {_words(judged.verdict)}{f' (tested in {some})' if some else ''} and not accepted"
    if judged.state is Standing.STALE:
        return f"{judged.mutant} is detected now; its disposition can go ({known.place})"
    if judged.state is Standing.EXPIRED:
        return f"{judged.mutant}: its disposition expired on {known.expires.isoformat()} ({known.place})"
    new = [key for key in judged.surviving if key not in known.situations]
    return f"{judged.mutant} survives in {', '.join(new)}, which its disposition does not name ({known.place})"


def disposition_table(told: Dispositions, campaign: str = CAMPAIGN) -> Table:
    """Every survivor and every disposition, a row each; `campaign` is its name, for commands."""
    rows = tuple(
        (
            one.mutant,
            one.state.value,
            _words(one.verdict),
            len(one.survives_in),
            one.owner or "",
            one.reason or "",
            one.expires.isoformat() if one.expires else "",
            " ".join(one.accepted_in),
        )
        for one in told.survivors
    )
    headers = ("mutant", "state", "verdict", "survives in", "owner", "reason", "expires", "accepted in")
    notes: tuple[str, ...] = (
        "Survivors are the default mutants put to the test that are not detected, undecided ones too.",
        "open, uncovered and expired fail `score --ratchet`; stale: detected now, the disposition can go.",
    )
    if to_fly := [one.mutant for one in told.survivors if one.has_find]:
        command = f"`scaloft-fi kills{in_campaign(campaign)} --show survivors`"
        notes += (f"A search found situations that show {', '.join(to_fly)}; {command} says how to fly them.",)
    return Table("Survivors and dispositions", headers, rows, notes)


def dispositions(study: Study, campaign: str, *, today: Today = None) -> Answer:
    """The survivors of a campaign beside those that somebody accepted.

    Raises:
        InputError: there is no such campaign, it holds no flight that counts, or no baseline pool to decide by.
    """
    with snapshot(study, campaign) as now:
        finds, score = now.study.finds, now.score
        judged, campaign = judged_survivors(now.study, score, today), now.name
    found = {mutant.subject.id for mutant in score.mutants if next_find(mutant, finds)}
    told = Dispositions(tuple(JudgedSurvivor.of(one, has_find=one.mutant in found) for one in judged))
    table = said(disposition_table(told, campaign), of_tests=score.of_tests)
    return Answer(DISPOSITIONS, lambda: told, lambda: (table,), warnings=finds.warnings)


def judged_survivors(study: Study, scored: Score, today: date | None = None) -> tuple[Judged, ...]:
    """The survivors and the dispositions; `today` as of `dispositions`.

    Raises:
        InputError: there is no pool; without one nobody knows what survives.
    """
    if not scored.pooled:
        raise InputError(f"no mutant is known to survive: {NO_POOL}")
    return judge(scored, study.roster, study.dispositions, today or date.today())  # noqa: DTZ011 - the user's own day


@verb(
    "dispositions",
    examples=(
        ("List what survives, and what was accepted", "scaloft-fi dispositions"),
        ("Draft an entry for each open survivor", "scaloft-fi dispositions --write"),
        ("See what will have expired by a day", "scaloft-fi dispositions --today 2027-01-31"),
    ),
)
def dispositions_command(
    *,
    study_folder: StudyFolder,
    campaign: Campaign,
    writing: Annotated[
        bool,
        Option(
            "Append every survivor that is not accepted to the study's hazop/dispositions.yaml, with owner, reason and "
            "expiry left empty: the file is refused until somebody has filled them in.",
            "--write",
        ),
    ],
    today: Today,
    style: TableFormat,
) -> None:
    """List the survivors of a campaign beside the study's dispositions.

    `scaloft-fi score --ratchet` makes a gate of it.
    """
    study = Study.open(study_folder)
    if writing:
        check_own(study, study_folder, study.dispositions_path)
    told = dispositions(study, campaign, today=today)
    answer(told, style)
    if writing:
        _draft(study.dispositions_path, told["survivors"])


def ratchet(study: Study, scored: Score, today: date | None) -> int:
    """Say on standard error what does not pass and what can go; returns the exit code.

    Raises:
        InputError: there is no baseline pool to decide by.
    """
    judged = judged_survivors(study, scored, today)
    stale = [entry for entry in judged if entry.state is Standing.STALE]
    failing = [entry for entry in judged if entry.state.fails]
    for sign, entries in (("warning", stale), ("ratchet", failing)):
        for entry in entries:
            say(f"{sign}: {complaint(entry)}")
    if not scored.tested.part:
        say("ratchet: no counted mutant was put to the test; there is nothing to hold")
    return ExitCode.BELOW if failing or not scored.tested.part else ExitCode.DONE


def _draft(path: Path, survivors: Columns) -> None:
    """Append an entry for each survivor that nobody has accepted, and say so."""
    opened = list(survivors["mutant"][survivors["state"] == Standing.OPEN])
    if not opened:
        say("nothing to write: no survivor without a disposition")
        return
    append_drafts(path, opened)
    say(f"{path}: {counted(len(opened), 'survivor')} to decide on; fill in owner, reason and expires")
