"""The tables behind the first screen: ratios, stages, pairs, the unmutated drone's findings, coverage, groupings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from scaloft_fi.analysis.coverage import Coverage
from scaloft_fi.analysis.detection import Firmness
from scaloft_fi.analysis.pool import Finding, Pool, State, Tally, findings, tallies
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import EARLY_S, By, MutantScore, Score, groups
from scaloft_fi.judge.outcome import PLACEBO_ID
from scaloft_fi.judge.requirement import Compliance, rho_text
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Rulings, Status
from scaloft_fi.views.coverage.coverage_tables import coverage_tables
from scaloft_fi.views.score.answers import NOT_COMPARED, false_detections
from scaloft_fi.views.tables.table import Table

MANY = 24
"""Of more mutants than these the flights at each stage are summed by parameter."""
POPULATIONS = {
    "exercised": "credible cells whose default mutant was flown, of all credible cells",
    "infected": "default mutants that changed a sample, of those flown",
    "tested": "default mutants put to the test: they infect where a safety requirement is steady; of those flown",
    "mutation_score": "default mutants detected by safety requirements, of those flown",
    "firm": "default mutants detected whichever one seed is left out, of those flown",
    "operability": "default mutants detected by operability requirements, of those flown",
}
"""What each ratio of the score counts."""


def tables_behind(
    scored: Score, rulings: Rulings, covered: Coverage, space: Space, by: By | None = None
) -> tuple[Table, ...]:
    """All tables behind the first screen; `by` adds the score part by part."""
    return (
        ratio_table(scored),
        composition_table(scored),
        stage_table(scored),
        *([group_table(scored, by, space)] if by else []),
        pair_table(scored.pool, space),
        baseline_table(findings(rulings.baselines, space)),
        requirement_table(tallies(rulings.baselines)),
        *coverage_tables(covered, space),
    )


def ratio_table(scored: Score) -> Table:
    """The ratios of the score, each with its population."""
    rows = tuple((name.replace("_", " "), str(getattr(scored, name)), of) for name, of in POPULATIONS.items())
    drawn = scored.redraw
    notes = [false_detections(scored.alpha, scored.tested.part)]
    if drawn.seeds:
        notes.append(
            f"Of {drawn.safety.whole} redraws of the unmutated drone ({drawn.seeds} seeds beside ten) "
            f"{drawn.safety.part} are called detected by safety, {drawn.operability.part} by operability requirements."
        )
    else:
        notes.append("No redraws: they need 20 baseline flights and more in every situation (`--baseline-seeds`).")
    return Table("Mutation score", ("ratio", "part/whole", "population"), rows, tuple(notes))


def composition_table(scored: Score) -> Table:
    """What the ratio is made of."""
    detected = scored.mutation_score.part
    firmness = Counter(mutant.firmness for mutant in scored.counted if mutant.firmness)
    alike = [" = ".join(group) for group in scored.behaviours if len(group) > 1]
    idle = [f"{mutant.subject.id} (acts in {mutant.acted.short})" for mutant in scored.without_effect]
    rows = (
        ("detected", detected, ""),
        *((one.words, firmness[one], _named(scored, one)) for one in Firmness if firmness[one]),
        ("distinct behaviours", len(scored.behaviours), "; ".join(alike)),
        ("without a kill", len(scored.without_kill), _ids(scored.without_kill)),
        ("trivial", len(scored.trivial), _ids(scored.trivial)),
        ("no effect here", len(scored.without_effect), ", ".join(idle)),
    )
    notes = (
        (
            "Of the default mutants of credible cells.  Distinct behaviours: detected mutants whose flights all equal "
            "each other's to the bit count once.  Trivial: killed in nine tenths of the situations that test it, or "
            f"within {EARLY_S:g} s of take-off.  No effect here: every flight equals the baseline's to the bit."
        ),
        NOT_COMPARED,
    )
    return Table("What the score is made of", ("what", "mutants", "which"), rows, notes)


def _named(scored: Score, firmness: Firmness) -> str:
    """The detected mutants that are not firm, by name."""
    return "" if firmness.firm else _ids(mutant for mutant in scored.counted if mutant.firmness is firmness)


def _ids(mutants: Iterable[MutantScore]) -> str:
    return ", ".join(mutant.subject.id for mutant in mutants)


def pair_table(pool: Pool, space: Space) -> Table:
    """The pairs of situation and requirement that put no fault to the test."""
    others = [pair for pair in pool.pairs.values() if pair.state is not State.STEADY]
    others.sort(key=lambda pair: (space.rank(pair.situation), pair.requirement))
    rows = tuple(
        (pair.situation, pair.requirement, pair.state.value, f"{pair.violated}/{pair.flights}", pair.open)
        for pair in others
    )
    steady = Ratio(len(pool.pairs) - len(others), len(pool.pairs))
    notes = (
        f"{steady} of the pairs are steady: nine tenths of the baseline flights hold the requirement.",
        "red: most violate; unsteady: between; open: a tenth is cut short before; vacuous: half never trigger it;",
        "unknown: fewer than ten baseline flights.  None of these contributes a kill.",
    )
    headers = ("situation", "requirement", "state", "violated", "open")
    return Table("Pairs that put no fault to the test", headers, rows, notes)


def stage_table(scored: Score) -> Table:
    """How many flights stopped at each stage: reach, infect, propagate, reveal; by parameter where mutants are many."""
    placebo = [scored.placebo] if scored.placebo else []
    entries = [*placebo, *scored.mutants, *scored.controls]
    if len(entries) <= MANY:
        parts = [(entry.subject.id, [entry]) for entry in entries]
    else:
        names = dict.fromkeys(mutant.subject.parameter for mutant in scored.mutants)
        parts = [(name, [m for m in scored.mutants if m.subject.parameter == name]) for name in names]
        parts = [*((PLACEBO_ID, [entry]) for entry in placebo), *parts, ("controls", list(scored.controls))]
    if len(entries) > 1:
        parts.append(("all", entries))
    rows = [_stages(name, members) for name, members in parts if members]
    headers = ("mutant" if len(entries) <= MANY else "parameter", *(status.value for status in Status), "flights")
    return Table("Where the faults stopped (flights)", headers, tuple(rows))


def _stages(name: str, members: Sequence[MutantScore]) -> tuple[str | int, ...]:
    counts = Counter[Status]()
    for member in members:
        counts.update(dict(member.statuses))
    return (name, *(counts[status] for status in Status), counts.total())


def baseline_table(findings: Sequence[Finding]) -> Table:
    """The situations where the unmutated drone violates a requirement, or leaves one untested."""
    rows = tuple(
        (
            finding.situation,
            Ratio(finding.red, finding.flown).short,
            ", ".join(finding.violated),
            ", ".join(finding.open),
            ", ".join(finding.vacuous),
            _first(finding),
        )
        for finding in findings
        if finding.violated
    )
    red = sum(finding.red > 0 for finding in findings)
    held = len(findings) - red
    vacuous = sum(bool(finding.vacuous) for finding in findings)
    notes = (
        f"{Ratio(held, len(findings))} of the situations flown have baselines that hold every safety requirement.",
        f"In {vacuous} of {len(findings)} a requirement was never triggered: vacuous, not passed.",
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
    headers = ("requirement", "kind", *(compliance.value for compliance in Compliance), "triggered", "least robustness")
    rows = tuple(
        (t.requirement, t.kind.value, *(count for _, count in t.compliances), t.triggered, rho_text(t.least_rho))
        for t in tallied
    )
    notes = (
        "Baseline flights by compliance; triggered: episodes in which the requirement's condition came true.",
        "Least robustness: of flights in which it came true, or that violate it.",
    )
    return Table("Requirements of the unmutated drone (flights)", headers, rows, notes)


def group_table(scored: Score, by: By, space: Space) -> Table:
    """The score of each part."""
    rows = tuple((group.name, str(group.tested), str(group.flown)) for group in groups(scored, by, space))
    mutants = by in (By.GUIDEWORD, By.PARAMETER, By.SEVERITY, By.REQUIREMENT)
    what = "detected" if mutants else "with a kill"
    of = "mutants in situations" if by is By.AXIS else "mutants"
    notes = (f"Default mutants of credible cells: {of} {what}, of those put to the test there, and of those flown.",)
    return Table(f"Score by {by.value}", (by.value, f"{what}/tested", f"{what}/flown"), rows, notes)
