"""How a verb is declared: what it asks, its page of help, how it answers; and the options that several verbs share.

The parameters of a verb's function are its options: a mark in the type of a parameter says how the command line asks
for it.  Scripts pass the same parameters (`scaloft_fi.scripting`).
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from functools import partial, wraps
from inspect import Parameter, cleandoc, get_annotations, signature
from pathlib import Path
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Union, get_args, get_origin

import click
from click.core import ParameterSource

from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.document import is_there, parse_date, read_text
from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.hazop.load import find_study, named_study, nearest_study, study_around
from scaloft_fi.output import (
    PROSE,
    Style,
    coloured,
    line,
    say,
    styled,
    tell,
    unwritable,
    width,
    with_study,
    wrapped,
    write_named,
    write_whole,
    writing,
)
from scaloft_fi.verbs import names

if TYPE_CHECKING:
    from scaloft_fi.study import Study
    from scaloft_fi.views.output import Answer


FORMATS = ("table", "markdown", "csv", "json", "latex")


@dataclass(frozen=True, eq=False)
class Option:
    """How the command line asks for a parameter: a mark in its type, `Annotated[int, Option("...", metavar="N")]`.

    Attributes:
        about: what it is; "" for an argument, which the help of the verb tells.
        flag: name of the option; by default that of the parameter, `--by-requirement`; "" for an argument.
        metavar: what stands for the value in the help.
        complete: finds the values that a shell offers.
        type: of click, where the type of the parameter does not say enough.
        check: reads or refuses the value: `callback` of click.
        default: the value without the option, where the parameter itself has none.
        otherwise: what is done without the option, in words.
    """

    about: str = ""
    flag: str | None = None
    metavar: str | None = None
    complete: Callable[..., Any] | None = None
    type: Any = None
    check: Callable[..., Any] | None = None
    default: Any = None
    otherwise: str = ""


@dataclass(frozen=True)
class DefaultWords:
    """What this verb does without an option that others have too, in words."""

    text: str


def parameters_of(function: Callable[..., Any]) -> Iterator[click.Parameter]:
    """The options and arguments of a verb's function, in their order; other parameters without a mark are left out.

    A parameter `study` is asked for as `--study`; where the function returns an `Answer`, there are `--format` and
    `--tables`.
    """
    hints = get_annotations(function, eval_str=True)
    found = {name: (hints[name], one.default) for name, one in signature(function).parameters.items() if name in hints}
    if "study" in found:
        found["study"] = StudyFolder, None
    if _answers(hints):
        found |= {"style": (TableFormat, "table"), "tables_folder": (TablesFolder, None)}
    for name, (hint, default) in found.items():
        option, otherwise = marked(hint)
        if option is not None:
            yield _asked(name, hint.__origin__, option, default, otherwise)


def several(given: Several, name: str) -> tuple[str, ...]:
    """One text, or several.

    Raises:
        InputError: there is something else.
    """
    anything: object = given  # whatever a script gives
    listed = tuple(anything) if isinstance(anything, Iterable) and not isinstance(anything, str) else (given,)
    for one in listed:
        if not isinstance(one, str):
            raise InputError(f"{name}={one!r} must be a text, or a sequence of texts")
    return listed


def called(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, called with what the command line gives: the study opened, the answer printed."""
    hints = get_annotations(function, eval_str=True)

    name = next((name for name in ("study", "study_folder") if name in hints), None)

    @wraps(function)
    def call(**given: Any) -> Any:
        if name is not None and given.get(name) is None and "/" in given.get("other", "/"):  # a bare name is of here
            given[name] = study_around(str(given.get("campaign") or ""))
        with named_study(given.get(name or "")):
            try:
                return answered(given)
            except ScaloftError as error:
                error.args = (with_study(str(error)),)
                raise

    def answered(given: dict[str, Any]) -> Any:
        if (name is not None and hasattr(hints[name], "__metadata__")) or name == "study":
            tell_study(given[name], quiet=given.get("quiet", False), campaign=given.get("campaign") or "")
        if name == "study":
            given["study"] = _opened(given)
        if not _answers(hints):
            return function(**given)
        style, tables = given.pop("style"), given.pop("tables_folder")
        return answer(function(**given), style, tables)

    return call


def _opened(given: Mapping[str, Any]) -> Study:
    """The study that the command line names, or that of the campaign that it names, over its grid."""
    from scaloft_fi.campaign.store.archive import study_of
    from scaloft_fi.study import Study

    folder, grid = given["study"], given.get("grid")
    return study_of(folder, given["campaign"], grid) if "grid" in given else Study.open(folder)


