"""The options that several verbs share, each declared once."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from datetime import date
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import click
from click.core import ParameterSource

from scaloft_fi.cli import names
from scaloft_fi.cli.own_study import tell_study
from scaloft_fi.defaults import CAMPAIGN

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
        shell_complete=names.campaigns,
        default=CAMPAIGN,
        show_default=True,
        metavar="NAME",
        help="A folder in the study's results/campaigns/; a NAME with a / or .zip is the path of a folder or archive.",
    )(function)


def grid_option(function: F) -> F:
    """`--grid NAME`: the situations to fly."""
    return click.option(
        "--grid",
        shell_complete=names.grids,
        metavar="NAME",
        help="A grid of the study: that of sim/situations.yaml, or a file in sim/grids/, whose campaign is called NAME "
        "when --campaign names no other.  [default: the grid of the campaign, else that of sim/situations.yaml]",
    )(function)


def grid_of_study_option(function: F) -> F:
    """`--grid NAME`: one of the study's grids, without a campaign."""
    return click.option(
        "--grid",
        shell_complete=names.grids,
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
        shell_complete=names.campaigns,
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
