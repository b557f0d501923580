"""A campaign with its score, and how `run`, `score` and a script show it: tables, text, plain JSON values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.coverage import Coverage, coverage_of
from scaloft_fi.analysis.detection import Noise, noise_of
from scaloft_fi.analysis.pool import findings
from scaloft_fi.analysis.roster import plain
from scaloft_fi.analysis.score import By, Score, groups, score_of
from scaloft_fi.analysis.survivor import Accepted, Background, Disposition, accepted_survivors, backgrounds
from scaloft_fi.campaign.runs.request import Look
from scaloft_fi.campaign.runs.run import borrowed
from scaloft_fi.console import joined
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import Rulings
from scaloft_fi.study import Study
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.runs.looks import look_record, look_table
from scaloft_fi.views.runs.unflown import Unflown, unflown, unflown_tables
from scaloft_fi.views.score.first_screen import first_screen, screen_text
from scaloft_fi.views.score.score_form import SCORE
from scaloft_fi.views.score.score_record import score_json
from scaloft_fi.views.score.tables import group_table, tables_behind
from scaloft_fi.views.snapshot import snapshot
from scaloft_fi.views.stale import NONE, Stale
from scaloft_fi.views.tables.table import Format, Table, render

if TYPE_CHECKING:
    from scaloft_fi.campaign.runs.request import Flown


@dataclass(frozen=True)
class ScoredCampaign:
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
) -> ScoredCampaign:
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
    return ScoredCampaign(study, campaign, rulings, score, noise, warning, stale, _accepted(study, score, today))


def scored_run(flown: Flown, campaign: str) -> ScoredCampaign:
    """Score the flights of a run; `campaign` is the name of its campaign."""
    planned, report = flown.planned, flown.report
    study = planned.study
    score = score_of(flown.rulings, study.roster, study.space, report.spending, planned.others)
    left = () if planned.request.sequential else unflown(planned.plan, report.left)
    noise = _noise(study, report.outcomes)
    with snapshot(study, campaign) as now:
        stale = now.stale
    accepted, looks = _accepted(study, score, None), tuple(flown.looks)
    return ScoredCampaign(study, campaign, flown.rulings, score, noise, report.mixture, stale, accepted, looks, left)


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
