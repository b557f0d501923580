"""`scaloft-fi doctor`: the platform, the installation, and whether a known flight has its published digest."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb
from scaloft_fi.console import say
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
@tables_option
@click.option("--no-flight", is_flag=True, help="Do not fly the known flight.")
def doctor_command(study_folder: Path | None, style: str, tables_folder: Path | None, no_flight: bool) -> None:
    """Print what decides the bits of a flight and what is installed, and fly a flight whose digest is published.

    Other bits on another platform are no failure; another status, ending or violation is: exit code 4.
    """
    from scaloft_fi.campaign.processes import one_thread_each

    one_thread_each()
    from scaloft_fi.views.outputs.answer import Answer
    from scaloft_fi.views.runs.installation import (
        DOCTOR,
        installation_tables,
        machine_values,
        package_values,
        platform_values,
        plugin_values,
        study_values,
    )

    plugins, broken = plugin_values()
    study, faults = study_values(study_folder)
    failure: Exception | None = None
    known = None
    if not no_flight:
        from scaloft_fi.campaign.runs.gates import fly_again
        from scaloft_fi.errors import GateError

        try:
            known = {"same": True, "told": fly_again(say)}
        except GateError as error:
            known, failure = {"same": False, "told": str(error)}, error
    values = {
        "platform": platform_values(),
        "packages": package_values(),
        "plugins": plugins,
        "study": study,
        "machine": machine_values(),
        "known_flight": known,
        "faults": [*broken, *faults],
    }
    answer(Answer(DOCTOR, lambda: values, lambda: installation_tables(values)), style, tables_folder)
    if failure is not None:
        raise failure
    if broken or faults:
        raise InputError("; ".join((*broken, *faults)))
