"""The command `scaloft-fi`: the list of verbs, imported when called; an error is a sentence and an exit code."""

from __future__ import annotations

import errno
import gc
import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from traceback import walk_tb
from typing import Any, NoReturn

import click
from click.shell_completion import CompletionItem

from scaloft_fi.defaults import __version__
from scaloft_fi.errors import ExitCode, InputError, ScaloftError, did_you_mean
from scaloft_fi.output import Marked, lost, say, stand, tell
from scaloft_fi.registry import in_one_line, plugin_behind
from scaloft_fi.verbs import GROUPS, VERBS, module_of
from scaloft_fi.verbs.completion import COMPLETION, answered
from scaloft_fi.verbs.options import REST, Example, HelpPage, Page

try:
    import resource
except ImportError:  # Windows has no such limits
    resource = None  # type: ignore[assignment]

DESCRIPTORS = "too many open files: raise the limit (`ulimit -n 256`)"
MEMORY = "not enough memory: raise the limit (`ulimit -v unlimited`), or give fewer --jobs"
DIRECTORY = "the working directory does not exist: change to another one"
FLYING, READING = 800_000_000, 320_000_000
"""Address space that verbs need which fly, and which read results; they took 675 and 262 MB for one flight [bytes]."""
_LOADER = {"Too many open files": DESCRIPTORS, "failed to map segment": MEMORY, "annot allocate memory": MEMORY}
"""What the dynamic loader says when a library cannot be loaded."""


def check_memory(verb: str) -> None:
    """Refuse early what would end in a crash or an endless loop of a numeric library, which does not answer a signal.

    Raises:
        InputError: the limit of the address space is too small for the verb.
    """
    if resource is None or verb == "matrix":
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    least = FLYING if verb in {"run", "margin", "replay"} else READING
    if limit != resource.RLIM_INFINITY and limit < least:
        raise InputError(
            f"{verb}: not enough memory: the limit is {limit // 1_000_000} MB of at least {least // 1_000_000}; "
            f"raise it (`ulimit -v {least // 1000}`)"
        )


def refusal(error: BaseException) -> str:
    """The sentence of an error that comes from the environment; "" for any other error.

    >>> refusal(MemoryError())
    'not enough memory: raise the limit (`ulimit -v unlimited`), or give fewer --jobs'
    >>> refusal(PermissionError(13, "Permission denied", "a.txt")), refusal(ValueError("odd"))
    ("'a.txt': Permission denied", '')
    """
    return next(filter(None, map(_sentence, _chain(error))), "")


