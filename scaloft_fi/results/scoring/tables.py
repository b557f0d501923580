"""The tables of a campaign: ratios, mutants, rungs, the baseline's findings, coverage, groupings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from scaloft_fi.results.outcome import PLACEBO, Outcome
from scaloft_fi.results.requirement import Verdict
from scaloft_fi.results.roster import Roster
from scaloft_fi.results.rulings import Rulings, rulings_of
from scaloft_fi.results.scoring.baseline import Finding, Tally, findings, tallies
from scaloft_fi.results.scoring.decision import Decision
from scaloft_fi.results.scoring.grouping import By, groups
from scaloft_fi.results.scoring.ratio import Ratio
from scaloft_fi.results.scoring.redraw import NO_PAIRS
from scaloft_fi.results.scoring.score import MutantScore, Score, score_of
from scaloft_fi.results.situations.coverage import Coverage, coverage_of
from scaloft_fi.results.space import Space
from scaloft_fi.results.status import Status
from scaloft_fi.results.telling.table import Table

ONE_SEED = "One seed: one flight per mutant and situation decides nothing statistically; fly more with --seeds."
SHORT = 24
"""Longest condition that the mutants' table shows."""
MANY = 24
"""Of more mutants than these the flights at each rung are summed by parameter."""
FLOWN = "Flown: killed of all situations flown.  First: the earliest kill, in seconds from take-off, of all flights."
"""What two columns of the mutants' table say."""
INTERVALS = "In brackets Wilson's 95 % interval [%] over the row's population; 0/0 is n/a."
MUTANTS = "Mutants"
DECIDED = (
    "Decided: situations killed + survived, ? undecided. Killed: a safety requirement is violated more often than by"
    " the pool of baselines (Fisher, one-sided; Holm over the mutant's situations and requirements; a third of 5 % at"
    " each of 3, 5 and 10 flights) and by at least 0.2. Survived: a fault that shows in half of its flights would have"
    " shown more often (5 %; no kill of 5, at most 1 of 10). Kill rates count what was seen."
)


def score_tables(outcomes: Iterable[Outcome], roster: Roster, space: Space, by: By | None = None) -> tuple[Table, ...]:
    """All tables that `run` and `score` print; `by` adds the score part by part."""
    rulings = rulings_of(outcomes)
    return tables_of(score_of(rulings, roster, space), rulings, roster, space, by)


def tables_of(scored: Score, rulings: Rulings, roster: Roster, space: Space, by: By | None = None) -> tuple[Table, ...]:
    """The same of rulings that were scored already."""
    clean, draws = rulings.baselines, rulings.draws
    seeds = len({seed for _, seed in draws})
    where = {m.subject.id: m.condition(space) for m in (*scored.mutants, *scored.controls)}
    tables = [ratio_table(scored, seeds), redraw_table(scored), mutant_table(scored.mutants, where, seeds)]
    if scored.controls:
        tables.append(mutant_table(scored.controls, where, seeds, "Controls (in no ratio)"))
    tables += condition_tables(where)
    tables.append(rung_table(scored))
    if by is not None:
        tables.append(group_table(scored, by, roster, space))
    tables += [
        baseline_table(findings(clean, space)),
        requirement_table(tallies(clean)),
        coverage_table(coverage_of(clean, draws, space)),
    ]
    return tuple(tables)


def ratio_table(scored: Score, seeds: int) -> Table:
    """The ratios of the score, each with its population."""
    rows = (
        ("exercised", str(scored.exercised), "credible cells whose default mutant was flown, of all credible cells"),
        ("infected", str(scored.infected), "default mutants that changed a sample, of those flown"),
        (
            "mutation score",
            str(scored.mutation_score),
            "default mutants killed, of those infected in an eligible situation",
        ),
        ("strict score", str(scored.strict_score), "default mutants killed, of those flown"),
        (
            "decided score",
            str(scored.decided_score),
            "default mutants that repeated flights decide are killed, of those flown often enough to tell",
        ),
        ("operability", str(scored.operability), "default mutants that break operability, of those put to that test"),
    )
    return Table("Mutation score", ("ratio", "part/whole", "population"), rows, _notes(seeds))


