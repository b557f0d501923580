"""`scaloft-fi merge`: join campaigns flown in parts."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer, line_format_option
from scaloft_fi.cli.options import campaign_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "merge",
    examples=(
        ("Join two parts, flown with --shard 1/2 and --shard 2/2", "scaloft-fi merge part1 part2"),
        ("Join them into a campaign of another name", "scaloft-fi merge part1 part2 --campaign whole"),
        ("Join a folder from another machine, bits and all", "scaloft-fi merge /data/night/campaign --same-platform"),
    ),
)
@click.argument("sources", shell_complete=names.campaigns, metavar="CAMPAIGN...", nargs=-1, required=True)
@study_option
@campaign_option
@click.option(
    "--same-platform",
    is_flag=True,
    help="Refuse a campaign of another platform unless flights in both show equal digests.  "
    "[default: refuse it where a flight in both has another status, ending or violation]",
)
@line_format_option
def merge_command(
    sources: tuple[str, ...], study_folder: Path | None, campaign: str, same_platform: bool, style: str
) -> None:
    """Join CAMPAIGNs, such as those flown with `run --shard K/N`, into the one named by --campaign.

    Campaigns of two platforms are compared, flight by flight; where both flew the same situation and seed, the flights
    of the first stay, because a mutant is judged beside a baseline of its own platform.

    The run's own command, without --shard, then holds the gates over the whole and prints the tables; it flies nothing.
    """
    from scaloft_fi.campaign.store.flown_grid import study_of_all
    from scaloft_fi.views.answers.merge import merge

    study = study_of_all(study_folder, [*sources, campaign])
    answer(merge(study, campaign, sources, same_platform=same_platform), style)
