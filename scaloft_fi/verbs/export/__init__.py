r"""`scaloft-fi export`: one row per flight, or the campaign in the format of another tool.

A format is one function in a file of this folder, or in a package that names its module in the entry-point group
`scaloft_fi.plugins`:

    @export_format("killed-ids", "ids of the detected mutants, one a line")
    def killed_ids(dossier: Dossier) -> str:
        return "".join(f"{mutant.subject.id}\n" for mutant in dossier.score.mutants if mutant.detected)
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Annotated

import click

from scaloft_fi.errors import InputError
from scaloft_fi.output import say, tell, write_named
from scaloft_fi.registry import load_plugins
from scaloft_fi.study import Study
from scaloft_fi.verbs import names, options
from scaloft_fi.verbs.export.dossier import FORMATS, Dossier, ExportFormat, dossier, export_format, unzipped
from scaloft_fi.verbs.options import Option, check_folder, check_writable, make_folder, verb

__all__ = ["FORMATS", "Dossier", "ExportFormat", "export_format"]

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")


ARCHIVE, ZIP = "archive", ".zip"
"""The format of several files; the end of the name of one that holds them all."""


class ExportCommand(options.Verb):
    """Its help lists every format, those of plugins too."""

    def sections(self, ctx: click.Context) -> list[tuple[str, list[tuple[str, str]]]]:
        """The options, then the formats."""
        load_plugins()
        formats = [(name, FORMATS[name].summary) for name in sorted(FORMATS)]
        return [*super().sections(ctx), ("Formats", formats)]


@verb("export", cls=ExportCommand)
def export_command(
    *,
    study_folder: options.StudyFolder,
    campaign: options.Campaign,
    style: Annotated[
        str,
        Option("One of the formats listed below.", "--format", metavar="NAME", complete=names.formats, default="json"),
    ],
    today: options.Today,
    output: Annotated[Path | None, Option("Write there instead of printing.", metavar="FILE")],
) -> None:
    """Print one row per flight, ordered by mutant, situation and seed, or the campaign in another tool's format.

    Facts of the simulation only: no clock, host or worker is in it; the day decides which survivors are accepted.

    Examples:
        Write one row per flight for pandas: `scaloft-fi export --format parquet --output flights.parquet`
        Give what is not detected to a code host: `scaloft-fi export --format sarif --output scaloft.sarif`
        Keep a campaign with its study for a paper: `scaloft-fi export --format archive --output campaign.zip`
    """
    study = Study.open(study_folder)
    chosen = FORMATS[style]
    if style == ARCHIVE and output is not None and output.suffix != ZIP:
        _check_new(output)
    else:
        check_writable(output, *chosen.ends, what=f"--format {style}")
    if output is None and not chosen.text:
        raise InputError(f"--format={style!r} is no text: give --output FILE")
    made = dossier(study, campaign, today)
    for warning in (*made.invalid, *made.finds.warnings):
        say(f"warning: {warning}")
    content = chosen.content(made)
    if output is None:
        tell(content)
    elif style == ARCHIVE and output.suffix != ZIP:
        for name, file in unzipped(content).items():
            make_folder((output / name).parent, "--output")
            write_named(output / name, file)
    else:
        write_named(output, content)


def _check_new(folder: Path) -> None:
    """Refuse to put an archive into a folder with other files.

    Raises:
        InputError: there is something of this name that is no empty folder, or no folder can be made there.
    """
    check_folder(folder, "--output")
    if folder.exists() and any(folder.iterdir()):
        raise InputError(f"--output={str(folder)!r} must be a new or empty folder, or end in {ZIP}")
