"""What a report is made from: a study, and the outcomes of one campaign with their tracks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.campaign.store.held import nothing_to_show
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.study import Study
from scaloft_fi.views.snapshot import snapshot
from scaloft_fi.views.stale import NONE, Stale


@dataclass(frozen=True)
class Evidence:
    """Everything that the page is made from.

    Attributes:
        study: what was flown.
        campaign: its name, for commands.
        outcomes: those that the study still stands for, with their tracks.
        stale: flights that no longer count.
        owed: flights planned and not flown.
        fingerprint: of the platform that flew them, by name.
        today: by which dispositions expire; None = none does.
        spending: how the campaign spends alpha.
    """

    study: Study
    campaign: str
    outcomes: tuple[Outcome, ...]
    stale: Stale = NONE
    owed: int = 0
    fingerprint: Mapping[str, str] | None = None
    today: date | None = None
    spending: Spending = field(default_factory=Spending)


def gather(study: Study, campaign: str, today: date | None = None) -> Evidence:
    """Read the campaign, all of it at one moment; `today` is the day by which dispositions expire.

    Raises:
        InputError: there is none, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        known = now.held.current or nothing_to_show(now.store, now.folder)
        return Evidence(
            study=now.study,
            campaign=now.name,
            outcomes=now.with_tracks(known, {outcome.mutant for outcome in known}),
            stale=now.stale,
            owed=now.held.owed,
            fingerprint=now.platform,
            today=today,
            spending=now.spending,
        )
