"""What several verbs ask and how verbs answer: shared options, files that the user names, `--format`, `--tables`."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable
from datetime import date
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click
from click.core import ParameterSource

from scaloft_fi.console import say, tell
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import find_study, nearest_study
from scaloft_fi.output import unwritable, write_named
from scaloft_fi.verbs.names import campaigns, grids

if TYPE_CHECKING:
    from scaloft_fi.study import Study
    from scaloft_fi.views.output import Answer


F = TypeVar("F", bound=Callable[..., Any])

FORMATS = ("table", "markdown", "csv", "json", "latex")


def study_option(function: F) -> F:
    """`--study DIR`: the study to work on; the verb says which one it uses where the user has none."""

    @wraps(function)
    def told(*args: Any, study_folder: Path | None, **options: Any) -> Any:
        tell_study(study_folder, quiet=options.get("quiet", False), campaign=options.get("campaign", ""))
        return function(*args, study_folder=study_folder, **options)

    return cast(F, _study_option(told))


def _study_option(function: F) -> F:
    return click.option(
        "--study",
        "study_folder",
        type=click.Path(path_type=Path),
        metavar="DIR",
        help="A folder with hazop/, mutants/ and sim/.  [default: the nearest one upwards, else the packaged study]",
    )(function)


def campaign_option(function: F) -> F:
    """`--campaign NAME`: where the outcomes are."""
    return click.option(
        "--campaign",
        shell_complete=campaigns,
        default=CAMPAIGN,
        show_default=True,
        metavar="NAME",
        help="A folder in the study's results/campaigns/; a NAME with a / or .zip is the path of a folder or archive.",
    )(function)


def grid_option(function: F) -> F:
    """`--grid NAME`: the situations to fly."""
    return click.option(
        "--grid",
        shell_complete=grids,
        metavar="NAME",
        help="A grid of the study: that of sim/situations.yaml, or a file in sim/grids/, whose campaign is called NAME "
        "when --campaign names no other.  [default: the grid of the campaign, else that of sim/situations.yaml]",
    )(function)


def grid_of_study_option(function: F) -> F:
    """`--grid NAME`: one of the study's grids, without a campaign."""
    return click.option(
        "--grid",
        shell_complete=grids,
        metavar="NAME",
        help="A grid of the study: a file in sim/grids/.  [default: that of sim/situations.yaml]",
    )(function)


def campaign_over(grid: str | None, campaign: str) -> str:
    """The campaign of the command: that of the user, else the one named by the grid, else the default."""
    source = click.get_current_context().get_parameter_source("campaign")
    return grid if grid is not None and source is ParameterSource.DEFAULT else campaign


def baseline_from_option(function: F) -> F:
    """`--baseline-from NAME`: a campaign whose baselines join the pool."""
    return click.option(
        "--baseline-from",
        "baseline_from",
        shell_complete=campaigns,
        metavar="NAME",
        help="Add the baselines of this campaign to the pool; its platform, data and code must be the same.",
    )(function)


def format_option(function: F) -> F:
    """`--format`: how tables are printed."""
    return click.option(
        "--format",
        "style",
        type=click.Choice(FORMATS),
        default="table",
        show_default=True,
        help="How tables are printed.",
    )(function)


def all_option(function: F) -> F:
    """`--all`: every mutant and every table."""
    return click.option(
        "--all", "everything", is_flag=True, help="Print every mutant and every table, not only the first screen."
    )(function)


def fail_under_option(function: F) -> F:
    """`--fail-under RATIO` and `--fail-under-firm RATIO`: the least mutation score that counts as a success."""
    return click.option(
        "--fail-under",
        type=click.FloatRange(0.0, 1.0),
        metavar="RATIO",
        help="Exit with 3 when the mutation score (0..1) is below RATIO; refused without a baseline pool.",
    )(_fail_under_firm(function))


def _fail_under_firm(function: F) -> F:
    return click.option(
        "--fail-under-firm",
        type=click.FloatRange(0.0, 1.0),
        metavar="RATIO",
        help="Exit with 3 when the share (0..1) of mutants that are detected whichever one seed is left out is below "
        "RATIO; refused without a baseline pool.",
    )(function)


def today_option(function: F) -> F:
    """`--today DATE`: the day by which dispositions expire."""
    return click.option(
        "--today",
        callback=_day,
        metavar="YYYY-MM-DD",
        help="The day by which dispositions expire; the mutation score does not depend on it.  [default: the system's "
        "date]",
    )(function)


def as_of_option(function: F) -> F:
    """`--today DATE`: the day by which dispositions expire; by default none is judged."""
    return click.option(
        "--today",
        callback=_day,
        metavar="YYYY-MM-DD",
        help="Mark the dispositions that have expired by this day.  [default: the last days are shown, not judged]",
    )(function)


def _day(_context: click.Context, _option: click.Parameter, text: str | None) -> date | None:
    if text is None:
        return None
    from scaloft_fi.study import parse_date

    found = parse_date(text)
    if found is None:
        raise click.BadParameter(f"{text!r} is not a date such as 2027-01-31")
    return found


def operability_option(function: F) -> F:
    """`--operability`: the requirements whose violation kills."""
    return click.option(
        "--operability",
        is_flag=True,
        help="Margins against the operability requirements instead of the safety requirements.",
    )(function)


