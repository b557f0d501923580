"""`scaloft-fi score`: what a campaign's flights say, again, without flying."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import click

from scaloft_fi.analysis.coverage import Coverage, coverage_of
from scaloft_fi.analysis.detection import Noise, Spending, Verdict, noise_of
from scaloft_fi.analysis.pool import findings
from scaloft_fi.analysis.roster import plain
from scaloft_fi.analysis.score import By, Score, groups, score_of
from scaloft_fi.analysis.survivor import Accepted, Background, Disposition, accepted_survivors, backgrounds
from scaloft_fi.campaign.flight import Flight
from scaloft_fi.campaign.plan import Plan
from scaloft_fi.campaign.runs.request import Look
from scaloft_fi.campaign.runs.run import borrowed
from scaloft_fi.console import joined, say, width, wrapped
from scaloft_fi.errors import ExitCode, InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Rulings, rulings_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.first_screen import first_screen, group_table, screen_text, tables_behind
from scaloft_fi.verbs.options import (
    BaselineFrom,
    Campaign,
    Everything,
    FailUnder,
    FailUnderFirm,
    Option,
    StudyFolder,
    TableFormat,
    TablesFolder,
    Today,
    answer,
)
from scaloft_fi.verbs.score_record import SCORE, score_json
from scaloft_fi.verbs.snapshot import NONE, Stale, snapshot
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Format, Table, render

if TYPE_CHECKING:
    from scaloft_fi.campaign.runs.request import FlownRun


def look_table(looks: Sequence[Look]) -> Table:
    """How the looks went."""
    rows = tuple(
        (look.seeds, look.mutants, look.flights, *(look.fates[verdict] for verdict in Verdict)) for look in looks
    )
    headers = ("seeds", "mutants", "flights", *(verdict.words for verdict in Verdict))
    notes = (
        "Only the undecided fly on, where the pool has a steady pair.  Each look spends a quarter of alpha.",
        "Flights: of mutants, planned for the look; PLACEBO and baselines fly beside them.",
    )
    return Table("Looks", headers, rows, notes)


def look_record(look: Look) -> dict[str, Any]:
    """A look as plain JSON values."""
    fates = {verdict.value: look.fates[verdict] for verdict in Verdict}
    return {"seeds": look.seeds, "mutants": look.mutants, "flights": look.flights, **fates}


@dataclass(frozen=True)
class Unflown:
    """A part of a plan of which flights were not flown.

    Attributes:
        by: `parameter` or `situation`.
        name: of the part.
        planned, flown, not_flown: number of flights.
    """

    by: str
    name: str
    planned: int
    flown: int
    not_flown: int


def unflown(planned: Plan, left: Sequence[Flight]) -> tuple[Unflown, ...]:
    """The plan by parameter, then by situation; nothing where no flight is left."""
    if not left:
        return ()
    flights = list(dict.fromkeys((*planned.known, *left)))
    return (
        *_parts("parameter", flights, left, lambda flight: flight.subject.parameter or flight.subject.id),
        *_parts("situation", flights, left, lambda flight: flight.situation.key),
    )


def _parts(
    by: str, flights: Iterable[Flight], left: Iterable[Flight], part: Callable[[Flight], str]
) -> Iterator[Unflown]:
    planned, missing = Counter(map(part, flights)), Counter(map(part, left))
    return (Unflown(by, name, count, count - missing[name], missing[name]) for name, count in planned.items())


def unflown_tables(parts: Sequence[Unflown]) -> tuple[Table, ...]:
    """Two tables, or none when nothing is left."""
    return tuple(
        _table(title, header, [one for one in parts if one.by == header])
        for title, header in (("Not flown, by parameter", "parameter"), ("Not flown, by situation", "situation"))
        if parts
    )


def _table(title: str, header: str, parts: Sequence[Unflown]) -> Table:
    left, planned = sum(one.not_flown for one in parts), sum(one.planned for one in parts)
    note = f"{left} of {planned} planned flights were not flown; the same command without --budget flies them."
    rows = tuple((one.name, one.planned, one.flown, one.not_flown) for one in parts)
    return Table(title, (header, "planned", "flown", "not flown"), rows, (note,))


@dataclass(frozen=True)
class ScoredFlights:
    """A campaign with its score.

    Attributes:
        study: the study, with the grid of the campaign.
        campaign: name of the campaign.
        rulings: what each flight shows beside its baseline.
        score: the score.
        noise: noise of a stack that is not deterministic; else empty.
        warning: what a reader must know of the platforms of the flights; "" where there is nothing.
        stale: the flights of the campaign that no longer count.
        accepted: the survivors that somebody accepted.
        looks: looks of the run that flew, where it was sequential.
        unflown: what the run that flew left out.
    """

    study: Study
    campaign: str
    rulings: Rulings
    score: Score
    noise: tuple[Noise, ...] = ()
    warning: str = ""
    stale: Stale = NONE
    accepted: tuple[Accepted, ...] = ()
    looks: tuple[Look, ...] = ()
    unflown: tuple[Unflown, ...] = ()

    @cached_property
    def coverage(self) -> Coverage:
        """The situation coverage."""
        return coverage_of(self.rulings.baselines, self.rulings.draws, self.study.space)

    @property
    def run(self) -> tuple[Table, ...]:
        """Tables about the run that flew: its looks, or what it left out."""
        return (*((look_table(self.looks),) if self.looks else ()), *unflown_tables(self.unflown))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader must know beside the score, in sentences; often nothing."""
        _, unread = _dispositions(self.study)
        return (*filter(None, [self.warning, unread]), *self.stale.sentences, *self.study.finds.warnings)

    def answer(self, form: Output, by: By | None = None, *, everything: bool = False) -> Answer:
        """What `run` and `score` answer; the arguments are those of `text`, `form` is that of the JSON."""
        return Answer(
            form,
            lambda: self.values(by),
            lambda: (*self.screen(whole=False), *self.run),
            told=lambda how: self.text(how, by=by, everything=everything),
            warnings=self.warnings,
        )

    def screen(self, *, whole: bool) -> tuple[Table, ...]:
        """The first screen as tables; `whole`: long groups are shown to their ends."""
        return first_screen(
            self.score,
            self.study.roster,
            self.study.space,
            self.coverage,
            self._background,
            campaign=self.campaign,
            finds=self.study.finds,
            noise=self.noise,
            accepted=self.accepted,
            whole=whole,
        )

    def text(self, how: Format, *, by: By | None = None, everything: bool = False) -> str:
        """The score as text.

        Args:
            how: form of the tables; JSON is `record`.
            by: adds the score part by part.
            everything: whether every mutant and every table is shown, not only the first screen.
        """
        screen = self.screen(whole=everything or how is not Format.TABLE)
        behind: Sequence[Table] = ()
        if everything:
            behind = tables_behind(self.score, self.rulings, self.coverage, self.study.space, by)
        elif by:
            behind = (group_table(self.score, by, self.study.space),)
        if how is not Format.TABLE:
            return render((*screen, *behind, *self.run), how)
        text, more = screen_text(screen), (*behind, *self.run)
        return joined([text, render(more, Format.TABLE)]) if more else text

    def record(self, by: By | None = None) -> dict[str, Any]:
        """The score as `score --format json` prints it; `by` adds the score part by part."""
        return SCORE.record(self.values(by))

    def values(self, by: By | None = None) -> dict[str, Any]:
        """The plain JSON values of the form `SCORE`, without its version."""
        space = self.study.space
        violated = [(finding.situation, finding.violated) for finding in findings(self.rulings.baselines, space)]
        return score_json(
            self.score,
            self.coverage,
            violated,
            groups(self.score, by, space) if by else (),
            noise=self.noise,
            looks=[look_record(look) for look in self.looks],
            unflown=plain(self.unflown),
            accepted=self.accepted,
            stale=self.stale,
        )

    def _background(self, mutant: str) -> Background | None:
        return backgrounds(self.study.matrix, [mutant])[mutant]