def _sentence(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return MEMORY
    if isinstance(error, ImportError):
        return next((sentence for said, sentence in _LOADER.items() if said in str(error)), "")
    if not isinstance(error, OSError):
        return ""
    if error.errno in (errno.EMFILE, errno.ENFILE):
        return DESCRIPTORS
    if error.errno == errno.ENOMEM:
        return MEMORY
    if error.filename is None and not _has_directory():
        return DIRECTORY
    said = error.strerror or str(error)
    return said if error.filename is None else f"{os.fsdecode(error.filename)!r}: {said}"


def _has_directory() -> bool:
    try:
        Path.cwd()
    except FileNotFoundError:
        return False
    return True


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """The error and its causes, the last cause first: an importer wraps what the loader says."""
    if error is not None:
        yield from _chain(error.__cause__ or error.__context__)
        yield error


def command_of(verb: str) -> click.Command:
    """The command of a verb; its file is imported only now."""
    command = getattr(import_module(f"scaloft_fi.verbs.{module_of(verb)}"), f"{verb}_command")
    assert isinstance(command, click.Command)
    return command


COLLECT_AFTER = (100_000, 50, 100)
"""Thresholds of the garbage collector: by default it takes half the time of an export of 100,000 flights."""


EXAMPLES = (
    Example("See what could go wrong", "scaloft-fi matrix"),
    Example("Fly one fault, two to four minutes", "scaloft-fi run --mutant LATE-human"),
    Example("Look at everything in a browser", "scaloft-fi report"),
)


class Pipeline(click.Group):
    """The verbs in groups, each loaded when it is called."""

    context_class = Page

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Every verb, in the order of the help."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the verb's file."""
        if cmd_name not in VERBS:
            return None
        check_memory(cmd_name)
        return command_of(cmd_name)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the verb; name the most similar verb when there is none."""
        if args and not args[0].startswith("-") and args[0] not in VERBS:
            raise click.UsageError(f"no verb {args[0]!r}{did_you_mean(args[0], VERBS)}", ctx)
        return super().resolve_command(ctx, args)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem[Any]]:
        """The verbs, without importing them, and the options."""
        verbs = [CompletionItem(name, help=about) for name, about in VERBS.items() if name.startswith(incomplete)]
        return [*verbs, *click.Command.shell_complete(self, ctx, incomplete)]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the verbs without importing them, then the options."""
        assert isinstance(formatter, HelpPage)
        for heading, verbs in GROUPS.items():
            formatter.write_section(heading, list(verbs.items()), VERBS)
        formatter.write_section(
            REST, [record for each in self.get_params(ctx) if (record := each.get_help_record(ctx))]
        )

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write examples, and where there are more."""
        assert isinstance(formatter, HelpPage)
        formatter.write_examples(EXAMPLES)
        formatter.write_paragraph()
        formatter.write_text("`scaloft-fi VERB --help` tells the options of a verb, with examples.")

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> NoReturn:
        """Run one verb and leave the process with its exit code."""
        stand()
        prog = prog_name or "scaloft-fi"
        if (asked := os.environ.get(COMPLETION)) is not None:
            tell(answered(self, asked))
            sys.exit(ExitCode.DONE)
        sys.exit(self._exit_code(sys.argv[1:] if args is None else args, prog))

    def _exit_code(self, args: Sequence[str], prog: str) -> int:
        try:
            outcome = self._invoked(args, prog)
        except click.UsageError as error:
            command = error.ctx.command_path if error.ctx else prog
            sentence = error.format_message().rstrip(".")
            say(f"error: {command}: {sentence[:1].lower()}{sentence[1:]}; see {command} --help")
            return ExitCode.BAD_INPUT
        except click.ClickException as error:
            say(f"error: {error.format_message()}")
            return ExitCode.BAD_INPUT
        except ScaloftError as error:
            plugin = plugin_behind(error) if error.exit_code == ExitCode.INTERNAL else ""
            say(f"error: {plugin}: {error}" if plugin else f"error: {error}")
            return error.exit_code
        except (KeyboardInterrupt, click.Abort):
            say("")  # below the ^C that a terminal shows
            say("error: interrupted")
            return ExitCode.INTERRUPTED
        except Exception as error:  # noqa: BLE001 - the last line of defence: no traceback reaches a user unasked
            return _unforeseen(error)
        return outcome if isinstance(outcome, int) else 0

    def _invoked(self, args: Sequence[str], prog: str) -> Any:
        """What the verb returns; help and version are results like any other."""
        try:
            with self.make_context(prog, list(args)) as context:
                return self.invoke(context)
        except click.exceptions.Exit as left:
            return left.exit_code
        except OSError as error:
            *_, (innermost, _) = walk_tb(error.__traceback__)
            if innermost.f_globals.get("__name__") != click.echo.__module__:
                raise
            lost(error)  # click could not print a help or the version
            return 0


def _unforeseen(error: Exception) -> int:
    """Say whose error it is: a plugin's, by name, the environment's (2), or ours; those of programs are 70."""
    if os.environ.get("SCALOFT_DEBUG"):
        traceback.print_exception(error)
    plugin = plugin_behind(error)
    refused = "" if plugin else refusal(error)
    if refused:
        say(f"error: {refused}")
        return ExitCode.BAD_INPUT
    say(f"error: {plugin or 'internal error'}: {in_one_line(error)} (SCALOFT_DEBUG=1 shows where)")
    return ExitCode.INTERNAL


@click.group(
    "scaloft-fi", cls=Pipeline, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.version_option(__version__, prog_name="scaloft-fi", message="%(prog)s %(version)s")
@click.pass_context
def main(context: click.Context) -> None:
    """Fault-injection mutation testing of an autonomous drone.

    A HAZOP deviation matrix becomes mutants, and every mutant is flown in a grid of situations.
    The score says which faults the safety requirements would have shown.
    """
    gc.set_threshold(*COLLECT_AFTER)
    if context.invoked_subcommand is None:
        tell(Marked(f"{context.get_help()}\n"))