def redraw_table(scored: Score) -> Table:
    """How many of the kills may be false, measured on the baselines."""
    measured, expected = scored.redraw, scored.false_kills
    rate, blocks = measured.rate, measured.decided
    percent = "n/a" if rate.value is None else f"{100 * rate.value:.2g} %"
    rows = [
        (
            "false-kill rate",
            f"{rate.part}/{rate.whole} = {percent}",
            "ordered pairs of baseline seeds of one situation, the second killed as a mutant of the first",
        )
    ]
    if expected:
        flights = "eligible flights of the default mutants, if each redrew all noise"
        rows.append(("false kills expected", f"{expected[0]:.2g} of {expected[1]}", flights))
    if blocks.whole:
        what = f"blocks of {measured.left_out} seeds, decided as killed anywhere beside the others"
        rows.append(("false decisions", blocks.plain, what))
    notes = () if measured.pairs else (f"Not measured: {NO_PAIRS}; fly more with --seeds.",)
    return Table("False kills (REDRAW)", ("figure", "part/whole", "population"), tuple(rows), notes)


def mutant_table(mutants: Sequence[MutantScore], where: Mapping[str, str], seeds: int, title: str = MUTANTS) -> Table:
    """Per mutant its kills of the eligible and of all flown situations, by what, how early, where; killed first."""
    decided = seeds > 1
    headers = (
        "mutant",
        "status",
        "killed/eligible",
        "flown",
        "by",
        "first",
        *(["decided"] * decided),
        "killed where",
    )
    rows = tuple(
        (
            mutant.subject.id,
            mutant.status.value,
            mutant.kill_rate.short,
            f"{mutant.kill_rate_flown.part}/{mutant.kill_rate_flown.whole}",
            ", ".join(f"{name} {ratio.part}/{ratio.whole}" for name, ratio in mutant.requirements),
            f"{mutant.earliest.t_s:.1f} s" if mutant.earliest else "",
            *([_decisions(mutant)] * decided),
            _short(where[mutant.subject.id]),
        )
        for mutant in sorted(mutants, key=lambda mutant: -mutant.status.rung)
    )
    notes = [FLOWN]
    if decided and title == MUTANTS:
        notes.append(DECIDED)
    return Table(title, headers, rows, tuple(notes))


def _short(condition: str) -> str:
    """A condition that fits into a column; a longer one stands in a table of its own."""
    return condition if len(condition) <= SHORT else "see below"


def condition_tables(where: Mapping[str, str]) -> tuple[Table, ...]:
    """The conditions too long for the mutants' table, if there are any."""
    rows = tuple((name, condition) for name, condition in where.items() if len(condition) > SHORT)
    note = "The shortest condition that holds in every situation where it kills and in none where it survives."
    return (Table("Killed where", ("mutant", "condition"), rows, (note,)),) if rows else ()


def _decisions(mutant: MutantScore) -> str:
    killed, survived, undecided = (len(mutant.decisions(decision)) for decision in Decision)
    return f"{killed}+{survived}" + (f" {undecided}?" if undecided else "")


def rung_table(scored: Score) -> Table:
    """How many flights stopped at each rung: reach, infect, propagate, reveal; by parameter where mutants are many."""
    placebo = [scored.placebo] if scored.placebo else []
    entries = [*placebo, *scored.mutants, *scored.controls]
    if len(entries) <= MANY:
        parts = [(entry.subject.id, [entry]) for entry in entries]
    else:
        names = dict.fromkeys(mutant.subject.parameter for mutant in scored.mutants)
        parts = [(name, [m for m in scored.mutants if m.subject.parameter == name]) for name in names]
        parts = [*((PLACEBO, [entry]) for entry in placebo), *parts, ("controls", list(scored.controls))]
    if len(entries) > 1:
        parts.append(("all", entries))
    rows = [_rungs(name, members) for name, members in parts if members]
    headers = ("mutant" if len(entries) <= MANY else "parameter", *(status.value for status in Status), "flights")
    return Table("Where the faults stopped (flights)", headers, tuple(rows))


