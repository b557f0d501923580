"""`scaloft-fi merge`: join campaigns flown in parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from scaloft_fi.campaign.runs.merge import Merged
from scaloft_fi.campaign.runs.merge import merge as merged_into
from scaloft_fi.campaign.store.archive import campaign_folder
from scaloft_fi.campaign.store.flown_grid import study_of_all
from scaloft_fi.console import line
from scaloft_fi.study import Study
from scaloft_fi.verbs.names import campaigns
from scaloft_fi.verbs.options import Campaign, LineFormat, Option, Several, StudyFolder, answer
from scaloft_fi.verbs.verb import verb
from scaloft_fi.views.output import Answer, Output
from scaloft_fi.views.table import Table

MERGE = Output("merge", "1.0", Merged, rows="summary")


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
        MERGE, lambda: merged, lambda: (Table(told, (), ()),), told=lambda _how: f"{told}\n", warnings=merged.warnings
    )


MergedCampaigns = Annotated[Several, Option("Names of the campaigns.", "", metavar="CAMPAIGN...", complete=campaigns)]
MergedPlatform = Annotated[
    bool,
    Option(
        "Refuse a campaign of another platform unless flights in both show equal digests.",
        otherwise="refuse it where a flight in both has another status, ending or violation",
    ),
]


@verb(
    "merge",
    examples=(
        ("Join two parts, flown with --shard 1/2 and --shard 2/2", "scaloft-fi merge part1 part2"),
        ("Join them into a campaign of another name", "scaloft-fi merge part1 part2 --campaign whole"),
        ("Join a folder from another machine, bits and all", "scaloft-fi merge /data/night/campaign --same-platform"),
    ),
)
def merge_command(
    *,
    sources: MergedCampaigns,
    study_folder: StudyFolder,
    campaign: Campaign,
    same_platform: MergedPlatform,
    style: LineFormat,
) -> None:
    """Join CAMPAIGNs, such as those flown with `run --shard K/N`, into the one named by --campaign.

    Campaigns of two platforms are compared, flight by flight; where both flew the same situation and seed, the flights
    of the first stay, because a mutant is judged beside a baseline of its own platform.

    The run's own command, without --shard, then holds the gates over the whole and prints the tables; it flies nothing.
    """
    study = study_of_all(study_folder, [*sources, campaign])
    answer(merge(study, campaign, sources, same_platform=same_platform), style)
