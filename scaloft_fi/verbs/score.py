"""`scaloft-fi score`, `dispositions`: what a campaign's flights say, again; its survivors beside the accepted ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from datetime import date
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import click

from scaloft_fi.analysis.coverage import Coverage, coverage_of
from scaloft_fi.analysis.detection import Look, Noise, Pair, SituationBaseline, Spending, Verdict, findings, noise_of
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import By, Group, Score, groups, score_of
from scaloft_fi.analysis.survivor import Disposition, Judged, Standing, accepted_survivors, judge, score_without
from scaloft_fi.campaign.store.archive import borrowed, flown_in
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.errors import ExitCode, GateError, InputError
from scaloft_fi.hazop.matrix import CellStatus
from scaloft_fi.hazop.render import signs_grid
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Rulings, rulings_of
from scaloft_fi.output import in_campaign, joined, say, width
from scaloft_fi.study import Study, append_drafts
from scaloft_fi.verbs import options
from scaloft_fi.verbs.first_screen import Screen, group_table, tables_behind
from scaloft_fi.verbs.options import Campaign, Option, StudyFolder, TableFormat, Today, answer, check_own, verb
from scaloft_fi.verbs.snapshot import NONE, Stale, snapshot
from scaloft_fi.verbs.verdict import NO_POOL, next_find, signs_of
from scaloft_fi.views.output import Answer, Columns, Output
from scaloft_fi.views.table import Format, Table, counted, render, said

if TYPE_CHECKING:
    from scaloft_fi.campaign.flights.fly import Flight
    from scaloft_fi.campaign.plan import Plan
    from scaloft_fi.campaign.runs.request import FlownRun


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
        judged, campaign, invalid = judged_survivors(now.study, score, today), now.name, now.stale.invalid
    found = {mutant.subject.id for mutant in score.mutants if next_find(mutant, finds)}
    told = Dispositions(tuple(JudgedSurvivor.of(one, has_find=one.mutant in found) for one in judged))
    table = said(disposition_table(told, campaign), of_tests=score.of_tests)
    return Answer(DISPOSITIONS, lambda: told, lambda: (table,), warnings=(*invalid, *finds.warnings))


def judged_survivors(study: Study, scored: Score, today: date | None = None) -> tuple[Judged, ...]:
    """The survivors and the dispositions; `today` as of `dispositions`.

    Raises:
        InputError: there is no pool; without one nobody knows what survives.
    """
    if not scored.pooled:
        raise InputError(f"no mutant is known to survive: {NO_POOL}")
    return judge(scored, study.roster, study.dispositions, today or date.today())  # noqa: DTZ011 - the user's own day


@verb("dispositions")
def dispositions_command(
    *,
    study_folder: StudyFolder,
    campaign: Campaign,
    writing: Annotated[
        bool,
        Option(
            "Append every survivor without an entry to the study's hazop/dispositions.yaml, with the status to_do: "
            "it stays open until somebody accepts it, with owner, reason and last day.",
            "--write",
        ),
    ],
    today: Today,
    style: TableFormat,
) -> None:
    """List the survivors of a campaign beside the study's dispositions.

    `scaloft-fi score --ratchet` makes a gate of it.

    Examples:
        List what survives, and what was accepted: `scaloft-fi dispositions`
        Draft an entry for each open survivor: `scaloft-fi dispositions --write`
        See what will have expired by a day: `scaloft-fi dispositions --today 2027-01-31`
    """
    study = Study.open(study_folder)
    if writing:
        check_own(study, study_folder, study.dispositions_path)
    told = dispositions(study, campaign, today=today)
    answer(told, style)
    if writing:
        _draft(study, told["survivors"])


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


def _draft(study: Study, survivors: Columns) -> None:
    """Append an entry for each survivor that has none, and say so."""
    path, opened = study.dispositions_path, survivors["mutant"][survivors["state"] == Standing.OPEN]
    new = append_drafts(path, study.matrix, opened)
    if new:
        say(f"{path}: {counted(len(new), 'survivor')} to decide on; to accept one, give it owner, reason and expires")
    else:
        say("nothing to write: no survivor without an entry")


def look_table(looks: Sequence[Look]) -> Table:
    """How the looks went."""
    headers = ("seeds", "mutants", "flights", *(verdict.words for verdict in Verdict))
    notes = (
        "Only the undecided fly on, where the pool has a steady pair.  Each look spends a quarter of alpha.",
        "Flights: of mutants, planned for the look; PLACEBO and baselines fly beside them.",
    )
    return Table("Looks", headers, tuple(map(astuple, looks)), notes)


@dataclass(frozen=True)
class Unflown:
    """A part of a plan of which flights were not flown.

    Attributes:
        by: what the parts are.
        name: of the part: a parameter or a subject, or the key of a situation.
        planned: flights.
        flown: of these flights, flown.
        not_flown: of these flights, not flown.
    """

    by: Literal["parameter", "situation"]
    name: str
    planned: int
    flown: int
    not_flown: int


def unflown(planned: Plan, left: Sequence[Flight]) -> tuple[Unflown, ...]:
    """The plan by parameter, then by situation; nothing where no flight is left."""
    flights = list(dict.fromkeys((*planned.known, *left))) if left else []

    def parts(by: Literal["parameter", "situation"], part: Callable[[Flight], str]) -> Iterator[Unflown]:
        missing = Counter(map(part, left))
        for name, count in Counter(map(part, flights)).items():
            yield Unflown(by, name, count, count - missing[name], missing[name])

    return (
        *parts("parameter", lambda flight: flight.subject.parameter or flight.subject.id),
        *parts("situation", lambda flight: flight.situation.key),
    )


def unflown_tables(parts: Sequence[Unflown]) -> tuple[Table, ...]:
    """Two tables, or none when nothing is left."""
    tables = []
    for by in ("parameter", "situation") if parts else ():
        rows = tuple((one.name, one.planned, one.flown, one.not_flown) for one in parts if one.by == by)
        left, planned = sum(row[-1] for row in rows), sum(row[1] for row in rows)
        note = f"{left} of {planned} planned flights were not flown; the same command without --budget flies them."
        tables.append(Table(f"Not flown, by {by}", (by, "planned", "flown", "not flown"), rows, (note,)))
    return tuple(tables)


@dataclass(frozen=True)
class Ratios:
    """The ratios, over the default mutants of credible cells.

    Attributes:
        score: of the campaign.
        without_accepted: mutants detected, of those flown that are no accepted survivors.
    """

    score: Score
    without_accepted: Ratio
    KEYS = ("score.*", "without_accepted")


@dataclass(frozen=True)
class Composition:
    """What the ratio is made of, over the default mutants of credible cells."""

    score: Score
    KEYS = ("score.behaviours", "score.without_kill", "score.trivial", "score.without_effect")


@dataclass(frozen=True)
class ScoredFlights:
    """A campaign with its score: which faults the requirements would have shown.

    Attributes:
        study: the study, with the grid of the campaign.
        campaign: name of the campaign.
        rulings: what each flight shows beside its baseline.
        score: the score.
        noise: of a stack that is not deterministic: the noise of robustness; else empty.
        warning: what a reader must know of the flights, such as their platforms; "" where there is nothing.
        stale: the stored flights that no longer count and were not flown again.
        accepted: the survivors that somebody accepted, of the mutants that the ratios count.
        looks: of `run --sequential`: its looks; else empty.
        unflown: of `run --budget`: where planned flights were not flown; else empty.
        by: what the parts are of which the score is told too; None: it is not told part by part.
    """

    study: Study
    campaign: str
    rulings: Rulings
    score: Score
    noise: tuple[Noise, ...] = ()
    warning: str = ""
    stale: Stale = NONE
    accepted: tuple[Disposition, ...] = ()
    looks: tuple[Look, ...] = ()
    unflown: tuple[Unflown, ...] = ()
    by: By | None = None
    KEYS = (
        *("score.alpha", "score.pooled", "ratios", "score.expected_false", "score.redraw", "composition"),
        *("score.mutants", "score.controls", "pairs", "score.lacking", "score.selected", "proposed"),
        *("coverage", "baseline", "groups", "noise", "looks", "unflown", "accepted", "stale"),
    )

    @property
    def proposed(self) -> tuple[str, ...]:
        """The requirements that decide, and that `propose` chose because of a mutant's flights."""
        return tuple(one.name for one in self.study.requirements if one.selected)

    @cached_property
    def coverage(self) -> Coverage:
        """How much of the situations the flights cover."""
        return coverage_of(self.rulings.baselines, self.rulings.draws, self.study.space)

    @property
    def ratios(self) -> Ratios:
        """The ratios, over the default mutants of credible cells."""
        return Ratios(self.score, score_without(self.score, self.accepted))

    @property
    def composition(self) -> Composition:
        """What the ratio is made of, over the default mutants of credible cells."""
        return Composition(self.score)

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """What the baseline pool says of each requirement in each situation."""
        return tuple(self.score.pool.pairs.values())

    @property
    def baseline(self) -> tuple[SituationBaseline, ...]:
        """What the unmutated drone violates."""
        return findings(self.rulings.baselines, self.study.space)

    @property
    def groups(self) -> tuple[Group, ...]:
        """With `--by`, the score part by part, over the default mutants of credible cells; else empty."""
        return groups(self.score, self.by, self.study.space) if self.by else ()

    @property
    def run(self) -> tuple[Table, ...]:
        """Tables about the run that flew: its looks, or what it left out."""
        return (*((look_table(self.looks),) if self.looks else ()), *unflown_tables(self.unflown))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader must know beside the score, in sentences; often nothing."""
        _, unread = _dispositions(self.study)
        to_do = self.study.matrix.counts()[CellStatus.TO_DO]
        draft = f"{counted(to_do, 'cell')} of the matrix to do: without a mutant, and in no ratio" if to_do else ""
        told = (self.warning, unread, draft, self._never_lands)
        return (*filter(None, told), *self.stale.sentences, *self.study.finds.warnings)

    @property
    def _never_lands(self) -> str:
        """That the drone without a fault does not end its mission; empty where a flight ends otherwise."""
        endings = [outcome.ending for outcome in self.rulings.baselines if not outcome.invalid]
        if self.study.command or self.score.of_tests or not endings or set(endings) != {"timed_out"}:
            return ""
        return (
            f"the unmutated drone lands in none of its {counted(len(endings), 'flight')}, and flies to the time limit"
        )

    @property
    def screen(self) -> Screen:
        """What the flights say, on the first screen or whole."""
        known = (self.noise, self.accepted, self.stale.invalid)
        return Screen(self.study, self.score, self.coverage, self.campaign, *known)

    def text(self, how: Format, *, everything: bool = False) -> str:
        """The score as text.

        Args:
            how: form of the tables.
            everything: whether every mutant and every table is shown, not only the first screen.
        """
        more = self.run
        if everything:
            more = (*tables_behind(self.score, self.rulings, self.coverage, self.study.space, self.by), *more)
        elif self.by:
            more = (group_table(self.score, self.by, self.study.space), *more)
        more = tuple(said(table, of_tests=self.score.of_tests) for table in more)
        if how is not Format.TABLE:
            return render((*self.screen.tables, *more), how)
        return joined([self.screen.text(whole=everything), *([render(more, how)] if more else [])])


SCORE = Output("score", "3.2", ScoredFlights, "mutants", "which faults the requirements would have shown")
RUN = replace(SCORE, verb="run", about="what was flown: the form of `score`, with how the run went")


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
        noise, stale, campaign = () if study.stack.deterministic else noise_of(now.outcomes), now.stale, now.name
    flown = rulings.situations
    keys = [key for key, _ in study.space.holding(flown).situations if key in flown]
    others = borrowed(study, baseline_from, keys) if baseline_from else ()
    score = score_of(rulings, study.roster, study.space, spending, others)
    return ScoredFlights(study, campaign, rulings, score, noise, warning, stale, _accepted(study, score, today))


def shown_so_far(study: Study, outcomes: Iterable[Outcome], spending: Spending) -> list[str]:
    """Lines of what `scaloft-fi score` would say now: how many of the faults flown so far, and the signs of the cells.

    Args:
        study: the study.
        outcomes: what the campaign holds.
        spending: of the campaign's alpha.
    """
    scored = score_of(rulings_of(outcomes), study.roster, study.space, spending)
    told = f"shown so far: {sum(mutant.detected for mutant in scored.faults)} of {len(scored.faults)} flown"
    return [told, *signs_grid(study.matrix, signs_of(scored), width() - 1)] if scored.faults else []


def scored_run(flown: FlownRun, campaign: str) -> ScoredFlights:
    """Score the flights of a run; `campaign` is the name of its campaign."""
    planned, report = flown.planned, flown.report
    study = planned.study
    score = score_of(flown.rulings, study.roster, study.space, report.spending, planned.others)
    left = () if planned.request.sequential else unflown(planned.plan, report.left)
    noise = () if study.stack.deterministic else noise_of(report.outcomes)
    with snapshot(study, campaign) as now:
        stale, beyond = now.stale, len(now.now.flights) - len(now.now.stale) - len(report.outcomes)
    judged = f"{beyond} more flights of the campaign are not judged here, as the run did not ask for them"
    whole = f"{judged}; `scaloft-fi score{in_campaign(campaign)}` judges all" if beyond > 0 else ""
    warning = "  ".join(filter(None, [report.mixture, whole]))
    accepted, looks = _accepted(study, score, None), tuple(flown.looks)
    return ScoredFlights(study, campaign, flown.rulings, score, noise, warning, stale, accepted, looks, left)


def _accepted(study: Study, score: Score, today: date | None) -> tuple[Disposition, ...]:
    dispositions, _ = _dispositions(study)
    return accepted_survivors(score, study.roster, dispositions, today or date.today())  # noqa: DTZ011 - the user's day


def _dispositions(study: Study) -> tuple[tuple[Disposition, ...], str]:
    """The dispositions of a study; none, and why, where the file is not filled in: a score needs none of them."""
    try:
        return study.dispositions, ""
    except InputError as error:
        return (), f"no survivor counts as accepted: {error}"


GROUPINGS = tuple(map(str, By))


@verb(
    "score",
    sections={
        "Where": "--study --campaign --baseline-from",
        "What fails": "--fail-under --fail-under-firm --ratchet --today",
        "What is printed": "--by --all --format --tables --help",
    },
)
def score_command(
    *,
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    grouping: Annotated[
        str | None,
        Option(
            f"The score part by part as well, by {', '.join(GROUPINGS[:-1])} or {GROUPINGS[-1]}.",
            "--by",
            metavar="WHAT",
            type=click.Choice(GROUPINGS),
        ),
    ],
    baseline_from: options.BaselineFrom,
    everything: options.Everything,
    style: options.TableFormat,
    fail_under: options.FailUnder,
    fail_under_firm: options.FailUnderFirm,
    ratcheting: Annotated[
        bool,
        Option(
            "Exit with 3 when a counted mutant is not detected that the study's hazop/dispositions.yaml does not "
            "accept, or a disposition has expired.",
            "--ratchet",
        ),
    ],
    tables_folder: options.TablesFolder,
    today: options.Today,
) -> int:
    """Say which faults the tests would have shown, which not, how sure that is, and what to do next.

    Examples:
        Ask which faults the tests would have shown: `scaloft-fi score`
        See every mutant, and the score of each guideword: `scaloft-fi score --all --by guideword`
        Hold a pipeline to what a team has accepted: `scaloft-fi score --fail-under-firm 0.25 --ratchet`
    """
    scored = scored_campaign(Study.open(study_folder), campaign, baseline_from, today)
    scored = replace(scored, by=By(grouping) if grouping else None)
    bars = bars_of(fail_under, fail_under_firm)
    for option in (*bars, *(["--ratchet"] if ratcheting else ())) if scored.stale.invalid else ():
        raise GateError(f"{option}: {scored.stale.invalid[0]}")
    code = report(scored, SCORE, everything=everything, style=style, tables=tables_folder, bars=bars)
    return (ratchet(scored.study, scored.score, today) if ratcheting else 0) or code


def bars_of(fail_under: float | None, fail_under_firm: float | None) -> dict[str, float]:
    """The least ratio that counts as a success, by the option that asks for it."""
    asked = {"--fail-under": fail_under, "--fail-under-firm": fail_under_firm}
    return {option: least for option, least in asked.items() if least is not None}


def report(
    scored: ScoredFlights,
    output: Output,
    *,
    everything: bool,
    style: str,
    tables: Path | None,
    bars: Mapping[str, float],
) -> int:
    """Print what a campaign says; returns the exit code.

    Args:
        scored: the campaign with its score.
        output: the form of its JSON.
        everything: `--all`.
        style: `--format`.
        tables: `--tables`.
        bars: as of `bars_of`.

    Raises:
        InputError: one of the bars where there is no pool to decide by.
    """
    for option, least in bars.items() if not scored.score.pooled else ():
        raise InputError(
            f"{option}={least:g} needs a baseline pool: campaign {scored.campaign!r} has fewer than ten baseline "
            f"flights wherever a mutant infects; `scaloft-fi run{in_campaign(flown_in(scored.campaign))}` flies them"
        )

    words = partial(scored.text, everything=everything)
    answer(Answer(output, lambda: scored, told=words, warnings=scored.warnings), style, tables)
    return below(scored.score, bars)


def below(score: Score, bars: Mapping[str, float]) -> int:
    """The exit code of a score, with a sentence where a ratio is below its bar."""
    reached = {"--fail-under": score.mutation_score, "--fail-under-firm": score.firm}
    shares = {option: reached[option].value for option in bars}
    short = [f"{option} {bars[option]:g}" for option, own in shares.items() if own is None or own < bars[option]]
    if not short:
        return 0
    detected, firm = reached.values()
    say(f"mutation score {detected}, firm {firm}: below {' and '.join(short)}")
    return ExitCode.BELOW