def _rungs(name: str, members: Sequence[MutantScore]) -> tuple[str | int, ...]:
    counts = Counter[Status]()
    for member in members:
        counts.update(dict(member.rungs))
    return (name, *(counts[status] for status in Status), counts.total())


def baseline_table(found: Sequence[Finding]) -> Table:
    """The situations where the unmutated drone violates a requirement, or leaves one untested."""
    rows = tuple(
        (
            finding.situation,
            str(Ratio(finding.red, finding.flown)),
            ", ".join(finding.violated),
            ", ".join(finding.open),
            ", ".join(finding.vacuous),
            _first(finding),
        )
        for finding in found
        if finding.violated
    )
    red = sum(finding.red > 0 for finding in found)
    held = len(found) - red
    vacuous = sum(bool(finding.vacuous) for finding in found)
    notes = (
        f"{Ratio(held, len(found))} of the situations flown have baselines that hold every safety requirement.",
        f"In {vacuous} of {len(found)} a requirement was never triggered: vacuous, not passed.",
    )
    headers = ("situation", "red flights", "violated", "open", "vacuous", "first")
    return Table("Findings about the unmutated drone", headers, rows, notes)


def _first(finding: Finding) -> str:
    if finding.first is None:
        return ""
    violation, seed = finding.first
    struck = f" struck {violation.struck}" if violation.struck else ""
    place = f"({violation.x:.2f}, {violation.y:.2f}, {violation.z:.2f})"
    of_seed = f", seed {seed}" if finding.flown > 1 else ""
    return f"{violation.requirement} {violation.t_s:.2f} s {place}{struck}{of_seed}"


def requirement_table(tallied: Sequence[Tally]) -> Table:
    """What the baseline flights say about each requirement."""
    headers = ("requirement", "kind", *(verdict.value for verdict in Verdict), "triggered", "least robustness")
    rows = tuple(
        (t.requirement, t.kind.value, *(count for _, count in t.verdicts), t.triggered, f"{t.least_rho:.3f}")
        for t in tallied
    )
    notes = ("Baseline flights by verdict; triggered: episodes in which the requirement's condition came true.",)
    return Table("Requirements of the unmutated drone (flights)", headers, rows, notes)


def coverage_table(covered: Coverage) -> Table:
    """How much of the situation space was flown; the grid is a closed list, so no interval."""
    rows = [
        ("distinct situations", covered.situations.plain, "situations of the grid"),
        ("draws", str(covered.draws), "situations flown with a seed"),
        *([("pool", str(covered.pool), "of these draws, the baseline's alone, to decide by")] if covered.pool else []),
        *((f"{t}-way", ratio.plain, "value combinations of that many axes") for t, ratio in covered.t_way),
        ("realised", covered.realised.plain, "situations whose every value came true in a baseline flight"),
        *(
            (f"realised {axis}", ratio.plain, "situations where the value on that axis came true")
            for axis, ratio in covered.by_axis
        ),
    ]
    return Table("Situation coverage", ("coverage", "part/whole", "of"), tuple(rows))


def group_table(scored: Score, by: By, roster: Roster, space: Space) -> Table:
    """The score of each part."""
    rows = tuple((group.name, str(group.killed), str(group.flown)) for group in groups(scored, by, roster, space))
    what = "mutants" if by is not By.AXIS else "mutants in situations"
    notes = (f"Counted are {what}, default mutants of credible cells only.",)
    return Table(f"Score by {by.value}", (by.value, "killed/eligible", "killed/flown"), rows, notes)


def _notes(seeds: int) -> tuple[str, ...]:
    return (INTERVALS, ONE_SEED) if seeds == 1 else (INTERVALS,)