def scored_campaign(
    study: Study, campaign: str, baseline_from: str | None = None, today: date | None = None
) -> ScoredFlights:
    """Score the flights that a campaign holds.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        baseline_from: name of a campaign whose baselines join the pool.
        today: the day by which dispositions expire; by default the system's date.

    Raises:
        InputError: a campaign does not exist, holds no flight that counts, or cannot lend its baselines.
    """
    with snapshot(study, campaign) as now:
        study, rulings, spending, warning = now.study, now.rulings, now.spending, now.platform_warning
        noise, stale, campaign = _noise(study, now.outcomes), now.stale, now.name
    others: Iterable[Outcome] = ()
    if baseline_from:
        flown = rulings.situations
        listed = study.space.holding(flown).situations
        others = borrowed(study, baseline_from, [key for key, _ in listed if key in flown])
    score = score_of(rulings, study.roster, study.space, spending, others)
    return ScoredFlights(study, campaign, rulings, score, noise, warning, stale, _accepted(study, score, today))


def detected_so_far(study: Study, outcomes: Iterable[Outcome], spending: Spending) -> list[str]:
    """Lines of what `scaloft-fi score` would count as detected now, of the mutants flown so far.

    Args:
        study: the study.
        outcomes: what the campaign holds.
        spending: of the campaign's alpha.
    """
    scored = score_of(rulings_of(outcomes), study.roster, study.space, spending)
    faults = scored.counted or [mutant for mutant in scored.mutants if mutant.flown]
    flown = Counter(mutant.subject.guideword for mutant in faults)
    detected = Counter(mutant.subject.guideword for mutant in faults if mutant.detected)
    if not flown:
        return []
    known = [word.id for word in study.matrix.guidewords if flown[word.id]]
    words = "  ".join(f"`{word} {detected[word]}/{flown[word]}`" for word in known)
    text = f"detected so far: {detected.total()} of {flown.total()} flown:  {words}"
    return wrapped(text, width() - 1, "", "  ").replace("`", "").split("\n")


