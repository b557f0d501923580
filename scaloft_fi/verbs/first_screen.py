"""The first screen after `run` and `score`, and what stands behind it with `--all`.

The first screen has the four answers and every fault: few of them in a table, many as the signs of the matrix.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from scaloft_fi.analysis import detection
from scaloft_fi.analysis.coverage import Coverage
from scaloft_fi.analysis.detection import LEAST, Firmness, Noise, State, Verdict, findings
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import EARLY_S, By, MutantScore, Score, groups
from scaloft_fi.analysis.survivor import Background, Disposition, backgrounds, score_without
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import class_of, worst_first
from scaloft_fi.hazop.render import signs_grid
from scaloft_fi.judge.outcome import PLACEBO_ID
from scaloft_fi.judge.requirement import Compliance, Kind, rho_text
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Rulings, Status
from scaloft_fi.output import PROSE, Marked, Style, coloured, in_campaign, line, styled, wrapped
from scaloft_fi.output import width as terminal_width
from scaloft_fi.study import Study
from scaloft_fi.verbs.situations import coverage_tables
from scaloft_fi.verbs.verdict import Next, advice, next_step, signs_of, some, with_legend
from scaloft_fi.views.output import Printed, printed_of
from scaloft_fi.views.table import Format, Table, body_text, commands, counted, note, render, said

NOT_COMPARED = (
    "Scores of two studies do not compare: whoever writes easier cells, or fewer hard ones, scores higher.  Compare "
    "two stacks or versions by the same matrix."
)
NAMES = ("Shown", "Not shown", "How sure", "What next")


class Line(NamedTuple):
    """A line of the first screen, such as one of the four answers: its name and the sentences."""

    name: str
    text: str


def answers(scored: Score, study: Study, campaign: str, invalid: Sequence[str] = ()) -> tuple[Line, ...]:
    """The four answers.

    Args:
        scored: the campaign's score.
        study: what was flown, or whose tests were run, with the grid of the campaign.
        campaign: its name, for the commands.
        invalid: why no score of it is valid, each reason in a sentence.
    """
    faults = scored.faults
    shown = _shown(faults) + "".join(f"  Selected: {told}." for told in selected(scored, study))
    told = (shown, _not_shown(scored, faults), _how_sure(scored, faults)) if scored.pooled else _no_pool(faults)
    sure = f"not at all: {'; '.join(invalid)}." if invalid else told[-1]
    return tuple(map(Line, NAMES, (*told[:-1], sure, next_step(scored, study, campaign, invalid))))


def _shown(faults: Sequence[MutantScore]) -> str:
    if not faults:
        return "nothing: no mutant was flown."
    safety = Ratio(sum(mutant.detected for mutant in faults), len(faults))
    operability = sum(mutant.operability.detected for mutant in faults)
    either = sum(mutant.detected or mutant.operability.detected for mutant in faults)
    shown = f"{_of(safety)} by safety requirements{_firmly(faults)}"
    if operability:
        shown += f"; operability {operability}, either {either}"
    return f"{shown}."


def selected(scored: Score, study: Study) -> Iterator[str]:
    """What was chosen because of flights such as those that the score is made of, each in a clause."""
    chosen = (
        (len(scored.selected), "situation", "found by a search, because of what flew there"),
        (sum(one.selected for one in study.requirements), "requirement", "proposed, because of what flew"),
    )
    yield from (
        f"{counted(number, noun)} {'was' if number == 1 else 'were'} {how}" for number, noun, how in chosen if number
    )


def _firmly(faults: Sequence[MutantScore]) -> str:
    """How many of the detected are firm."""
    known = Counter(mutant.firmness for mutant in faults if mutant.firmness is not None)
    detected, firm = known.total(), sum(count for firmness, count in known.items() if firmness.firm)
    if not detected:
        return ""
    if detected == 1:
        (firmness,) = known
        return f", {firmness.words if firmness.firm else 'not firmly: ' + firmness.words}"
    alone = known[Firmness.FIRM_BY_POOL]
    by_pool = "" if not alone else " by the pool alone" if alone == firm else f", {alone} of these by the pool alone"
    return f", {firm} firmly{by_pool}"


def _not_shown(scored: Score, faults: Sequence[MutantScore]) -> str:
    idle = 0 if scored.of_tests else sum(one.without_effect for one in faults)
    fates = Counter(mutant.verdict for mutant in faults)
    parts = {
        Verdict.NOT_DETECTED: "put to the test, nothing seen",
        Verdict.UNDECIDED: "undecided: seen or flown too seldom",
        Verdict.NOT_TESTED: "never put to the test",
    }
    counts = [f"{fates[verdict]} {words}" for verdict, words in parts.items() if fates[verdict]]
    if idle:
        counts.append(f"{idle} of these without effect: flights equal the baseline's to the bit")
    return f"{'.  '.join(counts) or 'none'}."


def _how_sure(scored: Score, faults: Sequence[MutantScore]) -> str:
    tested = sum(mutant.tested for mutant in faults)
    drawn = scored.redraw
    sure = false_detections(scored.alpha, tested)
    if drawn.seeds:
        sure += f"  Of {drawn.safety.whole} redraws of the unmutated drone {drawn.safety.part} were called shown."
    flown = {pair.flights for pair in scored.pool.pairs.values() if pair.flights >= LEAST}
    sure += f"  {seeds_flown(faults)} beside {_least_to_most(flown, 'baseline flight')} a situation." * bool(faults)
    firm = "  Firm: whichever one seed is left out."
    return sure + firm * any(mutant.detected for mutant in faults)


def seeds_flown(mutants: Sequence[MutantScore]) -> str:
    """How many seeds each of these mutants flew in a situation, of flights that count: `1 to 5 seeds`."""
    flown = {result.flown for mutant in mutants for result in mutant.results}
    return _least_to_most(flown if all(mutant.flown for mutant in mutants) else flown | {0}, "seed")


def _least_to_most(numbers: Collection[int], noun: str) -> str:
    least, most = min(numbers, default=0), max(numbers, default=0)
    return f"{least} to " * (least < most) + counted(most, noun)


BEFOREHAND = "for situations and a pool fixed beforehand"
"""Only further seeds spend alpha: who adds situations or baselines until a verdict comes out tests more than once."""


def false_detections(alpha: float, tested: int) -> str:
    """What the test would do to faults without effect: no probability of being wrong about one that is shown.

    Args:
        alpha: the level of the test.
        tested: number of faults put to the test.
    """
    if not tested:
        return "No fault was put to the test, so there is nothing to be sure of."
    if tested == 1:
        return f"A fault without effect would be called shown with a probability of {alpha:g} at most, {BEFOREHAND}."
    return (
        f"If none of the {tested} faults put to the test had any effect, {alpha * tested:.2g} at most would be called "
        f"shown, on average ({alpha:g} x {tested}).  As mutants share seeds, then several at once.  "
        f"That holds {BEFOREHAND}."
    )


def _no_pool(faults: Sequence[MutantScore]) -> tuple[str, str, str]:
    """The first three answers where there is no baseline pool."""
    revealed = sum(mutant.status is Status.REVEALED for mutant in faults)
    of = f"{revealed} of {counted(len(faults), 'fault')}"
    seen = f"{of} violated a safety requirement in a flight whose own baseline held it."
    return (
        f"not known: there is no baseline pool.  {seen}" if faults else "nothing: no mutant was flown.",
        "not known: without a baseline pool a fault cannot be told from chance.",
        f"not at all: {LEAST} baseline flights in each situation where a mutant infects would show what chance does.",
    )


def _of(ratio: Ratio) -> str:
    share = "" if ratio.whole < 2 else f" ({100 * ratio.part / ratio.whole:.0f} %)"
    return f"{ratio.part} of {counted(ratio.whole, 'fault')}{share}"


def noise_line(noise: Sequence[Noise]) -> str:
    """What the stack alone does to the robustness of each requirement, beside what the seeds do.

    >>> noise_line([Noise("SR1", 6, 0.0123, 0.2, 0), Noise("SR2", 0, None, None, 0)])
    'one flight varies by the stack alone (and between seeds): SR1 0.012 (0.2) by 6 pairs, SR2 not measured.'
    """
    told = ", ".join(map(_noise_of_one, noise))
    apart = [f"{one.requirement} in {one.apart} of {one.pairs}" for one in noise if one.apart]
    verdicts = f"  A pair has two verdicts: {', '.join(apart)}." if apart else ""
    return f"one flight varies by the stack alone (and between seeds): {told}.{verdicts}"


def _noise_of_one(one: Noise) -> str:
    if one.stack is None:
        return f"{one.requirement} not measured"
    seeds = f" ({one.seeds:.2g})" if one.seeds is not None else ""
    return f"{one.requirement} {one.stack:.2g}{seeds} by {one.pairs} pairs"


def accepted_line(scored: Score, accepted: Sequence[Disposition], campaign: str) -> str:
    """How many survivors were accepted and by whom, and the score with and without them, in a sentence."""
    owners = Counter(known.owner for known in accepted)
    by = ", ".join(f"{owner} {number}" if len(owners) > 1 else owner for owner, number in owners.items())
    score, without = scored.mutation_score, score_without(scored, accepted)
    share = f" ({100 * without.value:.0f} %)" if without.value is not None else ""
    return (
        f"{len(accepted)} of the {score.whole - score.part} faults not shown (by {by}).  Shown: {score.part} of "
        f"{score.whole} with them, {without.part} of {without.whole}{share} without them; "
        f"`scaloft-fi dispositions{in_campaign(campaign)}` lists them."
    )


SHORT = {
    Next.REPEAT: "fly it again",
    Next.FIND: "fly its find",
    Next.POOL: "a baseline pool",
    Next.SITUATION: "another situation",
    Next.ORACLE: "an oracle",
    Next.OPERABILITY: "nothing: operability",
    Next.TEST: "another test",
    Next.EXPECTED: "nothing: expected",
}
"""The steps in a few words; magnitude and seeds are named by `short_step`."""


def short_step(mutant: MutantScore, steps: Sequence[Next], background: Background | None) -> str:
    """The steps in a few words, for a row of a table."""
    words = dict(SHORT)
    words[Next.SEEDS] = f"--seeds {mutant.safety.needed}" + ", anew" * mutant.safety.anew
    words[Next.MAGNITUDE] = f"try {background.stronger[0]}" if background and background.stronger else ""
    return " or ".join(words[step] for step in steps)


MANY_ROWS = 24
"""Of more mutants than these the flights at each stage are summed by parameter."""


def tables_behind(
    scored: Score, rulings: Rulings, covered: Coverage, space: Space, by: By | None = None
) -> tuple[Table, ...]:
    """All tables behind the first screen; `by` adds the score part by part."""
    first = (
        ratio_table(scored),
        composition_table(scored),
        stage_table(scored),
        *([group_table(scored, by, space)] if by else []),
        pair_table(scored.pool, space),
    )
    if scored.of_tests:  # what else tests are without a fault, a suite tells test by test
        return first
    return (
        *first,
        baseline_table(findings(rulings.baselines, space)),
        requirement_table(detection.tallies(rulings.baselines)),
        *coverage_tables(covered, space),
    )


def ratio_table(scored: Score) -> Table:
    """The ratios of the score, each with its population."""
    rows = tuple((one.key.replace("_", " "), str(getattr(scored, one.name)), one.about) for one in ratios_of(scored))
    drawn = scored.redraw
    redraws = "No redraws: they need 20 baseline flights and more in every situation (`--baseline-seeds`)."
    if drawn.seeds:
        redraws = (
            f"Of {drawn.safety.whole} redraws of the unmutated drone ({drawn.seeds} seeds beside ten) "
            f"{drawn.safety.part} are called detected by safety, {drawn.operability.part} by operability requirements."
        )
    notes = false_detections(scored.alpha, sum(mutant.tested for mutant in scored.faults)), redraws
    return Table("Mutation score", ("ratio", "part/whole", "population"), rows, notes)


def ratios_of(scored: Score) -> list[Printed]:
    """The ratios of a score; tests have no requirements of operability."""
    return [one for one in printed_of(Score) if not (scored.of_tests and one.name == "operability")]


def composition_table(scored: Score) -> Table:
    """What the ratio is made of."""
    detected = scored.mutation_score.part
    firmness = {one: [each.subject.id for each in scored.counted if each.firmness is one] for one in Firmness}
    alike = [" = ".join(group) for group in scored.behaviours if len(group) > 1]
    idle = [f"{mutant.id} (acts in {mutant.acted.short})" for mutant in scored.without_effect]
    rows = (
        ("detected", detected, ""),
        *((one.words, len(ids), "" if one.firm else ", ".join(ids)) for one, ids in firmness.items() if ids),
        ("distinct behaviours", len(scored.behaviours), "; ".join(alike)),
        ("without a kill", len(scored.without_kill), ", ".join(scored.without_kill)),
        ("trivial", len(scored.trivial), ", ".join(scored.trivial)),
        ("no effect here", len(scored.without_effect), ", ".join(idle)),
    )
    words = (
        "Of the default mutants of credible cells.  Distinct behaviours: detected mutants whose flights all equal "
        "each other's to the bit count once.  Trivial: killed in nine tenths of the situations that test it, or "
        f"within {EARLY_S:g} s of take-off.  No effect here: every flight equals the baseline's to the bit."
    )
    return Table("What the score is made of", ("what", "mutants", "which"), rows, (words, NOT_COMPARED))


def pair_table(pool: detection.Pool, space: Space) -> Table:
    """The pairs of situation and requirement that put no fault to the test."""
    called = {pair: pair.called(of_tests=space.of_tests) for pair in pool.pairs.values()}
    others = [pair for pair, state in called.items() if state is not State.STEADY]
    others.sort(key=lambda pair: (space.rank(pair.situation), pair.requirement))
    rows = tuple(
        (pair.situation, pair.requirement, called[pair].value, f"{pair.violated}/{pair.flights}", pair.open)
        for pair in others
    )
    states = Counter(called.values())
    steady = Ratio(states[State.STEADY], len(called) - states[State.UNKNOWN])
    notes = (
        f"{steady} of the pairs with a pool are steady: nine tenths of the baseline flights hold the requirement.",
        "red: most violate; unsteady: between; open: a tenth is cut short before; vacuous: half never trigger it;",
        "unknown: fewer than ten baseline flights.  None of these contributes a kill.",
    )
    headers = ("situation", "requirement", "state", "violated", "open")
    return Table("Pairs that put no fault to the test", headers, rows, notes)


def stage_table(scored: Score) -> Table:
    """How many flights stopped at each stage: reach, infect, propagate, reveal; by parameter where mutants are many."""
    placebo = [scored.placebo] if scored.placebo else []
    entries = [*placebo, *scored.mutants, *scored.controls]
    if len(entries) <= MANY_ROWS:
        parts = [(entry.subject.id, [entry]) for entry in entries]
    else:
        names = dict.fromkeys(mutant.subject.parameter for mutant in scored.mutants)
        parts = [(name, [m for m in scored.mutants if m.subject.parameter == name]) for name in names]
        parts = [*((PLACEBO_ID, [entry]) for entry in placebo), *parts, ("controls", list(scored.controls))]
    if len(entries) > 1:
        parts.append(("all", entries))
    rows = [_stages(name, members) for name, members in parts if members]
    headers = ("mutant" if len(entries) <= MANY_ROWS else "parameter", *(status.value for status in Status), "flights")
    return Table("Where the faults stopped (flights)", headers, tuple(rows))


def _stages(name: str, members: Sequence[MutantScore]) -> tuple[str | int, ...]:
    counts = Counter[Status]()
    for member in members:
        counts.update(dict(member.statuses))
    return (name, *(counts[status] for status in Status), counts.total())


def baseline_table(findings: Sequence[detection.SituationBaseline]) -> Table:
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
    held = sum(not finding.red for finding in findings)
    vacuous = sum(bool(finding.vacuous) for finding in findings)
    notes = (
        f"{Ratio(held, len(findings))} of the situations flown have baselines that hold every safety requirement.",
        f"In {vacuous} of {len(findings)} a requirement was never triggered: vacuous, not passed.",
    )
    headers = ("situation", "red flights", "violated", "open", "vacuous", "first")
    return Table("Findings about the unmutated drone", headers, rows, notes)


def _first(finding: detection.SituationBaseline) -> str:
    if finding.first is None:
        return ""
    violation, seed = finding.first
    struck = f" struck {violation.struck}" if violation.struck else ""
    place = f"({violation.x:.2f}, {violation.y:.2f}, {violation.z:.2f})"
    of_seed = f", seed {seed}" if finding.flown > 1 else ""
    return f"{violation.requirement} {violation.t_s:.2f} s {place}{struck}{of_seed}"


def requirement_table(tallied: Sequence[detection.Tally]) -> Table:
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


MOST_ROWS = 8
"""More faults than these stand on the first screen as the signs of the matrix, or are counted."""
WIDEST = 24
"""Longest condition that a row shows."""
TITLE = "Would your tests have shown it?"
COLUMNS = ("verdict", "severity", "killed in", "firm", "by", "where", "first", "effect", "next")
"""The columns of a table of mutants, of which those are left out that have no value."""
ONLY_WHOLE = ("first", "next")
"""Those that the first screen leaves to `--all`."""
OF_FLIGHTS = ("by", "where", "first", "effect", "next")
"""Those that say nothing of runs of tests."""
SPARE = ("where", "by", "first")
"""The columns that a narrow terminal does without, in the order in which they are left out."""
CONTROL_COLUMNS = ("shows itself by", "effect")
NO_KILL = "no kill"
"""Of a detected mutant without a situation where most of its flights violate."""
LEGEND = {
    "killed in": "situations where most flights violate a requirement, of those that test the fault.",
    NO_KILL: "it violates here and there, more often than chance explains.",
    "pool": "by the baseline's seeds alone, as the mutant flew one.",
    "by": "situations per requirement.",
    "mixed": "`scaloft-fi kills{where} ID` says where.",
    "first": "earliest such violation [s from take-off].",
    "--seeds": "so many decide, by `run --mutant ID`; anew: in a campaign of its own.",
    SHORT[Next.FIND]: "`scaloft-fi kills{where} ID --show survivors` has the command.",
}
"""What the words of a table say that its reader may not know; the legend has those that are shown.