def _answers(hints: dict[str, Any]) -> bool:
    """Whether a function with these types returns an `Answer`."""
    return hasattr(hints.get("return"), "csv")


def marked(hint: Any) -> tuple[Option | None, str]:
    """How the command line asks for a parameter of this type, and what is done without the option."""
    marks = getattr(hint, "__metadata__", ())
    option = next((mark for mark in reversed(marks) if isinstance(mark, Option)), None)
    otherwise = option.otherwise if option else ""
    return option, next((mark.text for mark in reversed(marks) if isinstance(mark, DefaultWords)), otherwise)


def _asked(name: str, hint: Any, option: Option, default: Any, otherwise: str) -> click.Parameter:
    """The option or argument for a parameter of this type."""
    forms = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    sequence = next((form for form in forms if get_origin(form) is Sequence or get_origin(hint) is tuple), None)
    bare = get_args(sequence)[0] if sequence else next(form for form in forms if form is not NoneType)
    given: dict[str, Any] = {
        "type": option.type or (click.Path(path_type=Path) if bare is Path else bare),
        "metavar": option.metavar,
        "callback": option.check or (_finite if bare is float else None),
        "shell_complete": option.complete,
    }
    if option.flag == "":
        return click.Argument([name], nargs=-1 if sequence else 1, required=default is Parameter.empty, **given)
    names = [option.flag or f"--{name.replace('_', '-')}", name]
    about = option.about + f"  [default: {otherwise}]" * bool(otherwise)
    if bare is bool:
        return click.Option(names, is_flag=True, help=about)
    value = option.default if default in (Parameter.empty, None, ()) else default
    shown: dict[str, Any] = {} if value is None else {"default": value, "show_default": True}
    return click.Option(names, multiple=bool(sequence), help=about, **shown, **given)


def _finite(_context: click.Context, _option: click.Parameter, number: float | None) -> float | None:
    if number is not None and not math.isfinite(number):  # nan is beyond no bound of click's
        raise click.BadParameter(f"{number} is not a finite number")
    return number


def _day(_context: click.Context, _option: click.Parameter, text: str | None) -> date | None:
    if text is None:
        return None
    found = parse_date(text)
    if found is None:
        raise click.BadParameter(f"{text!r} is not a date such as 2027-01-31")
    return found


def _checked(_context: click.Context, _option: click.Parameter, folder: Path | None) -> Path | None:
    if folder is not None:
        check_folder(folder, "--tables")
    return folder


Several = str | Sequence[str]
"""One text, or several."""
GridOption = partial(Option, metavar="NAME", complete=names.grids)
CampaignOption = partial(Option, metavar="NAME", complete=names.campaigns)
SeedsOption = partial(Option, type=str, metavar="N|A-B")
SeedOption = partial(Option, metavar="S", type=click.IntRange(min=0), default=0)
SituationOption = partial(Option, flag="--situation", metavar="KEY|GLOB", complete=names.situations)
CountOption = partial(Option, metavar="N", type=click.IntRange(min=1))
FormatOption = partial(Option, flag="--format", default="table")
FlightSeed = Annotated[int, SeedOption("Seed of the noise.")]
_Ratio = partial(Option, metavar="RATIO", type=click.FloatRange(0.0, 1.0))
_Day = partial(Option, metavar="YYYY-MM-DD", type=str, check=_day)
StudyFolder = Annotated[
    Path | None,
    Option(
        "A folder with hazop/, mutants/ and sim/.",
        "--study",
        metavar="DIR",
        otherwise="the nearest one upwards, else the packaged study",
    ),
]
Campaign = Annotated[
    str,
    CampaignOption(
        "A folder in the study's results/campaigns/; a NAME with a / or .zip is the path of a folder or archive.",
        default=CAMPAIGN,
    ),
]
FlownGrid = Annotated[
    str | None,
    GridOption(
        "A grid of the study: that of sim/situations.yaml, or a file in sim/grids/, whose campaign is called NAME "
        "when --campaign names no other.",
        otherwise="the grid of the campaign, else that of sim/situations.yaml",
    ),
]
GridOfStudy = Annotated[
    str | None, GridOption("A grid of the study: a file in sim/grids/.", otherwise="that of sim/situations.yaml")
]
Situations = Annotated[
    Several, SituationOption("A situation's key or alias, or a pattern (repeatable).", otherwise="the whole grid")
]
BaselineFrom = Annotated[
    str | None,
    CampaignOption("Add the baselines of this campaign to the pool; its platform, data and code must be the same."),
]
Today = Annotated[
    date | None,
    _Day(
        "The day by which dispositions expire; the mutation score does not depend on it.", otherwise="the system's date"
    ),
]
AsOf = Annotated[
    date | None,
    _Day("Mark the dispositions that have expired by this day.", otherwise="the last days are shown, not judged"),
]
Operability = Annotated[
    bool, Option("Margins against the operability requirements instead of the safety requirements.")
]
Jobs = Annotated[int | None, CountOption("Worker processes.", otherwise="the processors")]
SamePlatform = Annotated[
    bool,
    Option(
        "Make stored flights of another platform stale when a sample of them has other digests here.",
        otherwise="when it has another status, ending or violation",
    ),
]
Warnings = Annotated[
    bool,
    Option(
        "Print a line for each violation when it happens, by the unmutated drone too.",
        otherwise="violations are counted; the campaign's mission_log.json lists them",
    ),
]
Quiet = Annotated[
    bool, Option("Print only the result, and no progress, count of violations or warning while drones fly.")
]
Untrusted = Annotated[
    bool,
    Option(
        "Refuse a study that starts programs of its own (exit code 2).",
        otherwise="a terminal asks once, else a line on standard error names them",
    ),
]
Everything = Annotated[bool, Option("Print every mutant and every table, not only the first screen.", "--all")]
FailUnder = Annotated[
    float | None, _Ratio("Exit with 3 when the mutation score (0..1) is below RATIO; refused without a baseline pool.")
]
FailUnderFirm = Annotated[
    float | None,
    _Ratio(
        "Exit with 3 when the share (0..1) of mutants detected whichever one seed is left out is below RATIO.  "
        "Refused without a baseline pool."
    ),
]
TableFormat = Annotated[str, FormatOption("How tables are printed.", type=click.Choice(FORMATS))]
LineFormat = Annotated[
    str, FormatOption("How the answer is printed: a line for people, or JSON.", type=click.Choice(("table", "json")))
]
TablesFolder = Annotated[
    Path | None,
    Option(
        "Also write each table of --format json as a CSV file of its own into the folder DIR, made if missing.",
        "--tables",
        metavar="DIR",
        check=_checked,
    ),
]


