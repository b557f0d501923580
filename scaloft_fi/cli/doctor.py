"""`scaloft-fi doctor`: the platform, the installation, and whether a known flight has its published digest."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say, tell
from scaloft_fi.errors import InputError


@verb(
    "doctor",
    examples=(
        ("See whether this machine has the published bits", "scaloft-fi doctor"),
        ("List versions only, and fly nothing", "scaloft-fi doctor --no-flight"),
        ("Check that plugins and a study load", "scaloft-fi doctor --study my_study --no-flight"),
    ),
)
@study_option
@format_option
@click.option("--no-flight", is_flag=True, help="Do not fly the known flight.")
def doctor_command(study_folder: Path | None, style: str, no_flight: bool) -> None:
    """Print what decides the bits of a flight and what is installed, and fly a flight whose digest is published.

    Other bits on another platform are no failure; another status, ending or violation is: exit code 4.
    """
    from scaloft_fi.campaign.processes.start import one_thread_each

    one_thread_each()
    from scaloft_fi.views.runs.installation import packages_table, places_table, platform_table, plugins_table
    from scaloft_fi.views.tables.table import Format, Table, render

    plugins, broken = plugins_table()
    places, faults = places_table(study_folder)
    tables = [platform_table(), packages_table(), plugins, places]
    failure: Exception | None = None
    if not no_flight:
        from scaloft_fi.campaign.runs.known_flight import fly_again
        from scaloft_fi.errors import GateError

        try:
            told = fly_again(say)
        except GateError as error:
            told, failure = str(error), error
        tables.append(Table("Known flight", ("answer",), ((told,),)))
    tell(render(tables, Format(style)))
    if failure is not None:
        raise failure
    if broken or faults:
        raise InputError("; ".join((*broken, *faults)))