`{where}` stands for the options that name study and campaign.
"""
FIRM = {
    Firmness.FIRM: "yes",
    Firmness.FIRM_BY_POOL: "pool",
    Firmness.HANGS: "no",
    Firmness.TOO_FEW: "too few seeds",
}
_STOPPED = {
    Status.INVALID: "the harness failed",
    Status.NOT_REACHED: "its seam carries nothing",
    Status.NOT_INFECTED: "changes no sample",
    Status.MASKED: "flies the same to the bit",
    Status.BASELINE_RED: "violates as the baseline",
    Status.SURVIVED: "flies otherwise",
    Status.REVEALED: "flies otherwise",
}


@dataclass(frozen=True)
class Screen:
    """What a campaign's flights say, on the first screen or whole.

    Attributes:
        study: with the grid of the campaign.
        scored: the campaign's score.
        covered: its situation coverage.
        campaign: its name, for the commands.
        noise: of a stack that is not deterministic.
        accepted: the survivors that somebody accepted.
        invalid: why no score of the campaign is valid, each reason in a sentence.
    """

    study: Study
    scored: Score
    covered: Coverage
    campaign: str = CAMPAIGN
    noise: Sequence[Noise] = ()
    accepted: Sequence[Disposition] = ()
    invalid: Sequence[str] = ()

    @property
    def answers(self) -> Table:
        """The four answers."""
        told = answers(self.scored, self.study, self.campaign, self.invalid)
        return self._said(Table(TITLE, ("question", "answer"), told))

    @property
    def tables(self) -> tuple[Table, ...]:
        """The answers, a table a group of mutants, and further findings."""
        scored, groups = self.scored, []
        in_score = Counter(mutant.verdict for mutant in scored.counted)
        for verdict in Verdict:
            members = [mutant for mutant in scored.mutants if mutant.verdict is verdict]
            by_kills = sorted(members, key=lambda mutant: -len(mutant.killing))
            title = f"{verdict.words.capitalize()}: {len(members)}"
            title += f", of which {in_score[verdict]} count in the score" * (in_score[verdict] != len(members))
            groups.append(self._table(title, worst_first(by_kills, lambda mutant: mutant.severity), ("verdict",)))
        columns = ("mutant", *(() if self.study.tests_of else CONTROL_COLUMNS))
        controls = tuple(_control(mutant)[: len(columns)] for mutant in scored.controls)
        groups.append(Table(f"Controls, in no ratio: {self._controls}", columns, controls))
        groups = [group for group in groups if group.rows]
        if groups:
            groups[-1] = replace(groups[-1], notes=("", legend(groups, self.campaign)))
        lines = [self._flown]
        if not self.study.tests_of:  # what its tests are without a fault, a suite tells test by test
            lines += [Line("Unmutated drone", baseline_line(scored.pool, self.campaign))]
            lines += [Line("Noise", noise_line(self.noise))] if self.noise else []
        besides = Table("Besides", ("what", "finding"), (*lines, *self._accepted))
        return (self.answers, *map(self._said, groups), self._said(besides))

    def _said(self, table: Table) -> Table:
        return said(table, of_tests=self.scored.of_tests)

    def text(self, *, whole: bool, width: int | None = None, marked: bool | None = None) -> str:
        """The screen as a terminal shows it: answers and findings as lines, the mutants between them.

        Args:
            whole: whether every mutant is shown with all that is known of it, not only the first screen.
            width: of the terminal [characters]; that of standard output when None.
            marked: whether the text has colours; as standard output has them when None.
        """
        columns = terminal_width() if width is None else width
        colours = coloured() if marked is None else marked
        first, *groups, last = self.tables if whole else (self.answers, self._said(Table("", (), tuple(self._below))))
        parts = [render([table], Format.TABLE, width=columns, marked=colours) for table in groups]
        parts = parts if whole else self._faults(columns, marked=colours)
        text = "\n".join([_lines(first, columns, marked=colours), *parts, _lines(last, columns, marked=colours)])
        return Marked(text) if colours else text

    def _faults(self, columns: int, *, marked: bool) -> list[str]:
        """The faults on the first screen: their signs, or a table of them with its legend; nothing without any."""
        if len(self.scored.counted) > MOST_ROWS:
            signs = signs_of(self.scored)
            grid = signs_grid(self.study.matrix, signs, columns)
            return [with_legend("\n".join(grid), signs, columns, marked=marked) + "\n"]
        flown = worst_first(self.scored.mutants, lambda mutant: mutant.severity)
        shown = self._table("", sorted(flown, key=lambda mutant: mutant.detected)[:MOST_ROWS], ONLY_WHOLE)
        shown = self._said(replace(shown, notes=(legend([shown], self.campaign),)))
        if not (rows := [[*map(str, row)] for row in shown.rows]):
            return []
        body = body_text(shown.headers, rows, columns, shown.spare, marked=marked)
        more = [f"... and {len(flown) - MOST_ROWS} more."] if len(flown) > MOST_ROWS else []
        notes = [note(each, columns, marked=marked) for each in (*more, *shown.notes) if each]
        return ["\n".join([body, *notes]) + "\n"]

    @property
    def _below(self) -> Iterator[Line]:
        """What stands below the faults on the first screen."""
        if self.covered.situations.part < self.covered.situations.whole:
            yield self._flown
        if self.scored.controls:
            yield Line("Controls", f"{self._controls}.")
        if not self.study.tests_of:
            yield from (Line("Unmutated drone", told) for told in mostly_red(self.scored.pool, self.campaign))
        if failed := [mutant.id for mutant in self.scored.faults if not mutant.flown]:
            why = f"every flight failed in the harness; `scaloft-fi status{in_campaign(self.campaign)}` says why"
            yield Line("Invalid", f"{some(failed)}: {why}.")
        yield from self._accepted
        yield Line("More", f"`scaloft-fi score{in_campaign(self.campaign)} --all`: all tables.")

    @property
    def _flown(self) -> Line:
        if self.scored.of_tests:
            return Line("Situations", f"{self.covered.situations.short} flown.")
        return Line("Situations", coverage_line(self.covered))

    @property
    def _accepted(self) -> list[Line]:
        return [Line("Accepted", accepted_line(self.scored, self.accepted, self.campaign))] if self.accepted else []

    @property
    def _controls(self) -> str:
        controls, what = self.scored.controls, "a test" if self.study.tests_of else "the drone"
        return f"{sum(bool(control.shown_by) for control in controls)} of {len(controls)} show that faults reach {what}"

    def _table(self, title: str, members: Sequence[MutantScore], without: Sequence[str]) -> Table:
        facts = [_facts(mutant, self.scored, self.study) for mutant in members]
        without = (*without, *(OF_FLIGHTS if self.study.tests_of else ()))
        columns = [each for each in COLUMNS if each not in without and any(one[each] for one in facts)]
        rows = tuple((mutant.id, *map(one.get, columns)) for mutant, one in zip(members, facts, strict=True))
        return Table(title, ("mutant", *columns), rows, spare=tuple(each for each in SPARE if each in columns))


def legend(tables: Sequence[Table], campaign: str) -> str:
    """What the words of these tables of mutants say, of those that they show."""
    shown = {str(cell) for table in tables for row in (table.headers, *table.rows) for cell in row}
    words = shown | {cell.partition(" ")[0] for cell in shown}
    said = "  ".join(f"{word}: {meaning}" for word, meaning in LEGEND.items() if word in words)
    return said.replace("{where}", in_campaign(campaign))


def _lines(table: Table, width: int, *, marked: bool) -> str:
    """A table of two columns as lines: the first column is what the others are indented by."""
    wide, lines = max(len(str(name)) for name, _ in table.rows) + 2, []
    for name, text in table.rows:
        head, blanks = styled(str(name), Style.STRONG) if marked else str(name), " " * wide
        shown = wrapped(line(str(text)), min(width, PROSE), blanks, blanks)
        lines.append(f"{head}{blanks[len(str(name)) :]}{commands(shown.lstrip(), marked=marked)}\n")
    return "".join(lines)


def coverage_line(covered: Coverage) -> str:
    """The situations in a sentence."""
    ways = ", ".join(f"{t}-way {100 * (r.value or 0):.0f} %" for t, r in covered.t_way if 2 <= t <= 3 and r.whole)
    said = f", {ways} covered" if ways else ""
    return f"{covered.situations.short} flown{said}; in {covered.realised.short} every value came true."


def baseline_line(pool: detection.Pool, campaign: str) -> str:
    """What the unmutated drone itself violates, in a sentence."""
    pairs = [pair for pair in pool.pairs.values() if pair.kind is Kind.SAFETY]
    if not any(pair.state is not State.UNKNOWN for pair in pairs):
        red = sum(pair.violated > 0 for pair in pairs)
        return f"violates a safety requirement in {red} of {len(pairs)} pairs of situation and requirement; no pool."
    held = []
    for name in pool.requirements(Kind.SAFETY):
        states = Counter(pair.state for pair in pairs if pair.requirement == name and pair.state is not State.UNKNOWN)
        ill = [f"{states[s]} {s.value}" for s in (State.RED, State.UNSTEADY, State.OPEN, State.VACUOUS) if states[s]]
        held.append(f"{name} in {states[State.STEADY]}" + (f" ({', '.join(ill)})" if ill else ""))
    steadily = f"of {len(pool.flown)} situations with a pool it holds steadily {', '.join(held)}."
    return "  ".join([steadily, *mostly_red(pool, campaign)])


def mostly_red(pool: detection.Pool, campaign: str) -> list[str]:
    """A sentence for each requirement that the unmutated drone violates in most situations, and what to do."""
    sentences = []
    for kind in (Kind.SAFETY, Kind.OPERABILITY):
        for name in pool.requirements(kind):
            states = Counter(state for (_, named), state in pool.states.items() if named == name)
            known = states.total() - states[State.UNKNOWN]
            if 2 * states[State.RED] > known:
                where = f"{states[State.RED]} of {counted(known, 'situation')}"
                red = f"{name} is red in {where}: most flights without a fault violate it, so it shows no fault there."
                names = f"`scaloft-fi score{in_campaign(campaign)} --all` names the situations."
                sentences.append(f"{red}  Mend the drone or {name}; {names}")
    return sentences


def _facts(mutant: MutantScore, scored: Score, study: Study) -> dict[str, str]:
    where, rate = mutant.condition(study.space), mutant.kill_rate
    seen = Counter(name for result in mutant.results for name in result.seen)
    killed = [f"{name} {ratio.short}" for name, ratio in mutant.requirements if name in mutant.safety.p]
    background = backgrounds(study.matrix, [mutant.id])[mutant.id]
    steps = () if mutant.detected else advice(mutant, scored, background, study.finds).steps
    return {
        "verdict": mutant.verdict.words,
        "severity": class_of(mutant.severity),
        "killed in": NO_KILL if mutant.detected and not mutant.kills else rate.short * mutant.tested,
        "firm": FIRM[mutant.firmness] if mutant.firmness else "",
        "by": ", ".join(killed or mutant.safety.by or (f"{name} seen in {k}/{rate.whole}" for name, k in seen.items())),
        "where": where if len(where) <= WIDEST else "mixed" * bool(mutant.kills),
        "first": f"{mutant.first.t_s:.1f}" if mutant.first else "",
        "effect": _effect(mutant),
        "next": short_step(mutant, steps, background),
    }


def _control(mutant: MutantScore) -> tuple[str, ...]:
    return mutant.subject.id, shows_itself_by(mutant) or "nothing", _broken(mutant) or _stopped(mutant)


def shows_itself_by(control: MutantScore) -> str:
    """What shows a control; where no verdict does, as of a canary, in how many flights.  Empty for nothing."""
    if control.detected or control.operability.detected:
        return ", ".join(control.shown_by)
    flights = Counter[str]()
    for result in control.results:
        flights.update(dict(result.violated))
    return ", ".join(f"{name} in {counted(flights[name], 'flight')}" for name in control.shown_by)


def _effect(mutant: MutantScore) -> str:
    """What the fault does to the flight, in words."""
    if broken := _broken(mutant):
        return broken
    if mutant.infected and not mutant.tested:
        unknown = mutant.verdict is Verdict.UNDECIDED
        return "no baseline pool where it acts" if unknown else "acts only where no pair is steady"
    return _stopped(mutant)


def _stopped(mutant: MutantScore) -> str:
    """What its flights alone show: the bodies that it strikes where the baseline does not, else its status."""
    return _strikes(mutant.struck) or _STOPPED[mutant.status]


def _broken(mutant: MutantScore) -> str:
    """What the fault breaks, as far as the verdict knows; empty where it breaks nothing."""
    struck = list(dict.fromkeys(kill.first.struck for kill in mutant.kills if kill.first.struck))
    if not struck and mutant.first is not None and mutant.first.struck:
        struck = [mutant.first.struck]
    if struck:
        return _strikes(struck)
    if mutant.detected:
        return "no contact"
    return f"breaks {', '.join(mutant.operability.by)}" if mutant.operability.detected else ""


def _strikes(bodies: Sequence[str]) -> str:
    """The first of the bodies and the number of the others; empty without any."""
    return f"strikes {bodies[0]}" + f" +{len(bodies) - 1}" * (len(bodies) > 1) if bodies else ""