def campaign_over(grid: str | None, campaign: str) -> str:
    """The campaign of the command: that of the user, else the one named by the grid, else the default."""
    source = click.get_current_context().get_parameter_source("campaign")
    return grid if grid is not None and source is ParameterSource.DEFAULT else campaign


def typed() -> str:
    """The command that the user typed, quoted for a shell."""
    program = Path(sys.argv[0]).name
    return shlex.join([*(["python", "-m", "scaloft_fi"] if program == "__main__.py" else [program]), *sys.argv[1:]])


PAGE, ENTRIES = (".html", ".htm"), (".yaml", ".yml")
"""Ends of names of files: of a page, and of entries for a document of the study."""
KNOWN_ENDS = frozenset(
    {*PAGE, *ENTRIES, ".csv", ".docx", ".dot", ".json", ".mcap", ".md", ".ods", ".parquet", ".pdf", ".png", ".sarif"}
    | {".svg", ".tex", ".txt", ".xls", ".xlsx", ".xml", ".zip"}
)
"""Ends by which people and programs know of what kind a file is."""


def check_writable(path: Path | None, *ends: str, what: str = "") -> None:
    """Refuse early what could not be written late; None is fine.

    Args:
        path: the value of `--output`.
        ends: the ends that its name may have; by default any.
        what: what is written whatever the name, in words: then an end is fine too that is not one of `KNOWN_ENDS`.

    Raises:
        InputError: the name ends otherwise, or no file can be written there.
    """
    if path is None:
        return
    end = path.suffix.lower()
    if ends and end not in ends and (not what or end in KNOWN_ENDS):
        allowed = " or ".join(filter(None, (", ".join(ends[:-1]), ends[-1])))
        raise InputError(f"--output={str(path)!r} must end in {allowed}" + f", because {what} is written" * bool(what))
    with writing(f"--output={str(path)!r} cannot be written"), suppress(FileNotFoundError):
        path.stat()
    if path.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: it is a folder")
    if not path.parent.is_dir():
        raise InputError(f"--output={str(path)!r} cannot be written: there is no folder {str(path.parent)!r}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(f"--output={str(path)!r} cannot be written: no permission")


def check_folder(path: Path, option: str) -> None:
    """Refuse early a folder that could not be made or written late; `option` names it.

    Raises:
        InputError: no file can be written in a folder of this path.
    """
    with writing(f"{option}={str(path)!r} cannot be written"):
        existing = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    if not existing.is_dir():
        raise InputError(f"{option}={str(path)!r} cannot be written: {str(existing)!r} is a file, not a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"{option}={str(path)!r} cannot be written: no permission in {str(existing)!r}")


def make_folder(path: Path, option: str) -> None:
    """Make the folder and those above it, where they are missing; `option` names it.

    Raises:
        InputError: it cannot be made.
    """
    with writing(f"{option}={str(path)!r} cannot be made"):
        path.mkdir(parents=True, exist_ok=True)


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
            write_named(folder / f"{name}.csv", text.encode(), "--tables")
    tell(given.text(style))
    for error in given.errors[:-1]:
        say(f"error: {error}")
    if given.errors:
        raise InputError(given.errors[-1])


def tell_warnings(given: Answer) -> None:
    """Say on standard error what a reader must know beside an answer."""
    for warning in given.warnings:
        say(f"warning: {warning}")


def programs_of(study: Study) -> tuple[str, ...]:
    """The commands that a flight of the study starts, as a shell would read them; none where all that flies is ours.

    Raises:
        InputError: stack or command cannot be read.
    """
    if study.command is not None:
        words = [word.text for word in study.command.run]
        return (_typed(words, {name: text.text for name, text in study.command.env.items()}, "."),)
    processes = getattr(study.sim.stack.settings(study.stack), "processes", ())
    return tuple(_typed(one.run, one.env, one.folder) for one in processes)


def _typed(run: Sequence[str], env: Mapping[str, str], folder: str) -> str:
    before = [f"cd {_quoted(folder)};"] if folder != "." else []
    return " ".join([*before, *(f"{name}={_quoted(text)}" for name, text in env.items()), *map(_quoted, run)])


def _quoted(word: str) -> str:
    """The word for a shell; braces around the name of a value are none of its marks."""
    return word if re.fullmatch(r"[\w@%+=:,./{}-]+", word) else shlex.quote(word)


def allow(study: Study, *, untrusted: bool) -> None:
    """Name the programs of its own that a study starts, before it does; on a terminal ask once, and remember.

    What was allowed is a line of `trusted` in the user's folder of settings: a digest of the study's real path and its
    commands, then the path.

    Raises:
        InputError: there are programs, and `untrusted` or the user refuses them.
    """
    if study.tests_of:
        raise InputError(f"the campaign has runs of tests and no flights; `{study.again}` runs them")
    programs, folder = programs_of(study), study.folder.resolve()
    if not programs:
        return
    named = f"{folder} starts programs of its own: {'; '.join(programs)}"
    if untrusted:
        raise InputError(f"--untrusted refuses that {named}")
    file = Path(click.get_app_dir("scaloft-fi")) / "trusted"
    digest = hashlib.sha256(json.dumps([str(folder), programs]).encode()).hexdigest()
    before = read_text(file) if is_there(file) else ""
    if digest in {known[:64] for known in before.splitlines()}:
        return
    say(f"study: {named}")
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return
    if not click.confirm("Start them, now and whenever this study flies?", err=True):
        raise InputError(f"{folder}: its programs were not allowed, so nothing was flown")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, f"{before}{digest} {line(str(folder))}\n".encode())
    except OSError as error:
        say(f"warning: it will be asked again: {str(file)!r} cannot be written: {unwritable(error)}")


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


REST = "Options"
"""The section of the options that stand in no other."""
NAMES = 26
"""Room for the names of options and verbs in a page of help [characters]; longer ones have a line of their own."""


class Example(NamedTuple):
    """A command that a user can copy, and what it does."""

    does: str
    command: str


class HelpPage(click.HelpFormatter):
    """Help as wide as the terminal, whose ids and commands are never broken."""

    def __init__(self, *_: object, **__: object) -> None:
        super().__init__(width=min(width(), PROSE))
        self._coloured = coloured()

    def write_heading(self, heading: str) -> None:
        """Write a heading."""
        self.write(f"{' ' * self.current_indent}{self._marked(f'{heading}:', Style.STRONG)}\n")

    def write_text(self, text: str) -> None:
        """Write paragraphs."""
        indent = " " * self.current_indent
        paragraphs = cleandoc(text).split("\n\n")
        self.write("\n\n".join(wrapped(" ".join(each.split()), self.width, indent, indent) for each in paragraphs))
        self.write("\n")

    def write_dl(self, rows: Iterable[tuple[str, str]], col_max: int = NAMES, col_spacing: int = 2) -> None:
        """Write names and what they mean, in two columns."""
        listed = list(rows)
        names = min(col_max, self.width // 3, max((len(name) for name, _ in listed), default=0))
        at = self.current_indent + names + col_spacing
        for name, meaning in listed:
            head = f"{' ' * self.current_indent}{name.rstrip()}"
            if len(head) > at - col_spacing:
                self.write(f"{head}\n")
                head = ""
            self.write(wrapped(meaning, self.width, head.ljust(at), " " * at).rstrip() + "\n")

    def write_section(self, heading: str, rows: Sequence[tuple[str, str]], names: Iterable[str] = ()) -> None:
        """Write a heading and, below it, rows; the column of their names has room for all `names` as well."""
        widest = min(NAMES, max(map(len, names), default=0))
        with self.section(heading):
            self.write_dl([(name.ljust(widest), meaning) for name, meaning in rows])

    def write_examples(self, examples: Sequence[Example]) -> None:
        """Write the examples: what each does, and its command on a line of its own."""
        with self.section("Examples"):
            for does, command in examples:
                self.write_text(f"{does}:")
                self.write(f"{' ' * (self.current_indent + 2)}{self._marked(command, Style.COMMAND)}\n")

    def _marked(self, text: str, style: Style) -> str:
        return styled(text, style) if self._coloured else text


class Page(click.Context):
    """The context of a command whose help is a `HelpPage`."""

    formatter_class = HelpPage

    def __init__(self, *words: Any, **named: Any) -> None:
        super().__init__(*words, **named)
        self.color = coloured()  # else click takes the marks away where no terminal is


class Verb(click.Command):
    """A command with examples, whose options stand in sections.

    Args:
        words: of `click.Command`.
        examples: the commands that end its help.
        sections: names of options, such as `--mutant --seeds`, by the heading under which they stand.
        named: of `click.Command`.
    """

    context_class = Page

    def __init__(
        self,
        *words: Any,
        examples: Sequence[tuple[str, str]] = (),
        sections: Mapping[str, str] | None = None,
        **named: Any,
    ) -> None:
        super().__init__(*words, **named)
        self.examples = tuple(Example(*each) for each in examples)
        self._sections = sections or {}

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse; click forgets of some errors at which verb they happened."""
        given = tuple(args)
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            error.ctx = error.ctx or ctx
            folder = next((word for word in given if Path(word).is_dir()), None)
            if folder is not None and error.message.startswith("Got unexpected extra argument"):
                sentence = f"{error.message.rstrip('.')}; a study is named by --study {folder}"
                raise click.UsageError(sentence, ctx) from error
            raise

    def sections(self, ctx: click.Context) -> list[tuple[str, list[tuple[str, str]]]]:
        """The options with what they mean, under their headings; those that are named in no section come last."""
        options = [each for each in self.get_params(ctx) if isinstance(each, click.Option) and not each.hidden]
        by_name = {name: each for each in options for name in each.opts}
        found = [(heading, [by_name[name] for name in names.split()]) for heading, names in self._sections.items()]
        known = {name for _, members in found for each in members for name in each.opts}
        found.append((REST, [each for each in options if known.isdisjoint(each.opts)]))
        return [
            (heading, [each.get_help_record(ctx) or (each.opts[0], "") for each in members])
            for heading, members in found
            if members
        ]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the sections of options."""
        assert isinstance(formatter, HelpPage)
        sections = self.sections(ctx)
        names = [name for _, rows in sections for name, _ in rows]
        for heading, rows in sections:
            formatter.write_section(heading, rows, names)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples."""
        assert isinstance(formatter, HelpPage)
        if self.examples:
            formatter.write_examples(self.examples)


_EXAMPLES = re.compile(r"\n\nExamples:(?:\n {4}.*)+")
_EXAMPLE = re.compile(r"^ {4}(\S[^\n]*?):\s+`([^`]+)`$", re.MULTILINE)


def verb(
    name: str, *, sections: Mapping[str, str] | None = None, cls: type[Verb] = Verb
) -> Callable[[Callable[..., Any]], Verb]:
    """Declare the function below as the verb `name`: its parameters are its options, its docstring is its help.

    Three commands under `Examples:` in the docstring, each with what it does before it, end the help; a test parses
    them.

    Args:
        name: of the verb.
        sections: names of options by heading, for a verb of many options.
        cls: the class of the command.
    """

    def declared(function: Callable[..., Any]) -> Verb:
        doc = cleandoc(function.__doc__ or "")
        examples = _EXAMPLE.findall(doc)
        function.__doc__ = _EXAMPLES.sub("", doc)  # a script types no command
        about = function.__doc__.partition("\n\nRaises:\n")[0]
        options = list(parameters_of(function))
        return cls(name, callback=called(function), params=options, help=about, examples=examples, sections=sections)

    return declared
