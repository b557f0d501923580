"""What `dispositions` answers."""

from __future__ import annotations

from datetime import date

from scaloft_fi.analysis.score import Score
from scaloft_fi.analysis.survivor import Judged, judge
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study
from scaloft_fi.views.dispositions import DISPOSITIONS, disposition_table, disposition_values
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.score.finds import next_find
from scaloft_fi.views.score.verdict import NO_POOL
from scaloft_fi.views.snapshot import snapshot


def dispositions(study: Study, campaign: str, today: date | None = None) -> Answer:
    """The survivors of a campaign beside those that somebody accepted.

    Args:
        study: the study, with any of its grids.
        campaign: name of the campaign.
        today: the day by which dispositions expire; by default the system's date.

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
