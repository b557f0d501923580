"""What `merge` answers."""

from __future__ import annotations

from collections.abc import Sequence

from scaloft_fi.campaign.runs.merge import merge as merged_into
from scaloft_fi.campaign.store.archive import campaign_folder
from scaloft_fi.console import line
from scaloft_fi.study import Study
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.runs.merged import MERGE, merge_values
from scaloft_fi.views.tables.table import Table


def merge(study: Study, campaign: str, sources: Sequence[str], *, same_platform: bool = False) -> Answer:
    """Join campaigns into `campaign`, which need not exist.

    Args:
        study: the study, with the grid of all of them.
        campaign: name of the campaign that gets the flights.
        sources: names of the others.
        same_platform: whether flights of another platform must have equal digests.

    Raises:
        GateError: a flight has other digests on one platform, or other facts on two; nothing is written.
        InputError: there is no such campaign, or it cannot be written.
    """
    folder = campaign_folder(study, campaign)
    merged = merged_into(study, folder, [campaign_folder(study, name) for name in sources], same_platform=same_platform)
    told = line(f"{merged.added} flights added to {folder}, {merged.known} known already")
    return Answer(
        MERGE,
        lambda: merge_values(folder, merged),
        lambda: (Table(told, (), ()),),
        told=lambda _how: f"{told}\n",
        warnings=merged.warnings,
    )
