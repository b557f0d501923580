"""`scaloft-fi replay`: fly one flight again, bit for bit, and draw it."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import line_format_option
from scaloft_fi.cli.files import check_writable, write
from scaloft_fi.cli.options import campaign_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say, tell, tell_line
from scaloft_fi.errors import GateError, InputError

ENDS = (".svg", ".png", ".mcap", ".csv")


@verb(
    "replay",
    examples=(
        ("Fly one flight again and compare its digest", "scaloft-fi replay LATE-human@3s/T0O0W0D0H1/0"),
        (
            "Draw it on the map, the baseline beside it",
            "scaloft-fi replay LATE-human@3s/T0O0W0D0H1/0 --output flight.svg",
        ),
        ("Record the unmutated drone for Foxglove", "scaloft-fi replay baseline/T0O0W0D0H1/0 --output flight.mcap"),
    ),
)
@click.argument("name", shell_complete=names.flights, metavar="MUTANT/SITUATION/SEED")
@study_option
@campaign_option
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write a map of the flight (.svg, .png), a recording for Foxglove (.mcap), or a table of its log (.csv).",
)
@click.option("--gui", is_flag=True, help="Watch the flight in PyBullet's window, in real time.")
@click.option(
    "--same-platform",
    is_flag=True,
    help="Exit with 4 when the digest differs from that of a flight of another platform.  "
    "[default: when status, ending or violations differ]",
)
@line_format_option
def replay_command(
    name: str,
    study_folder: Path | None,
    campaign: str,
    output: Path | None,
    gui: bool,
    same_platform: bool,
    style: str,
) -> None:
    """Fly one flight again and compare its digest with the campaign's; on another platform, status and ending too.

    MUTANT is `baseline`, `PLACEBO` or a mutant's id.  The map shows the baseline beside the mutant.
    """
    if output is not None and output.suffix.lower() not in ENDS:
        raise InputError(f"--output={str(output)!r} must end in .svg, .png, .mcap or .csv")
    check_writable(output)
    from scaloft_fi.campaign.processes import one_thread_each

    one_thread_each()
    from scaloft_fi.campaign.store.flown_grid import study_of
    from scaloft_fi.views.flights.logged_flight import RECORDINGS, fly_with_log, named, ready_to_fly, with_log
    from scaloft_fi.views.flights.repeated import Likeness, comparison
    from scaloft_fi.views.flights.replayed import REPLAY, replay_values
    from scaloft_fi.views.pictures.picture import png
    from scaloft_fi.views.tables.table import Format, render

    study = study_of(study_folder, campaign)
    if gui and study.command:
        raise InputError("--gui shows flights of our simulator, and a command flies this study (sim/flyer.yaml)")
    flight = ready_to_fly(study, *named(name), say)
    if gui:
        from scaloft_fi.campaign.flights.physics import fly_in_window

        flown = with_log(study, flight, fly_in_window(study, flight))
    else:
        flown = fly_with_log(study, flight)
    if style != "json":
        tell(render((flown.facts(),), Format.TABLE))
        tell("\n")
    end = output.suffix.lower() if output else ""
    if output is not None and end in RECORDINGS:
        write(output, flown.recording(end))
    elif output is not None:
        write(output, png(flown.map()) if end == ".png" else flown.map().encode())
    if output is not None and style != "json":
        tell_line(f"{'recording' if end in RECORDINGS else 'map'}: {output}")
    found = comparison(flown, campaign, same_platform=same_platform)
    if style == "json":
        words = study.grid.titles(flight.situation)
        tell(REPLAY.json(replay_values(flown.outcome, words, found, None if output is None else str(output))))
    if found.likeness is Likeness.DIFFERS:
        raise GateError(found.told)
    if style != "json":
        tell_line(found.told)
