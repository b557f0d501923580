"""The declaration of a verb: its name, its examples, the sections of its options; and the page of help made of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import cleandoc
from pathlib import Path
from typing import Any, NamedTuple

import click

from scaloft_fi.console import PROSE, Style, coloured, styled, width, wrapped
from scaloft_fi.verbs.options import called, parameters_of

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
        return [(heading, [_record(each, ctx) for each in members]) for heading, members in found if members]

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


def _record(option: click.Option, ctx: click.Context) -> tuple[str, str]:
    names, meaning = option.get_help_record(ctx) or (option.opts[0], "")
    return names, meaning


def verb(
    name: str, *, examples: Sequence[tuple[str, str]], sections: Mapping[str, str] | None = None, cls: type[Verb] = Verb
) -> Callable[[Callable[..., Any]], Verb]:
    """Declare the function below as the verb `name`: its parameters are its options, its docstring is its help.

    Args:
        name: of the verb.
        examples: three commands, each with what it does before it; they end the help, and a test parses them.
        sections: names of options by heading, for a verb of many options.
        cls: the class of the command.
    """

    def declared(function: Callable[..., Any]) -> Verb:
        about = cleandoc(function.__doc__ or "").partition("\n\nRaises:\n")[0]
        options = list(parameters_of(function))
        return cls(name, callback=called(function), params=options, help=about, examples=examples, sections=sections)

    return declared
