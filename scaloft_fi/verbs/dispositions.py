"""`scaloft-fi dispositions`: the survivors of a campaign beside those that were accepted."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import Judged, Standing, judge
from scaloft_fi.console import say
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.errors import ExitCode, InputError
from scaloft_fi.study import Study, append_drafts
from scaloft_fi.verbs.options import Campaign, Option, StudyFolder, TableFormat, Today, answer, check_own
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.verbs.verb import verb
from scaloft_fi.verbs.verdict import NO_POOL, in_campaign, next_find
from scaloft_fi.views.output import Answer, Output, flag, listing, optional, record, text, texts
from scaloft_fi.views.table import Table

if TYPE_CHECKING:
    from scaloft_fi.views.output import Columns


_NOBODY = "nobody has accepted it"
DISPOSITIONS = Output(
    "dispositions",
    "1.0",
    "the survivors of a campaign beside those that somebody accepted",
    {
        "survivors": listing(
            "every survivor and every disposition, survivors first",
            record(
                "one mutant",
                {
                    "mutant": text("id of the mutant"),
                    "state": text("how it stands", [state.value for state in Standing]),
                    "fails": flag("whether `score --ratchet` does not pass because of it"),
                    "verdict": optional(text("on the mutant", [verdict.value for verdict in Verdict]), "not flown"),
                    "survives_in": texts("keys of the situations that put it to the test, where it survives"),
                    "owner": optional(text("who accepted it"), _NOBODY),
                    "reason": optional(text("why"), _NOBODY),
                    "expires": optional({**text("last day of the acceptance"), "format": "date"}, _NOBODY),
                    "accepted_in": texts("keys of the situations for which it is accepted; empty for all"),
                    "has_find": flag("whether a search found a situation that shows it and is still to be flown"),
                },
            ),
        )
    },
    rows="survivors",
)


def verdict_words(judged: Judged) -> str:
    """The verdict on a survivor as people read it."""
    return judged.verdict.words if judged.verdict else "not flown"


def complaint(judged: Judged) -> str:
    """The sentence of one that does not pass, or can go.

    >>> from scaloft_fi.analysis.detection import Verdict
    >>> complaint(Judged("LATE-human@3s", Standing.OPEN, ("D0H1",), verdict=Verdict.NOT_DETECTED))
    'LATE-human@3s is not detected (tested in D0H1) and not accepted'
    """
    known = judged.disposition
    if known is None:
        some = ", ".join(judged.surviving[:3]) + " and more" * (len(judged.surviving) > 3)
        return f"{judged.mutant} is {verdict_words(judged)}{f' (tested in {some})' if some else ''} and not accepted"
    if judged.state is Standing.STALE:
        return f"{judged.mutant} is detected now; its disposition can go ({known.place})"
    if judged.state is Standing.EXPIRED:
        return f"{judged.mutant}: its disposition expired on {known.expires.isoformat()} ({known.place})"
    new = [key for key in judged.surviving if key not in known.situations]
    return f"{judged.mutant} survives in {', '.join(new)}, which its disposition does not name ({known.place})"


def disposition_table(judged: Sequence[Judged], found: Collection[str] = (), campaign: str = CAMPAIGN) -> Table:
    """Every survivor and every disposition, a row each.

    Args:
        judged: how they stand.
        found: mutants for which a find is to be flown next.
        campaign: name of the campaign, for commands.
    """
    rows = tuple(
        (
            entry.mutant,
            entry.state.value,
            verdict_words(entry),
            len(entry.surviving),
            entry.disposition.owner if entry.disposition else "",
            entry.disposition.reason if entry.disposition else "",
            entry.disposition.expires.isoformat() if entry.disposition else "",
            " ".join(entry.disposition.situations) if entry.disposition else "",
        )
        for entry in judged
    )
    headers = ("mutant", "state", "verdict", "survives in", "owner", "reason", "expires", "accepted in")
    notes: tuple[str, ...] = (
        "Survivors are the default mutants put to the test that are not detected, undecided ones too.",
        "open, uncovered and expired fail `score --ratchet`; stale: detected now, the disposition can go.",
    )
    if to_fly := [entry.mutant for entry in judged if entry.mutant in found]:
        command = f"`scaloft-fi kills{in_campaign(campaign)} --show survivors`"
        notes += (f"A search found situations that show {', '.join(to_fly)}; {command} says how to fly them.",)
    return Table("Survivors and dispositions", headers, rows, notes)


def disposition_values(judged: Sequence[Judged], found: Collection[str] = ()) -> dict[str, Any]:
    """Plain JSON values of the form `DISPOSITIONS`; `found` as of `disposition_table`."""
    return {"survivors": [_values(entry, entry.mutant in found) for entry in judged]}


def _values(entry: Judged, found: bool) -> dict[str, Any]:
    known = entry.disposition
    return {
        "mutant": entry.mutant,
        "state": entry.state.value,
        "fails": entry.state.fails,
        "verdict": entry.verdict.value if entry.verdict else None,
        "survives_in": list(entry.surviving),
        "owner": known.owner if known else None,
        "reason": known.reason if known else None,
        "expires": known.expires.isoformat() if known else None,
        "accepted_in": list(known.situations) if known else [],
        "has_find": found,
    }


def dispositions(study: Study, campaign: str, *, today: Today = None) -> Answer:
    """The survivors of a campaign beside those that somebody accepted.

    Raises:
        InputError: there is no such campaign, it holds no flight that counts, or no baseline pool to decide by.
    """
    with snapshot(study, campaign) as now:
        finds, score = now.study.finds, now.score
        judged, campaign = judged_survivors(now.study, score, today), now.name
    found = [mutant.subject.id for mutant in score.mutants if next_find(mutant, finds)]
    return Answer(
        DISPOSITIONS,
        lambda: disposition_values(judged, found),
        lambda: (disposition_table(judged, found, campaign),),
        warnings=finds.warnings,
    )


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
    for entry in judged:
        if entry.state is Standing.STALE:
            say(f"warning: {complaint(entry)}")
    failing = [entry for entry in judged if entry.state.fails]
    for entry in failing:
        say(f"ratchet: {complaint(entry)}")
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
    counted = f"{len(opened)} survivor{'s' * (len(opened) != 1)}"
    say(f"{path}: {counted} to decide on; fill in owner, reason and expires")