def warnings_option(function: F) -> F:
    """`--warnings`: print each violation when it happens."""
    return click.option(
        "--warnings",
        is_flag=True,
        help="Print a line for each violation when it happens, by the unmutated drone too.  "
        "[default: violations are counted; the campaign's mission_log.json lists them]",
    )(function)


def same_platform_option(function: F) -> F:
    """`--same-platform`: only flights with the bits of this platform count."""
    return click.option(
        "--same-platform",
        is_flag=True,
        help="Make stored flights of another platform stale when a sample of them has other digests here.  "
        "[default: when it has another status, ending or violation]",
    )(function)


def quiet_option(function: F) -> F:
    """`--quiet`: print only the result."""
    return click.option(
        "--quiet",
        is_flag=True,
        help="Print only the result, and no progress, count of violations or warning while drones fly.",
    )(function)


def typed() -> str:
    """The command that the user typed, quoted for a shell."""
    program = Path(sys.argv[0]).name
    return shlex.join([*(["python", "-m", "scaloft_fi"] if program == "__main__.py" else [program]), *sys.argv[1:]])


def check_writable(path: Path | None) -> None:
    """Refuse early what could not be written late; None is fine.

    Raises:
        InputError: no file can be written there.
    """
    if path is None:
        return
    try:
        path.stat()
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:
        raise InputError(f"--output={str(path)!r} cannot be written: {unwritable(error)}") from error
    if path.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: it is a folder")
    if not path.parent.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: there is no folder {str(path.parent)!r}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(f"--output={str(path)!r} cannot be written: no permission")


def write(path: Path, content: bytes, option: str = "--output") -> None:
    """Write the whole file, or leave what was there; `option` names it.

    Raises:
        InputError: it cannot be written.
    """
    write_named(path, content, option)


def check_folder(path: Path, option: str) -> None:
    """Refuse early a folder that could not be made or written late; `option` names it.

    Raises:
        InputError: no file can be written in a folder of this path.
    """
    try:
        existing = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    except (OSError, ValueError) as error:
        raise InputError(f"{option}={str(path)!r} cannot be written: {unwritable(error)}") from error
    if not existing.is_dir():
        raise InputError(f"{option}={str(path)!r} cannot be written: {str(existing)!r} is a file, not a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"{option}={str(path)!r} cannot be written: no permission in {str(existing)!r}")


def make_folder(path: Path, option: str) -> None:
    """Make the folder and those above it, where they are missing; `option` names it.

    Raises:
        InputError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{option}={str(path)!r} cannot be made: {unwritable(error)}") from error


def tables_option(function: F) -> F:
    """`--tables DIR`: every table as a CSV file."""
    return click.option(
        "--tables",
        "tables_folder",
        type=click.Path(path_type=Path),
        callback=_checked,
        metavar="DIR",
        help="Also write each table of --format json as a CSV file of its own into the folder DIR, made if missing.",
    )(function)


def line_format_option(function: F) -> F:
    """`--format` of a verb whose answer is a few lines, not a table."""
    return click.option(
        "--format",
        "style",
        type=click.Choice(("table", "json")),
        default="table",
        show_default=True,
        help="How the answer is printed: a line for people, or JSON.",
    )(function)


def answer(given: Answer, style: str, folder: Path | None = None) -> None:
    """Print a verb's answer and its warnings, and write its tables where `--tables` asks for them.

    Args:
        given: the answer.
        style: `--format`.
        folder: `--tables`.

    Raises:
        InputError: a table cannot be written.
    """
    tell_warnings(given)
    if folder is not None:
        make_folder(folder, "--tables")
        for name, text in given.csv().items():
            write(folder / f"{name}.csv", text.encode(), "--tables")
    tell(given.text(style))


def tell_warnings(given: Answer) -> None:
    """Say on standard error what a reader must know beside an answer."""
    for warning in given.warnings:
        say(f"warning: {warning}")


def _checked(_context: click.Context, _option: click.Parameter, folder: Path | None) -> Path | None:
    if folder is not None:
        check_folder(folder, "--tables")
    return folder


REMEDY = "make a study of your own with `scaloft-fi new DIR`, or name one with --study"


def check_own(study: Study, named: Path | None, path: Path) -> None:
    """Refuse to write `path` into a study that the user neither named nor stands in, or that is the package's.

    Raises:
        InputError: as above.
    """
    if study.packaged or (named is None and nearest_study() is None):
        raise InputError(f"{path} belongs to the reference study of this installation and is not written; {REMEDY}")


def tell_study(named: Path | None, *, quiet: bool, campaign: str = "") -> None:
    """Say in a line on standard error which study is used, where the user neither named one nor stands in one.

    Args:
        named: the study that the user named.
        quiet: whether nothing is said.
        campaign: the campaign that the user named, which may be an archive that has its study.

    Raises:
        InputError: there is no study at all.
    """
    if named is None and not quiet and nearest_study() is None and not _has_study(campaign):
        say(f"study: {find_study()}, the reference study of this installation; there is none here: {REMEDY}")


def _has_study(campaign: str) -> bool:
    """Whether the campaign is an archive that may have a study of its own."""
    if "/" not in campaign and not campaign.endswith(".zip"):
        return False
    from scaloft_fi.campaign.store.archive import is_archive

    return is_archive(Path(campaign))
