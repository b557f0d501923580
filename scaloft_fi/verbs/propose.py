"""`scaloft-fi propose`: the requirement that is missing, for faults that leave a trace and violate none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import click

from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.campaign.processes import Start, cores, forked, one_thread_each
from scaloft_fi.campaign.progress import Progress, Silence
from scaloft_fi.campaign.runs.propose import Few, Found, Seeds, Sought, Tested, propose
from scaloft_fi.campaign.store.archive import flown_in, study_of
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.catalogue import select
from scaloft_fi.output import in_campaign, json_text, say, write_own
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study
from scaloft_fi.verbs import names, options
from scaloft_fi.verbs.options import CountOption, Option, Several, several, verb
from scaloft_fi.verbs.snapshot import Snapshot, snapshot
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table

KEPT, MOST_SITUATIONS = 10, 10**6
"""Seeds of the unmutated drone, of the choice and of the test each; no grid has more situations."""


class Size(NamedTuple):
    """Seeds of a mutant in each half, and the most situations in which it flies."""

    seeds: int = 3
    situations: int = 8


PROPOSE = Output("propose", "1.1", Found, rows="proposals")


def entry(proposal: Tested) -> str:
    """The entry for `sim/requirements.yaml`; a person decides whether it is a hazard."""
    made, alarms = proposal.requirement, proposal.alarms.short
    title, mutant = (json_text(text, letters=True) for text in (made.title, proposal.mutant))
    where = f"violated by {proposal.shown.short} of its fresh flights, {alarms} of the unmutated drone's"
    lines = [
        f"  {_key(proposal.mutant)}:",
        f"    title: {title}",
        "    kind: reported             # safety, once a person has decided that its violation is a hazard",
        *([f"    trigger: {made.trigger}"] if made.trigger else []),
        f"    formula: {made.text}",
        *([f"    unit: {made.unit}"] if made.unit else []),
        f"    source: {where}",
        f"    proposed_from: {mutant}   # a score that it decides says that it is selected",
    ]
    return "\n".join(lines) + "\n"


def _key(mutant: str) -> str:
    """A name for the requirement of a mutant."""
    return "P-" + "".join(letter if letter.isalnum() or letter in "-." else "-" for letter in mutant)


def sought_in(now: Snapshot, mutants: Sequence[str], most: int) -> list[Sought]:
    """The mutants, by default those that are put to the test and of which nothing was seen, where they change samples.

    Args:
        now: the campaign.
        mutants: ids or patterns.
        most: most situations of each; where there are more, as many are drawn.

    Raises:
        InputError: a mutant is unknown or was not flown, or there is none.
    """
    by_id: Mapping[str, MutantScore] = {one.id: one for one in now.score.mutants}
    if mutants:
        chosen = [mutant.id for mutant in select(mutants, now.study.matrix, now.study.catalogue)]
        for id_ in chosen:
            if id_ not in by_id:
                flies = f"`scaloft-fi run{in_campaign(flown_in(now.name))} --mutant {id_}`"
                raise InputError(f"{id_} has no flights in the campaign {now.name}; {flies}")
    else:
        chosen = [one.id for one in now.score.counted if one.tested and not one.detected and not one.seen_in]
    if not chosen:
        raise InputError(f"the campaign {now.name} has no fault that is put to the test and violates nothing")
    found = []
    for mutant in select(chosen, now.study.matrix, now.study.catalogue):
        keys = [result.situation for result in by_id[mutant.id].results if result.infected]
        found.append(Sought(mutant.id, mutant, drawn(mutant.id, keys, most)))
    return found


def drawn(subject: str, keys: Sequence[str], most: int) -> tuple[str, ...]:
    """At most so many of the situations, in their order; the same for the same subject."""
    kept = set(sorted(keys, key=lambda key: key_words("propose", subject, key))[:most])
    return tuple(key for key in keys if key in kept)


def fresh_seeds(now: Snapshot, count: int) -> Seeds:
    """The first seeds for the choice, and as many for the test that neither the choice nor the campaign flew.

    Args:
        now: the campaign.
        count: seeds of the mutants in each half.
    """
    first = max(KEPT, 1 + max(outcome.seed for outcome in now.outcomes))
    return Seeds(range(count), range(KEPT), range(first, first + count), range(first, first + KEPT))


def answer_of(found: Found) -> Answer:
    """The answer of the verb."""
    return Answer(PROPOSE, lambda: found, lambda: tables(found))


def tables(answer: Found) -> tuple[Table, ...]:
    """The proposals for people, the confirmed ones first, and what was not found."""
    rows = tuple(
        (
            one.mutant,
            one.requirement.title,
            one.shown.short,
            one.alarms.short,
            f"{one.p:.2g}{', not confirmed' if not one.confirmed else '' if one.firm else ', not firm'}",
            len(one.others),
        )
        for one in answer.tested
    )
    lists = (
        ("No requirement of the templates separates its flights", answer.apart),
        ("Every flight equals the unmutated drone's to the bit", answer.same),
        ("Too few flights leave a trace, so no requirement was sought", [_few(one) for one in answer.few]),
    )
    notes = (
        *(f"{words}: {', '.join(ids)}." for words, ids in lists if ids),
        "shown in: fresh flights of the mutant that violate it.  alarms: of the unmutated drone, in any situation.",
        "others: further faults that it shows.  `--output FILE` writes the entries for sim/requirements.yaml.",
        "A proposal is in no score: a person decides whether its violation is a hazard.",
    )
    head = ("mutant", "requirement", "shown in", "alarms", "p", "others")
    return (Table("Requirements that are missing", head, rows, notes),)


def _few(one: Few) -> str:
    more = f"`--seeds {one.seeds}`" if one.seeds <= KEPT else "a greater `--most`"
    return f"{one.mutant} ({one.traces.short}, {one.needed} needed; try {more})"


MissingMutants = Annotated[
    Several,
    Option(
        "Ids or patterns.",
        "",
        metavar="[ID|GLOB...]",
        complete=names.mutants,
        otherwise="every default that the campaign puts to the test and that violates no safety requirement",
    ),
]
SeedCount = Annotated[
    int,
    CountOption(
        "Seeds of each mutant for the choice, and as many fresh ones for the test.",
        "--seeds",
        type=click.IntRange(min=1, max=KEPT),
        default=3,
    ),
]
SituationCount = Annotated[
    int,
    CountOption(
        "Most situations in which a mutant flies, drawn from those where it changes samples.",
        "--most",
        type=click.IntRange(min=1, max=MOST_SITUATIONS),
        default=8,
    ),
]
Entries = Annotated[
    Path | None,
    Option("Also write the confirmed entries for sim/requirements.yaml into FILE.", "--output", metavar="FILE"),
]


@verb(
    "propose",
    sections={
        "Where": "--study --campaign",
        "How": "--seeds --most --jobs --untrusted",
        "What is printed": "--output --format --tables --quiet --help",
    },
)
def propose_command(
    *,
    mutants: MissingMutants = (),
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    seeds: SeedCount,
    most: SituationCount,
    jobs: options.Jobs,
    untrusted: options.Untrusted,
    output: Entries,
    quiet: options.Quiet,
) -> Answer:
    """Propose the requirement that is missing, for faults that are put to the test and violate none.

    The flights are flown again for their logs.  Limits are held against the mutant and the unmutated drone on the
    first seeds.  Limited are every signal, its mean over 1 s and 3 s, its time beyond a level, and its change within a
    second.  Each limit holds for the whole flight, near a surface, or while or after a definition of the study holds.
    The limit with the widest margin is tested on fresh seeds, by the score's own test, at the study's alpha over all
    that were chosen.

    Examples:
        Propose a requirement for each fault that violates none: `scaloft-fi propose`
        On more seeds, for all that an own campaign does not show: `scaloft-fi propose --campaign night --seeds 5`
        For one fault, and write the entry to paste: `scaloft-fi propose MORE-depth --output missing.yaml`
    """
    one_thread_each()
    options.check_writable(output, *options.ENTRIES, ".txt", what="YAML")
    study = study_of(study_folder, campaign)
    options.allow(study, untrusted=untrusted)
    asked, size = several(mutants, "mutants"), Size(seeds, most)
    told = proposed(study, campaign, asked, size, jobs or cores(), Silence() if quiet else Progress())
    if output is not None:
        write_own(output, "".join(entry(one) + "\n" for one in told.tested if one.confirmed).encode())
    return answer_of(told)


def proposed(
    study: Study,
    campaign: str,
    mutants: Sequence[str],
    size: Size,
    jobs: int,
    progress: Progress,
    start: Start = forked,
) -> Found:
    """Propose the requirements that are missing.

    Raises:
        InputError: a mutant is unknown or was not flown, there is none, or the study cannot be flown.
    """
    if study.command is not None:
        raise InputError("a simulator that a command starts writes records; `propose` reads logs of the built-in one")
    with snapshot(study, campaign) as now:
        for warning in now.stale.invalid:
            say(f"warning: {warning}")
        sought, planned, study = sought_in(now, mutants, size.situations), fresh_seeds(now, size.seeds), now.study
    try:
        return propose(study, sought, planned, jobs, progress, start)
    finally:
        progress.close()
