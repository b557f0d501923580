"""What `status` answers."""

from __future__ import annotations

from scaloft_fi.study import Study
from scaloft_fi.views.flights.status import STATUS, status_tables, status_values
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.snapshot import snapshot


def status(study: Study, campaign: str) -> Answer:
    """How many flights a campaign holds, by status, and why those are stale that do not count any more.

    Raises:
        InputError: there is no such campaign.
    """
    with snapshot(study, campaign) as now:
        values = status_values(now)
    return Answer(STATUS, lambda: values, lambda: status_tables(values))