def scored_run(flown: FlownRun, campaign: str) -> ScoredFlights:
    """Score the flights of a run; `campaign` is the name of its campaign."""
    planned, report = flown.planned, flown.report
    study = planned.study
    score = score_of(flown.rulings, study.roster, study.space, report.spending, planned.others)
    left = () if planned.request.sequential else unflown(planned.plan, report.left)
    noise = _noise(study, report.outcomes)
    with snapshot(study, campaign) as now:
        stale = now.stale
    accepted, looks = _accepted(study, score, None), tuple(flown.looks)
    return ScoredFlights(study, campaign, flown.rulings, score, noise, report.mixture, stale, accepted, looks, left)


def _accepted(study: Study, score: Score, today: date | None) -> tuple[Accepted, ...]:
    dispositions, _ = _dispositions(study)
    return accepted_survivors(score, study.roster, dispositions, today or date.today())  # noqa: DTZ011 - the user's day


def _dispositions(study: Study) -> tuple[tuple[Disposition, ...], str]:
    """The dispositions of a study; none, and why, where the file is not filled in: a score needs none of them."""
    try:
        return study.dispositions, ""
    except InputError as error:
        return (), f"no survivor counts as accepted: {error}"


def _noise(study: Study, outcomes: Iterable[Outcome]) -> tuple[Noise, ...]:
    return noise_of(outcomes) if not study.stack.deterministic else ()


GROUPINGS = ("guideword", "parameter", "severity", "situation", "requirement", "axis")


@verb(
    "score",
    examples=(
        ("Ask which faults the tests would have shown", "scaloft-fi score"),
        ("See every mutant, and the score of each guideword", "scaloft-fi score --all --by guideword"),
        ("Hold a pipeline to what a team has accepted", "scaloft-fi score --fail-under-firm 0.25 --ratchet"),
    ),
    sections={
        "Where": "--study --campaign --baseline-from",
        "What fails": "--fail-under --fail-under-firm --ratchet --today",
        "What is printed": "--by --all --format --tables --help",
    },
)
def score_command(
    *,
    study_folder: StudyFolder,
    campaign: Campaign,
    grouping: Annotated[
        str | None,
        Option(
            f"The score part by part as well, by {', '.join(GROUPINGS[:-1])} or {GROUPINGS[-1]}.",
            "--by",
            metavar="WHAT",
            type=click.Choice(GROUPINGS),
        ),
    ],
    baseline_from: BaselineFrom,
    everything: Everything,
    style: TableFormat,
    fail_under: FailUnder,
    fail_under_firm: FailUnderFirm,
    ratcheting: Annotated[
        bool,
        Option(
            "Exit with 3 when a counted mutant is not detected that the study's hazop/dispositions.yaml does not "
            "accept, or a disposition has expired.",
            "--ratchet",
        ),
    ],
    tables_folder: TablesFolder,
    today: Today,
) -> int:
    """Say which faults the tests would have shown, which not, how sure that is, and what to do next."""
    scored = scored_campaign(Study.open(study_folder), campaign, baseline_from, today)
    code = report(
        scored,
        SCORE,
        grouping=grouping,
        everything=everything,
        style=style,
        tables=tables_folder,
        bars=Bars(fail_under, fail_under_firm),
    )
    if not ratcheting:
        return code
    from scaloft_fi.verbs.dispositions import ratchet

    return ratchet(scored.study, scored.score, today) or code


class Bars(NamedTuple):
    """The least ratios that count as a success; None asks for nothing."""

    detected: float | None
    firm: float | None

    def __bool__(self) -> bool:
        return self.detected is not None or self.firm is not None

    def __str__(self) -> str:
        """The first option that is given, as the user wrote it."""
        if self.detected is not None:
            return f"--fail-under={self.detected:g}"
        return f"--fail-under-firm={self.firm:g}"


def report(
    scored: ScoredFlights,
    output: Output,
    *,
    grouping: str | None,
    everything: bool,
    style: str,
    tables: Path | None,
    bars: Bars,
) -> int:
    """Print what a campaign says; returns the exit code.

    Args:
        scored: the campaign with its score.
        output: the form of its JSON.
        grouping: `--by`.
        everything: `--all`.
        style: `--format`.
        tables: `--tables`.
        bars: `--fail-under` and `--fail-under-firm`.

    Raises:
        InputError: one of the bars where there is no pool to decide by.
    """
    if bars and not scored.score.pooled:
        raise InputError(
            f"{bars} needs a baseline pool: campaign {scored.campaign!r} has fewer than ten "
            "baseline flights wherever a mutant infects; `scaloft-fi run` flies them"
        )

    by = By(grouping) if grouping else None
    answer(scored.answer(output, by, everything=everything), style, tables)
    detected, firm = scored.score.mutation_score, scored.score.firm
    below = [
        f"{option} {least:g}"
        for option, least, ratio in (
            ("--fail-under", bars.detected, detected),
            ("--fail-under-firm", bars.firm, firm),
        )
        if least is not None and (ratio.value is None or ratio.value < least)
    ]
    if not below:
        return 0
    say(f"mutation score {detected}, firm {firm}: below {' and '.join(below)}")
    return ExitCode.BELOW
