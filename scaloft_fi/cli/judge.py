"""`scaloft-fi judge`: judge records of flights with the study's requirements."""

from __future__ import annotations

from pathlib import Path

import click

from scaloft_fi.cli import names
from scaloft_fi.cli.answer import answer, tables_option
from scaloft_fi.cli.options import format_option, study_option
from scaloft_fi.cli.verb import verb


@verb(
    "judge",
    examples=(
        ("Judge a record of a flight in a known situation", "scaloft-fi judge flight.csv --situation T0O0W0D0H1"),
        (
            "Judge PX4's logs, with where the signals stand in them",
            "scaloft-fi judge monday.ulg tuesday.ulg --record px4.yaml",
        ),
        ("Let a script read the verdicts", "scaloft-fi judge bag/ --format json"),
    ),
)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=click.Path(path_type=Path))
@study_option
@click.option(
    "--record",
    "mapping_file",
    type=click.Path(path_type=Path),
    metavar="MAPPING.yaml",
    help="Where the signals stand in the records.  [default: sim/record.yaml of the study, else the mapping of the "
    "records that replay --output writes]",
)
@click.option(
    "--situation",
    shell_complete=names.situations,
    metavar="KEY",
    help="The situation that was flown, which has a route and a time limit.  [default: not known]",
)
@format_option
@tables_option
def judge_command(
    files: tuple[Path, ...],
    study_folder: Path | None,
    mapping_file: Path | None,
    situation: str | None,
    style: str,
    tables_folder: Path | None,
) -> None:
    """Judge records of flights (.csv, .mcap, .ulg, .bag, .db3, or a folder of rosbag2) with the study's requirements.

    Nothing is flown and no campaign is read.  A violation is a finding: the exit code is 0.
    """
    from scaloft_fi.study import Study
    from scaloft_fi.views.answers.judge import judge

    answer(judge(Study.open(study_folder), files, mapping_file, situation), style, tables_folder)
