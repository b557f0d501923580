"""`scaloft-fi status`: what a campaign holds."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from scaloft_fi.campaign.store.archive import MANIFEST
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.status import Status, baseline_status, flights_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.export.rows import WAITING, ordered
from scaloft_fi.verbs.options import answer, campaign_option, format_option, study_option, tables_option
from scaloft_fi.verbs.snapshot import Snapshot, snapshot
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output, by_name, count, listing, optional, record, text
from scaloft_fi.views.table import Table

_WORDS = {WAITING: "waiting for their baseline"}
BASELINE_STATUSES = ("held", "violated", Status.INVALID.value)

STATUS = Output(
    "status",
    "1.1",
    "how many flights a campaign holds, by status",
    {
        "campaign": text("folder of the campaign"),
        "archive": optional(text("SHA-256 of its `campaign.json`, which lists every other file's"), "it is no archive"),
        "platform": by_name("on which most flights were flown, part by part", {"type": "string"}),
        "grid": text("name of the grid that was flown"),
        "counted": count("flights that count"),
        "owed": count("flights that are planned and not flown"),
        "stale": count("stored outcomes that do not count any more"),
        "flown_again": count("of these, those whose flight was flown again since"),
        "command": optional(text("what flies the others again"), "there are none that the study still has"),
        "subjects": count("subjects flown: the baseline, PLACEBO, mutants"),
        "situations": count("situations flown"),
        "platforms": optional(text("how the flights divide over platforms"), "all of one platform"),
        "statuses": listing(
            "the flights that count, by status",
            record(
                "flights of one status",
                {
                    "subject": text(
                        "whose flights: of the unmutated drone, or of mutants and PLACEBO", ("baseline", "mutants")
                    ),
                    "status": text(
                        "of each flight: what it shows, or `waiting` for its baseline",
                        dict.fromkeys((*BASELINE_STATUSES, *(status.value for status in Status), WAITING)),
                    ),
                    "flights": count("how many"),
                },
            ),
        ),
        "reasons": listing(
            "why flights are stale",
            record("one reason", {"why": text("the reason, in a sentence"), "flights": count("how many")}),
        ),
    },
    rows="statuses",
)


def status_values(now: Snapshot) -> dict[str, Any]:
    """Plain JSON values of the form `STATUS`."""
    held = now.held
    flown = ordered(held.current, now.study.roster, now.study.space)
    clean = [outcome for outcome in flown if outcome.mutant == BASELINE]
    home = {(outcome.situation, outcome.seed) for outcome in clean}
    baselines = Counter(map(baseline_status, clean))
    mutants = Counter(
        flight.status.value if (flight.outcome.situation, flight.outcome.seed) in home else WAITING
        for flight in flights_of(flown)
    )
    return {
        "campaign": str(held.folder),
        "archive": now.archive.digest if now.archive else None,
        "platform": dict(now.platform),
        "grid": now.study.grid.name,
        "counted": len(flown),
        "owed": held.owed,
        "stale": held.stale,
        "flown_again": held.flown_again,
        "command": now.stale.command or None,
        "subjects": len({outcome.mutant for outcome in flown}),
        "situations": len({outcome.situation for outcome in flown}),
        "platforms": now.mixture or None,
        "statuses": [
            {"subject": subject, "status": status, "flights": flights}
            for subject, counted in (("baseline", baselines), ("mutants", mutants))
            for status, flights in counted.items()
        ],
        "reasons": [{"why": why, "flights": flights} for why, flights in held.why.items()],
    }


def status_tables(values: dict[str, Any]) -> tuple[Table, ...]:
    """The same for people."""
    flights = [
        (f"{BASELINE} {one['status']}" if one["subject"] == "baseline" else _word(one["status"]), one["flights"])
        for one in values["statuses"]
    ]
    mixture = values["platforms"] or ""
    table = Table(
        f"Campaign {values['campaign']}",
        ("flights", "number"),
        (
            *flights,
            ("all", values["counted"]),
            ("planned, not flown", values["owed"]),
            ("stale, not counted", values["stale"]),
            *([("flown again since", values["flown_again"])] if values["flown_again"] else []),
        ),
        (
            f"{values['subjects']} subjects in {values['situations']} situations.",
            *([f"{mixture[:1].upper()}{mixture[1:]}."] if mixture else []),
            *_of_archive(values),
        ),
    )
    reasons = tuple((one["why"], one["flights"]) for one in values["reasons"])
    again = f"`{values['command']}` flies them again; no flight log is kept from which they could be judged anew."
    notes = (again,) if values["command"] else ()
    stale = Table("Stale flights", ("why", "number"), reasons, notes)
    return (table, stale) if values["stale"] else (table,)


def _of_archive(values: dict[str, Any]) -> tuple[str, ...]:
    """What is cited of an archive, and what flew it."""
    if values["archive"] is None:
        return ()
    flown = ", ".join(f"{name} {version}" for name, version in sorted(values["platform"].items()))
    return (
        f"An archive, whose flights count as they stand; SHA-256 of its {MANIFEST}: {values['archive']}.",
        f"Flown on {flown}.",
    )


def _word(status: str) -> str:
    return _WORDS.get(status, status)


def status(study: Study, campaign: str) -> Answer:
    """How many flights a campaign holds, by status, and why those are stale that do not count any more.

    Raises:
        InputError: there is no such campaign.
    """
    with snapshot(study, campaign) as now:
        values = status_values(now)
    return Answer(STATUS, lambda: values, lambda: status_tables(values))


@verb(
    "status",
    examples=(
        ("Count the flights of the campaign, and say why some are stale", "scaloft-fi status"),
        ("Look at another campaign", "scaloft-fi status --campaign night"),
        ("Let a script read it", "scaloft-fi status --format json"),
    ),
)
@study_option
@campaign_option
@format_option
@tables_option
def status_command(study_folder: Path | None, campaign: str, style: str, tables_folder: Path | None) -> None:
    """Print how many flights a campaign holds, by status, and why those are stale that do not count any more."""
    answer(status(Study.open(study_folder), campaign), style, tables_folder)
