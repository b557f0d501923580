"""`scaloft-fi completion`: the script by which a shell completes verbs, options and the names of a study."""

from __future__ import annotations

import click

from scaloft_fi.cli.verb import verb
from scaloft_fi.console import tell

NAMES = ("bash", "zsh", "fish")


@verb(
    "completion",
    examples=(
        ("Switch it on in bash, here and now", "scaloft-fi completion bash"),
        ("See the script for zsh", "scaloft-fi completion zsh"),
        ("See the script for fish", "scaloft-fi completion fish"),
    ),
)
@click.argument("shell", type=click.Choice(NAMES))
@click.pass_context
def completion_command(context: click.Context, shell: str) -> None:
    """Print a script that lets a shell complete verbs, options, mutants, situations, grids and campaigns.

    bash: `eval "$(scaloft-fi completion bash)"` in ~/.bashrc.  zsh: `eval "$(scaloft-fi completion zsh)"` in ~/.zshrc,
    after compinit.  fish: `scaloft-fi completion fish > ~/.config/fish/completions/scaloft-fi.fish`.

    The names come from the study that a verb would use; a study that cannot be read has none.
    """
    from scaloft_fi.cli.shells import script

    assert context.parent is not None
    tell(script(shell, context.parent.command))
