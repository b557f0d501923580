"""The command `scaloft-fi`: imports the module of the verb, and turns each error into a sentence and an exit code."""

from __future__ import annotations

import gc
import os
import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from traceback import walk_tb
from typing import Any, NoReturn

import click

from scaloft_fi import __version__
from scaloft_fi.cli.refusal import check_memory, refusal
from scaloft_fi.console import lost, say, stand, tell
from scaloft_fi.errors import ScaloftError, did_you_mean
from scaloft_fi.registry import in_one_line, plugin_behind

# In the order of the pipeline: (where the verb is declared, what it does).
VERBS: dict[str, tuple[str, str]] = {
    "matrix": ("scaloft_fi.cli.matrix:matrix_command", "show the deviation matrix, every cell with its reason"),
    "mutants": ("scaloft_fi.cli.mutants:mutants_command", "list the catalogue of mutants, derive it, check it"),
    "check": ("scaloft_fi.cli.check:check_command", "check the whole study without flying"),
    "run": ("scaloft_fi.cli.run:run_command", "fly baseline and mutants over the grid, then score"),
    "margin": ("scaloft_fi.cli.margin:margin_command", "find the smallest magnitude that is killed, by bisection"),
    "seek": ("scaloft_fi.cli.seek:seek_command", "find a situation that would have shown a fault"),
    "merge": ("scaloft_fi.cli.merge:merge_command", "join campaigns that were flown in parts"),
    "status": ("scaloft_fi.cli.status:status_command", "show which flights a campaign holds"),
    "score": ("scaloft_fi.cli.score:score_command", "print the score of a campaign, without flying"),
    "worksheet": ("scaloft_fi.cli.worksheet:worksheet_command", "print the HAZOP worksheet with the findings"),
    "dispositions": (
        "scaloft_fi.cli.dispositions:dispositions_command",
        "list the survivors beside the accepted ones",
    ),
    "kills": ("scaloft_fi.cli.kills:kills_command", "show where mutants are killed, and what to do next"),
    "coverage": (
        "scaloft_fi.cli.coverage:coverage_command",
        "show what the situations cover",
    ),
    "diff": ("scaloft_fi.cli.diff:diff_command", "list the flights that differ between two campaigns"),
    "export": ("scaloft_fi.cli.export:export_command", "write one row per flight, or a file for another tool"),
    "report": ("scaloft_fi.cli.report:report_command", "write one HTML file with the whole campaign"),
    "replay": ("scaloft_fi.cli.replay:replay_command", "fly one flight again, bit for bit, and draw it"),
    "judge": ("scaloft_fi.cli.judge:judge_command", "judge records of flights with the study's requirements"),
    "doctor": ("scaloft_fi.cli.doctor:doctor_command", "show what decides the bits of a flight, and what is installed"),
}

INTERNAL, INTERRUPTED, USAGE = 70, 130, 2
COLLECT_AFTER = (100_000, 50, 100)
"""Thresholds of the garbage collector: by default it takes half the time of an export of 100,000 flights."""


class Pipeline(click.Group):
    """The verbs in pipeline order, each loaded when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Every verb, in the order of the pipeline."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the verb's file."""
        if cmd_name not in VERBS:
            return None
        check_memory(cmd_name)
        module, attribute = VERBS[cmd_name][0].split(":")
        command = getattr(import_module(module), attribute)
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the verb; name the most similar verb when there is none."""
        if args and not args[0].startswith("-") and args[0] not in VERBS:
            raise click.UsageError(f"no verb {args[0]!r}{did_you_mean(args[0], VERBS)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the verbs without importing them."""
        with formatter.section("The pipeline, in order"):
            formatter.write_dl([(verb, about) for verb, (_, about) in VERBS.items()])

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
        self._main_shell_completion(extra, prog, complete_var)
        sys.exit(self._exit_code(sys.argv[1:] if args is None else args, prog))

    def _exit_code(self, args: Sequence[str], prog: str) -> int:
        try:
            outcome = self._invoked(args, prog)
        except click.UsageError as error:
            command = error.ctx.command_path if error.ctx else prog
            sentence = error.format_message().rstrip(".")
            say(f"error: {command}: {sentence[:1].lower()}{sentence[1:]}; see {command} --help")
            return USAGE
        except click.ClickException as error:
            say(f"error: {error.format_message()}")
            return USAGE
        except ScaloftError as error:
            plugin = plugin_behind(error) if error.exit_code == INTERNAL else ""
            say(f"error: {plugin}: {error}" if plugin else f"error: {error}")
            return error.exit_code
        except (KeyboardInterrupt, click.Abort):
            say("")  # below the ^C that a terminal shows
            say("error: interrupted")
            return INTERRUPTED
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
        return USAGE
    say(f"error: {plugin or 'internal error'}: {in_one_line(error)} (SCALOFT_DEBUG=1 shows where)")
    return INTERNAL


@click.group(
    "scaloft-fi",
    cls=Pipeline,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 120},
)
@click.version_option(__version__, prog_name="scaloft-fi", message="%(prog)s %(version)s")
@click.pass_context
def main(context: click.Context) -> None:
    """Fault-injection mutation testing of an autonomous drone.

    A HAZOP deviation matrix becomes mutants, every mutant is flown in a grid of situations, and the score
    says which faults the safety requirements would have shown.
    """
    gc.set_threshold(*COLLECT_AFTER)
    if context.invoked_subcommand is None:
        tell(f"{context.get_help()}\n")
