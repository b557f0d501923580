"""What `coverage` answers."""

from __future__ import annotations

from scaloft_fi.analysis.coverage import coverage_of
from scaloft_fi.study import Study
from scaloft_fi.views.coverage.coverage_record import COVERAGE, coverage_values
from scaloft_fi.views.coverage.coverage_tables import coverage_tables
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.snapshot import snapshot


def coverage(study: Study, campaign: str) -> Answer:
    """How much of the situations a campaign covers, number by number.

    Raises:
        InputError: there is no such campaign, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        space, rulings, choices, stale = now.study.space, now.rulings, now.choices, now.stale
    covered = coverage_of(rulings.baselines, rulings.draws, space)
    made = [(one.text, one.seed, len(one.draws), len({key for key, _ in one.draws})) for one in choices]
    return Answer(
        COVERAGE,
        lambda: coverage_values(covered, choices) | stale.values,
        lambda: coverage_tables(covered, space, made),
        warnings=stale.sentences,
    )
