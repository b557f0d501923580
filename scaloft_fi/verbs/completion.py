"""`scaloft-fi completion`: the script by which a shell completes verbs, options and the names of a study.

A name is offered only if it is made of letters that no shell gives a meaning (`SAFE`), whatever a study calls its
things: what is completed stands in the command line, and the next key may be Enter.
"""

from __future__ import annotations

import os
import re
from typing import Annotated, Any

import click
from click import shell_completion as shells
from click.shell_completion import CompletionItem, ShellComplete

from scaloft_fi.output import tell
from scaloft_fi.verbs.options import Option, verb

PROGRAM = "scaloft-fi"
COMPLETION = "_SCALOFT_FI_COMPLETE"
"""The environment variable by which a shell asks what completes a word."""
SAFE = re.compile(r"[A-Za-z0-9_./-][A-Za-z0-9_./@#%+=:,-]*", re.ASCII)
_BASH = """\
_scaloft_fi_completion() {
    local type value
    COMPREPLY=()
    while IFS=',' read -r type value; do
        case $type in
            dir) compopt -o dirnames ;;
            file) compopt -o default ;;
            plain) COMPREPLY+=("$value") ;;
        esac
    done < <(COMP_LINE="${COMP_LINE:0:COMP_POINT}" COMP_WORDBREAKS="$COMP_WORDBREAKS" %(complete_var)s=bash_complete \\
        "$1" 2>/dev/null)
    [[ ${COMPREPLY[0]-} == */ ]] && compopt -o nospace
    return 0
}
complete -o nosort -F _scaloft_fi_completion %(prog_name)s 2>/dev/null \\
    || complete -F _scaloft_fi_completion %(prog_name)s
"""


class _Safe(ShellComplete):
    """Offers only names that no shell gives a meaning."""

    def get_completions(self, args: list[str], incomplete: str) -> list[CompletionItem[Any]]:
        """What fits the word at the cursor."""
        offered = super().get_completions(args, incomplete)
        return [item for item in offered if item.type != "plain" or SAFE.fullmatch(str(item.value))]


class Bash(_Safe, shells.BashComplete):
    """Completion in bash, which breaks words at signs that ids have, such as @ and =."""

    source_template = _BASH

    def source(self) -> str:
        """The script; no bash is started to ask for its version."""
        return ShellComplete.source(self)

    def get_completion_args(self) -> tuple[list[str], str]:
        """The words before the cursor, and the one at it."""
        line = os.environ["COMP_LINE"]
        words = shells.split_arg_string(line)[1:]
        typed = "" if line[-1:].isspace() or not words else words.pop()
        return words, typed

    def complete(self) -> str:
        """The answer, without what bash takes for an earlier word."""
        words, typed = self.get_completion_args()
        breaks = os.environ.get("COMP_WORDBREAKS", "").replace(" ", "")
        before = max((typed.rfind(sign) for sign in breaks), default=-1) + 1
        option = typed.partition("=")[0] + "=" if typed.startswith("-") and "=" in typed else ""
        offered = self.get_completions(words, typed)
        values = [(item.type, option + str(item.value)) for item in offered]
        return "\n".join(f"{kind},{value[before:] if kind == 'plain' else value}" for kind, value in values)


class Fish(_Safe, shells.FishComplete):
    """Completion in fish."""


_ADD = "compadd -U -V unsorted"


class Zsh(_Safe, shells.ZshComplete):
    """Completion in zsh; no blank follows a name to go on with, such as `baseline/`."""

    source_template = shells.ZshComplete.source_template.replace(
        f"{_ADD} -a", f"[[ $completions[1] == */ ]] && {_ADD} -S '' -a completions || {_ADD} -a"
    )


SHELLS: dict[str, type[ShellComplete]] = {"bash": Bash, "zsh": Zsh, "fish": Fish}


def script(shell: str, command: click.Command) -> str:
    """The script that lets a shell ask `command`."""
    return SHELLS[shell](command, {}, PROGRAM, COMPLETION).source()


def answered(command: click.Command, asked: str) -> str:
    """The answer to a shell; empty where there is none, whatever went wrong.

    Args:
        command: the program.
        asked: value of the environment variable `COMPLETION`, such as `bash_complete`.
    """
    shell, _, instruction = asked.partition("_")
    if shell not in SHELLS or instruction != "complete":
        return ""
    try:
        text = SHELLS[shell](command, {}, PROGRAM, COMPLETION).complete()
    except Exception:  # noqa: BLE001 - a completion never says anything else
        return ""
    return f"{text}\n" if text else ""


@verb("completion")
def completion_command(*, shell: Annotated[str, Option("", "", type=click.Choice(tuple(SHELLS)))]) -> None:
    """Print a script that lets a shell complete verbs, options, mutants, situations, grids and campaigns.

    bash: `eval "$(scaloft-fi completion bash)"` in ~/.bashrc.  zsh: `eval "$(scaloft-fi completion zsh)"` in ~/.zshrc,
    after compinit.  fish: `scaloft-fi completion fish > ~/.config/fish/completions/scaloft-fi.fish`.

    The names come from the study that a verb would use; a study that cannot be read has none.

    Examples:
        Switch it on in bash, here and now: `scaloft-fi completion bash`
        See the script for zsh: `scaloft-fi completion zsh`
        See the script for fish: `scaloft-fi completion fish`
    """
    context = click.get_current_context().parent
    assert context is not None
    tell(script(shell, context.command))
